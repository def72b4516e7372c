"""From fits to probabilities: classes of effects that a record cannot distinguish, prior beliefs, and what an
explanation leaves.

An explanation is a tuple of effects' names, () for no gap. A class is a tuple of effects' names that cannot be
distinguished; each effect belongs to one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import combinations
from math import e, expm1, hypot, log, log1p, sqrt
from typing import Literal

import numpy as np
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.spatial.distance import squareform
from scipy.special import chdtrc

from geometry.arrays import Array
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.infer.covariance import SHARED, Covariance, derivatives
from wirewear.diagnosis.infer.inference import SEPARATION_ITERATIONS, Fit, Problem, sought, together
from wirewear.diagnosis.observe.reduction import Part

_KNOWN = constants("infer.weighing")

#: Two effects closer than this, in standard deviations, are one class: 1 in 1000 by chance.
SEPARABLE = _KNOWN.number("separable")

#: Belief before looking: that there is no gap, that its cause is in no library; the rest goes to the classes.
PRIOR_NONE, PRIOR_OUTSIDE = _KNOWN.each("prior_none", "prior_outside")

#: A pair is as improbable beforehand as two independent single causes: this share of their belief, over all pairs.
PRIOR_PAIR = _KNOWN.number("prior_pair")

#: Log evidences are divided by this: the covariance is not known well enough to believe in every unit of chi-square.
TEMPERATURE = _KNOWN.number("temperature")

#: Evidence counts for more where less is left than is expected, down to this share of it.
LEAST_DISPERSION = _KNOWN.number("least_dispersion")

#: Log evidence that an explanation must gain to be noticed, and that a distortion must lead the library by: on tests
#: unlike those that solver differences were learned on, known effects and records without a gap are led by so much.
NOTICEABLE = _KNOWN.number("noticeable")

#: A class of effects accounts for a gap alone from this probability on.
SURE = _KNOWN.number("sure")

#: Log evidence below the best's from which on an effect is not compared with it, and how many are at most.
_NEGLIGIBLE, _MOST_COMPARED = _KNOWN.number("negligible"), _KNOWN.count("most_compared")

_OF_GATE = constants("infer.weighing.gate")

#: Standard deviation of the logarithm by which the variance of one observable's solver differences lies above or below
#: the learned one, from test to test.
SCALE = _OF_GATE.number("scale")

#: Places and weights of a normal deviate, for means over it.
_PLACES, _WEIGHTS = np.polynomial.hermite_e.hermegauss(_OF_GATE.count("places"))


@dataclass(frozen=True)
class Weighed:
    """Probabilities of the explanations, and of a cause outside the library (`outside`); together they are 1.

    A cause of no library that acts just like a known effect has no share of its own: how often such causes occur, no
    record shows. classes: names of effects in groups that the record cannot tell apart. beside: part of `outside` in
    which an explanation acts together with such a cause, by explanation.
    """

    probabilities: Mapping[tuple[str, ...], float]
    outside: float
    classes: tuple[tuple[str, ...], ...]
    beside: Mapping[tuple[str, ...], float] = field(default_factory=dict)

    @property
    def verdict(self) -> Literal["no_gap", "explained", "ambiguous", "unexplained"]:
        """The most probable of no gap, a cause outside the library ("unexplained"), and a class of effects or pair,
        which is "explained" from a probability of `SURE` on, else "ambiguous".
        """
        none, leading = self.probabilities[()], self.leading
        if none >= max(leading, self.outside):
            return "no_gap"
        if self.outside >= leading:
            return "unexplained"
        return "explained" if leading >= SURE else "ambiguous"

    @property
    def leading(self) -> float:
        """Probability of the likeliest class of effects or pair; 0 if there is none."""
        return max((self.mass(names) for names in self.probabilities if names), default=0.0)

    def mass(self, names: tuple[str, ...]) -> float:
        """Probability of an explanation and of all that cannot be distinguished from it."""
        return self._masses[self._classes(names)]

    def refuted(self, names: tuple[str, ...]) -> Weighed:
        """A copy in which the probability of an explanation, and of all of the same classes of effects, goes to a cause
        outside the library.
        """
        own = self._classes(names)
        kept = {one: 0.0 if self._classes(one) == own else p for one, p in self.probabilities.items()}
        return replace(self, probabilities=kept, outside=self.outside + self.mass(names))

    def withdrawn(self, names: tuple[str, ...]) -> Weighed:
        """A copy in which the probability of an explanation, and of all of the same classes of effects, goes to no gap,
        with what `beside` holds of them.
        """
        own = self._classes(names)
        gone = {one: p for one, p in self.probabilities.items() if one and self._classes(one) == own}
        beside = sum(self.beside.get(one, 0.0) for one in gone)
        kept = {**self.probabilities, **dict.fromkeys(gone, 0.0)}
        kept[()] += sum(gone.values()) + beside
        left = {one: p for one, p in self.beside.items() if one not in gone}
        return replace(self, probabilities=kept, outside=max(self.outside - beside, 0.0), beside=left)

    def with_remainder(self, names: tuple[str, ...]) -> Weighed:
        """A copy for an explanation that may act together with an unknown cause: `names`, and all explanations of the
        same classes, gain the probabilities that `beside` holds of them, which `outside` loses.
        """
        own = self._classes(names)
        credited = {one: p for one, p in self.beside.items() if one and self._classes(one) == own}
        kept = {one: p + credited.get(one, 0.0) for one, p in self.probabilities.items()}
        return replace(self, probabilities=kept, outside=max(self.outside - sum(credited.values()), 0.0), beside={})

    def _classes(self, names: tuple[str, ...]) -> tuple[tuple[str, ...], ...]:
        return tuple(sorted(map(self.class_of, names)))

    @cached_property
    def _masses(self) -> Mapping[tuple[tuple[str, ...], ...], float]:
        found: dict[tuple[tuple[str, ...], ...], float] = {}
        for names, probability in self.probabilities.items():
            own = self._classes(names)
            found[own] = found.get(own, 0.0) + probability
        return found

    def without_gap(self) -> Weighed:
        """A copy in which no gap has the probability 1, for differences within the tolerance."""
        return replace(self, probabilities={names: float(not names) for names in self.probabilities}, outside=0.0)

    def class_of(self, name: str) -> tuple[str, ...]:
        """The class, of effects that the record cannot tell apart, to which the effect `name` belongs; the name alone
        if none has it.
        """
        return next((members for members in self.classes if name in members), (name,))


def distances(problem: Problem, fits: Sequence[Fit], known: Sequence[Fit] = ()) -> Array:
    """Distances (k, k) between k fits: χ, in standard deviations, that the effects of one leave at best of the
    prediction of the other; the larger of both directions.

    Infinite for fits that do not differ in exactly one effect. known: fits to another record, whose distributions are
    the priors of the effects' coordinates; by default their expected sizes.
    """
    count = len(fits)
    matrix = np.full((count, count), np.inf)
    np.fill_diagonal(matrix, 0.0)
    for i, one in enumerate(fits):
        others = [j for j, other in enumerate(fits) if i != j and _differing(one, other)]
        twin = replace(problem, mean=problem.predicted(one.setup))
        near = together(
            twin,
            [
                sought(twin, fits[j].candidates, [fits[j].places], SEPARATION_ITERATIONS, known[j] if known else None)
                for j in others
            ],
        )
        matrix[i, others] = np.sqrt([other.distance2 for other in near])
    symmetric: Array = np.maximum(matrix, matrix.T)
    return symmetric


def relevant(fits: Sequence[Fit]) -> list[Fit]:
    """Fits with a log evidence within `_NEGLIGIBLE` of the largest, best first, at most `_MOST_COMPARED`."""
    ordered = sorted(fits, key=lambda one: -one.merit)
    near = [one for one in ordered if ordered[0].log_evidence - one.log_evidence < _NEGLIGIBLE]
    return near[:_MOST_COMPARED]


def _differing(one: Fit, other: Fit) -> tuple[str, str] | None:
    """The effects in which two fits of as many differ, if in one alone."""
    apart, others = (tuple(name for name in a.names if name not in b.names) for a, b in ((one, other), (other, one)))
    return (apart[0], others[0]) if len(apart) == len(others) == 1 else None


def classes_of(fits: Sequence[Fit], matrix: Array) -> tuple[tuple[str, ...], ...]:
    """Classes of effects by complete linkage: all members of one are closer to each other than `SEPARABLE`.

    fits: single effects and pairs. matrix: (k, k), their `distances`. Distances between pairs that share an effect
    count before those between the effects alone.
    """
    names = [*dict.fromkeys(name for one in fits for name in one.names)]
    apart = np.where(np.eye(len(names)) > 0.0, 0.0, 1e6)
    # What pairs show of two effects counts for more than what each shows alone.
    for i, j in sorted(combinations(range(len(fits)), 2), key=lambda both: len(fits[both[0]].names)):
        if (both := _differing(fits[i], fits[j])) and np.isfinite(matrix[i, j]):
            a, b = map(names.index, both)
            apart[a, b] = apart[b, a] = matrix[i, j]
    labels = np.ones(len(names), dtype=int)
    if len(names) > 1:
        below = np.nextafter(SEPARABLE, 0.0)
        labels = fcluster(linkage(squareform(apart), method="complete"), below, criterion="distance")
    return tuple(
        tuple(name for name, own in zip(names, labels, strict=True) if own == label)
        for label in dict.fromkeys(labels.tolist())
    )


def weigh(
    none: Fit,
    singles: Sequence[Fit],
    joint: Sequence[Fit],
    classes: Sequence[Sequence[str]],
    dispersion: float,
    log_surprise: float,
    gains: Mapping[tuple[str, ...], Sequence[float]] | None = None,
) -> Weighed:
    """Probabilities of all explanations, and of a cause outside the library.

    none, singles, joint: fits without effects, of single effects and of pairs. dispersion: misfit of the best, by which
    log evidences are divided beside `TEMPERATURE`: it estimates by how much all variances are larger or smaller than
    expected, as in a quasi-likelihood (McCullagh and Nelder, Generalized Linear Models, 1989, section 9.2).
    log_surprise: log Bayes factor by which the best explanation leaves more than chance would; 0 for none. gains: log
    evidence that each family of distortions adds to an explanation, by its effects' names; a cause outside the library
    counts by what they exceed `NOTICEABLE`.
    """
    temperature = TEMPERATURE * dispersion
    explained = 1.0 - PRIOR_NONE - PRIOR_OUTSIDE
    groups = [tuple(group) for group in classes]
    grouped = {name for group in groups for name in group}
    groups += [(one.names[0],) for one in singles if one.names[0] not in grouped]
    logs: dict[tuple[str, ...], float] = {(): np.log(PRIOR_NONE) + none.log_evidence / temperature}
    by_name = {one.names[0]: one for one in singles}
    for group in groups:
        weights = {name: by_name[name].candidates[0].kind.prior_weight for name in group}
        for name in group:
            prior = explained / len(groups) * weights[name] / sum(weights.values())
            logs[name,] = np.log(prior) + by_name[name].log_evidence / temperature
    for one in joint:
        prior = PRIOR_PAIR * explained / max(len(groups) * (len(groups) - 1) / 2, 1)
        logs[one.names] = np.log(prior) + one.log_evidence / temperature
    together: dict[tuple[str, ...], float] = {}
    for names, added in (gains or {}).items():
        beside = np.log(PRIOR_OUTSIDE / (1.0 - PRIOR_OUTSIDE)) - np.log(len(added))
        # What it adds it adds to its own explanation, and with the belief in that: beside none it need not be accepted
        # together with whatever effect happens to lead.
        together[names] = logs[names] + beside + np.logaddexp.reduce((np.array(added) - NOTICEABLE) / temperature)
    if log_surprise > 0.0:
        beside = np.log(PRIOR_OUTSIDE / explained) + np.log(np.expm1(log_surprise / TEMPERATURE))
        leading = max(logs, key=lambda names: logs[names])
        together[leading] = np.logaddexp(together.get(leading, -np.inf), logs[leading] + beside)
    total = float(np.logaddexp.reduce([*logs.values(), *together.values()]))
    probabilities, outside = (
        {names: float(np.exp(value - total)) for names, value in known.items()} for known in (logs, together)
    )
    return Weighed(probabilities, sum(outside.values()), tuple(groups), outside)


def leading_fit(weighed: Weighed, none: Fit, explained: Sequence[Fit]) -> Fit:
    """The fit that explains most of those of the likeliest class of effects or pair; `none` if there are no others."""
    fits = [one for one in explained if weighed.mass(one.names) == weighed.leading]
    return max(fits, key=lambda one: one.merit, default=none)


@dataclass(frozen=True)
class ForceZero:
    """Mean zero error of the force channel over all repeats.

    value_N: in N. deviations: the error over its expected standard deviation.
    """

    value_N: float
    deviations: float

    @property
    def stands_out(self) -> bool:
        """True if the zero error exceeds `SEPARABLE` expected standard deviations."""
        return abs(self.deviations) > SEPARABLE


def force_zero(problem: Problem, covariance: Covariance, one: Fit, repeats: int) -> ForceZero:
    """Mean zero error of the force channel, from the residuals that the explanation `one` leaves; repeats: how many the
    record has. It is a normal deviate beforehand, so that its mean afterwards is its variance times its column in Σ⁻¹
    r.
    """
    expected = hypot(SHARED["force_offset"], covariance.scatter["force_offset"] / sqrt(repeats))
    column = derivatives(problem.states, one.setup, problem.layout, {"force_offset": expected})[:, 0]
    deviations = float((problem.whitening @ column) @ problem.whitened(one.setup))
    return ForceZero(deviations * expected * problem.setup.load_N, deviations)


def log_surprise(p_value: float) -> float:
    """Natural logarithm of the largest Bayes factor against a hypothesis whose test has the p-value p; 0 if p ≥ 1/e.

    The Bayes factor for the hypothesis is at least −e p ln p (Sellke, Bayarri and Berger, Am. Stat. 55 (2001) 62, eq.
    2).
    """
    # Below this a chance has no digits left.
    p = max(p_value, 1e-300)
    return -log(-e * p * log(p)) if p < 1.0 / e else 0.0


@dataclass(frozen=True)
class Remainder:
    """Misfit that an explanation leaves.

    misfit: χ² per degree of freedom. block_p_value: smallest p-value of the observables, each as one block. blocks:
    their number.
    """

    misfit: float
    block_p_value: float
    blocks: int

    @property
    def log_surprise(self) -> float:
        """`log_surprise` of the smallest p-value, corrected for being the smallest of `blocks`."""
        return log_surprise(-expm1(self.blocks * log1p(-min(self.block_p_value, 0.5))))


def remainder_of(problem: Problem, one: Fit) -> Remainder:
    """Misfit that a fit leaves, as a whole and by observable."""
    residual = problem.mean - problem.predicted(one.setup)
    whitened = problem.whitening @ residual
    misfit = float(whitened @ whitened) / max(whitened.size - one.coordinates.size, 1)
    covariance = np.linalg.inv(problem.whitening.T @ problem.whitening)

    def p_value(part: Part) -> float:
        block, rest = covariance[part.rows, part.rows], residual[part.rows]
        return chance(float(rest @ np.linalg.solve(block, rest)), rest.size)

    return Remainder(misfit, min(map(p_value, problem.layout), default=1.0), len(problem.layout.parts))


def chance(squares: float, count: int, scale: float = SCALE) -> float:
    """Probability that χ² with `count` degrees of freedom is at least `squares`, if the variance itself is uncertain.
    scale: standard deviation of the logarithm of the variance: a posterior predictive p-value, the mean over it.
    """
    scaled = squares * np.exp(-scale * _PLACES)
    return float(_WEIGHTS @ chdtrc(count, scaled) / _WEIGHTS.sum())
