"""Reading an experiment record: a folder with experiment.toml and CSV files (format 1)."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wirewear.base.errors import RecordError
from wirewear.base.reading import read_toml, require_within
from wirewear.base.recognised import TABLE_FILE_NAME, Held, require_no_other
from wirewear.records.columns import Array, Column, ColumnTable, read_columns
from wirewear.records.normal_force import pressing
from wirewear.records.tables import RecordTables
from wirewear.records.toml_file import read_tables, require_unchanged
from wirewear.records.values import WIRES, ExperimentRecord, MeasuredEvolution, MeasuredLoop, MeasuredScar
from wirewear.study.keys import Table

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
SCAR_COLUMNS = (
    _REPEAT,
    Column("x_um", -1e5, 1e5, complete=True),
    Column("y_um", -1e5, 1e5, complete=True),
    Column("depth_um", -1e4, 1e4),
)
#: Of all tables, by name.
RECORD_COLUMNS = {column.name: column for column in (*LOOP_COLUMNS, *EVOLUTION_COLUMNS, *SCAR_COLUMNS)}


def read_record(folder: str | Path) -> ExperimentRecord:
    """Read and check a record. What can be coped with is kept and told in `notes`.

    Raises:
        RecordError: the record cannot be read; one sentence with file, line and column.
    """
    folder = Path(folder)
    if folder.name == TABLE_FILE_NAME and not folder.is_dir():
        folder = folder.parent
    require_no_other(folder, RecordError, Held.RECORD)
    if not folder.is_dir():
        what = "is a file" if folder.is_file() else "does not exist"
        raise RecordError(f"{folder} {what}: a record is a folder with {TABLE_FILE_NAME} and CSV files.")
    _refuse_line_contacts(folder)
    tables, notes = read_tables(folder / TABLE_FILE_NAME, RecordTables)
    notes = (*notes, *require_unchanged(folder / TABLE_FILE_NAME))
    files = tables.files
    loops, turned = pressing(tuple(loops_in(read_columns(data_file(folder, files, "loops"), LOOP_COLUMNS))))
    evolution: tuple[MeasuredEvolution, ...] = ()
    if files.evolution is not None:
        evolution = tuple(evolution_in(read_columns(data_file(folder, files, "evolution"), EVOLUTION_COLUMNS)))
    scars: list[MeasuredScar] = []
    for wire in WIRES:
        key = f"scar_{wire}"
        if getattr(files, key) is not None:
            own = _scars(read_columns(data_file(folder, files, key), SCAR_COLUMNS), wire)
            askew = tables.wires.axis_angle_deg(wire) if getattr(files.frames, key) == "wire" else 0.0
            scars += [scar.turned(askew) for scar in own]
    return ExperimentRecord(tables, loops, evolution, tuple(scars), (*notes, *turned), folder)


def _refuse_line_contacts(folder: Path) -> None:
    """See that a record is not that of a line contact, which only some commands take."""
    path = folder / TABLE_FILE_NAME
    if path.is_file() and "contact" in read_toml(path, RecordError):
        raise RecordError(
            f"{path} is the record of a line contact: `wirewear check`, `compare`, `diagnose` and `loops` take it, "
            "others only crossed wires."
        )


def data_file(folder: Path, files: Table, key: str) -> Path:
    """The data file that a key of `[files]` names.

    Raises:
        RecordError: there is none, or it lies outside the folder.
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
    """The loops of a table, in order of repeats and cycles."""
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
    """The evolutions of a table, repeat by repeat."""
    columns = sorted_rows(table, ("repeat", "cycle")).columns
    for part in _groups(columns["repeat"]):
        own = {name: values[part] for name, values in columns.items() if name != "repeat"}
        yield MeasuredEvolution(int(columns["repeat"][part.start]), own)


def _scars(table: ColumnTable, wire: str) -> Iterator[MeasuredScar]:
    table = sorted_rows(table, ("repeat", "x_um", "y_um"))
    columns = table.columns
    for part in _groups(columns["repeat"]):
        repeat = int(columns["repeat"][part.start])
        x, y = columns["x_um"][part], columns["y_um"][part]
        try:
            yield MeasuredScar.from_points(repeat, wire, x, y, columns["depth_um"][part])
        except RecordError as problem:
            where = f"{table.path}, line {table.line(part.start)}, columns x_um and y_um"
            raise RecordError(f"{where}: {problem}") from None


def sorted_rows(table: ColumnTable, keys: Sequence[str]) -> ColumnTable:
    """The rows in order of the keys.

    Raises:
        RecordError: two rows have the same keys.
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
    """Whether every row comes after the one before it, the first key counting most."""
    after = np.zeros(keys[0].size - 1, dtype=bool)
    for key in reversed(keys):
        step = np.diff(key)
        after = (step > 0.0) | ((step == 0.0) & after)
    return bool(after.all())


def _groups(*keys: Array) -> Iterator[slice]:
    """Slices of equal keys in sorted rows."""
    changes: NDArray[np.bool_] = np.logical_or.reduce([np.diff(key) != 0.0 for key in keys])
    bounds = [0, *(np.flatnonzero(changes) + 1).tolist(), keys[0].size]
    for start, stop in pairwise(bounds):
        yield slice(start, stop)


def _frozen(values: Array) -> Array:
    values.setflags(write=False)
    return values
