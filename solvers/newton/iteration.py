"""Newton iterations in which nodes change their status (open, stick, slip) until none changes and the tolerances are
met.
"""

from typing import NamedTuple

import numpy as np

from geometry.arrays import Array, BoolArray
from solvers.contact_conditions import LOST_CONTACT, ContactGuess, ContactOutcome, Linearisation
from solvers.jit_cache import compiled
from solvers.newton.conditions import NEAR_STICK, Changes, ContactConditions, stop_in_play, unbalanced_force
from solvers.newton.equations import newton_step
from solvers.newton.terms import Iterate

_ROUND_OFF = 1e-9  #: Slips shorter than this share of the bodies' elastic closure are round-off, and have no direction.

_MOST_ITERATIONS = 60
_PATIENCE = 15  # Iterations without progress after which the increment is given up.
_ROUND = 8  # Iterations without progress after which directions of slip are no longer iterated.


#: Allowed turn of friction in a step, rad, and the angle between friction and slip beyond which one more is taken.
_DIRECTION_TOLERANCE, _SLANTED = 1e-4, 1e-3

# Layers stiffen with the pressure: linearised where it is high, they ask for less than nothing where it should be low.
# Friction that bends with it is too steep where it is low: linearised there, it is too much where it should be high.
_LARGEST_FALL = 0.2

# Fewer nodes than this do not describe a contact.
_FEW_NODES = 10
_MESH_TOO_COARSE = "most likely the mesh is too coarse for this contact: take a smaller contact_mesh_um"


