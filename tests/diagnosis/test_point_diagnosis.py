"""Diagnosis of contacts at a point: what the fast model takes of two bodies, and what it says of a ball on a flat."""

from copy import deepcopy
from dataclasses import fields, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.records.point_records import SHAPES, run_of
from tests.simulation.point_contacts import STEEL, TEST
from wirewear import record_of_result
from wirewear.base.errors import RecordError
from wirewear.diagnosis import diagnose
from wirewear.diagnosis.fit import fit_record
from wirewear.diagnosis.preparation import prepared
from wirewear.diagnosis.surrogate.candidates import library
from wirewear.diagnosis.surrogate.forward import simulate
from wirewear.diagnosis.surrogate.nominal import nominal_study
from wirewear.diagnosis.surrogate.nominal_model import nominal_inputs
from wirewear.diagnosis.surrogate.wear_states import WearStates
from wirewear.diagnosis.surrogate.worn_wires import WornWires, elastic, equilibrium, wearing
from wirewear.loops.sensor import Sensor, SensorNoise
from wirewear.records import AnyRecord
from wirewear.simulation import run_study
from wirewear.test import study_from_tables
from wirewear.test.bodies import Wire
from wirewear.test.gaps import Gap
from wirewear.views.fit_report import fit_table


def wire(angle_deg: float) -> Wire:
    return Wire("wire", 210000.0, 0.3, "rigid", angle_deg, 0.45, None, 90.0, None)


@pytest.mark.parametrize("angle_deg", [15.0, 60.0, 90.0, 120.0])
def test_the_gap_of_wires_is_sheared_by_their_angle_and_as_wide_at_any(angle_deg: float) -> None:
    gap = Gap.of(wire(0.0), wire(angle_deg))
    assert gap.radius_mm == pytest.approx(0.225)
    assert gap.along == pytest.approx(np.sin(np.radians(angle_deg)) ** 2)
    assert gap.shear == pytest.approx(np.tan(np.radians(angle_deg - 90.0)))
    x, y = 0.03, 0.02
    sheared = (gap.along * (x + gap.shear * y) ** 2 + y**2) / (2.0 * gap.radius_mm)
    assert np.array([x, y]) @ gap.form @ np.array([x, y]) == pytest.approx(sheared)


def test_a_ball_on_a_flat_and_crossed_cylinders_have_the_same_states_and_loops() -> None:
    """To second order they are one contact: all that the fast model takes of the same run is the same."""
    ball, crossed = (WearStates.of_run(run_of(kind)) for kind in SHAPES)
    for field in fields(WearStates):
        assert getattr(ball, field.name) == pytest.approx(getattr(crossed, field.name), rel=1e-3, abs=1e-6), field.name
    setups = [nominal_inputs(study_from_tables(run_of(kind).study, "s"), "stroke") for kind in SHAPES]
    of_ball, of_crossed = (replace(one, crossing_error_rad=round(one.crossing_error_rad, 12)) for one in setups)
    assert of_ball == replace(of_crossed, contact_kind="ball-on-flat")
    loops = [simulate(own, setup, np.array([1e3, 1e5])) for own, setup in zip((ball, crossed), setups, strict=True)]
    assert loops[0].tangential_force_N == pytest.approx(loops[1].tangential_force_N, rel=1e-3, abs=1e-3)


def test_a_ball_considers_effects_of_point_contacts_but_no_angle_of_axes() -> None:
    names = {
        one.name for one in library(nominal_inputs(study_from_tables(run_of("ball-on-flat").study, "s"), "stroke"))
    }
    assert {"plasticity", "third_body", "roughness_compliance", "free_play", "tangential_compliance"} <= names
    assert "crossing_angle_error" not in names


@pytest.mark.parametrize("along", [0.25, 1.0, 4.0])
def test_unlike_curvatures_carry_and_wear_as_closed_forms_say(along: float) -> None:
    """A load of 1 on a foundation k presses π k d²/√along = 1; a spot of depth d has the volume π d²/√along."""
    wires = WornWires.unworn(1, 1.3, along)
    _, _, approach = equilibrium(wires, partial(elastic, stiffness=np.array([3.0])), np.full((1, wires.s.size), 0.2))
    assert approach == pytest.approx(np.full(approach.shape, (along**0.5 / (3.0 * np.pi)) ** 0.5), rel=0.02)
    volumes = np.array([0.0, 0.05, 0.3])
    *_, last = wearing(wires, volumes, 0.2, approach, 0.0, lambda own: partial(elastic, stiffness=own))
    # The fixed body alone wears: to the shape of the other, whose stroke does not change what it reaches across.
    assert float(last.approach.max()) == pytest.approx((0.3 * along**0.5 / np.pi) ** 0.5, rel=0.1)


def test_a_model_of_another_ball_is_refused() -> None:
    record = record_of_result(run_of("ball-on-flat"))
    other = deepcopy(nominal_study(record).resolved())
    other["bodies"]["ball"]["diameter_mm"] = 6.0
    with pytest.raises(RecordError, match=r"diameter_mm of the ball is 6 in the model .* but 3 in the record"):
        prepared(record, study_from_tables(other, "s"))


BALL = {"kind": "ball-on-flat", "bodies": {"ball": {"diameter_mm": 12.7, **STEEL}, "flat": STEEL}}
COMPLIANCE = {"name": "tangential_compliance", "stiffness_N_per_mm": 5000.0}
FRICTION, CYCLES = 0.6, 2000


def ball_record(folder: Path, *effects: dict[str, Any]) -> AnyRecord:
    """A simulated test of a ball, on another mesh than diagnoses have, read thrice by noisy sensors."""
    asked = TEST["conditions"] | {"cycles": CYCLES}
    tables = deepcopy(TEST) | deepcopy(BALL) | {"conditions": asked, "effects": list(effects)}
    tables["log"] = {"loop_cycles": [1, 30, 300, 1000, CYCLES], "contact_states": 0}
    tables["fidelity"] = {"quick": {"increments_per_cycle": 72, "mesh_refinement": 1.1}}
    (run,) = run_study(study_from_tables(tables, "s"), fidelity="quick", output=folder)
    noise = SensorNoise(displacement_um=0.1, tangential_force_N=0.05, normal_force_N=0.05)
    return record_of_result(run, sensor=Sensor(noise=noise), repeats=3, seed=5, samples=300, depth_noise_um=0.05)


@pytest.mark.slow
def test_a_ball_without_a_gap_has_none_and_a_soft_rig_is_named(tmp_path: Path) -> None:
    sound, soft = ball_record(tmp_path / "sound"), ball_record(tmp_path / "soft", COMPLIANCE)
    assert diagnose(sound).diagnosis.verdict == "no_gap"
    found = diagnose(soft).diagnosis
    assert found.verdict == "explained"
    (cause,) = (one for one in found.causes if one.effect == "tangential_compliance")
    low, high = cause.parameters["stiffness_N_per_mm"].interval95
    assert low < 5000.0 < high
    fit = fit_record(soft)
    assert "worn volume, ball" in [*fit_table(fit).columns[0].cells]
    fitted = fit.parameters
    assert fitted["tangential_stiffness_N_per_mm"].value == pytest.approx(5000.0, rel=0.1)
    assert fitted["friction"].value == pytest.approx(FRICTION, rel=0.01)
    assert fitted["energy_wear_coefficient_mm3_per_J"].value == pytest.approx(2e-5, rel=0.02)
    assert fitted["moving_share"].value == pytest.approx(0.3, abs=0.02)
