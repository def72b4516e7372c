"""Diagnoses of tests whose load, stroke, friction or wear is not the same all along."""

from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geometry.arrays import Array
from solvers import LoadCycle
from tests.diagnosis.test_sticking_diagnosis import CASES, ball, circumstances
from tests.simulation.point_contacts import STEEL, TEST
from wirewear import record_of_result
from wirewear.diagnosis import diagnose
from wirewear.diagnosis.preparation import ReducedRecord
from wirewear.diagnosis.surrogate.forward import simulate
from wirewear.diagnosis.surrogate.nominal_model import nominal_inputs
from wirewear.loops.sensor import Sensor, SensorNoise
from wirewear.simulation import run_study
from wirewear.test import study_from_tables

LINE: dict[str, Any] = {
    "format": 1, "name": "line", "kind": "line-contact", "pad": {"radius_mm": 6.0} | STEEL, "specimen": STEEL,
    "conditions": {"normal_load_N_per_mm": 20.0, "displacement_amplitude_um": 35.0, "cycles": 2000},
    "contact": {"friction": 0.6, "length_mm": 10.0},
    "wear": {"pad_energy_mm3_per_J": 2.0e-5, "specimen_energy_mm3_per_J": 4.0e-5},
    "holder": {"tangential_stiffness_N_per_mm2": 2000.0},
    "mesh": {"contact_mesh_um": 12.0, "jump_tolerance": 0.05},
    "log": {"loop_cycles": [1, 210, 300, 390, 610, 1000, 1010, 1500, 2000]},
}  # fmt: skip
OPENS = [[0.0, 1.0], [0.3, 1.0], [0.4, 0.0], [0.6, 0.0], [0.7, 1.0], [1.0, 1.0]]
BLOCKS = {"programme": [{"cycles": 200}, {"cycles": 200, "conditions": {"displacement_amplitude_um": 18.0}}]}
#: Keys that a test has beside those of `LINE`, and which block of it is looked at, None for all.
TESTS: dict[str, tuple[dict[str, Any], int | None]] = {
    "load that opens the contact": ({"conditions.load_cycle": {"points": OPENS}}, None),
    "load that varies in the cycle": ({"conditions.load_cycle": {"amplitude_share": 0.4, "lag_deg": 60.0}}, None),
    "block of a shorter stroke": (BLOCKS, 2),
    "blocks of two strokes": (BLOCKS, None),
    "wear that begins late": ({"wear.law": {"name": "energy-threshold", "threshold_mJ_per_mm2": 200.0}}, None),
    "layer of lower friction": ({"specimen.layers": [{"thickness_um": 0.5, "friction": 0.3}]}, None),
}  # fmt: skip
FRICTION = 0.5


@pytest.mark.parametrize("lag_deg", [0.0, 60.0, 90.0])
def test_a_slider_under_a_load_that_varies_has_its_friction_at_each_moment(lag_deg: float) -> None:
    """On a rigid rig x = cos 2πt, so that mid-stroke is passed at a quarter and at three quarters of the cycle."""
    stiff = replace(ball(), stiffness_N_per_um=np.full(2, 1e4))
    load = study_from_tables(with_keys({"conditions.load_cycle": {"amplitude_share": 0.4, "lag_deg": lag_deg}}), "s")
    course = simulate(stiff, circumstances(50.0, load_cycle=load.conditions.load_cycle), np.array([1.0, 10.0]))
    quarter = 0.4 * np.sin(np.radians(lag_deg))
    friction_N, x = 0.6 * 40.0, course.displacement_um[0]

    def in_the_middle(column: Array) -> list[float]:
        return [float(np.interp(0.0, sign * x[side], column[0, side])) for side, sign in enumerate((1.0, -1.0))]

    assert in_the_middle(course.normal_force_N) == pytest.approx(
        [40.0 - 40.0 * quarter, 40.0 + 40.0 * quarter], rel=5e-3
    )
    assert in_the_middle(course.tangential_force_N) == pytest.approx(
        [friction_N * (1.0 - quarter), -friction_N * (1.0 + quarter)], rel=5e-3
    )
    assert course.energy_mJ == pytest.approx(4e-3 * friction_N * 50.0, rel=2e-3)


