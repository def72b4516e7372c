"""Line contacts of any even pad on any rig: what studies say, wear on both springs, the zero-wear limit, variants."""

from contextlib import nullcontext
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import geometry
import solvers
from geometry import Cylinder, TabledProfile
from solvers.elasticity.linear_elasticity import stiffness_matrix
from solvers.elasticity.pairing import pair, primary_surface
from tests.simulation.coarse_runs import Killer
from tests.studies import line_study, require_equal_runs
from wirewear import reference
from wirewear.app.cli.consoles import wide_console
from wirewear.base.errors import RunError, StudyError
from wirewear.reference import Elastic, contact_modulus, hertz_line
from wirewear.results import RunResult, read_result
from wirewear.simulation import run_study, simulate
from wirewear.simulation.convergence import LINES, converge, convergence_table
from wirewear.simulation.line_model import farthest_contact, line_plan
from wirewear.simulation.store import CHECKPOINT_FILE_NAME
from wirewear.stress.line_contacts import INSIDE_LINES
from wirewear.stress.strength import material_points
from wirewear.test import LineStudy
from wirewear.verification.line_contact import (
    MATERIAL,
    LOAD_N_per_mm,
    RADIUS_mm,
    cylinder_on_flat,
    half_width,
    tangential_force,
)

FLAT = {"radius_mm": None, "face_half_width_mm": 0.6, "edge_radius_mm": 1.0, "height_mm": 1.5}
RIG = {
    "tangential_stiffness_N_per_mm2": 5e4,
    "rotational_stiffness_N_per_rad": 1e6,
    "pivot_height_mm": 8.0,
    "normal_spring_stiffness_N_per_mm2": 1.0,
}
MODULUS = reference.contact_modulus(reference.Elastic(2e5, 0.3), reference.Elastic(2e5, 0.3))


@pytest.mark.slow
def test_the_pressure_of_an_unworn_contact_tends_to_hertzs(tmp_path: Path) -> None:
    study = line_study(wear=None, conditions={"cycles": 1}, log={"loop_cycles": [1]})
    rows = {row.figure.name: row for row in converge(study, LINES, fidelity="quick", output=tmp_path)}
    bodies = [Elastic(body.youngs_modulus_MPa, body.poissons_ratio) for body in (study.pad, study.specimen)]
    assert study.pad.radius_mm is not None
    hertz = hertz_line(study.conditions.normal_load_N, study.pad.radius_mm, contact_modulus(*bodies))
    console = wide_console(150)
    with console.capture() as shown:
        console.print(convergence_table(list(rows.values())))
    assert all(f"[{row.figure.unit}]" in shown.get() for row in rows.values())
    pressure = rows["pressure at a node at mid-stroke"]
    assert abs(pressure.limit / hertz.peak_pressure_MPa - 1.0) < 0.01
    mean = rows["mean pressure at mid-stroke"]
    assert abs(mean.limit / hertz.mean_over_segment_MPa(hertz.half_width_mm) - 1.0) < 0.01
    assert rows["worn area of both bodies"].limit == 0.0
    # In gross slip the force is the friction force, whatever the resolution.
    force = study.contact.friction * study.conditions.normal_load_N
    assert rows["largest tangential force"].limit == pytest.approx(force, rel=0.005)


@pytest.fixture(scope="module")
def worn_flat() -> RunResult:
    chosen = line_study(
        kind="line-contact",
        pad=FLAT,
        conditions={"normal_load_N_per_mm": 100.0, "displacement_amplitude_um": 25.0, "cycles": 20_000},
        holder=RIG,
        mesh={"contact_mesh_um": 25.0, "increments_per_cycle": 24},
    )
    return simulate(chosen, fidelity="quick")


