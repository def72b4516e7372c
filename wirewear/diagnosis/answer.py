"""The answer of a diagnosis as a value, and as JSON."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from importlib.metadata import version
from math import floor
from typing import Any, Literal

import numpy as np

from geometry.arrays import Array
from wirewear.base.cache import code_hash
from wirewear.diagnosis.calibration import constants, digest
from wirewear.diagnosis.infer.inference import REACH, Fit
from wirewear.diagnosis.infer.resembling import Imitation, Resemblance
from wirewear.diagnosis.infer.search import Search
from wirewear.diagnosis.infer.shrink import Shrink
from wirewear.diagnosis.infer.weighing import Weighed
from wirewear.diagnosis.infer.where import GapFinding, Place, Relevance, findings
from wirewear.diagnosis.surrogate.candidates import Candidate
from wirewear.effects import Parameter
from wirewear.records.remarks import Remark

FORMAT = 1

_KNOWN = constants("answer")

#: By how much intervals are wider than their fit says, so that as many hold as they state: of some effects, of others.
_STRETCH = _KNOWN.number("stretch")

#: An explanation that fails, but takes this share of χ², is named as a part of one.
LEAST_REMOVED = _KNOWN.number("least_removed")

#: Explanations less probable than this are not listed.
LEAST_LISTED = _KNOWN.number("least_listed")

Verdict = Literal["no_gap", "explained", "ambiguous", "unexplained"]


@dataclass(frozen=True)
class Estimate:
    """Value of a parameter with its 95 % interval, in the parameter's unit."""

    value: float
    interval95: tuple[float, float]


def estimates(candidate: Candidate, coordinates: Array, deviations: Array, dispersion: float) -> dict[str, Estimate]:
    """Parameters of a fitted effect by name, with 95 % intervals.

    coordinates, deviations: (p,) of the fit and their standard deviations. dispersion: factor on the variances by the
    fit's misfit. Intervals are also widened by the calibrated factor. Held parameters have their expected value and
    range.
    """
    found, stretch = {}, _STRETCH
    for i, (name, parameter) in enumerate(candidate.parameters.items()):
        spread = stretch * deviations[i] * dispersion**0.5
        reach = 1.96 * float(np.hypot(spread, candidate.unknown_spread(name, float(coordinates[i]))))
        found[name] = _estimate(parameter, float(coordinates[i]), reach)
    for name, parameter in candidate.held.items():
        found[name] = Estimate(parameter.value(0.0), parameter.interest)
    return found


def forms(candidate: Candidate, coordinates: Array, deviations: Array, dispersion: float) -> dict[str, Estimate]:
    """Numbers of a fitted effect's law by name, where laws of one cause differ, with 95 % intervals; arguments as in
    `estimates`.
    """
    return {
        name: _estimate(form, float(coordinates[i]), 1.96 * float(deviations[i]) * dispersion**0.5)
        for i, (name, form) in enumerate(candidate.forms.items(), len(candidate.parameters))
    }


def _estimate(parameter: Parameter, coordinate: float, reach: float) -> Estimate:
    """The value at a coordinate, and those that far to either side, but no farther than is searched."""
    reach = min(reach, 1.96 * REACH)
    low, high = sorted(parameter.value(coordinate + side * reach) for side in (-1.0, 1.0))
    return Estimate(parameter.value(coordinate), (low, high))


@dataclass(frozen=True)
class Cause:
    """A possible cause: an effect, "none" or "outside_library", with its probability and parameters by name.

    joint: True if it acts together with another cause, the next or the one before in the list. chosen: words of the
    effect, such as the channel that lags. form: numbers of its law, see `forms`.
    """

    effect: str
    probability: float
    parameters: Mapping[str, Estimate]
    joint: bool = False
    chosen: Mapping[str, str] = field(default_factory=dict)
    form: Mapping[str, Estimate] = field(default_factory=dict)


@dataclass(frozen=True)
class Confirmed:
    """Result of the full simulation with the leading `effects`: shrink of the gap, and the gap after it in standard
    deviations of one test.
    """

    shrink: float
    after: float
    effects: tuple[str, ...]


@dataclass(frozen=True)
class Partial:
    """Effects that remove at least a stated share of a misfit without explaining it.

    misfit_removed: share of χ² that they remove. remains: zones where the rest lies.
    """

    causes: tuple[Cause, ...]
    misfit_removed: float
    remains: tuple[GapFinding, ...]


@dataclass(frozen=True)
class Remaining:
    """Gap that an explanation leaves: its share of the whole gap, the place where it lies ("" if it stands out
    nowhere), and a sentence.
    """

    share: float
    where: str
    text: str


def causes_of(explained: Sequence[Fit], weighed: Weighed, dispersion: float) -> tuple[Cause, ...]:
    """Causes by falling probability, with those of no gap and of a cause outside the library; see `causes_of_fit`."""
    fits = {one.names: one for one in explained}
    causes = [Cause("none", weighed.probabilities[()], {}), Cause("outside_library", weighed.outside, {})]
    for names, probability in weighed.probabilities.items():
        if names:
            causes += causes_of_fit(fits[names], probability, dispersion)
    listed = [cause for cause in causes if cause.probability >= LEAST_LISTED]
    # Causes that are one to the model keep the order of the library.
    return tuple(sorted(listed, key=lambda cause: -round(cause.probability, 9)))


