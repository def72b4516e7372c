"""The fast forward model against closed forms."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from geometry.arrays import Array
from studies.blind.generators.independent.friction import LAWS
from tests.diagnosis_cases import diagnosed, nominal, record, states, with_effect
from tests.test_diagnosis_covariance import layout
from tests.worked_examples import install_example
from wirewear.diagnosis.model.candidates import library
from wirewear.diagnosis.model.forward import simulate
from wirewear.diagnosis.model.loop_states import FULL_SLIP
from wirewear.diagnosis.model.readings import KNEE, MIDDLE
from wirewear.diagnosis.model.setup import Setup
from wirewear.diagnosis.observe.evolution import loop_area
from wirewear.diagnosis.observe.observable import ModelLoops, Scale
from wirewear.diagnosis.observe.reduction import _all_observables, reduce
from wirewear.records import ExperimentRecord, RecordTables

FORCE_N = 1.24  #: µP of the first loops, before the scar lends them slopes.

FIRST = np.array([2.0])


def test_each_predicts_sizes_and_places_every_number_that_it_lists() -> None:
    whole = layout()
    course = simulate(states(), nominal(), whole.cycles)
    loops = ModelLoops(nominal(), course)
    for part in whole:
        one, count = part.observable, len(part.sites)
        predicted = one.predict(course, part.sites)
        assert predicted.shape == one.solver_error(loops, part.sites).size.shape == (count,)
        assert one.free_size(nominal(), predicted).shape == (count,)
        assert set(one.zone(part.sites, 60.0)) <= {zone.name for zone in one.zones}
        assert one.smoothness(part.sites, Scale(60.0, 1.24)).along.shape == (count,)


def test_what_is_measured_of_the_models_own_loops_is_what_it_predicts() -> None:
    observed = reduce(record(repeats=1, scatter=0.0, samples=400))
    predicted = observed.layout.observed(simulate(states(), nominal("sensor"), observed.layout.cycles))
    size = np.sqrt(observed.noise[0] ** 2 + (observed.common**2).sum(axis=1))
    for part in observed.layout:
        away = (observed.values[0] - predicted)[part.rows] / size[part.rows]
        assert np.sqrt(np.mean(away**2)) < 3.0, part.observable.name


def test_the_worked_example_of_the_docs_measures_what_it_predicts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    example = install_example("An observable", tmp_path, monkeypatch)
    own = [one for one in _all_observables.__wrapped__() if one.name == example.name]
    observed = reduce(record(repeats=1, scatter=0.0, samples=400), own)
    predicted = observed.layout.observed(simulate(states(), nominal("sensor"), observed.layout.cycles))
    assert predicted.size > 3
    assert np.sqrt(np.mean(((observed.values[0] - predicted) / observed.noise[0]) ** 2)) < 3.0
    assert set(observed.layout.zones(60.0)) == {example.name}


def stating(one: ExperimentRecord, **changes: object) -> ExperimentRecord:
    """The record with other entries in its tables; those of `stated` are added."""
    data = one.tables.model_dump(exclude_none=True, exclude_unset=True)
    for key, value in changes.items():
        data[key] = {**data.get(key, {}), **value} if isinstance(value, dict) else value
    return replace(one, tables=RecordTables.model_validate(data))


@pytest.mark.slow
def test_a_wide_scatter_that_is_stated_makes_a_difference_of_its_size_no_gap() -> None:
    """A friction 6 % off is a gap to a laboratory that repeats within 1 %, and none to one that scatters by 5 %."""
    one = record({"friction_offset": {"friction": 0.66}}, repeats=1, seed=2)
    close = diagnosed(stating(one, scatter={"friction": 0.01})).diagnosis
    wide = diagnosed(stating(one, scatter={"friction": 0.06})).diagnosis
    assert close.verdict != "no_gap"
    assert wide.verdict == "no_gap"
    assert np.isfinite(close.shrink.before)


def areas(setup: Setup, cycles: Array = FIRST) -> Array:
    course = simulate(states(), setup, cycles)
    return loop_area(course.displacement_um, course.tangential_force_N)


def test_a_spring_takes_its_share_of_the_energy() -> None:
    one, other = nominal(), replace(nominal(), compliance_um_per_N=nominal().compliance_um_per_N + 5.0)
    assert areas(one)[0] - areas(other)[0] == pytest.approx(4e-3 * 5.0 * FORCE_N**2, rel=0.02)


@pytest.mark.parametrize("softer", [0.0, 0.5, 1.0])
def test_a_softer_knee_encloses_what_the_books_say(softer: float) -> None:
    setup = replace(nominal(), compliance_um_per_N=0.0, micro_slip=softer)
    course = simulate(states(), setup, FIRST)
    assert areas(setup)[0] == pytest.approx(course.energy_mJ[0], rel=2e-3)


def test_micro_slip_of_another_order_is_that_of_iwans_spread_thresholds() -> None:
    setup = replace(nominal(), compliance_um_per_N=0.0, micro_slip=float(np.log(2.5 / FULL_SLIP)))
    course = simulate(states(), setup, FIRST)
    x, q = course.displacement_um[0, 0, : KNEE + 1], course.tangential_force_N[0, 0, : KNEE + 1]
    share, travel = (q - q[0]) / (q[-1] - q[0]), (x - x[0]) / (x[-1] - x[0])
    assert share == pytest.approx(LAWS["iwan"].share(2.5 * travel), abs=1e-6)


def test_walls_lift_the_wires_against_the_spring_that_presses_them() -> None:
    """The load at a place is that in mid-stroke and the spring's; forces follow it, both branches alike."""
    lifted = replace(states(), lift_N=np.outer(states().load_drop_N, [0.3, 0.1]))
    flat, raised = (simulate(one, nominal(), np.array([1e5])) for one in (states(), lifted))
    end = float(raised.normal_force_N[0, 0, -1] - raised.normal_force_N[0, 0, MIDDLE])
    drop = nominal().load_N - float(raised.normal_force_N[0, 0, MIDDLE])
    assert end == pytest.approx(0.4 * drop, rel=0.01)
    assert raised.normal_force_N[0, 0] == pytest.approx(raised.normal_force_N[0, 1])
    ratio = raised.normal_force_N[0, 0, KNEE:] / flat.normal_force_N[0, 0, KNEE:]
    forces = raised.tangential_force_N[0, 0, KNEE:] / flat.tangential_force_N[0, 0, KNEE:]
    assert forces == pytest.approx(ratio, rel=1e-3)


