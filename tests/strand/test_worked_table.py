"""Loads, slips and pressures inside strands and ropes, against figures worked out from formulas and by other means."""

from functools import partial
from math import cos, degrees, pi, radians, sqrt, tan
from typing import Any

import numpy as np
import pytest

from geometry import Elastic
from geometry.arrays import Array
from tests.strand.ropes import conductor, nineteen_wires, rope, seven_wires, strands_of_seven
from wirewear import strand_contacts
from wirewear.strand.bending import BentLayer, MemberSlip, member_slips
from wirewear.strand.construction import Layer, RopeWire, Strand
from wirewear.strand.contacts import Bend, contacts_of
from wirewear.strand.estimates import ContactEstimate, estimated
from wirewear.strand.helix import DoubleHelix, Helix, least_radius_mm, radial_share
from wirewear.strand.rope_contacts import RopeContacts

near = partial(pytest.approx, rel=0.005)


def only(found: RopeContacts, name: str) -> ContactEstimate:
    return next(one for one in found.contacts if one.contact.name == name)


@pytest.mark.parametrize(
    ("core_mm", "lay_mm", "figures"),
    [
        # Lay angle, curvature, tension of a wire and of the core, load, p0, slip, torque, stiffness.
        (3.12, 60, (17.495, 0.030025, 2859.2, 3638.3, 85.85, 1999, (54.83, 13.71), (53.59, 12.47), 15.52, 8.405)),
        (3.0, 90, (11.637, 0.013793, 2860.3, 3190.8, 39.45, 1368, (82.77, 20.69), (81.57, 19.49), 10.21, 8.861)),
    ],
)
def test_a_strand_of_seven_wires_has_the_loads_and_slips_of_strand_mechanics(
    core_mm: float, lay_mm: float, figures: tuple[Any, ...]
) -> None:
    angle, curvature, wire, core, load, peak, free, held, torque, stiffness = figures
    for k, radius in enumerate((500.0, 2000.0)):
        tables = seven_wires(core_mm, lay_mm)
        tables["conditions"]["bending_radius_mm"] = radius
        found = strand_contacts(tables)
        (one,) = found.contacts
        helix = found.rope.layers[0].helix
        assert (degrees(helix.angle_rad), helix.curvature_per_mm) == near((angle, curvature))
        assert one.contact.upper.tension_N == near(wire)
        assert found.rope.core_tension_N(20_000.0) == near(core)
        assert (one.contact.load_N, one.peak_pressure_MPa) == near((load, peak))
        assert 1e3 * one.contact.free_slip_mm == near(free[k])
        assert 1e3 * one.contact.slip_amplitude_mm == near(held[k])
        assert 1e-3 * found.figures["torque_N_mm"] == near(torque)
        assert 1e-6 * found.figures["axial_stiffness_N"] == near(stiffness)
        assert one.contact.upper.bending_amplitude_MPa == near(580.0 * 500.0 / radius)


def full_per_mm(slip: MemberSlip) -> float:
    """Curvature from which the whole member slips: its tension grows no further."""
    return float(slip.gain_N[-1]) / (slip.gained_N(1e-9) / 1e-9)


@pytest.mark.parametrize(
    ("radius_mm", "lay_mm", "tension_N", "first_m", "full_m"),
    [(2.95, 60, 2896.5, 27.7, 17.1), (3.01, 60, 2859.2, 28.1, 17.2), (2.95, 90, 2860.3, 43.2, 26.9)],
)
def test_wires_begin_to_slip_and_slip_throughout_at_the_radii_of_papailiou(
    radius_mm: float, lay_mm: float, tension_N: float, first_m: float, full_m: float
) -> None:
    layer = BentLayer(Helix(radius_mm, lay_mm, 1), 6, tension_N, 200_000.0 * pi * 2.9**2 / 4.0)
    (slip,) = member_slips([layer], 0.15, 0.0, [True])
    assert (1e-3 / slip.first_per_mm, 1e-3 / full_per_mm(slip)) == near((first_m, full_m))
    assert slip.slip_mm(0.999 * slip.first_per_mm) == 0.0
    # Slip sets in, and goes over into that of a wire that slips throughout, without a step.
    curvatures = np.linspace(0.9 * slip.first_per_mm, 1.2 * full_per_mm(slip), 60)
    slips = [slip.slip_mm(one) for one in curvatures]
    assert np.all(np.diff(slips) >= 0.0)
    assert np.diff(slips).max() < 0.05 * slips[-1]


