"""Reading of an experiment record: a folder with experiment.toml and CSV files (format 1)."""

import copy
import hashlib
import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from difflib import get_close_matches
from itertools import pairwise
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from pydantic import ValidationError

from geometry.arrays import Array, BoolArray
from wirewear.base import kinds
from wirewear.base.errors import RecordError
from wirewear.base.files import TABLE_FILE_NAME, parsed_toml, read_bytes, read_text, read_toml, require_within
from wirewear.base.recognising import Held, require_no_other
from wirewear.base.words import shown
from wirewear.base.writing import set_aside
from wirewear.records.columns import Column, ColumnTable, read_columns
from wirewear.records.common_tables import OfTest
from wirewear.records.contact_tables import RECORDS, AnyTables
from wirewear.records.normal_force import pressing
from wirewear.records.surfaces import SCARS, WornSurfaces
from wirewear.records.tables import RecordTables
from wirewear.records.values import AnyRecord, ExperimentRecord, MeasuredEvolution, MeasuredLoop
from wirewear.test.keys import Table, quantity_of
from wirewear.test.messages import first_problem, known_fields, same_but_for_unit, telling_problem
from wirewear.test.study import found_from

_REPEAT = Column("repeat", 0, 1e6, whole=True, complete=True)
_CYCLE = Column("cycle", 0, 1e12, whole=True, complete=True)

LOOP_COLUMNS = (
    _REPEAT,
    _CYCLE,
    Column("sample", 0, 1e9, whole=True, complete=True),
    # Clocks count nanoseconds since 1970.
    Column("time_s", -1e19, 1e19),
    Column("displacement_um", -1e5, 1e5),
    Column("tangential_force_N", -1e5, 1e5),
    Column("normal_force_N", -1e5, 1e5, optional=True),
)
EVOLUTION_COLUMNS = (
    _REPEAT,
    _CYCLE,
    Column("displacement_amplitude_um", -1e5, 1e5),
    Column("slip_amplitude_um", -1e5, 1e5),
    Column("max_tangential_force_N", -1e5, 1e5),
    Column("dissipated_energy_mJ", -1e6, 1e6),
)
#: Of all tables, by name.
RECORD_COLUMNS = {column.name: column for column in (*LOOP_COLUMNS, *EVOLUTION_COLUMNS, *SCARS.columns)}

_LINE = re.compile(rb"^# sha256 ([0-9a-f]{64}) (\S+)\n", re.MULTILINE)
_LAST = re.compile(rb"^# sha256 ([0-9a-f]{64}) of the text above\n\Z", re.MULTILINE)


def tables_of_file(path: Path) -> type[AnyTables]:
    """Class of the tables in a record's folder, experiment.toml or mapping, by the kind of contact that it describes;
    of crossed wires if it states none or cannot be read.
    """
    table = path / TABLE_FILE_NAME if path.is_dir() else path
    try:
        found = read_toml(table, RecordError) if table.is_file() else {}
    except RecordError:
        found = {}  # to be reported by whoever reads it
    # A study has such tables, too, and says of which kind it is.
    if "kind" in found or not {"contact", "bodies"} & found.keys():
        return RecordTables
    contact, bodies = found.get("contact"), found.get("bodies")
    named = {*bodies} if isinstance(bodies, dict) else set()
    # Keys below [contact] or [bodies] say what is wrong with tables of no kind.
    nearest = RECORDS[kinds.BALL_ON_FLAT if "bodies" in found else kinds.LINE_CONTACT]
    others = (own for own in RECORDS.values() if named & {*own.body_names})
    other = next(others, nearest)
    return RECORDS.get(str(contact.get("kind")), other) if isinstance(contact, dict) else other


