"""Vertical gaps between the undeformed bodies, as wear and the holder's tilt have left them."""

from dataclasses import replace

import numpy as np

from geometry.arrays import Array, IntArray
from solvers.contact.problem import ContactProblem
from solvers.contact_layer import open_share
from solvers.contact_state import ContactState
from solvers.pairing import Pairing, pair, vertical_gap


def open_depths(problem: ContactProblem, state: ContactState) -> tuple[Array, Array]:
    """Worn depth of the primary and the secondary body without what layers fill."""
    share = open_share(problem.layers)
    if share == 1.0:
        return state.wear.primary_depth, state.wear.secondary_depth
    return share * state.wear.primary_depth, share * state.wear.secondary_depth


def vertical_gaps(problem: ContactProblem, state: ContactState, drive: float, holder_x: float) -> Array:
    """Gap at the primary's n nodes with the holder at height 0, (n,), mm; infinite beside the secondary."""
    offset = facing_offset(problem, state, drive, holder_x)
    upright = vertical_gap(problem.surface, problem.secondary, offset, *open_depths(problem, state))
    return upright + state.holder_tilt * levers(problem, drive, holder_x)


def facing_offset(problem: ContactProblem, state: ContactState, drive: float, holder_x: float) -> Array:
    """Plane position (2,) of the secondary body's origin relative to the primary's where their surfaces meet.

    As long as a core sticks, its strain makes up for the motion of the bodies: the surfaces face each other as they
    were pressed together, and what has worn beside the core must not be moved over it.
    """
    if state.core.any():
        return problem.offset(state.pressed_ahead, 0.0)
    return problem.offset(drive, holder_x)


def faced(
    problem: ContactProblem, state: ContactState, nodes: IntArray, drive: float, holder_x: float, tilt: float
) -> Pairing:
    """Nodes (k,) of the primary as they face the secondary, on the surfaces and after the sticking of a state."""
    core = bool(state.core.any())
    offset, depths = facing_offset(problem, state, drive, holder_x), open_depths(problem, state)
    pairing = pair(problem.surface, problem.secondary, nodes, offset, *depths, tilt, at_nodes=core)
    if not core:
        return pairing
    # What sticks stands as it stood: what has worn beside the core must neither open it, as it would where a node lies
    # between one of the other body that sticks and one that has worn, nor turn its normals.
    sticks = np.flatnonzero(state.core[nodes])
    facing = pairing.depths.at_heaviest(sticks)
    faced_depth = facing.averaged(depths[1].ravel()) / pairing.areas
    opened = faced_depth - pairing.depths.averaged(depths[1].ravel()) / pairing.areas
    inside = _no_deeper(depths[0], depths[0].ravel()[nodes[sticks]]), _no_deeper(depths[1], faced_depth[sticks])
    frames = pairing.frames.copy()
    frames[sticks] = pair(problem.surface, problem.secondary, nodes[sticks], offset, *inside, tilt).frames
    # What strain makes up for is motion along the surfaces, up and down their slope.
    normals = frames[:, 0, :]
    rate = normals[:, 0] / normals[:, 2]
    moved = holder_x - drive + state.pressed_ahead
    return replace(pairing, frames=frames, gap=pairing.gap + opened + rate * moved, gap_rate=rate, depths=facing)


def _no_deeper(depth: Array, core: Array) -> Array:
    """Worn depths (n_a, n_t) cut to the largest in the core."""
    return np.asarray(np.minimum(depth, core.max(initial=0.0)))


def levers(problem: ContactProblem, drive: float, holder_x: float) -> Array:
    """Distance of the primary's nodes ahead of the holder's pivot, along x, shape (n,)."""
    along = problem.primary.node_positions[:, 0]
    return along if problem.primary_is_upper else along - problem.offset(drive, holder_x)[0]
