"""`wirewear diagnose`: one sentence for every mistake, and a record of a full simulation from end to end."""

import dataclasses
import json
import re
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from tests.diagnosis_cases import record, tables
from tests.effect_studies import COARSE, WEARING, coarse, result_with
from wirewear.effects.tangential_compliance import TangentialCompliance
from wirewear.faces import cli
from wirewear.loops.sensor import Sensor, SensorNoise
from wirewear.records import write_record
from wirewear.records.exporting import record_of_result

#: Enough cycles for loops to be logged at several, on a mesh that is solved within seconds.
SHORT = (
    COARSE.replace("cycles = 1\n", "cycles = 8\n").replace("cycle = 40", "cycle = 28")
    + WEARING
    + "[log]\nloop_cycles = [1, 3, 8]\n"
)

STIFFNESS_N_per_mm = 300.0


def run(*arguments: str | Path) -> Result:
    return CliRunner().invoke(cli, ["diagnose", *map(str, arguments)])


def sentence_of(result: Result) -> str:
    assert result.exit_code == 2, result.output
    assert "Traceback" not in result.output
    return " ".join(result.output.split())


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return write_record(tmp_path / "record", record(repeats=1, evolution=False))


def test_a_folder_without_a_record_is_refused(tmp_path: Path) -> None:
    assert "experiment.toml" in sentence_of(run(tmp_path, "--output", tmp_path / "out"))


def test_a_record_without_friction_is_told_how_to_get_a_model_and_leaves_no_folder(tmp_path: Path) -> None:
    one = record(repeats=1, evolution=False)
    stated = one.tables.stated.model_copy(update={"friction": None, "friction_evolution": None})
    folder = write_record(
        tmp_path / "record", dataclasses.replace(one, tables=one.tables.model_copy(update={"stated": stated}))
    )
    assert "`wirewear fit`) and give the fitted study by --model" in sentence_of(
        run(folder, "--output", tmp_path / "out")
    )
    assert not (tmp_path / "out").exists()


def test_an_effect_to_be_left_out_must_exist(folder: Path, tmp_path: Path) -> None:
    words = sentence_of(run(folder, "--output", tmp_path / "out", "--without", "gremlins"))
    assert "there is no effect 'gremlins' to be left out" in words


def test_a_model_of_another_load_is_refused(folder: Path, tmp_path: Path) -> None:
    model = tmp_path / "model.toml"
    model.write_text(SHORT.replace("normal_load_N = 2.0", "normal_load_N = 3.0").replace("= 20.0\n", "= 60.0\n"))
    words = sentence_of(run(folder, "--output", tmp_path / "out", "--model", model))
    assert "normal_load_N is 3 in the model" in words
    assert "but 2 in the record" in words


def test_a_record_that_states_no_wear_says_what_to_add(tmp_path: Path) -> None:
    one = record(repeats=1, evolution=False)
    stated = tables().stated.model_copy(update={"energy_wear_coefficient_mm3_per_J": None})
    bare = write_record(tmp_path / "bare", type(one)(tables().model_copy(update={"stated": stated}), one.loops))
    words = sentence_of(run(bare, "--output", tmp_path / "out"))
    assert "does not give energy_wear_coefficient_mm3_per_J" in words


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
