"""Which effect explains the gap: each fitted with its expected sizes as the prior, and compared by evidence with all
others.

Parameters are searched as coordinates: standard normal deviates beforehand, 0 being the expected middle. The nuisances
(scatter between specimens, errors of the solvers) are marginalised, being columns of the covariance. Evidence is
Laplace's, so that large ranges pay for themselves (MacKay, Information Theory, Inference and Learning Algorithms, 2003,
ch. 28). A setup holds inputs of the fast model; a candidate is an effect that may be at work.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeVar

import numpy as np
from scipy.linalg import solve_triangular

from geometry.arrays import Array, BoolArray
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.infer.covariance import Covariance, estimate, moved, with_model_error
from wirewear.diagnosis.observe.reduction import Layout, Observations
from wirewear.diagnosis.surrogate.candidates import Candidate
from wirewear.diagnosis.surrogate.inputs import SurrogateInputs
from wirewear.diagnosis.surrogate.wear_states import WearStates
from wirewear.effects.holder import Plasticity

Found = TypeVar("Found")

_KNOWN = constants("infer.inference")

#: Coordinates beyond this many deviations are not searched.
REACH = _KNOWN.number("reach")

_STEP, _CONVERGED = _KNOWN.each("step", "converged")
ITERATIONS, SEPARATION_ITERATIONS = _KNOWN.count("iterations"), _KNOWN.count("separation_iterations")

#: A search begins at the best of its starts, and at others whose cost is within this factor.
_COMPARABLE = _KNOWN.number("comparable")


@dataclass(frozen=True, eq=False)
class Problem:
    """Observables of a record to be explained by the fast model, with its nominal setup.

    layout, mean: the n observables and their means over the repeats. whitening: (m, n), turns residuals into m
    independent standard deviates. known: cache of predicted observables by setup, which problems of one record share.
    free: standard deviations, by name, of the numerical freedoms that every explanation is fitted with.
    """

    states: WearStates
    setup: SurrogateInputs
    layout: Layout
    mean: Array
    whitening: Array
    known: dict[SurrogateInputs, Array] = field(default_factory=dict)
    free: Mapping[str, float] = field(default_factory=dict)

    @classmethod
    def of(cls, states: WearStates, setup: SurrogateInputs, layout: Layout, covariance: Covariance) -> Problem:
        """The problem of explaining all observables of `layout`, with the covariance's mean and total."""
        everything = np.ones(len(layout), dtype=bool)
        return cls(states, setup, layout, covariance.mean, np.zeros((0, 0))).part(everything, covariance)

    def part(self, keep: BoolArray, covariance: Covariance) -> Problem:
        """The problem of explaining only the observables that `keep` (n,) marks, with their part of the covariance."""
        fixed = covariance.total - covariance.moved @ covariance.moved.T
        whitening, mean = _whitening(fixed[np.ix_(keep, keep)]), covariance.mean[keep]
        return Problem(self.states, self.setup, self.layout.taken(keep), mean, whitening, free=covariance.free)

    def predictions(self, setups: Sequence[SurrogateInputs]) -> Array:
        """Observables (k, n) under k setups; 0 where the fast model defines none."""
        new = [setup for setup in dict.fromkeys(setups) if setup not in self.known]
        values = self.layout.computed(self.states, *new)
        self.known.update(zip(new, np.nan_to_num(values, nan=0.0, posinf=0.0, neginf=0.0), strict=True))
        return np.stack([self.known[setup] for setup in setups])

    def predicted(self, setup: SurrogateInputs) -> Array:
        """Observables (n,) under a setup; 0 where the fast model defines none."""
        return np.asarray(self.predictions([setup])[0])

    def whitened(self, setup: SurrogateInputs) -> Array:
        """Measured less predicted observables under a setup as independent standard deviates (m,)."""
        return self.whitening @ (self.mean - self.predicted(setup))


