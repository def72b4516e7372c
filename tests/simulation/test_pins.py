"""A pin in a bore, a shaft in a hub: what studies say of them, their meshes, closed forms, and runs."""

from math import asin, pi
from typing import Any

import numpy as np
import pytest

from geometry import Arc, GeometryError, GradedAxis, RingGeometry, build_planar, mirror_images
from tests.studies import line_study
from wirewear import reference
from wirewear.base.errors import RecordError, StudyError
from wirewear.records.exporting import profile_surfaces, record_of_result
from wirewear.results.health import limit_of, remedies
from wirewear.simulation import simulate
from wirewear.simulation.line_model import line_plan
from wirewear.test import LineStudy


def pin_study(**changes: Any) -> LineStudy:
    """A pin that slides in a wide bore."""
    return line_study(**({"kind": "line-contact", "specimen": {"bore_radius_mm": 6.1}, "mesh": None} | changes))


@pytest.mark.parametrize("radius_mm", [6.0, -6.1])
def test_a_ring_is_whole_symmetric_and_round_where_it_touches(radius_mm: float) -> None:
    ring = build_planar(RingGeometry(radius_mm, 5.0, GradedAxis(0.1, 4.0, 0.5, 8.0)))
    area = pi * abs(radius_mm**2 - (radius_mm - 5.0) ** 2)
    assert ring.mesh.area_mm2() == pytest.approx(area, rel=5e-3)
    assert ring.quality > 0.9
    assert mirror_images(ring.mesh, 0) is not None
    touching = ring.mesh.points[ring.patch.nodes[:, 0]]
    assert np.hypot(touching[:, 0], touching[:, 1] + radius_mm) == pytest.approx(abs(radius_mm))
    assert touching[-1, 0] == pytest.approx(abs(radius_mm) * np.sin(8.0 / abs(radius_mm)))
    held = ring.mesh.points[ring.mesh.surface_nodes("grip")]
    assert np.hypot(held[:, 0], held[:, 1] + radius_mm) == pytest.approx(abs(radius_mm - 5.0))


def test_a_worn_ring_loses_what_is_worn_below_the_contact_alone() -> None:
    ring = build_planar(RingGeometry(-6.1, 5.0, GradedAxis(0.1, 4.0, 0.5, 8.0)))
    x = ring.patch.axial_mm
    depth = 0.02 * np.maximum(1.0 - (x / 3.0) ** 2, 0.0)
    worn = ring.worn(depth)
    assert ring.mesh.area_mm2() - worn.mesh.area_mm2() == pytest.approx(np.trapezoid(depth, x), rel=1e-3)
    above = ring.mesh.points[:, 1] > 6.1
    assert np.array_equal(worn.mesh.points[above], ring.mesh.points[above])


@pytest.mark.parametrize(("radius_mm", "height_mm", "reach_mm"), [(6.0, 6.5, 5.0), (6.0, 5.0, 9.5), (-6.0, 0.01, 5.0)])
def test_a_ring_that_cannot_be_meshed_is_refused(radius_mm: float, height_mm: float, reach_mm: float) -> None:
    with pytest.raises(GeometryError):
        RingGeometry(radius_mm, height_mm, GradedAxis(0.1, 4.0, 0.5, reach_mm))


def test_the_pressure_of_a_pin_bears_its_load_and_is_hertzs_in_a_wide_bore() -> None:
    pin = reference.pin_in_bore(800.0, 6.0, 6.01, 1e5)
    angles = np.linspace(-pin.half_angle_rad, pin.half_angle_rad, 40_001)
    assert np.trapezoid(6.0 * pin.pressure(angles) * np.cos(angles), angles) == pytest.approx(800.0, rel=1e-4)
    narrow, hertz = reference.pin_in_bore(1e-3, 6.0, 6.001, 1e5), reference.hertz_line(1e-3, 36_006.0, 1e5)
    assert 6.0 * narrow.half_angle_rad == pytest.approx(hertz.half_width_mm, rel=1e-3)
    assert float(narrow.pressure(0.0)) == pytest.approx(hertz.peak_pressure_MPa, rel=1e-3)
    with pytest.raises(ValueError, match="clearance_mm must be positive"):
        reference.pin_in_bore(1.0, 6.0, 6.0, 1e5)


@pytest.mark.parametrize("area_mm2", [1e-9, 1e-3, 0.5])
def test_the_scar_of_a_pin_has_the_area_between_both_arcs(area_mm2: float) -> None:
    scar = reference.pin_scar(area_mm2, 6.0, 6.1)
    angle = scar.half_width_mm / 6.0
    angles = np.linspace(-angle, angle, 20_001)
    sunk = 0.1 / np.cos(angle) - 0.1
    assert scar.depth_mm == pytest.approx(sunk, rel=1e-6)
    overlap = (0.1 + sunk) * np.cos(angles) - 0.1
    assert np.trapezoid(6.0 * overlap, angles) == pytest.approx(area_mm2, rel=1e-4)


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"specimen": {"bore_radius_mm": 6.0}}, r"bore_radius_mm in \[specimen\] .* larger than the pin's radius_mm"),
        ({"pad": {"radius_mm": None, "face_half_width_mm": 0.6, "edge_radius_mm": 1.0}}, "needs a round pad"),
        ({"pad": {"half_width_mm": 3.0}}, r"half_width_mm in \[pad\] .* a pin and a plate with a bore have none"),
        ({"kind": "cylinder-on-flat"}, "a bore is no flat"),
    ],
)
def test_what_does_not_go_with_a_bore_is_one_sentence(changes: dict[str, Any], complaint: str) -> None:
    with pytest.raises(StudyError, match=complaint):
        pin_study(**changes)