def test_any_even_profile_touches_and_wears_as_the_cylinder_that_it_is() -> None:
    x = np.linspace(0.0, 1.5, 301)
    by_points = TabledProfile(tuple(zip(x, x**2 / 12.0, strict=True)))
    hertz = reference.hertz_line(120.0, 6.0, MODULUS)
    for face, tolerance in ((Cylinder(6.0, curved_along=True), 2e-4), (by_points, 2e-3)):
        contact = reference.even_line_contact(face, 120.0, MODULUS, 1.0)
        assert contact.half_width_mm == pytest.approx(hertz.half_width_mm, rel=tolerance)
        assert contact.peak_pressure_MPa == pytest.approx(hertz.peak_pressure_MPa, rel=10 * tolerance)
        # Tilted by 0.02 rad it touches 6 mm × 0.02 aside.
        assert farthest_contact(face, 0.0, 0.02, contact) == pytest.approx(hertz.half_width_mm + 0.12, abs=0.005)
        scar = reference.even_line_scar(face, 1e-3, 1.0)
        assert scar.half_width_mm == pytest.approx(reference.line_contact_scar(1e-3, 6.0).half_width_mm, rel=1e-3)
    with pytest.raises(ValueError, match="does not bear"):
        reference.even_line_contact(by_points, 1e6, MODULUS, 1.0)


@pytest.mark.parametrize(
    ("pad", "changes", "complaint"),
    [
        ({"radius_mm": None}, {}, "does not say which face it has: give radius_mm, or"),
        (FLAT | {"radius_mm": 6.0}, {}, "does not say which face"),
        (FLAT, {"kind": "cylinder-on-flat"}, "give radius_mm, the radius of the cylinder"),
        (FLAT, {"holder": {"rotational_stiffness_N_per_rad": 1e6}}, "pivot_height_mm, the height of its pivot"),
        (FLAT, {"holder": {**RIG, "rotational_stiffness_N_per_rad": 100.0}}, "the pad tips over"),
        ({**FLAT, "profile_points_mm": [[0, 0], [1, "a"]]}, {}, "must be a list of pairs"),
        ({**FLAT, "profile_points_mm": [[0, 0], [1, 1]]}, {}, "does not describe a face"),
        (FLAT, {"variants": {"no way": {}}}, "needs another name"),
    ],
)
def test_a_mistake_is_stated_in_one_sentence(pad: dict[str, Any], changes: dict[str, Any], complaint: str) -> None:
    with pytest.raises(StudyError, match=complaint):
        line_study(**({"kind": "line-contact", "pad": pad} | changes))


@pytest.mark.slow
def test_a_flat_wears_on_a_rig_that_translates_and_rotates(worn_flat: RunResult) -> None:
    """Volumes are those of the energy, energies those of the loops, and slip against friction is the loops' energy."""
    assert worn_flat.status == "complete"
    assert worn_flat.quality["volume_against_energy"] < 1e-10
    assert worn_flat.quality["energy_against_loops"] < 0.02
    assert worn_flat.quality["mirror_error"] < 1e-3
    assert worn_flat.evolution["max_depth_pad_um"][-1] > 0.5
    pad, loop = worn_flat.scar(20_000, "pad"), worn_flat.loops[-1]
    # The pivot's height times the force over the spring, less what the pressure's own moment takes.
    force = worn_flat.evolution["max_tangential_force_N"][-1]
    assert 0.3 < np.radians(np.abs(loop.tilt_deg).max()) / (8.0 * force / 1e6) < 1.05
    work = 1e-6 * 0.6 * np.trapezoid((pad.pressure_MPa * pad.slip_distance_um)[:, 0], pad.axial_um)
    assert work == pytest.approx(worn_flat.evolution["dissipated_energy_mJ"][-1], rel=0.1)
    # The loading spring gives as the bodies wear.
    depths = sum(worn_flat.evolution[f"max_depth_{body}_um"][-1] for body in ("pad", "specimen"))
    assert 100.0 - 2e-3 * depths < worn_flat.evolution["normal_force_N"][-1] < 100.0


def test_a_flat_is_meshed_finely_at_its_edges_and_holds_its_tilt() -> None:
    lines = line_plan(line_study(kind="line-contact", pad=FLAT, holder=RIG), "quick").pad.along.half_lines()
    at_edge = np.diff(lines)[lines[:-1] > 0.55].max()
    assert np.diff(lines).max() > 1.5 * at_edge
    assert lines[-1] > 0.6 + 1.0 * 0.012 / 8.0


E, NU = 200_000.0, 0.3
STEEL = geometry.Elastic(E, NU)
HERTZ = reference.hertz_line(LOAD_N_per_mm, RADIUS_mm, reference.contact_modulus(MATERIAL, MATERIAL))