def problem_around(
    states: WearStates,
    setup: SurrogateInputs,
    around: SurrogateInputs,
    observed: Observations,
    effects: Sequence[Candidate] = (),
    before: Problem | None = None,
) -> tuple[Problem, Covariance]:
    """The problem of explaining a record from the nominal `setup`, and the covariance at the setup `around`.

    effects: those in `around`, whose model error is included. before: an earlier problem of the record, whose cached
    predictions are shared.
    """
    covariance = estimate(states, around, observed)
    error = max((states.model_error(effect.kind) for effect in effects), default=0.0)
    if error > 0.0:
        law = max(effect.kind.law_error for effect in effects)
        covariance = with_model_error(states, setup, around, observed.layout, covariance, error, law)
    if setup.print_um > 0.0:
        # What a stated yield stress changes is known no better; bodies of 100 GPa yield nowhere.
        elastic = setup.with_effect(Plasticity(yield_stress_MPa=1e5))
        error, law = Plasticity.model_error, Plasticity.law_error
        covariance = with_model_error(states, setup, elastic, observed.layout, covariance, error, law)
    problem = Problem.of(states, setup, observed.layout, covariance)
    return problem if before is None else replace(problem, known=before.known), covariance


@dataclass(frozen=True, eq=False)
class Fit:
    """Best fit of one explanation, a set of effects.

    coordinates, spread: (p,) and (p, p), the effects' best coordinates and their covariance, by noise and by what the
    model of each effect is off as a whole. setup: with these effects and the freedoms in it. distance2: χ² that is
    left. log_evidence: of the record by this explanation.
    """

    candidates: tuple[Candidate, ...]
    coordinates: Array
    spread: Array
    setup: SurrogateInputs
    distance2: float
    log_evidence: float
    #: (k,) coordinates of the numerical freedoms, in standard deviations.
    free: Array = field(default_factory=lambda: np.zeros(0))

    @property
    def places(self) -> Array:
        """Coordinates (p + k,) of the effects and then of the freedoms."""
        return np.concatenate([self.coordinates, self.free])

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(candidate.name for candidate in self.candidates)

    @property
    def merit(self) -> float:
        """Log evidence rounded to six digits, for sorting: effects that the model cannot distinguish keep their
        order.
        """
        return round(self.log_evidence, 6)

    def parts(self) -> list[tuple[Candidate, Array, Array]]:
        """For each effect the candidate, its coordinates and their standard deviations."""
        deviations = np.sqrt(np.diag(self.spread)) if self.spread.size else np.zeros(0)
        return [(one, self.coordinates[own], deviations[own]) for one, own in _with_places(self.candidates)]


def jacobian_of(problem: Problem, one: Fit) -> Array:
    """Derivative (m, p + k) of a fit's whitened residuals by the coordinates of its effects and freedoms."""
    if not one.places.size:
        return np.zeros((problem.whitening.shape[0], 0))
    asked = _jacobian(lambda z: placed(problem, one.candidates, z), one.places, problem.whitened(one.setup))
    return together(problem, [asked])[0]


def placed(problem: Problem, candidates: Sequence[Candidate], places: Array) -> SurrogateInputs:
    """The problem's setup with effects and numerical freedoms at coordinates `places` (p + k,), effects first."""
    count = places.size - len(problem.free)
    setup = applied(candidates, problem.setup, places[:count])
    for (name, size), place in zip(problem.free.items(), places[count:].tolist(), strict=True):
        setup = moved(setup, name, size * place)
    return setup


def applied(candidates: Sequence[Candidate], setup: SurrogateInputs, coordinates: Array) -> SurrogateInputs:
    """A copy of `setup` with the candidates' effects at their coordinates (p,), added one after the other."""
    for candidate, own in _with_places(candidates):
        setup = candidate.applied(setup, coordinates[own])
    return setup


