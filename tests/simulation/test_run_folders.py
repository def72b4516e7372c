"""A run's folder: no other version's result stands for one's own, two never write at once, nothing old stays behind."""

import os
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import pytest

from tests import synthetic_results
from tests.simulation.coarse_runs import COARSE, VARIANTS, Recorder, coarse
from wirewear import RunError, RunResult, Study, run_study, write_result
from wirewear.base import cache
from wirewear.base.cache import Identity, code_hash, digest
from wirewear.base.locks import LOCK_FILE_NAME, occupied
from wirewear.results import RESULT_FILE_NAME, read_results
from wirewear.simulation.point_runs import PointRun
from wirewear.simulation.store import RunFolder

ROOT = Path(__file__).parents[2]


class Notes(Recorder):
    """Keeps what the user reads."""

    def __init__(self) -> None:
        super().__init__()
        self.notes: list[str] = []

    def note(self, sentence: str) -> None:
        self.notes.append(sentence)


@pytest.fixture(autouse=True)
def simulated(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Labels of the runs that were simulated; each leaves figures made up instead."""
    labels = []

    def run_cycles(plan: PointRun, folder: RunFolder, _observer: object, *, resume: bool) -> RunResult:
        labels.append(plan.label)
        folder.begin()
        made = synthetic_results.result(variant=plan.study.variant_name)
        settings = {**made.settings, "identity": str(plan.identity)}
        folder.write(replace(made, settings=settings, status="complete"))
        return folder.result()

    monkeypatch.setattr("wirewear.simulation.runs.run_cycles", run_cycles)
    return labels


def run(output: Path, study: Study | None = None, *, resume: bool = True) -> list[str]:
    """Run a study in a folder; returns what its user read."""
    notes = Notes()
    run_study(
        study or coarse(), fidelity="quick", output=output, resume=resume, observer_of=lambda _: nullcontext(notes)
    )
    return notes.notes


@pytest.mark.seconds
def test_a_complete_run_stands_for_itself_only_while_the_code_is_the_same(
    tmp_path: Path, simulated: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert run(tmp_path) == []
    assert run(tmp_path) == []
    assert len(simulated) == 1
    monkeypatch.setattr(cache, "code_hash", lambda _: "of other code")
    (note,) = run(tmp_path)
    assert note == f"{tmp_path} holds this run as another version of the program made it: it is run again."
    assert len(simulated) == 2
    assert run(tmp_path) == []
    assert len(simulated) == 2


def test_an_interrupted_run_of_other_code_is_not_continued(tmp_path: Path) -> None:
    of = {"study": "one"}
    one, other = Identity(digest(of), "this code"), Identity(digest(of), "other code")
    made = synthetic_results.result()
    write_result(tmp_path / RESULT_FILE_NAME, replace(made, settings={**made.settings, "identity": str(one)}))
    folder = RunFolder(other, tmp_path)
    assert "another version" in folder.found(unfinished=False).note
    assert folder.interrupted() is None


def test_two_runs_at_once_are_refused_by_name(tmp_path: Path, simulated: list[str]) -> None:
    with occupied(tmp_path, "steel wires"), pytest.raises(RunError) as refused:
        run(tmp_path, resume=False)
    who = f"steel wires, process {os.getpid()} on {os.uname().nodename}"
    assert str(refused.value) == (
        f"another command is writing to {tmp_path} ({who}): choose another --output, or wait for its end."
    )
    assert not simulated
    run(tmp_path, resume=False)
    assert not (tmp_path / LOCK_FILE_NAME).exists()


@pytest.mark.seconds
def test_results_are_not_mixed_up_with_other_runs_in_the_same_folder(tmp_path: Path, simulated: list[str]) -> None:
    run(tmp_path, coarse(COARSE + VARIANTS))
    with pytest.raises(RunError, match=r"holds other runs in folders of its own \(compliant, rigid\)"):
        run(tmp_path, resume=False)
    run(tmp_path / "alone")
    run(tmp_path / "alone", coarse(COARSE + VARIANTS), resume=False)
    assert [result.variant for result in read_results(tmp_path / "alone")] == ["compliant", "rigid"]


def test_a_hash_changes_with_any_byte_of_the_code(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "solvers").mkdir()
    file = tmp_path / "solvers" / "jumps.py"
    monkeypatch.setattr(cache, "_ROOT", tmp_path)

    def hashed(text: str) -> str:
        file.write_text(text)
        code_hash.cache_clear()
        return code_hash(("solvers",))

    try:
        assert hashed("x = 1") == hashed("x = 1") != hashed("x = 2")
    finally:
        code_hash.cache_clear()
