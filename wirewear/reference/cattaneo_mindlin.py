"""Cattaneo–Mindlin partial slip of a circular Hertz contact under constant normal load (N, mm, MPa).

Cattaneo 1938, Mindlin 1949, Mindlin & Deresiewicz 1953; Johnson, Contact Mechanics, 1985, sections 7.2 and 7.4.
Reversals follow Masing's rule: after a reversal at (u*, Q*) the change of displacement is twice that of first loading
at half the change of force. Symbols: force_N is Q, reversal_force_N and force_amplitude_N are Q*, displacement_mm of
the contact is u, radius_mm is r; an index 1, as in u₁ or Q₁, denotes first loading.

In the fretting loop behind a rig's tangential spring, under constant friction and without wear, the drive displaces the
moving body by δ = displacement_mm, at most by δa; the rig takes Q/K_s of it, the contact of stiffness K the rest (N·mm
= mJ). rig_stiffness_N_per_mm is K_s and may be math.inf (a rigid rig). The formulas follow from the curve, the linear
spring and Masing's rule, which a series of springs and sliders obeys exactly.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from geometry import Elastic
from geometry.arrays import Array
from wirewear.reference.hertz import PointContact, require_positive


@dataclass(frozen=True)
class PartialSlipPoint:
    """A circular contact of radius a that carries the normal load P and a tangential force Q of at most µP.

    stiffness_N_per_mm is Mindlin's initial tangential stiffness K = 2G*a. Raises ValueError unless all fields are
    positive.
    """

    normal_load_N: float
    friction: float
    contact_radius_mm: float
    stiffness_N_per_mm: float

    def __post_init__(self) -> None:
        require_positive(
            normal_load_N=self.normal_load_N,
            friction=self.friction,
            contact_radius_mm=self.contact_radius_mm,
            stiffness_N_per_mm=self.stiffness_N_per_mm,
        )

    @property
    def limit_N(self) -> float:
        """The sliding force µP."""
        return self.friction * self.normal_load_N

    @property
    def full_slip_displacement_mm(self) -> float:
        """Displacement u_slip = 1.5 µP/K at which a first loading starts to slide."""
        return 1.5 * self.limit_N / self.stiffness_N_per_mm


def mindlin_stiffness(tangential_modulus_MPa: float, contact_radius_mm: float) -> float:
    """Mindlin's tangential stiffness K = 2G*a in N/mm (Johnson 1985, section 7.2)."""
    return 2.0 * tangential_modulus_MPa * contact_radius_mm


def elliptic_stiffness(contact: PointContact, material: Elastic, angle_rad: float = 0.0) -> float:
    """Tangential stiffness in N/mm of an elliptic contact of two bodies of one material that sticks all over, moved at
    an angle from its major axis and held sideways.

    Along the axes a and b it is πGa/[(1 − ν)K + νD] and πGa/[K − νD], K and D = (K − E)/e² by the complete integrals of
    the eccentricity e (Mindlin, J. Appl. Mech. 16 (1949) 259).
    """
    from scipy.special import elliprd, elliprf

    squared = (contact.minor_semi_axis_mm / contact.major_semi_axis_mm) ** 2
    k, d, nu = float(elliprf(0.0, squared, 1.0)), float(elliprd(0.0, squared, 1.0)) / 3.0, material.poissons_ratio
    stiffness = math.pi * material.shear_modulus_MPa * contact.major_semi_axis_mm
    along, across = stiffness / ((1.0 - nu) * k + nu * d), stiffness / (k - nu * d)
    return along * math.cos(angle_rad) ** 2 + across * math.sin(angle_rad) ** 2


def partial_slip_point(
    normal_load_N: float, friction: float, contact_radius_mm: float, tangential_modulus_MPa: float
) -> PartialSlipPoint:
    """The contact of this Hertz radius whose stiffness follows from the tangential modulus G*."""
    stiffness = mindlin_stiffness(tangential_modulus_MPa, contact_radius_mm)
    return PartialSlipPoint(normal_load_N, friction, contact_radius_mm, stiffness)


def stick_radius(contact: PartialSlipPoint, force_N: ArrayLike) -> Array:
    """Stick radius c = a(1 − |Q|/µP)^⅓ in mm on first loading, of the forces' shape; 0 when sliding. Raises ValueError
    beyond µP.
    """
    return contact.contact_radius_mm * np.cbrt(_unused_capacity(contact, force_N))


