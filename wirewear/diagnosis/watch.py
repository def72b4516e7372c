"""A test watched while it runs: looks at the loops so far, and alarms at a stated rate.

A look diagnoses the loops so far. Its Bayes factor B is the odds that there is a gap over the odds beforehand. If there
is none, B is 1 in the mean, so that it reaches 1/p in at most the share p of such tests (Markov's inequality). The k-th
look may take alarm_rate/(k (k + 1)) of the rate; over all looks these shares sum up to it, however many there are.
Dividing log evidences by a temperature above 1 makes B smaller in the mean (Jensen's inequality).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, log, log1p

from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.infer.search import search
from wirewear.diagnosis.infer.weighing import PRIOR_NONE, Weighed
from wirewear.diagnosis.preparation import Nominal, PreparedRecord, prepared
from wirewear.diagnosis.record_diagnosis import judged
from wirewear.diagnosis.surrogate.inputs import UM3_PER_MJ
from wirewear.diagnosis.surrogate.nominal import ObserverOf
from wirewear.records import AnyRecord
from wirewear.records.values import MeasuredLoop

_KNOWN = constants("watch")

ALARM_RATE = _KNOWN.number("alarm_rate")  #: Alarms in a test without a gap, at most.

#: The next look is so much of the test later, or at so many times the cycle.
SHARE, GROWTH = _KNOWN.each("share", "growth")


@dataclass(frozen=True)
class Look:
    """Answer after the loops up to one: `verdict` and `sentence` as in a diagnosis, and what the leading causes are.

    number: of the look, from 1. clock: local date and time of the look. log_odds: logarithm of the Bayes factor for a
    gap. threshold: what an alarm needs.
    """

    number: int
    repeat: int
    cycle: int
    clock: str
    log_odds: float
    threshold: float
    verdict: str
    sentence: str
    causes: tuple[str, ...]

    @property
    def alarms(self) -> bool:
        return self.log_odds >= self.threshold


def threshold(number: int, alarm_rate: float = ALARM_RATE) -> float:
    """Logarithm of the Bayes factor at which the look of this number alarms."""
    return log(number * (number + 1) / alarm_rate)


def looks_among(loops: Sequence[MeasuredLoop], cycles: int) -> list[int]:
    """Places of the loops after which a look is due: the first loop of each repeat, and then those that come 2 % of the
    test's `cycles` or twice the cycle after the last look.
    """
    found: list[int] = []
    for place, loop in enumerate(loops):
        last = loops[found[-1]] if found else None
        if loop.cycle > 0 and (
            last is None
            or last.repeat != loop.repeat
            or loop.cycle >= min(GROWTH * last.cycle, last.cycle + SHARE * cycles)
        ):
            found.append(place)
    return found


@dataclass(frozen=True, eq=False)
class Watched:
    """A test with its nominal model, which the first look computes."""

    first: PreparedRecord
    nominal: Nominal

    @classmethod
    def of(cls, record: AnyRecord, observer_of: ObserverOf | None = None) -> Watched:
        """The test of a record; what it leaves unstated is taken from the loops that it holds. Raises as `diagnose`
        does.
        """
        (first,) = prepared(record)
        return cls(first, first.nominal(observer_of))

    @property
    def wear_mm3_per_J(self) -> float:
        """Worn volume of both bodies per friction energy that is expected."""
        return self.nominal[1].wear_um3_per_mJ / UM3_PER_MJ

    def look(self, loops: Sequence[MeasuredLoop], number: int, alarm_rate: float = ALARM_RATE, clock: str = "") -> Look:
        """Look at all loops so far. Raises RecordError if nothing can be concluded from them."""
        record = replace(self.first.record, loops=tuple(loops), evolution=(), scars=())
        own = replace(self.first, record=record).reduced(nominal=self.nominal)
        found = search(own.states, own.setup, own.observed, own.unfit)
        diagnosed = judged(own.record, own.study, own.states, own.observed, found)
        answer, last = diagnosed.diagnosis, loops[-1]
        leading = tuple(cause.effect for cause in answer.causes[:1] if answer.verdict != "no_gap")
        if leading and answer.causes[0].joint:
            leading = tuple(sorted(cause.effect for cause in answer.causes[:2]))
        return Look(
            number,
            last.repeat,
            last.cycle,
            clock,
            log_odds(diagnosed.weighed),
            threshold(number, alarm_rate),
            answer.verdict,
            answer.sentence,
            leading,
        )


def no_look(loop: MeasuredLoop, number: int, alarm_rate: float, clock: str, reason: str) -> Look:
    """The look of a number after a loop, where nothing can be concluded for a reason."""
    return Look(number, loop.repeat, loop.cycle, clock, -inf, threshold(number, alarm_rate), "", reason, ())


def log_odds(weighed: Weighed) -> float:
    """Logarithm of the Bayes factor for a gap, from the probability that there is none."""
    none = weighed.probabilities[()]
    if none >= 1.0:
        return -inf
    # Below this a probability has no digits left.
    return log1p(-none) - log(max(none, 1e-300)) - log((1.0 - PRIOR_NONE) / PRIOR_NONE)