def _with_places(candidates: Sequence[Candidate]) -> Iterator[tuple[Candidate, slice]]:
    """Each effect with the places of its coordinates among those of all."""
    end = 0
    for candidate in candidates:
        begin, end = end, end + len(candidate.unknowns)
        yield candidate, slice(begin, end)


#: A search as a generator: it asks for whitened residuals under setups, is sent them, and returns its result.
Asking = Generator[list[SurrogateInputs], list[Array], Found]


def together(problem: Problem, searches: Sequence[Asking[Found]]) -> list[Found]:
    """Results of several searches, in their order; they run in step, so that their predictions are computed
    together.
    """
    asked = {place: next(search) for place, search in enumerate(searches)}
    found: dict[int, Found] = {}
    while asked:
        values = problem.predictions([setup for setups in asked.values() for setup in setups])
        residuals = iter(((problem.mean - values) @ problem.whitening.T).copy())
        for place, setups in [*asked.items()]:
            try:
                asked[place] = searches[place].send([next(residuals) for _ in setups])
            except StopIteration as end:
                found[place] = end.value
                del asked[place]
    return [found[place] for place in range(len(searches))]


def fit(
    problem: Problem,
    candidates: Sequence[Candidate],
    starts: Sequence[Array] | None = None,
    iterations: int = ITERATIONS,
    known: Fit | None = None,
) -> Fit:
    """The best fit of several effects together; arguments as of `sought`."""
    return together(problem, [sought(problem, candidates, starts, iterations, known)])[0]


def sought(
    problem: Problem,
    candidates: Sequence[Candidate],
    starts: Sequence[Array] | None = None,
    iterations: int = ITERATIONS,
    known: Fit | None = None,
) -> Asking[Fit]:
    """A search, to be run by `together`, for the best coordinates of several effects, by Levenberg–Marquardt from
    several starts.

    candidates: the effects; empty for the numerical freedoms alone. starts: coordinates (p,) of the effects, or (p +
    k,) with those of the freedoms, else 0; None for the candidates' own. iterations: most steps from each start. known:
    a fit of the same effects to another record, whose distribution of the coordinates is the prior in place of the
    expected one; the evidence is then that of this record given the other.
    """
    candidates, free = tuple(candidates), len(problem.free)
    low, high = np.vstack([np.zeros((0, 2)), *(candidate.bounds() for candidate in candidates)]).T
    count = low.size
    if not count + free:
        (whitened,) = yield [problem.setup]
        distance2 = float(whitened @ whitened)
        return Fit((), np.zeros(0), np.zeros((0, 0)), problem.setup, distance2, -0.5 * distance2)

    ends: tuple[Array, Array] = np.full(count + free, -REACH), np.full(count + free, REACH)
    middle, root = np.zeros(count + free), np.eye(count + free)
    if known is not None:
        middle[:count], root[:count, :count] = known.coordinates, np.linalg.cholesky(known.spread)
        starts = [np.zeros(count)]
    else:
        ends[0][:count], ends[1][:count] = np.maximum(low, -REACH), np.minimum(high, REACH)

    def at(z: Array) -> SurrogateInputs:
        return placed(problem, candidates, middle + root @ z)

    own = _starts(candidates) if starts is None else starts
    places = [np.concatenate([start, np.zeros(count + free - start.size)]) for start in own]
    rests = yield [at(z) for z in places]
    best: tuple[float, Array, Array] | None = None
    # The two best of several starts, or the best alone if it is far better.
    costs = [float(rest @ rest + z @ z) for z, rest in zip(places, rests, strict=True)]
    order = np.argsort(costs, kind="stable")[:2]
    for start in [places[one] for one in order if costs[one] <= _COMPARABLE * costs[order[0]]]:
        cost, z, rest = yield from _descend(at, np.clip(start, *ends), iterations, ends)
        if best is None or cost < best[0] - 1e-9:
            best = cost, z, rest
    if best is None:
        raise ValueError("a search needs a start")
    _, z, rest = best
    jacobian = yield from _jacobian(at, z, rest)
    hessian = jacobian.T @ jacobian + np.eye(z.size)
    distance2 = float(rest @ rest)
    evidence = -0.5 * distance2 - 0.5 * float(z @ z) - 0.5 * float(np.linalg.slogdet(hessian)[1])
    found = middle + root @ z
    spread = np.linalg.inv(hessian)
    off = yield from _off(problem, candidates, found, rest)
    moved = spread @ jacobian.T @ off
    spread = root @ (spread + moved @ moved.T) @ root.T
    return Fit(candidates, found[:count], spread[:count, :count], at(z), distance2, evidence, found[count:])


