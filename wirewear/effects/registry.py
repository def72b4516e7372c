"""All effects there are: those of the library and those that installed packages add."""

from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from functools import cache
from typing import Any

from solvers.plugins import installed
from wirewear.base.errors import StudyError, shown
from wirewear.effects.contact import FrictionEvolution, FrictionOffset, RoughnessCompliance, ThirdBodyLayer
from wirewear.effects.drive import HeldDisplacement
from wirewear.effects.effect import Effect
from wirewear.effects.holder import (
    CrossingAngleError,
    FreePlay,
    Misalignment,
    NormalLoadDrift,
    Plasticity,
    RotationalCompliance,
    TangentialCompliance,
)
from wirewear.effects.sensors import DisplacementGain, DisplacementLoadCoupling, ForceCrosstalk, SensorLag
from wirewear.effects.wear import ContactOxygenation, WearRateEvolution, WearRateOffset

_EXAMPLE = 'such as [[effects]] with name = "tangential_compliance" and stiffness_N_per_mm = 150'

ENTRY_POINT_GROUP = "wirewear.effects"  #: Entry point group in which a package names its subclasses of `Effect`.

EffectType = type[Effect[Any]]

LIBRARY: tuple[EffectType, ...] = (
    TangentialCompliance, RotationalCompliance, FreePlay, FrictionOffset, FrictionEvolution, RoughnessCompliance,
    ThirdBodyLayer, Plasticity, CrossingAngleError, Misalignment, NormalLoadDrift, WearRateOffset, WearRateEvolution,
    ContactOxygenation, DisplacementGain, DisplacementLoadCoupling, ForceCrosstalk, SensorLag,
    HeldDisplacement,
)  # fmt: skip


def effects_of_tables(value: object) -> tuple[Effect[Any], ...]:
    """The effects that a list of tables gives; effects already made are kept.
    Raises ValueError if it is no such list, an effect is unknown or given twice, or a parameter makes no sense; the
    message goes on from the word "effects" and the place where it stands.
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


def tables_of_effects(effects: Iterable[Effect[Any]]) -> list[dict[str, Any]]:
    """The tables that give these effects."""
    return [effect.table() for effect in effects]


def _effect(table: object) -> Effect[Any]:
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
        if key not in values:
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
    found = {effect.name: effect for effect in LIBRARY}
    needed = ("name", "seam", "signature", "confused_with")
    for place, effect in installed(ENTRY_POINT_GROUP, Effect, "effect", "wirewear.effects", needed, _problem):
        if effect.name in found:
            raise StudyError(
                f"the entry point {place} adds an effect named {effect.name!r}, but there is one of that name "
                "already: uninstall that package, or give its effect another name."
            )
        found[effect.name] = effect
    return found


def effect_named(name: object) -> EffectType:
    """The effect of that name. Raises StudyError if there is none."""
    known = all_effects()
    if isinstance(name, str) and name in known:
        return known[name]
    close = get_close_matches(str(name), known, n=1)
    hint = f"did you mean {close[0]!r}?" if close else f"the effects are {', '.join(known)}."
    raise StudyError(f"there is no effect {name!r}: {hint}")


def _problem(sentence: str) -> StudyError:
    return StudyError(f"{sentence}.")
