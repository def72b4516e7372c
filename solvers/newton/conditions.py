"""The contact conditions of one pairing: gaps, slips and status of its nodes under tractions, and the holder's
equilibrium.

Per node, with normal traction p, tangential traction q, mean gap g and mean slip s of the upper body relative to the
lower one over the increment:

    open: p = q = 0, g >= 0;  stick: g = 0, s = 0, |q| <= tau(p);  slip: g = 0, q = -tau(p) s / |s|,

with tau the limit by the friction law, mu p by Coulomb's. The augmentation is the stiffness by which a slip is added to
the traction to decide between stick and slip (Alart & Curnier). It is scaled with the whole compliance that a change of
friction meets, the rig's included; with the local one alone a soft rig makes nodes alternate between both directions.
The holder's free play has a status, too: it floats without force, or rests on either of two stops. A node's local frame
is its normal and two tangents, see `Pairing`.
"""

from typing import NamedTuple

import numpy as np

from geometry.arrays import Array, BoolArray, IntArray
from solvers.contact_conditions import Linearisation
from solvers.jit_cache import compiled, inlined
from solvers.newton.terms import Carried, HolderTerms, Iterate, LinearLaws, Nodes, linear_laws, nodes_of, sheared

# Slipping nodes keep their tangential unknowns while their slip is below this share of the displacement that full
# friction on all nodes would cause; beyond, iterating the direction mostly converges fast.
NEAR_STICK = 2.0
_ROUND_OFF = 1e-12  # Of the largest friction: a node so near to its limit may count as sticking or slipping.


class Scales(NamedTuple):
    """Typical sizes with which the augmentation and the equations are scaled."""

    collective: float  #: Displacement by unit traction on all nodes, mm per MPa.
    local: float  #: Displacement by unit traction on one node alone, mm per MPa.
    rig: float  #: Displacement of the rig by unit traction on all nodes, mm per MPa.
    series_compliance: float  #: Compliance of contact and rig in series, mm per N.
    pressure: float  #: Mean pressure, MPa.
    reach: float  #: Displacement by a tilt of 1, mm: at the pivot's height or the contact's edge, whichever is more.


class Solution(NamedTuple):
    """Tractions of the k nodes, in MPa, and the holder's height and position (mm) and tilt (rad)."""

    #: (3 known,) in world axes, of the nodes whose compliance is known, in the order of `PairedCompliance.displaced`.
    force: Array
    normal: Array  #: (k,) along the normals, positive in compression.
    tangential: Array  #: (k, 2) along the two tangents.
    height: float
    holder_x: float
    tilt: float


class Changes(NamedTuple):
    """Differences between a state of the iteration and the one before.

    opening, sticking: numbers of nodes that open or close, and of nodes that change between stick and slip while not on
    the verge of either; changing: number of nodes that do either. gap: largest gap in mm of nodes that were in contact,
    or, where nodes touch late, slip of nodes that stuck.
    turned: largest change of the unit vector of friction at nodes that slip, about an angle in rad.
    """

    opening: int
    sticking: int
    changing: int
    gap: float
    turned: float


