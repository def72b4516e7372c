"""Friction and compliance fitted to the loops of all cycles by the fast model."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from wirewear.course import Course
from wirewear.diagnosis.model.forward import simulate
from wirewear.diagnosis.model.setup import Setup
from wirewear.diagnosis.model.wear_states import WearStates
from wirewear.effects.friction_evolution import FrictionEvolution
from wirewear.fitting.loops_of_tests import FITTED, LoopsOfTests
from wirewear.loops import LoopError, analyse_loop

Array = NDArray[np.float64]

#: Samples of a modelled loop.
SAMPLES = 128

#: Running-in counts where it lowers Schwarz's criterion by so much, and changes friction by this share.
EVIDENCE, LEAST_CHANGE = 6.0, 0.03


@dataclass(frozen=True, eq=False)
class FastFit:
    """A course of friction and the holder's compliance, with the covariance of their coordinates.

    `coordinates` are (ln µ, compliance) or (ln µ_i, ln µ_f, ln n_c, compliance); `repeats` (n, k) are those of each
    test by itself, one step of Gauss and Newton from the common ones.
    """

    coordinates: Array
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
    friction = tests.mean[:, 0]
    known = np.isfinite(friction)
    ends = np.log(friction[known][[0, -1]])
    middle = float(np.log(np.sqrt(tests.cycles[0] * tests.cycles[-1])))
    running = _fitted(states, setup, tests, np.array([*ends, middle, constant.compliance_um_per_N]))
    change = abs(running.friction.initial / running.friction.final - 1.0)
    gain = constant.misfit - running.misfit - 2.0 * np.log(constant.points)
    return running if gain > EVIDENCE and change > LEAST_CHANGE else constant


def _fitted(states: WearStates, setup: Setup, tests: LoopsOfTests, start: Array) -> FastFit:
    low, high = np.full(start.size, -np.inf), np.full(start.size, np.inf)
    low[-1] = 0.0
    if start.size > 2:
        low[:3], high[:3] = np.log([0.02, 0.02, 1.0]), np.log([2.0, 2.0, 10.0 * tests.cycles[-1]])
    start = np.clip(start, low + 1e-9, high - 1e-9)
    known = np.isfinite(tests.mean)
    weight = np.sqrt(np.isfinite(tests.figures).sum(axis=0)[known]) / tests.deviations[known]

    def modelled(coordinates: Array) -> Array:
        figures: Array = figures_of_model(states, setup, coordinates, tests.cycles)[known]
        return figures

    def residuals(coordinates: Array) -> Array:
        off: Array = np.nan_to_num((modelled(coordinates) - tests.mean[known]) * weight, nan=10.0)
        return off

    scale = np.append(np.full(start.size - 1, 0.05), max(start[-1], 0.5))
    found = least_squares(residuals, start, bounds=(low, high), x_scale=scale, diff_step=2e-3, max_nfev=8)
    covariance = np.linalg.pinv(found.jac.T @ found.jac)
    expected = modelled(found.x)
    own = []
    for figures in tests.figures:
        there = np.isfinite(figures[known])
        jacobian = found.jac[there] / weight[there, None] / tests.deviations[known][there, None]
        off = (figures[known] - expected)[there] / tests.deviations[known][there]
        own.append(found.x + np.linalg.pinv(jacobian) @ off)
    return FastFit(found.x, covariance, np.array(own), 2.0 * float(found.cost), int(known.sum()))


def figures_of_model(states: WearStates, setup: Setup, coordinates: Array, cycles: Array) -> Array:
    """FITTED figures (n, k) of the fast model's loops, read by the same analysis as measured ones."""
    course = _friction(coordinates)
    asked = replace(setup, friction=course.final, compliance_um_per_N=float(coordinates[-1]))
    if coordinates.size > 2:
        evolution = FrictionEvolution(initial=course.initial, final=course.final, cycles=course.cycles)
        asked = asked.with_effect(evolution)
    found = simulate(states, asked, cycles)
    return np.array([_row(*loop, asked.load_N) for loop in _sampled(found.displacement_um, found.tangential_force_N)])


def _sampled(displacement: Array, force: Array) -> list[tuple[Array, Array]]:
    """Loops (n, 2, m) of both branches as a logger samples them under a drive that is a sine."""
    phase = 2.0 * np.pi * np.arange(SAMPLES) / SAMPLES
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
