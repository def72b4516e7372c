"""From a logger's and a profilometer's files to parameters, comparison and diagnosis: five commands, nothing by hand.

For whole tests the finite element runs are replaced by frozen wear states and the made-up run of the article's test.
A test's first thousand cycles go the same way with the finite elements themselves.
"""

import dataclasses
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from tests import synthetic_results
from tests.frozen_states import frozen_states
from tests.logger_files import write_german
from wirewear.diagnosis.model.wear_states import WearStates
from wirewear.faces import cli
from wirewear.records import ExperimentRecord, read_record
from wirewear.results import RunResult, write_result
from wirewear.study import Study

EXAMPLE = Path(__file__).resolve().parent.parent / "studies/steel_wires/example_records/rigid_stated_compliant_rig"


@pytest.fixture
def _no_elements(monkeypatch: pytest.MonkeyPatch) -> None:
    def run_study(study: Study, *, output: Path, **_options: Any) -> list[RunResult]:
        found = synthetic_results.result("", float(study.holder.tangential_stiffness_N_per_mm))
        found = dataclasses.replace(found, study=study.resolved())
        write_result(output / "result.h5", found)
        return [found]

    nominal = synthetic_results.result("", 167.0)
    monkeypatch.setattr("wirewear.diagnosis.model.nominal.nominal_run", lambda *_: nominal)
    monkeypatch.setattr(WearStates, "of_run", classmethod(lambda *_: frozen_states()))
    monkeypatch.setattr("wirewear.simulation.run_study", run_study)


def imported(write: Callable[[ExperimentRecord, Path], list[Path]]) -> ExperimentRecord:
    """What two commands make of a logger's files of the example, in the folder `record`."""
    files = [path.name for path in write(read_record(EXAMPLE), Path())]
    for command in (
        ["new", "--mapping", *files, "--diameter", "0.45"],
        ["import", "mapping.toml", "--output", "record"],
    ):
        result = CliRunner().invoke(cli, command)
        assert result.exit_code == 0, result.output
    return read_record(Path("record"))


@pytest.mark.slow
@pytest.mark.usefixtures("_no_elements")
def test_five_commands_lead_from_own_files_to_an_answer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    imported(write_german)
    commands = (
        ["fit", "record", "--output", "fitted"],
        ["compare", "fitted/run", "record", "--output", "compared"],
        ["diagnose", "record", "--model", "fitted/study.toml", "--output", "diagnosis"],
    )
    for command in commands:
        result = CliRunner().invoke(cli, command)
        assert result.exit_code == 0, result.output
    fitted = (tmp_path / "fitted" / "study.toml").read_text(encoding="utf-8")
    assert "tangential_stiffness_N_per_mm = 1" in fitted
    assert "loop_cycles = [100, 1000, 10000, 100000]" in fitted
    assert (tmp_path / "compared" / "comparison.html").is_file()
    diagnosis = json.loads((tmp_path / "diagnosis" / "diagnosis.json").read_text(encoding="utf-8"))
    # The owner's rig was rigid in mind only: with the fitted one, little is left to explain.
    assert diagnosis["verdict"] in ("no_gap", "explained", "ambiguous")
    assert all(
        cause["effect"] != "tangential_compliance" or cause["probability"] < 0.5 for cause in diagnosis["causes"]
    )
