"""The test as a record states it, as a study: what is not stated is believed ideal."""

from collections.abc import Mapping
from typing import Any

from wirewear.base.errors import RecordError
from wirewear.records.tables import StatedRig

#: What changes over the cycles, as keys of `[stated]` and as effects of a study.
_EVOLUTIONS = ("friction_evolution", "wear_rate_evolution")

_OF_THE_CONTACT = ("friction", *_EVOLUTIONS)


def believed_study(tables: Any, more: Mapping[str, Any] | None = None) -> Any:
    """What the record's owner states, as a study of its kind of contact, of one millimetre of what has a length.

    more: further tables of the study, such as log and mesh.

    Raises:
        RecordError: friction or wear is not stated, or friction twice and differently.
        StudyError: what is stated does not fit together.
    """
    friction = stated_friction(tables)
    for lacking in tables.missing:
        raise RecordError(
            f"[stated] of the record {tables.name!r} does not give {lacking}, without which there is no model to "
            "diagnose: add it, or fit the record (`wirewear fit`) and give the fitted study by --model."
        )
    data = believed_tables(tables, friction or 0.0) | dict(more or {})
    return tables.study_of(data, f"the nominal model of the record {tables.name!r}")


def stated_friction(tables: Any) -> float | None:
    """Friction once it has run in, None where it is not stated.

    Raises:
        RecordError: it is stated twice and differently.
    """
    stated: StatedRig = tables.stated
    evolution = stated.friction_evolution
    if evolution is not None and stated.friction not in (None, evolution.final):
        raise RecordError(
            f"[stated] of the record {tables.name!r} gives friction = {stated.friction:g}, but final = "
            f"{evolution.final:g} in friction_evolution: leave friction out, or make them equal."
        )
    return stated.final_friction


def believed_tables(tables: Any, friction: float) -> dict[str, Any]:
    """The same with that friction as tables of a study; bodies whose wear is not stated do not wear."""
    stated = tables.stated.model_dump(mode="json", exclude_unset=True, exclude_none=True)
    rig = {key: stated[key] for key in StatedRig.model_fields if key in stated and key not in _OF_THE_CONTACT}
    wear = {key: stated[key] for key in type(tables.stated).WEAR if key in stated}
    wears = any("_wear_coefficient_" in key for key in wear)
    effects = [{"name": key, **stated[key]} for key in _EVOLUTIONS if key in stated]
    data: dict[str, Any] = {
        "format": 1,
        "name": tables.name,
        "kind": tables.contact_kind,
        "conditions": tables.for_study(tables.conditions.model_dump(mode="json", exclude={"drive"})),
        "contact": {"friction": friction},
        "holder": tables.for_study(rig or {"tangential_stiffness_N_per_mm": "rigid"}),
        **({"wear": tables.for_study(wear)} if wears else {}),
        **({"effects": effects} if effects else {}),
    }
    whole: dict[str, Any] = tables.with_bodies(data)
    return whole
