"""Wear over many cycles by one implicit step in which all positions of the cycle share the worn surface.

A stop is an increment of the traced cycle at whose end wear is computed; a position is a stop with the nodes that may
touch there; an unknown is the pressure at one of these nodes, and stands for its mirror image, too. N counts the
unknowns of all positions, one position after another, n the nodes of a body's patch. The primary is the body whose
nodes carry the tractions, the secondary the other one. A state's surfaces recede by worn depths, positive.
"""

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
