"""The classes among which the cause is in nine records of ten, and the measurement that tells them apart best.

Classes stand in the order of their probability, and go on until nine tenths of it are in the set. A cause of no library
is always in it: one that does what a known effect does, or that is too small to be seen, no record rules out.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations

from wirewear.diagnosis.calibration import constants
from wirewear.effects import Measurement, all_measurements, splits

#: How often a set holds the cause.
LEVEL = constants("infer.sets").number("level")

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


def plausible(known: Mapping[tuple[str, ...], float]) -> Classes:
    """The most probable classes, until they have 90 % of the probability, and a cause of no library."""
    kept: list[tuple[str, ...]] = []
    for members in sorted(known, key=lambda members: (-round(known[members], 9), members)):
        if sum(known[before] for before in kept) >= LEVEL:
            break
        kept.append(members)
    return joined(tuple(kept), (("outside_library",),))


def joined(first: Classes, second: Classes) -> Classes:
    """One set and, after it, the classes of another that share no effect with it."""
    return (*first, *(members for members in second if not any(set(members) & set(kept) for kept in first)))
