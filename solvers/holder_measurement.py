"""What a loop shows of the holder: the stiffness of each of its elements, fitted to simulated states."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geometry.arrays import Array
from solvers.contact import ContactProblem
from solvers.contact_state import ContactState
from solvers.errors import SolverError

# Forces below this share of the largest tell nothing of a spring.
_LEAST_FORCE = 0.05
_LEAST_SHARE_OF_LOAD = 1e-6


@dataclass(frozen=True)
class HolderElements:
    """The elements in series between the contact and the ground; rigid ones have an infinite stiffness.

    contact_stiffness_N_per_mm: of spring and rotation together as the contact feels them; play apart.
    """

    tangential_stiffness_N_per_mm: float
    rotational_stiffness_N_mm_per_rad: float
    play_mm: float
    contact_stiffness_N_per_mm: float


def measured_holder(problem: ContactProblem, states: Sequence[ContactState]) -> HolderElements:
    """Least squares of each element's motion over the force or moment that it carries, from the states of a loop.

    The translation is fitted by C Q + (g/2) sign(Q), the tilt by the moment about the pivot over K_theta.
    Raises SolverError if the states carry no tangential force in both directions.
    """
    holder = problem.holder
    force = np.array([state.primary_force[:, 0].sum() for state in states])
    least = _LEAST_SHARE_OF_LOAD * holder.normal_load_N
    if not force.min() < -least < least < force.max():
        raise SolverError("the holder's elements can only be measured from states with forces in both directions")
    loaded = np.abs(force) > _LEAST_FORCE * float(np.abs(force).max())
    tilt = np.array([state.holder_tilt for state in states])
    moved = np.array([state.holder_x for state in states])
    translation = moved - holder.pivot_height_mm * tilt
    moment = np.array([_moment(problem, state) for state in states])
    spring, half_play = _fit(np.column_stack([force, np.sign(force)])[loaded], translation[loaded])
    (rotation,) = _fit(moment[loaded, None], tilt[loaded])
    (together, _) = _fit(np.column_stack([force, np.sign(force)])[loaded], moved[loaded])
    return HolderElements(_stiffness(spring), _stiffness(rotation), 2.0 * half_play, _stiffness(together))


def _moment(problem: ContactProblem, state: ContactState) -> float:
    """Moment about the holder's pivot of the contact's forces and of the load that leans on them, N mm."""
    force = state.primary_force
    ahead = 0.0 if problem.primary_is_upper else problem.offset(state.drive, state.holder_x)[0]
    lever = problem.primary.node_positions[:, 0] - ahead
    sideways = force[:, 0].sum() + problem.holder.normal_load_N * state.holder_tilt
    return float(problem.holder.pivot_height_mm * sideways + lever @ force[:, 2])


def _fit(columns: Array, values: Array) -> list[float]:
    solution, *_ = np.linalg.lstsq(columns, values, rcond=None)
    # Round-off of a rigid element is no compliance.
    return [float(x) if abs(x) > 1e-13 else 0.0 for x in solution]


def _stiffness(compliance: float) -> float:
    return 1.0 / compliance if compliance else float("inf")
