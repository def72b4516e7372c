"""The classes among which the cause is in nine records of ten: sets by conformal calibration, for each verdict its own.

Classes stand in the order of their probability, what the verdict says first. A set goes on until more probability lies
before the next class than lay before the true one in nine of ten records that set it: then the next record of their
kind has its cause in the set with that chance, whatever the probabilities are worth (Vovk, Gammerman and Shafer,
Algorithmic Learning in a Random World, 2005, section 4.6, Mondrian by verdict).

Where no gap is seen, an effect that the record cannot show may be there as well as not, whatever the probabilities:
all of these are in the set. A gap is seen of something, so that they are not what explains it.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations
from math import ceil

from wirewear.diagnosis.calibration import constants
from wirewear.effects import Measurement, all_measurements, splits

_KNOWN = constants("infer.sets")

#: How often a set holds the cause.
LEVEL = _KNOWN.number("level")

#: Probability before the next class, beyond which it is left out, by verdict.
REACH: Mapping[str, float] = dict(
    zip(
        ("no_gap", "explained", "ambiguous", "unexplained"),
        _KNOWN.each("no_gap", "explained", "ambiguous", "unexplained"),
        strict=True,
    )
)

#: What a verdict says that names no effect.
_SAID = {"no_gap": "none", "unexplained": "outside_library"}

Classes = tuple[tuple[str, ...], ...]


def next_measurement(
    probabilities: Mapping[str, float], unclear: Sequence[Sequence[str]], available: frozenset[Measurement]
) -> tuple[Measurement, tuple[str, ...]] | None:
    """The measurement that removes most expected confusion per cost, and the effects that it splits.

    Confusion of a pair is the product of its probabilities; `unclear` are classes that cannot be told apart, whose
    members count as equally probable. `available` is what the record already has.
    """
    pairs: dict[tuple[str, str], float] = {}
    for one, other in combinations(sorted(probabilities), 2):
        pairs[one, other] = probabilities[one] * probabilities[other]
    for members in unclear:
        share = sum(probabilities.get(name, 0.0) for name in members) / len(members)
        for one, other in combinations(sorted(members), 2):
            pairs[one, other] = max(pairs.get((one, other), 0.0), share**2)
    best: tuple[float, Measurement, tuple[str, ...]] | None = None
    for measurement in all_measurements():
        if measurement in available:
            continue
        split = {pair: weight for pair, weight in pairs.items() if splits(measurement, *pair) and weight > 1e-4}
        worth = sum(split.values()) / measurement.cost_days
        if split and (best is None or worth > best[0]):
            best = worth, measurement, tuple(sorted({name for pair in split for name in pair}))
    return None if best is None else best[1:]


def masses(causes: Iterable[tuple[str, float]], equivalent: Iterable[Sequence[str]]) -> dict[tuple[str, ...], float]:
    """Probability of each class of effects that cannot be told apart, from that of each effect, at most 1."""
    groups = {name: tuple(members) for members in equivalent for name in members}
    found: dict[tuple[str, ...], float] = {}
    for name, probability in causes:
        members = groups.get(name, (name,))
        found[members] = min(found.get(members, 0.0) + probability, 1.0)
    return found


def in_order(verdict: str, known: Mapping[tuple[str, ...], float]) -> Classes:
    """What the verdict says, then all classes by their probability."""
    said = _SAID.get(verdict)
    return tuple(sorted(known, key=lambda members: (said not in members, -known[members], members)))


def plausible(verdict: str, known: Mapping[tuple[str, ...], float], undetectable: Sequence[str] = ()) -> Classes:
    """The set of a verdict: at least its own class, and effects that cannot be seen in the record where none was."""
    kept: list[tuple[str, ...]] = []
    before = 0.0
    for members in in_order(verdict, known):
        if kept and before > REACH[verdict]:
            break
        kept.append(members)
        before += known[members]
    return joined(tuple(kept), tuple((name,) for name in _unseen(verdict, undetectable)))


def joined(first: Classes, second: Classes) -> Classes:
    """One set and, after it, the classes of another that share no effect with it."""
    return (*first, *(members for members in second if not any(set(members) & set(kept) for kept in first)))


def _unseen(verdict: str, undetectable: Sequence[str]) -> tuple[str, ...]:
    return tuple(undetectable) if verdict == "no_gap" else ()


def before_truth(
    verdict: str, known: Mapping[tuple[str, ...], float], truths: Iterable[str], undetectable: Sequence[str] = ()
) -> float:
    """Probability of the classes before the first that holds one of several truths; 2 where none does, 0 if unseen."""
    wanted, before = set(truths), 0.0
    if wanted & set(_unseen(verdict, undetectable)):
        return before
    for members in in_order(verdict, known):
        if wanted & set(members):
            return before
        before += known[members]
    return 2.0


def reach_of(befores: Sequence[float], level: float) -> float:
    """The conformal quantile of what lay before the truth; 2, which leaves nothing out, of too few records."""
    rank = ceil((len(befores) + 1) * level)
    return 2.0 if rank > len(befores) else sorted(befores)[rank - 1]
