"""Which measurements tell which effects apart."""

from __future__ import annotations

from wirewear.effects.measurements import LIBRARY, Measurement
from wirewear.effects.registry import EffectType, all_effects


def all_measurements() -> tuple[Measurement, ...]:
    """Every measurement that tells effects apart: the library's, then those that effects of packages bring."""
    named = (answer.measurement for effect in all_effects().values() for answer in effect.answers)
    return tuple(dict.fromkeys((*LIBRARY, *named)))


def splits(measurement: Measurement, one: str, other: str) -> bool:
    """Whether it shows something else under one effect than under the other; "none" is the model without a gap."""
    a, b = (_shown(measurement, name) for name in (one, other))
    return bool(a and b and a != b)


def told_apart_by(effect: EffectType) -> tuple[Measurement, ...]:
    """Measurements that tell an effect from its look-alikes, or from any other if it has none; the cheapest first."""
    others = effect.confused_with or tuple(all_effects())
    found = [m for m in all_measurements() if any(splits(m, effect.name, other) for other in others)]
    return tuple(sorted(found, key=lambda measurement: measurement.cost_days))


def _shown(measurement: Measurement, name: str) -> str:
    if name == "none":
        return measurement.without_gap
    effect = all_effects().get(name)
    return effect.answer_to(measurement) if effect else ""
