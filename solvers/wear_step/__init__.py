"""Wear over many cycles by one implicit step in which all positions of the cycle share the worn surface."""

from solvers.wear_step.prints import mirrored_prints
from solvers.wear_step.stages import CycleJump, jump_cycles
from solvers.wear_step.strokes import closed_trace
from solvers.wear_step.symmetry import Symmetry, kept_by, mirror_error, symmetry_of

__all__ = [
    "CycleJump",
    "Symmetry",
    "closed_trace",
    "jump_cycles",
    "kept_by",
    "mirror_error",
    "mirrored_prints",
    "symmetry_of",
]
