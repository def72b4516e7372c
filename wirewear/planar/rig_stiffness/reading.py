"""Reading a rig stiffness study: every key checked, and what does not fit together."""

from collections.abc import Mapping
from typing import Any

from wirewear.errors import StudyError
from wirewear.planar.rig_stiffness.tables import ContactTable, RigStiffnessStudy
from wirewear.study.messages import validated


def rig_stiffness_study_from_tables(data: Mapping[str, Any], where: str) -> RigStiffnessStudy:
    """Build a rig stiffness study from nested tables; `where` names their origin in messages.

    Raises:
        StudyError: the tables are no valid study; the message is one sentence.
    """
    study = validated(RigStiffnessStudy, data, where, StudyError)
    if not study.contacts:
        raise StudyError(f"{where} has no contact: give a table [cylinder] or [flat], or both.")
    for name, contact in study.contacts.items():
        _require_consistent(name, contact, where)
    return study


def _require_consistent(name: str, contact: ContactTable, where: str) -> None:
    tangential, rotational = contact.tangential_stiffness_N_per_mm2, contact.rotational_stiffness_N_per_rad
    if isinstance(rotational, str):
        return
    if len(tangential) != len(rotational):
        raise StudyError(
            f"[{name}] of {where} gives {len(tangential)} tangential and {len(rotational)} rotational stiffnesses, but "
            "each case needs one of both."
        )
    leaning = contact.normal_load_N_per_mm * contact.pivot_height_mm
    if min(rotational) <= leaning:
        raise StudyError(
            f"rotational_stiffness_N_per_rad in [{name}] of {where} holds {min(rotational):g}, but below "
            f"{leaning:g}, load times pivot height, the pad tips over: give stiffer springs or a lower pivot."
        )
