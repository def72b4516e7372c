"""What the contact solver answers: tractions, the holder's position, and how well the conditions are met."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from solvers.newton.conditions import ContactConditions, FrictionStatus, Iterate
from solvers.newton.holder_balance import unbalanced_force

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

#: Slips shorter than this share of the bodies' elastic closure are round-off, and have no direction.
_ROUND_OFF = 1e-9

#: What `solve_contact` says of bodies that no longer touch.
LOST_CONTACT = "all nodes opened: the bodies have lost contact"


@dataclass(frozen=True)
class NewtonOutcome:
    """Result of `solve_contact`: tractions (k, 3) in world axes, holder position, quality, and a sentence.

    sliding: (k,) nodes that slide under pressure.  slip_length: (k,), mm, of these.
    """

    converged: bool
    message: str
    iterations: int
    traction: Array
    holder_x: float
    height: float
    tilt: float
    sliding: BoolArray
    slip_length: Array
    sticking: int
    force_error: float
    penetration: float
    complementarity: float
    slip_direction_error: float
    elastic_slip: float


def converged_outcome(
    conditions: ContactConditions, state: Iterate, active: BoolArray, friction: FrictionStatus, iterations: int
) -> NewtonOutcome:
    """The answer of a converged state, with its energies and residuals."""
    system, direction = conditions.system, friction.direction
    # Round-off may leave nodes on the verge of opening with a vanishing negative pressure.
    normal = np.where(active, np.maximum(state.normal, 0.0), 0.0)
    tangential = np.where(normal[:, None] > 0.0, state.tangential, 0.0)
    traction = conditions.world(normal, tangential)
    slip_size = np.linalg.norm(state.slip, axis=1)
    sliding = (normal > 0.0) & ~friction.stick & (slip_size > 0.0)
    scale = max(state.elastic, 1e-300)
    frictional = sliding & (not system.friction.none) & (slip_size > _ROUND_OFF * scale)
    unit, slip = direction[frictional], state.slip[frictional] / slip_size[frictional, None]
    sine = np.abs(unit[:, 0] * slip[:, 1] - unit[:, 1] * slip[:, 0])
    angle = np.arctan2(sine, -np.einsum("ij,ij->i", unit, slip))
    layer = system.compliance.layer
    return NewtonOutcome(
        converged=True,
        message=f"converged in {iterations} iterations",
        iterations=iterations,
        traction=traction,
        holder_x=state.holder_x,
        height=state.height,
        tilt=state.tilt,
        sliding=sliding,
        slip_length=np.where(sliding, slip_size, 0.0),
        sticking=int((friction.stick & (normal > 0.0)).sum()),
        force_error=unbalanced_force(conditions, state, traction),
        penetration=float(max(0.0, float((layer * normal - state.gap).max())) / scale),
        complementarity=float(np.abs(state.gap[normal > 0.0]).max() / scale),
        slip_direction_error=float(angle.max()) if len(angle) else 0.0,
        elastic_slip=float(layer * np.linalg.norm(tangential, axis=1).max() / scale),
    )


def failed_outcome(conditions: ContactConditions, state: Iterate, iterations: int, message: str) -> NewtonOutcome:
    """The answer where no state was found, with a sentence that says why."""
    return NewtonOutcome(
        converged=False,
        message=message,
        iterations=iterations,
        traction=conditions.world(state.normal, state.tangential),
        holder_x=state.holder_x,
        height=state.height,
        tilt=state.tilt,
        sliding=np.zeros(conditions.count, dtype=bool),
        slip_length=np.zeros(conditions.count),
        sticking=0,
        force_error=np.inf,
        penetration=np.inf,
        complementarity=np.inf,
        slip_direction_error=np.inf,
        elastic_slip=np.inf,
    )
