"""Import of a laboratory's files as a record, by a mapping."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import chain, pairwise
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from geometry.arrays import Array
from wirewear.base.delimited import sheets_left_out
from wirewear.base.errors import RecordError
from wirewear.loops.clock import read_clock
from wirewear.loops.cycles import split_cycles
from wirewear.loops.outline import outline
from wirewear.loops.sensor import enclosed_area
from wirewear.records.contact_tables import RECORDS
from wirewear.records.importing import sources
from wirewear.records.importing.loggers import kind_of
from wirewear.records.importing.mapping import MAPPINGS, EvolutionSource, LoopSource
from wirewear.records.importing.profilometry import surfaces_of
from wirewear.records.importing.text_reader import TextReader, require_mapping
from wirewear.records.normal_force import pressing
from wirewear.records.reading import EVOLUTION_COLUMNS, read_tables, tables_of_file
from wirewear.records.values import AnyRecord, ExperimentRecord, MeasuredEvolution, MeasuredLoop

#: A loop whose area against the motion is this share of the box around it has a force of the other sign.
AGAINST_MOTION = 0.05

#: In a loop so thin that its area shows no direction, a force that falls as the displacement rises, correlated so far,
#: has the other sign: a contact that sticks is a spring.
FALLING = -0.5

TURNED = (
    "the tangential force drives the motion in the files: the record has it with the other sign, positive when it "
    "resists motion in +x"
)

_NO_CYCLE = -1.0  #: In place of the number of a cycle where a sample belongs to none.


class Filling(Protocol):
    """Completes a mapping that several tests share by what one of them states, as a campaign's test does."""

    def tables(self, data: dict[str, object]) -> dict[str, object]:
        """The tables for the test, from those of the file."""
        ...


def import_record(mapping_path: str | Path, test: Filling | None = None) -> AnyRecord:
    """The record that a mapping file describes; file names in it are relative to its folder. test: what fills in the
    mapping, as a campaign's test does. Raises RecordError, in one sentence, if the mapping or a file cannot be read, or
    files do not hold what it says.
    """
    path = Path(mapping_path)
    mapping, notes = _mapping_of(path, test)
    home, length, model = path.parent, mapping.length_mm, RECORDS[mapping.contact_kind]
    conditions = mapping.conditions
    loops: tuple[MeasuredLoop, ...] = ()
    turned: tuple[str, ...] = ()
    if mapping.loops is not None:
        loops, turned = mapped_loops(mapping.loops, path, conditions.frequency_Hz, length)
    evolution = () if mapping.evolution is None else tuple(_evolution(mapping.evolution, home, length))
    found: list[Any] = []
    for body in mapping.body_names:
        if (source := getattr(mapping.surfaces, body)) is not None:
            found += surfaces_of(source, body, home, mapping)
    scars, bridged = zip(*(one.bridged() for one in found), strict=True) if found else ((), ())
    of_each = ((*one.levelling_notes, one.border_note, one.spikes_note) for one in found)
    surface_notes = (*chain.from_iterable(of_each), *bridged)
    if not loops and not evolution and not scars:
        raise RecordError(
            f"{path} maps nothing: give [loops], [evolution], [{mapping.worn.name}s.{mapping.body_names[0]}] or "
            f"[{mapping.worn.name}s.{mapping.body_names[1]}] with its files."
        )
    taken_over = {name: getattr(mapping, name) for name in model.model_fields if hasattr(mapping, name)}
    files = {"loops": "loops.csv"} if loops else {}
    tables = model.model_validate(taken_over | {"conditions": conditions, "files": files})
    read = dict.fromkeys((file, sources.layout_of(source)) for source, file in _files_of(mapping, home))
    texts = ((file, layout) for file, layout in read if kind_of(file) == TextReader.kind)
    unread = dict.fromkeys(note for one in texts for note in sheets_left_out(*one))
    return ExperimentRecord(tables, loops, evolution, scars, (*notes, *unread, *filter(None, surface_notes), *turned))


def _mapping_of(path: Path, test: Filling | None) -> tuple[Any, tuple[str, ...]]:
    if test is None:
        require_mapping(path)
    filled = dict if test is None else test.tables
    mapping, notes = read_tables(path, MAPPINGS[tables_of_file(path).contact_kind], filled)
    mapping.require_whole(str(path))
    return mapping, notes


