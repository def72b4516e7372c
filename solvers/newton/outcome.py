"""What the contact solver answers: tractions, the holder's position, and how well the conditions are met."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from geometry.arrays import Array, BoolArray
from solvers.kept_code import compiled
from solvers.newton.conditions import ContactConditions, FrictionStatus, Iterate
from solvers.newton.holder_balance import unbalanced_force

_ROUND_OFF = 1e-9  #: Slips shorter than this share of the bodies' elastic closure are round-off, and have no direction.

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
    system, layer = conditions.system, conditions.system.compliance.layer
    scale = max(state.elastic, 1e-300)
    # Without friction slip has no direction to differ from.
    least = np.inf if system.friction.none else _ROUND_OFF * scale
    normal, tangential, sliding, slip_length, largest = _residuals(
        active, friction.stick, friction.direction, state.normal, state.tangential, state.gap, state.slip, layer, least
    )
    traction = conditions.world(normal, tangential)
    return NewtonOutcome(
        converged=True,
        message=f"converged in {iterations} iterations",
        iterations=iterations,
        traction=traction,
        holder_x=state.holder_x,
        height=state.height,
        tilt=state.tilt,
        sliding=sliding,
        slip_length=slip_length,
        sticking=largest.sticking,
        force_error=unbalanced_force(conditions, state, traction),
        penetration=largest.penetration / scale,
        complementarity=largest.gap / scale,
        slip_direction_error=largest.turned,
        elastic_slip=layer * largest.tangential / scale,
    )


class _Largest(NamedTuple):
    """How well the conditions are met: nodes that stick, the deepest penetration and the largest gap under pressure in
    mm, the largest angle between friction and slip in rad, the largest tangential traction in MPa.
    """

    sticking: int
    penetration: float
    gap: float
    turned: float
    tangential: float


@compiled
def _residuals(
    active: BoolArray,
    stick: BoolArray,
    direction: Array,
    pressure: Array,
    friction: Array,
    gap: Array,
    slip: Array,
    layer: float,
    least: float,
) -> tuple[Array, Array, BoolArray, Array, _Largest]:
    """Tractions (k,) and (k, 2) of nodes in contact, which of them slide, how far, and the worst of all.

    least: slip of a direction, mm.
    """
    count = len(active)
    normal, tangential = np.zeros(count), np.zeros((count, 2))
    sliding, length = np.zeros(count, np.bool_), np.zeros(count)
    sticking, deepest, widest, turned, largest = 0, 0.0, 0.0, 0.0, 0.0
    for k in range(count):
        # Round-off may leave nodes on the verge of opening with a vanishing negative pressure.
        if active[k] and pressure[k] > 0.0:
            normal[k], tangential[k, 0], tangential[k, 1] = pressure[k], friction[k, 0], friction[k, 1]
            widest = max(widest, abs(gap[k]))
            largest = max(largest, np.sqrt(friction[k, 0] * friction[k, 0] + friction[k, 1] * friction[k, 1]))
            sticking += stick[k]
            size = np.sqrt(slip[k, 0] * slip[k, 0] + slip[k, 1] * slip[k, 1])
            if not stick[k] and size > 0.0:
                sliding[k], length[k] = True, size
                if size > least:
                    s0, s1 = slip[k, 0] / size, slip[k, 1] / size
                    sine = abs(direction[k, 0] * s1 - direction[k, 1] * s0)
                    turned = max(turned, np.arctan2(sine, -(direction[k, 0] * s0 + direction[k, 1] * s1)))
        deepest = max(deepest, layer * normal[k] - gap[k])
    return normal, tangential, sliding, length, _Largest(sticking, deepest, widest, turned, largest)


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