def loading_displacement(contact: PartialSlipPoint, force_N: ArrayLike) -> Array:
    """Displacement u = 3µP/(2K) · [1 − (1 − |Q|/µP)^⅔] in mm on first loading, odd in Q, of the forces' shape. Raises
    ValueError beyond µP.
    """
    remaining = np.cbrt(_unused_capacity(contact, force_N)) ** 2
    direction: Array = np.sign(np.asarray(force_N, float))
    return direction * contact.full_slip_displacement_mm * (1.0 - remaining)


def loading_force(contact: PartialSlipPoint, displacement_mm: ArrayLike) -> Array:
    """Force Q = µP[1 − (1 − |u|/u_slip)^(3/2)] in N on first loading, odd in u, of the displacements' shape; µP beyond
    u_slip.
    """
    u = np.asarray(displacement_mm, float)
    remaining = np.maximum(1.0 - np.abs(u) / contact.full_slip_displacement_mm, 0.0)
    force: Array = np.sign(u) * contact.limit_N * (1.0 - remaining**1.5)
    return force


def displacement_after_reversal(contact: PartialSlipPoint, force_N: ArrayLike, reversal_force_N: float) -> Array:
    """Displacement u(Q) = u* − 2u₁((Q* − Q)/2) in mm after first loading to Q* and reversal, of the forces' shape.

    Q lies between Q* and −Q*; a negative Q* describes reloading in a closed cycle. Raises ValueError where |Q* − Q|
    exceeds 2µP.
    """
    change = 0.5 * (reversal_force_N - np.asarray(force_N, float))
    return loading_displacement(contact, reversal_force_N) - 2.0 * loading_displacement(contact, change)


def loading_traction(contact: PartialSlipPoint, radius_mm: ArrayLike, force_N: float) -> Array:
    """Traction q(r) = µp0[√(1 − r²/a²) − (c/a)√(1 − r²/c²)] in MPa at radii r (any shape) on first loading, odd in Q;
    the second term counts for r < c only, and all is 0 for r > a.
    """
    r = np.asarray(radius_mm, float)
    a, c = contact.contact_radius_mm, float(stick_radius(contact, force_N))
    sliding = np.sqrt(np.maximum(a**2 - r**2, 0.0)) / a
    stuck = np.sqrt(np.maximum(c**2 - r**2, 0.0)) / a
    peak = 3.0 * contact.limit_N / (2.0 * np.pi * a**2)
    return float(np.sign(force_N)) * peak * (sliding - stuck)


def traction_after_reversal(
    contact: PartialSlipPoint, radius_mm: ArrayLike, force_N: float, reversal_force_N: float
) -> Array:
    """Traction q(r) = q₁(Q*) − 2q₁((Q* − Q)/2) in MPa at radii r (any shape), after first loading to Q* and unloading
    to Q.
    """
    change = 0.5 * (reversal_force_N - force_N)
    first = loading_traction(contact, radius_mm, reversal_force_N)
    return first - 2.0 * loading_traction(contact, radius_mm, change)


def stick_radius_after_reversal(contact: PartialSlipPoint, force_N: float, reversal_force_N: float) -> float:
    """Radius c' = a[1 − |Q* − Q|/(2µP)]^⅓ in mm inside which nothing slips back after a reversal at Q*; outside, an
    annulus does.
    """
    return float(stick_radius(contact, 0.5 * (reversal_force_N - force_N)))


def energy_per_cycle(contact: PartialSlipPoint, force_amplitude_N: float) -> float:
    """Energy in mJ that a closed cycle between ±Q* dissipates, without gross slip.

    (µP)²/K times `cyclic_loss`. Raises ValueError beyond µP.
    """
    ratio = 1.0 - _unused_capacity(contact, force_amplitude_N)
    return float(contact.limit_N**2 / contact.stiffness_N_per_mm * cyclic_loss(ratio))


def cyclic_loss(ratio: ArrayLike) -> Array:
    """Energy of a closed cycle of forces T = Q*/µP between 0 and 1, times K/(µP)².

    7.2 {1 − (1−T)^(5/3) − (5T/6)[1 + (1−T)^⅔]} (Mindlin & Deresiewicz 1953).
    """
    ratio = np.asarray(ratio, float)
    unused = 1.0 - ratio
    braces = 1.0 - unused ** (5.0 / 3.0) - 5.0 * ratio / 6.0 * (1.0 + unused ** (2.0 / 3.0))
    # the terms cancel to third order: their Taylor series keeps six digits where little is reached
    series = 5.0 / 162.0 * ratio**3 * (1.0 + ratio * 2.0 / 3.0)
    return np.asarray(7.2 * np.where(ratio < 2e-3, series, braces))


