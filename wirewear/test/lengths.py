"""Lengths of line contacts: conversion of keys per millimetre to those of the whole contact, and of studies to another
length.

One millimetre of a line contact is computed; files state the whole contact or values per millimetre. A value grows with
the length if it is a force, energy, volume or stiffness, by the unit at the end of its key.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Protocol, Self, TypeVar, cast

from pydantic import BaseModel

from wirewear.base.errors import WirewearError

#: Power of the length with which a number grows, by the unit at the end of its key; other numbers do not. (The watts of
#: an oxygen supply are a power density times the square of a distance, independent of the length.)
_POWERS = {"N": 1, "N_per_mm": 1, "N_mm_per_rad": 1, "mJ": 1, "J": 1, "mm3": 1, "um_per_N": -1, "um_per_N2": -2}
_UNIT = re.compile(rf"(?<!_per)_({'|'.join(_POWERS)})$")

_GROWING = ("conditions", "holder", "stop")  #: Tables of a study whose numbers may grow with the length.

#: Keys of one millimetre and those of the whole contact, by their tables.
_OF_WHOLE = {
    "conditions": {
        "normal_load_N_per_mm": "normal_load_N",
        "held_tangential_force_N_per_mm": "held_tangential_force_N",
        "held_energy_mJ_per_mm": "held_energy_mJ",
    },
    "holder": {
        "tangential_stiffness_N_per_mm2": "tangential_stiffness_N_per_mm",
        "rotational_stiffness_N_per_rad": "rotational_stiffness_N_mm_per_rad",
        "normal_spring_stiffness_N_per_mm2": "normal_spring_stiffness_N_per_mm",
    },
}
#: Earlier names of keys, by their tables.
_RENAMED = {
    "wear": {
        f"{body}_{law}_{unit}": f"{body}_{law}_wear_coefficient_{unit}"
        for body in ("pad", "specimen")
        for law, unit in (("energy", "mm3_per_J"), ("archard", "mm3_per_N_m"))
    }
}


class HasLength(Protocol):
    """A result or study of a line contact that can be converted to another contact length."""

    def of_length(self, length_mm: float) -> Self:
        """A copy for a contact of `length_mm`, with equal loads and energies per millimetre."""


AnyResult = TypeVar("AnyResult", bound=HasLength)
Named = TypeVar("Named")  #: Values by name: a mapping, or the fields of a table or an effect.


@dataclass(frozen=True)
class Extent:
    """How much of a contact is computed, and names and units that follow; this class is for contacts at a point,
    computed whole. length_mm: length of the line contact, None at a point. per: suffix of units of computed values;
    suffix: that of users' columns that grow with the length. worn: what worn surfaces are called. wear_unit: (factor on
    mm³, unit) of computed wear.
    """

    length_mm: float | None = None
    per: ClassVar[str] = ""
    suffix: ClassVar[str] = ""
    worn: ClassVar[str] = "scars"
    fewest_across: ClassVar[int] = 2  #: Least number of a worn surface's lines across the motion.
    wear_unit: ClassVar[tuple[float, str]] = 1e3, "10⁻³ mm³"

    @property
    def share(self) -> float:
        """Length that is computed over the contact's own: 1 at a point, 1/length_mm of a line contact."""
        return 1.0

    @property
    def half_mm(self) -> float:
        """By how much a contact reaches beyond its outermost computed lines across the motion: 0 at a point."""
        return 0.0

    @property
    def said(self) -> str:
        """Part of a contact that forces and energies belong to, as "10 mm of the contact"; empty at a point."""
        return ""

    def of_result(self, result: AnyResult) -> AnyResult:
        """A result of one millimetre converted to this length; unchanged for a contact at a point."""
        return result

    def units(self, per_length: Mapping[str, float]) -> dict[str, float]:
        """`per_length`, factors by unit for values per millimetre, multiplied by length_mm; empty at a point."""
        del per_length
        return {}

    def of(self, length_mm: float | None) -> "Extent":
        """The extent of a line contact of length `length_mm`, of 1 mm for None; unchanged for a contact at a point."""
        del length_mm
        return self


@dataclass(frozen=True)
class Length(Extent):
    """The extent of a line contact of length_mm, of which one millimetre is computed."""

    length_mm: float = 1.0
    per, suffix, worn, fewest_across = "/mm", "_per_mm", "profiles", 1
    wear_unit = 1e6, "µm²"

    @property
    def share(self) -> float:
        return 1.0 / self.length_mm

    @property
    def half_mm(self) -> float:
        return 0.5 * self.length_mm

    @property
    def said(self) -> str:
        return f"{self.length_mm:g} mm of the contact"

    def of_result(self, result: AnyResult) -> AnyResult:
        return result.of_length(self.length_mm)

    def units(self, per_length: Mapping[str, float]) -> dict[str, float]:
        return {unit: factor * self.length_mm for unit, factor in per_length.items()}

    def of(self, length_mm: float | None) -> Extent:
        return extent_of(length_mm or 1.0)


