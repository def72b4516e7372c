"""One closed loop at a frozen wear state: the rig follows the contact's tabulated forces quasi-statically.

The relative displacement r of the wires (slip and the contact's own elasticity) is the independent variable: force and
displacement follow from it branch by branch in closed form, and no equation is to be solved but for the two reversals.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from math import acosh, ceil, cosh, sinh, sqrt
from typing import Protocol, Self, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from studies.blind.generators.independent.foundation import tangential_force
from studies.blind.generators.independent.friction import LAWS
from studies.blind.generators.independent.world import World
from studies.blind.generators.waveform import SAMPLES

DAMPING = 2.0 / 13.0

Array = NDArray[np.float64]

POINTS = 160  # of a branch, crowded after its reversal
REVERSAL_STEPS, REVERSAL_TOLERANCE = 40, 1e-7
PLAY_FORCE_N = 2e-3  #: Play is a step of the holder at Q = 0, spread over so much force.
REFERENCE_SPEED = 0.3  #: Speed at which velocity-dependent friction has its nominal value [mm/s].


class Vector(Protocol):
    """What can be stepped: a value to which a multiple of a rate can be added."""

    def plus(self, share: float, rate: Self, /) -> Self:
        """This and `share` times `rate`."""
        ...


State = TypeVar("State", bound=Vector)


def stages_needed(step: float, spectral_radius: float) -> int:
    """Least number of stages for which a step is stable."""
    return max(2, ceil(sqrt(1.0 + 1.54 * step * spectral_radius)))


def chebyshev_step(state: State, rate: Callable[[State], State], step: float, stages: int) -> State:
    """The state after one step of an autonomous problem, with at least two stages."""
    w0 = 1.0 + DAMPING / stages**2
    angle = acosh(w0)
    value = [cosh(j * angle) for j in range(stages + 1)]
    first = [j * sinh(j * angle) / sinh(angle) for j in range(stages + 1)]
    second = [
        (j * j * cosh(j * angle) - w0 * j * sinh(j * angle) / sinh(angle)) / sinh(angle) ** 2 for j in range(stages + 1)
    ]
    w1 = first[stages] / second[stages]
    b = [second[max(j, 2)] / first[max(j, 2)] ** 2 for j in range(stages + 1)]
    initial_rate = rate(state)
    older, newer = state, state.plus(b[1] * w1 * step, initial_rate)
    for j in range(2, stages + 1):
        mu, nu = 2.0 * b[j] * w0 / b[j - 1], -b[j] / b[j - 2]
        mu_rate = 2.0 * b[j] * w1 / b[j - 1]
        old_share = -(1.0 - b[j - 1] * value[j - 1]) * mu_rate
        # (1 − µ − ν) y₀ + µ y_(j−1) + ν y_(j−2), spelled with differences.
        following = (
            state.plus(mu, newer)
            .plus(-mu, state)
            .plus(nu, older)
            .plus(-nu, state)
            .plus(mu_rate * step, rate(newer))
            .plus(old_share * step, initial_rate)
        )
        older, newer = newer, following
    return newer


@dataclass(frozen=True, eq=False)
class ForceTable:
    """The contact at one wear state: slope moments (k, n), load (n,) by position, friction, and series compliances."""

    positions_mm: Array
    moments: Array
    load_N: Array
    friction: float
    contact_stiffness_N_per_mm: float
    layer_compliance_mm_per_N: float
    cycle: float = 0.0

    @cached_property
    def splines(self) -> tuple[CubicSpline, CubicSpline]:
        """Moments and load as functions of the position."""
        return CubicSpline(self.positions_mm, self.moments, axis=1), CubicSpline(self.positions_mm, self.load_N)


@dataclass(frozen=True, eq=False)
class TrueLoop:
    """A cycle at SAMPLES even times: displacement [mm], force and load [N]; `reach_mm` is the contact's range."""

    displacement_mm: Array
    tangential_force_N: Array
    normal_force_N: Array
    reach_mm: tuple[float, float]


@dataclass(frozen=True, eq=False)
class _Branch:
    """One direction: relative displacement, displacement of the drive (increasing), force."""

    relative_mm: Array
    displacement_mm: Array
    force_N: Array
    mobilised_end: float


@dataclass(frozen=True)
class _Ends:
    """The two reversals: relative displacement, mobilisation and force at them."""

    low_mm: float
    high_mm: float
    low_mobilised: float
    high_mobilised: float
    low_force_N: float
    high_force_N: float


def closed_loop(world: World, table: ForceTable, amplitude_mm: float) -> TrueLoop:
    """The loop that closes while the drive moves to ±amplitude.
    Raises ArithmeticError if the contact does not reach gross slip or the reversals are not found.
    """
    world = replace(world, rig=world.rig.aged(table.cycle))
    moments, load = table.splines
    mu, contact = table.friction, float(load(0.0))
    give = _series(world, table)
    reach = amplitude_mm - give * mu * contact - 0.5 * world.rig.play_mm
    if reach <= 0.0:
        raise ArithmeticError("the rig takes the whole stroke: the contact does not slip.")
    ends = _Ends(-reach, reach, -mu, mu, -mu * contact, mu * contact)
    for _ in range(REVERSAL_STEPS):
        rising = _branch(world, table, moments, load, ends, +1, amplitude_mm)
        falling = _branch(world, table, moments, load, ends, -1, amplitude_mm)
        over = amplitude_mm - rising.displacement_mm[-1]
        under = -amplitude_mm - falling.displacement_mm[0]
        swung = ends.high_force_N - rising.force_N[-1], ends.low_force_N - falling.force_N[0]
        ends = replace(
            ends,
            high_mm=ends.high_mm + over,
            low_mm=ends.low_mm + under,
            high_mobilised=rising.mobilised_end,
            low_mobilised=falling.mobilised_end,
            high_force_N=float(rising.force_N[-1]),
            low_force_N=float(falling.force_N[0]),
        )
        if ends.high_mm <= ends.low_mm:
            raise ArithmeticError("the rig takes the whole stroke: the contact does not slip.")
        if max(abs(over), abs(under)) < REVERSAL_TOLERANCE and max(map(abs, swung)) < 1e-5:
            return _sampled(world, load, rising, falling, amplitude_mm, ends)
    raise ArithmeticError("the reversals of the loop were not found.")