def block(fine_mm: float, half_mm: float = 0.5, height_mm: float = 1.0, *, upper: bool = False) -> solvers.PlacedBody:
    along = geometry.GradedAxis(fine_mm, 0.5 * half_mm, fine_mm, 0.98 * half_mm)
    meshed = geometry.build_planar(geometry.PlanarGeometry(geometry.Flat(), half_mm, height_mm, along, far_mm=0.2))
    return solvers.place(solvers.condense(meshed.mesh, meshed.patch, STEEL), upper=upper, axis_angle_rad=0.0)


@cache
def line_contact() -> tuple[solvers.ContactProblem, solvers.ContactState]:
    problem = cylinder_on_flat(HERTZ.half_width_mm / 10.0)
    return problem, solvers.press(problem, solvers.unloaded_state(problem))[0]


def test_uniform_strain_is_reproduced_in_plane_and_out_of_it() -> None:
    mesh = geometry.build_planar(
        geometry.PlanarGeometry(
            geometry.Cylinder(6.0, curved_along=True), 1.0, 1.0, geometry.GradedAxis(0.1, 0.2, 0.1, 0.5), far_mm=0.2
        )
    ).mesh
    stiffness = stiffness_matrix(mesh, STEEL)
    x, z = mesh.points.T
    strain = np.array([[3e-4, 2e-4, 0.0], [0.0, 5e-4, 0.0], [1e-4, -4e-4, 0.0]])
    displacement = np.column_stack([a * x + b * z for a, b, _ in strain])
    force = (stiffness @ displacement.ravel()).reshape(-1, 3)
    edges = np.concatenate([mesh.surfaces["contact"], mesh.surfaces["grip"], mesh.surfaces["sides"]])
    inner = np.setdiff1d(np.arange(len(x)), [*edges.ravel(), *np.flatnonzero(np.abs(x) > 0.49)])
    assert np.abs(force[inner]).max() < 1e-10 * np.abs(force).max()
    # The energy of a state of uniform stress is its density times the area; plane strain means eps_yy = 0.
    (exx, exz), (uyx, uyz), (ezx, ezz) = strain[:, :2]
    shear, lame = E / (2.0 * (1.0 + NU)), E * NU / ((1.0 + NU) * (1.0 - 2.0 * NU))
    density = 0.5 * lame * (exx + ezz) ** 2 + shear * (exx**2 + ezz**2 + 0.5 * ((exz + ezx) ** 2 + uyx**2 + uyz**2))
    assert 0.5 * displacement.ravel() @ force.ravel() == pytest.approx(density * mesh.area_mm2(), rel=1e-10)


@pytest.mark.parametrize("primary_is_upper", [True, False])
def test_uniform_pressure_crosses_meshes_that_do_not_match(primary_is_upper: bool) -> None:
    upper, lower = block(0.05, upper=True), block(0.07)
    primary, secondary = (upper, lower) if primary_is_upper else (lower, upper)
    nodes = np.flatnonzero(np.abs(primary.patch.axial_mm) < 0.42)
    fresh = [np.zeros(b.patch.shape) for b in (primary, secondary)]
    pairing = pair(primary_surface(primary), secondary, nodes, np.array([0.003, 0.0]), fresh[0], fresh[1])
    force = pairing.secondary.T @ np.ones(len(nodes))
    assert force.sum() == pytest.approx(pairing.areas.sum(), rel=1e-12)
    whole = np.abs(secondary.patch.axial_mm) < 0.35
    assert force[whole] == pytest.approx(secondary.patch.node_areas()[whole], rel=0.1)


def test_a_cylinder_on_a_flat_is_hertzs_line_contact() -> None:
    problem, pressed = line_contact()
    assert pressed.primary_force[:, 2].sum() == pytest.approx(LOAD_N_per_mm, rel=1e-9)
    assert pressed.traction[:, 2].max() == pytest.approx(HERTZ.peak_pressure_MPa, rel=0.01)
    assert half_width(problem, pressed.traction[:, 2]) == pytest.approx(HERTZ.half_width_mm, rel=0.01)


def test_mirrored_motion_gives_exactly_the_mirrored_forces() -> None:
    problem, pressed = line_contact()
    one, other = pressed, pressed
    for drive in (0.0006, 0.0012, 0.0030, 0.0050, 0.0044, 0.0030):
        one, other = solvers.advance(problem, one, drive, 0.0)[0], solvers.advance(problem, other, -drive, 0.0)[0]
        assert tangential_force(other) == pytest.approx(-tangential_force(one), rel=1e-9)
        mirrored = other.traction[::-1] * [-1.0, 1.0, 1.0]
        assert mirrored == pytest.approx(one.traction, abs=1e-6 * HERTZ.peak_pressure_MPa)
    assert not one.traction[:, 1].any()