def test_formulas_alone_give_the_figures_of_a_layer_that_would_not_have_room() -> None:
    wire = RopeWire(2.9, Elastic(200_000.0, 0.3))
    strand = Strand(RopeWire(3.0, wire.elastic), (Layer(6, wire, Helix(2.95, 60.0, 1), 0.0, 1.0),))
    (contact,) = contacts_of(strand, 20_000.0, Bend(1.0 / 500.0, pulsating=False, friction=0.15))
    assert 1e-6 * strand.stiffness_N == near(8.327)
    assert (contact.upper.tension_N, strand.core_tension_N(20_000.0)) == near((2896.5, 3395.5))
    assert 1e-3 * strand.torque_N_mm(20_000.0) == near(15.13)
    assert (contact.upper.axial_MPa, contact.load_N) == near((438.5, 85.54))
    assert estimated(contact, 0.15, 0.0, 1, None).peak_pressure_MPa == near(2014.0)
    assert (1e3 * contact.free_slip_mm, 1e3 * contact.slip_amplitude_mm) == near((53.83, 52.61))


def test_a_layer_that_has_no_room_arches_and_its_wires_press_on_one_another() -> None:
    found = strand_contacts(seven_wires(3.0, 60))
    layer = found.rope.layers[0]
    assert (layer.helix.radius_mm, layer.gap_mm) == near((3.0084, 0.0584))
    (one,) = found.contacts
    assert one.contact.sort == "side by side"
    assert (one.contact.load_N, one.peak_pressure_MPa) == near((97.3, 2166))
    assert any("arches" in note for note in found.notes)


def test_the_core_is_touched_from_a_lay_or_from_a_core_on() -> None:
    assert strand_contacts(seven_wires(3.0, 86.8)).rope.layers[0].touches
    assert not strand_contacts(seven_wires(3.0, 86.2)).rope.layers[0].touches
    assert strand_contacts(seven_wires(3.119, 60)).rope.layers[0].touches
    assert not strand_contacts(seven_wires(3.115, 60)).rope.layers[0].touches


@pytest.mark.parametrize(("lay_mm", "count", "diameter_mm"), [(60, 6, 2.9), (130, 12, 2.9), (40, 6, 2.9)])
def test_neighbours_touch_where_their_centre_lines_come_closest(lay_mm: float, count: int, diameter_mm: float) -> None:
    radius = least_radius_mm(diameter_mm, lay_mm, count)
    z = np.linspace(-0.5, 0.5, 400_001) * lay_mm
    turned = 2.0 * pi * (z / lay_mm + 1.0 / count)
    way = np.stack([radius * np.cos(turned) - radius, radius * np.sin(turned), z])
    apart = np.linalg.norm(way, axis=0)
    assert apart.min() == pytest.approx(diameter_mm, rel=1e-6)
    nearest = way[:, apart.argmin()] / apart.min()
    assert radial_share(Helix(radius, lay_mm, 1), count) == pytest.approx(abs(nearest[0]), rel=1e-3)
    angle = Helix(radius, lay_mm, 1).angle_rad
    costello = 0.5 * diameter_mm * sqrt(1.0 + (tan(0.5 * pi - pi / count) / cos(angle)) ** 2)
    assert costello < radius < 1.02 * costello


@pytest.mark.parametrize(
    ("outer_lay", "angle", "spacing", "load_N", "slip_um", "torque"),
    [("left", 31.21, 7.583, 271.7, 294.0, -40.1), ("right", 0.877, 25.28, 905.6, 172.0, 65.8)],
)
def test_layers_cross_at_points_whose_load_follows_from_the_spacing(
    outer_lay: str, angle: float, spacing: float, load_N: float, slip_um: float, torque: float
) -> None:
    found = strand_contacts(nineteen_wires(outer_lay))
    contact = only(found, "layer 2 on layer 1").contact
    assert (contact.angle_deg, contact.spacing_mm) == near((angle, spacing))
    assert contact.load_N * (spacing if contact.is_line else 1.0) == near(load_N)
    assert contact.is_line == (outer_lay == "right")
    assert 1e3 * contact.free_slip_mm == near(slip_um)
    assert 1e-3 * found.figures["torque_N_mm"] == near(torque)
    assert contact.upper.tension_N == near(2682.0)
    assert found.rope.member_tension_N(found.rope.layers[0], 50_000.0) == near(2705.0)


