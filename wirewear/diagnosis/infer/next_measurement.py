"""Which further measurement would settle most of what a record leaves open, for its cost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations

from wirewear.effects import Measurement, all_measurements, splits


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
