"""Effects of a whole contact of some length, and of one millimetre of it: line contacts are computed per mm."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from wirewear.effects import Effect

#: By which power of the contact's length a whole contact's number is larger than that of one millimetre, by its unit;
#: of all other units the numbers are the same.
_POWERS = {"N": 1, "N_per_mm": 1, "N_mm_per_rad": 1, "um_per_N": -1, "um_per_N2": -2}


def per_mm(effects: Iterable[Effect[Any]], length_mm: float) -> tuple[Effect[Any], ...]:
    """Effects of a whole contact as a study of one millimetre of it takes them."""
    return tuple(_scaled(effect, length_mm, -1) for effect in effects)


def of_whole_contact(effects: Iterable[Effect[Any]], length_mm: float) -> tuple[Effect[Any], ...]:
    """Effects of a study per mm as those of the whole contact."""
    return tuple(_scaled(effect, length_mm, 1) for effect in effects)


def _scaled(effect: Effect[Any], length_mm: float, sign: int) -> Effect[Any]:
    known = effect.parameters().items()
    powers = {name: sign * _POWERS.get(described.quantity.unit, 0) for name, described in known}
    return replace(
        effect, **{name: getattr(effect, name) * length_mm**power for name, power in powers.items() if power}
    )
