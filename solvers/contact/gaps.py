"""Vertical gaps between the undeformed bodies, as wear and the holder's tilt have left them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from solvers.contact.problem import ContactProblem
from solvers.contact_layer import open_share
from solvers.contact_state import ContactState
from solvers.pairing import vertical_gap

Array = NDArray[np.float64]


def open_depths(problem: ContactProblem, state: ContactState) -> tuple[Array, Array]:
    """Worn depth of the primary and the secondary body without what layers fill."""
    share = open_share(problem.layers)
    return share * state.wear.primary_depth, share * state.wear.secondary_depth


def vertical_gaps(problem: ContactProblem, state: ContactState, drive: float, holder_x: float) -> Array:
    """Gap at the primary's n nodes with the holder at height 0, (n,), mm; infinite beside the secondary."""
    offset = problem.offset(drive, holder_x)
    upright = vertical_gap(problem.surface, problem.secondary, offset, *open_depths(problem, state))
    return upright + state.holder_tilt * levers(problem, drive, holder_x)


def levers(problem: ContactProblem, drive: float, holder_x: float) -> Array:
    """Distance of the primary's nodes ahead of the holder's pivot, along x, shape (n,)."""
    along = problem.primary.node_positions[:, 0]
    return along if problem.primary_is_upper else along - problem.offset(drive, holder_x)[0]
