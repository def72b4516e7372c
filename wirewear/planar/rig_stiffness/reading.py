"""Reading a rig stiffness study: TOML text, every key checked, and what does not fit together."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from wirewear.errors import StudyError
from wirewear.files.toml import read_toml
from wirewear.planar.reading import kind_of_study
from wirewear.planar.rig_stiffness.tables import KIND, ContactTable, RigStiffnessStudy
from wirewear.study.messages import first_problem


def is_rig_stiffness_study(path: str | Path) -> bool:
    """Whether a TOML file says that it holds a rig stiffness study; False for one that cannot be read."""
    return kind_of_study(path) == KIND


def load_rig_stiffness_study(path: str | Path) -> RigStiffnessStudy:
    """Read a rig stiffness study from a TOML file.

    Raises:
        StudyError: the file cannot be read, or is no valid study; the message is one sentence.
    """
    return rig_stiffness_study_from_tables(read_toml(Path(path), StudyError, "study file"), str(path))


def rig_stiffness_study_from_tables(data: Mapping[str, Any], where: str) -> RigStiffnessStudy:
    """Build a rig stiffness study from nested tables; `where` names their origin in messages.

    Raises:
        StudyError: the tables are no valid study; the message is one sentence.
    """
    try:
        study = RigStiffnessStudy.model_validate(data)
    except ValidationError as error:
        sentence = first_problem(error, where, lambda keys: ".".join(map(str, keys[:-1])), RigStiffnessStudy)
        raise StudyError(sentence) from None
    if not study.contacts:
        raise StudyError(f"{where} has no contact: give a table [cylinder] or [flat], or both.")
    for name, contact in study.contacts.items():
        _require_consistent(name, contact, where)
    return study


def _require_consistent(name: str, contact: ContactTable, where: str) -> None:
    tangential, rotational = contact.tangential_stiffness_N_per_mm2, contact.rotational_stiffness_N_per_rad
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
