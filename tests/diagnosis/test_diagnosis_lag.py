"""A lag of either channel: loops are parted in opposite directions, and the channel is named."""

import json
import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.arrays import Array
from tests.browser import page_faults
from tests.diagnosis.diagnosis_cases import diagnosed, nominal, record, states, with_effect
from tests.studies import COARSE, WEARING, coarse, result_with
from wirewear.app.cli import cli
from wirewear.diagnosis import Diagnosis
from wirewear.diagnosis.observe.measured_loops import harmonics_of, motion_of, reduced_loop
from wirewear.diagnosis.observe.reduction import reduce
from wirewear.diagnosis.record_diagnosis import Diagnosed
from wirewear.diagnosis.surrogate.forward import simulate
from wirewear.diagnosis.surrogate.loop_states import SINE, FastMotion
from wirewear.diagnosis.surrogate.sensed_loops import late_forces, late_places
from wirewear.effects.holder import TangentialCompliance
from wirewear.loops import LoopSignals, Sensor, SensorNoise
from wirewear.records import ExperimentRecord, MeasuredLoop, record_of_result, write_record
from wirewear.views.diagnosis_page import residuals, ten_lines

COUPLING = "displacement_load_coupling"
LAG = 0.03
LAG_s = 0.006


def leaning(linear: float, quadratic: float = 0.0) -> ExperimentRecord:
    """A record of a rigid holder and an imposed stroke whose reading then follows the force as well."""
    plain = record(stiffness_N_per_mm="rigid", drive="stroke", evolution=False)
    loops = [
        replace(
            loop,
            displacement_um=loop.displacement_um
            + linear * loop.tangential_force_N
            + quadratic * loop.tangential_force_N**2,
        )
        for loop in plain.loops
    ]
    return replace(plain, loops=tuple(loops))


@pytest.mark.slow
@pytest.mark.parametrize("linear", [-5.0, -3.2, -1.2])
def test_load_coupling_is_named_whether_or_not_the_reading_runs_back(linear: float) -> None:
    answer = diagnosed(leaning(linear, -0.1 * linear)).diagnosis
    assert answer.verdict == "explained"
    assert answer.causes[0].effect == COUPLING
    found = answer.causes[0].parameters["linear_um_per_N"]
    assert found.interval95[0] <= linear <= found.interval95[1]
    assert found.value == pytest.approx(linear, rel=0.1)


def test_the_branches_of_a_reading_that_runs_back_begin_at_the_reversal() -> None:
    one = leaning(-3.2)
    for loop in one.loops:
        for branch in reduced_loop(loop, one.tables.noise, 2.0).branches:
            assert branch.force_N[0] < -0.5 * branch.force_N.max()
            assert branch.displacement_um[branch.knee] < branch.displacement_um[0] - 4.0


@settings(max_examples=12, deadline=None)
@given(linear=st.floats(-12.0, 8.0), quadratic=st.floats(-1.5, 1.5), cycles=st.sampled_from([100.0, 10_000.0, 1e5]))
def test_a_drive_that_holds_a_reading_holds_its_whole_extent(linear: float, quadratic: float, cycles: float) -> None:
    values = {"linear_um_per_N": linear, "quadratic_um_per_N2": quadratic}
    setup = with_effect(nominal("sensor"), COUPLING, values)
    x = simulate(states(), setup, np.array([cycles])).displacement_um
    np.testing.assert_allclose(0.5 * (x.max() - x.min()), setup.amplitude_um, rtol=2e-3)


def triangle(phase: Array) -> Array:
    return np.asarray(2.0 / np.pi * np.arcsin(np.sin(phase)))


def found_motion(shape: Array, noise: float, loops: int = 24) -> FastMotion:
    """The motion found from loops of one cycle each, which begin anywhere."""
    random, samples = np.random.default_rng(4), shape.size
    time = np.arange(samples) / samples
    found = []
    for _ in range(loops):
        noisy = np.roll(shape, int(random.integers(samples))) + noise * random.standard_normal(samples)
        found.append(harmonics_of(time, 1.0, noisy))
    return motion_of(found, noise * float(np.sqrt(2.0 / (samples - 2.0 * found[0].size - 1.0))))


def branches() -> Array:
    """Places of both branches (1, 2, m)."""
    there = np.sin(0.5 * np.pi * np.linspace(-1.0, 1.0, 41))
    return np.stack([there, -there])[None]


def phases(samples: int = 400) -> Array:
    return np.asarray(2.0 * np.pi * np.arange(samples) / samples)


def test_a_sines_lag_turns_its_phase() -> None:
    place, turn = branches(), np.arctan(LAG)
    expected = np.sin(np.stack([np.arcsin(place[0, 0]), np.pi - np.arcsin(place[0, 1])]) - turn)
    assert late_places(nominal("sensor"), place, LAG)[0] == pytest.approx(expected, abs=1e-4)
    assert late_places(nominal("stroke"), place, LAG)[0] == pytest.approx(np.cos(turn) * expected, abs=1e-4)
    assert SINE.phases(place)[0, 0] == pytest.approx(2.0 * np.pi + np.arcsin(place[0, 0]), abs=1e-9)


