"""Slip along a planar contact over a cycle, from the states between increments."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from solvers import ContactProblem, ContactState
from solvers.contact.gaps import facing_offset

Array = NDArray[np.float64]


def slip_amplitude(problem: ContactProblem, states: Sequence[ContactState]) -> Array:
    """A quarter of the path that each point of the upper body slides over a closed cycle while it is in contact, mm.

    Where contact lasts, that is the amplitude of slip. The upper body must be the primary one.

    states: before the cycle and after each of its increments.  Returns (n,), at the primary's nodes.
    """
    places = np.array([faced_place(problem, state) for state in states])
    pressed = np.array([state.traction[:, 2] > 0.0 for state in states[1:]])
    return np.asarray(0.25 * np.where(pressed, np.abs(np.diff(places, axis=0)), 0.0).sum(axis=0))


def faced_place(problem: ContactProblem, state: ContactState) -> Array:
    """Place on the undeformed lower body that each node of the upper one faces, (n,), mm along x.

    X + u_lower(X) = x + u_upper(x) + holder - drive, with u_lower taken where the increment paired the node: strains
    are small.
    """
    upper = (problem.upper.compliance @ state.primary_force.ravel())[0::3]
    lower = (problem.lower.compliance @ -state.secondary_force.ravel())[0::3]
    own, other = problem.upper.node_positions[:, 0], problem.lower.node_positions[:, 0]
    paired = own - facing_offset(problem, state, state.drive, state.holder_x)[0]
    return np.asarray(own + state.holder_x - state.drive + upper - np.interp(paired, other, lower))
