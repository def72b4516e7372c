"""From a laboratory's files to a record, by a mapping."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wirewear.base.errors import RecordError
from wirewear.loops.area import enclosed_area
from wirewear.loops.cycles import split_cycles
from wirewear.loops.digitised import outline
from wirewear.records.importing.mapping import (
    PROFILOMETER,
    ColumnMapping,
    EvolutionSource,
    LoopSource,
    Mapping,
    ScarSource,
    Source,
)
from wirewear.records.importing.mistaken import require_mapping
from wirewear.records.importing.profilometry import MapOfWire, scar_of_heights, scar_of_map
from wirewear.records.importing.sources import files_of, numbers_in_name, read_source
from wirewear.records.normal_force import pressing
from wirewear.records.reading import RECORD_COLUMNS
from wirewear.records.tables import Files, RecordTables, RecordWires
from wirewear.records.toml_file import read_tables
from wirewear.records.values import WIRES, Array, ExperimentRecord, MeasuredEvolution, MeasuredLoop, MeasuredScar
from wirewear.study.keys import Table

#: Widest gap along a line that is bridged, in points: reflexes and dirt; what is wider, `check` tells.
WIDEST = 3

#: A cycle cut off at a file's end is left out if it has fewer samples than this share of the usual one.
WHOLE_CYCLE = 0.9

#: A loop whose area against the motion is this share of the box around it has a force of the other sign.
AGAINST_MOTION = 0.05

#: In a loop so thin that its area tells no direction, a force that falls as the displacement rises, correlated so far,
#: has the other sign: a contact that sticks is a spring.
FALLING = -0.5

TURNED = (
    "the tangential force drives the motion in the files: the record has it with the other sign, positive when it "
    "resists motion in +x"
)

#: In place of the number of a cycle where a sample belongs to none.
_NO_CYCLE = -1.0

_EVOLUTION = (
    "cycle",
    "displacement_amplitude_um",
    "slip_amplitude_um",
    "max_tangential_force_N",
    "dissipated_energy_mJ",
)


def bridged(scar: MeasuredScar) -> tuple[MeasuredScar, tuple[str, ...]]:
    """The scar with small gaps interpolated along its lines, and a sentence on how many points that were."""
    depth = np.array(scar.depth_um)
    both = np.stack([_along(scar.y_um, depth), _along(scar.x_um, depth.T).T])
    known = np.isfinite(both)
    means = np.where(known, both, 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
    fill = ~np.isfinite(depth) & known.any(axis=0)
    if not fill.any():
        return scar, ()
    depth[fill] = means[fill]
    depth.setflags(write=False)
    told = (
        f"{np.mean(fill):.1%} of the points of the {scar.wire} wire's map, repeat {scar.repeat}, were not measured: "
        f"gaps of up to {WIDEST} points are interpolated"
    )
    return replace(scar, depth_um=depth), (told,)


def _along(line: Array, depth: Array) -> Array:
    """Depths (n, m) over a line (m,) between the known ones beside a gap; NaN elsewhere."""
    known, place = np.isfinite(depth), np.arange(line.size)
    before = np.maximum.accumulate(np.where(known, place, -1), axis=1)
    after = np.minimum.accumulate(np.where(known, place, line.size)[:, ::-1], axis=1)[:, ::-1]
    small = ~known & (before >= 0) & (after < line.size) & (after - before - 1 <= WIDEST)
    rows, columns = np.nonzero(small)
    left, right = before[small], after[small]
    share = (line[columns] - line[left]) / (line[right] - line[left])
    found = np.full(depth.shape, np.nan)
    found[small] = (1.0 - share) * depth[rows, left] + share * depth[rows, right]
    return found


def import_record(mapping_path: str | Path) -> ExperimentRecord:
    """The record that a mapping file describes; file names in it are relative to its folder.

    Raises:
        RecordError: the mapping or a file cannot be read, or does not hold what the mapping says; one sentence.
    """
    path = Path(mapping_path)
    require_mapping(path)
    mapping, notes = read_tables(path, Mapping)
    home = path.parent
    loops, turned = mapped_loops(mapping.loops, path, mapping.conditions.frequency_Hz)
    scars: list[MeasuredScar] = []
    for wire in WIRES:
        source: ScarSource | None = getattr(mapping.scars, wire)
        if source is not None:
            for scar, told in map(bridged, _scars(source, wire, home, mapping.wires)):
                scars.append(scar)
                notes = (*notes, *told)
    tables = RecordTables(
        format=1,
        name=mapping.name,
        wires=mapping.wires,
        conditions=mapping.conditions,
        stated=mapping.stated,
        noise=mapping.noise,
        metadata=mapping.metadata,
        files=Files(loops="loops.csv"),
    )
    evolution = () if mapping.evolution is None else mapped_evolution(mapping.evolution, home)
    return ExperimentRecord(tables, loops, evolution, tuple(scars), (*notes, *turned))


def mapped_loops(
    source: LoopSource, mapping_path: Path, frequency_Hz: float, length_mm: float | None = None
) -> tuple[tuple[MeasuredLoop, ...], tuple[str, ...]]:
    """The loops of a source in order, their forces resisting the motion, and what was turned for that.

    length_mm: of a line contact, whose forces may be given per millimetre.

    Raises:
        RecordError: a file cannot be read or lacks something, or a loop is there twice.
    """
    home = mapping_path.parent
    loops = [loop for file in files_of(source, home) for loop in loops_of(file, source, frequency_Hz, length_mm)]
    loops.sort(key=lambda loop: (loop.repeat, loop.cycle))
    for one, other in pairwise(loops):
        if (one.repeat, one.cycle) == (other.repeat, other.cycle):
            raise RecordError(
                f"{mapping_path}: {one.name} is found twice in the files of [loops]: name_pattern or a column must "
                "tell them apart."
            )
    turned = 2 * sum(drives_motion(loop.complete) for loop in loops) > len(loops)
    if turned:
        loops = [replace(loop, tangential_force_N=-loop.tangential_force_N) for loop in loops]
    pressed, notes = pressing(loops)
    return pressed, (*((TURNED,) if turned else ()), *notes)


def drives_motion(loop: MeasuredLoop) -> bool:
    """Whether the force of a loop without gaps acts with the motion, which friction never does."""
    x, force = loop.displacement_um, loop.tangential_force_N
    box = float(np.ptp(x) * np.ptp(force)) if x.size else 0.0
    if not box:
        return False
    area = enclosed_area(x, force)
    if abs(area) > AGAINST_MOTION * box:
        return area < 0.0
    return bool(np.corrcoef(x, force)[0, 1] < FALLING)


def wanted_columns(columns: Table) -> dict[str, ColumnMapping]:
    """The columns that a table of columns names."""
    return {name: getattr(columns, name) for name in type(columns).model_fields if getattr(columns, name) is not None}


def loops_of(
    file: Path, source: LoopSource, frequency: float, length_mm: float | None = None
) -> Iterator[MeasuredLoop]:
    """The loops of one file as they stand there; `length_mm` as of `mapped_loops`.

    Raises:
        RecordError: the file cannot be read or lacks something.
    """
    named = numbers_in_name(file, source)
    columns = _in_rows(file, read_source(file, source, wanted_columns(source.columns), length_mm))
    require_recorded(file, **columns)
    if "cycles" in columns and "cycle" not in named.keys() | columns.keys():
        columns["cycle"] = source.first_cycle + columns["cycles"]
    count = columns["displacement_um"].size
    repeat = columns.get("repeat", np.full(count, float(named.get("repeat", source.repeat))))
    time = columns.get("time_s")
    if time is None and source.sample_rate_Hz is not None:
        time = np.arange(count) / source.sample_rate_Hz
    if "cycle" in columns:
        cycle = columns["cycle"]
    elif "cycle" in named:
        cycle = np.full(count, float(named["cycle"]))
    elif time is None:
        cycle = _split(source, columns["displacement_um"], columns["tangential_force_N"])
    else:
        cycle = np.full(count, _NO_CYCLE)
        held = np.flatnonzero(np.any([np.isfinite(own) for own in (*columns.values(), time)], axis=0))
        cycle[held] = _cut(file, source, time[held], frequency)
    counted = np.flatnonzero(cycle != _NO_CYCLE)
    require_recorded(file, repeat=repeat[counted], cycle=cycle[counted])
    order = counted[np.lexsort([counted, cycle[counted], repeat[counted]])]
    changes = np.flatnonzero((np.diff(repeat[order]) != 0) | (np.diff(cycle[order]) != 0)) + 1
    parts = np.split(order, changes)
    if "cycle" not in columns and "cycle" not in named and time is not None:
        usual = float(np.median([part.size for part in parts]))
        parts = [part for part in parts if part.size >= WHOLE_CYCLE * usual]
    for part in parts:
        own = np.arange(part.size) / (part.size * frequency) if time is None else time[part] - time[part[0]]
        yield MeasuredLoop(
            repeat=int(repeat[part[0]]),
            cycle=int(cycle[part[0]]),
            time_s=own,
            displacement_um=columns["displacement_um"][part],
            tangential_force_N=columns["tangential_force_N"][part],
            normal_force_N=columns["normal_force_N"][part] if "normal_force_N" in columns else None,
        )


def _in_rows(file: Path, columns: dict[str, Array]) -> dict[str, Array]:
    """Columns of equal length (n,); matrices (samples, cycles) are laid end to end, with their `cycles` from 0."""
    columns = _samples_first(columns)
    shape = columns["displacement_um"].shape
    if len(shape) == 1:
        rows = {name: values.ravel() for name, values in columns.items()}
    else:
        rows = {"cycles": np.repeat(np.arange(float(shape[1])), shape[0])}
        for name, values in columns.items():
            if values.shape == shape:
                rows[name] = values.T.ravel()
            elif values.size == shape[0] and values.ndim == 1 and name == "time_s":
                rows[name] = np.tile(values, shape[1])
            elif values.size == shape[1] and values.ndim == 1:
                rows[name] = np.repeat(values, shape[0])
            else:
                rows[name] = values.ravel()
    count = rows["displacement_um"].size
    for name, values in rows.items():
        if values.size == 1:
            rows[name] = np.full(count, values[0])
        elif values.size != count:
            raise RecordError(f"{file}: {name} has {values.size} values where displacement_um has {count}.")
    return rows


def _samples_first(columns: dict[str, Array]) -> dict[str, Array]:
    """Matrices with one cycle a column, where the file has one a row: along a cycle goes the stroke."""
    x = columns["displacement_um"]
    if x.ndim < 2 or np.nanmean(np.ptp(x, axis=0)) >= np.nanmean(np.ptp(x, axis=1)):
        return columns
    return {name: values.T if values.shape == x.shape else values for name, values in columns.items()}


def _split(source: LoopSource, x: Array, force: Array) -> Array:
    """Cycle numbers of a signal without time, split where the drive turns round."""
    known = np.flatnonzero(np.isfinite(x) & np.isfinite(force))
    cycle = np.full(x.size, _NO_CYCLE)
    scattered = known.size > 2 and outline(x[known], force[known]) is not None
    for number, part in enumerate([slice(None)] if scattered or known.size < 2 else split_cycles(x[known])):
        cycle[known[part]] = source.first_cycle + number
    return cycle


def _cut(file: Path, source: LoopSource, time: Array, frequency_Hz: float) -> Array:
    """Cycle numbers of a continuous signal."""
    if not np.isfinite(time).all():
        raise RecordError(
            f"{file}: nothing tells the cycles apart: give a column cycle, a name_pattern with a group cycle, or a "
            "column time_s or sample_rate_Hz to cut by the frequency."
        )
    # Half a sample of slack, so that round-off puts the first sample of a cycle into that cycle.
    slack = 0.5 * float(np.median(np.diff(time))) if time.size > 1 else 0.0
    cycle: Array = source.first_cycle + np.floor((time - time[0] + slack) * frequency_Hz)
    return cycle


def mapped_evolution(
    source: EvolutionSource, home: Path, length_mm: float | None = None
) -> tuple[MeasuredEvolution, ...]:
    """The evolutions of a source's files; `length_mm` as of `mapped_loops`.

    Raises:
        RecordError: a file cannot be read or lacks something.
    """
    return tuple(_evolution(source, home, length_mm))


def _evolution(source: EvolutionSource, home: Path, length_mm: float | None) -> Iterator[MeasuredEvolution]:
    columns_wanted = wanted_columns(source.columns)
    for file in files_of(source, home):
        columns = equal_rows(file, read_source(file, source, columns_wanted, length_mm), "cycle")
        count = columns["cycle"].size
        default = float(numbers_in_name(file, source).get("repeat", source.repeat))
        repeat = columns.pop("repeat", np.full(count, default))
        require_recorded(file, repeat=repeat, **columns)
        complete = {name: columns.get(name, np.full(count, np.nan)) for name in _EVOLUTION}
        for number in np.unique(repeat):
            own = np.flatnonzero(repeat == number)
            own = own[np.unique(complete["cycle"][own], return_index=True)[1]]
            yield MeasuredEvolution(int(number), {name: values[own] for name, values in complete.items()})


def equal_rows(file: Path, columns: dict[str, Array], first: str) -> dict[str, Array]:
    """Columns (n,).

    Raises:
        RecordError: they differ in length.
    """
    count = columns[first].size
    for name, values in columns.items():
        if values.size != count:
            raise RecordError(f"{file}: {name} has {values.size} values where {first} has {count}.")
    return {name: values.ravel() for name, values in columns.items()}


def columns_of_levels(
    file: Path, source: Source, columns: Table | None, table: str, repeat: int, step_um: float | None = None
) -> tuple[str, dict[str, Array]]:
    """Which of depth_um and height_um a file of worn surfaces gives, and its columns (n,), "repeat" among them.

    columns: what the mapping's `table` says of them.  repeat: of a file without a column of repeats.  step_um: from
    row to row, where there is no column of positions.

    Raises:
        RecordError: the mapping gives no columns, none or both of the levels, or the file's do not fit together.
    """
    if columns is None:
        raise RecordError(f'{file}: [{table}] must give columns, or kind = "{PROFILOMETER}".')
    given = [key for key in ("depth_um", "height_um") if getattr(columns, key) is not None]
    if len(given) != 1:
        raise RecordError(f"{file}: [{table}.columns] must give either depth_um or height_um.")
    read = equal_rows(file, read_source(file, source, wanted_columns(columns)), given[0])
    if "x_um" not in read:
        if step_um is None:
            raise RecordError(f"{file}: [{table}] must give x_um among its columns, or step_um.")
        read["x_um"] = step_um * np.arange(float(read[given[0]].size))
    repeats = read.get("repeat", np.full(read["x_um"].size, float(repeat)))
    read |= {"repeat": repeats}
    require_recorded(file, **read)
    return given[0], read


def _scars(source: ScarSource, wire: str, home: Path, wires: RecordWires) -> Iterator[MeasuredScar]:
    for place, file in enumerate(files_of(source, home)):
        # Without a pattern, files stand for repeats in their order.
        repeat = numbers_in_name(file, source).get("repeat", source.repeat + place)
        if source.kind == PROFILOMETER:
            yield scar_of_map(MapOfWire(file, source, wires, wire, repeat))
            continue
        given, columns = columns_of_levels(file, source, source.columns, f"scars.{wire}", repeat)
        for number in np.unique(columns["repeat"]):
            own: NDArray[np.bool_] = columns["repeat"] == number
            x, y, level = (columns[name][own] for name in ("x_um", "y_um", given))
            if given == "height_um":
                yield scar_of_heights(MapOfWire(file, source, wires, wire, int(number)), (x, y, level))
                continue
            try:
                scar = MeasuredScar.from_points(int(number), wire, x, y, level)
                yield scar.turned(wires.axis_angle_deg(wire) if source.frame == "wire" else 0.0)
            except RecordError as problem:
                raise RecordError(f"{file}: {problem}") from None


def require_recorded(file: Path, **columns: Array) -> None:
    """See that columns hold what a record's columns of these names can.

    Raises:
        RecordError: a value is none.
    """
    for name, values in columns.items():
        column = RECORD_COLUMNS.get(name)
        place = None if column is None else column.first_wrong(values)
        if column is not None and place is not None:
            raise RecordError(f"{file}: {name} is {values[place]:g}, but must be {column.kind}.")
