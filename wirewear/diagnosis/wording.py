"""A diagnosis in words: causes with their numbers, the verdict in a sentence, and the next steps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from math import floor, inf, log10
from typing import Any

from wirewear.base.frame import figure
from wirewear.base.units import unit_of, words_of
from wirewear.diagnosis.answer import Cause, Diagnosis, Estimate, Partial, Verdict
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.infer.resembling import Resemblance
from wirewear.diagnosis.infer.shrink import Shrink
from wirewear.diagnosis.infer.weighing import SURE
from wirewear.diagnosis.infer.where import GapFinding, Relevance
from wirewear.effects import all_measurements, effect_named

#: What to look at where a gap behaves like something at a seam.
SEAMS = {
    "sensor": "sensors, amplifiers, filters and logger",
    "holder": "clamps, joints and springs that hold the specimens",
    "contact": "surfaces, debris and humidity",
    "loading": "weights, springs and hinges of the load",
    "wear": "how the surfaces wear",
    "specimens": "shape and mounting of the specimens",
}

_KNOWN = constants("wording")

#: Where there is no gap, the likeliest effect is named all the same if all effects together have this probability.
_DOUBTED = _KNOWN.number("doubted")


def plain(name: str) -> str:
    """An effect's name for readers, words that are chosen of it in brackets: "sensor lag (force)" of
    "sensor_lag:force".
    """
    effect, _, chosen = name.partition(":")
    words = {"none": "no gap", "outside_library": "something outside the library"}.get(effect, effect.replace("_", " "))
    return f"{words} ({chosen})" if chosen else words


def in_words(cause: Cause) -> str:
    """A cause for readers: "sensor lag (force)"."""
    chosen = ", ".join(cause.chosen.values())
    return f"{plain(cause.effect)} ({chosen})" if chosen else plain(cause.effect)


def parameters_in_words(cause: Cause) -> str:
    """The parameters of a cause with their 95 % intervals, such as "stiffness 165 N/mm (158 to 173)"."""
    return ", ".join(_with_unit(name, estimate) for name, estimate in cause.parameters.items())


def _with_unit(name: str, estimate: Estimate) -> str:
    unit, (low, high) = unit_of(name), estimate.interval95
    symbol = {"1": "", "°": "°"}.get(unit, f" {unit}")
    # What spans a decade is no measured value; of others, no digits that the interval does not bear.
    if 0.0 < low < 0.11 * high:
        return f"{words_of(name)} not determined ({figure(low)} to {figure(high)}{symbol})"
    value = round(estimate.value, 1 - floor(log10(high - low))) if 0.0 < high - low < inf else estimate.value
    return f"{words_of(name)} {figure(value)}{symbol} ({figure(low)} to {figure(high)})"


@dataclass(frozen=True)
class Explanation:
    """Causes that act alone or together, as one explanation with all that cannot be distinguished from it.

    words: for readers. causes: the likeliest ones. probability: that any of all these is the cause. is_effect: False
    for no gap and for a cause outside the library.
    """

    words: str
    causes: tuple[Cause, ...]
    probability: float
    is_effect: bool


def explanations(causes: Sequence[Cause], equivalent: Sequence[Sequence[str]]) -> list[Explanation]:
    """Possible causes of a gap, most probable first; effects of one group of `equivalent` count as one explanation."""
    joint = [cause for cause in causes if cause.joint]
    found: dict[tuple[tuple[str, ...], ...], Explanation] = {}
    # Both halves of a pair stand side by side.
    for own in (*((cause,) for cause in causes if not cause.joint), *zip(joint[::2], joint[1::2], strict=True)):
        key = tuple(sorted(_group(cause, equivalent) for cause in own))
        words = " together with ".join(
            f"{in_words(one)}{' or its like' if len(_group(one, equivalent)) > 1 else ''}" for one in own
        )
        known = found.get(key, Explanation(words, own, 0.0, own[0].effect not in ("none", "outside_library")))
        found[key] = replace(known, probability=known.probability + sum(cause.probability for cause in own))
    return sorted(found.values(), key=lambda one: -round(one.probability, 9))


def worth_telling(diagnosis: Diagnosis, least: float = 0.01) -> list[Explanation]:
    """The most probable explanation, and the others with a probability of at least `least`."""
    found = explanations(diagnosis.causes, diagnosis.equivalent)
    return [one for one in found if one is found[0] or one.probability >= least]


def share(value: float) -> str:
    """A share or probability from 0 to 1 as text in per cent, "< 1 %" and "> 99 %" at the ends."""
    return "< 1 %" if value < 0.01 else "> 99 %" if value > 0.99 else f"{100.0 * value:.0f} %"


def steps(diagnosis: Diagnosis) -> list[tuple[str, str]]:
    """Next steps as pairs of a heading and a sentence: what to measure, and what to check on the rig."""
    leading = next((one for one in explanations(diagnosis.causes, diagnosis.equivalent) if one.is_effect), None)
    probabilities = {cause.effect: cause.probability for cause in diagnosis.causes}
    asked = next_measurement(diagnosis)
    found = [("measure next", asked[0])] if asked else []
    if diagnosis.verdict == "no_gap":
        found.append(("on the rig", "nothing needs to be repaired"))
    elif leading and (diagnosis.verdict != "unexplained" or diagnosis.partial):
        for cause in leading.causes:
            group = next((own for own in diagnosis.equivalent if cause.effect in own), (cause.effect,))
            alike = sorted(group, key=lambda name: -probabilities.get(name, 0.0))[:3]
            whether = "if it is " if len(alike) > 1 else ""
            found += [(f"{whether}{plain(name)}", effect_named(name).remedy or "check it") for name in alike]
    found += [("check on the rig", f"{SEAMS[one.seam]}, where it seems to arise") for one in diagnosis.resembles[:1]]
    return found


def next_measurement(diagnosis: Diagnosis, least: float = 0.02) -> tuple[str, list[tuple[str, float, str]]] | None:
    """Words on the next measurement (what, why, and its cost in time), and for each effect that it distinguishes its
    name, probability and what it would show, most probable first. None if no two of these effects have at least the
    probability `least` each, apart from effects that act together.
    """
    asked, causes = diagnosis.next_measurement, diagnosis.causes
    known = {cause.effect: cause.probability for cause in causes}
    shares = known | {
        name: sum(known.get(other, 0.0) for other in group) / len(group)
        for group in diagnosis.equivalent
        for name in group
    }
    together = {cause.effect for cause in causes[:2] if cause.joint}
    if asked is None or not any(
        {*pair} != together and min(shares.get(name, 0.0) for name in pair) >= least
        for pair in combinations(asked["splits"], 2)
    ):
        return None
    chosen = next(one for one in all_measurements() if one.what == asked["what"])
    answers = []
    for name in sorted(asked["splits"], key=lambda name: -known.get(name, 0.0)):
        text = chosen.without_gap if name == "none" else effect_named(name).answer_to(chosen)
        answers.append((name, known.get(name, 0.0), text or "nothing of its own"))
    days = chosen.cost_days
    cost = {0.5: "half a day", 1.0: "a day"}.get(days, f"{8.0 * days:.2g} hours" if days < 1.0 else f"{days:.2g} days")
    return f"{chosen.what}; {chosen.why} ({cost})", answers


def sentence_of(
    verdict: Verdict,
    causes: Sequence[Cause],
    equivalent: Sequence[Sequence[str]],
    shrink: Shrink,
    where: Sequence[GapFinding],
    partial: Partial | None = None,
    resembles: Sequence[Resemblance] = (),
    relevance: Relevance | None = None,
    behind: Sequence[Cause] = (),
    asked: Mapping[str, Any] | None = None,
) -> str:
    """The answer of a diagnosis in one or two sentences. Arguments: as the fields of `Diagnosis`, None and empty ones
    where nothing is known. behind: causes of a difference that lies within the tolerance, of which the first is named.
    asked: the next measurement.
    """
    if verdict == "no_gap":
        return _agreement(relevance, behind[0] if behind else None) + _left_open(causes, asked)
    weighed = explanations(causes, equivalent)
    named = [one for one in weighed if one.is_effect]
    place = f" It lies mostly in the {where[0].place}." if where else ""
    like = f" {resembles[0].text}" if resembles else ""
    if partial is not None:
        return f"{_partly(partial, equivalent)}{like}"
    if verdict == "unexplained" or not named:
        return f"There is a gap that no known effect, and no pair of them, explains.{like or place}"
    words = " together with ".join(_one(cause, equivalent) for cause in named[0].causes)
    if verdict == "ambiguous":
        sure = _sure(named, equivalent)
        rivals = [one.words for one in weighed if one != named[0] and one.causes[0].effect != "none"]
        others = " or ".join(rivals[:2]) or "other effects"
        return f"{_beside(sure, named, equivalent) if sure else _may_explain(causes[0], words, others)}{place}"
    explains = f"{words[0].upper()}{words[1:]}, explain{'s' if len(named[0].causes) == 1 else ''} the gap"
    if not shrink.shows_gap:
        seen = f" in the {where[0].place}" if where else ""
        return f"{explains}{seen}; tests may scatter by more than what was left out of the fit, which cannot check it."
    left_out = "a scar" if shrink.scar_held_out else "cycles"
    return (
        f"{explains}: on {left_out} left out of the fit the difference from the model falls from {shrink.before:.2g} "
        f"to {shrink.after:.2g} times the scatter of tests."
    )


def _agreement(relevance: Relevance | None, like: Cause | None) -> str:
    if relevance is None or not relevance.detected or relevance.largest is None:
        return "The record and the model agree within the repeats' scatter and the numerical uncertainty."
    behaves = f" It looks like {_one(like, ())}." if like and like.effect not in ("none", "outside_library") else ""
    return (
        f"A difference of {100.0 * relevance.largest.relative:.2g} % is detected, within the record's tolerance: "
        f"{relevance.largest.text}.{behaves}"
    )


def _left_open(causes: Sequence[Cause], asked: Mapping[str, Any] | None) -> str:
    """Sentence on the likeliest effect that a record without a gap does not rule out, to follow the answer."""
    effects = [one for one in causes if one.effect not in ("none", "outside_library")]
    if sum(one.probability for one in effects) < _DOUBTED:
        return ""
    like = max(effects, key=lambda one: one.probability)
    tells = asked is not None and {"none", like.effect} <= {*asked["splits"]}
    would = f"; {asked['what']} would tell" if asked and tells else ""
    return f" The record does not rule out {_one(like, ())}{would}."


def _group(cause: Cause, equivalent: Sequence[Sequence[str]]) -> tuple[str, ...]:
    return next((tuple(group) for group in equivalent if cause.effect in group), (in_words(cause),))


def _sure(named: Sequence[Explanation], equivalent: Sequence[Sequence[str]]) -> Cause | None:
    """The likeliest cause that explanations of the probability `SURE` together share; None without one."""
    found: dict[tuple[str, ...], float] = {}
    for one in named:
        for group in {_group(cause, equivalent) for cause in one.causes}:
            found[group] = found.get(group, 0.0) + one.probability
    causes = [cause for one in named for cause in one.causes]
    return next((cause for cause in causes if found[_group(cause, equivalent)] >= SURE), None)


def _beside(sure: Cause, named: Sequence[Explanation], equivalent: Sequence[Sequence[str]]) -> str:
    """Sentences on the part of a gap that is sure, and on what may act beside it."""
    own = _group(sure, equivalent)
    others = {
        _group(cause, equivalent): cause
        for one in reversed(named)
        for cause in one.causes
        if own in {_group(each, equivalent) for each in one.causes} and _group(cause, equivalent) != own
    }
    words = [_one(cause, equivalent) for cause in [*others.values()][::-1][:2]]
    if any(len(one.causes) == 1 and _group(one.causes[0], equivalent) == own for one in named):
        words.append("nothing")
    first = _one(sure, equivalent)
    return (
        f"{first[0].upper()}{first[1:]}, is there for sure, and its numbers hold; beside it there may be "
        f"{', or '.join(words)}, which this record cannot tell."
    )


def _may_explain(likeliest: Cause, words: str, others: str) -> str:
    if likeliest.effect == "none":
        return f"There may be a gap, though none is likeliest; {words} may explain it, and so may {others}."
    return f"There is a gap; {words} may explain it, but so may {others}."


def _partly(partial: Partial, equivalent: Sequence[Sequence[str]]) -> str:
    words = " together with ".join(_one(cause, equivalent) for cause in partial.causes)
    # Never a hundred of what something remains of.
    removed = min(100.0 * partial.misfit_removed, 99.0)
    text = f"{words[0].upper()}{words[1:]}, removes {removed:.0f} % of the misfit"
    if not partial.remains:
        return f"{text}; what remains stands out nowhere by itself, but no known effect explains it."
    return f"{text}; what remains is in the {partial.remains[0].text}, which no known effect explains."


def _one(cause: Cause, equivalent: Sequence[Sequence[str]]) -> str:
    values = parameters_in_words(cause)
    members = next((list(group) for group in equivalent if cause.effect in group), [])
    if members:
        names = ", ".join(plain(name) for name in members[:-1]) + " or " + plain(members[-1])
        return f"one of {names}, which this record cannot distinguish (as {in_words(cause)}: {values})"
    return f"{in_words(cause)}, {values}"
