"""All kinds of contact in a bent strand or rope: angle, load and slip, and the stresses in its wires over a cycle.

A member is a wire or strand of a layer. A crown is where a wire of an outer strand comes nearest to, or farthest from,
the rope's axis. The extrados is the outer side of the bend. Slip is largest at the neutral axis and is given there.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import atan2, cos, hypot, inf, nan, pi, sin
from typing import Literal, cast

from geometry import Elastic
from wirewear.reference.hertz import gap_curvatures
from wirewear.strand.bending import BentLayer, MemberSlip, member_slips, relative_slip_mm
from wirewear.strand.construction import Fibre, RopeWire, Strand
from wirewear.strand.helix import DoubleHelix, between_deg, crossing_spacing_mm, radial_share, valley_shares

ContactSort = Literal["crossing", "line", "side by side", "crown", "sheave"]


@dataclass(frozen=True)
class Bend:
    """A cycle of bending: amplitude of curvature, whether it starts from a straight rope (pulsating), and friction.
    tension_share: amplitude of the tension over its mean, in step with the bending.
    """

    curvature_per_mm: float
    pulsating: bool
    friction: float
    tension_share: float = 0.0


@dataclass(frozen=True)
class LoadedWire:
    """A wire with its stresses along its axis in a cycle, at the extrados: means, and amplitudes.

    Bending stress is E d/D (Reuleaux). `axial_amplitude_MPa` includes the amplitude of the tension and the tension that
    friction adds in bending.
    """

    name: str
    wire: RopeWire
    tension_N: float
    axial_MPa: float
    axial_amplitude_MPa: float
    bending_MPa: float
    bending_amplitude_MPa: float

    @property
    def mean_MPa(self) -> float:
        return self.axial_MPa + self.bending_MPa

    @property
    def amplitude_MPa(self) -> float:
        return self.axial_amplitude_MPa + self.bending_amplitude_MPa


@dataclass(frozen=True)
class SheaveGroove:
    """Bottom of a sheave's groove: curvatures in 1/mm along the rope and, negative, across it."""

    elastic: Elastic
    curvatures_per_mm: tuple[float, float]


@dataclass(frozen=True)
class ContactSlip:
    """Slip amplitudes (along the strand's axis, around it) at a contact, without (free) and with friction (held); NaN
    if not computed. share: tangential force over its limit, Q/µP, 1 in gross slip.
    """

    free_mm: tuple[float, float] = (nan, nan)
    held_mm: tuple[float, float] = (nan, nan)
    share: float = nan


@dataclass(frozen=True)
class WireContact:
    """Contacts of one kind. load_N: of one contact, or of one millimetre of a line contact. lower_rad, upper_rad:
    angles of the wires to the axis of the strand or rope, positive for a right lay. spacing_mm: between two contacts
    along the upper wire, infinite for parallel wires. per_axial_mm: number of contacts, or mm of line contact, of all
    members per mm of the axis. upper_curvature_per_mm: of the upper wire's centre line towards the lower body, 0 but on
    a sheave.
    """

    name: str
    sort: ContactSort
    lower: LoadedWire | SheaveGroove
    upper: LoadedWire
    load_N: float
    lower_rad: float
    upper_rad: float
    spacing_mm: float
    per_axial_mm: float
    slip: ContactSlip
    is_line: bool = True
    upper_curvature_per_mm: float = 0.0

    @property
    def length_mm(self) -> float | None:
        return 1.0 if self.is_line else None

    @property
    def angle_deg(self) -> float:
        """Angle between both wires, 0 to 90°."""
        return between_deg(self.lower_rad, self.upper_rad)

    @property
    def slip_amplitude_mm(self) -> float:
        return hypot(*self.slip.held_mm)

    @property
    def free_slip_mm(self) -> float:
        return hypot(*self.slip.free_mm)

    @property
    def motion_rad(self) -> float:
        """Angle in rad from the strand's axis to the direction of the slip, −π to π; positive as a right lay's."""
        along, around = self.slip.free_mm
        return atan2(around, along)

    @property
    def along_across_mm(self) -> tuple[float, float]:
        """(along, across): slip amplitude in the directions of the lower wire."""
        turned = self.motion_rad - self.lower_rad
        return self.slip_amplitude_mm * cos(turned), self.slip_amplitude_mm * sin(turned)

    @property
    def wires(self) -> list[LoadedWire]:
        """The bodies in contact that are wires: (lower, upper), or the upper alone on a sheave."""
        return [own for own in (self.lower, self.upper) if isinstance(own, LoadedWire)]

    @property
    def elastic(self) -> tuple[Elastic, Elastic]:
        lower = self.lower if isinstance(self.lower, SheaveGroove) else self.lower.wire
        return lower.elastic, self.upper.wire.elastic

    @property
    def gap_per_mm(self) -> tuple[float, float]:
        """(A, B), A ≤ B: coefficients in 1/mm of the gap Ax² + By²; A = 0 for a line contact."""
        across = 2.0 / self.upper.wire.diameter_mm
        if isinstance(self.lower, SheaveGroove):
            below, angle = self.lower.curvatures_per_mm, self.upper_rad
        else:
            below, angle = (0.0, 2.0 / self.lower.wire.diameter_mm), self.upper_rad - self.lower_rad
        if self.is_line:
            return 0.0, 0.5 * (below[1] + across)
        small, large, _ = gap_curvatures(below, (self.upper_curvature_per_mm, across), angle)
        return small, large


