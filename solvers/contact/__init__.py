"""Frictional contact of two bodies: increments of a finite-sliding motion, solved by a semismooth Newton method.

Unknowns are the tractions on the primary surface and the holder's position along the normal and the motion. The
augmented-Lagrangian conditions of Alart & Curnier (Comput. Methods Appl. Mech. Eng. 92 (1991) 353) decide node by node
between open, stick and slip. Nodes that slip far compared with their elastic displacement follow a known direction and
cost one unknown; the others keep their tangential unknowns. An increment's wear is deposited when it has been solved.
"""

from solvers.contact.advancing import advance
from solvers.contact.pressing import press
from solvers.contact.problem import ContactProblem, Formulation, unloaded_state

__all__ = ["ContactProblem", "Formulation", "advance", "press", "unloaded_state"]
