"""Figures of loops as a table and as JSON."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from rich import box
from rich.table import Table
from rich.text import Text

from wirewear.base.quantity import counted
from wirewear.loops import LoopError, LoopFigures, Measured, StickSlip, analyse_loop
from wirewear.views.loops_sources import SampledLoop

#: Figures in the order of the table and of JSON: name in `LoopFigures`, heading, factor to the heading's unit.
FIGURES = (
    ("displacement_amplitude_um", "δa [µm]", 1.0),
    ("slip_amplitude_um", "δ0 [µm]", 1.0),
    ("measured_stiffness_N_per_um", "K_t,m [N/mm]", 1e3),
    ("friction_max", "µ max", 1.0),
    ("friction_energy", "µ energy", 1.0),
    ("friction_geometry_independent", "µ geom.-indep.", 1.0),
    ("dissipated_energy_mJ", "E_d [mJ]", 1.0),
    ("energy_ratio", "A", 1.0),
    ("system_free_ratio", "B", 1.0),
    ("plateau_slope_N_per_um", "plateau slope [N/mm]", 1e3),
    ("end_hook_ratio", "end hooks", 1.0),
    ("corner_curvature", "corner curv.", 1.0),
    ("mean_force_N", "mean force [N]", 1.0),
    ("asymmetry", "asymmetry", 1.0),
)
#: What only some loops show, in a table of their own.
SHOWN_BY_SOME = (
    ("free_play_um", "free play [µm]", 1.0),
    ("force_zero_N", "force zero [N]", 1.0),
    ("friction_forward", "µ forward", 1.0),
    ("friction_backward", "µ backward", 1.0),
    ("static_overshoot", "static peak", 1.0),
)


@dataclass(frozen=True, eq=False)
class AnalysedLoop:
    """A loop with its figures, or with None and the reason in `refusal`."""

    loop: SampledLoop
    figures: LoopFigures | None
    refusal: str | None = None


def analyse_loops(loops: Iterable[SampledLoop]) -> tuple[AnalysedLoop, ...]:
    """Analyse loops; those that cannot be are kept with the reason.
    Raises LoopError if none of them can be analysed.
    """
    analysed = [_analysed(loop) for loop in loops]
    if analysed and all(item.figures is None for item in analysed):
        first = analysed[0]
        raise LoopError(
            f"no loop can be analysed; repeat {first.loop.repeat}, cycle {first.loop.cycle}: {first.refusal}"
        )
    if not analysed:
        raise LoopError("there are no loops to analyse")
    return tuple(analysed)


def _analysed(loop: SampledLoop) -> AnalysedLoop:
    try:
        figures = analyse_loop(loop.displacement_um, loop.tangential_force_N, loop.normal_load_N, time_s=loop.time_s)
    except LoopError as refusal:
        return AnalysedLoop(loop, None, str(refusal))
    return AnalysedLoop(loop, figures)


def loops_json(source: str, analysed: Sequence[AnalysedLoop]) -> dict[str, Any]:
    """``{"source", "loops": [{"repeat", "cycle", figure: {"value", "interval95"} or null, "notes", …}]}``."""
    return {"source": source, "loops": [_json(item) for item in analysed]}


def _json(item: AnalysedLoop) -> dict[str, Any]:
    found: dict[str, Any] = {"repeat": item.loop.repeat, "cycle": item.loop.cycle}
    if item.figures is None:
        return found | {"refused": item.refusal}
    figures = item.figures
    for name, _, _ in (*FIGURES, *SHOWN_BY_SOME):
        found[name] = _measured_json(getattr(figures, name))
    found["stick_slip"] = _stick_slip_json(figures.stick_slip)
    found["regime"] = {"value": figures.regime, "interval95": None}
    found["micro_slip_branches"] = [
        {
            "direction": branch.direction,
            "stiffness_N_per_um": _measured_json(branch.stiffness_N_per_um),
            "fitted_displacement_um": list(branch.displacement_um),
            "micro_slip_travel_um": branch.micro_slip_travel_um,
        }
        for branch in figures.branches
    ]
    return found | {"outlier_samples": list(figures.outlier_samples), "notes": [*item.loop.notes, *figures.notes]}


def _stick_slip_json(chatter: StickSlip | None) -> dict[str, Any] | None:
    if chatter is None:
        return None
    return {
        "share": chatter.share,
        "slips_per_cycle": chatter.slips_per_cycle,
        "frequency_Hz": chatter.frequency_Hz,
        "force_drop_share": _measured_json(chatter.force_drop_share),
        "resolved": chatter.resolved,
    }


def _measured_json(measured: Measured | None) -> dict[str, Any] | None:
    return None if measured is None else {"value": measured.value, "interval95": list(measured.interval95)}


def loops_table(analysed: Sequence[AnalysedLoop]) -> Table:
    """One row for each loop, to be printed with rich; ± is half of the 95 % interval."""

    def cells(figures: LoopFigures) -> list[str]:
        return [figures.regime.removesuffix(" slip"), *(_cell(getattr(figures, name), f) for name, _, f in FIGURES)]

    return _table(analysed, "Loops (± half the 95 % interval)", ["regime", *(head for _, head, _ in FIGURES)], cells)


def real_loops_table(analysed: Sequence[AnalysedLoop]) -> Table | None:
    """Free play, friction by direction, static peaks and stick-slip; None where no loop shows any of the three."""

    def tells(figures: LoopFigures | None) -> bool:
        return figures is not None and any((figures.free_play_um, figures.static_overshoot, figures.stick_slip))

    if not any(tells(item.figures) for item in analysed):
        return None

    def cells(figures: LoopFigures) -> list[str]:
        numbers = [_cell(getattr(figures, name), factor) for name, _, factor in SHOWN_BY_SOME]
        return [*numbers, *_chatter_cells(figures.stick_slip)]

    chatter = ["stick-slip share", "slips a cycle", "slips [Hz]", "force drop"]
    heads = [*(head for _, head, _ in SHOWN_BY_SOME), *chatter]
    return _table(analysed, "Free play, static friction and stick-slip", heads, cells)


def _table(
    analysed: Sequence[AnalysedLoop], title: str, headings: Sequence[str], cells: Callable[[LoopFigures], list[str]]
) -> Table:
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False, title=title, title_justify="left")
    repeats, cycles = ({getattr(item.loop, key) for item in analysed} for key in ("repeat", "cycle"))
    for heading, shown in (("repeat", len(repeats) > 1), ("cycle", len(cycles) > 1)):
        if shown:
            table.add_column(heading, justify="right", no_wrap=True)
    for heading in headings:
        # A unit in brackets is no markup.
        table.add_column(Text(heading), justify="right", min_width=8)
    for item in analysed:
        keys = [str(item.loop.repeat)] * (len(repeats) > 1) + [counted(item.loop.cycle)] * (len(cycles) > 1)
        own = ["refused", *["–"] * (len(headings) - 1)] if item.figures is None else cells(item.figures)
        table.add_row(*keys, *own)
    return table


def _chatter_cells(chatter: StickSlip | None) -> list[str]:
    """Share of the sliding, slips of a cycle, how often they come, and by how much the force falls."""
    if chatter is None:
        return ["–"] * 4
    often = "–" if chatter.frequency_Hz is None else f"{chatter.frequency_Hz:.3g}"
    least = "" if chatter.resolved else "≥ "
    return [f"{chatter.share:.0%}", f"{least}{chatter.slips_per_cycle}", often, _cell(chatter.force_drop_share, 1.0)]


def _cell(measured: Measured | None, factor: float) -> str:
    if measured is None:
        return "–"
    return "\n± ".join(rounded(measured, factor))


def rounded(measured: Measured, factor: float = 1.0) -> tuple[str, str]:
    """Value × factor and half its 95 % interval, both to the latter's first significant digit."""
    half = 0.5 * (measured.interval95[1] - measured.interval95[0]) * factor
    if not 0.0 < half < math.inf:
        return f"{round(measured.value * factor, 12) + 0.0:.4g}", f"{half:.1g}"
    decimals = max(-math.floor(math.log10(half)), 0)
    return f"{round(measured.value * factor, decimals) + 0.0:.{decimals}f}", f"{half:.{decimals}f}"


def remarks(analysed: Sequence[AnalysedLoop]) -> list[str]:
    """Notes and refusals, each once, with the number of loops that it is about where that is not all."""
    counted: dict[str, int] = {}
    for item in analysed:
        found = item.figures.notes if item.figures else (f"refused: {item.refusal}",)
        for note in (*item.loop.notes, *found):
            counted[note] = counted.get(note, 0) + 1
    return [f"{note} ({n} of {len(analysed)} loops)" if n < len(analysed) else note for note, n in counted.items()]
