"""Figures of loops, the numbers that `analyse_loop` gives, as tables and as JSON."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import groupby

from rich import box
from rich.table import Table
from rich.text import Text

from wirewear.base.words import counted
from wirewear.loops import LoopError, LoopFigures, Measured, StickSlip, analyse_loop
from wirewear.loops.figures import regime_of
from wirewear.records.importing.loop_sources import SampledLoop
from wirewear.records.loop_checks import DRY, NO_FRICTION

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

#: What loops without a plateau leave.
WITHOUT_PLATEAU = (("friction_partial_slip", "µ partial slip", 1.0), ("used_share", "Q*/µP", 1.0))


@dataclass(frozen=True, eq=False)
class AnalysedLoop:
    """A loop with its figures; if it cannot be analysed, figures are None and `refusal` is the reason."""

    loop: SampledLoop
    figures: LoopFigures | None
    refusal: str | None = None


def analyse_loops(loops: Iterable[SampledLoop]) -> tuple[AnalysedLoop, ...]:
    """Analyse loops; those that cannot be analysed keep the reason. Raises LoopError if there are none, or none of them
    can be analysed.
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
        signals = loop.displacement_um, loop.tangential_force_N, loop.normal_load_N
        figures = analyse_loop(*signals, time_s=loop.time_s, cycle=loop.cycle if loop.numbered else None)
    except LoopError as refusal:
        return AnalysedLoop(loop, None, str(refusal))
    ratio = figures.friction_max
    if ratio is not None and not DRY[0] <= ratio.value <= DRY[1]:
        warning = f"{NO_FRICTION.format(ratio.value)}: check the units of both"
        loop = replace(loop, notes=(*loop.notes, warning[:1].lower() + warning[1:]))
    return AnalysedLoop(loop, figures)


def loops_json(source: str, analysed: Sequence[AnalysedLoop]) -> dict[str, object]:
    """Plain values for JSON: {"source", "regime", "loops": [{"repeat", "cycle", figures by name, "notes", …}]}. source:
    name of the data. A figure is {"value", "interval95"} or None; a loop that cannot be analysed has "refused".
    """
    regime = regime_of(item.figures for item in analysed if item.figures is not None)
    return {"source": source, "regime": regime, "loops": [_json(item) for item in analysed]}


def _json(item: AnalysedLoop) -> dict[str, object]:
    found: dict[str, object] = {"repeat": item.loop.repeat, "cycle": item.loop.cycle}
    if item.figures is None:
        return found | {"refused": item.refusal}
    figures = item.figures
    for name, _, _ in (*FIGURES, *SHOWN_BY_SOME, *WITHOUT_PLATEAU):
        found[name] = _measured_json(getattr(figures, name))
    found["stick_slip"] = _stick_slip_json(figures.stick_slip)
    found["regime"] = {"value": figures.regime, "interval95": None}
    found["possible_regimes"] = list(figures.regimes)
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


def _stick_slip_json(chatter: StickSlip | None) -> dict[str, object] | None:
    if chatter is None:
        return None
    return {
        "share": chatter.share,
        "slips_per_cycle": chatter.slips_per_cycle,
        "frequency_Hz": chatter.frequency_Hz,
        "force_drop_share": _measured_json(chatter.force_drop_share),
        "resolved": chatter.resolved,
    }


def _measured_json(measured: Measured | None) -> dict[str, object] | None:
    """Value and interval for JSON, with null for anything unknown or infinite."""
    if measured is None:
        return None
    value, low, high = (one if math.isfinite(one) else None for one in (measured.value, *measured.interval95))
    return {"value": value, "interval95": [low, high]}


def loops_table(analysed: Sequence[AnalysedLoop]) -> Table:
    """Table with one row for each loop, to be printed with rich; ± is half the 95 % interval."""

    def cells(figures: LoopFigures) -> list[str]:
        return [figures.regime.removesuffix(" slip"), *(_cell(getattr(figures, name), f) for name, _, f in FIGURES)]

    return _table(analysed, "Loops (± half the 95 % interval)", ["regime", *(head for _, head, _ in FIGURES)], cells)


