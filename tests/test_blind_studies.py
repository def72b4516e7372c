"""Whole batches: what is still to be done, what is kept, and the baseline that knows no mechanics."""

import json
import time
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from studies.blind import Truth, default_key_path, make_batch, score_batch, verified
from studies.blind.answering import DIAGNOSIS, FAILURE, write_json
from studies.blind.batch import diagnosing_tasks, oracle_tasks, run_tasks
from studies.blind.compare import main as compare
from studies.blind.forest import features, label, main, said, trained
from tests.blind_batches import PlainModel
from wirewear import read_record
from wirewear.base.local_processes import LocalProcesses


@pytest.fixture(scope="module")
def records(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("batches") / "records"
    make_batch(folder, cases=30, seed=12, generator=PlainModel())
    return folder


def truths_of(batch: Path) -> tuple[Truth, ...]:
    return verified(batch, default_key_path(batch)).truths


def test_only_records_without_an_answer_are_still_to_be_diagnosed(records: Path, tmp_path: Path) -> None:
    assert len(diagnosing_tasks(records, tmp_path)) == 30
    write_json(tmp_path / "case_003" / DIAGNOSIS, {})
    (tmp_path / "case_005").mkdir()
    (tmp_path / "case_005" / FAILURE).write_text("it has no loops in gross slip.\n")
    names = [task.args[0].name for task in diagnosing_tasks(records, tmp_path)]  # type: ignore[attr-defined]
    assert len(names) == 28
    assert not {"case_003", "case_005"} & set(names)


def test_a_diagnosis_is_told_what_to_leave_out_and_nothing_else(records: Path, tmp_path: Path) -> None:
    cases = json.loads((records / "manifest.json").read_text())["cases"]
    for task in diagnosing_tasks(records, tmp_path):
        record, left_out, diagnoses = task.args  # type: ignore[attr-defined]
        assert (list(left_out), diagnoses) == (cases[record.name]["left_out"], tmp_path)


def test_the_oracle_is_asked_about_known_effects_only(records: Path, tmp_path: Path) -> None:
    asked = {task.args[0].name: task.args[1] for task in oracle_tasks(records, default_key_path(records), tmp_path)}  # type: ignore[attr-defined]
    assert asked == {t.case: t.effects for t in truths_of(records) if t.kind in ("single", "pair")}


def test_no_record_is_begun_when_the_time_is_up() -> None:
    assert run_tasks([], LocalProcesses(1), "nothing", time.monotonic() - 1.0)
    assert not run_tasks([lambda: None], LocalProcesses(1), "something", time.monotonic() - 1.0)


@pytest.mark.slow
def test_a_forest_that_saw_such_records_answers_better_than_the_commonest_answer(records: Path, tmp_path: Path) -> None:
    training = tmp_path / "training"
    make_batch(training, cases=80, seed=11, generator=PlainModel())
    truths = truths_of(records)
    ran = CliRunner().invoke(main, [str(training), str(records), str(tmp_path / "answers")])
    assert ran.exit_code == 0, ran.output
    found = {
        path.parent.name: json.loads(path.read_text()) for path in tmp_path.glob("answers/baselines/random_forest/*/*")
    }
    assert set(found) == {truth.case for truth in truths}
    first = [found[t.case]["causes"][0]["effect"] for t in truths if t.kind in ("none", "single")]
    right = [label(t) for t in truths if t.kind in ("none", "single")]
    share = np.mean(np.array(first) == np.array(right))
    assert share > max(right.count(name) for name in right) / len(right)


def test_what_is_left_out_counts_as_outside_the_library(records: Path) -> None:
    forest = trained(records, truths_of(records)[:20])
    record = read_record(records / "case_021")
    answer = said(forest, record, ())
    every = said(forest, record, [name for name in forest.classes_ if name != "none"])
    assert sum(cause["probability"] for cause in answer["causes"]) == pytest.approx(1.0)
    assert {cause["effect"] for cause in every["causes"]} == {"none", "outside_library"}
    assert np.isfinite(features(record)).all()


def test_a_score_keeps_every_case_and_is_set_beside_others(tmp_path: Path) -> None:
    records = tmp_path / "records"
    make_batch(records, cases=6, seed=1, generator=PlainModel())
    for name in ("case_001", "case_002", "case_004"):
        causes = [{"effect": "friction_offset", "probability": 0.75}]
        write_json(tmp_path / "diagnoses" / name / DIAGNOSIS, {"verdict": "explained", "causes": causes})
    score_batch(records, tmp_path / "diagnoses", key_path=default_key_path(records))
    kept = json.loads((tmp_path / "diagnoses" / "score.json").read_text())
    assert [line["case"] for line in kept["lines"]] == [f"case_{n:03d}" for n in range(1, 7)]
    assert [line["verdict"] for line in kept["lines"]].count(None) == kept["unanswered"] == 3

    beside = CliRunner().invoke(compare, [str(tmp_path / "diagnoses")] * 2)
    assert beside.exit_code == 0, beside.output
    head, _, false_alarms = beside.output.splitlines()[:3]
    assert head == "| figure (95 % interval) | aim of T1 | T2, 6 records | T2, 6 records |"
    alarms = kept["false_alarms"]
    assert f"{alarms['hits']} of {alarms['of']}" in false_alarms
    assert ("✗" in false_alarms) == (alarms["value"] > 0.05)
