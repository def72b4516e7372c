"""A simulated line contact beside a measured one: loops, evolution and profiles, with a table of differences."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from rich import box
from rich.markup import escape
from rich.table import Table

from wirewear.base.errors import RecordError
from wirewear.base.quantity import counted
from wirewear.base.writing import json_text, write_text, writing
from wirewear.loops import LoopError
from wirewear.pictures.colours import GREY, VARIANT_COLOURS
from wirewear.pictures.style import cycle_name, new_figure, panel_letters, save
from wirewear.records.checking import remarks_told
from wirewear.records.remarks import unlike_conditions
from wirewear.records.surfaces import MeasuredProfile
from wirewear.records.values import LineRecord
from wirewear.results import BODIES, RunResult, Scar, read_loops

_MOST_ASIDE_um, _STEP_um = 50.0, 1.0


@dataclass(frozen=True)
class LineDifference:
    """A figure measured (mean over the repeats) and simulated, of the whole contact; scatter: between the repeats."""

    quantity: str
    cycle: int
    measured: float
    simulated: float
    scatter: float | None

    @property
    def relative(self) -> float:
        """Measured over simulated, less one."""
        return self.measured / self.simulated - 1.0 if self.simulated else float("nan")


@dataclass(frozen=True, eq=False)
class LineComparison:
    """A result and a record side by side.

    `unlike` says in which conditions both differ. By body: how far measured profiles were moved aside, and the root
    mean square of what is left between both.
    """

    result: RunResult
    record: LineRecord
    differences: tuple[LineDifference, ...]
    aside_um: dict[str, float]
    left_um: dict[str, float]
    unlike: str | None = None


def compare_line(result: RunResult, record: LineRecord) -> LineComparison:
    """Compare loops of common cycles and profiles at the end; profiles are moved aside onto the simulated ones.

    Raises:
        RecordError: they have nothing in common, or the result has no profile at the record's last cycle; or the
            record is such that nothing can be concluded from it.
    """
    remarks_told(record)
    result = result.of_length(record.tables.contact.length_mm)
    aside: dict[str, float] = {}
    left: dict[str, float] = {}
    rows = [*_loop_differences(result, record), *_profile_differences(result, record, aside, left)]
    if not rows:
        raise RecordError(
            f"the result {result.full_name!r} and the record {record.name!r} have no loop of a common cycle, and no "
            "profile."
        )
    return LineComparison(result, record, tuple(rows), aside, left, _unlike(result, record))


def _unlike(result: RunResult, record: LineRecord) -> str | None:
    tables, own = record.tables, result.study
    asked, pad = tables.conditions, tables.pad
    pairs = {
        "normal_load_N_per_mm": asked.normal_load_N / tables.contact.length_mm,
        "displacement_amplitude_um": asked.displacement_amplitude_um,
        "radius_mm": pad.radius_mm,
        "face_half_width_mm": pad.face_half_width_mm,
        "edge_radius_mm": pad.edge_radius_mm,
    }
    told = {**own.get("pad", {}), **own.get("conditions", {})}
    cycles = float(told.get("cycles", asked.cycles)), float(asked.cycles)
    return unlike_conditions({key: (told.get(key), value) for key, value in pairs.items()}, cycles)


def write_line_comparison(comparison: LineComparison, folder: Path) -> list[Path]:
    """Write comparison.json and comparison.png; ResultError when that fails."""
    content = {
        "result": comparison.result.full_name,
        "record": comparison.record.name,
        "unlike_conditions": comparison.unlike,
        "moved_aside_um": comparison.aside_um,
        "left_between_profiles_um": comparison.left_um,
        "differences": [{**asdict(row), "relative": row.relative} for row in comparison.differences],
    }
    with writing(RecordError, f"cannot write the comparison to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        written = write_text(folder / "comparison.json", json_text(content) + "\n")
    return [written, save(lambda: _picture(comparison), folder / "comparison.png")]


def _loop_differences(result: RunResult, record: LineRecord) -> Iterator[LineDifference]:
    evolution = result.evolution
    columns = {"slip amplitude [µm]": "slip_amplitude_um", "dissipated energy [mJ]": "dissipated_energy_mJ"}
    for cycle in sorted(set(record.cycles) & {loop.cycle for loop in result.loops}):
        at = int(np.argmin(np.abs(evolution["cycle"] - cycle)))
        figures = []
        for loop in record.loops:
            if loop.cycle == cycle:
                try:
                    figures.append(loop.figures(record.tables.conditions.normal_load_N))
                except LoopError:
                    continue
        for words, name in columns.items():
            measured = [float(getattr(one, name).value) for one in figures]
            if measured and np.isfinite(evolution[name][at]):
                yield _difference(words, cycle, measured, float(evolution[name][at]))
        forces = [float(np.nanmax(np.abs(loop.tangential_force_N))) for loop in record.loops if loop.cycle == cycle]
        largest = float(evolution["max_tangential_force_N"][at])
        yield _difference("largest tangential force [N]", cycle, forces, largest)


def _profile_differences(
    result: RunResult, record: LineRecord, aside: dict[str, float], left: dict[str, float]
) -> Iterator[LineDifference]:
    end = record.tables.conditions.cycles
    for body in BODIES:
        own = record.scars_of(body)
        if not own:
            continue
        if end not in result.scar_cycles():
            raise RecordError(
                f"the result {result.full_name!r} has no profile at {end} cycles, the end of {record.name!r}."
            )
        simulated = _as_measured(result.scar(end, body))
        moved = [_aside(profile, simulated) for profile in own]
        aside[body] = float(np.mean(moved))
        left[body] = float(np.mean([_left(one, simulated, a) for one, a in zip(own, moved, strict=True)]))
        for words, figure in (
            ("depth [µm]", lambda p: float(p.smooth_um.max())),
            ("worn area [µm²]", lambda p: p.area_um2),
            ("width [µm]", lambda p: p.width_um),
        ):
            yield _difference(f"{body}: {words}", end, [figure(profile) for profile in own], figure(simulated))


def _difference(quantity: str, cycle: int, measured: list[float], simulated: float) -> LineDifference:
    scatter = float(np.std(measured, ddof=1)) if len(measured) > 1 else None
    return LineDifference(quantity, cycle, float(np.mean(measured)), simulated, scatter)


def _as_measured(scar: Scar) -> MeasuredProfile:
    return MeasuredProfile(0, scar.body, scar.axial_um, scar.depth_um[:, 0])


def _aside(measured: MeasuredProfile, simulated: MeasuredProfile) -> float:
    """How far a measured profile lies to the right of the simulated one."""
    places = np.arange(-_MOST_ASIDE_um, _MOST_ASIDE_um + 1e-9, _STEP_um)
    apart = [
        float(np.sum((np.interp(measured.x_um - a, simulated.x_um, simulated.depth_um) - measured.depth_um) ** 2))
        for a in places
    ]
    return float(places[int(np.argmin(apart))])


def _left(measured: MeasuredProfile, simulated: MeasuredProfile, aside_um: float) -> float:
    """Root mean square of what is left between both within either's scar."""
    x = measured.x_um - aside_um
    ends = [simulated.edges_um, tuple(edge - aside_um for edge in measured.edges_um)]
    worn = (x >= min(low for low, _ in ends)) & (x <= max(high for _, high in ends))
    rest = measured.depth_um[worn] - np.interp(x[worn], simulated.x_um, simulated.depth_um)
    return float(np.sqrt(np.mean(rest**2)))


