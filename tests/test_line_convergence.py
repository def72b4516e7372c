"""Line contacts refined: what each refinement refines, and where figures tend to, against closed forms."""

from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest

from tests.test_planar_study import TABLES
from wirewear.base.errors import StudyError
from wirewear.faces.study_script import wide_console
from wirewear.planar.convergence import LINES, refined_study, resolutions_of
from wirewear.planar.model import PlanarPlan, plan
from wirewear.planar.reading import planar_study_from_tables
from wirewear.planar.tables import PlanarStudy
from wirewear.reference import Elastic, contact_modulus, hertz_line
from wirewear.simulation.convergence import BASE, JUMPS, MESH, POSITIONS, converge
from wirewear.simulation.convergence_report import convergence_table


def study_of(**changes: Any) -> PlanarStudy:
    return planar_study_from_tables(deepcopy(TABLES) | changes, "study.toml")


def spacings(planned: PlanarPlan) -> tuple[float, float, float]:
    return planned.pad.along.fine_mm, planned.pad.far_mm, planned.specimen.along.fine_mm


def test_each_refinement_refines_one_resolution_and_leaves_the_others() -> None:
    study = refined_study(study_of(), "quick")
    plans = {name: plan(study.variant(name), "quick") for name in study.variant_names}
    base = plans.pop(BASE)
    assert tuple(plans) == (*MESH.runs, *POSITIONS.runs, *JUMPS.runs)
    for factor, name in zip(MESH.factors, MESH.runs, strict=True):
        assert spacings(plans[name]) == pytest.approx([size / factor for size in spacings(base)])
    for factor, name in zip(POSITIONS.factors, POSITIONS.runs, strict=True):
        assert plans[name].increments_per_cycle == factor * base.increments_per_cycle
    for factor, name in zip(JUMPS.factors, JUMPS.runs, strict=True):
        assert plans[name].jump_tolerance == pytest.approx(base.jump_tolerance / factor**2)
    for name, planned in plans.items():
        assert (planned.pad == base.pad) == (name not in MESH.runs)
        assert (planned.increments_per_cycle == base.increments_per_cycle) == (name not in POSITIONS.runs)
        assert (planned.jump_tolerance == base.jump_tolerance) == (name not in JUMPS.runs)


def test_without_wear_there_are_no_jumps_to_refine() -> None:
    assert resolutions_of(study_of(wear={})) == (MESH, POSITIONS)


def test_variants_are_refined_one_at_a_time() -> None:
    study = study_of(variants={"soft": {"holder": {"tangential_stiffness_N_per_mm2": 100.0}}})
    with pytest.raises(StudyError, match="has variants: choose one of soft"):
        refined_study(study, "quick")
    assert BASE in refined_study(study.variant("soft"), "quick").variant_names


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