def contacts_of(rope: Strand, tension_N: float, bend: Bend, groove: SheaveGroove | None = None) -> list[WireContact]:
    """All kinds of contact in a strand, or in a rope and its strands, from the innermost to the outermost.

    groove: of a sheave, None if the rope runs on none; its curvature along the rope is that of the bent rope.
    """
    found = list(_Bent(rope, tension_N, 0.0, 0.0, bend).contacts())
    if groove is not None:
        found.append(_on_sheave(rope, tension_N, bend, groove))
    return found


@dataclass(frozen=True)
class _Bent:
    """Strand with its tension, the tension that friction adds, and a radial load per millimetre of its axis."""

    strand: Strand
    tension_N: float
    gained_N: float
    outside_N_per_mm: float
    bend: Bend
    prefix: str = ""

    def contacts(self) -> Iterator[WireContact]:
        slips, loads = self.member_slips(), self.loads_N_per_mm()
        if isinstance(self.strand.core, Strand):
            yield from self.core_strand(self.strand.core).contacts()
        for place, layer in enumerate(self.strand.layers):
            if isinstance(layer.member, Strand):
                yield from self.of_member(place).contacts()
            if not layer.touches:
                yield self._side_by_side(place, slips[place], loads[place])
            elif place:
                yield self._crossing(place, slips, loads[place])
            elif isinstance(layer.member, Strand):
                yield from self._crowns(slips[0], loads[0])
            else:
                yield self._on_core(slips[0], loads[0])

    def member_slips(self) -> list[MemberSlip]:
        layers = [
            BentLayer(own.helix, own.count, self.strand.member_tension_N(own, self.tension_N), own.member.stiffness_N)
            for own in self.strand.layers
        ]
        presses = [own.presses for own in self.strand.layers]
        return member_slips(layers, self.bend.friction, self.outside_N_per_mm, presses)

    def loads_N_per_mm(self) -> list[float]:
        """Radial load of each layer on the layer or core below, of all its members per mm of the axis."""
        found: list[float] = []
        above = self.outside_N_per_mm
        for own in reversed(self.strand.layers):
            tension = self.strand.member_tension_N(own, self.tension_N)
            total = above + own.count * tension * own.helix.curvature_per_mm / cos(own.helix.angle_rad)
            found.append(total)
            above = own.presses * total
        return found[::-1]

    def core_strand(self, core: Strand) -> "_Bent":
        """Core strand of a rope under its share of tension and the load of the strands around it."""
        share = self.strand.core_tension_N(1.0)
        outside = self.loads_N_per_mm()[0] if self.strand.layers[0].touches else 0.0
        return _Bent(core, share * self.tension_N, share * self.gained_N, outside, self.bend, "core strand: ")

    def of_member(self, place: int) -> "_Bent":
        """One strand of the layer with this index under its share of tension."""
        member = cast("Strand", self.strand.layers[place].member)
        return _Bent(member, *self._tensions(place), 0.0, self.bend, "outer strands: ")

    def wire(self, place: int) -> LoadedWire:
        """One wire of the layer with this index, with its stresses."""
        member = cast("RopeWire", self.strand.layers[place].member)
        return self._loaded(f"layer {place + 1}", member, *self._tensions(place))

    def core_wire(self) -> LoadedWire:
        core, share = cast("RopeWire", self.strand.core), self.strand.core_tension_N(1.0)
        return self._loaded("core", core, share * self.tension_N, share * self.gained_N)

    def _tensions(self, place: int) -> tuple[float, float]:
        """Mean tension of one member of the layer with this index, and the tension that friction adds at the extrados,
        in N.
        """
        share = self.strand.member_tension_N(self.strand.layers[place], 1.0)
        own = self.member_slips()[place].gained_N(self.bend.curvature_per_mm)
        return share * self.tension_N, share * self.gained_N + own

    def _loaded(self, name: str, wire: RopeWire, tension_N: float, gained_N: float) -> LoadedWire:
        axial, gained = tension_N / wire.area_mm2, gained_N / wire.area_mm2
        bending = 0.5 * wire.elastic.youngs_modulus_MPa * wire.diameter_mm * self.bend.curvature_per_mm
        mean = 1.0 if self.bend.pulsating else 0.0
        return LoadedWire(
            f"{self.prefix}{name}", wire, tension_N, axial + mean * gained, self.bend.tension_share * axial + gained,
            mean * bending, bending,
        )  # fmt: skip

    def _slip(self, outer: MemberSlip, inner: MemberSlip | None = None, times: float = 1.0) -> ContactSlip:
        """Slip between an outer and an inner member at the neutral axis; inner is None for a core that does
        not slide.
        """
        curvature = self.bend.curvature_per_mm
        slips = [outer] if inner is None else [outer, inner]
        below = None if inner is None else inner.helix
        free = [times * own.helix.free_slip_mm(curvature) for own in slips]
        held = [times * own.slip_mm(curvature) for own in slips]
        return ContactSlip(
            relative_slip_mm(outer.helix, free[0], below, free[-1]),
            relative_slip_mm(outer.helix, held[0], below, held[-1]),
            curvature / max(curvature, min(own.first_per_mm for own in slips)),
        )

    def _on_core(self, own: MemberSlip, load_N_per_mm: float) -> WireContact:
        helix, count = own.helix, self.strand.layers[0].count
        along = cos(helix.angle_rad)
        return WireContact(
            name=f"{self.prefix}layer 1 on core",
            sort="line",
            lower=self.core_wire(),
            upper=self.wire(0),
            load_N=load_N_per_mm * along / count,
            lower_rad=helix.signed_angle_rad,
            upper_rad=helix.signed_angle_rad,
            spacing_mm=inf,
            per_axial_mm=count / along,
            slip=self._slip(own),
        )

    def _side_by_side(self, place: int, own: MemberSlip, load_N_per_mm: float) -> WireContact:
        """Contacts between neighbours in an arching layer, which slide most at the extrados and the intrados."""
        layer, helix = self.strand.layers[place], own.helix
        along, turned, spacing = cos(helix.angle_rad), 0.0, inf
        if isinstance(layer.member, Strand):
            inner, last = self.of_member(place), layer.member.layers[-1]
            double = DoubleHelix(helix, last.helix)
            turned, spacing = atan2(double.twist, 1.0), double.crown_spacing_mm(last.count)
            name, wire = "outer strands", inner.wire(len(layer.member.layers) - 1)
        else:
            name, wire = f"layer {place + 1}", self.wire(place)
        return _points_or_line(
            WireContact(
                name=f"{self.prefix}{name} side by side",
                sort="side by side",
                lower=wire,
                upper=wire,
                load_N=0.5 * load_N_per_mm * along / layer.count / radial_share(helix, layer.count),
                lower_rad=helix.signed_angle_rad - turned,
                upper_rad=helix.signed_angle_rad + turned,
                spacing_mm=spacing,
                per_axial_mm=layer.count / along,
                slip=self._slip(own, times=2.0 * sin(pi / layer.count)),
            )
        )

    def _crossing(self, place: int, slips: Sequence[MemberSlip], load_N_per_mm: float) -> WireContact:
        inner, outer = self.strand.layers[place - 1 : place + 1]
        found = WireContact(
            name=f"{self.prefix}layer {place + 1} on layer {place}",
            sort="crossing",
            lower=self.wire(place - 1),
            upper=self.wire(place),
            load_N=load_N_per_mm / outer.count,
            lower_rad=inner.helix.signed_angle_rad,
            upper_rad=outer.helix.signed_angle_rad,
            spacing_mm=crossing_spacing_mm(inner.helix, inner.count, outer.helix),
            per_axial_mm=outer.count,
            slip=self._slip(slips[place], slips[place - 1]),
        )
        if not outer.in_valleys:
            return _points_or_line(found)
        # Each outer wire lies along two of the layer below.
        share, _ = valley_shares(inner.helix, outer.helix, outer.count)
        along = cos(outer.helix.angle_rad)
        return replace(
            found, sort="line", load_N=0.5 * found.load_N * along / share, per_axial_mm=2.0 * outer.count / along
        )

    def _crowns(self, own: MemberSlip, load_N_per_mm: float) -> Iterator[WireContact]:
        """Contacts of wires of the outer strands with a core strand or core wire; none on a core of fibres.

        own: slip of an outer strand. load_N_per_mm: on the core, by all outer strands.
        """
        ring, core = self.strand.layers[0], self.strand.core
        if isinstance(core, Fibre) or not isinstance(ring.member, Strand):
            return
        last, along = ring.member.layers[-1], cos(ring.helix.angle_rad)
        double = DoubleHelix(ring.helix, last.helix)
        below, lower = None, None
        if isinstance(core, Strand):
            beneath = self.core_strand(core)
            below, lower = beneath.member_slips()[-1], beneath.wire(len(core.layers) - 1)
        yield _points_or_line(
            WireContact(
                name="outer strands on core strand" if below else "outer strands on core",
                sort="crown",
                lower=lower or self.core_wire(),
                upper=self.of_member(0).wire(len(ring.member.layers) - 1),
                load_N=load_N_per_mm * along / ring.count,
                lower_rad=below.helix.signed_angle_rad if below else 0.0,
                upper_rad=double.innermost_rad,
                spacing_mm=double.crown_spacing_mm(last.count),
                per_axial_mm=ring.count / along,
                slip=self._slip(own, below),
            )
        )