def _unused_capacity(contact: PartialSlipPoint, force_N: ArrayLike) -> Array:
    """1 − |Q|/µP, at least 0; ValueError for forces beyond µP by more than round-off."""
    unused = 1.0 - np.abs(np.asarray(force_N, float)) / contact.limit_N
    if np.any(unused < -1e-9):
        raise ValueError(f"the tangential force must not exceed µP = {contact.limit_N:g} N")
    clipped: Array = np.maximum(unused, 0.0)
    return clipped


@dataclass(frozen=True)
class HysteresisLoop:
    """A closed loop, starting at mid-stroke moving towards +x; the last sample does not repeat the first; arrays (n,).

    time_cycles runs from 0 to (n − 1)/n of a cycle.
    """

    time_cycles: Array
    displacement_mm: Array
    tangential_force_N: Array


def sliding_threshold(contact: PartialSlipPoint, rig_stiffness_N_per_mm: float = math.inf) -> float:
    """Smallest displacement amplitude with gross slip, µP/K_s + 1.5 µP/K, in mm."""
    require_positive(rig_stiffness_N_per_mm=rig_stiffness_N_per_mm)
    return contact.limit_N / rig_stiffness_N_per_mm + contact.full_slip_displacement_mm


def unloading_stiffness(contact: PartialSlipPoint, rig_stiffness_N_per_mm: float = math.inf) -> float:
    """Slope of the loop just after a reversal, 1/(1/K_s + 1/K), in N/mm."""
    require_positive(rig_stiffness_N_per_mm=rig_stiffness_N_per_mm)
    return 1.0 / (1.0 / rig_stiffness_N_per_mm + 1.0 / contact.stiffness_N_per_mm)


def first_loading_force(
    contact: PartialSlipPoint, displacement_mm: ArrayLike, rig_stiffness_N_per_mm: float = math.inf
) -> Array:
    """Force Q in N on first loading through the rig's spring at displacements δ (any shape), odd in δ; µP beyond
    `sliding_threshold`.

    With s³ = 1 − Q/µP the displacement is the cubic (µP/K_s)(1 − s³) + 1.5(µP/K)(1 − s²), solved by bisection.
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
    """Largest force Q* in N of the closed loop of amplitude δa; µP in gross slip. Raises ValueError for an amplitude
    that is not positive.
    """
    require_positive(displacement_amplitude_mm=displacement_amplitude_mm)
    return float(first_loading_force(contact, displacement_amplitude_mm, rig_stiffness_N_per_mm))


def slip_amplitude(
    contact: PartialSlipPoint, displacement_amplitude_mm: float, rig_stiffness_N_per_mm: float = math.inf
) -> float:
    """Slip amplitude δ0 in mm, half the loop's width at Q = 0; in gross slip δa − µP/K_s − 1.110 µP/K."""
    amplitude = force_amplitude(contact, displacement_amplitude_mm, rig_stiffness_N_per_mm)
    own = 2.0 * float(loading_displacement(contact, 0.5 * amplitude))
    return displacement_amplitude_mm - amplitude / rig_stiffness_N_per_mm - own


def dissipated_energy(
    contact: PartialSlipPoint, displacement_amplitude_mm: float, rig_stiffness_N_per_mm: float = math.inf
) -> float:
    """Energy in mJ of the closed loop of amplitude δa; in gross slip 4µP(δa − µP/K_s) − 4.8(µP)²/K."""
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
    """Tangential force Q in N on one branch of the closed loop, of the shape of `displacement_mm`.

    displacement_mm: δ, displacements of the drive, any shape. displacement_amplitude_mm: δa. forward: True for the
    branch towards +x, with Q = −Q* + 2 Q₁((δ + δa)/2); False for the one back, with Q = Q* − 2 Q₁((δa − δ)/2). Q* is
    the force at the reversals and Q₁(d) the force of first loading at a drive displacement d (`first_loading_force`).
    """
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
    """The whole steady Q–δ loop under a sinusoidal drive of amplitude δa, in partial or in gross slip; samples:
    their number in the cycle.

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
