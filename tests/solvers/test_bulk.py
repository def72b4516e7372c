"""Bulk stresses: closed forms of a bar, how far they shift the stick zone of a contact, what studies state of them."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import solvers
from geometry.arrays import Array
from solvers.bulk_stress import section_stress
from tests.bodies import STEEL, RADIUS_mm, crossed_wires
from tests.stress.interior_runs import CYCLE, run_with_forces
from tests.studies import LONG, block, coarse, line_study, minimal
from wirewear import StudyError
from wirewear.diagnosis.surrogate.nominal import limits_of
from wirewear.records import read_record, record_of_result, write_record
from wirewear.records.values import stated_study
from wirewear.results import read_result
from wirewear.results.hdf5 import write_result
from wirewear.simulation import simulate
from wirewear.simulation.line_model import bodies, line_plan, line_problem
from wirewear.stress.bodies import body_states
from wirewear.stress.line_contacts import INSIDE_LINES
from wirewear.test import LineStudy, study_from_tables
from wirewear.verification import QUICK
from wirewear.verification.line_contact import bulk_rows

TENSION = "[wires.fixed.bulk]\naxial_stress_MPa = 400\naxial_stress_amplitude_MPa = 150\nphase_deg = 90\n"


def test_a_bar_carries_the_force_and_the_moments_of_its_stresses() -> None:
    """N = σ A, M = σ π R³/4 and T = τ π R³/2, over a disc in polar coordinates."""
    radius = 0.2
    r, angle = np.meshgrid((np.arange(400) + 0.5) * radius / 400, np.arange(64) * np.pi / 32, indexing="ij")
    y, z = (r * np.cos(angle)).ravel(), (r * np.sin(angle)).ravel()
    area = (r * radius / 400 * np.pi / 32).ravel()
    bar = solvers.BulkStress(STEEL, (300.0, 0.0, 0.0), (0.0, 80.0, 50.0), 0.5 * np.pi)
    points = np.column_stack([np.zeros_like(y), y, z - radius])
    at_rest, later = section_stress(bar.nominal(np.array([0.0, 0.25])), points, radius)
    assert area @ at_rest[:, 0] == pytest.approx(300.0 * np.pi * radius**2)
    assert np.abs(at_rest[:, 1:]).max() < 1e-12
    assert (area * z) @ later[:, 0] == pytest.approx(80.0 * np.pi * radius**3 / 4.0, rel=1e-4)
    torque = (area * y) @ later[:, 5] - (area * z) @ later[:, 3]
    assert torque == pytest.approx(-50.0 * np.pi * radius**3 / 2.0, rel=1e-4)


def test_a_wire_across_the_motion_contracts_along_it_and_both_wires_stretch_about_the_contact() -> None:
    problem, nodes = crossed_wires(0.01), np.arange(7)
    pulled = solvers.BulkStress(STEEL, (210.0, 0.0, 0.0))
    step = pulled.gradient(np.array([pulled.mean, pulled.mean]))
    offset, own = np.array([0.003, 0.0]), problem.primary.node_positions[nodes]
    expected = 1e-3 * (own * [-0.3, 1.0] - (own - offset) * [1.0, -0.3])
    np.testing.assert_allclose(problem.stretched(step, nodes, offset)[:, :2], expected, atol=1e-15)


STRESS_MPa, ELEMENT_um = 200.0, 8.0


def stretched(body: str, stress: dict[str, float]) -> LineStudy:
    held = {"height_mm": 30.0, "half_width_mm": 15.0}
    bodies: dict[str, dict[str, Any]] = {"pad": {"radius_mm": 20.0} | held, "specimen": dict(held)}
    bodies[body]["bulk"] = stress
    asked = {"normal_load_N_per_mm": 200.0, "displacement_amplitude_um": 5.0}
    return line_study(**bodies, conditions=asked, wear=None, mesh={"contact_mesh_um": ELEMENT_um})


def stuck(before: solvers.ContactState, after: solvers.ContactState, x: Array) -> tuple[float, float]:
    """The ends of the zone that sticks over an increment."""
    still = x[(after.traction[:, 2] > 0.0) & (after.primary_slid == before.primary_slid)]
    return float(still.min()), float(still.max())


@pytest.mark.parametrize(
    ("body", "key", "sign"),
    [("specimen", "axial_stress_amplitude_MPa", -1.0), ("pad", "bending_stress_amplitude_MPa", 1.0)],
)
def test_a_bulk_stress_shifts_the_stick_zone_as_nowell_and_hills_say(body: str, key: str, sign: float) -> None:
    """By a σ / 4 µ p0 against the motion of the body that is pulled at its end (Int. J. Mech. Sci. 29 (1987) 355)."""
    study = stretched(body, {key: STRESS_MPa})
    planned, friction = line_plan(study, "quick"), study.contact.friction
    problem = line_problem(study, *bodies(study, planned))
    fresh = replace(solvers.unloaded_state(problem), bulk=study.drive.mean_bulk)
    state, trace = solvers.run_cycle(
        problem, solvers.first_quarter(problem, solvers.press(problem, fresh)[0], study.drive, 32), study.drive, 32, 0.0
    )
    element, line = 1e-3 * ELEMENT_um, planned.hertz
    shift = STRESS_MPa * line.half_width_mm / (4.0 * friction * line.peak_pressure_MPa)
    assert shift > 2.0 * element
    for before, after in ((trace.states[-2], state), (trace.states[14], trace.states[15])):
        low, high = stuck(before, after, problem.primary.node_positions[:, 0])
        share = abs(float(problem.surface.areas @ after.traction[:, 0])) / (friction * 200.0)
        radius = line.half_width_mm * np.sqrt(1.0 - share)
        assert 0.5 * (low + high) == pytest.approx(sign * shift, abs=element)
        assert 0.5 * (high - low) == pytest.approx(radius, abs=element)


def test_a_pulled_flat_has_the_stick_zone_and_tension_of_closed_forms() -> None:
    assert [row for row in bulk_rows(QUICK) if not row.passed] == []


BULK = np.array([300.0, 120.0, 60.0])


def test_stresses_inside_a_wire_are_those_of_the_contact_and_of_the_bar() -> None:
    run = run_with_forces()
    alone = body_states(run, "fixed", CYCLE, ["end-forward"])[0]
    pulled = [replace(one, bulk_stress_MPa=np.tile(BULK, (len(one.phase), 1))) for one in run.contact_forces]
    state = body_states(replace(run, contact_forces=tuple(pulled)), "fixed", CYCLE, ["end-forward"])[0]
    of_bar = section_stress(BULK, alone.places_mm, RADIUS_mm)
    np.testing.assert_allclose(state.stress - alone.stress, of_bar, atol=0.01)


@pytest.mark.parametrize("of", ["wires", "line"])
def test_a_run_keeps_the_bulk_stress_of_each_position_and_its_fields_have_it(of: str, tmp_path: Path) -> None:
    if of == "wires":
        own, result = "fixed", simulate(coarse(LONG.replace("cycles = 400", "cycles = 1") + TENSION), fidelity="quick")
    else:
        own = "specimen"
        tension = {"axial_stress_MPa": 400.0, "axial_stress_amplitude_MPa": 150.0, "phase_deg": 90.0}
        result = simulate(stretched(own, tension), fidelity="quick")
    write_result(tmp_path / "result.h5", result)
    forces = read_result(tmp_path / "result.h5").forces(1, own)
    assert forces.bulk_stress_MPa is not None
    axial = 400.0 + 150.0 * np.sin(2.0 * np.pi * forces.phase)
    np.testing.assert_allclose(forces.bulk_stress_MPa, axial[:, None] * [1.0, 0.0, 0.0], atol=1e-9)
    if of == "line":
        state = INSIDE_LINES.states(result, own, 1, ["mid-back"], worn=False)[0]
        far = int(np.abs(state.places_mm[:, 0]).argmax())
        np.testing.assert_allclose(state.stress[far, :3], 550.0 * np.array([1.0, 0.3, 0.0]), atol=25.0)


@pytest.mark.parametrize("phase_deg", [0.0, 90.0])
def test_the_area_of_a_loop_is_friction_work_and_that_of_what_pulls_the_body(phase_deg: float) -> None:
    stress = {"axial_stress_amplitude_MPa": STRESS_MPa, "phase_deg": phase_deg}
    result = simulate(stretched("specimen", stress), fidelity="quick")
    area, bulk = (float(result.evolution[name][0]) for name in ("dissipated_energy_mJ", "bulk_work_mJ"))
    assert bulk < -0.2 * area
    assert area - bulk == pytest.approx(float(result.loops[0].friction_work_mJ[-1]), rel=2e-3)
    assert result.quality["loop_area_against_friction_work"] < 2e-3


def test_no_half_of_a_cycle_mirrors_the_other_where_a_body_is_stretched_within_it() -> None:
    alternating = coarse(LONG + TENSION).drive
    steady = coarse(LONG + TENSION.replace("amplitude_MPa = 150", "amplitude_MPa = 0")).drive
    twisted = coarse(LONG + "[wires.fixed.bulk]\ntorsion_stress_MPa = 50\n").drive
    symmetry = solvers.symmetry_of(crossed_wires(0.01))
    assert symmetry.across is not None
    assert symmetry.half_cycle is not None
    assert symmetry.under(steady) == symmetry
    assert symmetry.under(alternating) == replace(symmetry, half_cycle=None)
    assert symmetry.under(twisted) == replace(symmetry, across=None)


def test_bulk_stresses_change_from_block_to_block_of_any_contact() -> None:
    wires = coarse(LONG + TENSION + block(100) + block(100, "bulk.fixed.axial_stress_amplitude_MPa = 250"))
    assert [own.study.drive.bulk[1].amplitude[0] for own in wires.schedule.stretches[:2]] == [150.0, 250.0]
    assert {own.study.drive.bulk[1].mean[0] for own in wires.schedule.stretches} == {400.0}
    blocks = [{"cycles": 9}, {"cycles": 9, "bulk": {"specimen": {"phase_deg": 90}}}]
    lines = line_study(programme=blocks).schedule.stretches
    assert [len(own.study.drive.bulk) for own in lines[:2]] == [0, 2]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (TENSION.replace("400", '"much"'), r"axial_stress_MPa in \[wires.fixed.bulk\] .*must be a number"),
        (block(9, "bulk.third.phase_deg = 3"), r"unknown key 'third' in \[wires\] of block 1"),
        (block(9, "bulk.fixed = 3"), r"bulk in \[wires.fixed\] of block 1 .*must be a table"),
    ],
)
def test_a_bulk_stress_that_cannot_be_is_stated_with_its_place(text: str, message: str) -> None:
    with pytest.raises(StudyError, match=message):
        coarse(LONG + text)


def test_a_state_on_another_mesh_is_as_stretched_as_before() -> None:
    study = stretched("specimen", {"axial_stress_MPa": STRESS_MPa})
    problem = line_problem(study, *bodies(study, line_plan(study, "quick")))
    state = solvers.press(problem, replace(solvers.unloaded_state(problem), bulk=study.drive.mean_bulk))[0]
    assert state.bulk.any()
    np.testing.assert_array_equal(solvers.remeshed(problem, state, problem)[0].bulk, state.bulk)


def test_a_ball_is_not_pulled() -> None:
    steel = {"youngs_modulus_MPa": 2.1e5, "poissons_ratio": 0.3}
    tables = minimal() | {
        "kind": "ball-on-flat",
        "bodies": {"ball": {"diameter_mm": 5.0, **steel}, "flat": dict(steel)},
    }
    tables.pop("wires")
    tables["bodies"]["flat"]["bulk"] = {"axial_stress_MPa": 100.0}
    assert study_from_tables(tables, "study.toml").drive.bulk[0].mean[0] == 100.0
    tables["bodies"]["ball"]["bulk"] = {"axial_stress_MPa": 100.0}
    with pytest.raises(StudyError, match=r"bulk in \[bodies.ball\] of study.toml is given, but a ball is no bar"):
        study_from_tables(tables, "study.toml")


def test_torsion_is_of_round_bars() -> None:
    with pytest.raises(StudyError, match=r"bulk in \[pad\] .*gives a torsion stress, which is of round bars"):
        stretched("pad", {"torsion_stress_MPa": 10.0})


def test_a_record_states_the_bulk_stress_of_its_test_without_which_loops_are_predicted(tmp_path: Path) -> None:
    text = LONG.replace("cycles = 400", "cycles = 2") + TENSION + block(1) + block(1, "bulk.fixed.phase_deg = 0")
    result = simulate(coarse(text), fidelity="quick")
    record = record_of_result(result)
    write_record(tmp_path, record)
    stated = stated_study(read_record(tmp_path).tables)
    assert [own.study.drive.bulk[1].phase_rad for own in stated.schedule.stretches] == [0.5 * np.pi, 0.0]
    (message,) = limits_of(result, stated)
    assert message.startswith("loops are predicted without the bulk stresses")
