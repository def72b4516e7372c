"""Rig stiffness studies: a pad that translates or rotates on a spring, in plane strain."""

from wirewear.planar.rig_stiffness.results import RigStiffnessResult, differences, read_rig_stiffness_result
from wirewear.planar.rig_stiffness.run import run_rig_stiffness_study
from wirewear.planar.rig_stiffness.tables import RigStiffnessStudy

__all__ = [
    "RigStiffnessResult",
    "RigStiffnessStudy",
    "differences",
    "read_rig_stiffness_result",
    "run_rig_stiffness_study",
]
