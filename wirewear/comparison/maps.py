"""Maps of fretting tests over displacement and load: running conditions, and response of the material.

Running conditions (O. Vingsbo and S. Söderberg, Wear 126 (1988) 131) are partial slip, mixed and gross slip. The fresh
contact slides as a whole from 3µP/(2K) on (Mindlin); a rig in series takes µP/K_rig more.

The material's response (L. Vincent, Y. Berthier, M. C. Dubourg and M. Godet, Wear 153 (1992) 135) is cracking of a
contact that sticks in its middle and is overstressed, or wear of one that slides as a whole. The stress here is the
largest one on the surface: the tension at the trailing edge of the fresh contact of half-spaces in Cattaneo–Mindlin
slip. Wear flattens a sliding contact and reduces that tension.

Worn volume over friction energy is fitted by a straight line with intervals by Student's t.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import radians

import numpy as np
import scipy
from numpy.typing import ArrayLike

from geometry import Elastic
from geometry.arrays import Array, BoolArray
from wirewear.base.errors import StudyError
from wirewear.loops.energy import SYSTEM_FREE_TRANSITION
from wirewear.reference.cattaneo_mindlin import PartialSlipPoint, loading_displacement, partial_slip_point
from wirewear.reference.half_space import partial_slip_stress
from wirewear.reference.hertz import contact_modulus, gap_curvatures, hertz_elliptic, tangential_contact_modulus
from wirewear.test.study import point_study

LOADS = np.geomspace(0.1, 10.0, 41)  #: Loads of the map, relative to the test's.

#: A loop of this energy ratio is at the transition (S. Fouvry, P. Kapsa, L. Vincent, Wear 185 (1995) 35).
TRANSITION = 0.2
FULL = 0.85  #: No loop in partial slip fills so much of the box of its slip and its forces: at the transition, 0.77.


#: Shares of the sliding force at which the tension is computed; it begins with a vertical tangent.
SHARES = np.linspace(0.0, 1.0, 61) ** 3
POINTS, MOST_LINES = 41, 5  #: Loads of a line in partial slip; lines at most, where none is asked for.


@dataclass(frozen=True)
class FreshContact:
    """Contact of two bodies before they wear.

    bodies: their elastic constants. gap_per_mm: curvatures of the gap along its two principal directions in 1/mm.
    friction: coefficient. rig_um_per_N: compliance of the rig.
    """

    bodies: tuple[Elastic, Elastic]
    gap_per_mm: tuple[float, float]
    friction: float
    rig_um_per_N: float
    normal_load_N: float

    @property
    def ball_diameter_mm(self) -> float:
        """Diameter of the ball on a flat whose gap has the same geometric mean curvature: of equal wires at right
        angles, the wires' diameter.
        """
        small, large = self.gap_per_mm
        return float(1.0 / (small * large) ** 0.5)

    def at(self, load_N: float) -> tuple[PartialSlipPoint, float]:
        """The Cattaneo–Mindlin contact under a normal load, on a circle of equal area, and its peak pressure in MPa."""
        first, second = self.bodies
        hertz = hertz_elliptic(load_N, *self.gap_per_mm, contact_modulus(first, second))
        modulus = tangential_contact_modulus(first, second)
        return partial_slip_point(load_N, self.friction, hertz.contact_radius_mm, modulus), hertz.peak_pressure_MPa


@dataclass(frozen=True)
class RunningConditions:
    """Transition to gross slip at n loads.

    contact_um, test_um: (n,) displacement amplitudes from which the contact alone, and the contact with its rig, slide
    as a whole.
    """

    normal_load_N: Array
    contact_um: Array
    test_um: Array


def fresh_contact(study: Mapping[str, object]) -> FreshContact | None:
    """The unworn contact of a study, given by its resolved tables; None if it states too little, has no friction, or is
    of a pad.
    """
    try:
        stated = point_study(study, "the study")
    except StudyError:
        return None
    friction, rig = stated.contact.friction, stated.holder.tangential_stiffness_N_per_mm
    if friction <= 0.0:
        return None
    first, second = stated.bodies
    if first.face or second.face:
        return None
    crossing = radians(stated.crossing_angle_deg)
    small, large, _ = gap_curvatures(first.curvatures_per_mm, second.curvatures_per_mm, crossing)
    compliance = 0.0 if isinstance(rig, str) else 1e3 / rig
    bodies, load = (first.material, second.material), stated.conditions.normal_load_N
    return FreshContact(bodies, (small, large), friction, compliance, load)


def running_conditions(study: Mapping[str, object]) -> RunningConditions | None:
    """Transition to gross slip of a study, given by its resolved tables, at LOADS times its load; None without
    `fresh_contact`.
    """
    contact = fresh_contact(study)
    return None if contact is None else transition(contact, contact.normal_load_N * LOADS)


def transition(contact: FreshContact, loads_N: ArrayLike) -> RunningConditions:
    """Displacement amplitudes from which a contact slides as a whole, alone and with its rig, at loads (n,) in N."""
    loads = np.asarray(loads_N, dtype=np.float64)
    own = np.array([1e3 * contact.at(float(load))[0].full_slip_displacement_mm for load in loads])
    return RunningConditions(loads, own, own + contact.rig_um_per_N * contact.friction * loads)


def energy_ratio(energy_mJ: Array, amplitude_um: Array, force_N: Array) -> Array:
    """Ratio A = E_d/(4 δa Q*) (n,) of loops from energy, displacement amplitude and largest force: 1 for a rectangular
    loop, 0.2 at the transition to gross slip, 0 for a line; NaN if δa or Q* is 0.
    """
    box = 4e-3 * amplitude_um * force_N
    return np.divide(energy_mJ, box, out=np.full_like(energy_mJ, np.nan), where=box > 0.0)


def slides(energy_mJ: Array, amplitude_um: Array, slip_um: Array, force_N: Array) -> BoolArray:
    """True for contacts (n,) that slide as a whole, by any of three criteria.

    energy_mJ, amplitude_um, slip_um, force_N: (n,) of the loops. The criteria: the energy ratio A; the loop's width
    over its stroke, for scars whose slopes add to the force; the ratio B, for compliant rigs that take most of the
    stroke.
    """
    wide = slip_um / amplitude_um > TRANSITION / SYSTEM_FREE_TRANSITION
    full = energy_ratio(energy_mJ, slip_um, force_N) > FULL
    whole: BoolArray = (energy_ratio(energy_mJ, amplitude_um, force_N) > TRANSITION) | wide | full
    return whole


@dataclass(frozen=True)
class TensionLine:
    """Displacement amplitudes (n,) in µm and loads (n,) in N at which the tension at the contact's edge reaches
    `tension_MPa`.
    """

    tension_MPa: float
    displacement_um: Array
    normal_load_N: Array


def edge_tension(contact: FreshContact) -> Array:
    """Largest tension at the trailing edge over the peak pressure, for each of SHARES of the sliding force (61,); of
    both bodies, the larger one. It rises from (1 − 2ν)/3 without a tangential force to (1 − 2ν)/3 + µπ(4 + ν)/8 in
    gross slip (Hamilton 1983).
    """
    stick = np.maximum(np.cbrt(1.0 - SHARES), 1e-6)
    found: Array = np.max(
        [
            [
                partial_slip_stress(
                    -1.0,
                    0.0,
                    0.0,
                    contact_radius_mm=1.0,
                    stick_radius_mm=float(centre),
                    peak_pressure_MPa=1.0,
                    friction=contact.friction,
                    poissons_ratio=ratio,
                )[..., 0]
                for centre in stick
            ]
            for ratio in {body.poissons_ratio for body in contact.bodies}
        ],
        axis=0,
    )
    return found


def tension_lines(
    contact: FreshContact, reach_um: float, loads_N: tuple[float, float], tensions_MPa: Sequence[float] = ()
) -> list[TensionLine]:
    """Lines of equal tension up to the displacement `reach_um`, between two loads in N; tensions_MPa: by default round
    values. Where the contact slides as a whole a line goes on at constant load, as the tension grows no further.
    Tensions that no load reaches have no line.
    """
    shape = edge_tension(contact)
    peaks = [contact.at(load)[1] for load in loads_N]
    # Where none is asked for, lines begin at the tension of this share under the lowest load.
    least = float(np.interp(0.5, SHARES, shape))
    values = tensions_MPa or _round_values(peaks[0] * least, peaks[1] * float(shape[-1]))
    return [line for value in values if (line := _line(contact, shape, value, reach_um, loads_N)) is not None]


def _line(
    contact: FreshContact, shape: Array, tension_MPa: float, reach_um: float, loads_N: tuple[float, float]
) -> TensionLine | None:
    reference = contact.at(1.0)[1]
    # The peak pressure grows with the cube root of the load.
    all_slide, none_slides = ((tension_MPa / (reference * float(shape[end]))) ** 3 for end in (-1, 0))
    low, high = max(all_slide, loads_N[0]), min(none_slides, loads_N[1])
    if low >= high:
        return None
    x, y = [], []
    for load in np.geomspace(low, high, POINTS):
        point, peak = contact.at(float(load))
        share = float(np.interp(tension_MPa / peak, shape, SHARES))
        force = share * point.limit_N
        x.append(1e3 * float(loading_displacement(point, force)) + contact.rig_um_per_N * force)
        y.append(float(load))
    if all_slide >= loads_N[0] and reach_um > x[0]:
        x, y = [reach_um, *x], [y[0], *y]
    return TensionLine(tension_MPa, np.array(x), np.array(y))


def _round_values(low: float, high: float) -> list[float]:
    """The largest MOST_LINES, at most, of the round values 1, 2, 5, 10, … between two limits."""
    first = int(np.floor(np.log10(low)))
    found = [step * 10.0**power for power in range(first, first + 6) for step in (1.0, 2.0, 5.0)]
    return [value for value in found if low <= value <= high][-MOST_LINES:]


@dataclass(frozen=True)
class RegressionLine:
    """Line V = slope · (ΣE_d − threshold) through tests; intervals contain the true values with a probability
    of 95 %.
    """

    slope_mm3_per_J: float  #: Worn volume per friction energy.
    #: Interval of the slope; infinite if one test alone leaves it unknown.
    slope_interval95: tuple[float, float]
    threshold_J: float  #: Energy below which nothing wears; 0 for a line through the origin.
    threshold_interval95: tuple[float, float]  #: Interval of the threshold.
    #: Share of the volumes' variance that the line explains (R²); NaN if all volumes are equal.
    explained: float
    tests: int


def line_through_origin(energy_J: ArrayLike, volume_mm3: ArrayLike) -> RegressionLine:
    """The line V = α E through n ≥ 1 tests, with α in mm³/J by least squares (Fouvry et al., Wear 255 (2003) 287).

    energy_J: (n,) friction energy E of each test, at least one above 0. volume_mm3: (n,) worn volume V.
    """
    x, y = np.asarray(energy_J, dtype=np.float64), np.asarray(volume_mm3, dtype=np.float64)
    # Squares of energies that next to no friction leaves would vanish.
    largest = float(np.abs(x).max())
    share = x / largest
    square = float(share @ share)
    slope = float(share @ y) / square / largest
    left = y - slope * x
    # One test alone lies on its line, which nothing shows the uncertainty of.
    free = x.size - 1
    half = _quantile(free) * np.sqrt(float(left @ left) / free / square) / largest if free else np.inf
    return RegressionLine(slope, (slope - half, slope + half), 0.0, (0.0, 0.0), _explained(y, left), x.size)


def line_with_threshold(energy_J: ArrayLike, volume_mm3: ArrayLike) -> RegressionLine:
    """The line V = α (ΣE_d − E_th) through tests (n,), n ≥ 3, with different energies. The threshold's interval
    propagates the errors of slope and mean to first order.
    """
    x, y = np.asarray(energy_J, dtype=np.float64), np.asarray(volume_mm3, dtype=np.float64)
    middle, mean = float(x.mean()), float(y.mean())
    width = float(np.abs(x - middle).max())
    share = (x - middle) / width
    square = float(share @ share)
    slope = float(share @ (y - mean)) / square / width
    left = y - mean - slope * (x - middle)
    variance = float(left @ left) / (x.size - 2)
    threshold = middle - mean / slope if slope else float("nan")
    # Mean and slope are uncorrelated.
    t = _quantile(x.size - 2)
    half, of_mean = t * np.sqrt(variance / square) / width, t * np.sqrt(variance / x.size)
    wide = float(np.hypot(of_mean, mean / slope * half)) / abs(slope) if slope else float("inf")
    return RegressionLine(
        slope,
        (slope - half, slope + half),
        threshold,
        (threshold - wide, threshold + wide),
        _explained(y, left),
        x.size,
    )


def _quantile(free: int) -> float:
    return float(scipy.special.stdtrit(free, 0.975)) if free > 0 else float("inf")


def _explained(y: Array, left: Array) -> float:
    spread = float(np.sum((y - y.mean()) ** 2))
    return 1.0 - float(left @ left) / spread if spread > 0.0 else float("nan")
