"""From a laboratory's files to a record, by a mapping."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from geometry.arrays import Array
from wirewear.base.delimited import sheets_left_out
from wirewear.base.errors import RecordError
from wirewear.base.writing import prepared_folder
from wirewear.loops import LoopError
from wirewear.loops.clock import read_clock
from wirewear.loops.cycles import outline, split_cycles
from wirewear.loops.sensor import enclosed_area
from wirewear.pictures.style import GREY, VARIANT_COLOURS, WIDTH_in, depth_scale, new_figure, save
from wirewear.records.contact_tables import TABLES, LineRecordTables
from wirewear.records.importing import sources
from wirewear.records.importing.loggers import kind_of
from wirewear.records.importing.mapping import MAPPINGS, EvolutionSource, LoopSource
from wirewear.records.importing.profilometry import surfaces_of
from wirewear.records.importing.reader import TextReader, require_mapping
from wirewear.records.normal_force import pressing
from wirewear.records.reading import EVOLUTION_COLUMNS, read_tables, tables_of_file
from wirewear.records.remarks import listed, plural
from wirewear.records.surfaces import PROFILES, SCARS, MeasuredProfile, MeasuredScar
from wirewear.records.tables import PointRecordTables
from wirewear.records.values import AnyRecord, ExperimentRecord, MeasuredEvolution, MeasuredLoop
from wirewear.results.scar import called

FEW = 5

MOST_DRAWN = 3  #: Scars of one wire, or profiles of one body, that are drawn.


def import_text(record: AnyRecord) -> str:
    """What would be imported, the first samples of the first loop and its figures, and those of worn surfaces."""
    parts = (
        (record.repeats, "repeat"),
        (record.loops, "loop"),
        (record.evolution, "evolution table"),
        (record.scars, record.tables.worn.noun),
    )
    counts = ", ".join(plural(len(items), noun) for items, noun in parts)
    lines = [f"note: {note}" for note in record.notes]
    lines.append(f"{counts}; cycles {listed(record.cycles)}" if record.cycles else counts)
    if record.loops:
        lines += loop_lines(record.loops[0], record.tables.conditions.normal_load_N)
    return "\n".join([*lines, *(f"{one.body}, repeat {one.repeat}: {one.sizes}" for one in record.scars)])


def loop_lines(loop: MeasuredLoop, normal_load_N: float) -> list[str]:
    """The first samples of a loop, and its figures."""
    lines = [
        f"first loop: {loop.name}, {plural(loop.time_s.size, 'sample')}",
        f"{'time_s':>12} {'displacement_um':>16} {'tangential_force_N':>19} {'normal_force_N':>15}",
    ]
    normal = np.full(loop.time_s.size, np.nan) if loop.normal_force_N is None else loop.normal_force_N
    channels = (loop.time_s, loop.displacement_um, loop.tangential_force_N, normal)
    rows = zip(*(channel[:FEW].tolist() for channel in channels), strict=True)
    lines += [f"{time:12.6g} {x:16.6g} {q:19.6g} {p:15.6g}" for time, x, q, p in rows]
    try:
        figures = loop.figures(normal_load_N)
    except LoopError as problem:
        return [*lines, f"this is no loop that can be analysed: {problem}"]
    lines.append(
        f"δa {figures.displacement_amplitude_um.value:.4g} µm, δ0 {figures.slip_amplitude_um.value:.4g} µm, "
        f"energy {figures.dissipated_energy_mJ.value:.4g} mJ, {figures.regime}"
    )
    return [*lines, *figures.notes]


def draw_import(record: AnyRecord, output: Path) -> list[Path]:
    """Draw the first loop, and of each body the first worn surfaces as they would be imported; the pictures' paths.

    They stand beside where the record would be, whose folder is made if need be.
    """
    prepared_folder(output.parent)
    drawn = []
    if record.loops:
        drawn.append(save(lambda: _picture(record.loops[0]), output.with_name(f"{output.name}_first_loop.png")))
    name = record.tables.worn.name
    for body in record.tables.body_names:
        if own := record.scars_of(body)[:MOST_DRAWN]:
            path = output.with_name(f"{output.name}_{name}_{body}.png")
            drawn.append(save(partial(_PICTURES[name], own, body, record.tables), path))
    return drawn


def _scar_picture(scars: Sequence[MeasuredScar], body: str, tables: PointRecordTables) -> Figure:
    """Depth below the fitted surface, on one scale."""
    # As wide as its panels: one alone would stand aside.
    figure = new_figure(3.4, min(WIDTH_in, 1.5 + 2.4 * len(scars)))
    panels = figure.subplots(1, len(scars), sharex=True, sharey=True, squeeze=False)[0]
    colours, norm = depth_scale(scar.depth_um for scar in scars)
    for axes, scar in zip(panels, scars, strict=True):
        image = axes.pcolormesh(scar.x_um, scar.y_um, scar.depth_um.T, norm=norm, cmap=colours)
        axes.set_aspect("equal")
        along = np.radians(tables.body(body).axis_angle_deg)
        axes.axline((0.0, 0.0), (np.cos(along), np.sin(along)), color=GREY, linewidth=0.7, linestyle=(0, (8, 2, 1, 2)))
        axes.set(title=f"repeat {scar.repeat}\n{1e6 * scar.volume_mm3:.3g}·10⁻⁶ mm³", xlabel="x, along the motion [µm]")
    panels[0].set_ylabel(f"{called(body)} (its axis dash-dotted), y [µm]")
    figure.colorbar(image, ax=list(panels), label="worn depth, raised if negative [µm]", shrink=0.8)
    return figure


def _profile_picture(profiles: Sequence[MeasuredProfile], body: str, _: LineRecordTables) -> Figure:
    heights = any(one.face_um is not None for one in profiles)
    figure = new_figure(5.0 if heights else 3.0)
    panels = figure.subplots(2 if heights else 1, len(profiles), sharex="col", sharey="row", squeeze=False)
    for (upper, axes), one in zip(((column[0], column[-1]) for column in panels.T), profiles, strict=True):
        profile, (left, right) = one, one.edges_um
        worn = (profile.x_um >= left) & (profile.x_um <= right)
        axes.axhline(0.0, color=GREY, linewidth=0.6, zorder=1)
        axes.plot(profile.x_um, profile.depth_um, color=VARIANT_COLOURS[0], linewidth=0.8)
        axes.fill_between(profile.x_um[worn], profile.depth_um[worn], color=VARIANT_COLOURS[0], alpha=0.25)
        axes.set_xlabel("x, along the motion [µm]")
        upper.set_title(f"{body}, repeat {profile.repeat}\n{profile.area_um2:.4g} µm²")
        if one.height_um is not None and one.face_um is not None:
            upper.plot(profile.x_um, one.height_um, color=VARIANT_COLOURS[0], linewidth=0.8, label="measured")
            fitted = {"color": VARIANT_COLOURS[1], "linestyle": "--", "linewidth": 1.2}
            upper.plot(profile.x_um, one.face_um, **fitted, label="fitted face")
    panels[-1][0].invert_yaxis()
    if heights:
        panels[0][0].set_ylabel("height [µm]")
        panels[0][0].legend(fontsize="small")
    panels[-1][0].set_ylabel("worn depth [µm]")
    return figure


_PICTURES: Mapping[str, Callable[[Any, str, Any], Figure]] = {
    SCARS.name: _scar_picture,
    PROFILES.name: _profile_picture,
}


def _picture(loop: MeasuredLoop) -> Figure:
    figure = new_figure(3.2)
    left, right = figure.subplots(1, 2)
    left.plot(loop.displacement_um, loop.tangential_force_N, color=VARIANT_COLOURS[0], marker=".", markersize=3)
    left.plot(loop.displacement_um[:1], loop.tangential_force_N[:1], color=VARIANT_COLOURS[1], marker="o", markersize=6)
    left.set(xlabel="displacement δ [µm]", ylabel="tangential force Q [N]", title=f"{loop.name} (dot: first sample)")
    _mark_motion(left, loop)
    right.plot(loop.time_s, loop.displacement_um, color=VARIANT_COLOURS[0])
    right.set_xlabel("time [s]")
    right.set_ylabel("displacement δ [µm]", color=VARIANT_COLOURS[0])
    force = right.twinx()
    force.plot(loop.time_s, loop.tangential_force_N, color=VARIANT_COLOURS[1], linestyle="--", linewidth=1.2)
    force.set_ylabel("tangential force Q [N]", color=VARIANT_COLOURS[1])
    force.spines["right"].set_visible(True)
    force.grid(visible=False)
    for axes in (left, right):
        axes.axhline(0.0, color=GREY, linewidth=0.6, zorder=1)
    return figure


def _mark_motion(axes: Axes, loop: MeasuredLoop) -> None:
    """An arrow in the middle of the branch on which the displacement grows, and what the force must be there."""
    x, q = loop.displacement_um, loop.tangential_force_N
    steps = np.nan_to_num(np.gradient(x))
    if not (growing := np.flatnonzero(steps > 0.5 * steps.max(initial=0.0))).size:
        return
    near = growing[np.argmin(np.abs(x[growing] - np.nanmean(x)))]
    arrow = {"arrowstyle": "-|>", "color": VARIANT_COLOURS[1], "linewidth": 2.0, "mutation_scale": 14}
    axes.annotate("", (x[near] + 0.12 * np.ptp(x[np.isfinite(x)]), q[near]), (x[near], q[near]), arrowprops=arrow)
    said = "δ grows at the arrow:\nthere Q must be positive"
    axes.text(0.5, 0.65, said, transform=axes.transAxes, ha="center", va="center", fontsize=7.5)


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

_NO_CYCLE = -1.0  #: In place of the number of a cycle where a sample belongs to none.


def import_record(mapping_path: str | Path) -> AnyRecord:
    """The record that a mapping file describes; file names in it are relative to its folder.
    Raises RecordError, in one sentence, if the mapping or a file cannot be read, or does not hold what the mapping
    says.
    """
    path = Path(mapping_path)
    mapping, notes = _mapping_of(path)
    home, length, model = path.parent, mapping.length_mm, TABLES[mapping.contact_kind]
    conditions = mapping.asked(path)
    loops: tuple[MeasuredLoop, ...] = ()
    turned: tuple[str, ...] = ()
    if mapping.loops is not None:
        loops, turned = mapped_loops(mapping.loops, path, conditions.frequency_Hz, length)
    evolution = () if mapping.evolution is None else tuple(_evolution(mapping.evolution, home, length))
    found: list[Any] = []
    for body in mapping.body_names:
        if (source := getattr(mapping.surfaces, body)) is not None:
            found += surfaces_of(source, body, home, mapping)
    scars, told = zip(*(one.bridged() for one in found), strict=True) if found else ((), ())
    told = (*(sentence for one in found for sentence in (*one.told, one.spikes_told)), *told)
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
    return ExperimentRecord(tables, loops, evolution, scars, (*notes, *unread, *filter(None, told), *turned))


def _mapping_of(path: Path) -> tuple[Any, tuple[str, ...]]:
    require_mapping(path)
    mapping, notes = read_tables(path, MAPPINGS[tables_of_file(path).contact_kind])
    mapping.require_whole(str(path))
    return mapping, notes


def inputs_of(mapping_path: Path) -> list[Path]:
    """A mapping and the files that it names.
    Raises RecordError, in one sentence, if the mapping cannot be read, or a file is not there.
    """
    mapping, _ = _mapping_of(mapping_path)
    return [mapping_path, *(file for _, file in _files_of(mapping, mapping_path.parent))]


def _files_of(mapping: Any, home: Path) -> Iterator[tuple[Any, Path]]:
    """The files that a mapping names, each behind its source."""
    surfaces = (getattr(mapping.surfaces, body) for body in mapping.body_names)
    for source in filter(None, (mapping.loops, mapping.evolution, *surfaces)):
        columns = () if source.columns is None else sources.wanted_columns(source.columns).values()
        for file in sources.files_of(source, home):
            yield from ((source, own) for own in (file, *(sources.file_of(column, file) for column in columns)))


def mapped_loops(
    source: LoopSource, mapping_path: Path, frequency_Hz: float, length_mm: float | None = None
) -> tuple[tuple[MeasuredLoop, ...], tuple[str, ...]]:
    """The loops of a source in order, their forces resisting the motion, and what was turned for that.

    length_mm: of a line contact, whose forces may be given per millimetre.
    Raises RecordError if a file cannot be read or lacks something, or a loop is there twice.
    """
    home = mapping_path.parent
    loops, told = list[MeasuredLoop](), list[str]()
    for file in sources.files_of(source, home):
        own, notes = loops_of(file, source, frequency_Hz, length_mm)
        loops += own
        told += [note for note in notes if note not in told]
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
    pressed, of_load = pressing(loops)
    return pressed, (*told, *((TURNED,) if turned else ()), *of_load)


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


def loops_of(
    file: Path, source: LoopSource, frequency: float, length_mm: float | None = None
) -> tuple[list[MeasuredLoop], tuple[str, ...]]:
    """The loops of one file as they stand there, and notes on them; `length_mm` as of `mapped_loops`.
    Raises RecordError if the file cannot be read or lacks something.
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
        clock = read_clock(time, columns["displacement_um"], columns["tangential_force_N"])
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
        parts = [part for part in parts if part.size >= WHOLE_CYCLE * usual]
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
    if not np.isfinite(time).all():
        raise RecordError(
            f"{file}: nothing tells the cycles apart: give a column cycle, a name_pattern with a group cycle, or a "
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
