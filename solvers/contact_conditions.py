"""The interface between an increment and the algorithm that solves its contact conditions.

An algorithm is one object, `ContactProblem.algorithm`. It is given the linear system of one pairing of k nodes, and
finds the tractions and the holder's position at which every node is open, sticks or slips as it should, and the forces
balance. `solvers.newton` is the one in use.

A jump over cycles solves conditions of the same kind by a method of its own (`solvers.wear_step.active_set`). An
increment seeks three tractions per node on one pairing: which nodes stick and where the others slide is unknown, which
couples all three and needs a semismooth Newton method. A jump knows from the traced cycle where nodes slide and how
far: unknown are normal pressures only, but at all positions of the cycle at once, because each wears the surface that
the others meet. This is close to a convex quadratic programme of thousands of unknowns with one block per position,
which an active set solves in a few steps; with three tractions per node each block would take 27 times the work.
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

#: The message of an outcome in which the bodies no longer touch.
LOST_CONTACT = "all nodes opened: the bodies have lost contact"


@dataclass(frozen=True)
class Linearisation:
    """Affine map from tractions and holder position to gaps and slips of the k nodes of one pairing; mm, N, MPa."""

    pairing: Pairing
    before: Pairing  #: Pairing of the nodes that were loaded before the increment, as the bodies stood then.
    #: Mean displacement of the upper against the lower body at the nodes by tractions on them.
    compliance: PairedCompliance
    old_displacement: Array  #: (k, 3) displacement by the tractions before the increment.
    friction: Friction  #: The friction law at the nodes.
    paired_holder_x: float  #: Holder's position along x for which the pairing was made.
    old_holder_x: float  #: Holder's position along x before the increment.
    old_height: float  #: Its height then.
    drive_step: float  #: Motion of the lower body along x in the increment.
    old_tilt: float  #: Its tilt then, rad.
    lever: Array  #: (k,) distance of the nodes ahead of the holder's pivot along x.
    holder: Holder  #: Load and springs of the upper body.
    pressed_height: float  #: Holder's height at which it had the normal load.
    prescribed_height: float | None  #: Height at which the holder is held instead of loaded; None: loaded.
    old_place_in_play: float = 0.0  #: Holder's position between the stops of its free play before the increment.
    layers: LayersAtNodes | None = None  #: Layers between the surfaces.
    #: (k,) gap in mm before the increment of nodes that then carried nothing, times their compliance along over across
    #: the surface: what they slip before they touch, per tangential over normal traction. None: all carried some.
    late: Array | None = None


class ContactGuess(NamedTuple):
    """Tractions, status of nodes and holder position from which an algorithm may start."""

    traction: Array  #: (k, 3) in world axes, MPa.
    active: BoolArray  #: (k,) nodes in contact.
    height: float  #: Height of the holder, mm.
    holder_x: float  #: Its position along x, mm.


@dataclass(frozen=True)
class ContactOutcome:
    """The solution of an increment: tractions (k, 3) in MPa in world axes, the holder's position (mm, rad) and
    residuals, which are those of `IncrementReport`. If not `converged`, `message` says why in a sentence, and the rest
    is the last state.
    """

    converged: bool
    message: str
    iterations: int
    traction: Array
    holder_x: float
    height: float
    tilt: float
    sliding: BoolArray  #: (k,) nodes that slide under pressure.
    slip_length: Array  #: (k,) lengths by which those nodes slide, mm; 0 at others.
    sticking: int
    force_error: float
    penetration: float
    complementarity: float
    slip_direction_error: float
    elastic_slip: float

    @classmethod
    def nothing_pressed(cls, count: int, holder_x: float, height: float, tilt: float) -> "ContactOutcome":
        """The converged outcome of `count` nodes without traction, with the holder at a position (mm), height (mm) and
        tilt (rad).
        """
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
    """A method that solves the contact conditions of an increment."""

    def solve_contact(self, system: Linearisation, guess: ContactGuess, /) -> ContactOutcome:
        """Find tractions and holder position for one pairing, starting from a guess.

        If there is no solution, the outcome is not `converged` and its message says why: LOST_CONTACT if nothing
        touches.
        """
        ...
