"""A contact as a row of springs, in any path of load and displacement.

Of the springs more touch the higher the load is, and each carries friction in proportion to how far it is pressed down.
A contact that yields by n Q/K (1 − (1 − Q/µP)^(1/n)) is such a row, for any path by the law of Ciavarella and Jäger
(Popov and Heß, Method of Dimensionality Reduction in Contact Mechanics and Friction, 2015, chapter 5).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geometry.arrays import Array
from solvers.jit_cache import compiled, inlined
from wirewear.diagnosis.calibration import constants
from wirewear.loops.sensor import DAMPING

_KNOWN = constants("surrogate.springs")

#: Springs of a row; lowest order of micro-slip, below which one spring is all that there is.
_SPRINGS, _LEAST_ORDER = _KNOWN.count("springs"), _KNOWN.number("least_order")

#: Play opens over this force, N: a step would leave a curve without an inverse.
PLAY_FORCE_N = _KNOWN.number("play_force_N")

#: Cycles after which a holder's swinging has died down.
_MOST_TURNS = _KNOWN.count("most_turns")

#: Stiffnesses that are tried of a loop, and by how much the first and later ones may be apart from the best yet.
_TRIED, _APART = _KNOWN.count("tried"), _KNOWN.numbers("apart")


@dataclass(frozen=True, eq=False)
class Rows:
    """n contacts under the test's load: displacement in µm from stick to full slip, and order of micro-slip, (n,)."""

    full_um: Array
    order: Array


@dataclass(frozen=True, eq=False)
class Curves:
    """Figures of n contacts that slide under the test's load, at k positions each; all (n, k).

    position_um: position of the sliding body along the motion. yielded_um: elastic displacement in µm by the force of
    the scar's walls. wall_N: that tangential force, by which the inclined walls resist the motion. friction_N, load_N:
    friction and normal force there.
    """

    position_um: Array
    yielded_um: Array
    wall_N: Array
    friction_N: Array
    load_N: Array


@dataclass(frozen=True, eq=False)
class Rig:
    """What holds n contacts: springs, play, and the inertia of what they hold, in N/µm at the drive's frequency, (n,)
    each. The springs oscillate with it by m ü + c u̇ + u/C = Q (Den Hartog, Trans. ASME 53 (1931) APM-107).
    """

    springs_um_per_N: Array
    play_um: Array
    inertia_N_per_um: Array


def through(
    phase: Array, drive: Array, share: Array, stroke_um: Array, rows: Rows, curves: Curves, rig: Rig
) -> tuple[Array, Array, Array, Array, Array]:
    """Slip and force of n contacts along a closed path of k instants, behind springs and play, once they repeat.

    phase, drive, share: (k,) phase in rad, displacement over its amplitude from 1 to −1 and back, and load over the
    test's. stroke_um: (n,) amplitudes of displacement. rows, curves: micro-slip and sliding of each contact. Returns
    the force of the springs and the normal force in N, sliding position in µm and share of the friction from −1 to 1,
    (n, k) each, and the friction energy of a cycle in mJ (n,).
    """
    order = np.maximum(rows.order, _LEAST_ORDER)
    edges = share.max() ** (1.0 / order)[:, None] * np.linspace(0.0, 1.0, _SPRINGS + 1)
    lower, upper = (side ** (order - 1.0)[:, None] for side in (edges[:, :-1], edges[:, 1:]))
    weights = order[:, None] * (upper - lower)
    heights = (order - 1.0)[:, None] * (upper * edges[:, 1:] - lower * edges[:, :-1]) / weights
    found, energy = np.zeros((4, len(stroke_um), drive.size)), np.zeros(len(stroke_um))
    places = np.maximum.accumulate(curves.position_um + curves.yielded_um, axis=1)
    of = np.stack([places, curves.position_um, curves.wall_N, curves.friction_N, curves.load_N], axis=1)
    of_rig = rig.springs_um_per_N, rig.play_um, rig.inertia_N_per_um
    taken = phase, drive, share, stroke_um, *of_rig, rows.full_um, order, weights, heights, of, found, energy
    _follow(*(np.ascontiguousarray(one, dtype=np.float64) for one in taken))
    return found[0], found[1], found[2], found[3], energy


