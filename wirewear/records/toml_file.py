"""Reading experiment.toml: one sentence for every mistake, with line and column; unknown keys are kept aside."""

import copy
import hashlib
import re
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from wirewear.base.errors import RecordError
from wirewear.base.quantity import shown
from wirewear.base.reading import parsed_toml, read_bytes, read_text
from wirewear.study.keys import quantity_of
from wirewear.study.messages import first_problem, known_fields, same_but_for_unit, telling_problem

_LINE = re.compile(rb"^# sha256 ([0-9a-f]{64}) (\S+)\n", re.MULTILINE)
_LAST = re.compile(rb"^# sha256 ([0-9a-f]{64}) of the text above\n\Z", re.MULTILINE)

Model = TypeVar("Model", bound=BaseModel)


def with_checksums(text: str, folder: Path, names: Mapping[str, str]) -> str:
    """The text of experiment.toml with the checksums of files of its folder, by their keys, and its own behind it."""
    lines = [f"# sha256 {hashlib.sha256((folder / name).read_bytes()).hexdigest()} {name}\n" for name in names.values()]
    text += "\n# The files as wirewear wrote them. Whoever changes one on purpose deletes its line.\n" + "".join(lines)
    return text + f"# sha256 {hashlib.sha256(text.encode()).hexdigest()} of the text above\n"


def require_unchanged(table_path: Path) -> tuple[str, ...]:
    """See that a record's tables are as they were written; what is to be told of experiment.toml itself.
    Raises RecordError if a table has changed, or experiment.toml cannot be read.
    """
    data = read_bytes(table_path, RecordError, "TOML file")
    folder = table_path.parent.resolve()
    for found, name in _LINE.findall(data):
        path = table_path.parent / Path(name.decode("utf-8", "replace")).name
        if not path.is_file() or not path.resolve().is_relative_to(folder):
            continue
        if hashlib.sha256(read_bytes(path, RecordError)).hexdigest() != found.decode():
            raise RecordError(
                f"{path} is not as it was written: it is damaged, or was changed; if that was on purpose, delete the "
                f"line of its checksum from {table_path.name}."
            )
    last = _LAST.search(data)
    whole = last is not None and hashlib.sha256(data[: last.start()]).hexdigest() == last[1].decode()
    if whole or b"# sha256 " not in data:
        return ()
    return (f"{table_path.name} is not as it was written: it was changed by hand, or is damaged",)


def read_tables(path: Path, model: type[Model]) -> tuple[Model, tuple[str, ...]]:
    """The checked tables of a TOML file, and one sentence for each unknown key that was passed over.

    A key that only looks like a misspelt one is refused: passing over it would lose what it says.
    Raises RecordError, in one sentence with line and column, if the file cannot be read, or is no valid TOML of that
    model.
    """
    text = read_text(path, RecordError, "TOML file")
    data = parsed_toml(text, str(path), RecordError)
    return _checked(data, text, path, model)


def _checked(data: dict[str, Any], text: str, path: Path, model: type[Model]) -> tuple[Model, tuple[str, ...]]:
    try:
        return model.model_validate(data), ()
    except ValidationError as error:
        unknown = [p["loc"] for p in error.errors(include_url=False) if p["type"] == "extra_forbidden"]
    strange = [keys for keys in unknown if not _looks_misspelt(keys, data, model)]
    rest = copy.deepcopy(data)
    for *table, key in strange:
        del _below(rest, table)[str(key)]
    try:
        tables = model.model_validate(rest)
    except ValidationError as error:
        keys = telling_problem(error)["loc"]
        line, column = _position(text, keys)
        where = f"{path}, line {line}, column {column}"
        raise RecordError(first_problem(error, where, model)) from None
    return tables, tuple(_passed_over(keys, text, path) for keys in strange)


def _passed_over(keys: Sequence[int | str], text: str, path: Path) -> str:
    *table, key = keys
    home = f"[{'.'.join(map(str, table))}]" if table else "the file"
    return f"{path.name}, line {_position(text, keys)[0]}: the unknown key {shown(key)} in {home} was passed over"


def _below(data: dict[str, Any], table: Sequence[int | str]) -> dict[str, Any]:
    for key in table:
        data = data[str(key)]
    return data


def _looks_misspelt(keys: Sequence[int | str], data: Mapping[str, Any], model: type[BaseModel]) -> bool:
    """Whether an unknown key resembles a known one that is not given in the same table."""
    *table, last = keys
    key = str(last)
    given: Any = data
    for name in table:
        given = given[str(name)]
    absent = {name: field for name, field in known_fields(table, model).items() if name not in given}
    for name, field in absent.items():
        quantity = quantity_of(field)
        if quantity is not None and same_but_for_unit(key, name, quantity.unit):
            return True
    return bool(get_close_matches(key, absent, n=1, cutoff=0.8))


def _position(text: str, keys: Sequence[int | str]) -> tuple[int, int]:
    """Line and column, from 1, of a key in TOML text; of its table's header, or the start, where it is not spelled."""
    table, here, fallback = ".".join(map(str, keys[:-1])), "", (1, 1)
    for number, line in enumerate(text.splitlines(), start=1):
        if header := re.match(r"\s*\[([^\[\]]+)\]", line):
            here = re.sub(r"[\s\"']", "", header[1])
            if here == table or here == ".".join(map(str, keys)):
                fallback = (number, 1)
        elif here == table and (found := re.match(rf"\s*[\"']?{re.escape(str(keys[-1]))}[\"']?\s*=\s*", line)):
            return number, found.end() + 1
    return fallback
