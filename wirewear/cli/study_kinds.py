"""A study of whatever kind `wirewear run` takes, from one reading of its file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from wirewear.errors import StudyError
from wirewear.files.toml import read_toml
from wirewear.planar import PlanarStudy, planar_study_from_tables
from wirewear.planar.rig_stiffness import RigStiffnessStudy, rig_stiffness_study_from_tables
from wirewear.planar.rig_stiffness.tables import KIND as RIG_STIFFNESS
from wirewear.planar.tables import KINDS
from wirewear.study import Study, study_from_tables

AnyStudy = Study | PlanarStudy | RigStiffnessStudy

_READERS: dict[str, Callable[[Mapping[str, Any], str], AnyStudy]] = {
    **dict.fromkeys(KINDS, planar_study_from_tables),
    RIG_STIFFNESS: rig_stiffness_study_from_tables,
}


def load_any_study(path: str | Path) -> AnyStudy:
    """Read a study from a TOML file; its `kind` says what it is, and one without or unknown is told so.

    Raises:
        StudyError: the file cannot be read, or is no valid study of its kind; the message is one sentence.
    """
    tables = read_toml(Path(path), StudyError, "study file")
    return _READERS.get(str(tables.get("kind")), study_from_tables)(tables, str(path))
