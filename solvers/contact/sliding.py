"""Friction work, wear work and slipped length of an increment, node by node, by the trapezoidal rule in time.

Half of each stands where nodes were paired at the increment's start, with the pressures and faces of then, half where
they are at its end. Slip takes part only at the friction limit: a node that first sticks and then slips dissipates the
limit times its slip, not the mean of its tractions. Small-strain normals do not turn with the loaded surfaces, so that
sliding nodes move a little along them. The pressure's work on that motion is of no node's own: most of it is given
back at other nodes and places. What is left of it over a closed loop, the elastic strain's share, belongs to the loop's
area: 0.3 % of it under a fresh Hertz contact of steel wires. It is left out where a node opens or closes; what layers
close by is no such motion, but is stored.
"""

import numpy as np

from geometry.arrays import Array, BoolArray
from solvers.contact.gaps import levers
from solvers.contact.linearisation import layers_between
from solvers.contact.problem import ContactProblem
from solvers.contact_state import ContactState
from solvers.kept_code import compiled
from solvers.newton import Linearisation, NewtonOutcome
from solvers.pairing import Pairing
from solvers.wear import Sliding


def slid(
    problem: ContactProblem,
    state: ContactState,
    system: Linearisation,
    outcome: NewtonOutcome,
    drive: float,
    forces: tuple[Array, Array],
) -> tuple[Sliding, Sliding]:
    """The sliding of an increment from `state` to its outcome at `drive`: at its start and at its end.

    forces: (n, 3) nodal ones on the primary and the secondary patch at its end.
    """
    end, start = system.pairing, system.before
    moved_end, moved_start = system.compliance.moved(outcome.traction, forces)
    step_x = outcome.holder_x - state.holder_x - (drive - state.drive)
    step_z, step_tilt = outcome.height - state.holder_z, outcome.tilt - state.holder_tilt
    old_levers = levers(problem, state.drive, state.holder_x)[start.nodes]
    for moved, lever in ((moved_end, system.lever), (moved_start, old_levers)):
        _add_holder(moved, lever, step_x, step_z, step_tilt)
    size = problem.primary.patch.size
    loaded = np.zeros(size, dtype=bool)
    loaded[start.nodes] = True
    pressed = outcome.traction[:, 2] > 0.0
    still, sticks = np.zeros(size, dtype=bool), np.zeros(size, dtype=bool)
    still[end.nodes[pressed]] = True
    sticks[end.nodes[pressed & ~outcome.sliding]] = True
    pressure, along = _along(outcome.traction, end.frames), _along(moved_end, end.frames)
    if system.layers is not None:
        old = _along(state.traction[end.nodes], end.frames)
        along += system.layers.closure(pressure)[0] - system.layers.closure(old)[0]
    last = _sliding(
        problem,
        end,
        pressure,
        0.5 * outcome.slip_length,
        np.where(outcome.sliding & loaded[end.nodes], 0.5 * along, 0.0),
    )
    return _first_half(problem, state, system, outcome, moved_start, still[start.nodes], sticks[start.nodes]), last


def _sliding(problem: ContactProblem, pairing: Pairing, pressure: Array, length: Array, lifted: Array) -> Sliding:
    """Sliding of nodes under pressure (k,) MPa along a length (k,), while they move along their normals, both in mm."""
    energy = problem.law.limit(pressure) * length
    wear_work = energy if problem.wear.law == "energy" else pressure * length
    return Sliding(pairing, energy, wear_work, length, 0.0 * energy if problem.law.none else pressure * lifted)


def _first_half(
    problem: ContactProblem,
    state: ContactState,
    system: Linearisation,
    outcome: NewtonOutcome,
    moved: Array,
    still_loaded: BoolArray,
    sticks: BoolArray,
) -> Sliding:
    """Sliding at the nodes loaded at the increment's start, which move by `moved` (l, 3)."""
    start = system.before
    traction, lifted, slip = state.traction[start.nodes], _along(moved, start.frames), moved
    if problem.layers or problem.layer_mm_per_MPa != 0.0:
        everywhere = np.zeros_like(state.traction)
        everywhere[system.pairing.nodes] = outcome.traction
        after = everywhere[start.nodes]
        slip = moved + problem.layer_mm_per_MPa * (after - traction)
        if problem.layers:
            layers, before = (layers_between(problem, state, start, loads) for loads in (after, traction))
            slip += layers.old_displacement - before.old_displacement
            closed, closed_before = (layers.closure(_along(loads, start.frames))[0] for loads in (after, traction))
            lifted += closed - closed_before
    length = np.where(sticks, 0.0, 0.5 * _tangential_size(slip, start.frames))
    pressure = np.maximum(_along(traction, start.frames), 0.0)
    return _sliding(problem, start, pressure, length, np.where(still_loaded & ~sticks, 0.5 * lifted, 0.0))


@compiled
def _add_holder(moved: Array, lever: Array, x: float, z: float, tilt: float) -> None:
    """Add a motion of the holder to that of nodes (k, 3)."""
    for k in range(len(moved)):
        moved[k, 0] += x
        moved[k, 2] += z + lever[k] * tilt


@compiled
def _along(vectors: Array, frames: Array) -> Array:
    """Normal components (k,) of vectors (k, 3)."""
    result = np.empty(len(vectors))
    for k in range(len(vectors)):
        normal = frames[k, 0]
        result[k] = vectors[k, 0] * normal[0] + vectors[k, 1] * normal[1] + vectors[k, 2] * normal[2]
    return result


@compiled
def _tangential_size(vectors: Array, frames: Array) -> Array:
    """Sizes (k,) of what vectors (k, 3) are in the tangent planes."""
    result = np.empty(len(vectors))
    for k in range(len(vectors)):
        n0, n1, n2 = frames[k, 0, 0], frames[k, 0, 1], frames[k, 0, 2]
        along = vectors[k, 0] * n0 + vectors[k, 1] * n1 + vectors[k, 2] * n2
        x, y, z = vectors[k, 0] - along * n0, vectors[k, 1] - along * n1, vectors[k, 2] - along * n2
        result[k] = np.sqrt(x * x + y * y + z * z)
    return result