WHOLE = Extent()  #: The extent of any contact at a point.


def extent_of(length_mm: float | None) -> Extent:
    """The extent of a line contact of this length; that of a contact at a point for None."""
    return Length(length_mm) if length_mm else WHOLE


def whole_test(
    data: Mapping[str, object], where: str, error: type[WirewearError], length_mm: float | None = None
) -> dict[str, object]:
    """The nested tables of a line contact's study and of its blocks, with values per millimetre converted to the whole
    contact. length_mm: length of the contact; None takes that in [contact] of `data`, or 1. where: name of the file for
    messages. Raises `error`, in one sentence, if a value is stated both ways.
    """
    try:
        return _of_whole(data, length_mm or given_length_mm(data) or 1.0)
    except ValueError as problem:
        raise error(f"{where} {problem}.") from None


def given_length_mm(data: Mapping[str, object]) -> float | None:
    """The contact's length in mm in [contact] of a file's nested tables; None if it is missing or no number."""
    contact = data.get("contact")
    own = contact.get("length_mm") if isinstance(contact, Mapping) else None
    return own if _is_number(own) else None


def _of_whole(data: Mapping[str, Any], length_mm: float) -> dict[str, Any]:
    found = dict(data)
    for table in (*_OF_WHOLE, *_RENAMED):
        if isinstance(values := data.get(table), Mapping):
            found[table] = _renamed(table, values, length_mm)
    if isinstance(blocks := data.get("programme"), list | tuple):
        found["programme"] = [_of_whole(one, length_mm) if isinstance(one, Mapping) else one for one in blocks]
    return found


def key_of_whole(key: str, value: object, length_mm: float) -> tuple[str, object]:
    """A key with dots and its value for the whole contact of `length_mm`; as given if it is not per length."""
    table, _, name = key.rpartition(".")
    ((own, number),) = _renamed(table.rpartition(".")[2], {name: value}, length_mm).items()
    return f"{table}.{own}" if table else own, number


def _renamed(table: str, values: Mapping[str, Any], length_mm: float) -> dict[str, Any]:
    per_length, renamed, found = _OF_WHOLE.get(table, {}), _RENAMED.get(table, {}), {}
    for key, value in values.items():
        own = per_length.get(key, renamed.get(key, key))
        if own != key and own in values:
            raise ValueError(f"gives both {key} and {own} in [{table}]: give one of the two")
        found[own] = value * length_mm if key in per_length and _is_number(value) and length_mm != 1.0 else value
    return found


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def lengthened(values: Named, factor: float) -> Named:
    """A copy of a mapping, table or effect for a contact `factor` times as long; numbers change by their units."""
    own = ((key, value, _UNIT.search(key)) for key, value in _named(values).items() if _is_number(value))
    return _changed(values, {key: value * factor ** _POWERS[unit[1]] for key, value, unit in own if unit is not None})


def study_of_length(study: Named, length_mm: float) -> Named:
    """A copy of a line contact's study, as tables or as a nested mapping, for another length of the contact in mm, with
    equal load, force and energy per millimetre.
    """
    tables = _named(study)
    if length_mm == (own := stated_length_mm(tables)):
        return study
    factor = length_mm / own
    found: dict[str, object] = {name: lengthened(tables[name], factor) for name in _GROWING if tables.get(name)}
    for name, longer in (("effects", lengthened), ("programme", _lengthened_block)):
        rows = [] if tables.get(name) is None else tables[name]
        found[name] = type(rows)(longer(row, factor) for row in rows)
    return _changed(study, found | {"contact": _changed(tables["contact"], {"length_mm": length_mm})})


def _lengthened_block(block: Named, factor: float) -> Named:
    own = _named(block)
    return _changed(block, {key: lengthened(own[key], factor) for key in ("conditions", "holder") if own.get(key)})


def _named(values: object) -> Mapping[str, Any]:
    return values if isinstance(values, Mapping) else vars(values)


def _changed(values: Named, changes: Mapping[str, object]) -> Named:
    """The values with changes that are not checked."""
    if isinstance(values, Mapping):
        return cast("Named", {**values, **changes})
    return (
        values.model_copy(update=changes) if isinstance(values, BaseModel) else replace(cast("Any", values), **changes)
    )


def stated_length_mm(study: Mapping[str, object]) -> float:
    """Length in mm of the contact in the nested tables of a line contact's study; 1 if not stated."""
    return float(_named(study["contact"]).get("length_mm", 1.0))