def read_record(folder: str | Path, contact_kind: str | None = None) -> AnyRecord:
    """Read and check a record of any kind of contact, or of the given kind; its `notes` state tolerable faults. Raises
    RecordError, in one sentence with file, line and column, if the record cannot be read, or is of another kind.
    """
    folder = Path(folder)
    if folder.name == TABLE_FILE_NAME and not folder.is_dir():
        folder = folder.parent
    require_no_other(folder, RecordError, Held.RECORD)
    if not folder.is_dir():
        what = "is a file" if folder.is_file() else "does not exist"
        if (aside := set_aside(folder)) is not None:
            what += f", but the record before is in {aside}, where a command left it that was killed: rename it"
        raise RecordError(f"{folder} {what}: a record is a folder with {TABLE_FILE_NAME} and CSV files.")
    path = folder / TABLE_FILE_NAME
    model = tables_of_file(folder)
    if contact_kind not in (None, model.contact_kind):
        raise RecordError(f"{path} is the record of a {model.contact_kind}, where one of {contact_kind} is needed.")
    tables, notes = read_tables(path, model)
    tables.require_whole(str(path))
    notes = (*notes, *require_unchanged(path))
    given = {key for key in type(tables.files).model_fields if key != "frames" and getattr(tables.files, key)}
    if not given:
        raise RecordError(f"{path}: [files] names no file, so there is nothing recorded.")

    def columns(key: str, wanted: Sequence[Column]) -> ColumnTable:
        return read_columns(_data_file(folder, tables.files, key), wanted)

    loops, turned = pressing(tuple(loops_in(columns("loops", LOOP_COLUMNS))) if "loops" in given else ())
    evolution = tuple(evolution_in(columns("evolution", EVOLUTION_COLUMNS))) if "evolution" in given else ()
    scars: list[Any] = []
    for body in tables.body_names:
        if (key := f"{tables.worn.name}_{body}") in given:
            scars += map(tables.placed, _surfaces(columns(key, tables.worn.columns), tables.worn, body))
    loops, left_out = without_first_loading(loops)
    return ExperimentRecord(tables, loops, evolution, tuple(scars), (*notes, *turned, *left_out), folder)


def without_first_loading(loops: tuple[MeasuredLoop, ...]) -> tuple[tuple[MeasuredLoop, ...], tuple[str, ...]]:
    """Loops without those that begin at rest and are the first of several in their repeat, and a sentence on them.
    Loading from rest follows a branch that no later cycle has.
    """
    counts, first = Counter(loop.repeat for loop in loops), {loop.repeat: loop for loop in reversed(loops)}
    out = [own for own in loops if own is first[own.repeat] and counts[own.repeat] > 1 and own.begins_at_rest]
    if not out:
        return loops, ()
    named = "; ".join(loop.name for loop in out)
    note = f"loops that begin at rest are left out, as their first loading is no branch of a closed loop: {named}"
    return tuple(loop for loop in loops if loop not in out), (note,)


def _data_file(folder: Path, files: Table, key: str) -> Path:
    """Path of the data file that a key of `[files]` names.

    Raises RecordError if it does not exist, or lies outside the folder.
    """
    path: Path = folder / getattr(files, key)
    try:
        if path.is_file():
            require_within(path, folder, RecordError, f"{folder / TABLE_FILE_NAME}: {key} in [files]")
            return path
    except OSError as error:  # a name too long
        raise RecordError(f"{folder / TABLE_FILE_NAME}: {key} cannot be looked up ({error.strerror}).") from None
    raise RecordError(f"{folder / TABLE_FILE_NAME}: {key} in [files] is {path.name!r}, but there is no file {path}.")


def loops_in(table: ColumnTable) -> Iterator[MeasuredLoop]:
    """Loops of a table with the columns of loops.csv, in order of repeats and cycles."""
    columns = sorted_rows(table, ("repeat", "cycle", "sample")).columns
    repeat, cycle = columns["repeat"], columns["cycle"]
    for part in _groups(repeat, cycle):
        normal = columns["normal_force_N"][part] if "normal_force_N" in columns else None
        if normal is not None and np.isnan(normal).all():
            normal = None
        yield MeasuredLoop(
            repeat=int(repeat[part.start]),
            cycle=int(cycle[part.start]),
            time_s=columns["time_s"][part],
            displacement_um=columns["displacement_um"][part],
            tangential_force_N=columns["tangential_force_N"][part],
            normal_force_N=normal,
        )


def evolution_in(table: ColumnTable) -> Iterator[MeasuredEvolution]:
    """Evolutions of a table with the columns of evolution.csv, in order of repeats."""
    columns = sorted_rows(table, ("repeat", "cycle")).columns
    for part in _groups(columns["repeat"]):
        own = {name: values[part] for name, values in columns.items() if name != "repeat"}
        yield MeasuredEvolution(int(columns["repeat"][part.start]), own)


def _surfaces(table: ColumnTable, worn: WornSurfaces, body: str) -> Iterator[Any]:
    places = [name for name in ("x_um", "y_um") if name in table.columns]
    table = sorted_rows(table, ("repeat", *places))
    for part in _groups(table.columns["repeat"]):
        own = {name: values[part] for name, values in table.columns.items() if name != "repeat"}
        try:
            yield worn.surface.from_points(int(table.columns["repeat"][part.start]), body, **own)
        except RecordError as problem:
            where = f"{table.path}, line {table.line(part.start)}, columns {' and '.join(places)}"
            raise RecordError(f"{where}: {problem}") from None


