"""Line contacts of any even pad on any rig: worn on both springs, their zero-wear limit, variants, sensors."""

from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geometry import Cylinder, RoundedFlat, TabledProfile
from tests.test_planar_study import TABLES
from wirewear import reference
from wirewear.base.errors import StudyError
from wirewear.faces.study_script import wide_console
from wirewear.planar import PlanarStudy, planar_study_from_tables, run_planar_study
from wirewear.planar.model import PlanarPlan, plan
from wirewear.planar.run import LINES
from wirewear.reference import Elastic, contact_modulus, hertz_line
from wirewear.results import RunResult
from wirewear.simulation.convergence import converge, convergence_table

FLAT = {
    "face_half_width_mm": 0.6,
    "edge_radius_mm": 1.0,
    "youngs_modulus_MPa": 2e5,
    "poissons_ratio": 0.3,
    "height_mm": 1.5,
}
RIG = {
    "tangential_stiffness_N_per_mm2": 5e4,
    "rotational_stiffness_N_per_rad": 1e6,
    "pivot_height_mm": 8.0,
    "normal_spring_stiffness_N_per_mm2": 1.0,
}
MODULUS = reference.contact_modulus(reference.Elastic(2e5, 0.3), reference.Elastic(2e5, 0.3))


def study_of(**changes: Any) -> PlanarStudy:
    return planar_study_from_tables(deepcopy(TABLES) | changes, "study.toml")


def spacings(planned: PlanarPlan) -> tuple[float, float, float]:
    return planned.pad.along.fine_mm, planned.pad.far_mm, planned.specimen.along.fine_mm


@pytest.mark.slow
def test_the_pressure_of_an_unworn_contact_tends_to_hertzs(tmp_path: Path) -> None:
    study = study_of(wear={}, conditions=TABLES["conditions"] | {"cycles": 1}, log={"loop_cycles": [1]}, holder={})
    rows = {row.figure.name: row for row in converge(study, LINES, fidelity="quick", output=tmp_path)}
    bodies = [Elastic(body.youngs_modulus_MPa, body.poissons_ratio) for body in (study.pad, study.specimen)]
    assert study.pad.radius_mm is not None
    hertz = hertz_line(study.conditions.normal_load_N_per_mm, study.pad.radius_mm, contact_modulus(*bodies))
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
    force = study.contact.friction * study.conditions.normal_load_N_per_mm
    assert rows["largest tangential force"].limit == pytest.approx(force, rel=0.005)


def tables(pad: dict[str, Any] | None = None, **changes: Any) -> dict[str, Any]:
    changed = deepcopy(TABLES) | {"kind": "line-contact"}
    if pad is not None:
        changed["pad"] = pad
    for table, values in changes.items():
        changed[table] = changed.get(table, {}) | values
    return changed


def study(pad: dict[str, Any] | None = None, **changes: Any) -> PlanarStudy:
    return planar_study_from_tables(tables(pad, **changes), "study.toml")


@pytest.fixture(scope="module")
def worn_flat() -> RunResult:
    chosen = study(
        FLAT,
        conditions={"normal_load_N_per_mm": 100.0, "displacement_amplitude_um": 25.0, "cycles": 20_000},
        holder=RIG,
        mesh={"contact_mesh_um": 25.0, "increments_per_cycle": 24},
    )
    return run_planar_study(chosen, fidelity="quick")


def test_any_even_profile_touches_and_wears_as_the_cylinder_that_it_is() -> None:
    x = np.linspace(0.0, 1.5, 301)
    by_points = TabledProfile(tuple(zip(x, x**2 / 12.0, strict=True)))
    hertz = reference.hertz_line(120.0, 6.0, MODULUS)
    for face, tolerance in ((Cylinder(6.0, curved_along=True), 2e-4), (by_points, 2e-3)):
        contact = reference.even_line_contact(face, 120.0, MODULUS, 1.0)
        assert contact.half_width_mm == pytest.approx(hertz.half_width_mm, rel=tolerance)
        assert contact.peak_pressure_MPa == pytest.approx(hertz.peak_pressure_MPa, rel=10 * tolerance)
        scar = reference.even_line_scar(face, 1e-3, 1.0)
        assert scar.half_width_mm == pytest.approx(reference.line_contact_scar(1e-3, 6.0).half_width_mm, rel=1e-3)
    with pytest.raises(ValueError, match="does not bear"):
        reference.even_line_contact(by_points, 1e6, MODULUS, 1.0)


def test_a_flat_with_a_vanishing_face_is_a_cylinder_and_a_wide_one_bears_its_load_at_its_edges() -> None:
    narrow = reference.even_line_contact(RoundedFlat(0.0, 6.0), 120.0, MODULUS, 1.0)
    assert narrow.half_width_mm == pytest.approx(0.09134, rel=1e-3)
    wide = reference.even_line_contact(RoundedFlat(1.0, 3.0), 400.0, MODULUS, 2.0)
    assert 1.0 < wide.half_width_mm < 1.1
    assert wide.peak_pressure_MPa > 1.5 * 400.0 / (2.0 * wide.half_width_mm)


@pytest.mark.parametrize(
    ("pad", "changes", "complaint"),
    [
        (
            {"youngs_modulus_MPa": 2e5, "poissons_ratio": 0.3},
            {},
            "does not say which face the pad has: give radius_mm, or",
        ),
        (FLAT | {"radius_mm": 6.0}, {}, "does not say which face"),
        (FLAT, {"kind": "cylinder-on-flat"}, "give radius_mm, the radius of the cylinder"),
        (FLAT, {"holder": {"rotational_stiffness_N_per_rad": 1e6}}, "pivot_height_mm, the height of its pivot"),
        (FLAT, {"holder": {**RIG, "rotational_stiffness_N_per_rad": 100.0}}, "the pad tips over"),
        ({**FLAT, "profile_points_mm": [[0, 0], [1, "a"]]}, {}, "must be a list of pairs"),
        ({**FLAT, "profile_points_mm": [[0, 0], [1, 1]]}, {}, "does not describe a face"),
        (FLAT, {"variants": {"no way": {}}}, "needs another name"),
    ],
)
def test_a_mistake_is_told_in_one_sentence(pad: dict[str, Any], changes: dict[str, Any], complaint: str) -> None:
    changed = tables(pad)
    changed |= changes
    with pytest.raises(StudyError, match=complaint):
        planar_study_from_tables(changed, "study.toml")


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
    meshes = plan(study(FLAT, holder=RIG), "quick")
    lines = meshes.pad.along.half_lines()
    at_edge = np.diff(lines)[lines[:-1] > 0.55].max()
    assert np.diff(lines).max() > 1.5 * at_edge
    assert lines[-1] > 0.6 + 1.0 * 0.012 / 8.0
