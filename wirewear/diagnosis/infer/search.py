"""The search for causes: all effects alone, then pairs, updated by further records of the same rig.

An explanation is no effect, one effect or a pair, with its fit. What a record leaves open of its parameters is the
prior for the next record (sequential Bayes, by Laplace's approximation), so that an explanation must hold on both with
the same parameters.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations, product

import numpy as np

from geometry.arrays import Array
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.infer.covariance import Covariance
from wirewear.diagnosis.infer.distortions import Distortion, distortions
from wirewear.diagnosis.infer.inference import (
    ITERATIONS,
    Fit,
    Problem,
    applied,
    placed,
    problem_around,
    sought,
    together,
)
from wirewear.diagnosis.infer.resembling import Imitation, imitations
from wirewear.diagnosis.infer.weighing import LEAST_DISPERSION, NOTICEABLE, Remainder, distances, remainder_of
from wirewear.diagnosis.observe.reduction import Observations
from wirewear.diagnosis.surrogate.candidates import considered
from wirewear.diagnosis.surrogate.inputs import SurrogateInputs
from wirewear.diagnosis.surrogate.wear_states import WearStates

_KNOWN = constants("infer.search")

#: Log evidence that a second effect must gain, per misfit of the first, as evidence is weighed. One is always looked
#: for: a first may leave no more than is expected, as expectations are wide, and a second one still gain forty.
PAIR_GAIN = _KNOWN.number("pair_gain")

#: Pairs whose log evidence lies so far below that of the best are left out.
_PAIRS_WITHIN = _KNOWN.number("pairs_within")

#: Steps of a search that only screens; second effects that are then fitted jointly with the first, and so many that are
#: for what they explain alone.
_SCREENING, _SECONDS, _LIKELY = _KNOWN.count("screening"), _KNOWN.count("seconds"), _KNOWN.count("likely")

#: Distortions are tried beside so many of the likeliest explanations, and beside none.
_DISTORTED = _KNOWN.count("distorted")

#: Scars alone: an effect shows whose coordinates a fit moves by so much.
_SHOWN = _KNOWN.number("shown")

#: Scars alone: coordinates from which joint fits begin, and their steps.
_PLACES, _FEW_ITERATIONS = _KNOWN.numbers("places"), _KNOWN.count("few_iterations")

#: Explanations so many times the best's log evidence below it are hopeless.
_HOPELESS = _KNOWN.number("hopeless")


@dataclass(frozen=True, eq=False)
class Search:
    """Result of the search for causes.

    problem, covariance: as at the best explanation. none, singles, pairs: fits without effects, of each effect alone,
    and of the pairs that beat them. remainder: the misfit that the best explanation leaves. distortions: families of
    distortions beside the likeliest explanations.
    """

    problem: Problem
    covariance: Covariance
    none: Fit
    singles: tuple[Fit, ...]
    pairs: tuple[Fit, ...]
    remainder: Remainder
    distortions: tuple[Distortion, ...]

    @property
    def best(self) -> Fit:
        """The fit of largest log evidence among no effect, single effects and pairs."""
        return max((self.none, *self.singles, *self.pairs), key=lambda one: one.merit)

    @property
    def removed(self) -> float:
        """Share of the χ² without effects that the best explanation removes; 0 if that χ² is 0."""
        return 1.0 - self.best.distance2 / self.none.distance2 if self.none.distance2 > 0.0 else 0.0

    def left(self, one: Fit) -> float:
        """Share that an explanation leaves of the excess of χ² without effects over the number of observables; 0
        without an excess.
        """
        beyond = self.none.distance2 - self._numbers
        return max(one.distance2 - self._numbers, 0.0) / beyond if beyond > 0.0 else 0.0

    @property
    def _numbers(self) -> int:
        return self.problem.mean.size

    def apart(self, fits: Sequence[Fit]) -> Array:
        """Distances (k, k) between k fits in standard deviations, see `distances`."""
        return distances(self.problem, fits)

    def imitated(self, one: Fit) -> tuple[Imitation, ...]:
        """Causes of no library that the record cannot tell from the effects of a fit, see `imitations`."""
        return imitations(self.problem, one)


def search(states: WearStates, setup: SurrogateInputs, observed: Observations, left_out: Sequence[str] = ()) -> Search:
    """Search for the causes of the differences between a record's observables and its nominal model. setup, states:
    nominal inputs and wear states. left_out: names of effects that are not considered.
    """
    scars = any(part.observable.of_scars for part in observed.layout)
    effects = considered(setup, states, left_out, scars=scars)
    problem, covariance = problem_around(states, setup, setup, observed)
    none, *singles = together(problem, [sought(problem, own) for own in ((), *((effect,) for effect in effects))])
    best = max((none, *singles), key=lambda one: one.merit)
    around: list[tuple[str, ...]] = [()]
    # An explanation is judged by the covariance around it: taken again until the leader stays, or leads for the second
    # time.
    while best.log_evidence > none.log_evidence + NOTICEABLE and best.names not in around:
        first = best
        around.append(first.names)
        problem, covariance = problem_around(states, setup, first.setup, observed, first.candidates, problem)
        none, *singles = _refitted(problem, singles, first)
        best = max((none, *singles), key=lambda one: one.merit)
    tried: list[Fit] = []
    pairs: list[Fit] = []
    if best.candidates:
        alone = problem, covariance, none, singles
        tried = pair_fits(problem, none, singles)
        enough = max(one.log_evidence for one in singles) + gain_needed(problem, best)
        pairs = [one for one in tried if one.log_evidence > enough]
        pairs = [one for one in pairs if pairs[0].log_evidence - one.log_evidence < _PAIRS_WITHIN]
        if pairs:
            problem, covariance = problem_around(states, setup, pairs[0].setup, observed, pairs[0].candidates, problem)
            none, *singles = _refitted(problem, singles, best)
            single = max((none, *singles), key=lambda one: one.merit)
            pairs = together(problem, [sought(problem, one.candidates, [one.places]) for one in pairs])
            enough = single.log_evidence + gain_needed(problem, single)
            pairs = [one for one in pairs if one.log_evidence > enough]
        if not pairs:
            problem, covariance, none, singles = alone
    chosen, beside = leading(none, (*singles, *pairs))
    distorted = distortions(problem, beside)
    left = remainder_of(problem, chosen)
    return Search(problem, covariance, none, tuple(singles), tuple(pairs), left, distorted)


def gain_needed(problem: Problem, one: Fit) -> float:
    """Log evidence that a second effect must gain beside the explanation `one`: in proportion to the misfit that this
    leaves, from `LEAST_DISPERSION` up to 1, as more may be left because the second effect is missing.
    """
    return PAIR_GAIN * min(max(one.distance2 / problem.mean.size, LEAST_DISPERSION), 1.0)


def leading(none: Fit, others: Sequence[Fit]) -> tuple[Fit, tuple[Fit, ...]]:
    """The fit of largest evidence among `none` and `others`, and the fits beside which distortions are tried: `none`
    and the `_DISTORTED` best of `others`.
    """
    ordered = sorted(others, key=lambda one: -one.merit)
    return max((none, *ordered[:1]), key=lambda one: one.merit), (none, *ordered[:_DISTORTED])


def _refitted(problem: Problem, singles: Sequence[Fit], best: Fit) -> list[Fit]:
    """None, and all again under another covariance: from where they were, and the better ones from all starts."""
    asked = [sought(problem, ())]
    for one in singles:
        hopeless = best.log_evidence - one.log_evidence > _HOPELESS * abs(best.log_evidence)
        starts = [one.places] if hopeless else [one.places, *one.candidates[0].starts()]
        asked.append(sought(problem, one.candidates, starts, _SCREENING if hopeless else ITERATIONS))
    return together(problem, asked)


def pair_fits(problem: Problem, none: Fit, singles: Sequence[Fit]) -> list[Fit]:
    """Fits of the likeliest single effect with each second one that promises something, and of the next likely ones
    with one another, best first. none, singles: fits without effects and of each effect alone.
    """
    ordered = sorted(singles, key=lambda one: -one.merit)
    first = ordered[0]
    # With the first effect in place, a few steps show which second ones are worth a joint fit.
    beside = replace(problem, setup=first.setup)
    others = [one for one in singles if one.names != first.names]
    rough = together(beside, [sought(beside, one.candidates, iterations=_SCREENING) for one in others])
    needed = gain_needed(problem, first)
    enough = -0.5 * first.distance2 + 0.5 * needed
    screened = [pair for pair in zip(rough, others, strict=True) if pair[0].log_evidence > enough]
    screened.sort(key=lambda pair: -pair[0].merit)
    alone = all(part.observable.of_scars for part in problem.layout)
    if alone:
        # Effects that shape a scar together need not show beside the first as it is; what scars never show stays out.
        chosen = [(one, one) for one in others if np.abs(one.coordinates).max() > _SHOWN]
    else:
        # The first effect, bent to do for both, may hide those that explain much by themselves.
        likely = [one for one in ordered[: _LIKELY + 1] if one.log_evidence > none.log_evidence + needed]
        chosen = [*screened[:_SECONDS], *((one, one) for one in likely[1:])]
    asked = [(first, started, one) for started, one in chosen]
    if not alone:
        # The best single effect may be one that imitates two others together.
        asked += [(one, other, other) for one, other in combinations(likely[1:], 2)]
    joint = [
        sought(
            problem,
            (*one.candidates, *other.candidates),
            _joint_starts(one, started, alone),
            _FEW_ITERATIONS if alone else ITERATIONS,
        )
        for one, started, other in asked
    ]
    found = together(problem, joint)
    best: dict[tuple[str, ...], Fit] = {}
    for one in sorted(found, key=lambda one: -one.merit):
        best.setdefault(one.names, one)
    return [*best.values()]


def _joint_starts(first: Fit, second: Fit, alone: bool) -> list[Array]:
    """Where a joint fit begins: at both as they were found, and, of scars alone, at places all over both ranges.

    A scar that two effects shape together may look like another size of one of them; its few depths are soon computed.
    """
    found = [np.concatenate([first.coordinates, second.coordinates, first.free])]
    if alone:
        # Forms begin as their source has them: places of theirs, too, would be thousands.
        both = (*first.candidates, *second.candidates)
        places = [(0.0,) if name in one.forms else _PLACES for one in both for name in one.unknowns]
        found += map(np.array, product(*places))
    return found


@dataclass(frozen=True, eq=False)
class Updated(Search):
    """A search on a first record, updated by others; its fits are those of all records together.

    further: the problems of the other records. before: for each of these, the fits that were its priors.
    """

    further: tuple[Problem, ...] = ()
    before: tuple[tuple[Fit, ...], ...] = ()

    @property
    def _numbers(self) -> int:
        return super()._numbers + sum(problem.mean.size for problem in self.further)

    def apart(self, fits: Sequence[Fit]) -> Array:
        """Distances (k, k) between k fits by all records together, in standard deviations: root of the sum of their
        squares.
        """
        squares = super().apart(fits) ** 2
        for problem, before in zip(self.further, self.before, strict=True):
            known = {one.names: one for one in before}
            carried = [_carried(problem, one) for one in fits]
            squares += distances(problem, carried, [known[one.names] for one in fits]) ** 2
        return np.sqrt(squares)

    def imitated(self, one: Fit) -> tuple[Imitation, ...]:
        """Causes of no library that none of the records can tell from the effects of a fit."""
        found = super().imitated(one)
        for problem in self.further:
            also = {own.family for own in imitations(problem, _carried(problem, one))}
            found = tuple(own for own in found if own.family in also)
        return found


def updated(first: Search, states: WearStates, setup: SurrogateInputs, observed: Observations) -> Search:
    """The search updated by another record: `observed` are its observables, `setup` and `states` its nominal setup and
    wear states.
    """
    around = applied(first.best.candidates, setup, first.best.coordinates)
    problem, _ = problem_around(states, setup, around, observed, first.best.candidates)
    fits = (first.none, *first.singles, *first.pairs)
    asked = [sought(problem, one.candidates, known=one if one.candidates else None) for one in fits]
    second = {one.names: one for one in together(problem, asked)}

    def both(one: Fit) -> Fit:
        own = second[one.names]
        together = placed(first.problem, one.candidates, np.concatenate([own.coordinates, one.free]))
        white = first.problem.whitened(together)
        return replace(
            own,
            setup=together,
            distance2=float(white @ white) + own.distance2,
            log_evidence=one.log_evidence + own.log_evidence,
            free=one.free,
        )

    none, singles, pairs = both(first.none), tuple(map(both, first.singles)), tuple(map(both, first.pairs))
    chosen, beside = leading(none, (*singles, *pairs))
    seen = distortions(problem, [second[one.names] for one in beside])
    lefts = remainder_of(first.problem, chosen), remainder_of(problem, second[chosen.names])
    earlier = first if isinstance(first, Updated) else None
    return Updated(
        first.problem,
        first.covariance,
        none,
        singles,
        pairs,
        max(lefts, key=lambda left: (left.log_surprise, left.misfit)),
        _together(distortions(first.problem, beside), seen),
        (*(earlier.further if earlier else ()), problem),
        (*(earlier.before if earlier else ()), fits),
    )


def _carried(problem: Problem, one: Fit) -> Fit:
    """An explanation in the circumstances of another record."""
    setup = applied(one.candidates, problem.setup, one.coordinates)
    return replace(one, setup=setup, free=np.zeros(len(problem.free)))


def _together(first: Sequence[Distortion], second: Sequence[Distortion]) -> tuple[Distortion, ...]:
    """Distortions of a first record, each with its gain on a second record added; each has sizes of its own there."""
    more = {(one.family.seam, one.family.name, one.beside.names): one.gain for one in second}
    found = []
    for one in first:
        added = more.get((one.family.seam, one.family.name, one.beside.names), 0.0)
        found.append(replace(one, gain=one.gain + added, log_evidence=one.log_evidence + added))
    return tuple(sorted(found, key=lambda one: -one.log_evidence))
