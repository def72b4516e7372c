"""Rig stiffness studies: a pad that translates or rotates on a spring, in plane strain."""

from wirewear.planar.rig_stiffness.reading import rig_stiffness_study_from_tables
from wirewear.planar.rig_stiffness.results import RigStiffnessResult, differences, read_rig_stiffness_result
from wirewear.planar.rig_stiffness.run import run_rig_stiffness_study
from wirewear.planar.rig_stiffness.tables import RigStiffnessStudy

__all__ = [
    "RigStiffnessResult",
    "RigStiffnessStudy",
    "differences",
    "read_rig_stiffness_result",
    "rig_stiffness_study_from_tables",
    "run_rig_stiffness_study",
]
