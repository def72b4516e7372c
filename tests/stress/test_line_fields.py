"""Stresses inside the bodies of a line contact from the forces that its run records."""

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from geometry import build_planar
from tests.bodies import STEEL
from tests.commands import wirewear
from tests.studies import line_study
from wirewear import lives, reference
from wirewear.base.errors import ResultError, StudyError
from wirewear.results import read_result
from wirewear.simulation import run_study, simulate
from wirewear.simulation.line_model import line_plan, placed_body
from wirewear.simulation.line_runs import LineRun
from wirewear.stress.line_contacts import INSIDE_LINES, state_grid
from wirewear.stress.strength import StrengthAsked, strength_of, yield_sentence
from wirewear.verification.line_contact import largest_tension

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("line")
    run_study(
        line_study(conditions={"cycles": 1}, log={"loop_cycles": [1]}, mesh={"contact_mesh_um": 3.0}),
        fidelity="quick",
        output=path,
    )
    return path


@pytest.mark.parametrize(("asked", "body"), [("specimen", "specimen"), ("lower", "specimen"), ("fixed", "pad")])
def test_fields_strength_and_lives_take_one_body_of_a_line_contact_by_the_same_names(
    folder: Path, tmp_path: Path, asked: str, body: str
) -> None:
    wirewear("fields", folder, "--cycle", "1", "--body", asked, "--output", tmp_path)
    assert {path.name.partition("_")[0] for path in tmp_path.glob("*.vtu")} == {body}
    table = wirewear("strength", folder, "--cycle", "1", "--body", asked, "--output", tmp_path).output
    assert body in table
    assert ("pad" in table) == (body == "pad")
    (life,) = lives(read_result(folder), [asked], values={"tensile_strength_MPa": 800.0})
    assert life.body == body


def test_strengths_of_all_cycles_are_drawn_where_a_course_begins_ends_and_peaks(tmp_path: Path) -> None:
    cycles = [1, 2, 3, 4, 5]
    study = line_study(conditions={"cycles": 5}, log={"loop_cycles": cycles}, mesh={"contact_mesh_um": 12.0})
    run_study(study, fidelity="quick", output=tmp_path)
    asked = "strength", tmp_path, "--body", "pad"
    wirewear(*asked)
    drawn = {path.stem for path in (tmp_path / "strength").glob("*.png")}
    with (tmp_path / "strength" / "strength.csv").open() as file:
        stresses = [float(row["von_mises_MPa"]) for row in csv.DictReader(file)]
    worst = cycles[int(np.argmax(stresses))]
    assert drawn == {f"strength_pad_{cycle:07d}" for cycle in (1, worst, 5)}
    assert len(list((tmp_path / "strength").glob("*.vtu"))) == len(cycles)
    wirewear(*asked, "--cycle", "2", "--output", tmp_path / "second")
    assert [path.stem for path in (tmp_path / "second").glob("*.png")] == ["strength_pad_0000002"]


def test_recorded_forces_carry_the_load_and_the_friction(folder: Path) -> None:
    specimen, pad = read_result(folder).contact_forces
    assert (pad.body, specimen.body) == ("pad", "specimen")
    for forces in (pad, specimen):
        np.testing.assert_allclose(forces.force_N[..., 2].sum(axis=1), -30.0, rtol=1e-3)
    # The pad's axes are the test's, turned over: friction on it along x is what the specimen gives. Tractions are
    # turned back with each body's own surface, which sums see to second order in its slopes.
    np.testing.assert_allclose(pad.force_N[..., 0].sum(axis=1), -specimen.force_N[..., 0].sum(axis=1), rtol=1e-3)


@pytest.mark.parametrize("share", [0.3, 0.6])
def test_at_standard_the_trailing_edge_in_partial_slip_is_stretched_as_cattaneo_and_mindlin_have_it(
    share: float,
) -> None:
    held = {"cycles": 1, "held_tangential_force_N_per_mm": share * 0.6 * 30.0, "displacement_amplitude_um": 20.0}
    study = line_study(wear=None, mesh=None, conditions=held, log={"loop_cycles": [1]})
    result = simulate(study, fidelity="standard")
    forces = result.computed.forces(1, "specimen")
    pulled = int(np.argmax(forces.force_N[..., 0].sum(axis=1)))
    (state,) = INSIDE_LINES.states(result, "specimen", 1, [pulled], worn=False)
    force = state.applied[state.patch_nodes]
    steel = study.pad.elastic
    hertz = reference.hertz_line(30.0, study.pad.radius_mm or 0.0, reference.contact_modulus(steel, steel))
    found = largest_tension(state.body.meshed, state.body.surface, force)
    assert found == pytest.approx(2.0 * 0.6 * hertz.peak_pressure_MPa * share**0.5, rel=0.03)


