"""A lag of either channel: loops are parted in opposite directions, and the channel is named."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.diagnosis_cases import diagnosed, nominal, record, states
from wirewear.base.errors import StudyError
from wirewear.diagnosis import Diagnosis
from wirewear.diagnosis.model.forward import simulate
from wirewear.diagnosis.model.readings import late_forces
from wirewear.diagnosis.model.setup import Array
from wirewear.diagnosis.observe.evolution import loop_area
from wirewear.effects import effects_of_tables, tables_of_effects
from wirewear.effects.sensor_lag import SensorLag
from wirewear.loops.sensor import Sensor
from wirewear.loops.signals import LoopSignals
from wirewear.records import ExperimentRecord
from wirewear.views.diagnosis_page import ten_lines

LAG_s = 0.006


def read_by(sensor: Sensor, one: ExperimentRecord) -> ExperimentRecord:
    """What a sensor makes of loops that are known already."""
    return replace(one, loops=tuple(loop.read_as(sensor.read(loop.signals())) for loop in one.loops))


@cache
def lagging(channel: str) -> Diagnosis:
    sensor = Sensor(force_lag_s=LAG_s) if channel == "force" else Sensor(lag_s=LAG_s)
    return diagnosed(read_by(sensor, record(evolution=False, drive="stroke"))).diagnosis


@pytest.mark.slow
@pytest.mark.parametrize("channel", ["force", "displacement"])
def test_the_channel_that_lags_is_named_with_its_time(channel: str) -> None:
    """The readings are a filter's, the diagnosis knows a turned phase."""
    answer = lagging(channel)
    assert answer.verdict == "explained"
    table = answer.to_json()["causes"][0]
    assert (table["effect"], table["channel"]) == ("sensor_lag", channel)
    assert answer.causes[0].parameters["time_s"].value == pytest.approx(LAG_s, rel=0.15)
    assert f"sensor lag ({channel})" in answer.sentence
    assert f"sensor lag ({channel})" in ten_lines(answer)


def test_both_channels_late_by_as_much_enclose_the_area_that_none_does() -> None:
    at = np.array([1000.0])

    def area(*channels: str) -> float:
        setup = nominal()
        for channel in channels:
            setup = setup.with_effect(SensorLag(time_s=0.001, channel=channel))
        course = simulate(states(), setup, at)
        return float(loop_area(course.displacement_um, course.tangential_force_N)[0])

    either = abs(area("displacement") - area())
    assert abs(area("displacement", "force") - area()) < 0.05 * either
    assert area("displacement") - area() == pytest.approx(area() - area("force"), rel=0.1)


def test_a_sensor_whose_force_lags_reads_it_late_and_can_be_undone() -> None:
    time = np.arange(400) / 400
    truth = LoopSignals(time, 60.0 * np.sin(2.0 * np.pi * time), np.cos(2.0 * np.pi * time))
    sensor = Sensor(force_lag_s=0.01, lag_kind="delay")
    read = sensor.read(truth)
    assert read.tangential_force_N == pytest.approx(np.cos(2.0 * np.pi * (time - 0.01)))
    assert read.displacement_um == pytest.approx(truth.displacement_um)
    assert sensor.corrected(read).tangential_force_N == pytest.approx(truth.tangential_force_N)


def test_a_study_says_which_channel_lags() -> None:
    tables = [{"name": "sensor_lag", "time_s": 0.001, "channel": "force"}]
    assert tables_of_effects(effects_of_tables(tables)) == tables
    usual = [{"name": "sensor_lag", "time_s": 0.001}]
    assert tables_of_effects(effects_of_tables([{**usual[0], "channel": "displacement"}])) == usual
    with pytest.raises(StudyError, match=r'channel of sensor_lag is .*, but must be "displacement" or "force"'):
        SensorLag(time_s=0.001, channel="both")


def test_the_fast_model_filters_forces_as_a_sensor_does() -> None:
    """The filter in closed form between points of a branch, against the Fourier series of the sensor."""
    lag, points = 0.2, 400
    branch = np.sin(0.5 * np.pi * np.linspace(-1.0, 1.0, points))
    phase = np.stack([np.arcsin(branch), np.pi + np.arcsin(branch)])

    def force(at: Array) -> Array:
        return np.asarray(np.tanh(3.0 * np.cos(at - 0.5)) + 0.2 * np.sin(3.0 * at))

    late = late_forces(force(phase)[None], np.stack([branch, -branch])[None], np.array([lag]))[0]
    time = np.arange(4096) / 4096
    even = LoopSignals(time, time, force(2.0 * np.pi * time))
    expected = Sensor(force_lag_s=lag / (2.0 * np.pi)).read(even).tangential_force_N
    at = np.mod(phase, 2.0 * np.pi) / (2.0 * np.pi)
    assert late == pytest.approx(np.interp(at, np.append(time, 1.0), np.append(expected, expected[0])), abs=1e-4)


def test_branches_that_solvers_part_lie_as_a_lag_of_that_phase_would_have_them() -> None:
    """So far apart solvers are expected to be: a lag below it cannot be told from them."""
    at, setup = np.array([1000.0]), nominal()
    phase = 0.01
    late = simulate(states(), setup.with_effect(SensorLag(time_s=phase / (2.0 * np.pi * setup.frequency_Hz))), at)
    apart = simulate(states(), replace(setup, apart=phase), at)
    together = simulate(states(), setup, at)
    assert apart.displacement_um == pytest.approx(late.displacement_um)
    assert np.abs(apart.displacement_um - together.displacement_um).max() > 0.3
