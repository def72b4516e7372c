"""A strand or rope as a value: wires, layers of wires or of strands, and how a tension shares itself out among them.

Hruska (Wire and Wire Products 26 (1951) 766): no rotation, and no contraction of the radii. A strand in a rope is a
member as a wire is, of its own stiffness.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import cos, degrees, inf, pi, sin
from typing import TypeAlias

from geometry import Elastic
from wirewear.base.errors import StudyError
from wirewear.strand.helix import Hand, Helix, least_radius_mm

ARCH = 0.1  #: A layer whose neighbours touch farther off the one below, in diameters of its members, holds too many.
NEAR = 0.02  #: A layer laid at a stated radius touches the one below if it is this near, in diameters.
OVERLAP = 0.01  #: What members may overlap by rounding of what is stated, in diameters.
STEEPEST_deg = 45.0


@dataclass(frozen=True)
class RopeWire:
    """A round wire; its yield stress is None where it is not stated."""

    diameter_mm: float
    elastic: Elastic
    material: str | None = None
    yield_stress_MPa: float | None = None

    @property
    def area_mm2(self) -> float:
        return 0.25 * pi * self.diameter_mm**2

    @property
    def stiffness_N(self) -> float:
        """EA."""
        return self.elastic.youngs_modulus_MPa * self.area_mm2

    @property
    def bending_N_mm2(self) -> tuple[float, float]:
        """EI, twice: a wire has one."""
        own = self.elastic.youngs_modulus_MPa * pi * self.diameter_mm**4 / 64.0
        return own, own

    def torque_N_mm(self, tension_N: float) -> float:
        """None by tension."""
        return 0.0 * tension_N


@dataclass(frozen=True)
class Fibre:
    """A core that fills, and bears no tension."""

    diameter_mm: float
    stiffness_N: float = 0.0
    bending_N_mm2: tuple[float, float] = (0.0, 0.0)

    def torque_N_mm(self, tension_N: float) -> float:
        """None."""
        return 0.0 * tension_N


@dataclass(frozen=True)
class Layer:
    """So many wires, or strands, on a helix; gap_mm: between it and what lies below."""

    count: int
    member: "RopeWire | Strand"
    helix: Helix
    gap_mm: float
    touches: bool  #: Whether it presses on what lies below; else it arches, its members on one another.


@dataclass(frozen=True)
class Strand:
    """A core, a wire, a fibre or a strand, with layers around it, from the innermost on."""

    core: "RopeWire | Fibre | Strand"
    layers: tuple[Layer, ...]

    @property
    def diameter_mm(self) -> float:
        return outer_diameter_mm(self.core, self.layers)

    @cached_property
    def stiffness_N(self) -> float:
        """EA = Σ n EA cos³α, rotation held."""
        return self.core.stiffness_N + sum(
            own.count * own.member.stiffness_N * cos(own.helix.angle_rad) ** 3 for own in self.layers
        )

    @cached_property
    def bending_N_mm2(self) -> tuple[float, float]:
        """EI where all members slip freely, and where all stick: Σ n EI cos α, and ½ Σ n EA r² cos³α more."""
        least, most = self.core.bending_N_mm2
        for own in self.layers:
            slips, sticks = (own.count * one * cos(own.helix.angle_rad) for one in own.member.bending_N_mm2)
            lever = own.helix.radius_mm**2 * cos(own.helix.angle_rad) ** 3
            least += slips
            most += sticks + 0.5 * own.count * own.member.stiffness_N * lever
        return least, most

    def core_tension_N(self, tension_N: float) -> float:
        return tension_N * self.core.stiffness_N / self.stiffness_N

    def member_tension_N(self, layer: Layer, tension_N: float) -> float:
        """Tension along a member of a layer: EA ε cos²α at the strand's strain ε."""
        share = layer.member.stiffness_N * cos(layer.helix.angle_rad) ** 2 / self.stiffness_N
        return tension_N * share

    def torque_N_mm(self, tension_N: float) -> float:
        """What holds the rotation: Σ n (T sin α r + M cos α), positive of a right lay."""
        total = self.core.torque_N_mm(self.core_tension_N(tension_N))
        for own in self.layers:
            tension, alpha = self.member_tension_N(own, tension_N), own.helix.angle_rad
            turning = own.helix.hand * tension * sin(alpha) * own.helix.radius_mm
            total += own.count * (turning + own.member.torque_N_mm(tension) * cos(alpha))
        return total


Member: TypeAlias = RopeWire | Fibre | Strand


def outer_diameter_mm(core: Member, layers: Sequence[Layer]) -> float:
    """Of a core and the layers around it so far."""
    if not layers:
        return core.diameter_mm
    return 2.0 * layers[-1].helix.radius_mm + layers[-1].member.diameter_mm


def laid(
    below: tuple[Member, Sequence[Layer]],
    count: int,
    member: RopeWire | Strand,
    lay_length_mm: float,
    hand: Hand,
    radius_mm: float | None,
    where: str,
) -> Layer:
    """A layer on what lies below, at a stated radius or where it comes to rest: on it, or arched over it.

    Raises StudyError, in one sentence that begins with `where`, if it cannot hold its members.
    """
    what = "strands" if isinstance(member, Strand) else "wires"
    d, base = member.diameter_mm, outer_diameter_mm(*below)
    resting = 0.5 * (base + d)
    least = least_radius_mm(d, lay_length_mm, count)
    if least == inf:
        raise StudyError(
            f"{where} cannot hold {count} {what} of {d:.4g} mm: at a lay length of {lay_length_mm:g} mm they have no "
            f"room at any radius; give a lay_length_mm well above {count * d:.3g}."
        )
    if radius_mm is not None:
        if radius_mm < resting - OVERLAP * d:
            raise StudyError(
                f"{where} interpenetrates what lies below: its {what} of {d:.4g} mm touch {base:.4g} mm from a radius "
                f"of {resting:.4g} mm on, and radius_mm is {radius_mm:g}."
            )
        if radius_mm < least - OVERLAP * d:
            raise StudyError(
                f"the {count} {what} of {where} interpenetrate one another: at a lay length of {lay_length_mm:g} mm "
                f"they have room from a radius of {least:.4g} mm on, and radius_mm is {radius_mm:g}."
            )
    radius = max(resting, least) if radius_mm is None else max(radius_mm, least)
    gap = radius - resting
    if gap > ARCH * d:
        fitting = max((n for n in range(3, count) if least_radius_mm(d, lay_length_mm, n) <= resting), default=None)
        remedy = f"at most {fitting} fit" if fitting else "none fit at this lay length"
        if radius_mm is not None and radius_mm > least:
            remedy = f"give a radius_mm of {resting:.4g}, or none"
        raise StudyError(
            f"{where} cannot hold {count} {what} of {d:.4g} mm around {base:.4g} mm: they would lie {gap:.3g} mm off "
            f"what is below; {remedy}."
        )
    helix = Helix(radius, lay_length_mm, hand)
    if degrees(helix.angle_rad) > STEEPEST_deg:
        raise StudyError(
            f"{where} has a lay angle of {degrees(helix.angle_rad):.0f}°, where strand mechanics reaches "
            f"{STEEPEST_deg:g}°: give a lay_length_mm above {2.0 * pi * radius:.3g}."
        )
    touches = gap <= NEAR * d if radius_mm is not None and radius_mm > least else gap <= 1e-9 * d
    return Layer(count, member, helix, gap, touches)