def yielding_of(
    x_um: Array, q_N: Array, share: Array, friction_N: float, orders: Array, expected_N_per_um: float
) -> tuple[float, float]:
    """Stiffness in N/µm and order of micro-slip of a contact whose loop these samples (n,) are, by least squares.

    share: load over that at which `friction_N` slides the contact. orders: (m,) of those that it may have, growing;
    between them it may have any.
    """
    first = int(np.argmax(x_um))
    x, q, load = (np.append(np.roll(one, -first), one[first]) for one in (x_um, q_N, share))
    middle, half = 0.5 * float(x.max() + x.min()), 0.5 * float(np.ptp(x))
    drive = (x - middle) / half
    best = (np.inf, expected_N_per_um, float(orders[0]))
    for apart in _APART:
        tried = best[1] * np.geomspace(1.0 / apart, apart, _TRIED)
        order, stiffness = (one.ravel() for one in np.meshgrid(orders, tried, indexing="ij"))
        none = np.zeros((stiffness.size, 2))
        even = friction_N + none
        curves = Curves(half * (none + np.array([-1.0, 1.0])), none, none, even, even)
        still = np.zeros(stiffness.size)
        rows = Rows(order * friction_N / stiffness, order)
        at = np.linspace(0.0, 2.0 * np.pi, load.size)
        found = through(at, drive, load, np.full(stiffness.size, half), rows, curves, Rig(still, still, still))[0]
        # Stuck springs hold what they were pressed together with.
        missed = found - q
        left = ((missed - missed.mean(axis=1, keepdims=True)) ** 2).sum(axis=1)
        one = int(np.argmin(left))
        best = min(best, (float(left[one]), float(stiffness[one]), float(order[one])))
        if apart < _APART[0]:
            # Stiffnesses are now so close that orders are sought between the neighbours of the best one.
            place = int(np.searchsorted(orders, best[2]))
            orders = np.linspace(orders[max(place - 1, 0)], orders[min(place + 1, orders.size - 1)], orders.size)
    return best[1], best[2]


@inlined
def _carried(bent: Array, moved: float, limit: float, full: float, weight: Array, height: Array) -> tuple[float, ...]:
    """What a row bent so far carries once it has moved on, what it carries at most, and the weight that sticks."""
    given = whole = free = 0.0
    for i in range(weight.size):
        most = limit - full * height[i]
        if most > 0.0:
            wanted = bent[i] + moved
            own = min(max(wanted, -most), most)
            free += weight[i] if own == wanted else 0.0
            given += weight[i] * own
            whole += weight[i] * most
    return given, whole, free


@inlined
def _yielded(bent: Array, moved: float, limit: float, full: float, weight: Array, height: Array) -> float:
    """Work of the springs that slip as a row moves on, over what it carries at most; changes `bent`."""
    work = whole = 0.0
    for i in range(weight.size):
        most = max(limit - full * height[i], 0.0)
        own = min(max(bent[i] + moved, -most), most)
        work += 0.5 * weight[i] * (own + bent[i]) * (moved - own + bent[i])
        whole += weight[i] * most
        bent[i] = own
    bent[-1] = min(max(bent[-1] + moved, -limit), limit)
    return work / whole if whole > 0.0 else 0.0


@inlined
def _place(places: Array, at: float) -> tuple[int, float]:
    """Index of the place at or before `at`, and the share of the way to the next one."""
    low, high = 0, places.size - 1
    while high - low > 1:
        middle = (low + high) // 2
        if places[middle] > at:
            high = middle
        else:
            low = middle
    width = places[high] - places[low]
    return low, min(max((at - places[low]) / width, 0.0), 1.0) if width > 0.0 else 0.0


@inlined
def _between(values: Array, low: int, part: float) -> float:
    return float(values[low] + part * (values[low + 1] - values[low]))


@inlined
def _reached(
    moved: float,
    x: float,
    share: float,
    bent: Array,
    limit: float,
    full: float,
    weight: Array,
    height: Array,
    of: Array,
) -> tuple[float, ...]:
    """Tangential force, its rise per displacement, normal force, friction, its share that acts, and sliding position.

    of: (5, k) places, positions, forces of the walls, friction and load.
    """
    given, whole, free = _carried(bent, moved, limit, full, weight, height)
    acting = given / whole if whole > 0.0 else 0.0
    at = x - min(max(bent[-1] + moved, -limit), limit)
    low, part = _place(of[0], at)
    friction = share * _between(of[3], low, part)
    force = share * _between(of[2], low, part) + acting * friction
    beyond = min(at - of[0, 0], 0.0) + max(at - of[0, -1], 0.0)
    rise = friction * free / whole if whole > 0.0 else 0.0
    return force, rise, share * _between(of[4], low, part), friction, acting, _between(of[1], low, part) + beyond


