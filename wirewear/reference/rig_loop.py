"""Fretting loop of a circular contact in series with the rig's tangential spring, constant friction, no wear.

The drive displaces the moving wire by δ; the rig takes Q/K_s of it, the contact the rest. N, mm, N·mm = mJ.
rig_stiffness_N_per_mm may be math.inf (rigid rig). The formulas follow from the Cattaneo–Mindlin curve, the linear
spring and Masing's rule, which a series of springs and sliders obeys exactly.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from geometry.arrays import Array
from wirewear.reference.cattaneo_mindlin import PartialSlipPoint, energy_per_cycle, loading_displacement
from wirewear.reference.hertz import require_positive


@dataclass(frozen=True)
class HysteresisLoop:
    """A closed loop, starting at mid-stroke moving towards +x; the last sample does not repeat the first; shapes (n,).

    time_cycles runs from 0 to (n − 1)/n of a cycle.
    """

    time_cycles: Array
    displacement_mm: Array
    tangential_force_N: Array


def sliding_threshold(contact: PartialSlipPoint, rig_stiffness_N_per_mm: float = math.inf) -> float:
    """Smallest displacement amplitude with gross slip, µP/K_s + 1.5 µP/K_c, in mm."""
    require_positive(rig_stiffness_N_per_mm=rig_stiffness_N_per_mm)
    return contact.limit_N / rig_stiffness_N_per_mm + contact.full_slip_displacement_mm


def unloading_stiffness(contact: PartialSlipPoint, rig_stiffness_N_per_mm: float = math.inf) -> float:
    """Slope just after a reversal, 1/(1/K_s + 1/K_c), in N/mm."""
    require_positive(rig_stiffness_N_per_mm=rig_stiffness_N_per_mm)
    return 1.0 / (1.0 / rig_stiffness_N_per_mm + 1.0 / contact.stiffness_N_per_mm)


def first_loading_force(
    contact: PartialSlipPoint, displacement_mm: ArrayLike, rig_stiffness_N_per_mm: float = math.inf
) -> Array:
    """Q on first loading through the spring, in N, odd in δ, µP beyond `sliding_threshold`.

    With s³ = 1 − Q/µP the displacement is the cubic (µP/K_s)(1 − s³) + 1.5(µP/K_c)(1 − s²), solved by bisection.
    """
    displacement = np.asarray(displacement_mm, float)
    spring = contact.limit_N / rig_stiffness_N_per_mm
    own = contact.full_slip_displacement_mm
    target = np.minimum(np.abs(displacement), sliding_threshold(contact, rig_stiffness_N_per_mm))
    low, high = np.zeros_like(target), np.ones_like(target)
    for _ in range(54):
        middle = 0.5 * (low + high)
        too_far = spring * (1.0 - middle**3) + own * (1.0 - middle**2) > target
        low, high = np.where(too_far, middle, low), np.where(too_far, high, middle)
    force: Array = np.sign(displacement) * contact.limit_N * (1.0 - high**3)
    return force


def force_amplitude(
    contact: PartialSlipPoint, displacement_amplitude_mm: float, rig_stiffness_N_per_mm: float = math.inf
) -> float:
    """Q* of the closed loop of amplitude δa, in N."""
    require_positive(displacement_amplitude_mm=displacement_amplitude_mm)
    return float(first_loading_force(contact, displacement_amplitude_mm, rig_stiffness_N_per_mm))


def slip_amplitude(
    contact: PartialSlipPoint, displacement_amplitude_mm: float, rig_stiffness_N_per_mm: float = math.inf
) -> float:
    """δ0, half the loop's width at Q = 0, in mm; in gross slip δa − µP/K_s − 1.110 µP/K_c."""
    amplitude = force_amplitude(contact, displacement_amplitude_mm, rig_stiffness_N_per_mm)
    own = 2.0 * float(loading_displacement(contact, 0.5 * amplitude))
    return displacement_amplitude_mm - amplitude / rig_stiffness_N_per_mm - own


def dissipated_energy(
    contact: PartialSlipPoint, displacement_amplitude_mm: float, rig_stiffness_N_per_mm: float = math.inf
) -> float:
    """E_d of a closed loop in mJ; in gross slip 4µP(δa − µP/K_s) − 4.8(µP)²/K_c."""
    amplitude = force_amplitude(contact, displacement_amplitude_mm, rig_stiffness_N_per_mm)
    sliding = max(displacement_amplitude_mm - sliding_threshold(contact, rig_stiffness_N_per_mm), 0.0)
    return energy_per_cycle(contact, amplitude) + 4.0 * contact.limit_N * sliding


def branch_force(
    contact: PartialSlipPoint,
    displacement_mm: ArrayLike,
    displacement_amplitude_mm: float,
    rig_stiffness_N_per_mm: float = math.inf,
    *,
    forward: bool,
) -> Array:
    """Q at δ on one branch of the closed loop, in N: ∓Q* ± 2Q₁(|δ ± δa|/2), upper signs on the forward branch."""
    amplitude = force_amplitude(contact, displacement_amplitude_mm, rig_stiffness_N_per_mm)
    sign = 1.0 if forward else -1.0
    travelled = displacement_amplitude_mm + sign * np.asarray(displacement_mm, float)
    gained = 2.0 * first_loading_force(contact, 0.5 * travelled, rig_stiffness_N_per_mm)
    return sign * np.minimum(gained - amplitude, amplitude)


def closed_loop(
    contact: PartialSlipPoint,
    displacement_amplitude_mm: float,
    rig_stiffness_N_per_mm: float = math.inf,
    samples: int = 400,
) -> HysteresisLoop:
    """The whole steady Q–δ loop under a sinusoidal drive, in partial or in gross slip.

    Raises ValueError for fewer than 8 samples or values that are not positive.
    """
    if samples < 8:
        raise ValueError(f"samples must be at least 8, not {samples}")
    time = np.arange(samples) / samples
    displacement = displacement_amplitude_mm * np.sin(2.0 * np.pi * time)
    forward = np.cos(2.0 * np.pi * time) >= 0.0
    force = np.where(
        forward,
        branch_force(contact, displacement, displacement_amplitude_mm, rig_stiffness_N_per_mm, forward=True),
        branch_force(contact, displacement, displacement_amplitude_mm, rig_stiffness_N_per_mm, forward=False),
    )
    return HysteresisLoop(time, displacement, force)