def causes_of_fit(one: Fit, probability: float, dispersion: float) -> list[Cause]:
    """The effects of an explanation as causes, each with its share of the explanation's probability.

    dispersion: by how much variances are larger than expected, 1 or more.
    """
    causes = []
    for candidate, coordinates, deviations in one.parts():
        parameters = estimates(candidate, coordinates, deviations, dispersion)
        causes.append(
            Cause(
                candidate.kind.name,
                probability / len(one.candidates),
                parameters,
                joint=len(one.candidates) > 1,
                chosen=candidate.chosen,
                form=forms(candidate, coordinates, deviations, dispersion),
            )
        )
    return causes


def partial_of(found: Search, weighed: Weighed, dispersion: float, left_over: list[Place]) -> Partial | None:
    """The best explanation, where it removes most of a misfit without explaining it, and what it leaves where."""
    best = found.best
    if not best.candidates or found.removed < LEAST_REMOVED:
        return None
    probability = weighed.probabilities[best.names]
    return Partial(tuple(causes_of_fit(best, probability, dispersion)), found.removed, tuple(findings(left_over)))


@dataclass(frozen=True)
class Diagnosis:
    """The answer of a diagnosis; record, model: names.

    sentence: the answer for readers. physical: distances of loops and profiles from the record before and after adding
    the best effects, by name and unit. confirmed: None if not asked for. where: zones that differ. equivalent: groups
    of effects that cannot be distinguished. undetectable: effects that the record would not show. next_measurement:
    "what" to measure, "why", and the effects that it "splits"; None if none would help. notes: sentences on what limits
    the answer. resembles: what a gap of unknown cause behaves like. equivalent_unknown: causes of no
    library that the record cannot tell from the effects that explain it. partial, remainder: None if no effects explain
    a part only. plausible: classes of effects among which the cause is in nine records of ten. updated_by: names of
    further records. checked: remarks of `wirewear check`.
    """

    record: str
    model: str
    verdict: Verdict
    sentence: str
    shrink: Shrink
    physical: Mapping[str, tuple[float, float]]
    confirmed: Confirmed | None
    where: tuple[GapFinding, ...]
    causes: tuple[Cause, ...]
    equivalent: tuple[tuple[str, ...], ...]
    undetectable: tuple[str, ...]
    next_measurement: Mapping[str, Any] | None
    notes: tuple[str, ...]
    resembles: tuple[Resemblance, ...] = ()
    equivalent_unknown: tuple[Imitation, ...] = ()
    partial: Partial | None = None
    remainder: Remaining | None = None
    plausible: tuple[tuple[str, ...], ...] = ()
    relevance: Relevance | None = None
    updated_by: tuple[str, ...] = ()
    checked: tuple[Remark, ...] = field(default=())

    def to_json(self) -> dict[str, Any]:
        """The answer as plain values for JSON, numbers rounded to four digits."""
        s = self.shrink
        return {
            "format": FORMAT,
            "record": self.record,
            "model": self.model,
            "updated_by": list(self.updated_by),
            "program": program(),
            "verdict": self.verdict,
            "sentence": self.sentence,
            "gap": {
                "before": _rounded(s.before),
                "after": _rounded(s.after),
                "floor": _rounded(s.floor),
                "shrink": _rounded(s.shrink),
                "shrink_interval95": [_rounded(v) for v in s.interval95],
                "predicted_shrink": _rounded(s.predicted),
                "held_out": [f"{s.scar_words}cycle {n}" for n in s.held_out],
                "placebo_shrink": {
                    "best_wrong_effect": _rounded(s.best_wrong_effect),
                    "free_smooth_fit": _rounded(s.free_smooth_fit),
                },
                "physical": {name: [_rounded(v) for v in pair] for name, pair in self.physical.items()},
                "confirmed": None if self.confirmed is None else asdict(self.confirmed),
            },
            "relevance": None if self.relevance is None else asdict(self.relevance),
            "where": [asdict(finding) for finding in self.where],
            "causes": [_table(cause) for cause in self.causes],
            "partial": None
            if self.partial is None
            else {
                "causes": [_table(cause) for cause in self.partial.causes],
                "misfit_removed": _rounded(self.partial.misfit_removed),
                "remains": [asdict(finding) for finding in self.partial.remains],
            },
            "remainder": None
            if self.remainder is None
            else {**asdict(self.remainder), "share": _rounded(self.remainder.share)},
            "resembles": [asdict(one) for one in self.resembles],
            "set90": [list(members) for members in self.plausible],
            "equivalent": [list(members) for members in self.equivalent],
            "equivalent_unknown": [asdict(one) for one in self.equivalent_unknown],
            "undetectable": list(self.undetectable),
            "next_measurement": None if self.next_measurement is None else dict(self.next_measurement),
            "notes": list(self.notes),
            "checked": [asdict(remark) for remark in self.checked],
        }


def program() -> dict[str, str]:
    """The origin of an answer: "version" of this program, and hashes of its "sources" and fitted constants
    ("calibration").
    """
    return {"version": version("wirewear"), "sources": code_hash(), "calibration": digest()}


def _table(cause: Cause) -> dict[str, Any]:
    # To four digits, such that a sum of many stays within one.
    return {
        "effect": cause.effect,
        "probability": floor(1e4 * cause.probability) / 1e4,
        "parameters": _estimated(cause.parameters),
        **cause.chosen,
        **({"form": _estimated(cause.form)} if cause.form else {}),
        **({"joint": True} if cause.joint else {}),
    }


def _estimated(estimates: Mapping[str, Estimate]) -> dict[str, Any]:
    return {
        name: {"value": _rounded(e.value), "interval95": [_rounded(v) for v in e.interval95]}
        for name, e in estimates.items()
    }


def _rounded(value: float | None) -> float | None:
    return None if value is None else float(f"{value:.4g}")
