"""`[[effects]]` tables of a study, and the effects that they give."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from typing import Any

from wirewear.base.errors import StudyError
from wirewear.base.quantity import shown
from wirewear.effects.effect import Effect
from wirewear.effects.registry import effect_named

_EXAMPLE = 'such as [[effects]] with name = "tangential_compliance" and stiffness_N_per_mm = 150'


def effects_of_tables(value: object) -> tuple[Effect[Any], ...]:
    """The effects that a list of tables gives; effects already made are kept.

    Raises:
        ValueError: it is no such list, an effect is unknown or given twice, or a parameter makes no sense; the message
            goes on from the word "effects" and the place where it stands.
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