@pytest.fixture(scope="module")
def worn() -> RunResult:
    return simulate(line_study(), fidelity="quick")


@pytest.mark.parametrize(
    ("table", "values", "complaint"),
    [
        ("pad", {"radius_mm": -1.0}, r"radius_mm in \[pad\] of study.toml is -1.0, but must lie between"),
        ("pad", {"radius_um": 1.0}, r"given as radius_mm, in millimetres"),
        ("conditions", {"motion": "square"}, 'must be "triangular" or "sinusoidal"'),
        ("wear", {"pad_archard_mm3_per_N_m": 1e-5}, "a body wears by one law"),
        ("holder", {"tangential_stiffness_N_per_mm2": "soft"}, 'or "rigid"'),
    ],
)
def test_a_mistake_in_a_study_of_a_line_is_one_sentence(table: str, values: dict[str, Any], complaint: str) -> None:
    with pytest.raises(StudyError, match=complaint):
        line_study(**{table: values})


@pytest.mark.slow
def test_a_worn_contact_is_a_segment_of_the_cylinder(worn: RunResult) -> None:
    """Oracle of line contacts in gross slip: A = 2b³/(3R), h = b²/(2R); 5 % for the elastic contact's own width."""
    pad, specimen = (worn.scar(20_000, body) for body in ("pad", "specimen"))
    exact = reference.line_contact_scar(1e-6 * (pad.area_um2 + specimen.area_um2), 6.0)
    depth = sum(np.interp(0.0, *scar.section_along_motion()) for scar in (pad, specimen))
    left, right = pad.edges_um()
    assert 1e-3 * depth == pytest.approx(exact.depth_mm, rel=0.05)
    assert 0.5e-3 * (right - left) == pytest.approx(exact.half_width_mm, rel=0.05)

    before, after = worn.evolution["max_depth_pad_um"][1:]
    assert np.log(after / before) / np.log(4.0) == pytest.approx(2.0 / 3.0, abs=0.07)


def test_archards_law_wears_what_the_energy_law_wears_at_the_same_friction() -> None:
    same = line_study(wear={"pad_energy_mm3_per_J": 0.0, "pad_archard_mm3_per_N_m": 4e-5 * 0.6})
    assert same.energy_coefficients() == pytest.approx((4e-5, 2e-5), rel=1e-12)


@pytest.mark.seconds
def test_a_run_of_any_length_that_was_killed_and_resumed_ends_as_one_of_a_millimetre(tmp_path: Path) -> None:
    unit = line_study(conditions={"cycles": 400}, log={"loop_cycles": [1, 40, 400]})
    short, unbroken = unit.of_length(8.0), simulate(unit, fidelity="quick").of_length(8.0)
    assert short.conditions.normal_load_N == 240.0
    with pytest.raises(KeyboardInterrupt):
        run_study(short, fidelity="quick", output=tmp_path, observer_of=lambda _: nullcontext(Killer(1)))
    assert read_result(tmp_path / "result.h5").status == "running"
    (resumed,) = run_study(short, fidelity="quick", output=tmp_path, resume=True)
    assert resumed.status == "complete"
    assert not (tmp_path / CHECKPOINT_FILE_NAME).exists()
    require_equal_runs(resumed, unbroken)
    assert unbroken.quality["volume_against_energy"] < 1e-10
    complete = (tmp_path / "result.h5").read_bytes()
    run_study(short, fidelity="quick", output=tmp_path, resume=True)
    assert (tmp_path / "result.h5").read_bytes() == complete
    with pytest.raises(RunError, match="another study"):
        run_study(line_study(), fidelity="quick", output=tmp_path, resume=True)


