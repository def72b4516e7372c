"""What a further record of the same rig adds: evidence multiplies, and parameters are known from the records before.

What a record leaves open of an explanation's parameters is what is expected of them when the next one is looked at
(sequential Bayes, by Laplace's approximation), so that an explanation must hold on both with the same parameters.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from geometry.arrays import Array
from wirewear.diagnosis.infer.distortions import Distortion, distortions
from wirewear.diagnosis.infer.inference import Fit, Problem, applied, fit
from wirewear.diagnosis.infer.recognised import remainder_of
from wirewear.diagnosis.infer.search import Search, leading, problem_around
from wirewear.diagnosis.infer.weighing import distances
from wirewear.diagnosis.model.setup import Setup
from wirewear.diagnosis.model.wear_states import WearStates
from wirewear.diagnosis.observe.reduction import Observations


@dataclass(frozen=True, eq=False)
class Updated(Search):
    """A search on a first record, its fits those of all records; `further` are the problems of the others.

    `before` are the fits that each of these began with.
    """

    further: tuple[Problem, ...] = ()
    before: tuple[tuple[Fit, ...], ...] = ()

    def apart(self, fits: Sequence[Fit]) -> Array:
        """Distances (k, k) by all records."""
        squares = super().apart(fits) ** 2
        for problem, before in zip(self.further, self.before, strict=True):
            known = {one.names: one for one in before}
            carried = [_carried(problem, one) for one in fits]
            squares += distances(problem, carried, [known[one.names] for one in fits]) ** 2
        return np.sqrt(squares)


def updated(first: Search, states: WearStates, setup: Setup, observed: Observations) -> Search:
    """A search with what another record shows, in its own circumstances and on its own nominal run."""
    around = applied(first.best.candidates, setup, first.best.coordinates)
    problem, _ = problem_around(states, setup, around, observed, first.best.candidates)
    fits = (first.none, *first.singles, *first.pairs)
    second = {one.names: fit(problem, one.candidates, known=one if one.candidates else None) for one in fits}

    def both(one: Fit) -> Fit:
        own = second[one.names]
        together = applied(one.candidates, first.problem.setup, own.coordinates)
        white = first.problem.whitened(together)
        return replace(
            own,
            setup=together,
            distance2=float(white @ white) + own.distance2,
            log_evidence=one.log_evidence + own.log_evidence,
        )

    none, singles, pairs = both(first.none), tuple(map(both, first.singles)), tuple(map(both, first.pairs))
    chosen, beside = leading(none, (*singles, *pairs))
    seen = distortions(problem, [_carried(problem, one) for one in beside])
    lefts = remainder_of(first.problem, chosen), remainder_of(problem, _carried(problem, chosen))
    earlier = first if isinstance(first, Updated) else None
    return Updated(
        first.problem,
        first.covariance,
        none,
        singles,
        pairs,
        max(lefts, key=lambda left: (left.log_surprise, left.misfit)),
        _together(distortions(first.problem, beside), seen),
        chosen.log_evidence,
        (*(earlier.further if earlier else ()), problem),
        (*(earlier.before if earlier else ()), fits),
    )


def _carried(problem: Problem, one: Fit) -> Fit:
    """An explanation in the circumstances of another record."""
    return replace(one, setup=applied(one.candidates, problem.setup, one.coordinates))


def _together(first: Sequence[Distortion], second: Sequence[Distortion]) -> tuple[Distortion, ...]:
    """Those of a first record, with what the same adds on a second one; each has sizes of its own there."""
    more = {(one.family.seam, one.family.name, one.beside.names): one.gain for one in second}
    found = []
    for one in first:
        added = more.get((one.family.seam, one.family.name, one.beside.names), 0.0)
        found.append(replace(one, gain=one.gain + added, log_evidence=one.log_evidence + added))
    return tuple(sorted(found, key=lambda one: -one.log_evidence))