def inputs_of(mapping_path: Path, test: Filling | None = None) -> list[Path]:
    """Paths of a mapping and of all files that it names. test: see `import_record`.

    Raises RecordError, in one sentence, if the mapping cannot be read, or a file does not exist.
    """
    mapping, _ = _mapping_of(mapping_path, test)
    return [mapping_path, *(file for _, file in _files_of(mapping, mapping_path.parent))]


def _files_of(mapping: Any, home: Path) -> Iterator[tuple[Any, Path]]:
    """Each source of a mapping with each of its files."""
    surfaces = (getattr(mapping.surfaces, body) for body in mapping.body_names)
    for source in filter(None, (mapping.loops, mapping.evolution, *surfaces)):
        columns = () if source.columns is None else sources.wanted_columns(source.columns).values()
        for file in sources.files_of(source, home):
            yield from ((source, own) for own in (file, *(sources.file_of(column, file) for column in columns)))


def mapped_loops(
    source: LoopSource, mapping_path: Path, frequency_Hz: float, length_mm: float | None = None
) -> tuple[tuple[MeasuredLoop, ...], tuple[str, ...]]:
    """Loops of a source, sorted by repeat and cycle, with forces that resist the motion, and sentences on changed signs
    and times.

    frequency_Hz: of the test, by which files are cut into cycles if nothing else numbers these. length_mm: of a line
    contact, whose forces may be given per millimetre. Raises RecordError if a file cannot be read or lacks something,
    or a loop occurs twice.
    """
    home = mapping_path.parent
    loops, loop_notes = list[MeasuredLoop](), list[str]()
    for file in sources.files_of(source, home):
        own, notes = loops_of(file, source, frequency_Hz, length_mm)
        loops += own
        loop_notes += [note for note in notes if note not in loop_notes]
    loops.sort(key=lambda loop: (loop.repeat, loop.cycle))
    for one, other in pairwise(loops):
        if (one.repeat, one.cycle) == (other.repeat, other.cycle):
            raise RecordError(
                f"{mapping_path}: {one.name} is found twice in the files of [loops]: name_pattern or a column must "
                "distinguish them."
            )
    turned = 2 * sum(drives_motion(loop.complete) for loop in loops) > len(loops)
    if turned:
        loops = [replace(loop, tangential_force_N=-loop.tangential_force_N) for loop in loops]
    pressed, of_load = pressing(loops)
    return pressed, (*loop_notes, *((TURNED,) if turned else ()), *of_load)


def drives_motion(loop: MeasuredLoop) -> bool:
    """True if the force of a complete loop acts with the motion, which friction never does: its sign is wrong."""
    x, force = loop.displacement_um, loop.tangential_force_N
    box = float(np.ptp(x) * np.ptp(force)) if x.size else 0.0
    if not box:
        return False
    area = enclosed_area(x, force)
    if abs(area) > AGAINST_MOTION * box:
        return area < 0.0
    return bool(np.corrcoef(x, force)[0, 1] < FALLING)


