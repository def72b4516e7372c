"""All effects as a table for a terminal and as JSON."""

from __future__ import annotations

from typing import Any

from rich.table import Table

from wirewear.effects.effect import Effect
from wirewear.effects.parameter import Parameter, plain
from wirewear.effects.registry import EffectType, all_effects
from wirewear.study.quantity import UNIT_NAMES


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
        "split_by": effect.split_by,
        "parameters": [_parameter_json(name, item) for name, item in effect.parameters().items()],
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
    neutral = "any" if item.neutral is None else str(plain(item.neutral))
    of = f" × {item.share_of}" if item.share_of else ""
    return f"{name}: {neutral}, {item.hard:g}, {item.easy:g}{of}"


def effect_text(effect: type[Effect[Any]]) -> str:
    """One effect in full: physics, parameters, signature, look-alikes and what tells them apart."""
    lines = [f"{effect.name} ({effect.seam})", "", *(effect.__doc__ or "").strip().splitlines(), ""]
    lines[2:] = [line.strip() for line in lines[2:]]
    for name, item in effect.parameters().items():
        unit = UNIT_NAMES[item.quantity.unit]
        lines.append(f"{_parameter_line(name, item)}: {item.meaning}{f', in {unit}' if unit else ''}")
    lines += [
        "",
        f"Signature: {effect.signature}.",
        f"Confused with: {', '.join(effect.confused_with)}.",
        f"Told apart by: {effect.split_by}.",
    ]
    return "\n".join(lines)