def test_the_sliding_specimen_is_stressed_beneath_as_smith_and_liu_have_it(folder: Path) -> None:
    grid = state_grid(INSIDE_LINES.states(read_result(folder), "specimen", 1, ["mid-forward"])[0])
    steel = reference.Elastic(2e5, 0.3)
    exact = reference.hertz_line(30.0, 6.0, reference.contact_modulus(steel, steel))
    a, p0 = exact.half_width_mm, exact.peak_pressure_MPa
    middle = grid.points[:, 2].max()
    below = (np.abs(grid.points[:, 0]) < 1500.0 * a) & (middle - grid.points[:, 2] < 1500.0 * a)
    below &= middle - grid.points[:, 2] > 300.0 * a
    x, z = 1e-3 * grid.points[below, 0], 1e-3 * (middle - grid.points[below, 2])
    # The specimen moves towards +x and is held back; its own z axis points out of it.
    expected = reference.line_stress(
        x, z, half_width_mm=a, peak_pressure_MPa=p0, peak_shear_MPa=-0.6 * p0, poissons_ratio=0.3
    )
    found = grid.point_data["stress_MPa"][below]
    for component, sign in ((0, 1.0), (2, 1.0), (5, -1.0)):
        np.testing.assert_allclose(found[:, component], sign * expected[:, component], atol=0.04 * p0)


def test_first_yield_lies_where_mcewen_has_it_and_cracks_begin_at_the_surface(folder: Path) -> None:
    result = read_result(folder)
    steel = reference.Elastic(2e5, 0.3)
    exact = reference.hertz_line(30.0, 6.0, reference.contact_modulus(steel, steel))
    asked = StrengthAsked(yield_strength_MPa=100.0)
    pad, specimen = (strength_of(result, body, 1, asked, INSIDE_LINES) for body in ("pad", "specimen"))
    # At µ = 0.6 the largest stress lies at the surface (Johnson 1985, section 7.1): √3 µ p0 and more.
    assert specimen.von_mises.value_MPa > np.sqrt(3.0) * 0.6 * exact.peak_pressure_MPa
    assert specimen.von_mises.depth_um < 100.0 * exact.half_width_mm
    assert specimen.critical_plane.depth_um < 100.0 * exact.half_width_mm
    assert (specimen.body, pad.body, pad.yields) == ("specimen", "pad", True)
    assert "specimen: yields at 100 MPa from cycle 1" in yield_sentence([specimen])
    smooth = strength_of(
        result, "specimen", 1, StrengthAsked(averaging_length_um=1e3 * exact.half_width_mm), INSIDE_LINES
    )
    with pytest.raises(
        ResultError, match=r"^stresses cannot be averaged over 1e\+09 µm: the pad is thinner than that\.$"
    ):
        strength_of(result, "pad", 1, StrengthAsked(averaging_length_um=1e9), INSIDE_LINES)
    assert smooth.critical_plane.value_MPa < specimen.critical_plane.value_MPa


def test_a_stated_grip_lets_the_pad_give_way() -> None:
    softest = line_study(pad={"grip_width_mm": 2.0, "grip_stiffness_N_per_mm3": 1e3})
    geometry = line_plan(softest, "quick").pad
    assert (geometry.grip_half_width_mm, geometry.grip_stiffness_N_per_mm3) == (1.0, 1e3)
    with pytest.raises(StudyError, match="grip_stiffness_N_per_mm3"):
        line_study(pad={"grip_stiffness_N_per_mm3": -1.0})
    held, firm = (
        placed_body(replace(geometry, grip_stiffness_N_per_mm3=stiffness), steel, upper=True).folded
        for stiffness, steel in ((1e3, STEEL), (None, STEEL))
    )
    # A load on the whole patch meets the springs of the grip in series.
    pressed = np.zeros((len(held.dense) // 3, 3))
    pressed[:, 2] = 1.0 / len(pressed)
    gives = [float(pressed.ravel() @ one.dense @ pressed.ravel()) for one in (held, firm)]
    width = build_planar(geometry).mesh.surface_lengths("grip").sum()
    assert gives[0] - gives[1] == pytest.approx(1.0 / (1e3 * width), rel=0.05)


def test_bodies_of_a_programme_are_meshed_inside_as_they_were_in_the_run() -> None:
    study = line_study(programme=[{"cycles": 10}, {"cycles": 10, "conditions": {"displacement_amplitude_um": 40.0}}])
    assert line_plan(study, "quick").specimen == LineRun.of(study, "quick").planned.specimen
    assert line_plan(study, "quick").specimen == line_plan(study.envelope, "quick").specimen
