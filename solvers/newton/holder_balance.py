"""Equilibrium of the holder under the tractions: its equations, and by how much a state misses them.

Free play of the holder is one more alternative beside those of the nodes: it floats without force, or rests on either
stop.
"""

import numpy as np

from geometry.arrays import Array, IntArray
from solvers.kept_code import inlined
from solvers.newton.conditions import ContactConditions, Iterate
from solvers.newton.terms import Carried, HolderTerms, Nodes


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


def held_place(conditions: ContactConditions, stop: int) -> float | None:
    """Where in its free play the holder is held, mm; None while it floats."""
    system = conditions.system
    if system.holder.play_mm == 0.0:
        return 0.0
    if system.friction.none:
        # Nothing else would hold it.
        return system.old_place_in_play
    return 0.5 * stop * system.holder.play_mm if stop else None


@inlined
def fill_holder_rows(
    transposed: Array, rhs: Array, nodes: Nodes, carried: Carried, holder: HolderTerms, on: IntArray, tan: IntArray
) -> None:
    """Write the last three rows: tractions against the load, and against the rig's springs."""
    size = len(rhs)
    z, x, t = size - 3, size - 2, size - 1
    for place in range(size - 3):
        tangent = 0 if place < len(on) else 1 + (place - len(on)) // len(tan)
        node = on[place] if tangent == 0 else tan[(place - len(on)) % len(tan)]
        along, up = carried.per_normal[node, 0], carried.per_normal[node, 2]
        if tangent > 0:
            along, up = nodes.frames[node, tangent, 0], nodes.frames[node, tangent, 2]
        along, up = nodes.areas[node] * along, nodes.areas[node] * up
        transposed[place, z], transposed[place, x] = up, along
        transposed[place, t] = nodes.lever[node] * up + holder.pivot_mm * along
    lift = pull = moment = 0.0
    if carried.shifted:
        for node in range(len(nodes.areas)):
            along, up = nodes.areas[node] * carried.constant[node, 0], nodes.areas[node] * carried.constant[node, 2]
            lift, pull = lift + up, pull + along
            moment += nodes.lever[node] * up + holder.pivot_mm * along
    # The load, which acts through the pivot, leans on the contact that rotation has carried sideways.
    transposed[t, t] += holder.normal_load_N * holder.pivot_mm
    floats, prescribed = np.isnan(holder.held_mm), not np.isnan(holder.height_mm)
    compliance = holder.series_mm_per_N if floats else holder.tangential_mm_per_N
    for place in range(size):
        transposed[place, t] *= holder.rotational_rad_per_N_mm
        transposed[place, x] *= compliance
        if prescribed:
            transposed[place, z] = 0.0
    transposed[t, t] -= 1.0
    rhs[t] -= moment * holder.rotational_rad_per_N_mm
    rhs[x] = -pull * compliance
    if not floats:
        # The contact moves with the holder's translation and with its rotation about the pivot.
        transposed[x, x] -= 1.0
        transposed[t, x] += holder.pivot_mm
        rhs[x] -= holder.held_mm
    transposed[z, z] += 1.0 if prescribed else -holder.normal_N_per_mm
    rhs[z] = holder.height_mm if prescribed else holder.load_N - lift
    if not np.isnan(holder.rigid_x_mm):
        rhs[x] = holder.rigid_x_mm


def unbalanced_force(conditions: ContactConditions, state: Iterate, traction: Array) -> float:
    """Largest unbalanced force on the holder by tractions (k, 3) over the normal force."""
    system, areas, holder = conditions.system, conditions.areas, conditions.system.holder
    force = areas @ traction
    expected = holder.load_N(state.height, system.pressed_height) if system.prescribed_height is None else force[2]
    errors = [abs(force[2] - expected)]
    held = held_place(conditions, stop_in_play(conditions, state))
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
