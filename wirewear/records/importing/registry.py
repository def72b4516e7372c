"""All readers there are: those of the library and those that installed packages add."""

from collections.abc import Mapping
from functools import cache
from pathlib import Path

from solvers.plugins import installed
from wirewear.base.errors import RecordError
from wirewear.records.importing.matlab import MatlabReader, TdmsReader
from wirewear.records.importing.reader import Reader, TextReader

ENTRY_POINT_GROUP = "wirewear.readers"  #: Entry point group in which a package names its subclasses of `Reader`.

LIBRARY: tuple[type[Reader], ...] = (TextReader, MatlabReader, TdmsReader)


@cache
def readers() -> Mapping[str, Reader]:
    """One of each, by its kind.
    Raises RecordError if a package's entry point holds no reader, or one whose kind is taken.
    """
    found: dict[str, Reader] = {kind.kind: kind() for kind in LIBRARY}
    home = "wirewear.records.importing.reader"
    for place, reader in installed(ENTRY_POINT_GROUP, Reader, "reader", home, ("kind",), _problem):
        if reader.kind in found:
            raise RecordError(
                f"the entry point {place} adds a reader of files of the kind {reader.kind!r}, but there is one "
                "already: uninstall that package, or give its reader another kind."
            )
        found[reader.kind] = reader()
    return found


def kind_of(path: Path) -> str:
    """Of which kind a file is, by its own first bytes: text, unless a reader knows them.
    Raises RecordError if the file cannot be read.
    """
    try:
        with path.open("rb") as file:
            head = file.read(512)
    except OSError as problem:
        raise RecordError(f"{path} cannot be read ({problem.strerror}).") from None
    return next((kind for kind, reader in readers().items() if reader.reads(head)), TextReader.kind)


def _problem(sentence: str) -> RecordError:
    return RecordError(f"{sentence}.")
