"""Which effect explains the gap: each fitted under what one expects of it, weighed by evidence against all others.

The nuisances (scatter between specimens, errors of the solvers) are marginalised, being columns of the covariance.
Evidence is Laplace's, with every parameter a standard normal deviate beforehand, so that large ranges pay for
themselves (MacKay, Information Theory, Inference and Learning Algorithms, 2003, ch. 28).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve_triangular

from geometry.arrays import Array, BoolArray
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.infer.covariance import Covariance
from wirewear.diagnosis.model.candidates import Candidate
from wirewear.diagnosis.model.forward import simulate
from wirewear.diagnosis.model.setup import Setup
from wirewear.diagnosis.model.wear_states import WearStates
from wirewear.diagnosis.observe.reduction import Layout

_KNOWN = constants("infer.inference")

#: Coordinates beyond this many deviations are not searched.
REACH = _KNOWN.number("reach")

_STEP, _CONVERGED = _KNOWN.each("step", "converged")
ITERATIONS, _SEPARATION_ITERATIONS = _KNOWN.count("iterations"), _KNOWN.count("separation_iterations")

#: A search begins at the best of its starts, and at others whose cost is within this factor.
_COMPARABLE = _KNOWN.number("comparable")


@dataclass(frozen=True, eq=False)
class Problem:
    """What is to be explained: the observables of `layout`, with their mean and covariance, by the fast model.

    `whitening` (m, n) turns residuals into m independent standard deviates.
    """

    states: WearStates
    setup: Setup
    layout: Layout
    mean: Array
    whitening: Array
    log_determinant: float

    @classmethod
    def of(cls, states: WearStates, setup: Setup, layout: Layout, covariance: Covariance) -> Problem:
        """The whole record."""
        whitening, log_determinant = _whitening(covariance.total)
        return cls(states, setup, layout, covariance.mean, whitening, log_determinant)

    def part(self, keep: BoolArray, covariance: Covariance) -> Problem:
        """Some observables only."""
        whitening, log_determinant = _whitening(covariance.total[np.ix_(keep, keep)])
        return Problem(
            self.states, self.setup, self.layout.taken(keep), covariance.mean[keep], whitening, log_determinant
        )

    def predicted(self, setup: Setup) -> Array:
        """Observables (n,) under a setup."""
        values = self.layout.observed(simulate(self.states, setup, self.layout.cycles))
        return np.nan_to_num(values, nan=0.0, posinf=0.0, neginf=0.0)

    def whitened(self, setup: Setup) -> Array:
        """Residual (m,) in independent standard deviations."""
        return self.whitening @ (self.mean - self.predicted(setup))


@dataclass(frozen=True, eq=False)
class Fit:
    """One explanation: effects at their best coordinates (p,), their covariance (p, p), distance² and log evidence."""

    candidates: tuple[Candidate, ...]
    coordinates: Array
    spread: Array
    setup: Setup
    distance2: float
    log_evidence: float

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(candidate.name for candidate in self.candidates)

    @property
    def merit(self) -> float:
        """Log evidence by which fits are ordered: effects that are one to the model keep the library's order."""
        return round(self.log_evidence, 6)

    def parts(self) -> list[tuple[Candidate, Array, Array]]:
        """Each effect with its own coordinates and their standard deviations."""
        parts, at = [], 0
        deviations = np.sqrt(np.diag(self.spread)) if self.spread.size else np.zeros(0)
        for candidate in self.candidates:
            n = len(candidate.unknowns)
            parts.append((candidate, self.coordinates[at : at + n], deviations[at : at + n]))
            at += n
        return parts


def jacobian_of(problem: Problem, one: Fit) -> Array:
    """Derivative (m, p) of a fit's whitened residuals by its coordinates (p,)."""
    if not one.candidates:
        return np.zeros((problem.whitening.shape[0], 0))

    def residual(z: Array) -> Array:
        return problem.whitened(applied(one.candidates, problem.setup, z))

    return _jacobian(residual, one.coordinates, residual(one.coordinates))


def applied(candidates: Sequence[Candidate], setup: Setup, coordinates: Array) -> Setup:
    """The setup with several effects in it, one after the other."""
    at = 0
    for candidate in candidates:
        n = len(candidate.unknowns)
        setup = candidate.applied(setup, coordinates[at : at + n])
        at += n
    return setup


