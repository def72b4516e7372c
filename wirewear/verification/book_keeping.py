"""Book-keeping of wear and energy, which holds on any mesh: V = alpha E on both bodies, loop area = friction work."""

from __future__ import annotations

from solvers import WearRates, closed_adaptive_cycle, run_cycle
from wirewear.loops.area import enclosed_area
from wirewear.verification.level import Level
from wirewear.verification.rows import Row, compared
from wirewear.verification.sliding import INCREMENTS, AMPLITUDE_mm, at_end_of_stroke, sliding_wires

_RATES = WearRates(upper_mm3_per_mJ=6e-8, lower_mm3_per_mJ=4e-8)
_CYCLES = 50.0
_ROUND_OFF = 1e-10


def book_keeping_rows(level: Level) -> tuple[Row, ...]:
    """Worn volumes after a cycle jump, and a closed loop on the worn wires with the wear frozen."""
    problem = sliding_wires(level.loop_resolution, wear=_RATES)
    worn, jump = run_cycle(problem, at_end_of_stroke(problem), AMPLITUDE_mm, INCREMENTS, _CYCLES)
    wear, energy = worn.wear, _CYCLES * jump.friction_work
    upper = float((problem.upper.patch.node_areas() * wear.primary_depth.ravel()).sum())
    lower = float((problem.lower.patch.node_areas() * wear.secondary_depth.ravel()).sum())
    _, closed = closed_adaptive_cycle(problem, worn, AMPLITUDE_mm, INCREMENTS)
    name = f"Book-keeping, {_CYCLES:g} cycles"
    work, area = closed.friction_work, abs(enclosed_area(closed.drive, closed.tangential_force))
    return (
        compared(name, "energy kept in the state [mJ]", wear.energy_mJ, energy, _ROUND_OFF),
        compared(name, "volume of upper wire = αE [mm³]", upper, _RATES.upper_mm3_per_mJ * energy, _ROUND_OFF),
        compared(name, "volume of lower wire = αE [mm³]", lower, _RATES.lower_mm3_per_mJ * energy, _ROUND_OFF),
        compared(name, "loop area = friction work [mJ]", area, work, 2e-3),
    )
