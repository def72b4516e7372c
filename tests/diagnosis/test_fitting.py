"""Parameters fitted to records of another code's rigs, energies of whole tests, stiffness without the contact's."""

import dataclasses
from collections.abc import Mapping
from functools import cache

import numpy as np
import pytest

from tests.exam.frozen_states import frozen_states
from tests.exam.independent_records import independent_record
from tests.synthetic_loops import Recipe, SyntheticLoop
from wirewear.base.course import enclosed_energy
from wirewear.diagnosis.fit import FittedParameter, FittedTest, fit_record
from wirewear.diagnosis.fit.stiffness import rig_compliance, spring_of_loads
from wirewear.loops import analyse_loop
from wirewear.records import ExperimentRecord
from wirewear.records.evolution_checks import accumulated_energy_J


@pytest.fixture(autouse=True)
def _frozen(monkeypatch: pytest.MonkeyPatch) -> None:
    """Wear states of the article's test in place of a finite element run."""
    monkeypatch.setattr(
        "wirewear.diagnosis.surrogate.nominal_model.PointModel.states", lambda *_: (frozen_states(), ())
    )


RIGS: dict[str, dict[str, Mapping[str, float]]] = {
    "as stated": {},
    "softer": {"tangential_compliance": {"stiffness_N_per_mm": 400.0}},
    "rough": {"friction_offset": {"friction": 0.75}},
    "loose": {"free_play": {"gap_um": 5.0}},
    "running in": {"friction_evolution": {"initial": 0.45, "final": 0.62, "cycles": 3000.0}},
}


@cache
def record_of(rig: str, repeats: int = 3) -> ExperimentRecord:
    return independent_record(RIGS[rig], repeats=repeats, scars=rig == "as stated")


@cache
def fitted(rig: str, repeats: int = 3) -> FittedTest:
    return fit_record(record_of(rig, repeats))


def known(fit: FittedTest, name: str) -> FittedParameter:
    return fit.parameters[name]


def holds(parameter: FittedParameter, truth: float) -> bool:
    return parameter.interval95[0] <= truth <= parameter.interval95[1]


@pytest.mark.slow
def test_friction_and_rig_lie_in_their_intervals_and_wear_is_volume_over_the_whole_tests_energy() -> None:
    fit = fitted("as stated")
    assert holds(known(fit, "friction"), 0.62)
    assert known(fit, "friction").value == pytest.approx(0.62, rel=0.03)
    assert holds(known(fit, "tangential_stiffness_N_per_mm"), 167.0)
    assert known(fit, "tangential_stiffness_N_per_mm").value == pytest.approx(167.0, rel=0.05)
    fit = fitted("as stated")
    assert holds(known(fit, "energy_wear_coefficient_mm3_per_J"), 3.0e-5)
    assert known(fit, "moving_share").value == pytest.approx(0.5, abs=0.03)


@pytest.mark.slow
def test_free_play_is_distinguished_from_compliance() -> None:
    fit = fitted("loose")
    assert known(fit, "free_play_um").value == pytest.approx(5.0, rel=0.1)
    assert known(fit, "tangential_stiffness_N_per_mm").value == pytest.approx(167.0, rel=0.07)
    (effect,) = fit.study.effects
    assert effect.name == "free_play"


@pytest.mark.slow
def test_running_in_is_found_where_there_is_one_and_nowhere_else() -> None:
    fit = fitted("running in")
    assert known(fit, "friction_initial").value == pytest.approx(0.45, rel=0.05)
    assert known(fit, "friction_final").value == pytest.approx(0.62, rel=0.05)
    assert known(fit, "friction_cycles").value == pytest.approx(3000.0, rel=0.4)
    assert fit.study.effects != ()
    assert all("friction" in fitted(rig).parameters for rig in ("as stated", "softer", "loose"))


SPRING = "normal_spring_stiffness_N_per_mm"


@pytest.mark.slow
def test_the_spring_that_presses_the_wires_is_that_of_another_codes_test() -> None:
    fit = fitted("as stated")
    assert holds(known(fit, SPRING), 1.0)
    assert fit.study.given()["holder"][SPRING] == pytest.approx(known(fit, SPRING).value, rel=1e-3)
    unknown = [dataclasses.replace(loop, normal_force_N=None) for loop in record_of("as stated").loops]
    assert SPRING not in fit_record(dataclasses.replace(record_of("as stated"), loops=tuple(unknown))).parameters


def test_a_spring_is_distinguished_from_a_drift_and_from_scatter_or_not_at_all() -> None:
    cycles, descent_um = np.array([100.0, 1000.0, 10_000.0, 100_000.0]), np.array([0.6, 2.6, 8.0, 28.0])
    scatter = 0.001 * np.random.default_rng(1).standard_normal((3, 4)) + np.array([[2.02], [2.0], [1.97]])
    found = spring_of_loads(scatter - 1e-3 * 1.4 * descent_um, descent_um, cycles)
    assert found is not None
    assert holds(found, 1.4)
    assert found.repeats == 3
    missing = np.where(np.arange(4) == 1, np.nan, scatter - 1e-3 * 1.4 * descent_um)
    assert spring_of_loads(missing, descent_um, cycles) is not None
    for undecided in (scatter, scatter + 1e-3 * descent_um, scatter - 0.04 * cycles / 1e5, np.full((3, 4), np.nan)):
        assert spring_of_loads(undecided, descent_um, cycles) is None
    # Two cycles have no course.
    assert spring_of_loads(scatter[:, [0, 3]] - 1e-3 * descent_um[[0, 3]], descent_um[[0, 3]], cycles[[0, 3]]) is None


def test_energy_over_a_test_is_the_integral_of_a_power_law() -> None:
    cycles = np.array([1.0, 10.0, 1000.0])
    assert enclosed_energy(cycles, 3.0 * cycles**-0.5) == pytest.approx(6.0 * (np.sqrt(1000.0) - 1.0))
    assert enclosed_energy(cycles, np.full(3, 0.25)) == pytest.approx(0.25 * 999.0)


@pytest.mark.seconds
def test_the_energy_of_a_test_from_its_evolution_is_that_of_its_loops() -> None:
    record = record_of("as stated")
    alone = ExperimentRecord(record.tables, record.loops)
    for repeat in record.repeats:
        energies = [accumulated_energy_J(one, repeat) for one in (record, alone)]
        assert energies[0] == pytest.approx(energies[1], rel=0.02)


@pytest.mark.parametrize("rig", [50.0, 167.0, 1000.0])
def test_a_rigs_stiffness_is_that_of_the_loop_less_that_of_the_contact(rig: float) -> None:
    contact = 2718.0
    _, displacement, force = SyntheticLoop(Recipe(rig_stiffness=rig, contact_stiffness=contact)).sampled(512)
    measured = analyse_loop(displacement, force, 2.0).measured_stiffness_N_per_um
    assert measured is not None
    assert 1e3 / rig_compliance(measured.value, 1e-3 * contact) == pytest.approx(rig, rel=0.03)
    assert rig_compliance(1e-3 * contact, 1e-3 * contact) == 0.0
