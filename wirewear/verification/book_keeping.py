"""What holds on any mesh of worn wires: V = alpha E on both bodies, E = loop area, pressures that mirror themselves."""

from __future__ import annotations

from math import nan

from solvers import WearRates, closed_adaptive_cycle, mirror_error, symmetry_of
from wirewear.loops.area import enclosed_area
from wirewear.verification.level import Level
from wirewear.verification.rows import Row, compared
from wirewear.verification.sliding import INCREMENTS, AMPLITUDE_mm, at_end_of_stroke, jumped, sliding_wires

_RATES = WearRates(upper_mm3_per_mJ=6e-8, lower_mm3_per_mJ=4e-8)
_CYCLES = 50.0
_ROUND_OFF = 1e-10
_MIRROR_TOLERANCE = 0.02


def book_keeping_rows(level: Level) -> tuple[Row, ...]:
    """Worn volumes after a cycle jump, and a closed loop on the worn wires with the wear frozen."""
    problem = sliding_wires(level.loop_resolution, wear=_RATES)
    fresh = at_end_of_stroke(problem)
    _, first = closed_adaptive_cycle(problem, fresh, AMPLITUDE_mm, INCREMENTS)
    worn = jumped(problem, fresh, _CYCLES)
    wear, energy = worn.wear, worn.wear.energy_mJ
    upper = float((problem.upper.patch.node_areas() * wear.primary_depth.ravel()).sum())
    lower = float((problem.lower.patch.node_areas() * wear.secondary_depth.ravel()).sum())
    _, closed = closed_adaptive_cycle(problem, worn, AMPLITUDE_mm, INCREMENTS)
    name = f"Book-keeping, {_CYCLES:g} cycles"
    before, area = (abs(enclosed_area(loop.drive, loop.tangential_force)) for loop in (first, closed))
    work, mirror = closed.friction_work, mirror_error(problem, closed.states, symmetry_of(problem))
    return (
        compared(name, "energy = loop area times cycles [mJ]", energy, 0.5 * _CYCLES * (before + area), 5e-3),
        compared(name, "volume of upper wire = αE [mm³]", upper, _RATES.upper_mm3_per_mJ * energy, _ROUND_OFF),
        compared(name, "volume of lower wire = αE [mm³]", lower, _RATES.lower_mm3_per_mJ * energy, _ROUND_OFF),
        compared(name, "loop area = friction work [mJ]", area, work, 2e-3),
        compared(
            name, "mirror error of the pressures", nan if mirror is None else mirror, 0.0, _MIRROR_TOLERANCE, scale=1.0
        ),
    )
