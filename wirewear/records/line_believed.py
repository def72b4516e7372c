"""The test as a line contact's record states it, as a study: what is not stated is believed ideal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from wirewear.base.errors import RecordError
from wirewear.planar.model import bodies_stiffness_N_per_mm2, half_width_of
from wirewear.planar.reading import planar_study_from_tables
from wirewear.planar.tables import KINDS, Pad, PlanarHolder, PlanarStudy, Specimen
from wirewear.records.line_tables import OF_WHOLE, LineStated, LineTest


def believed_study(tables: LineTest, more: Mapping[str, Any] | None = None) -> PlanarStudy:
    """What the record's owner states, as a study of one millimetre of the contact.

    more: further tables of the study, such as log and mesh.

    Raises:
        RecordError: friction is not stated, twice and differently, or neither body's wear is.
        StudyError: what is stated does not fit together.
    """
    name, friction = tables.name, stated_friction(tables)
    if friction is None:
        raise _missing(name, "friction")
    if not stated_wear(tables.stated):
        raise _missing(name, "a wear coefficient of pad or specimen")
    return study_of_test(tables, friction, more)


def stated_friction(tables: LineTest) -> float | None:
    """Friction once it has run in, None where it is not stated.

    Raises:
        RecordError: it is stated twice and differently.
    """
    stated = tables.stated
    evolution = stated.friction_evolution
    if evolution is not None and stated.friction not in (None, evolution.final):
        raise RecordError(
            f"[stated] of the record {tables.name!r} gives friction = {stated.friction:g}, but final = "
            f"{evolution.final:g} in friction_evolution: leave friction out, or make them equal."
        )
    return stated.final_friction


def stated_wear(stated: LineStated) -> dict[str, float]:
    """The stated wear coefficients by the keys of a study's `[wear]`."""
    return {
        own: value
        for own, (key, per_length) in OF_WHOLE.items()
        if not per_length and (value := getattr(stated, key)) is not None
    }


def assumed_heights_mm(tables: LineTest) -> dict[str, float]:
    """Heights taken of the bodies whose own is not stated, by body: a study's, of a pad no more than it is wide.

    A block is sheared by friction; a column would bend, and give way with the cube of a height that no one knows.
    """
    width = 2.0 * (tables.pad.half_width_mm or half_width_of(tables.pad.profile))
    usual = {"pad": min(Pad.model_fields["height_mm"].default, width)}
    usual["specimen"] = Specimen.model_fields["height_mm"].default
    return {body: height for body, height in usual.items() if getattr(tables, body).height_mm is None}


def doubts_bodies(tables: LineTest) -> bool:
    """Whether the compliance between rig and contact is unsure: a stiffness that includes the bodies settles it."""
    stated = tables.stated
    whole = stated.stiffness_includes == "bodies" and stated.tangential_stiffness_N_per_mm != "rigid"
    return bool(assumed_heights_mm(tables)) and not whole


def study_of_test(tables: LineTest, friction: float, more: Mapping[str, Any] | None = None) -> PlanarStudy:
    """The study of one millimetre of a record's test, with that friction; bodies whose wear is not stated do not wear.

    Raises:
        StudyError: what is stated does not fit together.
    """
    data = tables_of_test(tables, friction) | dict(more or {})
    return planar_study_from_tables(data, f"the nominal model of the record {tables.name!r}")


def tables_of_test(tables: LineTest, friction: float) -> dict[str, Any]:
    """The same as tables of a study: what is not stated is left out, but for the heights that are taken."""
    length, asked, wear = tables.contact.length_mm, tables.conditions, stated_wear(tables.stated)
    stated = tables.stated.model_dump(mode="json", exclude_none=True)
    effects = [{"name": key, **stated[key]} for key in ("friction_evolution", "wear_rate_evolution") if key in stated]
    data: dict[str, Any] = {
        "format": 1,
        "name": tables.name,
        "kind": KINDS[0],
        "pad": tables.pad.model_dump(mode="json", exclude_none=True, exclude={"material"}),
        "specimen": tables.specimen.model_dump(mode="json", exclude_none=True, exclude={"material"}),
        "conditions": {
            "normal_load_N_per_mm": asked.normal_load_N / length,
            "displacement_amplitude_um": asked.displacement_amplitude_um,
            "frequency_Hz": asked.frequency_Hz,
            "cycles": asked.cycles,
            "motion": asked.motion,
        },
        "contact": {"friction": friction},
    }
    for body, height in assumed_heights_mm(tables).items():
        data[body]["height_mm"] = height
    data["holder"] = _holder(tables, data)
    return data | ({"wear": wear} if wear else {}) | ({"effects": effects} if effects else {})


def _holder(tables: LineTest, test: Mapping[str, Any]) -> dict[str, Any]:
    stated, length = tables.stated, tables.contact.length_mm
    holder: dict[str, Any] = {}
    for own, (key, _) in OF_WHOLE.items():
        if own in PlanarHolder.model_fields:
            value = getattr(stated, key)
            holder[own] = value if isinstance(value, str) else value / length
    if stated.pivot_height_mm is not None:
        holder["pivot_height_mm"] = stated.pivot_height_mm
    if stated.stiffness_includes == "bodies" and holder["tangential_stiffness_N_per_mm2"] != "rigid":
        holder["tangential_stiffness_N_per_mm2"] = _without_bodies(tables, test)
    return holder


def _without_bodies(tables: LineTest, test: Mapping[str, Any]) -> float:
    """Stiffness of the rig alone, per mm: what is left of the stated one in series with pad and specimen.

    Raises:
        RecordError: the bodies alone are no stiffer than what is stated of all.
    """
    length = tables.contact.length_mm
    whole = float(tables.stated.tangential_stiffness_N_per_mm)
    of_bodies = length * bodies_stiffness_N_per_mm2(
        planar_study_from_tables(dict(test), f"the bodies of the record {tables.name!r}")
    )
    if whole >= of_bodies:
        raise RecordError(
            f"[stated] of the record {tables.name!r} gives a stiffness of {whole:.4g} N/mm that includes the bodies, "
            f"but these alone have {of_bodies:.4g} N/mm: correct it, height_mm or half_width_mm of [pad] and "
            '[specimen], or say stiffness_includes = "rig only".'
        )
    return 1.0 / (1.0 / whole - 1.0 / of_bodies) / length


def _missing(name: str, what: str) -> RecordError:
    return RecordError(
        f"[stated] of the record {name!r} does not give {what}, without which there is no model to diagnose: add "
        "it, or fit the record (`wirewear fit`) and give the fitted study by --model."
    )