def _picture(comparison: LineComparison) -> Figure:
    result, record = comparison.result, comparison.record
    common = sorted(set(record.cycles) & {loop.cycle for loop in result.loops})
    figure = new_figure(5.4 if common else 3.2)
    panels = figure.subplots(2 if common else 1, 2, squeeze=False)
    for axes, body in zip(panels[0], BODIES, strict=True):
        _profiles(axes, comparison, body)
    shown = list(panels[0])
    if common:
        loops = dict.fromkeys((common[0], common[-1]))
        for axes, cycle in zip(panels[1], loops, strict=False):
            _loops(axes, comparison, cycle)
            shown.append(axes)
        for axes in panels[1][len(loops) :]:
            axes.set_visible(False)
    handles = {label: handle for axes in shown for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)}
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=2)
    panel_letters(shown)
    return figure


def _profiles(axes: Axes, comparison: LineComparison, body: str) -> None:
    result, record = comparison.result, comparison.record
    end = record.tables.conditions.cycles
    for profile in record.scars_of(body):
        x = profile.x_um - comparison.aside_um[body]
        axes.plot(x, profile.depth_um, ".", ms=2, color=GREY, label=record.name)
    if end in result.scar_cycles():
        own = result.scar(end, body)
        axes.plot(own.axial_um, own.depth_um[:, 0], color=VARIANT_COLOURS[0], label=result.full_name)
    axes.invert_yaxis()
    axes.set_title(f"worn depth, {body}")
    axes.set_xlabel("x (µm)")
    axes.set_ylabel("depth (µm)")


def _loops(axes: Axes, comparison: LineComparison, cycle: int) -> None:
    result, record = comparison.result, comparison.record
    for loop in record.loops:
        if loop.cycle == cycle:
            axes.plot(loop.displacement_um, loop.tangential_force_N, ".", ms=2, color=GREY, label=record.name)
    own = next(loop for loop in read_loops(result) if loop.cycle == cycle)
    x, q = (np.append(each, each[0]) for each in (own.displacement_um, own.tangential_force_N))
    axes.plot(x, q, color=VARIANT_COLOURS[0], label=result.full_name)
    axes.set_title(f"cycle {cycle_name(cycle)}")
    axes.set_xlabel("displacement (µm)")
    axes.set_ylabel("tangential force (N)")


def line_differences_table(comparison: LineComparison) -> Table:
    """Measured and simulated figures, to be printed with rich."""
    title = f"{comparison.record.name} against {comparison.result.label}"
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, title=escape(title), title_justify="left")
    table.add_column("figure", no_wrap=True)
    for heading in ("cycle", "measured", "scatter", "simulated", "measured over simulated"):
        table.add_column(heading, justify="right", no_wrap=True)
    for row in comparison.differences:
        scatter = "–" if row.scatter is None else f"{row.scatter:.3g}"
        figures = counted(row.cycle), f"{row.measured:.4g}", scatter, f"{row.simulated:.4g}", f"{row.relative:+.1%}"
        table.add_row(escape(row.quantity), *figures)
    return table
