"""What an increment poses to a contact algorithm, and what the algorithm gives back.

An algorithm is one object, `ContactProblem.algorithm`. Given is the affine system of one pairing of k nodes, sought
are tractions and the holder's place at which every node is open, sticks or slips as it should, and the forces balance.
`solvers.newton` has the one in use.

A jump over cycles solves conditions of the same kind, but another problem, and keeps a method of its own
(`solvers.wear_step.active_set`). An increment seeks three tractions a node on one pairing: which nodes stick and where
the others slide is unknown, couples all three, and takes a semismooth Newton method. A jump knows from the traced
cycle where nodes slide and how far: what is left are normal pressures, of all positions of the cycle at once because
each wears the surface that the others meet. That is close to a convex quadratic programme of thousands of unknowns,
whose matrix is one block a position and what wear couples: an active set finds it in a few solutions, where three
tractions a node would make each block 27 times the work, for directions that are known.
"""

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from geometry.arrays import Array, BoolArray
from solvers.contact_state import Holder
from solvers.elasticity.compliance import PairedCompliance
from solvers.elasticity.pairing import Pairing
from solvers.laws.friction_law import Friction
from solvers.laws.layers import LayersAtNodes

#: What an algorithm says of bodies that no longer touch.
LOST_CONTACT = "all nodes opened: the bodies have lost contact"


@dataclass(frozen=True)
class Linearisation:
    """Affine map from tractions and holder position to gaps and slips for one pairing of k nodes."""

    pairing: Pairing
    before: Pairing  #: Pairing of the nodes that were loaded before the increment, as the bodies stood then.
    #: Mean displacement of the upper against the lower body at the nodes by tractions on them.
    compliance: PairedCompliance
    old_displacement: Array  #: (k, 3), the same for the tractions before the increment.
    friction: Friction
    paired_holder_x: float
    old_holder_x: float
    old_height: float
    drive_step: float
    old_tilt: float
    lever: Array  #: (k,) distance of the nodes ahead of the holder's pivot along x.
    #: What moves and resists the upper body; where `prescribed_height` is given, it is held there instead of loaded.
    holder: Holder
    pressed_height: float
    prescribed_height: float | None
    old_place_in_play: float = 0.0  #: Where it stood between the stops of its free play.
    layers: LayersAtNodes | None = None  #: What gives way between the surfaces.  Lengths in mm, forces in N.


class ContactGuess(NamedTuple):
    """Where an algorithm may start."""

    traction: Array  #: (k, 3) in world axes, MPa.
    active: BoolArray  #: (k,) nodes in contact.
    height: float  #: Of the holder, mm, as the next.
    holder_x: float


@dataclass(frozen=True)
class ContactOutcome:
    """Tractions (k, 3) in world axes, holder position, quality, and a sentence."""

    converged: bool
    message: str
    iterations: int
    traction: Array
    holder_x: float
    height: float
    tilt: float
    sliding: BoolArray  #: (k,) nodes that slide under pressure.
    slip_length: Array  #: (k,), mm, of these.
    sticking: int
    force_error: float
    penetration: float
    complementarity: float
    slip_direction_error: float
    elastic_slip: float

    @classmethod
    def nothing_pressed(cls, count: int, holder_x: float, height: float, tilt: float) -> "ContactOutcome":
        """The outcome of `count` open nodes without traction, with the holder at a place (mm, mm, rad)."""
        return cls(
            converged=True,
            message="nothing is pressed",
            iterations=0,
            traction=np.zeros((count, 3)),
            holder_x=holder_x,
            height=height,
            tilt=tilt,
            sliding=np.zeros(count, dtype=bool),
            slip_length=np.zeros(count),
            sticking=0,
            force_error=0.0,
            penetration=0.0,
            complementarity=0.0,
            slip_direction_error=0.0,
            elastic_slip=0.0,
        )


class ContactAlgorithm(Protocol):
    """How the conditions of an increment are met."""

    def solve_contact(self, system: Linearisation, guess: ContactGuess, /) -> ContactOutcome:
        """Tractions and holder position of one pairing.

        Where none is found, the outcome has not converged and its message says why, LOST_CONTACT if nothing touches.
        """
        ...