class ContactConditions:
    """The contact conditions on the k nodes of a pairing.

    holders: the holder's terms in the equations, kept by the stop on which it rests (-1, 0 or +1, see `stop_in_play`).
    """

    def __init__(self, system: Linearisation, loaded: BoolArray) -> None:
        """loaded: (k,) True for nodes likely in contact, from which the scales are taken."""
        self.system, self.scales, self.nodes = system, _scales(system, loaded), nodes_of(system)
        self.holders: dict[int, HolderTerms] = {}
        self._laws = linear_laws(system, np.zeros(len(loaded)))

    def laws(self, about: Array) -> LinearLaws:
        """Friction and layers, linearised at pressures `about` (k,) in MPa; laws that are linear only once."""
        system = self.system
        if system.layers is not None or not system.friction.law.proportional:
            return linear_laws(system, about)
        if system.late is None:
            return self._laws
        shear, change = sheared(system, about)
        return self._laws._replace(pressure=about, shear=shear, change=change)

    def world(self, normal: Array, tangential: Array) -> Array:
        """Tractions (k, 3) in world axes from normal (k,) and tangential (k, 2) ones in the nodes' local frames."""
        frames = self.nodes.frames
        sideways = tangential[:, :1] * frames[:, 1] + tangential[:, 1:] * frames[:, 2]
        return np.asarray(normal[:, None] * frames[:, 0] + sideways)

    def first(self, traction: Array, height: float, holder_x: float, active: BoolArray) -> Iterate:
        """The state under guessed tractions (k, 3) in MPa in world axes, with the nodes marked in `active` (k,) in
        contact and the holder at this height and position (mm).
        """
        compliance, frames = self.system.compliance, self.nodes.frames
        normal = np.maximum(np.einsum("ij,ij->i", traction, frames[:, 0]), 0.0)
        tangential = np.einsum("ij,ikj->ik", traction, frames[:, 1:])
        force = compliance.in_order(self.world(normal, tangential))
        solution = Solution(force, normal, tangential, height, holder_x, self.system.old_tilt)
        before = active, np.zeros(len(active), dtype=bool), np.zeros((len(active), 2))
        return self.judged(solution, NEAR_STICK, before, given=True)[0]

    def judged(
        self,
        solution: Solution,
        near_stick: float,
        before: tuple[BoolArray, BoolArray, Array],
        *,
        about: Array | None = None,
        given: bool = False,
    ) -> tuple[Iterate, Changes]:
        """The state that follows from a solution (gaps, slips, status of nodes, directions of friction), and what has
        changed.

        near_stick: see `NEAR_STICK`. before: of the previous state, True for nodes in contact (k,) and sticking (k,),
        and directions of friction (k, 2). about: pressures (k,) in MPa at which the solution was linearised; None if it
        was not. given: True to keep the nodes in contact that were.
        """
        layers, friction, normal = self.system.layers, self.system.friction, solution.normal
        shear, closure, softness = sheared(self.system, normal)[0], self._laws.closure, self._laws.softness
        if layers is not None:
            closure, softness = layers.closure(normal)
            if layers.yielding is not None and about is not None:
                # What yielded in a step that went too far bears elastically again before it opens.
                softness = np.maximum(softness, layers.yielding.closure(about)[1])
        compliance = self.system.compliance
        return _judged(
            compliance.displaced(solution.force),
            compliance.place,
            compliance.layer,
            self.nodes,
            self.scales,
            solution,
            (closure, softness, shear, friction.limit(normal)),
            near_stick,
            friction.none,
            before,
            given,
            self.system.late is not None,
        )


@inlined
def forces_on(normal: Array, tangential: Array, frames: Array, place: IntArray, known: int) -> Array:
    """Tractions in world axes (3 known,), in the order in which nodes became known to the compliance, from normal (k,)
    and tangential (k, 2) ones. place: (k,) each node's number in that order, -1 if not known.
    """
    force = np.zeros(3 * known)
    for k in range(len(normal)):
        if place[k] >= 0:
            for c in range(3):
                sideways = tangential[k, 0] * frames[k, 1, c] + tangential[k, 1] * frames[k, 2, c]
                force[3 * place[k] + c] = normal[k] * frames[k, 0, c] + sideways
    return force


@inlined
def _changes(active: BoolArray, stuck: BoolArray, pointed: Array, state: Iterate, late: bool) -> Changes:
    opening, sticking, changing, widest, turned = 0, 0, 0, 0.0, 0.0
    for k in range(len(active)):
        opens, sticks = active[k] != state.active[k], stuck[k] != state.stick[k] and not state.verge[k]
        opening, sticking, changing = opening + opens, sticking + sticks, changing + (opens or sticks)
        if active[k]:
            widest = max(widest, abs(state.gap[k]))
            if not stuck[k] and state.normal[k] > 0.0:
                x, y = state.direction[k, 0] - pointed[k, 0], state.direction[k, 1] - pointed[k, 1]
                turned = max(turned, np.sqrt(x * x + y * y))
        if late and stuck[k] and state.normal[k] > 0.0:
            widest = max(widest, abs(state.slip[k, 0]), abs(state.slip[k, 1]))
    return Changes(opening, sticking, changing, widest, turned)