def fit(
    problem: Problem,
    candidates: Sequence[Candidate],
    starts: Sequence[Array] | None = None,
    iterations: int = ITERATIONS,
    known: Fit | None = None,
) -> Fit:
    """The best coordinates of these effects together, from several starts, or from what another record says of them.

    With `known`, its normal distribution of the coordinates is what is expected, and the evidence is that of this
    record given the other.
    """
    candidates = tuple(candidates)
    if not candidates:
        whitened = problem.whitened(problem.setup)
        distance2 = float(whitened @ whitened)
        return Fit((), np.zeros(0), np.zeros((0, 0)), problem.setup, distance2, -0.5 * distance2)

    low, high = np.vstack([candidate.bounds() for candidate in candidates]).T
    ends = np.maximum(low, -REACH), np.minimum(high, REACH)
    middle: Array = np.zeros(low.size)
    root: Array = np.eye(low.size)
    if known is not None:
        middle, root = known.coordinates, np.asarray(np.linalg.cholesky(known.spread), dtype=np.float64)
        starts, ends = [np.zeros(low.size)], (np.full(low.size, -REACH), np.full(low.size, REACH))
    seen: dict[bytes, Array] = {}

    def residual(z: Array) -> Array:
        # Where a search begins has been looked at before.
        place = z.tobytes()
        if place not in seen:
            seen[place] = problem.whitened(applied(candidates, problem.setup, middle + root @ z))
        return seen[place]

    best: tuple[float, Array, Array, Array] | None = None
    for start in _promising(residual, starts if starts is not None else _starts(candidates)):
        cost, z, rest, jacobian = _descend(residual, np.clip(start, *ends), iterations, ends)
        if best is None or cost < best[0] - 1e-9:
            best = cost, z, rest, jacobian
    if best is None:
        raise ValueError("a search needs a start")
    _, z, rest, jacobian = best
    hessian = jacobian.T @ jacobian + np.eye(z.size)
    distance2 = float(rest @ rest)
    evidence = -0.5 * distance2 - 0.5 * float(z @ z) - 0.5 * float(np.linalg.slogdet(hessian)[1])
    found = middle + root @ z
    spread = np.asarray(root @ np.linalg.inv(hessian) @ root.T, dtype=np.float64)
    return Fit(candidates, found, spread, applied(candidates, problem.setup, found), distance2, evidence)


def _starts(candidates: Sequence[Candidate]) -> list[Array]:
    if len(candidates) == 1:
        return candidates[0].starts()
    return [np.concatenate([candidate.starts()[1] for candidate in candidates])]


def _promising(residual: Callable[[Array], Array], starts: Sequence[Array]) -> list[Array]:
    """The two best of several starts, or the best alone if it is far better."""
    if len(starts) == 1:
        return list(starts)
    costs = [float(rest @ rest + z @ z) for z, rest in ((z, residual(z)) for z in starts)]
    order = np.argsort(costs, kind="stable")[:2]
    return [starts[i] for i in order if costs[i] <= _COMPARABLE * costs[order[0]]]


def _descend(
    residual: Callable[[Array], Array], start: Array, iterations: int, ends: tuple[Array, Array]
) -> tuple[float, Array, Array, Array]:
    """Levenberg–Marquardt on the residual and the prior, from one start, between the ends of the parameters' ranges.

    Steps of at most one deviation keep it from the ends of the ranges, where scipy's trust region was seen to stay.
    """
    z = start.astype(float).copy()
    rest = residual(z)
    cost = float(rest @ rest + z @ z)
    damping, jacobian = 1e-3, _jacobian(residual, z, rest)
    for _ in range(iterations):
        normal = jacobian.T @ jacobian + np.eye(z.size)
        step = np.linalg.solve(normal + damping * np.diag(np.diag(normal)), -(jacobian.T @ rest + z))
        step *= min(1.0, 1.0 / max(float(np.abs(step).max()), 1e-12))
        trial = np.clip(z + step, *ends)
        trial_rest = residual(trial)
        trial_cost = float(trial_rest @ trial_rest + trial @ trial)
        if trial_cost < cost:
            gained, z, rest, cost = cost - trial_cost, trial, trial_rest, trial_cost
            damping *= 0.2
            jacobian = _jacobian(residual, z, rest)
            if gained < _CONVERGED:
                break
        else:
            damping = max(10.0 * damping, 1e-2)
            if damping > 1e6:
                break
    return cost, z, rest, jacobian


def _jacobian(residual: Callable[[Array], Array], z: Array, rest: Array) -> Array:
    columns = []
    for i in range(z.size):
        moved = z.copy()
        # Away from the bound, so that the step is never clipped.
        moved[i] += -_STEP if z[i] > 0.0 else _STEP
        columns.append((residual(moved) - rest) / (moved[i] - z[i]))
    return np.stack(columns, axis=1)


def _whitening(covariance: Array) -> tuple[Array, float]:
    scale = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(scale, scale) + 1e-9 * np.eye(scale.size)
    factor = np.linalg.cholesky(correlation)
    inverse = solve_triangular(factor, np.eye(scale.size), lower=True)
    return inverse / scale, 2.0 * float(np.log(np.diag(factor)).sum() + np.log(scale).sum())


def separation(problem: Problem, one: Fit, other: Fit, known: Fit | None = None) -> float:
    """Least whitened distance between an explanation and another's effect, nuisances free, from where that is."""
    twin = replace(problem, mean=problem.predicted(one.setup))
    near = fit(twin, other.candidates, [other.coordinates], _SEPARATION_ITERATIONS, known)
    return float(np.sqrt(near.distance2))
