"""Friction work, wear work and slipped length of an increment, node by node, by the trapezoidal rule in time.

Half of each stands where nodes were paired at the increment's start, with the pressures and faces of then, half where
they are at its end. Slip takes part only at the friction limit: a node that first sticks and then slips dissipates the
limit times its slip, not the mean of its tractions. Small-strain normals do not turn with the loaded surfaces, so that
sliding nodes move a little along them; the pressure's work on that motion, of the order of the elastic strain, belongs
to the dissipation: without it the area of a closed loop and the friction work differ by that strain over friction,
0.3 % under a fresh Hertz contact of steel wires. It is left out where a node opens or closes; what layers close by
is no such motion, but is stored.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from solvers.contact.gaps import levers
from solvers.contact.linearisation import layers_between
from solvers.contact.problem import ContactProblem
from solvers.contact_state import ContactState
from solvers.newton import Linearisation, NewtonOutcome
from solvers.pairing import Pairing
from solvers.wear import Sliding

Array = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


def slid(
    problem: ContactProblem,
    state: ContactState,
    system: Linearisation,
    outcome: NewtonOutcome,
    drive: float,
) -> tuple[Sliding, Sliding]:
    """The sliding of an increment from `state` to its outcome at `drive`: at its start and at its end."""
    end, start = system.pairing, system.before
    moved_end, moved_start = system.compliance.moved(outcome.traction)
    step_x = outcome.holder_x - state.holder_x - (drive - state.drive)
    step_z, step_tilt = outcome.height - state.holder_z, outcome.tilt - state.holder_tilt
    old_levers = levers(problem, state.drive, state.holder_x)[start.nodes]
    for moved, lever in ((moved_end, system.lever), (moved_start, old_levers)):
        moved[:, 0] += step_x
        moved[:, 2] += step_z + lever * step_tilt
    size = problem.primary.patch.size
    loaded = np.zeros(size, dtype=bool)
    loaded[start.nodes] = True
    pressed = outcome.traction[:, 2] > 0.0
    still, sticks = np.zeros(size, dtype=bool), np.zeros(size, dtype=bool)
    still[end.nodes[pressed]] = True
    sticks[end.nodes[pressed & ~outcome.sliding]] = True
    normals = end.frames[:, 0, :]
    pressure = np.einsum("ij,ij->i", outcome.traction, normals)
    along = np.einsum("ij,ij->i", moved_end, normals)
    if system.layers is not None:
        old = np.einsum("ij,ij->i", state.traction[end.nodes], normals)
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
    if not problem.law.none:
        energy = np.maximum(energy - pressure * lifted, 0.0)
    if problem.wear.law == "energy":
        return Sliding(pairing, energy, energy, length)
    return Sliding(pairing, energy, pressure * length, length)


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
    normals, traction = start.frames[:, 0, :], state.traction[start.nodes]
    after = np.zeros_like(state.traction)
    after[system.pairing.nodes] = outcome.traction
    lifted = np.einsum("ij,ij->i", moved, normals)
    slip = moved + problem.layer_mm_per_MPa * (after[start.nodes] - traction)
    if problem.layers:
        layers, before = (layers_between(problem, state, start, loads) for loads in (after[start.nodes], traction))
        slip += layers.old_displacement - before.old_displacement
        closed, closed_before = (
            layers.closure(np.einsum("ij,ij->i", loads, normals))[0] for loads in (after[start.nodes], traction)
        )
        lifted += closed - closed_before
    slip -= np.einsum("ij,ij->i", slip, normals)[:, None] * normals
    length = np.where(sticks, 0.0, 0.5 * np.linalg.norm(slip, axis=1))
    pressure = np.maximum(np.einsum("ij,ij->i", traction, normals), 0.0)
    return _sliding(problem, start, pressure, length, np.where(still_loaded & ~sticks, 0.5 * lifted, 0.0))
