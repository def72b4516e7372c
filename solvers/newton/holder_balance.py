"""Equilibrium of the holder under the tractions: its equations, and by how much a state misses them.

Free play of the holder is one more alternative beside those of the nodes: it floats without force, or rests on either
stop.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from solvers.compiled import compiled
from solvers.newton.carried import Carried
from solvers.newton.conditions import ContactConditions, Iterate
from solvers.newton.system import Linearisation
from solvers.newton.unknowns import Unknowns

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


def stop_in_play(conditions: ContactConditions, state: Iterate) -> int:
    """Which stop of its free play the holder rests on: +1 or -1, or 0 while it floats between them."""
    holder = conditions.system.holder
    if holder.play_mm == 0.0:
        return 0
    force = float(conditions.areas @ conditions.world(state.normal, state.tangential)[:, 0])
    place = holder.place_in_play_mm(state.holder_x, state.tilt, force)
    # On a stop the place is the stop's, floating the force is zero: the compliance between them only has to be
    # positive.
    trial = place + conditions.scales.series_compliance * force
    return int(trial > 0.5 * holder.play_mm) - int(trial < -0.5 * holder.play_mm)


def _held_place(conditions: ContactConditions, stop: int) -> float | None:
    """Where in its free play the holder is held, mm; None while it floats."""
    system = conditions.system
    if system.holder.play_mm == 0.0:
        return 0.0
    if system.friction.none:
        # Nothing else would hold it.
        return system.old_place_in_play
    return 0.5 * stop * system.holder.play_mm if stop else None


def fill_holder_rows(
    matrix: Array, rhs: Array, conditions: ContactConditions, unknowns: Unknowns, carried: Carried, stop: int
) -> None:
    """Write the last three rows: tractions against the load, and against the rig's springs.

    carried: tractions of the nodes by their normal ones.
    """
    system, w, holder = conditions.system, conditions.areas, conditions.system.holder
    on, tan = unknowns.on, unknowns.tan
    z, x, t = unknowns.z, unknowns.x, unknowns.t
    _fill_loads(matrix.T, on, tan, w, system.lever, carried.per_normal, system.pairing.frames, holder.pivot_height_mm)
    # The load, which acts through the pivot, leans on the contact that rotation has carried sideways.
    matrix[t, t] += holder.normal_load_N * holder.pivot_height_mm
    matrix[t] *= holder.rotational_compliance_rad_per_N_mm
    matrix[t, t] -= 1.0
    constant = np.zeros(3) if carried.constant is None else _loads_of(carried.constant, system, w)
    rhs[t] -= constant[2] * holder.rotational_compliance_rad_per_N_mm
    matrix[z, z] -= holder.normal_stiffness_N_per_mm
    rhs[z] = holder.load_N(0.0, system.pressed_height) - constant[0]
    held = _held_place(conditions, stop)
    if held is None:
        matrix[x] *= conditions.scales.series_compliance
        rhs[x] = -constant[1] * conditions.scales.series_compliance
    else:
        # The contact moves with the holder's translation and with its rotation about the pivot.
        matrix[x] *= holder.tangential_compliance_mm_per_N
        matrix[x, x] -= 1.0
        matrix[x, t] += holder.pivot_height_mm
        rhs[x] = -held - constant[1] * holder.tangential_compliance_mm_per_N
    if system.prescribed_height is not None:
        matrix[z] = 0.0
        matrix[z, z], rhs[z] = 1.0, system.prescribed_height
    if holder.tangential_compliance_mm_per_N == 0.0 and holder.play_mm == 0.0:
        rhs[x] = holder.pivot_height_mm * system.old_tilt - system.old_holder_x


@compiled
def _fill_loads(
    transposed: Array,
    on: IntArray,
    tan: IntArray,
    areas: Array,
    lever: Array,
    per_normal: Array,
    frames: Array,
    pivot_height: float,
) -> None:
    """Write what tractions contribute to the last three rows: normal and tangential force, moment about the pivot."""
    z = transposed.shape[1] - 3
    for place in range(len(on) + 2 * len(tan)):
        tangent = 0 if place < len(on) else 1 + (place - len(on)) // len(tan)
        node = on[place] if tangent == 0 else tan[(place - len(on)) % len(tan)]
        along, up = per_normal[node, 0], per_normal[node, 2]
        if tangent > 0:
            along, up = frames[node, tangent, 0], frames[node, tangent, 2]
        along, up = areas[node] * along, areas[node] * up
        transposed[place, z], transposed[place, z + 1] = up, along
        transposed[place, z + 2] = lever[node] * up + pivot_height * along


def _loads_of(tractions: Array, system: Linearisation, areas: Array) -> Array:
    """Normal force, tangential force and moment about the pivot of tractions (k, 3), shape (3,)."""
    force = areas @ tractions
    moment = (areas * system.lever) @ tractions[:, 2] + system.holder.pivot_height_mm * force[0]
    return np.array([force[2], force[0], moment])


def unbalanced_force(conditions: ContactConditions, state: Iterate, traction: Array) -> float:
    """Largest unbalanced force on the holder by tractions (k, 3) over the normal force."""
    system, areas, holder = conditions.system, conditions.areas, conditions.system.holder
    force = areas @ traction
    expected = holder.load_N(state.height, system.pressed_height) if system.prescribed_height is None else force[2]
    errors = [abs(force[2] - expected)]
    held = _held_place(conditions, stop_in_play(conditions, state))
    if held is None:
        errors.append(abs(force[0]))
    elif holder.tangential_compliance_mm_per_N > 0.0:
        translation = state.holder_x - holder.pivot_height_mm * state.tilt - held
        errors.append(abs(force[0] - translation / holder.tangential_compliance_mm_per_N))
    if holder.rotational_compliance_rad_per_N_mm > 0.0 and holder.pivot_height_mm > 0.0:
        moment = holder.pivot_height_mm * force[0] + (areas * system.lever) @ traction[:, 2]
        moment += holder.pivot_height_mm * holder.normal_load_N * state.tilt
        resisted = state.tilt / holder.rotational_compliance_rad_per_N_mm
        errors.append(abs(moment - resisted) / holder.pivot_height_mm)
    return float(max(errors) / max(abs(expected), 1e-300))
