"""Materials that studies can name, read from materials.toml."""

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from typing import Any

from geometry import Elastic

_TABLE = Path(__file__).parent / "materials.toml"


@dataclass(frozen=True)
class Material:
    """A material: first name, synonyms (`also`), elastic constants, fatigue data, yield stress and Vickers hardness.

    Of each of the three data: its source, and verified: True if that source itself has been read. `fatigue` holds pairs
    (key of `LifeTable`, value), `yields` pairs (key of a body, value); each is empty where the table has none.
    """

    name: str
    elastic: Elastic
    source: str
    also: tuple[str, ...] = ()
    verified: bool = True
    #: Fatigue data by the keys of `LifeTable`, their source, and whether that has been read.
    fatigue: tuple[tuple[str, Any], ...] = ()
    fatigue_source: str = ""
    fatigue_verified: bool = True
    #: Yield stress and hardening by the keys of a body, if the name states the material's condition; else empty.
    yields: tuple[tuple[str, float], ...] = ()
    hardness_HV: float | None = None  #: In that condition; its source is that of the yield stress.
    yields_source: str = ""
    yields_verified: bool = True

    @property
    def fatigue_note(self) -> str:
        """Source of the fatigue data, after a caution if it was not read or gives estimates; empty without data."""
        measured = "fatigue_strength_coefficient_MPa" in dict(self.fatigue)
        doubt = "the tests behind them were not read: " if measured else "estimates from the tensile strength: "
        return f"{'' if self.fatigue_verified else doubt}{self.fatigue_source}"


@dataclass(frozen=True)
class RubbingPair:
    """Friction and energy wear coefficient of two bodies in published tests, each empty, one value, or several by the
    conditions. how: how they follow, where they are not printed as such. verified: False if the tests' own publication
    was not read.
    """

    bodies: str
    conditions: str
    source: str
    friction: tuple[float, ...] = ()
    energy_wear_coefficient_mm3_per_J: tuple[float, ...] = ()
    how: str = ""
    verified: bool = True


@cache
def rubbing_pairs() -> tuple[RubbingPair, ...]:
    """All pairs of materials.toml, in the file's order."""
    rows: list[dict[str, Any]] = tomllib.loads(_TABLE.read_text(encoding="utf-8"))["pair"]
    lists = ("friction", "energy_wear_coefficient_mm3_per_J")
    return tuple(RubbingPair(**row | {key: tuple(row.get(key, ())) for key in lists}) for row in rows)


@cache
def materials() -> tuple[Material, ...]:
    """All materials of materials.toml, in the file's order."""
    entries = {entry["name"]: entry for entry in tomllib.loads(_TABLE.read_text(encoding="utf-8"))["material"]}
    return tuple(_material({**entries.get(entry.get("like"), {}), "also": (), **entry}) for entry in entries.values())


def _material(entry: Mapping[str, Any]) -> Material:
    fatigue, plasticity = entry.get("fatigue", {}), entry.get("plasticity", {})
    return Material(
        name=entry["name"],
        elastic=Elastic(entry["youngs_modulus_MPa"], entry["poissons_ratio"]),
        source=entry["source"],
        also=tuple(entry["also"]),
        verified=entry.get("verified", True),
        fatigue=_data(fatigue),
        fatigue_source=fatigue.get("source", ""),
        fatigue_verified=fatigue.get("verified", True),
        yields=_data(plasticity),
        hardness_HV=plasticity.get("hardness_HV"),
        yields_source=plasticity.get("source", ""),
        yields_verified=plasticity.get("verified", True),
    )


def _data(table: Mapping[str, Any]) -> tuple[tuple[str, Any], ...]:
    return tuple(item for item in table.items() if item[0] not in ("source", "verified", "hardness_HV"))


def names() -> tuple[str, ...]:
    """First names of all materials, without synonyms."""
    return tuple(material.name for material in materials())


def material_named(name: object) -> Material:
    """The material with this name or synonym; case, blanks and hyphens do not matter.

    Raises ValueError if there is none; the message continues a sentence that begins with a key.
    """
    known = {_plain(spelled): (spelled, item) for item in materials() for spelled in (item.name, *item.also)}
    wanted = _plain(name) if isinstance(name, str) else ""
    if wanted in known:
        return known[wanted][1]
    close = " or ".join(repr(known[key][0]) for key in get_close_matches(wanted, known))
    hint = f"did you mean {close}?" if close else f"the table knows {', '.join(names())}"
    raise ValueError(f"is {name!r}, which is in no table of materials: {hint}")


def _plain(name: str) -> str:
    return re.sub(r"[\s_-]", "", name.casefold())
