"""Friction and compliance fitted to the loops of all cycles by the fast model."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from wirewear.base.course import Course
from wirewear.diagnosis.model.forward import simulate
from wirewear.diagnosis.model.setup import Setup
from wirewear.diagnosis.model.wear_states import WearStates
from wirewear.effects.friction_evolution import FrictionEvolution
from wirewear.fitting.loops_of_tests import FITTED, FRICTIONS, LoopsOfTests
from wirewear.loops import LoopError, analyse_loop

Array = NDArray[np.float64]

#: Samples of a modelled loop, where it is compared with none that has a number of its own.
SAMPLES = 128

#: Running-in takes at most so many times the test.
LONGEST_RUNNING_IN = 10.0

#: Running-in counts where it lowers Schwarz's criterion by so much, and changes friction by this share.
EVIDENCE, LEAST_CHANGE = 6.0, 0.03


@dataclass(frozen=True, eq=False)
class FastFit:
    """A course of friction and the holder's compliance, with the covariance of their coordinates.

    `coordinates` are (ln µ, compliance) or (ln µ_i, ln µ_f, ln n_c, compliance), between `low` and `high`; `repeats`
    (n, k) are those of each test by itself, one step of Gauss and Newton from the common ones.
    """

    coordinates: Array
    low: Array
    high: Array
    covariance: Array
    repeats: Array
    misfit: float
    points: int

    @property
    def runs_in(self) -> bool:
        """Whether friction changes."""
        return self.coordinates.size > 2

    @property
    def friction(self) -> Course:
        """Friction over the cycles."""
        return _friction(self.coordinates)

    @property
    def compliance_um_per_N(self) -> float:
        """Compliance of the holder."""
        return float(self.coordinates[-1])


def _friction(coordinates: Array) -> Course:
    if coordinates.size == 2:
        return Course.constant(float(np.exp(coordinates[0])))
    initial, final, cycles = np.exp(coordinates[:3])
    return Course(float(initial), float(final), float(cycles))


def fast_fit(states: WearStates, setup: Setup, tests: LoopsOfTests) -> FastFit:
    """Constant friction, or friction that runs in where the loops ask for that."""
    start = np.array([np.log(setup.friction), setup.compliance_um_per_N])
    constant = _fitted(states, setup, tests, start)
    if tests.cycles.size < 4 or tests.cycles[-1] < 30.0 * tests.cycles[0]:
        return constant
    if constant.misfit < EVIDENCE + 2.0 * np.log(constant.points):
        return constant
    friction = tests.mean[:, 0]
    known = np.isfinite(friction)
    ends = np.log(friction[known][[0, -1]])
    middle = float(np.log(np.sqrt(tests.cycles[0] * tests.cycles[-1])))
    running = _fitted(states, setup, tests, np.array([*ends, middle, constant.compliance_um_per_N]))
    change = abs(running.friction.initial / running.friction.final - 1.0)
    gain = constant.misfit - running.misfit - 2.0 * np.log(constant.points)
    return running if gain > EVIDENCE and change > LEAST_CHANGE else constant


def _bounds(count: int, tests: LoopsOfTests) -> tuple[Array, Array]:
    """The lowest and highest values of so many coordinates."""
    low, high = (np.full(count, np.log(end)) for end in FRICTIONS)
    if count > 2:
        low[2], high[2] = 0.0, np.log(LONGEST_RUNNING_IN * tests.cycles[-1])
    low[-1], high[-1] = 0.0, np.inf
    return low, high


def _fitted(states: WearStates, setup: Setup, tests: LoopsOfTests, start: Array) -> FastFit:
    low, high = _bounds(start.size, tests)
    start = np.clip(start, low + 1e-9, high - 1e-9)

    def modelled(coordinates: Array) -> Array:
        return figures_of_model(states, setup, coordinates, tests.cycles, tests.samples)

    known = np.isfinite(tests.mean) & np.isfinite(modelled(start))
    weight = np.sqrt(np.isfinite(tests.figures).sum(axis=0)[known]) / tests.deviations[known]

    def residuals(coordinates: Array) -> Array:
        off: Array = np.nan_to_num((modelled(coordinates)[known] - tests.mean[known]) * weight, nan=10.0)
        return off

    scale = np.append(np.full(start.size - 1, 0.05), max(start[-1], 0.5))
    found = least_squares(residuals, start, bounds=(low, high), x_scale=scale, diff_step=2e-3, max_nfev=8)
    covariance = np.linalg.pinv(found.jac.T @ found.jac)
    expected = modelled(found.x)[known]
    own = []
    for figures in tests.figures:
        off = (figures[known] - expected) / tests.deviations[known]
        there = np.isfinite(off)
        jacobian = found.jac[there] / weight[there, None] / tests.deviations[known][there, None]
        own.append(np.clip(found.x + np.linalg.pinv(jacobian) @ off[there], low, high))
    return FastFit(found.x, low, high, covariance, np.array(own), 2.0 * float(found.cost), int(known.sum()))


def figures_of_model(
    states: WearStates, setup: Setup, coordinates: Array, cycles: Array, samples: int = SAMPLES
) -> Array:
    """FITTED figures (n, k) of the fast model's loops of so many samples, read as measured ones are."""
    course = _friction(coordinates)
    asked = replace(setup, friction=course.final, compliance_um_per_N=float(coordinates[-1]))
    if coordinates.size > 2:
        evolution = FrictionEvolution(initial=course.initial, final=course.final, cycles=course.cycles)
        asked = asked.with_effect(evolution)
    found = simulate(states, asked, cycles)
    loops = _sampled(found.displacement_um, found.tangential_force_N, samples)
    return np.array([_row(*loop, asked.load_N) for loop in loops])


def _sampled(displacement: Array, force: Array, samples: int) -> list[tuple[Array, Array]]:
    """Loops (n, 2, m) of both branches as a logger takes so many samples of them under a drive that is a sine."""
    phase = 2.0 * np.pi * np.arange(samples) / samples
    loops = []
    for (up_x, down_x), (up_q, down_q) in zip(displacement, force, strict=True):
        x = 0.5 * (up_x.max() + up_x.min()) + 0.5 * float(np.ptp(up_x)) * np.sin(phase)
        forward = np.interp(x, up_x, up_q)
        backward = np.interp(x, down_x[::-1], down_q[::-1])
        loops.append((x, np.where(np.cos(phase) >= 0.0, forward, backward)))
    return loops


def _row(displacement: Array, force: Array, load_N: float) -> list[float]:
    try:
        figures = analyse_loop(displacement, force, load_N)
    except LoopError:
        return [np.nan] * len(FITTED)
    return [np.nan if (found := getattr(figures, name)) is None else found.value for name in FITTED]