@pytest.mark.parametrize(("bore_mm", "friction"), [(6.01, 0.1), (6.0125, 0.6)])
def test_a_pin_that_would_wedge_itself_is_refused_before_the_run(bore_mm: float, friction: float) -> None:
    with pytest.raises(StudyError, match="wedges itself"):
        line_plan(pin_study(specimen={"bore_radius_mm": bore_mm}, contact={"friction": friction}), "quick")


def test_patches_reach_as_far_as_the_pin_climbs() -> None:
    plan = line_plan(pin_study(specimen={"bore_radius_mm": 6.02}, wear=None), "quick")
    climbed = 6.0 * asin(12.0 / 20.0)
    assert plan.pad.along.half_extent_mm > climbed + plan.hertz.half_width_mm
    assert 6.02 * np.sin(plan.specimen.along.half_extent_mm / 6.02) == pytest.approx(
        6.0 * np.sin(plan.pad.along.half_extent_mm / 6.0) + 0.012
    )


@pytest.mark.seconds
def test_a_pin_wears_its_bore_without_any_error_of_the_program() -> None:
    result = simulate(pin_study(conditions={"cycles": 20}, log={"loop_cycles": [1, 20]}), fidelity="quick")
    assert result.status == "complete"
    assert remedies([name for name, value in result.quality.items() if value > limit_of(name)]) == []
    pad, bore = (result.scar(20, body) for body in ("pad", "specimen"))
    assert pad.volume_mm3 / bore.volume_mm3 == pytest.approx(2.0, rel=1e-6)
    heights = profile_surfaces(result, 0.0, 0)["profile_specimen"]()
    x = 1e-3 * heights["x_um"]
    assert heights["height_um"][[0, -1]] == pytest.approx(1e3 * Arc(-6.1).height(np.column_stack([x, x]))[[0, -1]])
    with pytest.raises(RecordError, match="of a pin in a bore, which records do not state"):
        record_of_result(result, 10.0)


def shaft_study(**changes: Any) -> LineStudy:
    """A shaft of 10 mm in a hub of twice its radius, on a coarse mesh."""
    tables: dict[str, Any] = {
        "kind": "line-contact",
        "pad": {"radius_mm": None, "face_half_width_mm": 10.0, "edge_radius_mm": 1.0, "height_mm": 10.0},
        "specimen": {"shaft_radius_mm": 10.0, "interference_um": 5.0, "taper": 0.05},
        "conditions": {"normal_load_N_per_mm": 800.0, "displacement_amplitude_um": 20.0, "cycles": 1},
        "contact": {"friction": 0.1, "length_mm": 20.0 * pi},
        "mesh": {"contact_mesh_um": 100.0, "increments_per_cycle": 16},
        "wear": None,
        "log": {"loop_cycles": [1]},
    }
    return line_study(**(tables | {key: tables.get(key, {}) | value for key, value in changes.items()}))


@pytest.mark.seconds
def test_a_taper_slides_as_its_statics_say_under_the_pressure_of_lame() -> None:
    result = simulate(shaft_study(), fidelity="quick")
    loop, scar = result.loops[0], result.scar(1, "pad")
    share = loop.tangential_force_N / loop.normal_force_N
    taper, friction = 0.05, 0.1
    assert -share.min() == pytest.approx((friction + taper) / (1.0 - friction * taper), rel=1e-3)
    assert share[loop.displacement_um.argmax()] == pytest.approx(
        (friction - taper) / (1.0 + friction * taper), rel=1e-2
    )
    elastic = shaft_study().pad.elastic
    lame = 5e-3 / 10.0 * elastic.youngs_modulus_MPa / (500.0 / 300.0 + 1.0)
    assert scar.pressure_MPa[len(scar.axial_um) // 2, 0] == pytest.approx(lame, rel=0.03)


@pytest.mark.seconds
@pytest.mark.parametrize(("taper", "force_N"), [(0.05, 7500.0), (0.0, 5000.0)])
def test_a_shaft_pushed_in_by_a_force_slides_on_under_that_force(taper: float, force_N: float) -> None:
    specimen = {"interference_um": None, "assembly_force_N": force_N, "taper": taper}
    loop = simulate(shaft_study(specimen=specimen), fidelity="quick").loops[0]
    inwards = np.roll(loop.displacement_um, 1) > loop.displacement_um
    middle = np.flatnonzero(inwards)[np.abs(loop.displacement_um[inwards]).argmin()]
    assert -loop.tangential_force_N[middle] == pytest.approx(force_N, rel=0.03)


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"contact": {"length_mm": 10.0}}, r"length_mm in \[contact\].* must be 62\.8319, the shaft's circumference"),
        ({"specimen": {"interference_um": None}}, "nothing else presses a hub on its shaft"),
        ({"specimen": {"shaft_radius_mm": None}}, "is of a shaft: give its shaft_radius_mm, too"),
        ({"specimen": {"assembly_force_N": 900.0}}, "are both given, but either follows from the other"),
        ({"pad": {"face_half_width_mm": None, "edge_radius_mm": None, "radius_mm": 6.0}}, "is the hub of a shaft"),
        ({"specimen": {"bore_radius_mm": 6.0}}, "bore_radius_mm"),
    ],
)
def test_what_does_not_go_with_a_shaft_is_one_sentence(changes: dict[str, Any], complaint: str) -> None:
    with pytest.raises(StudyError, match=complaint):
        shaft_study(**changes)
