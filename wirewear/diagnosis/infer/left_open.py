"""What a record leaves open: among which classes of effects the cause is, which effects it cannot show, what would.

A class is a tuple of effects that a record cannot distinguish. Classes stand in the order of their probability; the
most probable that together hold nine tenths of it form the set in which the cause is in nine records of ten. A cause of
no library is always in the set: no record rules out one that acts like a known effect or is too small to be seen.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations

import numpy as np

from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.infer.inference import Problem
from wirewear.diagnosis.infer.search import Search
from wirewear.diagnosis.infer.weighing import SEPARABLE, Weighed
from wirewear.diagnosis.surrogate.candidates import Candidate, effect_of
from wirewear.effects import Measurement, all_measurements, measurements, splits
from wirewear.records import AnyRecord

#: How often a set holds the cause.
LEVEL = constants("infer.left_open").number("level")

Classes = tuple[tuple[str, ...], ...]


def masses(causes: Iterable[tuple[str, float]], equivalent: Iterable[Sequence[str]]) -> dict[tuple[str, ...], float]:
    """Probability of each class, at most 1, from `causes`, pairs of an effect's name and probability. equivalent:
    classes of several effects; every other effect is a class of its own.
    """
    groups = {name: tuple(members) for members in equivalent for name in members}
    found: dict[tuple[str, ...], float] = {}
    for name, probability in causes:
        members = groups.get(name, (name,))
        found[members] = min(found.get(members, 0.0) + probability, 1.0)
    return found


def plausible(known: Mapping[tuple[str, ...], float]) -> Classes:
    """The most probable of classes with known probabilities, until they have 90 % of it together, and a cause of no
    library.
    """
    kept: list[tuple[str, ...]] = []
    for members in sorted(known, key=lambda members: (-round(known[members], 9), members)):
        if sum(known[before] for before in kept) >= LEVEL:
            break
        kept.append(members)
    return joined(tuple(kept), (("outside_library",),))


def joined(first: Classes, second: Classes) -> Classes:
    """The classes of `first`, followed by those of `second` that share no effect with them."""
    return (*first, *(members for members in second if not any(set(members) & set(kept) for kept in first)))


def unseen(found: Search, own: set[str]) -> tuple[str, ...]:
    """Names of effects that the record would not show in any choice, such as the channel that lags. own: names of the
    effects that explain it, and of those not distinguished from them.
    """
    others = [one.candidates[0] for one in found.singles if one.names[0] not in own]
    unseen = _undetectable(found.problem, others)
    seen = {effect_of(one.name) for one in others if one.name not in unseen} | set(map(effect_of, own))
    return tuple(name for name in dict.fromkeys(map(effect_of, unseen)) if name not in seen)


def _undetectable(problem: Problem, candidates: Sequence[Candidate]) -> tuple[str, ...]:
    """Names of the candidates that change the observables by less than `SEPARABLE` standard deviations at one prior
    deviation of their first parameter.
    """
    unseen = []
    for candidate in candidates:
        ends = [side * np.eye(len(candidate.unknowns))[0] for side in (1.0, -1.0)]
        values = problem.predictions([problem.setup, *(candidate.applied(problem.setup, at) for at in ends)])
        if np.linalg.norm(problem.whitening @ (values[1:] - values[0]).T, axis=0).max() < SEPARABLE:
            unseen.append(candidate.name)
    return tuple(unseen)


def measurement_after(
    records: Sequence[AnyRecord], weighed: Weighed, equivalent: Sequence[Sequence[str]]
) -> dict[str, object] | None:
    """The next measurement as a diagnosis states it: what it is, the effects that it splits, and why; None for none.

    records: all that were made of the test so far, whose measurements need not be made again.
    """
    single: dict[str, float] = {}
    for names, probability in weighed.probabilities.items():
        for name in map(effect_of, names or ("none",)):
            single[name] = single.get(name, 0.0) + probability / max(len(names), 1)
    present = []
    if any(record.scars for record in records):
        present.append(measurements.SCAR_MAPS)
    if any(record.loops and all(loop.normal_force_N is not None for loop in record.loops) for record in records):
        present.append(measurements.NORMAL_FORCE)
    if any(record.tables.conditions.drive == "stroke" for record in records):
        present.append(measurements.ENCODER)
    chosen = most_worth(single, equivalent, frozenset(present))
    if chosen is None:
        return None
    return {"what": chosen[0].what, "splits": list(chosen[1]), "why": chosen[0].why}


def most_worth(
    probabilities: Mapping[str, float], unclear: Sequence[Sequence[str]], available: frozenset[Measurement]
) -> tuple[Measurement, tuple[str, ...]] | None:
    """The measurement that removes most expected confusion per day, and the names of the effects that it distinguishes;
    None if none distinguishes any.

    Confusion of a pair is the product of its probabilities. probabilities: by effect, "none" for no gap. unclear:
    classes, whose members count as equally probable. available: measurements that the record has.
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
