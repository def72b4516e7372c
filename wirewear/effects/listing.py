"""All effects as a table for a terminal and as JSON."""

from inspect import getdoc
from math import isinf
from typing import Any

from rich.table import Table

from wirewear.effects.effect import Effect
from wirewear.effects.measurements import LIBRARY, Measurement
from wirewear.effects.parameter import RIGID, Parameter, plain
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


def effects_json() -> list[dict[str, Any]]:
    """Every effect with its parameters, ready for JSON."""
    return [_effect_json(effect) for effect in all_effects().values()]


def _effect_json(effect: EffectType) -> dict[str, Any]:
    return {
        "name": effect.name,
        "title": effect.title(),
        "seam": str(effect.seam),
        "signature": effect.signature,
        "confused_with": list(effect.confused_with),
        "split_by": "; ".join(measurement.what for measurement in told_apart_by(effect)),
        "parameters": [_parameter_json(name, item) for name, item in effect.parameters().items()],
        "choices": {name: list(words) for name, words in effect.choices().items()},
    }


def _parameter_json(name: str, item: Parameter) -> dict[str, Any]:
    return {
        "name": name,
        "meaning": item.meaning,
        "unit": item.quantity.unit,
        "range": [item.quantity.low, item.quantity.high],
        "neutral": None if item.neutral is None else plain(item.neutral),
        "easy": item.easy,
        "hard": item.hard,
        "interest": list(item.interest),
        "scale": "logarithmic" if item.logarithmic else "linear",
        "multiple_of": item.share_of or None,
    }


def effects_table() -> Table:
    """Every effect with its seam, parameters and sizes."""
    table = Table(title="Effects", title_justify="left", show_lines=True)
    for heading in ("effect", "seam", "parameters: neutral, hard and easy to see", "signature"):
        table.add_column(heading, overflow="fold")
    for effect in all_effects().values():
        lines = [_parameter_line(name, item) for name, item in effect.parameters().items()]
        table.add_row(effect.name, str(effect.seam), "\n".join(lines), effect.signature)
    return table


def _parameter_line(name: str, item: Parameter) -> str:
    return f"{name}: {_neutral(item)}, {item.hard:g}, {item.easy:g}{_multiple(item)}"


def _neutral(item: Parameter) -> str:
    if item.neutral is None:
        return "any"
    return RIGID if isinf(item.neutral) else f"{item.neutral:g}"


def _multiple(item: Parameter) -> str:
    return f" × {item.share_of}" if item.share_of else ""


def effect_text(effect: type[Effect[Any]]) -> str:
    """One effect in full: physics, parameters, signature, look-alikes and what tells them apart."""
    parts = [
        f"{effect.name} ({effect.seam})",
        getdoc(effect) or "",
        "\n".join(
            [
                *(_parameter_text(name, item) for name, item in effect.parameters().items()),
                *(f"{name}: {' or '.join(words)}; {words[0]} unless given" for name, words in effect.choices().items()),
            ]
        ),
        (
            f"Signature: {effect.signature}.\n"
            f"Confused with: {', '.join(effect.confused_with) or 'no other effect'}.\n"
            f"Told apart by: {_split_text(effect)}."
        ),
    ]
    return "\n\n".join(parts)


def _parameter_text(name: str, item: Parameter) -> str:
    sizes = f"neutral {_neutral(item)}, hard to see {item.hard:g}, easy to see {item.easy:g}{_multiple(item)}"
    return f"{name}: {item.meaning}\n    {item.quantity.range_text}; {sizes}"


def _split_text(effect: EffectType) -> str:
    found = told_apart_by(effect)
    return "; ".join(f"{m.what} ({effect.answer_to(m)})" for m in found) or "no further measurement that is known"