def sorted_rows(table: ColumnTable, keys: Sequence[str]) -> ColumnTable:
    """The table with its rows sorted by the columns `keys`, the first counting most. Raises RecordError if two rows are
    equal in all of them.
    """
    if _in_order([table.columns[key] for key in keys]):
        return replace(table, columns={n: _frozen(v) for n, v in table.columns.items()})
    order = np.lexsort([table.columns[key] for key in reversed(keys)])
    ordered = {name: _frozen(values[order]) for name, values in table.columns.items()}
    found = replace(table, columns=ordered, order=order)
    same = np.logical_and.reduce([np.diff(ordered[key]) == 0.0 for key in keys])
    if same.any():
        row = int(np.argmax(same))
        first, second = sorted((found.line(row), found.line(row + 1)))
        what = ", ".join(f"{key} {ordered[key][row]:.12g}" for key in keys)
        raise RecordError(
            f"{table.path}, line {second}, columns {', '.join(keys)}: {what} is given a second time, "
            f"first on line {first}."
        )
    return found


def _in_order(keys: Sequence[Array]) -> bool:
    """True if the rows are already sorted, the first key counting most."""
    after = np.zeros(keys[0].size - 1, dtype=bool)
    for key in reversed(keys):
        step = np.diff(key)
        after = (step > 0.0) | ((step == 0.0) & after)
    return bool(after.all())


def _groups(*keys: Array) -> Iterator[slice]:
    """Slices of consecutive rows with equal keys."""
    changes: BoolArray = np.logical_or.reduce([np.diff(key) != 0.0 for key in keys])
    bounds = [0, *(np.flatnonzero(changes) + 1).tolist(), keys[0].size]
    for start, stop in pairwise(bounds):
        yield slice(start, stop)


def _frozen(values: Array) -> Array:
    values.setflags(write=False)
    return values


Model = TypeVar("Model", bound=OfTest)


def require_unchanged(table_path: Path) -> tuple[str, ...]:
    """Compare a record's files with the checksums in its experiment.toml, `table_path`; returns a sentence if that file
    itself was changed. Raises RecordError if a data file was changed, or experiment.toml cannot be read.
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


def read_tables(
    path: Path, model: type[Model], filled: Callable[[dict[str, Any]], dict[str, Any]] = dict
) -> tuple[Model, tuple[str, ...]]:
    """Checked tables of a TOML file, and one sentence for each unknown key that was ignored. filled: what the file's
    plain values become before they are checked; by default they stay.

    Raises RecordError, in one sentence with line and column, if the file cannot be read or is not valid for this model,
    or an unknown key looks like a misspelt one.
    """
    text = read_text(path, RecordError, "TOML file")
    data = filled(parsed_toml(text, str(path), RecordError))
    if isinstance(bodies := data.get("bodies"), dict):
        data["bodies"] = found_from(path.parent, bodies)
    return _checked(model.known(data, str(path)), text, path, model)


def _checked(data: dict[str, Any], text: str, path: Path, model: type[Model]) -> tuple[Model, tuple[str, ...]]:
    try:
        return model.model_validate(data), ()
    except ValidationError as error:
        unknown = [p["loc"] for p in error.errors(include_url=False) if p["type"] == "extra_forbidden"]
    strange = [keys for keys in unknown if not _looks_misspelt(keys, data, model)]
    rest = copy.deepcopy(data)
    for *table, key in strange:
        here: Any = rest
        for name in table:
            here = here[name]
        del here[key]
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


def _looks_misspelt(keys: Sequence[int | str], data: Mapping[str, Any], model: type[Table]) -> bool:
    """True if an unknown key resembles a known one that is missing from its table."""
    *table, last = keys
    key = str(last)
    given: Any = data
    for name in table:
        given = given[name]
    absent = {name: field for name, field in known_fields(table, model).items() if name not in given}
    for name, field in absent.items():
        quantity = quantity_of(field)
        if quantity is not None and same_but_for_unit(key, name, quantity.unit):
            return True
    return bool(get_close_matches(key, absent, n=1, cutoff=0.8))


def _position(text: str, keys: Sequence[int | str]) -> tuple[int, int]:
    """Line and column, counted from 1, of a key in TOML text, or else of its table's header or of the start."""
    table, here, fallback = ".".join(map(str, keys[:-1])), "", (1, 1)
    for number, line in enumerate(text.splitlines(), start=1):
        if header := re.match(r"\s*\[([^\[\]]+)\]", line):
            here = re.sub(r"[\s\"']", "", header[1])
            if here == table or here == ".".join(map(str, keys)):
                fallback = (number, 1)
        elif here == table and (found := re.match(rf"\s*[\"']?{re.escape(str(keys[-1]))}[\"']?\s*=\s*", line)):
            return number, found.end() + 1
    return fallback
