"""Fretting cycles: the drive's path, one simulated cycle, and wear states compared and extrapolated over cycle jumps.

Cycles start and end where the lower body is at +amplitude; the drive is a cosine, so increments are short near the
reversals, where the contact changes from slip to stick and back.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from solvers.contact import ContactProblem, advance
from solvers.contact_state import ContactState, IncrementReport, WearState

Array = NDArray[np.float64]

#: Called after every increment.
Watch = Callable[[ContactState, IncrementReport], None]


@dataclass(frozen=True)
class CycleTrace:
    """One simulated cycle of n increments from +amplitude and back; arrays (n,) hold the ends of increments.

    drive, holder_x in mm, forces in N, work in mJ (of the increment, for one cycle). middle: the state when the drive
    passes zero moving towards +x.
    """

    drive: Array
    holder_x: Array
    tangential_force: Array
    normal_force: Array
    work: Array
    reports: tuple[IncrementReport, ...]
    middle: ContactState

    @property
    def friction_work(self) -> float:
        """Friction work of the cycle, mJ."""
        return float(self.work.sum())


def drive_path(amplitude_mm: float, increments: int) -> Array:
    """Drive at the ends of the increments of a cycle, shape (increments,), the last one +amplitude.

    Mirrored quarter by quarter, so that both strokes are the same to the last bit.
    """
    quarter = amplitude_mm * np.cos(0.5 * np.pi * np.arange(1, increments // 4 + 1) / (increments // 4))
    quarter[-1] = 0.0
    fall = np.concatenate([quarter, -quarter[-2::-1], [-amplitude_mm]])
    return np.concatenate([fall, -fall])


def first_quarter(
    problem: ContactProblem, state: ContactState, amplitude_mm: float, increments: int, watch: Watch | None = None
) -> ContactState:
    """Move from mid-stroke to +amplitude without wear."""
    for drive in drive_path(amplitude_mm, increments)[-(increments // 4) :]:
        state, reports = advance(problem, state, float(drive), 0.0)
        for report in reports:
            if watch:
                watch(state, report)
    return state


def run_cycle(
    problem: ContactProblem,
    state: ContactState,
    amplitude_mm: float,
    increments: int,
    cycles: float,
    watch: Watch | None = None,
) -> tuple[ContactState, CycleTrace]:
    """Simulate one cycle from +amplitude that wears as `cycles` cycles do (0: wear frozen)."""
    path = drive_path(amplitude_mm, increments)
    rows: list[tuple[float, float, float, float]] = []
    everything: list[IncrementReport] = []
    middle = state
    for index, drive in enumerate(path):
        state, reports = advance(problem, state, float(drive), cycles)
        everything.extend(reports)
        for report in reports:
            if watch:
                watch(state, report)
        work = sum(report.friction_work for report in reports)
        rows.append((state.holder_x, reports[-1].tangential_force, reports[-1].normal_force, work))
        if index == 3 * increments // 4 - 1:
            middle = state
    holder_x, tangential, normal, work_done = np.array(rows).T
    return state, CycleTrace(path, holder_x, tangential, normal, work_done, tuple(everything), middle)


def wear_difference(whole: ContactState, halves: ContactState) -> float:
    """Largest difference of worn depth anywhere over the largest depth."""
    pairs = (
        (whole.wear.primary_depth, halves.wear.primary_depth),
        (whole.wear.secondary_depth, halves.wear.secondary_depth),
    )
    deepest = max(float(b.max()) for _, b in pairs)
    return max(float(np.abs(a - b).max()) for a, b in pairs) / deepest if deepest > 0.0 else 0.0


def extrapolated(problem: ContactProblem, whole: ContactState, halves: ContactState) -> ContactState:
    """Second-order combination of a step taken whole and in halves; worn volumes stay alpha times energy."""
    first, second = whole.wear, halves.wear
    primary_areas = problem.primary.patch.node_areas()
    secondary_areas = problem.secondary.patch.node_areas()

    def combine(a: Array, b: Array, areas: Array) -> Array:
        return _without_negative(2.0 * b - a, areas.reshape(a.shape))

    wear = WearState(
        primary_depth=combine(first.primary_depth, second.primary_depth, primary_areas),
        secondary_depth=combine(first.secondary_depth, second.secondary_depth, secondary_areas),
        primary_energy=combine(first.primary_energy, second.primary_energy, primary_areas),
        secondary_energy=combine(first.secondary_energy, second.secondary_energy, secondary_areas),
        energy_mJ=2.0 * second.energy_mJ - first.energy_mJ,
    )
    return replace(halves, wear=wear)


def _without_negative(field: Array, areas: Array) -> Array:
    """The field with negative values set to zero and the rest scaled so that its integral stays."""
    positive = np.maximum(field, 0.0)
    total = float((positive * areas).sum())
    return positive * (float((field * areas).sum()) / total) if total > 0.0 else positive
