"""Reading a planar study: every key checked, and what does not fit together."""

from collections.abc import Mapping
from typing import Any

from solvers import Coulomb
from wirewear.effects import Seam
from wirewear.errors import StudyError
from wirewear.planar.tables import PlanarStudy
from wirewear.study.messages import validated
from wirewear.study.reading import default_loop_cycles
from wirewear.study.tables import Log


def planar_study_from_tables(data: Mapping[str, Any], where: str) -> PlanarStudy:
    """Build a planar study from nested tables; `where` names their origin in messages.

    Raises:
        StudyError: the tables are no valid study; the message is one sentence.
    """
    study = validated(PlanarStudy, data, where, StudyError)
    _require_consistent(study, where)
    if not study.log.loop_cycles:
        study = study.model_copy(update={"log": Log(loop_cycles=default_loop_cycles(study.conditions.cycles))})
    return study


def _require_consistent(study: PlanarStudy, where: str) -> None:
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
            f"friction_law in [contact] of {where} is {study.contact.friction_law.name!r}, but planar studies compute "
            "Archard wear from Coulomb's friction energy: give energy wear coefficients instead."
        )
    if study.contact.friction == 0.0 and archard > 0.0:
        raise StudyError(
            f"friction in [contact] of {where} is 0, but Archard wear is computed from friction energy: give a small "
            "coefficient such as 0.01."
        )
    for effect in study.effects:
        if effect.seam in (Seam.SPECIMENS, Seam.SENSOR):
            raise StudyError(
                f"effects in {where} hold {effect.name}, which changes the {effect.seam} of crossed wires: planar "
                "studies take effects of holder, contact, wear and loading."
            )
    last = max(study.log.loop_cycles, default=1)
    if last > study.conditions.cycles:
        raise StudyError(
            f"loop_cycles in [log] of {where} asks for cycle {last}, but the test ends after cycles = "
            f"{study.conditions.cycles}."
        )
