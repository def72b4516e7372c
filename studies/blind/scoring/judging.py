"""Judging one answer against the truth, class by class."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from studies.blind.causes import seam_of
from studies.blind.generators.cases import EXACT_CLASSES, exact_class
from studies.blind.scoring.answers import NONE, OUTSIDE, Answer, NamedCause

SET_LEVEL = 0.9  #: Level of the class sets whose coverage is reported, of answers that state none.
OPEN_KINDS = ("outside", "left_out")  #: Kinds of cases whose effect no library holds, as the diagnosis sees it.
#: Effects that another one contains: left out of the library, they cannot be unexplained; the other one is right.
CONTAINED_IN = {"friction_offset": "friction_evolution", "wear_rate_offset": "wear_rate_evolution"}


@dataclass(frozen=True)
class Truth:
    """What the key says of a case."""

    case: str
    kind: str
    ease: str | None
    effects: tuple[str, ...]
    parameters: Mapping[str, Mapping[str, float]]
    gap_in_scatter: float
    #: What the weaker of two effects changes beyond the other, see `weaker_of`; None where it is unknown.
    weaker_in_scatter: float | None = None

    @classmethod
    def of_key(cls, data: Mapping[str, Any]) -> "Truth":
        """The truth from the key's JSON."""
        return cls(
            case=data["case"],
            kind=data["kind"],
            ease=data["ease"],
            effects=tuple(effect["effect"] for effect in data["effects"]),
            parameters={effect["effect"]: dict(effect["parameters"]) for effect in data["effects"]},
            gap_in_scatter=float(data["gap_in_scatter"]),
            weaker_in_scatter=data.get("weaker_in_scatter"),
        )

    @property
    def hypotheses(self) -> tuple[str, ...]:
        """What a perfect answer names."""
        if self.kind == "none":
            return (NONE,)
        if self.kind == "left_out" and self.effects[0] in CONTAINED_IN:
            return (CONTAINED_IN[self.effects[0]],)
        return (OUTSIDE,) if self.is_open else self.effects

    @property
    def is_open(self) -> bool:
        """Whether no effect of the library that the diagnosis may use can explain it."""
        contained = self.kind == "left_out" and self.effects[0] in CONTAINED_IN
        return self.kind in OPEN_KINDS and not contained


@dataclass(frozen=True)
class Judgement:
    """One case's answer, judged; fields that do not apply are None."""

    truth: Truth
    answer: Answer | None
    label: str
    first_right: bool
    second_right: bool
    truth_probability: float
    leading_probability: float
    leading_right: bool
    set_holds_truth: bool
    set_size: int
    class_size: int
    outside_score: float
    pair_found: int | None
    aims: tuple[str, ...] = ()
    parameters: Mapping[str, bool] = field(default_factory=dict)

    @property
    def gap_seen(self) -> bool:
        """Whether a gap was found."""
        return self.answer is not None and self.answer.gap_seen

    @property
    def effect_named(self) -> bool:
        """Whether an effect was named as the cause."""
        return self.answer is not None and self.answer.names_an_effect

    @property
    def rejected(self) -> bool:
        """Whether a gap was found that no known effect explains."""
        return self.answer is not None and self.answer.verdict == "unexplained"

    @property
    def right_seam(self) -> bool | None:
        """Whether a cause of no library is said to enter where it does; None if it was not left unexplained."""
        if self.answer is None or not self.rejected or self.truth.kind != "outside":
            return None
        seam = seam_of(self.truth.effects[0])
        return None if seam is None else self.answer.seam == seam

    @property
    def leading_causes(self) -> tuple[NamedCause, ...]:
        """The two likeliest causes as stated, those of no cause among them."""
        causes = () if self.answer is None else self.answer.causes
        return tuple(sorted(causes, key=lambda cause: -cause.probability)[:2])

    @property
    def said(self) -> str:
        """The answer's verdict and likeliest cause."""
        if self.answer is None:
            return "no answer"
        leading = "".join(f", {cause.effect} {cause.probability:.2f}" for cause in self.leading_causes[:1])
        return f"{self.answer.verdict}{leading}"

    @property
    def verdict_on_it(self) -> str:
        """Whether the answer is right, in a word; of a pair, how many of its effects were named."""
        if self.pair_found is not None:
            return f"{self.pair_found} of 2"
        return "yes" if self.first_right else "no"


def classes_of(equivalent: Iterable[frozenset[str]]) -> dict[str, frozenset[str]]:
    """Class of each effect that has others in it: the exact classes and those declared, joined where they overlap."""
    joined: list[frozenset[str]] = []
    for members in (*EXACT_CLASSES, *equivalent):
        touching = [other for other in joined if other & members]
        merged = members.union(*touching)
        joined = [other for other in joined if other not in touching] + [merged]
    return {effect: members for members in joined for effect in members}