def test_a_conductor_shares_its_tension_and_crosses_as_worked_out() -> None:
    found = strand_contacts(conductor())
    outer, inner = only(found, "layer 3 on layer 2"), only(found, "layer 2 on layer 1")
    assert outer.contact.angle_deg == near(24.149)
    assert inner.contact.angle_deg == near(16.327)
    assert (outer.contact.spacing_mm, inner.contact.spacing_mm) == near((10.849, 15.173))
    assert (outer.contact.load_N, inner.contact.load_N) == near((37.25, 135.1))
    assert 1e3 * outer.contact.free_slip_mm == near(1038.0)
    assert 1e3 * np.abs(outer.contact.slip.free_mm) == near((1033.0, 99.0))
    assert 1e3 * inner.contact.free_slip_mm == near(500.0)
    tensions = [found.rope.member_tension_N(layer, 22_000.0) for layer in found.rope.layers]
    assert [found.rope.core_tension_N(22_000.0), *tensions] == near([1086.0, 1075.0, 579.0, 566.2])
    assert outer.contact.upper.axial_MPa == near(58.9)
    figures = found.figures
    assert 1e-6 * figures["axial_stiffness_N"] == near(24.37)
    bending = figures["least_bending_stiffness_N_mm2"], figures["largest_bending_stiffness_N_mm2"]
    assert 1e-6 * np.array(bending) == near((16.8, 574.9))
    assert 1e3 * only(strand_contacts(conductor(2000.0)), "layer 3 on layer 2").contact.free_slip_mm == near(259.5)


def test_a_contact_far_beyond_yield_says_so_with_its_plastic_area() -> None:
    found = strand_contacts(conductor())
    one = only(found, "layer 3 on layer 2")
    assert (one.peak_pressure_MPa, one.major_mm, one.minor_mm) == near((1041.0, 0.354, 0.0483))
    # First yield at 0.89 N: the peak pressure grows with the cube root of the load.
    assert one.contact.load_N / one.yield_ratio**3 == pytest.approx(0.89, rel=0.01)
    assert one.plastic_area_mm2 == pytest.approx(0.078, rel=0.01)
    assert any(note.startswith("layer 3 on layer 2: far beyond yield") for note in found.notes)


def test_inner_layers_of_a_conductor_are_held_by_what_presses_on_them() -> None:
    """Within 1.5 % of strdcable, whose layers are full of wires, as n ∝ r/d; here all forces balance (54.9 N/mm)."""
    found = strand_contacts(conductor())
    layers = [
        BentLayer(
            own.helix, own.count, found.rope.member_tension_N(own, 22_000.0), own.member.stiffness_N
        )
        for own in found.rope.layers
    ]  # fmt: skip
    slips = member_slips(layers, 0.5, 0.0, [True] * 3)
    *inner, first, full = (1e-3 / one for own in slips for one in (own.first_per_mm, full_per_mm(own)))
    assert (first, full) == near((88.0, 51.0))
    assert inner == pytest.approx([7.2, 3.8, 16.8, 9.3], rel=0.015)


@pytest.mark.parametrize(
    ("wire_lay", "core_lay", "outermost", "innermost", "against_core"),
    [
        ("left", "left", 4.30, 25.71, 40.5),
        ("left", "right", 4.30, 25.71, 11.0),
        ("right", "left", 33.72, -4.91, 9.85),
        ("right", "right", 33.72, -4.91, 19.7),
    ],
)
def test_wires_of_a_rope_of_strands_cross_those_of_the_core_strand_at_crowns(
    wire_lay: str, core_lay: str, outermost: float, innermost: float, against_core: float
) -> None:
    sheave = {"groove_radius_mm": 5.2, "youngs_modulus_MPa": 200_000.0, "poissons_ratio": 0.3}
    found = strand_contacts(strands_of_seven(wire_lay, core_lay, sheave=sheave))
    crown = only(found, "outer strands on core strand").contact
    assert degrees(crown.upper_rad) == near(innermost)
    assert crown.angle_deg == near(against_core)
    # Strands press on the core with 29.5 N/mm; six wires come to it in a lay.
    assert (crown.spacing_mm, crown.load_N) == near((24 / 6, 29.5 * 24 / 6))
    on_sheave = only(found, "outer strands on sheave").contact
    assert degrees(on_sheave.upper_rad) == near(outermost)
    assert on_sheave.load_N / on_sheave.spacing_mm == near(20.0)
    ring = found.rope.layers[0]
    assert found.rope.member_tension_N(ring, 10_000.0) == near(1427.0)
    assert crown.upper.tension_N == near(203.9)
    assert crown.upper.axial_MPa == near(260.0)
    inside = only(found, "outer strands: layer 1 on core").contact
    assert inside.load_N == near(13.4)
    assert 1e3 * inside.free_slip_mm == near(7.6)
    assert 1e3 * ring.helix.free_slip_mm(1.0 / 500.0) == near(72.7)
    assert inside.upper.bending_amplitude_MPa == near(200.0)


