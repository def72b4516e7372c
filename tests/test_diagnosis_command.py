"""`wirewear diagnose`: one sentence for every mistake, and a record of a full simulation from end to end."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from tests.diagnosis_cases import diagnosed, record
from tests.studies import COARSE, WEARING, coarse, result_with
from wirewear.diagnosis.model.forward import simulate
from wirewear.diagnosis.observe.reduction import reduce
from wirewear.effects.holder import TangentialCompliance
from wirewear.faces import cli
from wirewear.loops.sensor import Sensor, SensorNoise
from wirewear.records import MeasuredLoop, record_of_result, write_record
from wirewear.views.diagnosis_shown import residuals
from wirewear.views.diagnosis_wording import Diagnosed

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
    model = diagnosed(plain)
    forward, _ = left_of(replace(model, observed=reduce(raised)))
    out = np.abs(forward["force_N"]) > 1.5 * forward["band_N"]
    places = forward["displacement_um"][out]
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
    effect = TangentialCompliance(stiffness_N_per_mm=STIFFNESS_N_per_mm)
    result = result_with(effect, text=SHORT)
    sensor = Sensor(noise=SensorNoise(0.05, 0.004, 0.005))
    folder = write_record(tmp_path / "record", record_of_result(result, sensor=sensor, repeats=3, seed=4))
    model = tmp_path / "model.toml"
    model.write_text(SHORT)
    finished = run(folder, "--output", tmp_path / "out", "--model", model, "--confirm", "--jobs", "1")
    assert finished.exit_code == 0, finished.output
    answer = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    page = (tmp_path / "out" / "report.html").read_text()
    assert answer["verdict"] == "explained"
    assert any({"tangential_compliance", "rotational_compliance"} <= set(group) for group in answer["equivalent"])
    (cause,) = (one for one in answer["causes"] if one["effect"] == "tangential_compliance")
    assert cause["parameters"]["stiffness_N_per_mm"]["value"] == pytest.approx(STIFFNESS_N_per_mm, rel=0.1)
    assert answer["gap"]["confirmed"]["shrink"] == pytest.approx(answer["gap"]["predicted_shrink"], abs=0.05)
    assert re.findall(r"(?:src|href)=[\"'](?!data:|#)[^\"']*", page) == []
    assert coarse(SHORT).effects == ()