def _off(problem: Problem, candidates: Sequence[Candidate], places: Array, rest: Array) -> Asking[Array]:
    """Whitened errors (m, k) of the change that each of k effects makes as a whole: the model error's share of it.

    places, rest: coordinates of effects and freedoms, and whitened residuals there.
    """
    inexact, setups = [], []
    for candidate, own in _with_places(candidates):
        error = problem.states.model_error(candidate.kind)
        if error > 0.0:
            others = [one for one in candidates if one is not candidate]
            setups.append(placed(problem, others, np.delete(places, own)))
            inexact.append(error)
    without = (yield setups) if setups else []
    return np.column_stack(
        [np.zeros((rest.size, 0)), *(e * (one - rest) for e, one in zip(inexact, without, strict=True))]
    )


def _starts(candidates: Sequence[Candidate]) -> list[Array]:
    if not candidates:
        return [np.zeros(0)]
    if len(candidates) == 1:
        return candidates[0].starts()
    return [np.concatenate([candidate.starts()[1] for candidate in candidates])]


def _descend(
    at: Callable[[Array], SurrogateInputs], start: Array, iterations: int, ends: tuple[Array, Array]
) -> Asking[tuple[float, Array, Array]]:
    """Levenberg–Marquardt on the residual and the prior, from one start, between the ends of the parameters' ranges.

    Steps of at most one deviation keep it from the ends of the ranges, where scipy's trust region was seen to stay.
    """
    z = start.astype(float)
    (rest,) = yield [at(z)]
    cost = float(rest @ rest + z @ z)
    damping, jacobian = 1e-3, None
    for _ in range(iterations):
        if jacobian is None:
            jacobian = yield from _jacobian(at, z, rest)
        normal = jacobian.T @ jacobian + np.eye(z.size)
        step = np.linalg.solve(normal + damping * np.diag(np.diag(normal)), -(jacobian.T @ rest + z))
        step *= min(1.0, 1.0 / max(float(np.abs(step).max()), 1e-12))
        trial = np.clip(z + step, *ends)
        (trial_rest,) = yield [at(trial)]
        trial_cost = float(trial_rest @ trial_rest + trial @ trial)
        if trial_cost < cost:
            gained, z, rest, cost = cost - trial_cost, trial, trial_rest, trial_cost
            damping, jacobian = 0.2 * damping, None
            if gained < _CONVERGED:
                break
        else:
            damping = max(10.0 * damping, 1e-2)
            if damping > 1e6:
                break
    return cost, z, rest


def _jacobian(at: Callable[[Array], SurrogateInputs], z: Array, rest: Array) -> Asking[Array]:
    # Away from the bound, so that the steps are never clipped.
    steps = np.where(z > 0.0, -_STEP, _STEP)
    moved = z + np.diag(steps)
    rests = yield [at(one) for one in moved]
    return np.stack(
        [(own - rest) / (to[i] - z[i]) for i, (own, to) in enumerate(zip(rests, moved, strict=True))], axis=1
    )


def _whitening(covariance: Array) -> Array:
    scale = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(scale, scale) + 1e-9 * np.eye(scale.size)
    return np.asarray(solve_triangular(np.linalg.cholesky(correlation), np.eye(scale.size), lower=True) / scale)