def test_the_angles_of_a_double_helix_are_those_of_its_tangents() -> None:
    found = strand_contacts(strands_of_seven("left"))
    ring = found.rope.layers[0]
    assert isinstance(ring.member, Strand)
    strand, wire = ring.helix, ring.member.layers[0].helix

    def place(t: float) -> Array:
        """A wire that begins outermost, in the frame that turns with its strand's path of arc length t."""
        beta = strand.angle_rad
        at = strand.hand * t * np.sin(beta) / strand.radius_mm
        centre = np.array([strand.radius_mm * np.cos(at), strand.radius_mm * np.sin(at), t * np.cos(beta)])
        outward = np.array([np.cos(at), np.sin(at), 0.0])
        along = np.array(
            [-strand.hand * np.sin(beta) * np.sin(at), strand.hand * np.sin(beta) * np.cos(at), np.cos(beta)]
        )
        turned = 2.0 * pi * wire.hand * t / wire.lay_length_mm
        offset = np.cos(turned) * outward + np.sin(turned) * np.cross(along, outward)
        return np.asarray(centre + wire.radius_mm * offset)

    h = 1e-4
    tangent, bend = (place(h) - place(-h)) / (2.0 * h), (place(h) - 2.0 * place(0.0) + place(-h)) / h**2
    double = DoubleHelix(strand, wire)
    assert np.arctan2(tangent[1], tangent[2]) == pytest.approx(double.outermost_rad, abs=radians(0.05))
    assert -bend[0] / (tangent @ tangent) == pytest.approx(double.crown_curvature_per_mm, rel=0.02)
    # One of six wires comes nearest to the rope's axis wherever one has gone on by a sixth of its lay: that axis turns
    # with the strand's frame. Counted against a frame that does not turn it would be every 5.71 mm.
    t = np.linspace(0.0, 24.0, 2401)
    reach = [np.hypot(*place(one)[:2]) for one in t]
    assert t[int(np.argmin(reach))] == pytest.approx(12.0, abs=0.05)
    assert double.crown_spacing_mm(6) == 24.0 / 6


def test_a_layer_of_as_many_wires_and_the_same_lay_lies_in_the_valleys_of_the_one_below() -> None:
    """Seale's construction: each outer wire touches two, and presses them apart."""
    layers = [{"wires": 9, "wire_diameter_mm": d, "lay_length_mm": 75} for d in (1.1, 1.9)]
    found = strand_contacts(rope(10_000.0, core={"wire_diameter_mm": 2.2}, layers=layers))
    inner, outer = (layer.helix for layer in found.rope.layers)
    z = np.linspace(-5.0, 5.0, 40_001)
    turned = 2.0 * pi * z / 75.0 + pi / 9.0
    way = np.stack([inner.radius_mm * np.cos(turned) - outer.radius_mm, inner.radius_mm * np.sin(turned), z])
    apart = np.linalg.norm(way, axis=0)
    assert apart.min() == pytest.approx(1.5, rel=1e-6)
    pointing = -way[0, apart.argmin()] / apart.min()
    tension = found.rope.member_tension_N(found.rope.layers[1], 10_000.0)
    one = only(found, "layer 2 on layer 1").contact
    assert one.is_line
    assert 2.0 * one.load_N * pointing == pytest.approx(tension * outer.curvature_per_mm, rel=1e-3)
    # What it leaves in wedging wires apart does not reach the core.
    core = only(found, "layer 1 on core").contact
    own = found.rope.member_tension_N(found.rope.layers[0], 10_000.0) * inner.curvature_per_mm
    assert own + 0.8 * tension * outer.curvature_per_mm < core.load_N < own + 0.84 * tension * outer.curvature_per_mm