@compiled
def _judged(
    elastic: Array,
    place: IntArray,
    layer: float,
    nodes: Nodes,
    scales: Scales,
    solution: Solution,
    laws: tuple[Array, Array, Array, Array],
    near_stick: float,
    frictionless: bool,
    before: tuple[BoolArray, BoolArray, Array],
    given: bool,
    late: bool,
) -> tuple[Iterate, Changes]:
    """The state that follows from elastic displacements (k, 3) of the surfaces, and what has changed; see `judged`.

    laws: closure, softness and shear of layers, and limit of friction, (k,) each. late: True if nodes may touch late.
    """
    (closure, softness, shear, limit), (active, stuck, pointed) = laws, before
    normal, tangential, holder_x = solution.normal, solution.tangential, solution.holder_x
    height, tilt = solution.height, solution.tilt
    frames, old, count = nodes.frames, nodes.old_displacement, len(nodes.gap)
    gap, slip, largest = np.empty(count), np.empty((count, 2)), 0.0
    touch, stick, near, follows, verge = np.zeros((5, count), np.bool_)
    direction, augmentation = np.zeros((count, 2)), np.empty(count)
    along, most, touching, fresh = holder_x - nodes.old_holder_x - nodes.drive_step, 0.0, 0, 0
    for k in range(count):
        lever = nodes.lever[k]
        moved = nodes.gap_rate[k] * (holder_x - nodes.paired_holder_x)
        gap[k] = frames[k, 0, 2] * (nodes.gap[k] + height + lever * tilt + moved)
        for c in range(3):
            sideways = tangential[k, 0] * frames[k, 1, c] + tangential[k, 1] * frames[k, 2, c]
            elastic[k, c] += layer * (normal[k] * frames[k, 0, c] + sideways)
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
        touch[k] = active[k] if given else normal[k] - 1.0 / (scales.local + softness[k]) * gap[k] > 0.0
        touching, fresh = touching + touch[k], fresh + (touch[k] and place[k] < 0)
        most = max(most, limit[k])
    for k in range(count):
        compliance = scales.collective + shear[k]
        augmentation[k] = 1.0 / (compliance + scales.rig)
        if frictionless:
            follows[k] = touch[k]
            continue
        s0, s1 = slip[k, 0], slip[k, 1]
        soft = compliance + scales.rig
        t0, t1 = tangential[k, 0] - s0 / soft, tangential[k, 1] - s1 / soft
        length, size = np.sqrt(s0 * s0 + s1 * s1), np.sqrt(t0 * t0 + t1 * t1)
        stick[k], verge[k] = touch[k] and size <= limit[k], abs(size - limit[k]) <= _ROUND_OFF * most
        near[k] = touch[k] and (stick[k] or length < near_stick * limit[k] * compliance)
        follows[k] = touch[k] and not near[k]
        if follows[k] and t0 * s0 + t1 * s1 < 0.0 and length > 0.0:
            # Far from stick the slip alone gives the direction; the trial traction would turn into it only slowly.
            direction[k, 0], direction[k, 1] = -s0 / length, -s1 / length
        elif size > 0.0:
            direction[k, 0], direction[k, 1] = t0 / size, t1 / size
        elif nodes.drive_step != 0.0:
            direction[k, 0] = 1.0 if nodes.drive_step > 0.0 else -1.0
    state = Iterate(
        normal,
        tangential,
        height,
        holder_x,
        tilt,
        gap,
        slip,
        largest,
        touch,
        touching,
        fresh,
        stick,
        near,
        follows,
        verge,
        direction,
        augmentation,
        limit,
    )
    return state, _changes(active, stuck, pointed, state, late)


def _scales(system: Linearisation, loaded: BoolArray) -> Scales:
    nodes = np.flatnonzero(loaded) if loaded.any() else np.arange(len(loaded))
    normals, compliance = system.pairing.frames[nodes, 0], system.compliance
    unit = np.zeros((len(loaded), 3))
    unit[nodes] = normals
    elastic = compliance.displaced(compliance.in_order(unit))[nodes] + compliance.layer * normals
    collective = float(np.einsum("ij,ij->i", elastic, normals).max())
    area = float(system.pairing.areas[nodes].sum())
    rig = system.holder.compliance_at_contact_mm_per_N * area
    return Scales(
        collective=collective,
        local=collective / max(1.0, 0.5 * float(np.sqrt(len(nodes)))),
        rig=rig,
        series_compliance=(collective + rig) / area,
        pressure=system.holder.normal_load_N / area,
        reach=max(system.holder.pivot_height_mm, float(system.pairing.areas.sum()) ** 0.5),
    )


def stop_in_play(conditions: ContactConditions, state: Iterate) -> int:
    """The stop of its free play on which the holder rests, 1 or -1; 0 while it floats between them or has no play."""
    holder = conditions.system.holder
    if holder.play_mm == 0.0:
        return 0
    force = float(conditions.nodes.areas @ conditions.world(state.normal, state.tangential)[:, 0])
    place = holder.place_in_play_mm(state.holder_x, state.tilt, force)
    # On a stop the place is the stop's, floating the force is zero: the compliance between them only has to be
    # positive.
    trial = place + conditions.scales.series_compliance * force
    return int(trial > 0.5 * holder.play_mm) - int(trial < -0.5 * holder.play_mm)


def held_place(conditions: ContactConditions, stop: int) -> float | None:
    """Position in mm in its free play, 0 in the middle, at which the holder is held while on `stop` (see
    `stop_in_play`); 0 without play, None while it floats.
    """
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
    """Write the last three equations, the forces' balance along z and x and of moments about the pivot, into the
    transposed matrix and the right-hand side in place. on, tan: nodes of the unknowns, see `equations`.
    """
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
    """Largest unbalanced force on the holder, by springs, load and tractions (k, 3) in MPa, over the normal force."""
    system, areas, holder = conditions.system, conditions.nodes.areas, conditions.system.holder
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
