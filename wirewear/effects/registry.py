"""The effects of the library and of installed packages, by name, as a table for the terminal and as JSON."""

from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from functools import cache
from inspect import getdoc
from math import isinf

from rich.table import Table

from solvers.laws.plugins import by_name
from wirewear.base.errors import StudyError, ended
from wirewear.base.words import shown
from wirewear.effects import contact, holder, measurements, sensors, wear
from wirewear.effects.effect import AnyEffect, Effect
from wirewear.effects.measurements import Measurement
from wirewear.effects.parameter import Parameter

_EXAMPLE = 'such as [[effects]] with name = "tangential_compliance" and stiffness_N_per_mm = 150'

ENTRY_POINT_GROUP = "wirewear.effects"  #: Entry point group in which a package names its subclasses of `Effect`.

EffectType = type[AnyEffect]

LIBRARY: tuple[EffectType, ...] = (
    holder.TangentialCompliance, holder.RotationalCompliance, holder.FreePlay, holder.HolderInertia,
    contact.FrictionOffset,
    contact.FrictionEvolution, contact.RoughnessCompliance, contact.ThirdBodyLayer, contact.DebrisBalance,
    holder.Plasticity,
    holder.CrossingAngleError, holder.Misalignment, holder.NormalLoadDrift, wear.WearRateOffset, wear.WearRateEvolution,
    wear.ContactOxygenation, wear.FrictionHeating,
    sensors.DisplacementGain, sensors.DisplacementLoadCoupling, sensors.ForceCrosstalk,
    sensors.SensorLag, holder.HeldDisplacement,
)  # fmt: skip


def effects_of_tables(value: object) -> tuple[AnyEffect, ...]:
    """The effects that a list of `[[effects]]` tables states; effect objects in it are kept.

    Raises ValueError if `value` is not such a list, an effect is unknown or given twice, or a parameter is missing,
    unknown or out of range; the message continues a sentence that begins with "effects" and their place.
    """
    if not isinstance(value, list | tuple):
        raise ValueError(f"is {shown(value)}, but must be tables {_EXAMPLE}")
    try:
        effects = tuple(item if isinstance(item, Effect) else _effect(item) for item in value)
    except StudyError as problem:
        raise ValueError(f"cannot be used: {str(problem).rstrip('.')}") from None
    names = [effect.name for effect in effects]
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"cannot be used: {name} is given {names.count(name)} times, but an effect acts once")
    return effects


def tables_of_effects(effects: Iterable[AnyEffect]) -> list[dict[str, object]]:
    """The `[[effects]]` tables that give these effects."""
    return [effect.table() for effect in effects]


def _effect(table: object) -> AnyEffect:
    if not isinstance(table, Mapping):
        raise StudyError(f"{shown(table)} is no table {_EXAMPLE}")
    if "name" not in table:
        raise StudyError(f"an effect has no name; give tables {_EXAMPLE}")
    kind = effect_named(table["name"])
    known = kind.parameters()
    values = {key: value for key, value in table.items() if key != "name"}
    names = (*known, *kind.choices())
    for key in values:
        if key not in names:
            close = get_close_matches(key, names, n=1)
            hint = f"did you mean {close[0]!r}?" if close else f"its parameters are {', '.join(names)}"
            raise StudyError(f"{kind.name} has no parameter {shown(key)}: {hint}")
    for key, described in known.items():
        if key not in values and described.default is None:
            example = "" if described.share_of else f", for example {key} = {described.easy:g}"
            raise StudyError(f"{kind.name} needs {key}, the {described.meaning}{example}")
    return kind(**values)


def all_effects() -> dict[str, EffectType]:
    """Every effect by its name: the library's, then those of installed packages.

    Raises StudyError if a package's entry point holds no effect, or one whose name is taken.
    """
    return dict(_all_effects())


@cache
def _all_effects() -> dict[str, EffectType]:
    needed = ("name", "seam", "signature", "confused_with")
    return by_name(LIBRARY, ENTRY_POINT_GROUP, Effect, "effect", "wirewear.effects", needed, ended(StudyError))


