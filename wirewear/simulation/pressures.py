"""Pressures of a closed loop, largest and about mid-stroke: of single nodes, and as means over a length."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from solvers import ContactProblem, ContactState, CycleTrace
from wirewear.results import largest_means

Array = NDArray[np.float64]

# Mid-stroke is where the drive is within this share of its amplitude: 35 µm of 60.
MID_STROKE = 35.0 / 60.0


def pressure_figures(problem: ContactProblem, trace: CycleTrace, length_mm: float) -> dict[str, float]:
    """Columns of a closed loop's row of the evolution, MPa; means are over the length."""
    reports = [(report.drive, report.max_pressure, report.inner_pressure) for report in trace.reports]
    drives, largest, inner = np.array(reports).T
    means = mean_pressures(problem, trace.states, length_mm)
    return {
        "max_pressure_MPa": float(largest.max()),
        "mid_stroke_pressure_MPa": at_mid_stroke(drives, inner),
        "max_mean_pressure_MPa": float(means.max()),
        "mid_stroke_mean_pressure_MPa": at_mid_stroke(trace.drive, means),
    }


def mean_pressures(problem: ContactProblem, states: Sequence[ContactState], length_mm: float) -> Array:
    """The largest mean pressure over a length in each of k states that differ in no wear, (k,), MPa."""
    patch = problem.primary.patch
    pressures = nodal_pressures(problem, states).reshape(len(states), *patch.shape)
    return largest_means(pressures, patch.axial_mm, patch.transverse_mm, length_mm)


def nodal_pressures(problem: ContactProblem, states: Sequence[ContactState]) -> Array:
    """Normal pressures (k, n) at the primary's nodes in k states that differ in no wear, MPa.

    Normal is what is so to the primary's own surface. Solvers take the mean slope of both.
    """
    tractions = np.array([state.traction for state in states])
    nodes = np.flatnonzero(tractions[:, :, 2].any(axis=0))
    slope = problem.surface.mean_slope(nodes, states[0].wear.primary_depth)
    pressures = np.zeros(tractions.shape[:2])
    own = tractions[:, nodes]
    normal = own[..., 2] - np.einsum("knc,nc->kn", own[..., :2], slope)
    pressures[:, nodes] = normal / (1.0 + (slope**2).sum(axis=1))
    return pressures


def at_mid_stroke(drive: ArrayLike, pressure: ArrayLike) -> float:
    """Median over mid-stroke of pressures (k,) at drives (k,) of a closed loop, each weighing as much as it moves."""
    drive, pressure = np.asarray(drive), np.asarray(pressure)
    step = np.abs(np.diff(drive, prepend=drive[-1]))
    weight = np.where(np.abs(drive) < MID_STROKE * np.abs(drive).max(), step + np.roll(step, -1), 0.0)
    order = np.argsort(pressure)
    passed = np.cumsum(weight[order])
    return float(pressure[order][np.searchsorted(passed, 0.5 * passed[-1])])
