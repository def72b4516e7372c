"""What is taken for a mapping file and is another one: said as what it is, with the command that takes it."""

from pathlib import Path

from wirewear.errors import RecordError
from wirewear.files.toml import read_toml
from wirewear.records.reading import TABLE_FILE_NAME

#: Tables of a mapping that say where measured numbers are.
_SOURCES = ("loops", "evolution", "scars", "profiles")


def require_mapping(path: Path) -> None:
    """See that a file is no study, no sweep, no record and none of a laboratory's own files.

    What is wrong within a mapping is left to whoever reads it.

    Raises:
        RecordError: it is; one sentence that says what it is.
    """
    if (path / TABLE_FILE_NAME).is_file():
        raise RecordError(f"{path} is a record already: `wirewear check {path}` reads it.")
    if not path.is_file():
        return
    try:
        tables = read_toml(path, RecordError)
    except RecordError:
        if path.suffix == ".toml":
            raise
        raise RecordError(
            f"{path} is no mapping file, which says what a laboratory's files hold: `wirewear new --mapping {path}` "
            "begins one."
        ) from None
    if any(name in tables for name in _SOURCES):
        return
    if "files" in tables:
        raise RecordError(f"{path} belongs to a record already: `wirewear check {path.parent}` reads it.")
    if "vary" in tables:
        raise RecordError(f"{path} is a sweep, and no mapping of measured files: `wirewear sweep {path}` runs it.")
    if "kind" in tables or "friction" in _table(tables.get("contact")):
        raise RecordError(
            f"{path} is a study, and no mapping of measured files: `wirewear run {path}` simulates it, and `wirewear "
            "new --mapping FILES` begins a mapping."
        )


def _table(value: object) -> dict[str, object]:
    return value if isinstance(value, dict) else {}