def loops_of(
    file: Path, source: LoopSource, frequency: float, length_mm: float | None = None
) -> tuple[list[MeasuredLoop], tuple[str, ...]]:
    """Loops of one file with the file's signs, and sentences on its times; arguments as of `mapped_loops`. Raises
    RecordError if the file cannot be read or lacks something.
    """
    named = sources.numbers_in_name(file, source)
    columns = in_rows(file, sources.read_source(file, source, sources.wanted_columns(source.columns), length_mm))
    sources.require_recorded(file, **columns)
    if "cycles" in columns and "cycle" not in named.keys() | columns.keys():
        columns["cycle"] = source.first_cycle + columns["cycles"]
    count = columns["displacement_um"].size
    repeat = columns.get("repeat", np.full(count, float(named.get("repeat", source.repeat))))
    time, note = columns.get("time_s"), ""
    if time is not None:
        numbers = [columns[key] for key in ("repeat", "cycle", "cycles") if key in columns]
        clock = read_clock(time, columns["displacement_um"], columns["tangential_force_N"], numbers)
        time, note = clock.time_s, clock.note
        if clock.gaps and "cycle" not in named.keys() | columns.keys():
            raise RecordError(f"{file}: {note}, nor how many cycles lie in its gaps: give a column cycle.")
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
    sources.require_recorded(file, repeat=repeat[counted], cycle=cycle[counted])
    order = counted[np.lexsort([counted, cycle[counted], repeat[counted]])]
    changes = np.flatnonzero((np.diff(repeat[order]) != 0) | (np.diff(cycle[order]) != 0)) + 1
    parts = np.split(order, changes)
    if "cycle" not in columns and "cycle" not in named and time is not None:
        usual = float(np.median([part.size for part in parts]))
        # A cycle cut off at a file's end is left out if it has fewer samples than this share of the usual one.
        parts = [part for part in parts if part.size >= 0.9 * usual]
    loops = []
    for part in parts:
        own = np.arange(part.size) / (part.size * frequency) if time is None else time[part] - time[part[0]]
        loops.append(
            MeasuredLoop(
                repeat=int(repeat[part[0]]),
                cycle=int(cycle[part[0]]),
                time_s=own,
                displacement_um=columns["displacement_um"][part],
                tangential_force_N=columns["tangential_force_N"][part],
                normal_force_N=columns["normal_force_N"][part] if "normal_force_N" in columns else None,
            )
        )
    return loops, ((f"{file.name}: {note}",) if note else ())


def in_rows(file: Path, columns: dict[str, Array]) -> dict[str, Array]:
    """Columns of equal length (n,); matrices, of cycles by samples either way round, are joined cycle by cycle, with a
    column "cycles" counted from 0. Raises RecordError, whose message begins with `file`, if the columns do not fit
    together.
    """
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
    """Columns with matrices transposed if needed to have one cycle in each column."""
    x = columns["displacement_um"]
    if x.ndim < 2 or np.nanmean(np.ptp(x, axis=0)) >= np.nanmean(np.ptp(x, axis=1)):
        return columns
    return {name: values.T if values.shape == x.shape else values for name, values in columns.items()}


def _split(source: LoopSource, x: Array, force: Array) -> Array:
    """Number of the cycle of each sample (n,) without times, split at the drive's reversals; _NO_CYCLE for missing
    samples.
    """
    known = np.flatnonzero(np.isfinite(x) & np.isfinite(force))
    cycle = np.full(x.size, _NO_CYCLE)
    scattered = known.size > 2 and outline(x[known], force[known]) is not None
    for number, part in enumerate([slice(None)] if scattered or known.size < 2 else split_cycles(x[known])):
        cycle[known[part]] = source.first_cycle + number
    return cycle


def _cut(file: Path, source: LoopSource, time: Array, frequency_Hz: float) -> Array:
    if not np.isfinite(time).all():
        raise RecordError(
            f"{file}: nothing distinguishes the cycles: give a column cycle, a name_pattern with a group cycle, or a "
            "column time_s or sample_rate_Hz to cut by the frequency."
        )
    # Half a sample of slack, so that round-off puts the first sample of a cycle into that cycle.
    slack = 0.5 * float(np.median(np.diff(time))) if time.size > 1 else 0.0
    cycle: Array = source.first_cycle + np.floor((time - time[0] + slack) * frequency_Hz)
    return cycle


def _evolution(source: EvolutionSource, home: Path, length_mm: float | None) -> Iterator[MeasuredEvolution]:
    columns_wanted = sources.wanted_columns(source.columns)
    for file in sources.files_of(source, home):
        columns = sources.equal_rows(file, sources.read_source(file, source, columns_wanted, length_mm), "cycle")
        count = columns["cycle"].size
        default = float(sources.numbers_in_name(file, source).get("repeat", source.repeat))
        repeat = columns.pop("repeat", np.full(count, default))
        sources.require_recorded(file, repeat=repeat, **columns)
        wanted = [column.name for column in EVOLUTION_COLUMNS[1:]]
        complete = {name: columns.get(name, np.full(count, np.nan)) for name in wanted}
        for number in np.unique(repeat):
            own = np.flatnonzero(repeat == number)
            own = own[np.unique(complete["cycle"][own], return_index=True)[1]]
            yield MeasuredEvolution(int(number), {name: values[own] for name, values in complete.items()})