def effect_named(name: object) -> EffectType:
    """The effect class of this name. Raises StudyError if no effect has it."""
    known = all_effects()
    if isinstance(name, str) and name in known:
        return known[name]
    close = get_close_matches(str(name), known, n=1)
    hint = f"did you mean {close[0]!r}?" if close else f"the effects are {', '.join(known)}."
    raise StudyError(f"there is no effect {name!r}: {hint}")


def all_measurements() -> tuple[Measurement, ...]:
    """All further measurements that can distinguish effects: the library's, then those of effects of packages."""
    named = (answer.measurement for effect in all_effects().values() for answer in effect.answers)
    return tuple(dict.fromkeys((*measurements.LIBRARY, *named)))


def splits(measurement: Measurement, one: str, other: str) -> bool:
    """True if a measurement is known to show different answers under the effects of these two names; "none" names the
    model without an effect.
    """
    a, b = (_shown(measurement, name) for name in (one, other))
    return bool(a and b and a != b)


def distinguished_by(effect: EffectType) -> tuple[Measurement, ...]:
    """Measurements that distinguish an effect from any of those it can be confused with, or if there are none, from any
    other effect; the cheapest first.
    """
    others = effect.confused_with or tuple(all_effects())
    found = [m for m in all_measurements() if any(splits(m, effect.name, other) for other in others)]
    return tuple(sorted(found, key=lambda measurement: measurement.cost_days))


def _shown(measurement: Measurement, name: str) -> str:
    if name == "none":
        return measurement.without_gap
    effect = all_effects().get(name)
    return effect.answer_to(measurement) if effect else ""


def effects_json() -> list[dict[str, object]]:
    """Every effect with its parameters, sizes and measurements, as plain values for JSON."""
    return [_effect_json(effect) for effect in all_effects().values()]


def _effect_json(effect: EffectType) -> dict[str, object]:
    return {
        "name": effect.name,
        "title": effect.title(),
        "seam": str(effect.seam),
        "signature": effect.signature,
        "confused_with": list(effect.confused_with),
        "split_by": "; ".join(measurement.what for measurement in distinguished_by(effect)),
        "parameters": [_parameter_json(name, item) for name, item in effect.parameters().items()],
        "choices": {name: list(words) for name, words in effect.choices().items()},
    }


def _parameter_json(name: str, item: Parameter) -> dict[str, object]:
    return {
        "name": name,
        "meaning": item.meaning,
        "unit": item.quantity.unit,
        "range": [item.quantity.low, item.quantity.high],
        "neutral": None if item.neutral is None else item.plain(item.neutral),
        "easy": item.easy,
        "hard": item.hard,
        "interest": list(item.interest),
        "scale": "logarithmic" if item.logarithmic else "linear",
        "multiple_of": item.share_of or None,
    }


def effects_table() -> Table:
    """A table of every effect with its seam, parameters, sizes and signature, to be printed with rich."""
    table = Table(title="Effects", title_justify="left", show_lines=True)
    for heading in ("effect", "seam", "parameters: neutral, hard and easy to see", "signature"):
        table.add_column(heading, overflow="fold")
    for effect in all_effects().values():
        lines = [
            f"{name}: {_neutral(item)}, {item.hard:g}, {item.easy:g}{_multiple(item)}"
            for name, item in effect.parameters().items()
        ]
        table.add_row(effect.name, str(effect.seam), "\n".join(lines), effect.signature)
    return table


def _neutral(item: Parameter) -> str:
    if item.neutral is None:
        return "any"
    return item.quantity.words[0] if isinf(item.neutral) else f"{item.neutral:g}"


def _multiple(item: Parameter) -> str:
    return f" × {item.share_of}" if item.share_of else ""


def effect_text(effect: EffectType) -> str:
    """A text on an effect: physics, parameters, signature, effects it can be confused with, what distinguishes them."""
    found = distinguished_by(effect)
    splitting = "; ".join(f"{m.what} ({effect.answer_to(m)})" for m in found) or "no further measurement that is known"
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
            f"Distinguished by: {splitting}."
        ),
    ]
    return "\n\n".join(parts)


def _parameter_text(name: str, item: Parameter) -> str:
    sizes = f"neutral {_neutral(item)}, hard to see {item.hard:g}, easy to see {item.easy:g}{_multiple(item)}"
    return f"{name}: {item.meaning}\n    {item.quantity.range_text}; {sizes}"
