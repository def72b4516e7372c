"""Reading a planar study: every key checked, and what does not fit together."""

from collections.abc import Mapping
from typing import Any

from solvers import Coulomb
from wirewear.base.errors import StudyError
from wirewear.effects import Seam
from wirewear.planar.tables import CYLINDER_ON_FLAT, PlanarStudy
from wirewear.study.consistency import log_within, merged
from wirewear.study.messages import validated
from wirewear.study.reading import variants_in


def planar_study_from_tables(data: Mapping[str, Any], where: str) -> PlanarStudy:
    """Build a planar study from nested tables; `where` names their origin in messages.
    Raises StudyError, in one sentence, if the tables are no valid study.
    """
    base = {key: value for key, value in data.items() if key != "variants"}
    study = _checked(base, where)
    return study.with_variants(
        tuple(
            (name, _checked(merged(base, overrides), f"the variant {name!r} of {where}").named(name))
            for name, overrides in variants_in(data, where)
        )
    )


def _checked(tables: Mapping[str, Any], where: str) -> PlanarStudy:
    study = validated(PlanarStudy, tables, where, StudyError)
    _require_consistent(study, where)
    return study.model_copy(update={"log": log_within(study.log, study.conditions.cycles)})


def _require_one_face(study: PlanarStudy, where: str) -> None:
    if (wanted := study.pad.missing_face(round_alone=study.kind == CYLINDER_ON_FLAT)) is not None:
        raise StudyError(f"[pad] in {where} does not say which face the pad has: {wanted}.")


def _require_holder(study: PlanarStudy, where: str) -> None:
    holder = study.holder
    if holder.rotational_stiffness_N_per_rad == "rigid":
        return
    if holder.pivot_height_mm is None:
        raise StudyError(
            f"rotational_stiffness_N_per_rad in [holder] of {where} says that the holder rotates, but pivot_height_mm, "
            "the height of its pivot above the contact, is missing."
        )
    leaning = study.conditions.normal_load_N_per_mm * holder.pivot_height_mm
    if holder.rotational_stiffness_N_per_rad <= leaning:
        raise StudyError(
            f"rotational_stiffness_N_per_rad in [holder] of {where} is {holder.rotational_stiffness_N_per_rad:g}, but "
            f"below {leaning:g}, load times pivot height, the pad tips over: give a stiffer spring or a lower pivot."
        )


def _require_consistent(study: PlanarStudy, where: str) -> None:
    _require_one_face(study, where)
    _require_holder(study, where)
    wear = study.wear
    for body in ("pad", "specimen"):
        energy, archard = getattr(wear, f"{body}_energy_mm3_per_J"), getattr(wear, f"{body}_archard_mm3_per_N_m")
        if energy > 0.0 and archard > 0.0:
            raise StudyError(
                f"{body}_energy_mm3_per_J and {body}_archard_mm3_per_N_m in [wear] of {where} are both given, but a "
                "body wears by one law: give one of the two."
            )
    archard = max(wear.pad_archard_mm3_per_N_m, wear.specimen_archard_mm3_per_N_m)
    if archard > 0.0 and not isinstance(study.contact.friction_law, Coulomb):
        raise StudyError(
            f"friction_law in [contact] of {where} is {study.contact.friction_law.name!r}, but line contacts compute "
            "Archard wear from Coulomb's friction energy: give energy wear coefficients instead."
        )
    if study.contact.friction == 0.0 and archard > 0.0:
        raise StudyError(
            f"friction in [contact] of {where} is 0, but Archard wear is computed from friction energy: give a small "
            "coefficient such as 0.01."
        )
    for effect in study.effects:
        if effect.seam is Seam.SPECIMENS:
            raise StudyError(
                f"effects in {where} hold {effect.name}, which changes the {effect.seam} of crossed wires: line "
                "contacts take effects of holder, contact, wear, loading and sensor."
            )
