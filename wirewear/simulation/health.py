"""How sound a run is, read from its measured cycles: energies that must close, pressures that must be mirrored."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import nan

import numpy as np

from solvers import ContactProblem, CycleTrace, mirror_error, symmetry_of
from wirewear.base.course import enclosed_energy
from wirewear.loops.area import enclosed_area
from wirewear.results.quality import ENERGIES_AGREE
from wirewear.simulation.tally import Counters

# A loop that encloses less than this share of the rectangle around it has no area worth comparing.
_LEAST_AREA = 1e-3
# Of all the energy that has worn: what the course between two loops may differ by from what has worn between them.
_BENT = 2e-3
#: A cycle, the friction work per cycle there and the energy that has worn so far, mJ.
Energies = tuple[float, float, float]


def judge(counters: Counters, trace: CycleTrace, rows: Sequence[Mapping[str, float]], accumulated_mJ: float) -> None:
    """Count what the latest measured cycle, the last row of an evolution, tells.

    accumulated_mJ: friction energy that has worn.
    """
    counters.worst("loop_area_against_friction_work", area_mismatch(trace))
    counters.worst("mirror_error", rows[-1]["mirror_error"])
    cycles, energies = ([row[name] for row in rows] for name in ("cycle", "dissipated_energy_mJ"))
    counters.energy_against_loops = energy_mismatch(cycles, energies, accumulated_mJ)


def area_mismatch(trace: CycleTrace) -> float:
    """Relative difference of a loop's area and the friction work over it; 0 where it encloses next to nothing."""
    drive, force, work = trace.drive, trace.tangential_force, trace.friction_work
    area = abs(enclosed_area(drive, force))
    if work <= 0.0 or area < _LEAST_AREA * np.ptp(drive) * np.ptp(force):
        return 0.0
    return abs(area / work - 1.0)


def mirrored_mismatch(problem: ContactProblem, trace: CycleTrace) -> float:
    """How far the pressures of a closed cycle are from their own mirror image, 0 to 1; see `solvers.mirror_error`.

    NaN where bodies, rig or effects have no mirror that takes the way out into the way back.
    """
    error = mirror_error(problem, trace.states, symmetry_of(problem))
    return nan if error is None else error


def energy_mismatch(cycles: Sequence[float], per_cycle_mJ: Sequence[float], accumulated_mJ: float) -> float:
    """Relative difference of the energy that measured loops enclose from the test's start to the last and that which
    has worn.

    cycles, per_cycle_mJ: of the loops, increasing.  accumulated_mJ: friction energy of all cycles up to the last.
    Up to the first loop the energy per cycle is taken to be that one's, between two loops to be a power of the cycles.
    0 before anything has worn. NaN where
    that differs from what has worn, but straight lines between the loops differ to the other side: the loops are then
    too few to tell how much they enclose.
    """
    if accumulated_mJ <= 0.0:
        return 0.0
    first = cycles[0] * per_cycle_mJ[0]
    by_powers = first + enclosed_energy(cycles, per_cycle_mJ)
    by_lines = first + float(np.trapezoid(per_cycle_mJ, cycles))
    mismatch = abs(by_powers / accumulated_mJ - 1.0)
    told = mismatch <= ENERGIES_AGREE or not min(by_powers, by_lines) < accumulated_mJ < max(by_powers, by_lines)
    return mismatch if told else nan


def bends(before: Energies, now: Energies) -> bool:
    """Whether the energy that has worn between two cycles is not what loops measured there would tell."""
    (start, per_cycle, worn), (end, later, total) = before, now
    told = enclosed_energy((start, end), (per_cycle, later))
    return abs(told - (total - worn)) > _BENT * total