def judged(truth: Truth, answer: Answer | None) -> Judgement:
    """An answer judged; no answer is wrong about everything."""
    classes = classes_of(() if answer is None else answer.equivalent)
    aims = [_class(aim, classes) for aim in _aims(truth, classes)]
    if answer is None:
        return Judgement(
            truth, None, "no answer", False, False, 0.0, 0.0, False, False, 0, 0, 0.0, _pair(truth, None, aims)
        )
    mass = class_probabilities(answer, classes)
    ranked = sorted(mass, key=lambda members: (-mass[members], sorted(members)))
    first = _first(answer, ranked)
    order = [first, *(members for members in ranked if members != first)]
    chosen = _stated(answer, classes) or _set(ranked, mass)
    leading = ranked[0] if ranked else first
    return Judgement(
        truth=truth,
        answer=answer,
        label=_label(first, truth, answer),
        first_right=first in aims,
        second_right=any(members in aims for members in order[:2]),
        truth_probability=max((mass.get(aim, 0.0) for aim in aims), default=0.0),
        leading_probability=mass.get(leading, 0.0),
        leading_right=leading in aims,
        set_holds_truth=any(members & aim for members in chosen for aim in aims),
        set_size=sum(len(members) for members in chosen),
        class_size=max(len(aim) for aim in aims),
        # How strongly the answer says that no known effect explains the gap: its probability, the verdict on top.
        outside_score=mass.get(frozenset({OUTSIDE}), 0.0) + (answer.verdict == "unexplained"),
        pair_found=_pair(truth, answer, aims),
        aims=_aims(truth, classes),
        parameters=_covered(truth, answer),
    )


def _aims(truth: Truth, classes: Mapping[str, frozenset[str]]) -> tuple[str, ...]:
    """Hypotheses that are right; an effect that was left out may also be named by one declared equivalent to it."""
    if truth.kind != "left_out":
        return truth.hypotheses
    stand_ins = classes.get(truth.effects[0], frozenset()) - exact_class(truth.effects[0])
    return (*truth.hypotheses, *sorted(stand_ins)[:1])


def exact_label(effect: str) -> str:
    """Name of an effect's exact class: its members', joined by a slash."""
    return " / ".join(sorted(exact_class(effect), reverse=True))


def _class(effect: str, classes: Mapping[str, frozenset[str]]) -> frozenset[str]:
    return classes.get(effect, frozenset({effect}))


def class_probabilities(answer: Answer, classes: Mapping[str, frozenset[str]]) -> dict[frozenset[str], float]:
    """Probability of each class: the sum of its members', at most 1."""
    mass: dict[frozenset[str], float] = {}
    for cause in answer.causes:
        members = _class(cause.effect, classes)
        mass[members] = min(mass.get(members, 0.0) + cause.probability, 1.0)
    return mass


def _first(answer: Answer, ranked: list[frozenset[str]]) -> frozenset[str]:
    """The class that the verdict comes down to."""
    if answer.verdict == "no_gap":
        return frozenset({NONE})
    if answer.verdict == "unexplained":
        return frozenset({OUTSIDE})
    named = [members for members in ranked if not members & {NONE, OUTSIDE}]
    return named[0] if named else frozenset({OUTSIDE})


def _set(ranked: list[frozenset[str]], mass: Mapping[frozenset[str], float]) -> list[frozenset[str]]:
    """Fewest classes that hold the level's probability."""
    chosen, total = [], 0.0
    for members in ranked:
        chosen.append(members)
        total += mass[members]
        if total >= SET_LEVEL:
            break
    return chosen


def _stated(answer: Answer, classes: Mapping[str, frozenset[str]]) -> list[frozenset[str]]:
    """The set that the answer states, by the classes of the score."""
    whole = (frozenset[str]().union(*(_class(name, classes) for name in members)) for members in answer.stated_set)
    return list(dict.fromkeys(whole))


def _label(first: frozenset[str], truth: Truth, answer: Answer) -> str:
    """Column of the confusion matrix: of a class, the true member or the likeliest."""
    if len(first) == 1:
        return next(iter(first))
    for effect in truth.effects:
        if effect in first:
            return effect
    likeliest = sorted((c for c in answer.causes if c.effect in first), key=lambda c: -c.probability)
    return likeliest[0].effect if likeliest else min(first)


def _pair(truth: Truth, answer: Answer | None, aims: list[frozenset[str]]) -> int | None:
    """How many effects of a pair were named as acting together; alone, only the leading one counts."""
    if truth.kind != "pair":
        return None
    if answer is None or not answer.names_an_effect:
        return 0
    classes = classes_of(answer.equivalent)
    joint = {_class(cause.effect, classes) for cause in answer.causes if cause.joint}
    if not joint:
        mass = class_probabilities(answer, classes)
        ranked = sorted(mass, key=lambda members: (-mass[members], sorted(members)))
        joint = {_first(answer, ranked)}
    return sum(aim in joint for aim in aims)


def _covered(truth: Truth, answer: Answer) -> dict[str, bool]:
    """Whether the interval of each parameter holds its true value, of each true effect where it is likeliest."""
    if truth.kind not in ("single", "pair"):
        return {}
    found: dict[str, bool] = {}
    for cause in answer.causes:
        for name, value in truth.parameters.get(cause.effect, {}).items():
            if name in cause.intervals:
                low, high = cause.intervals[name]
                found.setdefault(f"{cause.effect}.{name}", low <= value <= high)
    return found
