"""Bodies under a held approach whose wear has parted them: nothing holds them but the holder."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from solvers.contact.problem import ContactProblem
from solvers.contact_state import ContactState, IncrementReport


def parted(problem: ContactProblem, state: ContactState, drive: float) -> tuple[ContactState, IncrementReport]:
    """The state at `drive` of bodies that do not touch, and the report of it: no force, and the holder at rest."""
    stop = 0.5 * problem.holder.play_mm
    holder_x = float(np.clip(state.holder_x, -stop, stop))
    none = np.zeros_like(state.traction)
    apart = replace(
        state,
        drive=drive,
        holder_x=holder_x,
        holder_tilt=state.holder_tilt + problem.holder.tilt_per_motion_rad_per_mm * (holder_x - state.holder_x),
        holder_rate=0.0,
        overlap_area=0.0,
        traction=none,
        primary_force=none,
        secondary_force=np.zeros_like(state.secondary_force),
        core=np.zeros_like(state.core),
    )
    return apart, IncrementReport(
        drive=drive,
        tangential_force=0.0,
        normal_force=0.0,
        friction_work=0.0,
        iterations=0,
        pairings=0,
        active=0,
        sticking=0,
        contact_area=0.0,
        max_pressure=0.0,
        inner_pressure=0.0,
        half_width_x=0.0,
        half_width_y=0.0,
        force_error=0.0,
        penetration=0.0,
        complementarity=0.0,
        slip_direction_error=0.0,
        elastic_slip=0.0,
    )
