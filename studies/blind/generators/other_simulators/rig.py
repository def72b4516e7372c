"""A rig of springs in series: the stroke that a drive holds, the loop that comes of it, and what instruments read."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import tan
from typing import Protocol

import numpy as np
from scipy.optimize import brentq

from studies.blind.generators.other_simulators.pair import Array, Touch
from studies.blind.generators.other_simulators.world import World
from wirewear.base.errors import RunError

POINTS, TIMES = 480, 1024  #: Points of a stroke, closer to its beginning, and of a loop over time.
SWEEPS = 6  #: Of a stroke against the load that its drive brings.
#: A drive holds its amplitude so well; a play is crossed within this share of the friction's limit.
HELD, CROSSED = 1e-7, 1e-3


class Sliding(Protocol):
    """How a contact sticks and slips."""

    def lag_mm(self, friction: float, load_N: float) -> float:
        """Elastic displacement of a contact that slips everywhere."""
        ...

    def stroke(self, way_mm: Array, half_mm: float, friction: float, load_N: float) -> Array:
        """Friction over its limit along a stroke that begins at a reversal."""
        ...

    def under(self, way_mm: Array, friction: float, load_N: Array) -> Array:
        """Friction over its limit of the moment along such a stroke, under loads (n,) that vary."""
        ...


@dataclass(frozen=True, eq=False)
class Loop:
    """A cycle at even times (n,): true motion against ground, what the drive holds, and forces; slip and its work."""

    place_mm: Array
    tangential_N: Array
    normal_N: Array
    half_slip_mm: float
    work_mJ: float


def periodic_loop(world: World, cycle: float, load_N: float, touch: Touch, sliding: Sliding) -> Loop:
    """The loop whose stroke the drive holds. Raises RunError if the contact does not slide, or no stroke is found."""

    def both_strokes(half: float) -> list[tuple[Array, ...]]:
        return [_stroke(world, cycle, load_N, touch, sliding, half, direction) for direction in (1, -1)]

    def missing(half: float) -> float:
        strokes = both_strokes(half)
        left = world.amplitude_mm - _half_range(strokes)
        if world.held is None:
            return left
        key, value = world.held
        return min(left, world.amplitude_mm * (1.0 - HOLDS[key](strokes) / value))

    shortest, longest = 1e-3 * world.amplitude_mm, world.amplitude_mm
    if missing(shortest) <= 0.0:
        raise RunError("the rig takes the whole stroke.")
    while missing(longest) > 0.0:
        longest *= 1.5
    half = float(brentq(missing, shortest, longest, xtol=HELD * world.amplitude_mm))
    strokes = both_strokes(half)
    held = np.concatenate([stroke[1] for stroke in strokes])
    amplitude = world.amplitude_mm if world.held is None else _half_range(strokes)
    lag = sliding.lag_mm(world.friction_at(cycle), load_N)
    if half - lag < world.least_slip * world.amplitude_mm:
        raise RunError(f"the contact slips over {1e3 * (half - lag):.3g} µm only.")
    phase = 2.0 * np.pi * np.arange(TIMES) / TIMES
    rising = np.cos(phase) >= 0.0
    middle = 0.5 * float(held.max() + held.min())
    wanted = middle + amplitude * np.sin(phase)
    channels = []
    for channel in (0, 2, 3):
        there, back = (np.interp(wanted, *_increasing(stroke[1], stroke[channel])) for stroke in strokes)
        channels.append(np.where(rising, there, back))
    return Loop(channels[0], channels[1], channels[2], half - lag, _work_mJ(strokes))


def _half_range(strokes: list[tuple[Array, ...]]) -> float:
    return 0.5 * float(np.ptp(np.concatenate([stroke[1] for stroke in strokes])))


def _work_mJ(strokes: list[tuple[Array, ...]]) -> float:
    return sum(abs(float(np.trapezoid(stroke[4], stroke[5]))) for stroke in strokes)


#: What a drive may hold in place of its stroke, by the key of a study.
HOLDS: Mapping[str, Callable[[list[tuple[Array, ...]]], float]] = {
    "held_tangential_force_N": lambda strokes: max(float(np.abs(stroke[2]).max()) for stroke in strokes),
    "held_energy_mJ": _work_mJ,
}


def _increasing(held: Array, channel: Array) -> tuple[Array, Array]:
    order = slice(None) if held[-1] > held[0] else slice(None, None, -1)
    return np.maximum.accumulate(held[order]), channel[order]


def _stroke(
    world: World, cycle: float, load_N: float, touch: Touch, sliding: Sliding, half: float, direction: int
) -> tuple[Array, ...]:
    """Motion, what the drive holds of it, forces, friction and slip along a stroke of the contact (n,) each."""
    friction = world.friction_at(cycle) * _by_pressure(world, touch)
    way = 2.0 * half * np.linspace(0.0, 1.0, POINTS) ** 3
    moved = direction * (way - half)
    off, drive = moved / half, moved
    # Where the load follows the drive, the drive follows from what the rig gives under that load.
    for _ in range(SWEEPS if world.swing else 1):
        shares = _load_shares(world, drive)
        if world.swing:
            mobilised = direction * sliding.under(way, friction, load_N * shares)
        else:
            mobilised = direction * sliding.stroke(way, half, friction, load_N)
        slip = moved - mobilised * shares * sliding.lag_mm(friction, load_N)
        lean = tan(world.lean_rad)
        normal = load_N * shares + world.spring_N_per_mm * lean * moved
        for cause in world.causes:
            normal = normal * cause.load_along(off, direction)
        coefficient = friction * world.varied(off, direction) * mobilised
        slope = np.interp(slip, touch.place_mm, touch.slope_N) / load_N + lean
        # Friction acts along the slope, tan(φ + β): the pressures' sum is larger than the load.
        pressing = normal / (1.0 - coefficient * slope)
        rubbed, force = coefficient * pressing, (coefficient + slope) * pressing
        limit = world.stated_friction * world.stated_load_N
        given = (world.compliance_mm_per_N + touch.shear_mm_per_N) * force
        given = given + 0.5 * world.play_mm * np.clip(force / (CROSSED * limit), -1.0, 1.0)
        for cause in world.causes:
            given = given + cause.given_mm(force, limit, direction)
        place = moved + given
        drive = place if world.drive == "stroke" else displacement(world, cycle, place, force)
    return place, drive, force, normal, rubbed, slip


def _load_shares(world: World, drive_mm: Array) -> Array:
    """Load over its mean where the drive is (n,): a cosine of its phase since its rest at +x."""
    if world.swing is None:
        return np.ones_like(drive_mm)
    share, ratio = world.swing
    middle, half = 0.5 * float(drive_mm.max() + drive_mm.min()), 0.5 * float(np.ptp(drive_mm))
    return np.asarray(1.0 + share * np.cos(ratio * np.arccos(np.clip((drive_mm - middle) / half, -1.0, 1.0))))


def _by_pressure(world: World, touch: Touch) -> float:
    """Friction over that at the pressure which is expected in the end."""
    return float((world.load_N / touch.area_mm2 / world.expected_MPa) ** world.pressure_exponent)


def displacement(world: World, cycle: float, place_mm: Array, force_N: Array) -> Array:
    """What the displacement sensor reads without lag [mm]."""
    linear, square = world.coupling
    return world.gain_at(cycle) * place_mm + linear * force_N + square * force_N**2


def readings(world: World, cycle: float, loop: Loop) -> tuple[Array, Array, Array]:
    """Displacement [µm], tangential and normal force [N] as the instruments give them, at even times (n,)."""
    read = displacement(world, cycle, loop.place_mm, loop.tangential_N)
    tangential = loop.tangential_N + world.crosstalk * loop.normal_N
    normal = loop.normal_N + world.crosstalk * loop.tangential_N
    limit = world.stated_friction * world.stated_load_N
    for cause in world.causes:
        tangential = cause.read_N(tangential, limit, cycle)
    if world.lag_s > 0.0:
        turn = 2.0 * np.pi * world.frequency_Hz * np.fft.rfftfreq(TIMES, 1.0 / TIMES)
        filtered = 1.0 / (1.0 + 1j * turn * world.lag_s)
        read = np.fft.irfft(filtered * np.fft.rfft(read), TIMES)
    return 1e3 * read, tangential, normal