def test_play_takes_twice_its_width_times_the_force() -> None:
    one, other = nominal(), with_effect(nominal(), "free_play", {"gap_um": 4.0})
    assert areas(one)[0] - areas(other)[0] == pytest.approx(2e-3 * 4.0 * FORCE_N, rel=0.03)


@pytest.mark.parametrize(
    "changed",
    [
        with_effect(nominal(), "displacement_load_coupling", {"linear_um_per_N": 4.0, "quadratic_um_per_N2": 0.0}),
        with_effect(nominal(), "displacement_load_coupling", {"linear_um_per_N": 0.0, "quadratic_um_per_N2": 1.0}),
        replace(nominal(), force_offset_N=0.05),
    ],
)
def test_a_reading_that_depends_on_the_force_leaves_the_area(changed: Setup) -> None:
    cycles = np.array([100.0, 1e4])
    assert areas(changed, cycles) == pytest.approx(areas(nominal(), cycles), rel=2e-3)


def test_the_worn_volume_is_the_coefficient_times_the_energy() -> None:
    cycles = np.geomspace(1.0, 1e5, 60)
    course = simulate(states(), nominal(), cycles)
    energy = np.trapezoid(np.append(course.energy_mJ[0], course.energy_mJ), np.append(0.0, cycles))
    assert course.volume_um3[-1] == pytest.approx(30.0 * energy, rel=0.01)


def test_the_drive_holds_the_reading_or_the_true_stroke() -> None:
    gained = with_effect(nominal("sensor"), "displacement_gain", {"gain": 1.05})
    read = simulate(states(), gained, FIRST).displacement_um
    assert 0.5 * np.ptp(read) == pytest.approx(60.0, rel=1e-3)
    read = simulate(states(), replace(gained, drive="stroke"), FIRST).displacement_um
    assert 0.5 * np.ptp(read) == pytest.approx(63.0, rel=1e-3)


@pytest.mark.seconds
def test_every_effect_that_loops_show_moves_an_observable() -> None:
    layout = reduce(record()).layout
    before = layout.observed(simulate(states(), nominal(), layout.cycles))
    for candidate in library(nominal()):
        changed = candidate.applied(nominal(), np.full(len(candidate.unknowns), 1.0))
        after = layout.observed(simulate(states(), changed, layout.cycles))
        moved = float(np.nanmax(np.abs(after - before)))
        assert (moved > 1e-4) == (candidate.name != "crossing_angle_error"), candidate.name
