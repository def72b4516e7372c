"""Construction of a strand or rope: wires, layers of wires or strands, and how a tension is shared among them.

Hruska (Wire and Wire Products 26 (1951) 766): no rotation, no contraction of the radii. A member is a wire or strand of
a layer; a strand in a rope counts with its own stiffness, as a wire does. A layer arches if its members touch each
other and not the layer below. A right lay has the hand 1, a left one -1.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import cos, degrees, inf, pi, sin
from typing import NoReturn, TypeAlias

from geometry import Elastic
from wirewear.base.errors import StudyError
from wirewear.strand.helix import Hand, Helix, least_radius_mm, valley_radius_mm, valley_shares

NEAR = 0.02  #: A layer laid at a stated radius touches the one below if it is this near, in diameters.
STEEPEST_deg = 45.0


@dataclass(frozen=True)
class RopeWire:
    """A round wire of a rope; its yield stress is None where unknown, its material None if constants are stated."""

    diameter_mm: float
    elastic: Elastic
    material: str | None = None
    yield_stress_MPa: float | None = None

    @property
    def area_mm2(self) -> float:
        return 0.25 * pi * self.diameter_mm**2

    @property
    def stiffness_N(self) -> float:
        """Axial stiffness EA."""
        return self.elastic.youngs_modulus_MPa * self.area_mm2

    @property
    def bending_N_mm2(self) -> tuple[float, float]:
        """Bending stiffness EI twice, as the least and the largest one of a strand."""
        own = self.elastic.youngs_modulus_MPa * pi * self.diameter_mm**4 / 64.0
        return own, own

    def torque_N_mm(self, tension_N: float) -> float:
        """Torque by a tension: 0 for a straight wire."""
        return 0.0 * tension_N


@dataclass(frozen=True)
class Fibre:
    """A core of fibres, which fills the middle and carries no tension."""

    diameter_mm: float
    stiffness_N: float = 0.0
    bending_N_mm2: tuple[float, float] = (0.0, 0.0)

    def torque_N_mm(self, tension_N: float) -> float:
        """Torque by a tension: 0."""
        return 0.0 * tension_N


@dataclass(frozen=True)
class Layer:
    """`count` wires or strands on a common helix. gap_mm: distance to the layer or core below. presses: share of its
    radial load that it passes on: 1, less where its members lie in valleys of the layer below, 0 if it arches.
    """

    count: int
    member: "RopeWire | Strand"
    helix: Helix
    gap_mm: float
    presses: float
    in_valleys: bool = False

    @property
    def touches(self) -> bool:
        """True if the layer presses on what lies below, False if it arches."""
        return self.presses > 0.0


@dataclass(frozen=True)
class Strand:
    """A core (wire, fibre or strand) with layers around it, from the innermost to the outermost."""

    core: "RopeWire | Fibre | Strand"
    layers: tuple[Layer, ...]

    @property
    def diameter_mm(self) -> float:
        return outer_diameter_mm(self.core, self.layers)

    @cached_property
    def stiffness_N(self) -> float:
        """Axial stiffness Σ n EA cos³α of core and layers, with rotation prevented."""
        return self.core.stiffness_N + sum(
            own.count * own.member.stiffness_N * cos(own.helix.angle_rad) ** 3 for own in self.layers
        )

    @cached_property
    def bending_N_mm2(self) -> tuple[float, float]:
        """(least, largest): Σ n EI cos α with all members slipping, and ½ Σ n EA r² cos³α more with all sticking."""
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
        """Tension along one member of a layer under the strand's tension: EA ε cos²α at the strand's strain ε."""
        share = layer.member.stiffness_N * cos(layer.helix.angle_rad) ** 2 / self.stiffness_N
        return tension_N * share

    def torque_N_mm(self, tension_N: float) -> float:
        """Torque that prevents rotation under this tension: Σ n (T sin α r + M cos α), positive for a right lay."""
        total = self.core.torque_N_mm(self.core_tension_N(tension_N))
        for own in self.layers:
            tension, alpha = self.member_tension_N(own, tension_N), own.helix.angle_rad
            turning = own.helix.hand * tension * sin(alpha) * own.helix.radius_mm
            total += own.count * (turning + own.member.torque_N_mm(tension) * cos(alpha))
        return total


Member: TypeAlias = RopeWire | Fibre | Strand


def outer_diameter_mm(core: Member, layers: Sequence[Layer]) -> float:
    """Diameter over a core and the layers around it, of which there may be none."""
    if not layers:
        return core.diameter_mm
    return 2.0 * layers[-1].helix.radius_mm + layers[-1].member.diameter_mm


@dataclass(frozen=True)
class AskedLayer:
    """A layer as it is stated. below: the core and the layers that it lies on; radius_mm: of its helix, None to let it
    rest; where: its name in messages.
    """

    below: tuple[Member, Sequence[Layer]]
    count: int
    member: RopeWire | Strand
    lay_length_mm: float
    hand: Hand
    radius_mm: float | None
    where: str

    def laid(self) -> Layer:
        """The layer at its stated radius, or where it comes to rest: on what lies below, or arched over it.

        Raises StudyError, in one sentence, if its members do not fit.
        """
        resting, least, d = self._resting_mm, self._least_mm, self.member.diameter_mm
        stated = self.radius_mm
        if stated is not None:
            self._require_no_overlap(stated, resting, least)
        radius = max(resting, least) if stated is None else max(stated, least)
        gap = radius - resting
        # A layer whose neighbours touch farther off the one below, in diameters of its members, holds too many.
        if gap > 0.1 * d:
            self._refuse(gap, resting, stated_off=stated is not None and stated > least)
        helix = Helix(radius, self.lay_length_mm, self.hand)
        if degrees(helix.angle_rad) > STEEPEST_deg:
            raise StudyError(
                f"{self.where} has a lay angle of {degrees(helix.angle_rad):.0f}°, where strand mechanics reaches "
                f"{STEEPEST_deg:g}°: give a lay_length_mm above {2.0 * pi * radius:.3g}."
            )
        # What is stated is rounded; what comes to rest is not.
        touches = gap <= (NEAR if stated is not None and stated > least else 1e-9) * d
        if touches and (valleys := self._valleys) is not None:
            outer, inner = valley_shares(valleys.helix, helix, self.count)
            return Layer(self.count, self.member, helix, gap, inner / outer, in_valleys=True)
        return Layer(self.count, self.member, helix, gap, float(touches))

    @property
    def _what(self) -> str:
        kind = "strands" if isinstance(self.member, Strand) else "wires"
        return f"{kind} of {self.member.diameter_mm:.4g} mm"

    @property
    def _base_mm(self) -> float:
        return outer_diameter_mm(*self.below)

    @property
    def _valleys(self) -> Layer | None:
        """The layer below, if it has the same number and lay, so that members lie in its valleys; else None."""
        for beneath in self.below[1][-1:]:
            own, helix = (self.count, self.lay_length_mm, self.hand), beneath.helix
            if (beneath.count, helix.lay_length_mm, helix.hand) == own:
                return beneath
        return None

    @property
    def _resting_mm(self) -> float:
        """Radius at which the layer touches what lies below."""
        if (valleys := self._valleys) is None:
            return 0.5 * (self._base_mm + self.member.diameter_mm)
        found = valley_radius_mm(valleys.helix, valleys.member.diameter_mm, self.member.diameter_mm, self.count)
        if found <= valleys.helix.radius_mm:
            raise StudyError(
                f"the {self._what} of {self.where} would fall between those of the layer below, whose number and lay "
                "they have: give thicker ones."
            )
        return found

    @property
    def _least_mm(self) -> float:
        """Radius at which members of the layer touch one another."""
        found = least_radius_mm(self.member.diameter_mm, self.lay_length_mm, self.count)
        if found == inf:
            raise StudyError(
                f"{self.where} cannot hold {self.count} {self._what}: at a lay length of {self.lay_length_mm:g} mm "
                f"they have no room at any radius; give a lay_length_mm well above "
                f"{self.count * self.member.diameter_mm:.3g}."
            )
        return found

    def _require_no_overlap(self, stated: float, resting: float, least: float) -> None:
        # What members may overlap by rounding of what is stated, in diameters.
        allowed = 0.01 * self.member.diameter_mm
        if stated < resting - allowed:
            raise StudyError(
                f"{self.where} interpenetrates what lies below: its {self._what} touch {self._base_mm:.4g} mm from a "
                f"radius of {resting:.4g} mm on, and radius_mm is {stated:g}."
            )
        if stated < least - allowed:
            raise StudyError(
                f"the {self.count} {self._what} of {self.where} interpenetrate one another: at a lay length of "
                f"{self.lay_length_mm:g} mm they have room from a radius of {least:.4g} mm on, and radius_mm is "
                f"{stated:g}."
            )

    def _refuse(self, gap_mm: float, resting: float, *, stated_off: bool) -> NoReturn:
        numbers = (n for n in range(3, self.count) if self._fits(n, resting))
        fitting = max(numbers, default=None)
        remedy = f"at most {fitting} fit" if fitting else "none fit at this lay length"
        if stated_off:
            remedy = f"give a radius_mm of {resting:.4g}, or none"
        raise StudyError(
            f"{self.where} cannot hold {self.count} {self._what} around {self._base_mm:.4g} mm: they would lie "
            f"{gap_mm:.3g} mm off what is below; {remedy}."
        )

    def _fits(self, count: int, radius_mm: float) -> bool:
        return least_radius_mm(self.member.diameter_mm, self.lay_length_mm, count) <= radius_mm