@inlined
def _settled(
    now: float, aim: float, ahead: float, springs: float, half_play: float, share: float, bent: Array, limit: float,
    full: float, weight: Array, height: Array, of: Array, most_N: float,
) -> float:  # fmt: skip
    """Displacement of the bodies at which springs and play take up the rest of the drive's; Newton between bounds."""
    reach = springs * most_N * share + half_play + 1e-9
    low, high = aim - reach, aim + reach
    x = min(max(now + ahead, low), high)
    for _ in range(40):
        force, rise, _, _, _, _ = _reached(x - now, x, share, bent, limit, full, weight, height, of)
        rest = x + springs * force + min(max(force / PLAY_FORCE_N, -1.0), 1.0) * half_play - aim
        if abs(rest) < 1e-6 or high - low < 1e-9:
            break
        slope = 1.0 + springs * rise + (half_play * rise / PLAY_FORCE_N if abs(force) < PLAY_FORCE_N else 0.0)
        low, high = (low, x) if rest > 0.0 else (x, high)
        x -= rest / slope
        if not low < x < high:
            x = 0.5 * (low + high)
    return x


@inlined
def _yielding(swing: Array, wide: float, held: float, mass: float) -> tuple[float, float]:
    """Compliance of a spring that holds a mass over a step of phase, and what its swinging so far adds to its
    deflection, both by Newmark's rule of average acceleration (Hughes, The Finite Element Method, 1987, section 9.1).
    swing: deflection, its first and its second derivative by phase, led on.
    """
    if mass * held == 0.0:
        return held, 0.0
    swing[0] += wide * (swing[1] + 0.25 * wide * swing[2])
    swing[1] += 0.5 * wide * swing[2]
    damps = 2.0 * DAMPING * np.sqrt(mass / held)
    inert = (4.0 * mass / wide + 2.0 * damps) / wide
    yields = 1.0 / (inert + 1.0 / held)
    return yields, yields * (inert * swing[0] - damps * swing[1])


@inlined
def _swung(swing: Array, bend: float, wide: float) -> None:
    """Bring a swing, led on by `_yielding`, to the deflection at the end of the step."""
    swing[2] = 4.0 * (bend - swing[0]) / wide**2
    swing[1] += 0.5 * wide * swing[2]
    swing[0] = bend


@compiled
def _follow(
    phase: Array, drive: Array, share: Array, stroke: Array, springs: Array, play: Array, inertia: Array, full: Array,
    order: Array, weight: Array, height: Array, curves: Array, found: Array, energy: Array,
) -> None:  # fmt: skip
    """The path of each contact, instant by instant; results in the last two arrays."""
    last = drive.size - 1
    start = last
    while start > 0 and drive[start - 1] < drive[start] + 1e-12 and drive[start - 1] > 0.0:
        start -= 1
    for one in range(stroke.size):
        # The bodies are pressed together in the middle of the stroke; the path is gone through until it repeats itself.
        bent, before = np.zeros(weight.shape[1] + 1), np.zeros(weight.shape[1] + 1)
        of, now, most_N = curves[one], 0.0, 0.0
        swing, held, swings = np.zeros(3), springs[one], inertia[one] * springs[one] > 0.0
        for j in range(of.shape[1]):
            most_N = max(most_N, abs(of[2, j]) + abs(of[3, j]))
        for turn in range(_MOST_TURNS if swings else 3):
            energy[one] = changed = 0.0
            ended = swing[0]
            for step in range(start if turn == 0 else 1, last + 1):
                limit = full[one] * share[step] ** (1.0 / order[one])
                ahead = stroke[one] * (drive[step] - drive[step - 1])
                wide = max(phase[step] - phase[step - 1], 1e-9)
                yields, moved = _yielding(swing, wide, held, inertia[one])
                x = _settled(
                    now, stroke[one] * drive[step] - moved, ahead, yields, 0.5 * play[one], share[step], bent, limit,
                    full[one], weight[one], height[one], of, most_N,
                )  # fmt: skip
                force, _, load, friction, acting, place = _reached(
                    x - now, x, share[step], bent, limit, full[one], weight[one], height[one], of
                )
                energy[one] += 1e-3 * friction * _yielded(bent, x - now, limit, full[one], weight[one], height[one])
                if swings:
                    _swung(swing, yields * force + moved, wide)
                    force = swing[0] / held
                found[0, one, step], found[1, one, step] = force, load
                found[2, one, step], found[3, one, step] = place, acting
                now = x
            for i in range(bent.size):
                changed = max(changed, abs(bent[i] - before[i]))
                before[i] = bent[i]
            if turn > 0 and changed < 1e-6 * full[one] and abs(swing[0] - ended) <= 1e-4 * held * most_N:
                break
        for k in range(4):
            found[k, one, 0] = found[k, one, last]
