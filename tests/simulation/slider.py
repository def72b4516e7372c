"""A ball that slides on a flat behind a spring, under a load that changes within the cycle: its loop, slip and energy.

The ball's contact is represented by a row of springs, each with its own load and Coulomb's friction, which has the
forces and the friction work of Cattaneo and Mindlin's contact under any path (Jäger, Arch. Appl. Mech. 65 (1995) 478;
Popov and Hess, Method of Dimensionality Reduction, 2015, chapter 5). A spring that comes into contact starts without
friction force, and loses it when contact ends. The code shares nothing with the solver, which is tested against it.
"""

import math
from dataclasses import dataclass

import numpy as np

from geometry.arrays import Array

_CYCLES = 2  #: Until the loop is closed.
_SPRINGS = 40
_MOVED_OUT = 60  #: Steps from mid-stroke to the stroke's end.


@dataclass(frozen=True)
class SlidingBall:
    """A ball on a flat: its radius, the moduli E* and G* of the pair, the coefficient of friction, and the stiffness of
    the rig's spring along the motion (inf: rigid).
    """

    radius_mm: float
    modulus_MPa: float
    tangential_modulus_MPa: float
    friction: float
    rig_stiffness_N_per_mm: float = math.inf


@dataclass(frozen=True)
class SliderLoop:
    """A closed loop from where the drive is at +amplitude, at the ends of n equal parts of the cycle; arrays (n,)."""

    displacement_mm: Array
    slid_mm: Array  #: Distance that the ball has slid, averaged over its load; without contact, that which it moves.
    force_N: Array

    @property
    def slip_amplitude_mm(self) -> float:
        """Half of the range of `slid_mm`."""
        return 0.5 * float(np.ptp(self.slid_mm))

    @property
    def energy_mJ(self) -> float:
        """Dissipated energy: area of the loop of force over displacement, by the trapezoidal rule."""
        means = 0.5 * (self.force_N + np.roll(self.force_N, 1))
        return float(means @ (self.displacement_mm - np.roll(self.displacement_mm, 1)))


def slider_loop(amplitude_mm: float, load_N: Array, ball: SlidingBall, pressed_N: float | None = None) -> SliderLoop:
    """The closed loop of a ball that a sinusoidal drive moves by ±amplitude_mm through the rig's spring.

    load_N: (n,) at the ends of n equal parts of the cycle, which starts at +amplitude; 0 where there is no contact.
    pressed_N: load under which it is pressed at mid-stroke, which what sticks for good remembers; None: it starts
    without force at +amplitude.
    """
    count = len(load_N)
    drive = amplitude_mm * np.cos(2.0 * np.pi * np.arange(1, count + 1) / count)
    out = np.linspace(0.0, 1.0, 0 if pressed_N is None else _MOVED_OUT)
    path = np.concatenate([amplitude_mm * out, *[drive] * _CYCLES])
    loads = np.concatenate([(pressed_N or 0.0) * (1.0 - out) + load_N[-1] * out, *[load_N] * _CYCLES])
    largest = (3.0 * float(load_N.max()) * ball.radius_mm / (4.0 * ball.modulus_MPa)) ** (1.0 / 3.0)
    width = largest / _SPRINGS
    depth = ((np.arange(_SPRINGS) + 0.5) * width) ** 2 / ball.radius_mm
    stiffness, across = 2.0 * ball.tangential_modulus_MPa * width, 2.0 * ball.modulus_MPa * width
    limits = np.array([ball.friction * _carried(float(load), depth, across) for load in loads])
    strain, place, slid = np.zeros(_SPRINGS), float(drive[-1]) if pressed_N is None else 0.0, 0.0
    found = np.empty((len(loads), 2))
    for k, (moved, load, limit) in enumerate(zip(path, loads, limits, strict=True)):
        reach = limit / stiffness
        step = _step(strain, reach, stiffness, float(moved) - place, ball.rig_stiffness_N_per_mm)
        held = np.clip(strain + step, -reach, reach)
        slid += float((strain + step - held) @ limit) / float(limit.sum()) if load > 0.0 else step
        strain, place = held, place + step
        found[k] = slid, stiffness * float(held.sum())
    return SliderLoop(drive, *found[-count:].T)


def _carried(load_N: float, depth_mm: Array, stiffness: float) -> Array:
    """Share (m,) in N of a load that each spring carries; depth_mm: (m,) increasing, the approach at which it
    touches.
    """
    if load_N <= 0.0:
        return np.zeros_like(depth_mm)
    # The first k springs carry the load at an approach that is the least for those that touch.
    approach = float(np.min((load_N / stiffness + np.cumsum(depth_mm)) / np.arange(1, len(depth_mm) + 1)))
    return stiffness * np.maximum(approach - depth_mm, 0.0)


def _step(strain: Array, reach: Array, stiffness: float, ahead: float, rig: float) -> float:
    """Motion in mm of the ball until the rig's spring, with its drive `ahead` of the ball, balances the contact's
    springs.
    """
    if math.isinf(rig):
        return ahead
    bends = np.sort(np.concatenate([-reach - strain, reach - strain]))
    most = stiffness * float(reach.sum()) / rig
    bends = np.concatenate([[min(bends[0], ahead - most) - 1.0], bends, [max(bends[-1], ahead + most) + 1.0]])
    forces = stiffness * np.clip(strain + bends[:, None], -reach, reach).sum(axis=1)
    return float(np.interp(0.0, forces - rig * (ahead - bends), bends))
