"""A run's folder: no other version's result stands for one's own, two never write at once, nothing old stays behind."""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests import synthetic_results
from tests.test_simulate import COARSE, VARIANTS, Recorder, coarse
from tools.house import imports_among, modules_of
from wirewear import RunError, RunResult, Study, run_study, write_result
from wirewear.base import identity
from wirewear.base.identity import CONDENSATION_CODE, PLANAR_CODE, RUN_CODE, Identity, added_code, code_hash, digest
from wirewear.base.locks import LOCK_FILE_NAME, last_noted, occupied
from wirewear.pictures import show
from wirewear.results import RESULT_FILE_NAME, read_results
from wirewear.results.vtk import write_time_series
from wirewear.simulation.folder import RunFolder
from wirewear.simulation.plan import RunPlan
from wirewear.simulation.runs import PICTURES

ROOT = Path(__file__).resolve().parent.parent


class Notes(Recorder):
    """Keeps what the user is told."""

    def __init__(self) -> None:
        super().__init__()
        self.notes: list[str] = []

    def note(self, sentence: str) -> None:
        self.notes.append(sentence)


HOLDER = """
import sys
from pathlib import Path
from wirewear.base.locks import occupied

with occupied(Path(sys.argv[1]), "killed", asked="x"):
    print("held", flush=True)
    sys.stdin.read()
"""