def converged_outcome(
    conditions: ContactConditions, before: Iterate, state: Iterate, iterations: int
) -> ContactOutcome:
    """The outcome of a converged `state`, with its residuals; `before`: the state before it, with nodes' status."""
    system, layer = conditions.system, conditions.system.compliance.layer
    scale = max(state.elastic, 1e-300)
    # Without friction slip has no direction to differ from.
    least = np.inf if system.friction.none else _ROUND_OFF * scale
    traction, sliding, slip_length, largest = _residuals(before, state, conditions.nodes.frames, layer, least)
    return ContactOutcome(
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
    """Residuals of a state.

    sticking: number of nodes. penetration, gap: deepest penetration, and largest gap of nodes under pressure, mm.
    turned: largest angle between friction and slip, rad. tangential: largest tangential traction, MPa.
    """

    sticking: int
    penetration: float
    gap: float
    turned: float
    tangential: float


@compiled
def _residuals(
    before: Iterate, state: Iterate, frames: Array, layer: float, least: float
) -> tuple[Array, BoolArray, Array, _Largest]:
    """Tractions (k, 3) in world axes, nodes that slide (k,), their slip lengths (k,) in mm, and the residuals.

    least: slip in mm below which its direction is round-off.
    """
    count, slip, direction, friction = len(frames), state.slip, before.direction, state.tangential
    traction, sliding, length = np.zeros((count, 3)), np.zeros(count, np.bool_), np.zeros(count)
    sticking, deepest, widest, turned, largest = 0, 0.0, 0.0, 0.0, 0.0
    for k in range(count):
        pressure = 0.0
        # Round-off may leave nodes on the verge of opening with a vanishing negative pressure.
        if before.active[k] and state.normal[k] > 0.0:
            pressure = state.normal[k]
            for c in range(3):
                sideways = friction[k, 0] * frames[k, 1, c] + friction[k, 1] * frames[k, 2, c]
                traction[k, c] = pressure * frames[k, 0, c] + sideways
            widest = max(widest, abs(state.gap[k]))
            largest = max(largest, np.sqrt(friction[k, 0] * friction[k, 0] + friction[k, 1] * friction[k, 1]))
            sticking += before.stick[k]
            size = np.sqrt(slip[k, 0] * slip[k, 0] + slip[k, 1] * slip[k, 1])
            if not before.stick[k] and size > 0.0:
                sliding[k], length[k] = True, size
                if size > least:
                    s0, s1 = slip[k, 0] / size, slip[k, 1] / size
                    sine = abs(direction[k, 0] * s1 - direction[k, 1] * s0)
                    turned = max(turned, np.arctan2(sine, -(direction[k, 0] * s0 + direction[k, 1] * s1)))
        deepest = max(deepest, layer * pressure - state.gap[k])
    return traction, sliding, length, _Largest(sticking, deepest, widest, turned, largest)


def failed_outcome(conditions: ContactConditions, state: Iterate, iterations: int, message: str) -> ContactOutcome:
    """The outcome if no state meets the conditions, with the tractions of the latest one; `message` is a sentence that
    says why.
    """
    return ContactOutcome(
        converged=False,
        message=message,
        iterations=iterations,
        traction=conditions.world(state.normal, state.tangential),
        holder_x=state.holder_x,
        height=state.height,
        tilt=state.tilt,
        sliding=np.zeros(len(state.gap), dtype=bool),
        slip_length=np.zeros(len(state.gap)),
        sticking=0,
        force_error=np.inf,
        penetration=np.inf,
        complementarity=np.inf,
        slip_direction_error=np.inf,
        elastic_slip=np.inf,
    )


def _bend(conditions: ContactConditions, before: Iterate, state: Iterate, about: Array) -> float:
    """Largest difference, at slipping nodes, of friction from the law's tangent at pressures `about` (k,), over the
    largest friction.
    """
    friction = conditions.system.friction
    if friction.law.proportional:
        return 0.0
    slipping = before.active & ~before.stick & (state.normal > 0.0)
    slope, offset = friction.tangent(about)
    largest = float(state.limit[slipping].max(initial=0.0))
    bent = np.abs(state.limit - offset - slope * state.normal)
    return float(bent[slipping].max()) / largest if largest > 0.0 else 0.0


class _Change(NamedTuple):
    """How far a state is from the one before."""

    nodes: Changes  #: Numbers of nodes that change their status, and more.
    #: Largest gap of nodes in contact, or slip of those that stick, over the largest elastic displacement.
    gap_error: float
    #: Largest difference of the friction law from its tangent at slipping nodes, over the largest friction.
    bend: float
    settled: bool  #: No node and no stop changes.

    @classmethod
    def of(
        cls, nodes: Changes, conditions: ContactConditions, before: Iterate, after: Iterate, about: Array
    ) -> "_Change":
        stays = stop_in_play(conditions, before) == stop_in_play(conditions, after)
        gap_error = nodes.gap / max(after.elastic, 1e-300)
        return cls(nodes, gap_error, _bend(conditions, before, after, about), nodes.changing == 0 and stays)

    @property
    def converged(self) -> bool:
        # Allowed gap of loaded nodes over the largest elastic displacement, and unbalanced force over the load.
        return self.settled and max(self.gap_error, self.bend) <= 1e-5 and self.nodes.turned <= _DIRECTION_TOLERANCE

    @property
    def error(self) -> float:
        """Distance from the solution: 1 + the number of nodes that change between open, stick and slip or, once none
        does, the largest relative residual.
        """
        if self.settled:
            return max(self.gap_error, self.nodes.turned, self.bend)
        return 1.0 + float(self.nodes.changing)

    def sentence(self, iterations: int) -> str:
        return (
            f"after {iterations} iterations {self.nodes.opening} nodes still open or close, "
            f"{self.nodes.sticking} change between stick and slip, the largest gap error is "
            f"{self.gap_error:.1e} and the slip direction turns by {self.nodes.turned:.1e} rad"
        )

    def likeliest_cause(self, conditions: ContactConditions, state: Iterate) -> str:
        """The most probable reason why an increment does not converge, as part of a sentence."""
        system = conditions.system
        if state.touching < _FEW_NODES:
            return _MESH_TOO_COARSE
        if self.nodes.sticking > self.nodes.opening:
            # Friction may fall along a stroke on a rig that gives way: under a held approach, or with the area.
            falls = system.prescribed_height is not None or not system.friction.law.proportional
            if conditions.scales.rig > 0.0 and falls:
                return (
                    "most likely friction falls along the stroke faster than the rig's spring follows, so that the rig "
                    "would snap: take a stiffer rig or, if the approach is held, a load in its place"
                )
            return (
                "most likely the nodes flicker between stick and slip because the increments are long against the "
                "elastic motion: take more increments_per_cycle"
            )
        if self.nodes.opening:
            return (
                "most likely the contact's edge flickers because one increment wears or moves the surfaces too far: "
                "take a smaller jump_tolerance or more increments_per_cycle"
            )
        return "most likely the direction of slip turns too far within the increment: take more increments_per_cycle"


class SemismoothNewton:
    """Newton's method for contact conditions that change with the status of nodes; see `solvers.contact_conditions`."""

    def solve_contact(self, system: Linearisation, guess: ContactGuess, /) -> ContactOutcome:
        """Tractions and holder position of a pairing; the outcome says if they `converged`, in 60 steps, or why not."""
        height = guess.height if system.prescribed_height is None else system.prescribed_height
        conditions = ContactConditions(system, guess.active)
        before = state = conditions.first(guess.traction, height, guess.holder_x, guess.active)
        best, best_at, once_more, linear = np.inf, 0, True, state.normal
        for iteration in range(1, _MOST_ITERATIONS + 1):
            if not before.touching:
                return failed_outcome(conditions, state, iteration, LOST_CONTACT)
            near_stick = NEAR_STICK
            if iteration - best_at > _ROUND:
                # What is left to iterate does not settle: directions of all nodes are found by Newton's method.
                # Friction that moves a rig may part nodes that it closes, but only while they are little pressed.
                near_stick, linear = np.inf, np.where(linear > 0.0, linear, conditions.scales.pressure)
            solution = newton_step(conditions, before, linear)
            if solution is None:
                singular = f"the contact's equations became singular with {before.touching} nodes in contact"
                return failed_outcome(conditions, state, iteration, f"{singular}; {_MESH_TOO_COARSE}")
            held = before.active, before.stick, before.direction
            state, changes = conditions.judged(solution, near_stick, held, about=linear)
            change = _Change.of(changes, conditions, before, state, linear)
            linear = np.maximum(state.normal, _LARGEST_FALL * linear)
            if change.converged:
                outcome = converged_outcome(conditions, before, state, iteration)
                # Where nodes barely slip, a slip turns much more than the friction that has settled.
                if outcome.slip_direction_error <= _SLANTED or not once_more:
                    return outcome
                once_more = False
            if change.error < 0.9 * best:
                best, best_at = change.error, iteration
            elif iteration - best_at > _PATIENCE:
                break
            before = state
        cause = change.likeliest_cause(conditions, state)
        return failed_outcome(conditions, state, iteration, f"{change.sentence(iteration)}; {cause}")