def _points_or_line(contact: WireContact) -> WireContact:
    """Separate contact points where wires cross; the line contact unchanged if they cross at less than 5°."""
    # Wires that cross at less lie along each other; no study crosses them either.
    if contact.angle_deg < 5.0:
        return contact
    spacing = contact.spacing_mm
    return replace(contact, load_N=contact.load_N * spacing, per_axial_mm=contact.per_axial_mm / spacing, is_line=False)


def _on_sheave(rope: Strand, tension_N: float, bend: Bend, groove: SheaveGroove) -> WireContact:
    """Contacts of the outermost wires with a groove that carries T/ρ; their slip is not computed.

    Estimates: a wire of a strand touches the groove once a lay, and one strand of a rope carries the load at a time.
    """
    last = rope.layers[-1]
    line_load = tension_N * groove.curvatures_per_mm[0]
    state = _Bent(rope, tension_N, 0.0, 0.0, bend)
    place = len(rope.layers) - 1
    if isinstance(last.member, Strand):
        wires = last.member.layers[-1]
        double = DoubleHelix(last.helix, wires.helix)
        spacing = double.crown_spacing_mm(wires.count) * cos(last.helix.angle_rad)
        angle, curvature = double.outermost_rad, double.crown_curvature_per_mm
        name, upper = "outer strands", state.of_member(place).wire(len(last.member.layers) - 1)
    else:
        spacing = last.helix.lay_length_mm / last.count
        angle, curvature, upper = last.helix.signed_angle_rad, last.helix.curvature_per_mm, state.wire(place)
        name = f"layer {place + 1}"
    return WireContact(
        name=f"{name} on sheave",
        sort="sheave",
        lower=groove,
        upper=upper,
        load_N=line_load * spacing,
        lower_rad=0.0,
        upper_rad=angle,
        spacing_mm=spacing,
        per_axial_mm=1.0 / spacing,
        slip=ContactSlip(),
        is_line=False,
        upper_curvature_per_mm=curvature,
    )