@pytest.fixture(autouse=True)
def simulated(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Labels of the runs that were simulated; each leaves figures made up instead."""
    labels = []

    def run_cycles(plan: RunPlan, folder: RunFolder, observer: object, *, resume: bool) -> RunResult:
        labels.append(plan.label)
        folder.begin()
        made = synthetic_results.result(variant=plan.study.variant_name)
        settings = {**made.settings, "identity": str(plan.identity)}
        folder.write(replace(made, settings=settings, status="complete"))
        return folder.result()

    monkeypatch.setattr("wirewear.simulation.runs.run_cycles", run_cycles)
    return labels


def run(output: Path, study: Study | None = None, *, resume: bool = True) -> list[str]:
    """Run a study in a folder; returns what its user was told."""
    notes = Notes()
    run_study(
        study or coarse(), fidelity="quick", output=output, resume=resume, observer_of=lambda _: nullcontext(notes)
    )
    return notes.notes


def test_a_complete_run_stands_for_itself_only_while_the_code_is_the_same(
    tmp_path: Path, simulated: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert run(tmp_path) == []
    assert run(tmp_path) == []
    assert len(simulated) == 1
    monkeypatch.setattr(identity, "code_hash", lambda _: "of other code")
    (note,) = run(tmp_path)
    assert note == f"{tmp_path} holds this run as another version of the program made it: it is run anew."
    assert len(simulated) == 2
    assert run(tmp_path) == []
    assert len(simulated) == 2


def test_an_interrupted_run_of_other_code_is_not_continued(tmp_path: Path) -> None:
    of = {"study": "one"}
    one, other = Identity(digest(of), "this code"), Identity(digest(of), "other code")
    made = synthetic_results.result()
    write_result(tmp_path / RESULT_FILE_NAME, replace(made, settings={**made.settings, "identity": str(one)}))
    folder = RunFolder(tmp_path, other, write_result)
    assert "another version" in folder.found(begun=False).note
    assert folder.interrupted() is None


def test_a_run_that_was_stopped_before_its_first_result_can_be_resumed_over_anothers(
    tmp_path: Path, simulated: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    other = coarse(COARSE.replace("friction = 0.62", "friction = 0.5"))
    run(tmp_path)
    with pytest.raises(RunError, match="another study"):
        run(tmp_path, other)

    def stopped(*_: object, **__: object) -> RunResult:
        raise KeyboardInterrupt

    with monkeypatch.context() as changed:
        changed.setattr("wirewear.simulation.runs.run_cycles", stopped)
        with pytest.raises(KeyboardInterrupt):
            run(tmp_path, other, resume=False)
    (note,) = run(tmp_path, other)
    assert note == f"{tmp_path} was interrupted before its first result: it is run anew."
    assert len(simulated) == 2


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


def test_a_killed_run_leaves_its_folder_free_and_its_name(tmp_path: Path) -> None:
    with subprocess.Popen(
        [sys.executable, "-c", HOLDER, str(tmp_path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        process.stdout.readline()
        with pytest.raises(RunError, match=f"killed, process {process.pid}"), occupied(tmp_path, "mine"):
            pass
        process.kill()
    assert last_noted(tmp_path)["asked"] == "x"
    with occupied(tmp_path, "mine") as before:
        assert before["what"] == "killed"
    assert last_noted(tmp_path) == {}


def test_nothing_is_left_of_work_that_ends_in_an_error_unless_somebody_can_go_on_with_it(tmp_path: Path) -> None:
    for noted, left in (({}, False), ({"asked": "x"}, True)):
        with pytest.raises(ZeroDivisionError), occupied(tmp_path, "mine", **noted):
            raise ZeroDivisionError
        assert (tmp_path / LOCK_FILE_NAME).exists() is left


def test_the_note_of_a_run_that_was_killed_at_its_very_end_goes(tmp_path: Path, simulated: list[str]) -> None:
    run(tmp_path)
    (tmp_path / LOCK_FILE_NAME).write_bytes(b"left behind")
    run(tmp_path)
    assert not (tmp_path / LOCK_FILE_NAME).exists()
    with occupied(tmp_path, "another"):
        run(tmp_path)
        assert (tmp_path / LOCK_FILE_NAME).exists()
    assert len(simulated) == 1


@pytest.mark.parametrize("damage", [b"", b"{", b"[1]", b"\xff", b'{"what": 1}'])
def test_a_lock_with_anything_in_it_can_be_taken(tmp_path: Path, damage: bytes) -> None:
    (tmp_path / LOCK_FILE_NAME).write_bytes(damage)
    with occupied(tmp_path, "mine") as before:
        assert before == {}


def test_a_complete_run_in_a_folder_that_takes_no_files_is_read(tmp_path: Path, simulated: list[str]) -> None:
    run(tmp_path)
    with occupied(tmp_path, "another"):
        run(tmp_path)
    assert len(simulated) == 1


@pytest.mark.slow
def test_time_series_and_pictures_of_an_older_run_go(tmp_path: Path) -> None:
    run(tmp_path)
    (made,) = read_results(tmp_path)
    write_time_series(made, tmp_path / "vtk")
    drawn = [path for path in show(tmp_path) if path.exists()]
    assert drawn
    mine = tmp_path / "pictures" / "of_my_own.png"
    mine.write_bytes(drawn[0].read_bytes())
    run(tmp_path, coarse(COARSE.replace("friction = 0.62", "friction = 0.5")), resume=False)
    assert not list((tmp_path / "vtk").iterdir())
    assert list((tmp_path / "pictures").iterdir()) == [mine]


def test_a_time_series_holds_its_own_run_alone(tmp_path: Path) -> None:
    made = synthetic_results.result()
    write_time_series(made, tmp_path)
    before = {path.name for path in tmp_path.iterdir()}
    last = made.scar_cycles()[-1]
    fewer = replace(made, scars=tuple(scar for scar in made.scars if scar.cycle == last))
    write_time_series(fewer, tmp_path)
    assert {path.name for path in tmp_path.iterdir()} < before
    assert len(list(tmp_path.glob("*.vtu"))) == 2


@pytest.mark.slow
def test_every_picture_of_a_run_is_known_to_go(tmp_path: Path) -> None:
    run(tmp_path, coarse(COARSE + VARIANTS))
    drawn = {path.relative_to(tmp_path).as_posix() for path in show(tmp_path)}
    known = {path.relative_to(tmp_path).as_posix() for pattern in PICTURES for path in tmp_path.glob(pattern)}
    assert drawn == known


def test_results_are_not_mixed_up_with_other_runs_in_the_same_folder(tmp_path: Path, simulated: list[str]) -> None:
    run(tmp_path, coarse(COARSE + VARIANTS))
    with pytest.raises(RunError, match=r"holds other runs in folders of its own \(compliant, rigid\)"):
        run(tmp_path, resume=False)
    run(tmp_path / "alone")
    run(tmp_path / "alone", coarse(COARSE + VARIANTS), resume=False)
    assert [result.variant for result in read_results(tmp_path / "alone")] == ["compliant", "rigid"]


def closure(graph: dict[str, set[str]], start: str) -> Iterator[str]:
    seen, ahead = {start}, [start]
    while ahead:
        module = ahead.pop()
        yield module
        ahead += sorted(graph[module] - seen)
        seen |= graph[module]


@pytest.mark.parametrize(
    ("start", "code", "left_out"),
    [
        (
            "wirewear.simulation.runs",
            RUN_CODE,
            ("wirewear.base",),
        ),
        (
            "wirewear.planar.run",
            PLANAR_CODE,
            ("wirewear.base", "wirewear.pictures"),
        ),
        ("solvers.condensation", CONDENSATION_CODE, ("solvers",)),
    ],
)
def test_the_code_of_an_identity_is_all_that_the_answer_comes_from(
    start: str, code: tuple[str, ...], left_out: tuple[str, ...]
) -> None:
    packages = [modules_of(ROOT, package) for package in ("geometry", "solvers", "wirewear")]
    modules = {name: file for package in packages for name, file in package.items()}
    graph = imports_among(modules)
    hashed = [ROOT / name for name in code]
    for module in closure(graph, start):
        file = modules[module]
        held = any(file == own or own in file.parents for own in hashed)
        neutral = any(module == name or (name != "solvers" and module.startswith(f"{name}.")) for name in left_out)
        assert held or neutral, f"{module} is missing from the code of {start}"


def test_a_hash_changes_with_any_byte_of_the_code(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "solvers").mkdir()
    file = tmp_path / "solvers" / "jumps.py"
    monkeypatch.setattr(identity, "_ROOT", tmp_path)

    def hashed(text: str) -> str:
        file.write_text(text)
        code_hash.cache_clear()
        return code_hash(("solvers",))

    try:
        assert hashed("x = 1") == hashed("x = 1") != hashed("x = 2")
    finally:
        code_hash.cache_clear()


def test_code_that_is_not_ours_counts_where_its_effects_are_used() -> None:
    class Foreign:
        pass

    assert list(added_code([Foreign(), 1, Identity("a", "b")])) == [__name__]


def test_nested_tables_have_one_digest_whatever_their_order() -> None:
    one: dict[str, Any] = {"a": {"b": 1, "c": (1.0, 2.0)}, "d": "x"}
    assert digest(one) == digest({"d": "x", "a": {"c": [1.0, 2.0], "b": 1}}) != digest({**one, "d": "y"})