@pytest.mark.seconds
def test_what_wears_is_there_or_has_left_also_after_an_interruption(tmp_path: Path) -> None:
    debris = {"name": "debris_balance", "modulus_MPa": 5e3, "leaving_share": 1e-3, "protecting_um": 1e6}
    study = line_study(
        conditions={"cycles": 400}, log={"loop_cycles": [1, 40, 400]},
        effects=[{**debris, "retained_fraction": 0.4}],
    )  # fmt: skip
    with pytest.raises(KeyboardInterrupt):
        run_study(study, fidelity="quick", output=tmp_path, observer_of=lambda _: nullcontext(Killer(1)))
    (result,) = run_study(study, fidelity="quick", output=tmp_path, resume=True)
    evolution = result.evolution
    worn, there, left = (evolution[name] for name in ("worn_volume_pad_mm3", "debris_volume_mm3", "debris_left_mm3"))
    worn = worn + evolution["worn_volume_specimen_mm3"]
    assert there + left == pytest.approx(0.4 * worn, rel=1e-12)
    assert (np.diff(left) > 0.0).all()
    assert (there > 0.0).all()


def sticking(share: float, stress_MPa: float = 0.0) -> LineStudy:
    """A steel cylinder of 25 mm under 150 N/mm, by a drive that holds a share of the sliding force."""
    own, held = {"youngs_modulus_MPa": 210_000.0, "height_mm": 10.0}, share * 0.6 * 150.0
    bulk = {"bulk": {"axial_stress_amplitude_MPa": stress_MPa}} if stress_MPa else {}
    conditions = {"normal_load_N_per_mm": 150.0, "displacement_amplitude_um": 20.0, "cycles": 1}
    return line_study(
        pad={"radius_mm": 25.0, "half_width_mm": 6.0, **own},
        specimen={"half_width_mm": 15.0, **own, **bulk},
        conditions=conditions | {"held_tangential_force_N_per_mm": held},
        wear=None,
        mesh=None,
        log=None,
    )


@pytest.mark.parametrize(
    ("share", "stress_MPa", "energy_uJ"),
    [
        (0.15, 0.0, 0.054425),
        (0.5, 0.0, 2.5408),
        (0.95, 0.0, 31.191),
        pytest.param(0.3, 60.0, 0.62828, marks=pytest.mark.seconds),
        pytest.param(0.3, 400.0, 7.450, marks=pytest.mark.seconds),
    ],
)
def test_energy_in_partial_slip_is_that_of_cattaneo_and_of_nowell_and_hills(
    share: float, stress_MPa: float, energy_uJ: float
) -> None:
    """Of half-planes: W = 2(1-ν)/πG (µP)² [2(1-q) ln(1-q) + 2q - q²] without bulk stress, the last one by numbers."""
    loop = simulate(sticking(share, stress_MPa), fidelity="quick").loops[0]
    assert 1e3 * float(loop.friction_work_mJ[-1]) == pytest.approx(energy_uJ, rel=0.02)


@pytest.mark.seconds
@pytest.mark.parametrize(("share", "stress_MPa"), [(0.5, 60.0), pytest.param(0.3, 0.0, marks=pytest.mark.slow)])
def test_tension_at_the_trailing_edge_in_partial_slip_is_that_of_nowell_and_hills(
    share: float, stress_MPa: float
) -> None:
    study, half_mm, pressure_MPa = sticking(share, stress_MPa), 0.203421, 469.434
    result = simulate(study, fidelity="quick")
    states = INSIDE_LINES.states(result, "specimen", 1, ["end-forward"], worn=False)
    exact = stress_MPa + reference.line_partial_slip_stress(
        -half_mm,
        0.0,
        half_width_mm=half_mm,
        stick_half_width_mm=half_mm * np.sqrt(1.0 - share),
        peak_pressure_MPa=pressure_MPa,
        friction=0.6,
        poissons_ratio=0.3,
        stick_centre_mm=half_mm * stress_MPa / (4.0 * 0.6 * pressure_MPa),
    )
    found = material_points(states, states[0].patch_nodes).history[0, :, 0].max()
    assert found == pytest.approx(float(exact[0]), rel=0.03)


def test_a_line_contact_that_its_bodies_let_stick_has_more_elements_all_alike() -> None:
    given = sticking(0.5).with_values({"conditions.held_tangential_force_N_per_mm": None})
    for height_mm, amplitude_um, sticks in ((10.0, 3.5, True), (4.0, 3.5, False), (10.0, 6.0, False)):
        values = {"conditions.displacement_amplitude_um": amplitude_um}
        heights = {f"{body}.height_mm": height_mm for body in ("pad", "specimen")}
        axis = line_plan(given.with_values(values | heights), "quick").pad.along
        a = line_plan(given, "quick").hertz.half_width_mm
        assert a / np.diff(axis.half_lines()) == pytest.approx(40.0 if sticks else 8.0, rel=0.1)