def _series(world: World, table: ForceTable) -> float:
    return world.rig.series_mm_per_N + world.rig.loose_mm_per_N(table.cycle) + table.layer_compliance_mm_per_N


def _branch(
    world: World,
    table: ForceTable,
    moments: CubicSpline,
    load: CubicSpline,
    ends: _Ends,
    direction: int,
    amplitude_mm: float,
) -> _Branch:
    start, mobilised_from = (ends.low_mm, ends.low_mobilised) if direction > 0 else (ends.high_mm, ends.high_mobilised)
    stiffness = table.contact_stiffness_N_per_mm / (2.0 * table.friction * float(load(start)))

    def followed(along: Array) -> tuple[Array, Array]:
        """Mobilisation and force after so much displacement since the reversal."""
        relative = start + direction * along
        limit = direction * _limit(world, table, relative, along, amplitude_mm)
        share = LAWS[world.friction.law].share(along * stiffness)
        mobilised = mobilised_from + (limit - mobilised_from) * share
        return mobilised, tangential_force(moments(relative), mobilised)

    along = (ends.high_mm - ends.low_mm) * np.linspace(0.0, 1.0, POINTS) ** 3
    mobilised, force = followed(along)
    if world.rig.play_mm:
        along = _with_shelf(along, direction * force)
        mobilised, force = followed(along)
    relative = start + direction * along
    held_from = ends.low_force_N if direction > 0 else ends.high_force_N
    displacement = relative + _holder(world, table, force, held_from, direction)
    end = float(mobilised[-1])
    if direction < 0:
        relative, displacement, force = relative[::-1], displacement[::-1], force[::-1]
    rising = np.maximum.accumulate(displacement + 1e-12 * np.arange(along.size))
    return _Branch(relative, rising, force, end)


def _with_shelf(along: Array, rising_force: Array) -> Array:
    """Further points where the force passes through 0, between which the holder crosses its play."""
    after = int(np.argmax(rising_force > 0.0))
    if after == 0:
        return along
    pair = slice(after - 1, after + 1)
    passing = np.interp(PLAY_FORCE_N * np.linspace(-1.0, 1.0, 7), rising_force[pair], along[pair])
    return np.unique(np.concatenate([along, passing]))


def _limit(world: World, table: ForceTable, relative: Array, along: Array, amplitude_mm: float) -> Array:
    """Largest coefficient along a branch (n,)."""
    friction = world.friction
    limit = LAWS[friction.law].limit(table.friction, along)
    limit = limit * (1.0 + friction.adhesion * np.exp(-along / friction.adhesion_length_mm))
    if friction.slant or friction.ripple:
        wave = np.sin(2.0 * np.pi * relative / friction.ripple_length_mm)
        limit = limit * (1.0 + friction.slant * relative / amplitude_mm + friction.ripple * wave)
    if friction.velocity_sensitivity:
        omega = 2.0 * np.pi * world.drive.frequency_Hz
        speed = omega * np.sqrt(np.maximum(amplitude_mm**2 - relative**2, 0.0))
        limit = limit * (1.0 + friction.velocity_sensitivity * np.log((speed + 0.02) / REFERENCE_SPEED))
    return np.asarray(limit)


def _holder(world: World, table: ForceTable, force: Array, held_from: float, direction: int) -> Array:
    """Displacement of the holder under a force that swings from one reversal to the other (n,)."""
    rig = world.rig
    moved = _series(world, table) * force
    if rig.hardening_mm_per_N3:
        moved = moved + rig.hardening_mm_per_N3 * (table.friction * float(table.load_N.mean())) ** 2 * force
        moved = moved - rig.hardening_mm_per_N3 / 3.0 * force**3
    if rig.play_mm:
        moved = moved + 0.5 * rig.play_mm * np.clip(force / PLAY_FORCE_N, -1.0, 1.0)
    for joint in rig.joints:
        moved = moved + joint.moved_mm(force, held_from, direction)
    return np.asarray(moved)


def _sampled(
    world: World, load: CubicSpline, rising: _Branch, falling: _Branch, amplitude_mm: float, ends: _Ends
) -> TrueLoop:
    displacement = amplitude_mm * world.drive.waveform.shape()
    place = np.arange(SAMPLES)
    top, bottom = int(displacement.argmax()), int(displacement.argmin())
    down = (place > top) & (place <= bottom)
    relative = np.where(
        down,
        np.interp(displacement, falling.displacement_mm, falling.relative_mm),
        np.interp(displacement, rising.displacement_mm, rising.relative_mm),
    )
    force = np.where(
        down,
        np.interp(displacement, falling.displacement_mm, falling.force_N),
        np.interp(displacement, rising.displacement_mm, rising.force_N),
    )
    return TrueLoop(displacement, force, np.asarray(load(relative)), (ends.low_mm, ends.high_mm))
