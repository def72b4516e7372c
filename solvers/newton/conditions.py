"""The conditions of one pairing: gaps, slips and statuses of nodes under given tractions, and the holder's equilibrium.

Per node, with normal traction p, tangential traction q, mean gap g and mean slip s of the upper body against the
lower one over the increment:
    open: p = q = 0, g >= 0;  stick: g = 0, s = 0, |q| <= tau(p);  slip: g = 0, q = -tau(p) s / |s|,
with tau the friction law, mu p by Coulomb's.
The augmentation that decides between stick and slip is scaled with the whole compliance that a change of friction
meets, the rig's included; with the local one alone a soft rig makes nodes alternate between both slip directions.

Free play of the holder is one more alternative beside those of the nodes: it floats without force, or rests on either
stop.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from geometry.arrays import Array, BoolArray, IntArray
from solvers.kept_code import compiled, inlined
from solvers.newton.terms import Carried, HolderTerms, Linearisation, Nodes, nodes_of

# Slipping nodes keep their tangential unknowns while their slip is below this share of the displacement that full
# friction on all nodes would cause; beyond, iterating the direction mostly converges fast.
_NEAR_STICK = 2.0
_ROUND_OFF = 1e-12  # Of the largest friction: what is so near to its limit may stick or slip.


class Iterate(NamedTuple):
    """Tractions (k,) and (k, 2) in local frames, the holder's position, and what follows from them.

    gap, slip: (k,) and (k, 2).  elastic: largest elastic displacement.  Lengths in mm, tractions in MPa.
    """

    normal: Array
    tangential: Array
    height: float
    holder_x: float
    tilt: float
    gap: Array
    slip: Array
    elastic: float


class FrictionStatus(NamedTuple):
    """Nodes that stick (k,), those near enough to it to keep tangential unknowns (k,), direction of friction (k, 2).

    verge: (k,) nodes at their limit but for round-off, which may stick or slip as well.  follows: (k,) nodes in contact
    far from stick.  augmentation: (k,) MPa per mm of slip.  limit: (k,) of friction, MPa.
    """

    stick: BoolArray
    verge: BoolArray
    near_stick: BoolArray
    follows: BoolArray
    direction: Array
    augmentation: Array
    limit: Array


class Scales(NamedTuple):
    """What the augmentation and the equations are measured by.

    collective, local, rig: displacement by unit traction on all nodes, on one of them, and by what that moves the rig,
    mm per MPa.  series_compliance: of contact and rig, mm per N.  pressure: mean one, MPa.
    """

    collective: float
    local: float
    rig: float
    series_compliance: float
    pressure: float


@dataclass(frozen=True)
class ContactConditions:
    """The conditions on the k nodes of a pairing.

    going_round: what is left to iterate does not settle, so that Newton's method finds the directions of all nodes.
    """

    system: Linearisation
    scales: Scales
    going_round: bool = False

    @classmethod
    def of(cls, system: Linearisation, loaded: BoolArray) -> "ContactConditions":
        """The conditions, scaled as for a contact of the loaded nodes (k,)."""
        return cls(system, _scales(system, loaded))

    @cached_property
    def count(self) -> int:
        return len(self.system.pairing.nodes)

    @cached_property
    def normals(self) -> Array:
        """Unit normals, (k, 3)."""
        return self.system.pairing.frames[:, 0, :]

    @cached_property
    def tangents(self) -> Array:
        """Both unit tangents of each node, (k, 2, 3)."""
        return self.system.pairing.frames[:, 1:, :]

    @cached_property
    def nodes(self) -> Nodes:
        """The nodes as compiled functions take them."""
        return nodes_of(self.system)

    @property
    def areas(self) -> Array:
        """Plane areas of the nodes, mm², (k,)."""
        return self.system.pairing.areas

    def world(self, normal: Array, tangential: Array) -> Array:
        """Tractions (k, 3) in world axes."""
        return _world(normal, tangential, self.system.pairing.frames)

    @cached_property
    def holders(self) -> dict[int, HolderTerms]:
        """The holder as equations take it, by the stop on which it rests; so far as they were asked for."""
        return {}

    def judged(
        self,
        normal: Array,
        tangential: Array,
        height: float,
        holder_x: float,
        tilt: float,
        active: BoolArray | None = None,
    ) -> tuple[Iterate, BoolArray, FrictionStatus]:
        """Gaps and slips under these tractions at this position of the holder, the nodes (k,) that are pressed or
        overlap, and which of them, or of `active` ones (k,), stick, and where friction points.
        """
        layers, friction = self.system.layers, self.system.friction
        if layers is None:
            closure = softness = shear = self._no_layer
        else:
            (closure, softness), (shear, _) = layers.closure(normal), layers.shear_compliance(normal)
        elastic, limit = self.system.compliance.displacement(self.world(normal, tangential)), friction.limit(normal)
        gap, slip, largest, (touch, stick, verge, near, follows), direction, augmentation = _judged(
            *(elastic, self.nodes, self.scales, normal, tangential, height, holder_x, tilt),
            *(closure, softness, shear, limit, np.inf if self.going_round else _NEAR_STICK, friction.none),
            *(self._nowhere if active is None else active, active is not None),
        )
        state = Iterate(normal, tangential, height, holder_x, tilt, gap, slip, largest)
        return state, touch, FrictionStatus(stick, verge, near, follows, direction, augmentation, limit)

    @cached_property
    def _no_layer(self) -> Array:
        return np.zeros(self.count)

    @cached_property
    def _nowhere(self) -> BoolArray:
        return np.zeros(self.count, dtype=bool)


@compiled
def _world(normal: Array, tangential: Array, frames: Array) -> Array:
    result = np.empty((len(normal), 3))
    for k in range(len(normal)):
        for c in range(3):
            sideways = tangential[k, 0] * frames[k, 1, c] + tangential[k, 1] * frames[k, 2, c]
            result[k, c] = normal[k] * frames[k, 0, c] + sideways
    return result


@compiled
def _judged(
    elastic: Array,
    nodes: Nodes,
    scales: Scales,
    normal: Array,
    tangential: Array,
    height: float,
    holder_x: float,
    tilt: float,
    closure: Array,
    softness: Array,
    shear: Array,
    limit: Array,
    near_stick: float,
    frictionless: bool,
    chosen: BoolArray,
    given: bool,
) -> tuple[Array, Array, float, BoolArray, Array, Array]:
    """Gaps (k,) and slips (k, 2) under displacements (k, 3), and the largest component of these; nodes in contact, that
    stick, on the verge, near stick and that follow (5, k); direction of friction (k, 2), its augmentation (k,).

    closure, softness, shear: (k,) of layers.  chosen: (k,) nodes in contact, if they are given.
    """
    frames, old, count = nodes.frames, nodes.old_displacement, len(nodes.gap)
    gap, slip, largest = np.empty(count), np.empty((count, 2)), 0.0
    status, direction, augmentation = np.zeros((5, count), np.bool_), np.zeros((count, 2)), np.empty(count)
    along, most = holder_x - nodes.old_holder_x - nodes.drive_step, 0.0
    for k in range(count):
        lever = nodes.lever[k]
        moved = nodes.gap_rate[k] * (holder_x - nodes.paired_holder_x)
        gap[k] = frames[k, 0, 2] * (nodes.gap[k] + height + lever * tilt + moved)
        for c in range(3):
            gap[k] += elastic[k, c] * frames[k, 0, c]
            largest = max(largest, abs(elastic[k, c]))
        gap[k] += closure[k]
        x, y = elastic[k, 0] - old[k, 0] + along, elastic[k, 1] - old[k, 1]
        z = elastic[k, 2] - old[k, 2] + (height - nodes.old_height + lever * (tilt - nodes.old_tilt))
        for t in range(2):
            slip[k, t] = x * frames[k, 1 + t, 0] + y * frames[k, 1 + t, 1] + z * frames[k, 1 + t, 2]
            slip[k, t] += shear[k] * tangential[k, t]
            for c in range(3):
                slip[k, t] -= nodes.old_sheared[k, c] * frames[k, 1 + t, c]
        status[0, k] = chosen[k] if given else normal[k] - 1.0 / (scales.local + softness[k]) * gap[k] > 0.0
        most = max(most, limit[k])
    for k in range(count):
        compliance = scales.collective + shear[k]
        augmentation[k] = 1.0 / (compliance + scales.rig)
        if frictionless:
            status[4, k] = status[0, k]
            continue
        s0, s1, active = slip[k, 0], slip[k, 1], status[0, k]
        soft = compliance + scales.rig
        t0, t1 = tangential[k, 0] - s0 / soft, tangential[k, 1] - s1 / soft
        length, size = np.sqrt(s0 * s0 + s1 * s1), np.sqrt(t0 * t0 + t1 * t1)
        stick = active and size <= limit[k]
        near = active and (stick or length < near_stick * limit[k] * compliance)
        status[1, k], status[2, k] = stick, abs(size - limit[k]) <= _ROUND_OFF * most
        status[3, k], status[4, k] = near, active and not near
        if active and not near and t0 * s0 + t1 * s1 < 0.0 and length > 0.0:
            # Far from stick the slip alone gives the direction; the trial traction would turn into it only slowly.
            direction[k, 0], direction[k, 1] = -s0 / length, -s1 / length
        elif size > 0.0:
            direction[k, 0], direction[k, 1] = t0 / size, t1 / size
        elif nodes.drive_step != 0.0:
            direction[k, 0] = 1.0 if nodes.drive_step > 0.0 else -1.0
    return gap, slip, largest, status, direction, augmentation


def _scales(system: Linearisation, loaded: BoolArray) -> Scales:
    normals, areas = system.pairing.frames[:, 0, :], system.pairing.areas
    nodes = loaded if loaded.any() else np.ones(len(areas), dtype=bool)
    uniform = np.where(nodes[:, None], normals, 0.0)
    lift = np.einsum("ij,ij->i", system.compliance.displacement(uniform), normals)
    collective = float(lift[nodes].max())
    area = float(areas[nodes].sum())
    rig = system.holder.compliance_at_contact_mm_per_N * area
    return Scales(
        collective=collective,
        local=collective / max(1.0, 0.5 * float(np.sqrt(nodes.sum()))),
        rig=rig,
        series_compliance=(collective + rig) / area,
        pressure=system.holder.normal_load_N / area,
    )


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
