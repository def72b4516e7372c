"""Parameters fitted to records of line contacts whose truth is known: simulated with another mesh and other jumps."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from wirewear.fitting import FittedTest, fit_record
from wirewear.loops.sensor import Sensor, SensorNoise
from wirewear.planar import PlanarStudy, planar_study_from_tables, run_planar_study
from wirewear.records import LineRecord, record_of_result
from wirewear.records.line_tables import LineStated

LENGTH_mm, CYCLES = 8.0, 2000
STEEL = {"youngs_modulus_MPa": 210000.0, "poissons_ratio": 0.3}
NOISE = Sensor(noise=SensorNoise(displacement_um=0.05, tangential_force_N=0.5, normal_force_N=0.5))

FACES: dict[str, tuple[dict[str, float], float]] = {
    "cylinder": ({"radius_mm": 6.0}, 20.0),
    "rounded flat": ({"face_half_width_mm": 0.15, "edge_radius_mm": 3.0}, 25.0),
}


@cache
def record_of(face: str, play_um: float = 0.0) -> LineRecord:
    """Two tests of µ 0.7 on a rig of 2000 N/mm² and 2 and 4·10⁻⁵ mm³/J; nothing but load and stroke is stated."""
    keys, load = FACES[face]
    tables: dict[str, Any] = {
        "format": 1,
        "name": face,
        "kind": "line-contact",
        "pad": keys | STEEL,
        "specimen": STEEL,
        "conditions": {
            "normal_load_N_per_mm": load,
            "displacement_amplitude_um": 35.0,
            "cycles": CYCLES,
            "frequency_Hz": 5.0,
        },
        "contact": {"friction": 0.7},
        "wear": {"pad_energy_mm3_per_J": 2.0e-5, "specimen_energy_mm3_per_J": 4.0e-5},
        "holder": {"tangential_stiffness_N_per_mm2": 2000.0},
        "effects": [{"name": "free_play", "gap_um": play_um}] if play_um else [],
        "log": {"loop_cycles": [1, 30, 300, CYCLES]},
        "mesh": {"contact_mesh_um": 9.0, "jump_tolerance": 0.05, "increments_per_cycle": 80},
    }
    result = run_planar_study(planar_study_from_tables(tables, "study.toml"), fidelity="quick")
    options: dict[str, Any] = {"sensor": NOISE, "depth_noise_um": 0.005, "repeats": 2, "seed": 1, "samples": 256}
    record = record_of_result(result, LENGTH_mm, **options)
    return replace(record, tables=record.tables.model_copy(update={"stated": LineStated()}))


@cache
def fitted(face: str, play_um: float = 0.0) -> FittedTest:
    return fit_record(record_of(face, play_um))


def within(fit: FittedTest, name: str, truth: float, share: float) -> None:
    """The truth lies in the interval, and the value is near it."""
    found = fit.parameters[name]
    assert found.interval95[0] <= truth <= found.interval95[1]
    assert found.value == pytest.approx(truth, rel=share)


@pytest.mark.slow
@pytest.mark.parametrize("face", FACES)
def test_friction_rig_and_wear_of_both_bodies_are_found(face: str) -> None:
    fit = fitted(face)
    within(fit, "friction", 0.7, 0.02)
    within(fit, "tangential_stiffness_N_per_mm", 2000.0 * LENGTH_mm, 0.06)
    for body, truth in (("pad", 2e-5), ("specimen", 4e-5)):
        assert fit.parameters[f"{body}_energy_wear_coefficient_mm3_per_J"].value == pytest.approx(truth, rel=0.03)
    volume, energy = fit.found["worn_volume_specimen_mm3"].value, fit.found["accumulated_energy_J"].value
    coefficient = fit.parameters["specimen_energy_wear_coefficient_mm3_per_J"].value
    assert volume / energy == pytest.approx(coefficient, rel=0.01)
    assert isinstance(fit.study, PlanarStudy)
    assert fit.study.holder.tangential_stiffness_N_per_mm2 == pytest.approx(2000.0, rel=0.06)
    assert fit.study.log.loop_cycles == (1, 30, 300, CYCLES)


@pytest.mark.slow
def test_play_is_told_from_the_rigs_stiffness() -> None:
    fit = fitted("cylinder", 4.0)
    assert fit.parameters["free_play_um"].value == pytest.approx(4.0, rel=0.1)
    assert fit.parameters["tangential_stiffness_N_per_mm"].value == pytest.approx(16000.0, rel=0.1)
    assert [effect.name for effect in fit.study.effects] == ["free_play"]


def record_of_nothing() -> LineRecord:
    from tests.logger_files import CYLINDER, line_record

    return line_record(CYLINDER)


def test_energies_and_volumes_of_a_line_contact_are_those_of_the_whole() -> None:
    from wirewear.fitting.wear import fitted_wear

    record = record_of_nothing()
    parameters, found, notes = fitted_wear(record)
    loop = record.loops[0]
    x, q = loop.displacement_um, loop.tangential_force_N
    area_mJ = 0.5e-3 * abs(float(np.sum(q * (np.roll(x, -1) - np.roll(x, 1)))))
    assert found["accumulated_energy_J"].value == pytest.approx(1e-3 * area_mJ * 1000, rel=0.01)
    # A parabola of 600 µm and 2.5 µm along 8 mm.
    assert found["worn_volume_specimen_mm3"].value == pytest.approx(2.0 / 3.0 * 0.6 * 2.5e-3 * 8.0, rel=0.01)
    ratio = found["worn_volume_pad_mm3"].value / found["accumulated_energy_J"].value
    assert parameters["pad_energy_wear_coefficient_mm3_per_J"].value == pytest.approx(ratio)
    assert notes == []