def test_a_triangles_lag_is_found_from_what_the_late_sensor_reads() -> None:
    """In closed form: x less v τ (1 − 2 exp(−t/τ)) at times t after a reversal; its stroke shrinks by v τ ln 2."""
    spectrum = np.fft.rfft(triangle(phases(4096)))
    late = np.fft.irfft(spectrum / (1.0 + 1j * LAG * np.arange(spectrum.size)), 4096)
    motion = found_motion(np.interp(phases(), phases(4096), late), 0.002)
    before = motion.before(LAG)
    after = before.behind(LAG)
    place, speed = branches(), 2.0 / np.pi
    since = 0.5 * np.pi * (place[0, 0] + 1.0)
    change = (after.at(before.phases(place)) - before.at(before.phases(place))) / before.half_range
    assert change[0, 0] == pytest.approx(-speed * LAG * (1.0 - 2.0 * np.exp(-since / LAG)), abs=2.5e-3)
    assert after.half_range / before.half_range == pytest.approx(1.0 - speed * LAG * np.log(2.0), abs=1e-3)


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
    assert f"sensor lag ({channel})" in answer.sentence.lower()
    assert f"sensor lag ({channel})" in ten_lines(answer).lower()


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


LAST = 100_000
#: Enough cycles for loops to be logged at several, on a mesh that is solved within seconds.
SHORT = (
    COARSE.replace("cycles = 1\n", "cycles = 8\n").replace("cycle = 40", "cycle = 28")
    + WEARING
    + "[log]\nloop_cycles = [1, 3, 8]\n"
)
STIFFNESS_N_per_mm = 300.0


def bumped(loop: MeasuredLoop) -> MeasuredLoop:
    """A loop whose force is 0.4 N higher in size about 20 µm."""
    force = loop.tangential_force_N
    more = 0.4 * np.exp(-(((loop.displacement_um - 20.0) / 8.0) ** 2)) * np.sign(force)
    return replace(loop, tangential_force_N=force + more)


def left_of(one: Diagnosed, force_N: float = 0.0, slope: float = 1.0) -> list[dict[str, np.ndarray]]:
    """What is left of the last loop of its best explanation, whose force is stretched and shifted first."""
    course = simulate(one.states, one.search.best.setup, np.array([float(LAST)]))
    changed = replace(course, tangential_force_N=slope * course.tangential_force_N + force_N)
    loops = tuple(loop for loop in one.observed.loops if loop.cycle == LAST)
    return residuals(loops, changed, 0, one.search.covariance.scatter, one.setup.load_N)


@pytest.mark.slow
def test_of_the_right_model_what_is_left_lies_within_the_band() -> None:
    for branch in left_of(diagnosed(record(repeats=2, evolution=False))):
        assert np.mean(np.abs(branch["force_N"]) < branch["band_N"]) > 0.9
        assert 0.01 < branch["band_N"].mean() < 0.2


@pytest.mark.slow
def test_a_force_that_is_higher_at_a_place_stands_out_of_the_band_there_alone() -> None:
    plain = record(repeats=3, scatter=0.3, evolution=False)
    raised = replace(plain, loops=tuple(bumped(loop) for loop in plain.loops))
    forward, _ = left_of(replace(diagnosed(plain), observed=reduce(raised)))
    places = forward["displacement_um"][(np.abs(forward["force_N"]) > 1.5 * forward["band_N"])]
    assert 5.0 < places.min() < 20.0 < places.max() < 35.0


def run(*arguments: str | Path) -> Result:
    return CliRunner().invoke(cli, ["diagnose", *map(str, arguments)])


def sentence_of(result: Result) -> str:
    assert result.exit_code == 2, result.output
    assert "Traceback" not in result.output
    return " ".join(result.output.split())


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return write_record(tmp_path / "record", record(repeats=1, evolution=False))


def test_a_model_of_another_load_is_refused(folder: Path, tmp_path: Path) -> None:
    model = tmp_path / "model.toml"
    model.write_text(SHORT.replace("normal_load_N = 2.0", "normal_load_N = 3.0").replace("= 20.0\n", "= 60.0\n"))
    words = sentence_of(run(folder, "--output", tmp_path / "out", "--model", model))
    assert "normal_load_N is 3 in the model" in words
    assert "but 2 in the record" in words


@pytest.mark.slow
def test_a_compliance_in_a_full_simulation_is_found_and_confirmed(tmp_path: Path) -> None:
    result = result_with(TangentialCompliance(stiffness_N_per_mm=STIFFNESS_N_per_mm), text=SHORT)
    sensor = Sensor(noise=SensorNoise(0.05, 0.004, 0.005))
    folder = write_record(tmp_path / "record", record_of_result(result, sensor=sensor, repeats=3, seed=4))
    model = tmp_path / "model.toml"
    model.write_text(SHORT)
    finished = run(folder, "--output", tmp_path / "out", "--model", model, "--confirm", "--jobs", "1")
    assert finished.exit_code == 0, finished.output
    answer = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    page = (tmp_path / "out" / "report.html").read_text()
    assert page_faults(tmp_path / "out" / "report.html") == []
    assert answer["verdict"] == "explained"
    assert any({"tangential_compliance", "rotational_compliance"} <= set(group) for group in answer["equivalent"])
    (cause,) = (one for one in answer["causes"] if one["effect"] == "tangential_compliance")
    assert cause["parameters"]["stiffness_N_per_mm"]["value"] == pytest.approx(STIFFNESS_N_per_mm, rel=0.1)
    assert answer["gap"]["confirmed"]["shrink"] == pytest.approx(answer["gap"]["predicted_shrink"], abs=0.05)
    assert re.findall(r"(?:src|href)=[\"'](?!data:|#)[^\"']*", page) == []
    assert coarse(SHORT).effects == ()
