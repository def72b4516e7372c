"""Which further measurement would settle most of what a record leaves open, for its cost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations


@dataclass(frozen=True)
class Measurement:
    """A measurement that tells the effects of `groups` apart from each other; cost in days of a laboratory."""

    what: str
    why: str
    cost: float
    groups: tuple[frozenset[str], ...]

    def splits(self, one: str, other: str) -> bool:
        """Whether both effects are known to it, in different groups."""
        a, b = (next((i for i, group in enumerate(self.groups) if name in group), None) for name in (one, other))
        return a is not None and b is not None and a != b


def _m(what: str, why: str, cost: float, *groups: str) -> Measurement:
    return Measurement(what, why, cost, tuple(frozenset(group.split()) for group in groups))


#: What laboratories can do, with the effects that each measurement separates.
MEASUREMENTS = (
    _m(
        "a second displacement sensor at another height above the contact",
        "a tilting holder moves both points differently, a sliding one alike",
        1.0,
        "tangential_compliance free_play roughness_compliance third_body",
        "rotational_compliance",
        "displacement_load_coupling displacement_gain sensor_lag",
    ),
    _m(
        "one loop with the stroke held by a sensor that bears no load (an encoder on the drive)",
        "a sensor's error leaves the true stroke and the dissipated energy as they are, a compliance does not",
        0.5,
        "tangential_compliance rotational_compliance free_play roughness_compliance third_body",
        "displacement_load_coupling",
        "displacement_gain",
        "sensor_lag",
    ),
    _m(
        "the normal force over whole cycles",
        "a drifting or wrong load shows in it, friction does not",
        0.3,
        "normal_load_drift",
        "friction_offset",
        "friction_evolution",
        "misalignment force_crosstalk",
    ),
    _m(
        "a stroke without contact and one with half the load",
        "offsets that follow the load are the sensor's or the load's direction, those that follow friction are not",
        0.3,
        "force_crosstalk",
        "misalignment",
        "free_play",
        "tangential_compliance rotational_compliance displacement_load_coupling",
        "roughness_compliance third_body",
        "friction_offset",
    ),
    _m(
        "scars of tests stopped after 1 to 10, 1 000 and 30 000 cycles",
        "the path of the worn volume tells an early flattening, a wrong and a changing wear rate apart",
        3.0,
        "plasticity",
        "wear_rate_offset",
        "wear_rate_evolution",
        "friction_evolution friction_offset",
        "crossing_angle_error",
    ),
    _m(
        "the same test at a tenth of the frequency",
        "a lag shrinks with the frequency, everything elastic stays",
        0.5,
        "sensor_lag",
        "tangential_compliance rotational_compliance displacement_load_coupling",
        "free_play",
        "displacement_gain",
        "roughness_compliance third_body",
    ),
    _m(
        "loops every half decade from the first cycle on",
        "a rough surface wears in, debris gathers, a rig stays as it is",
        0.2,
        "roughness_compliance",
        "third_body",
        "tangential_compliance rotational_compliance free_play displacement_load_coupling",
        "friction_evolution",
    ),
    _m(
        "maps of both scars",
        "their volume, length and skew show true stroke, wear and angle without any sensor of the rig",
        0.5,
        "displacement_gain",
        "tangential_compliance rotational_compliance",
        "wear_rate_offset wear_rate_evolution",
        "crossing_angle_error",
        "friction_offset",
        "none",
    ),
)


def next_measurement(
    probabilities: Mapping[str, float], unclear: Sequence[Sequence[str]], available: frozenset[str]
) -> tuple[Measurement, tuple[str, ...]] | None:
    """The measurement that removes most expected confusion per cost, and the effects that it splits.

    Confusion of a pair is the product of its probabilities; `unclear` are classes that cannot be told apart, whose
    members count as equally probable. `available` names what the record already has.
    """
    pairs: dict[tuple[str, str], float] = {}
    for one, other in combinations(sorted(probabilities), 2):
        pairs[one, other] = probabilities[one] * probabilities[other]
    for members in unclear:
        share = sum(probabilities.get(name, 0.0) for name in members) / len(members)
        for one, other in combinations(sorted(members), 2):
            pairs[one, other] = max(pairs.get((one, other), 0.0), share**2)
    best: tuple[float, Measurement, tuple[str, ...]] | None = None
    for measurement in MEASUREMENTS:
        if measurement.what in available:
            continue
        split = {pair: weight for pair, weight in pairs.items() if measurement.splits(*pair) and weight > 1e-4}
        worth = sum(split.values()) / measurement.cost
        if split and (best is None or worth > best[0]):
            best = worth, measurement, tuple(sorted({name for pair in split for name in pair}))
    return None if best is None else best[1:]
