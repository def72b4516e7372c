"""Estimates of a strand's contacts by closed forms: pressure, yielding, friction energy, wear, life (N, mm, MPa, mJ).

Hertz, Cattaneo and Mindlin on a circle of equal area, or a line contact sliding along itself; unworn half-spaces.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, inf, isnan, nan, pi, sin, sqrt

import numpy as np

from geometry import Elastic
from geometry.arrays import Array
from wirewear.reference.cattaneo_mindlin import energy_per_cycle, loading_displacement, partial_slip_point, stick_radius
from wirewear.reference.half_space import half_plane_line_stiffness, line_stress, partial_slip_stress
from wirewear.reference.hertz import contact_modulus, hertz_elliptic, hertz_line, tangential_contact_modulus
from wirewear.reference.wear import line_contact_scar, worn_volume
from wirewear.strand.contacts import LoadedWire, WireContact
from wirewear.test.life import LifeTable

#: Peak pressure over yield stress at first yield of a round contact and of a line (von Mises; Johnson, Contact
#: Mechanics, 1985, section 4.2), between them by the ratio of the ellipse's axes.
_YIELD_ROUND, _YIELD_LINE = 1.60, 1.79
_PLACES = 400


@dataclass(frozen=True)
class ContactEstimate:
    """Estimates of one kind of contact; energies and volumes are per cycle, for one contact or one millimetre of a
    line. Values are NaN where slip, and so energy, is not computed.

    major_mm, minor_mm: semi-axes of the contact, the major one infinite for a line. elastic_mm: displacement before
    sliding, or in all if it sticks. worn_depth_mm: of both wires together after all cycles. yield_ratio: peak pressure
    over that at first yield of the softer wire, NaN if unstated. plastic_area_mm2: load over 2.8 times the yield
    stress, NaN below yield. lives: cycles until a crack begins (lower, upper), NaN where not known.
    """

    contact: WireContact
    peak_pressure_MPa: float
    major_mm: float
    minor_mm: float
    elastic_mm: float
    energy_mJ: float
    worn_mm3: float
    worn_depth_mm: float
    yield_ratio: float
    plastic_area_mm2: float
    lives: tuple[float, float]

    @property
    def life_cycles(self) -> float:
        """Cycles until a crack begins in the first of both wires; NaN where not known."""
        known = [one for one in self.lives if not isnan(one)]
        return min(known, default=nan)

    @property
    def regime(self) -> str:
        """ "gross slip", "partial slip" or "not computed"."""
        share = self.contact.slip.share
        if isnan(share):
            return "not computed"
        return "gross slip" if share >= 1.0 else "partial slip"

    @property
    def severity(self) -> tuple[float, float]:
        """Sorting key, the least is the worst: (life in cycles, or infinite; minus friction energy per area, or 0)."""
        life = self.life_cycles
        area = pi * self.minor_mm * self.major_mm if self.major_mm < inf else 2.0 * self.minor_mm
        energy = self.energy_mJ / area
        return inf if isnan(life) else life, 0.0 if isnan(energy) else -energy


def estimated(
    contact: WireContact, friction: float, wear_mm3_per_J: float, cycles: int, life: LifeTable | None
) -> ContactEstimate:
    """Estimates of a contact; worn depths are after `cycles` cycles. life: criterion and data beside those of the
    wires' materials; None for no lives.
    """
    first, second = contact.elastic
    modulus = contact_modulus(first, second)
    small, large = contact.gap_per_mm
    limit, share = friction * contact.load_N, contact.slip.share
    sliding = 4.0 * limit * contact.slip_amplitude_mm
    if contact.is_line:
        line = hertz_line(contact.load_N, 0.5 / large, modulus)
        major, minor, peak = inf, line.half_width_mm, line.peak_pressure_MPa
        depth = contact.upper.wire.diameter_mm / 2.0
        elastic = share * limit / half_plane_line_stiffness(first, second, minor, 1.0, depth)
        energy = sliding + _partial_line_mJ(minor, friction * peak, share, first, second)
    else:
        hertz = hertz_elliptic(contact.load_N, small, large, modulus)
        major, minor, peak = hertz.major_semi_axis_mm, hertz.minor_semi_axis_mm, hertz.peak_pressure_MPa
        elastic = energy = nan
        if friction == 0.0 and not isnan(share):
            elastic = energy = 0.0
        elif not isnan(share):
            point = partial_slip_point(
                contact.load_N, friction, hertz.contact_radius_mm, tangential_contact_modulus(first, second)
            )
            elastic = float(loading_displacement(point, share * limit))
            energy = sliding + energy_per_cycle(point, share * limit)
    worn = worn_volume(wear_mm3_per_J, energy)
    ratio, area = _yielding(contact, peak, minor / major)
    return ContactEstimate(
        contact, peak, major, minor, elastic, energy, worn, _worn_depth_mm(contact, worn * cycles), ratio, area,
        _lives(contact, friction, peak, sqrt(major * minor) if major < inf else minor, life),
    )  # fmt: skip


def _worn_depth_mm(contact: WireContact, volume_mm3: float) -> float:
    """Depth of a flat scar with this volume: V = πh²/(2√(AB)) for a cap on the gap Ax² + By², or the segment of a line
    contact.
    """
    small, large = contact.gap_per_mm
    if not volume_mm3 > 0.0:
        return volume_mm3
    if contact.is_line:
        return line_contact_scar(volume_mm3, 0.5 / large).depth_mm
    return sqrt(2.0 * volume_mm3 * sqrt(small * large) / pi)


def _yielding(contact: WireContact, peak_MPa: float, ratio: float) -> tuple[float, float]:
    stated = (own.wire.yield_stress_MPa for own in contact.wires)
    known = [one for one in stated if one is not None]
    if not known:
        return nan, nan
    soft = min(known)
    beyond = peak_MPa / (soft * (_YIELD_LINE - (_YIELD_LINE - _YIELD_ROUND) * ratio))
    # Mean pressure over yield stress where a contact is fully plastic (Johnson 1985, section 6.3).
    return beyond, contact.load_N / (2.8 * soft) if beyond > 1.0 else nan


def _partial_line_mJ(half_width_mm: float, shear_MPa: float, share: float, first: Elastic, second: Elastic) -> float:
    """Energy per cycle of a millimetre of line contact in partial slip along the line, in mJ.

    Antiplane shear µp0 [√(1 − x²/a²) − (c/a)√(1 − x²/c²)] strains two bodies against each other by µp0 √(x² − c²)/a
    (1/G₁ + 1/G₂) outside the stick zone c; each half of a cycle slips twice the first loading there (Masing).
    """
    stick = half_width_mm * sqrt(max(1.0 - share, 0.0))
    x = np.linspace(stick, half_width_mm, _PLACES)
    compliance = 1.0 / first.shear_modulus_MPa + 1.0 / second.shear_modulus_MPa
    strain = shear_MPa / half_width_mm * compliance * np.sqrt(np.maximum(x**2 - stick**2, 0.0))
    slip = np.concatenate([[0.0], np.cumsum(0.5 * (strain[1:] + strain[:-1]) * np.diff(x))])
    traction = shear_MPa * np.sqrt(np.maximum(1.0 - (x / half_width_mm) ** 2, 0.0))
    return float(8.0 * np.trapezoid(traction * slip, x))


def _lives(
    contact: WireContact, friction: float, peak_MPa: float, reach_mm: float, life: LifeTable | None
) -> tuple[float, float]:
    if life is None:
        return nan, nan
    found = [
        _life(contact, own, angle, friction, peak_MPa, reach_mm, life)
        for own, angle in ((contact.lower, contact.lower_rad), (contact.upper, contact.upper_rad))
    ]
    return found[0], found[1]


def _life(
    contact: WireContact,
    wire: object,
    angle_rad: float,
    friction: float,
    peak_MPa: float,
    reach_mm: float,
    life: LifeTable,
) -> float:
    """Cycles until a crack begins at either edge of the contact, with stresses averaged as [life] states.

    Friction and bulk stress are taken to be largest at the same time, the bulk stress as at the extrados.
    """
    from wirewear.stress.averaging import kernel_of
    from wirewear.stress.criteria import criterion_of

    share = contact.slip.share
    if not isinstance(wire, LoadedWire) or isnan(share):
        return nan
    table = life.of_material(wire.wire.material)
    table.required(*table.needed)
    places, weights = kernel_of(table, plane=contact.is_line)(0.0)
    turned = angle_rad - contact.motion_rad
    edges = (-reach_mm, reach_mm)
    ends = []
    for sign in (1.0, -1.0):
        local = [weights @ _stress(contact, wire, places, edge, sign * share, friction, peak_MPa) for edge in edges]
        bulk = wire.mean_MPa + sign * wire.amplitude_MPa
        along = 0.5 * pi if contact.is_line else turned  # A line lies along y, and so does what it slides along.
        uniaxial = [cos(along) ** 2, sin(along) ** 2, 0.0, sin(along) * cos(along), 0.0, 0.0]
        ends.append(np.array(local) + bulk * np.array(uniaxial))
    share_of_life = criterion_of(table, wire.wire.elastic).damage(np.array(ends)).share
    return float(1.0 / share_of_life.max()) if share_of_life.max() > 0.0 else inf


def _stress(
    contact: WireContact,
    wire: LoadedWire,
    places: Array,
    edge_mm: float,
    share: float,
    friction: float,
    peak_MPa: float,
) -> Array:
    """Stresses (k, 6) at points (k, 3) relative to an edge of the contact, at one end of the motion."""
    x, y, z = places[:, 0] + edge_mm, places[:, 1], places[:, 2]
    ratio, sign = wire.wire.elastic.poissons_ratio, 1.0 if share > 0.0 else -1.0
    if contact.is_line:
        half = abs(edge_mm)
        stress = line_stress(x, z, half_width_mm=half, peak_pressure_MPa=peak_MPa, poissons_ratio=ratio)
        stick = half * sqrt(max(1.0 - abs(share), 0.0))
        along = _antiplane(x, z, half) - (_antiplane(x, z, stick) * stick / half if stick > 0.0 else 0.0)
        stress[:, 4] += sign * friction * peak_MPa * along.real
        stress[:, 3] += sign * friction * peak_MPa * along.imag
        return stress
    radius = abs(edge_mm)
    point = partial_slip_point(contact.load_N, max(friction, 1e-9), radius, 1.0)
    stick = max(float(stick_radius(point, abs(share) * point.limit_N)), 1e-6 * radius)
    # The end at −x is the mirror image of that at +x.
    stress = partial_slip_stress(
        sign * x, y, z, contact_radius_mm=radius, stick_radius_mm=stick, peak_pressure_MPa=peak_MPa, friction=friction,
        poissons_ratio=ratio,
    )  # fmt: skip
    return np.asarray(stress * np.array([1.0, 1.0, 1.0, sign, 1.0, sign]))


def _antiplane(x_mm: Array, z_mm: Array, half_width_mm: float) -> Array:
    """τ_yz + i τ_xy in the half-plane z > 0 under a unit shear √(1 − x²/a²) along y; harmonic and decaying
    with depth.
    """
    at = (x_mm + 1j * z_mm) / half_width_mm
    root = np.sqrt(1.0 - at) * np.sqrt(1.0 + at)
    return np.asarray(-(root + 1j * at))


def estimates(
    contacts: Sequence[WireContact], friction: float, wear_mm3_per_J: float, cycles: int, life: LifeTable | None
) -> list[ContactEstimate]:
    """Estimates of all contacts, the worst first; arguments as in `estimated`."""
    found = [estimated(one, friction, wear_mm3_per_J, cycles, life) for one in contacts]
    return sorted(found, key=lambda one: one.severity)