def with_keys(keys: dict[str, Any], *effects: dict[str, Any]) -> dict[str, Any]:
    tables = deepcopy(LINE) | {"effects": list(effects)}
    for key, value in keys.items():
        table, _, name = key.rpartition(".")
        (tables[table] if table else tables)[name] = value
    return tables


@pytest.mark.parametrize(("share", "amplitude_um", "energy_uJ"), CASES)
def test_a_contact_that_sticks_under_a_load_that_hardly_varies_has_the_loop_of_mindlin(
    share: float, amplitude_um: float, energy_uJ: float
) -> None:
    course = simulate(ball(), circumstances(amplitude_um, load_cycle=LoadCycle(1e-9)), np.array([1.0, 10.0]))
    assert course.tangential_force_N.max() == pytest.approx(share * 24.0, rel=3e-3)
    assert 1e3 * course.energy_mJ == pytest.approx(energy_uJ, rel=0.03)


def test_a_contact_without_load_carries_nothing_and_sticks_from_where_it_closes() -> None:
    """Open from 0.4 to 0.6 of the cycle, about the end at −x; Hertz's contact is stiffer under more load."""
    load = LoadCycle(points=((0.0, 1.0), (0.3, 1.0), (0.4, 0.0), (0.6, 0.0), (0.7, 1.0), (1.0, 1.0)))
    stiff = replace(ball(), stiffness_N_per_um=np.full(2, 1e4))
    course = simulate(stiff, circumstances(50.0, load_cycle=load), np.array([1.0, 10.0]))
    x, q, p = (one[0] for one in (course.displacement_um, course.tangential_force_N, course.normal_force_N))
    is_open = x < 50.0 * np.cos(0.8 * np.pi) - 1.0
    assert np.abs(q[is_open]).max() == 0.0
    assert np.abs(p[is_open]).max() == 0.0
    pressed = np.abs(x) < 10.0
    assert np.abs(q[pressed]) == pytest.approx(24.0, rel=1e-6)


def test_a_pad_is_not_suspected_to_be_flattened() -> None:
    pad = {"shape": "pad", "face_half_width_mm": 0.2, "edge_radius_mm": 5.0, **STEEL}
    bodies = {"lower": {"shape": "flat", **STEEL}, "upper": pad}
    study: Any = study_from_tables(deepcopy(TEST) | {"kind": "point-contact", "bodies": bodies}, "s")
    unread: Any = None
    reduced = ReducedRecord(unread, study, unread, nominal_inputs(study, "stroke"), unread)
    assert "plasticity" in reduced.unfit
    ball_on_flat = bodies | {"upper": {"shape": "ball", "diameter_mm": 6.0, **STEEL}}
    other = study_from_tables(deepcopy(TEST) | {"kind": "point-contact", "bodies": ball_on_flat}, "s")
    assert "plasticity" not in replace(reduced, study=other).unfit


@pytest.mark.slow
@pytest.mark.parametrize("test", TESTS)
def test_any_test_has_no_gap_as_stated_and_its_friction_is_found(test: str, tmp_path: Path) -> None:
    keys, block = TESTS[test]
    noise = SensorNoise(displacement_um=0.05, tangential_force_N=0.5, normal_force_N=0.5)
    for effects in ((), ({"name": "friction_offset", "friction": FRICTION},)):
        study = study_from_tables(with_keys(keys, *effects), "s")
        (run,) = run_study(study, fidelity="quick", output=tmp_path / str(len(effects)))
        made = record_of_result(run, sensor=Sensor(noise=noise), repeats=2, seed=5, samples=300, depth_noise_um=0.05)
        found = diagnose(made if block is None else made.of_block(block)).diagnosis
        assert ("block 2 of the programme is taken in" in found.notes) is (test == "blocks of two strokes")
        if not effects:
            assert found.verdict == "no_gap"
            continue
        assert found.verdict == "explained"
        cause = next(one for one in found.causes if one.effect == "friction_offset")
        low, high = cause.parameters["friction"].interval95
        assert low < FRICTION < high
