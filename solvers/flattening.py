"""Surfaces flattened together before any wear: where unworn shapes overlap at an approach, both give way by half.

A body is flattened wherever the other one presses on it during the stroke. The rest of the shapes then conform
within the overlap, as after plastic contact without pile-up (Johnson, Contact Mechanics (1985), ch. 6).
"""

from dataclasses import replace

import numpy as np

from geometry.arrays import Array
from solvers.contact import ContactProblem
from solvers.contact_state import ContactState
from solvers.pairing import PrimarySurface, primary_surface, vertical_gap

# Positions along the stroke at which the other body presses, per half-width of the flattened spot.
_PER_HALF_WIDTH = 4.0


def flattened(
    problem: ContactProblem, state: ContactState, approach_mm: float, slip_amplitude_mm: float
) -> ContactState:
    """The state of unloaded bodies with both surfaces flattened by a common approach, at all places of the stroke.

    The depths count as worn, and their volumes as taken by wear, so that volumes close.
    """
    if approach_mm == 0.0:
        return state
    primary = _depth(problem.surface, problem, approach_mm, slip_amplitude_mm)
    secondary = _depth(primary_surface(problem.secondary), problem, approach_mm, slip_amplitude_mm)
    wear = replace(
        state.wear,
        primary_depth=state.wear.primary_depth + primary,
        secondary_depth=state.wear.secondary_depth + secondary,
        primary_volume_mm3=state.wear.primary_volume_mm3 + _volume(primary, problem.primary.patch.node_areas()),
        secondary_volume_mm3=state.wear.secondary_volume_mm3 + _volume(secondary, problem.secondary.patch.node_areas()),
    )
    return replace(state, wear=wear)


def _depth(surface: PrimarySurface, problem: ContactProblem, approach: float, amplitude: float) -> Array:
    """Half the largest overlap (n_a, n_t) at each node of that body over the stroke."""
    is_primary = surface.body is problem.primary
    other = problem.secondary if is_primary else problem.primary
    unworn = np.zeros(surface.body.patch.shape), np.zeros(other.patch.shape)
    at_rest = vertical_gap(surface, other, problem.offset(0.0, 0.0), *unworn)
    half_width = float(np.ptp(surface.body.node_positions[at_rest < approach, 0])) / 2.0 or amplitude
    count = 2 * int(np.ceil(_PER_HALF_WIDTH * amplitude / half_width)) + 1
    closest = at_rest
    for drive in np.linspace(-amplitude, amplitude, count):
        offset = problem.offset(float(drive), 0.0)
        closest = np.minimum(closest, vertical_gap(surface, other, offset if is_primary else -offset, *unworn))
    return 0.5 * np.maximum(approach - closest, 0.0).reshape(surface.body.patch.shape)


def _volume(depth: Array, areas: Array) -> float:
    return float(depth.ravel() @ areas)
