"""The spring that presses the bodies, from the fall of the measured normal force as they wear."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as students_t

from wirewear.diagnosis.model.forward import simulate
from wirewear.diagnosis.model.setup import Setup
from wirewear.diagnosis.model.wear_states import WearStates
from wirewear.fitting.fast_fit import EVIDENCE
from wirewear.fitting.loops_of_tests import LoopsOfTests
from wirewear.fitting.values import FittedParameter
from wirewear.records import AnyRecord
from wirewear.records.normal_force import median_load_N

Array = NDArray[np.float64]

#: By how much worn depths miss the way that bodies come together, beyond the first 10 µm of the article's run: growing
#: contacts give back up to 0.7 of 0.9 µm of approach.
DESCENT_DEVIATION = 0.03

SPRING = "normal_spring_stiffness_N_per_mm"


def with_spring(
    states: WearStates, setup: Setup, record: AnyRecord, tests: LoopsOfTests
) -> tuple[WearStates, dict[str, FittedParameter]]:
    """States whose load falls as the record's does, and the spring's stiffness; as they are where it does not decide.

    The bodies come together by the deepest depths of both. A load that drifts with the cycles falls in another course:
    the spring has to fit better by as much as counts for evidence, with an interval that leaves none out.
    """
    ends = [simulate(states, replace(setup, cycles=cycle), np.array([cycle])) for cycle in tests.cycles]
    profiles = [sum(float(depth.max()) for _, depth in one.profiles.values()) for one in ends]
    descent_um = np.array([one.scars[:, 1].sum() for one in ends]) + profiles
    loads = np.full((len(tests.repeats), tests.cycles.size), np.nan)
    for loop in record.loops:
        loads[tests.repeats.index(loop.repeat), tests.cycles == loop.cycle] = median_load_N(loop)
    spring = spring_of_loads(loads, descent_um, tests.cycles)
    if spring is None:
        return states, {}
    worn_um3 = np.array([one.volume_um3[-1] for one in ends])
    drop = 1e-3 * spring.value * np.interp(states.volume_um3, np.append(0.0, worn_um3), np.append(0.0, descent_um))
    return replace(states, load_drop_N=drop), {SPRING: spring}


def spring_of_loads(loads_N: Array, descent_um: Array, cycles: Array) -> FittedParameter | None:
    """Stiffness by which loads (repeats, cycles), NaN where not measured, fall with the descent; None if undecided."""
    slope, left, deviation, free = _common_slope(loads_N, descent_um)
    beside = _common_slope(loads_N, cycles)[1]
    floor = 1e-12 * float(np.nansum(loads_N**2))
    count = int(np.isfinite(loads_N).sum())
    if free < 1 or count * np.log((beside + floor) / (left + floor)) < EVIDENCE:
        return None
    half = float(np.hypot(float(students_t.ppf(0.975, free)) * deviation, 1.96 * DESCENT_DEVIATION * slope))
    low, value, high = (-1e3 * (slope + side * half) for side in (1.0, 0.0, -1.0))
    if not low > 0.0:
        return None
    return FittedParameter(value, (low, high), "N_per_mm", int(np.isfinite(loads_N).any(axis=1).sum()))


def _common_slope(values: Array, at: Array) -> tuple[float, float, float, int]:
    """Slope of rows over places, each with a level of its own; squares left, the slope's deviation, their freedom."""
    rows, columns = np.nonzero(np.isfinite(values))
    levels = rows[:, None] == np.unique(rows)
    design, wanted = np.column_stack([levels, at[columns]]), values[rows, columns]
    found = np.linalg.lstsq(design, wanted, rcond=None)[0]
    left = float(((wanted - design @ found) ** 2).sum())
    free = wanted.size - np.linalg.matrix_rank(design)
    spread = float(np.linalg.pinv(design.T @ design)[-1, -1])
    return float(found[-1]), left, float(np.sqrt(spread * left / max(free, 1))), int(free)