def real_loops_table(analysed: Sequence[AnalysedLoop]) -> Table | None:
    """Table of free play, friction by direction, static peaks and stick-slip; None if no loop shows play, peaks or
    stick-slip.
    """

    def shows_any(figures: LoopFigures | None) -> bool:
        return figures is not None and any((figures.free_play_um, figures.static_overshoot, figures.stick_slip))

    if not any(shows_any(item.figures) for item in analysed):
        return None

    def cells(figures: LoopFigures) -> list[str]:
        numbers = [_cell(getattr(figures, name), factor) for name, _, factor in SHOWN_BY_SOME]
        return [*numbers, *_chatter_cells(figures.stick_slip)]

    chatter = ["stick-slip share", "slips a cycle", "slips [Hz]", "force drop"]
    heads = [*(head for _, head, _ in SHOWN_BY_SOME), *chatter]
    return _table(analysed, "Free play, static friction and stick-slip", heads, cells)


def partial_slip_table(analysed: Sequence[AnalysedLoop]) -> Table | None:
    """Table of friction and possible regimes from loops without a plateau; None if there are no such loops."""
    if not any(item.figures is not None and item.figures.sticking is not None for item in analysed):
        return None

    def cells(figures: LoopFigures) -> list[str]:
        numbers = [with_interval(getattr(figures, name)) for name, _, _ in WITHOUT_PLATEAU]
        return [*numbers, " or ".join(one.removesuffix(" slip") for one in figures.regimes)]

    heads = [*(head for _, head, _ in WITHOUT_PLATEAU), "regime may be"]
    return _table(analysed, "Without a plateau (95 % interval)", heads, cells)


def with_interval(measured: Measured | None) -> str:
    """Value with its interval as text; without a value the bounds, "≥ low" if there is no upper one; "–" for None."""
    if measured is None:
        return "–"
    low, high = measured.interval95
    if math.isfinite(measured.value):
        return f"{measured.value:.3g} ({low:.3g} to {high:.3g})"
    return f"≥ {low:.3g}" if math.isinf(high) else f"{low:.3g} to {high:.3g}"


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
    """Texts for stick-slip: share of the sliding, slips per cycle, their frequency and the fall of the force."""
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
    """Texts of value × factor and of half its 95 % interval, both rounded to the first significant digit of the latter;
    four digits if the interval is no wider than round-off.
    """
    value, half = measured.value * factor, 0.5 * (measured.interval95[1] - measured.interval95[0]) * factor
    if not max(1e-5 * abs(value), 1e-9) < half < math.inf:
        return f"{round(value, 9) + 0.0:.4g}", f"{half:.1g}"
    decimals = max(-math.floor(math.log10(half)), 0)
    return f"{round(value, decimals) + 0.0:.{decimals}f}", f"{half:.{decimals}f}"


def remarks(analysed: Sequence[AnalysedLoop]) -> list[str]:
    """Notes and refusals of loops, each once, with the number of loops concerned unless that is all."""
    often: dict[str, int] = {}
    for item in analysed:
        found = item.figures.notes if item.figures else (f"refused: {item.refusal}",)
        for note in (*item.loop.notes, *found):
            often[note] = often.get(note, 0) + 1
    regimes = regimes_over_cycles(analysed)
    said = [f"{note} ({n} of {len(analysed)} loops)" if n < len(analysed) else note for note, n in often.items()]
    return said if regimes is None else [regimes, *said]


def regimes_over_cycles(analysed: Sequence[AnalysedLoop]) -> str | None:
    """Sentence on the cycles in which a mixed test slides as a whole; None for other tests."""
    known = [(item.loop.cycle, item.figures) for item in analysed if item.figures is not None]
    if regime_of(figures for _, figures in known) != "mixed":
        return None
    cycles = sorted({cycle for cycle, _ in known})
    regimes = [regime_of(figures for at, figures in known if at == cycle) for cycle in cycles]
    runs = []
    for regime, run in groupby(zip(regimes, cycles, strict=True), key=lambda one: one[0]):
        own = [cycle for _, cycle in run]
        where = f"cycle {counted(own[0])}" if len(own) == 1 else f"cycles {counted(own[0])} to {counted(own[-1])}"
        runs.append(f"{'some loops in either' if regime == 'mixed' else regime} in {where}")
    return f"a mixed test: {', '.join(runs)}"
