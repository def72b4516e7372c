"""Commands killed, on full disks and without permissions, flipped bits, mutated inputs: a few of each.

The scripts in studies/benchmarks do the same for hours.
"""

import ctypes
import os
import re
import signal
import site
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from random import Random
from typing import Any

import pytest
from click.testing import CliRunner, Result

from studies.benchmarks import flipped_bits, fuzz_inputs, watched_child
from studies.benchmarks.forked_commands import Commands, Ended, Hardship
from studies.benchmarks.fuzz_readers import Reader
from studies.benchmarks.hard_pressed import COMMANDS, make_given
from studies.benchmarks.hardships import Scene, tried, undisturbed
from tests.diagnosis_cases import diagnosed, record
from tests.synthetic_results import result
from tests.test_simulate import coarse
from wirewear import (
    ResultError,
    WirewearError,
    read_result,
    run_study,
    write_result,
)
from wirewear.diagnosis import write_diagnosis
from wirewear.faces import cli
from wirewear.simulation import Observer

ROOT = Path(__file__).resolve().parent.parent

# In a process of its own, so that what dies with it takes no other test along.
KILLED = """
from tests.test_broken_commands import Silent, killed, killed_maker
from wirewear.base.engine import results_of
from wirewear.base.engine import LocalProcesses
from wirewear.base.errors import WirewearError
from wirewear.simulation.together import run_side_by_side
engine = LocalProcesses(1)
for begin in (lambda: run_side_by_side([killed], [Silent()], engine), lambda: results_of(engine, [killed_maker])):
    try:
        begin()
    except WirewearError as error:
        print(type(error).__name__, error)
"""

#: A library that a package brought with it.
OPENBLAS = next(Path(site.getsitepackages()[0]).glob("scipy.libs/lib*openblas*.so"))


def told(ended: Result) -> str:
    assert ended.exit_code == 2, ended.output
    assert "Traceback" not in ended.output
    (sentence,) = ended.stderr.strip().splitlines()[-1:]
    assert sentence.startswith("wirewear: ")
    return sentence


def killed(_observer: Observer) -> str:
    os.kill(os.getpid(), signal.SIGKILL)
    return "never"


def killed_maker() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


class Silent:
    """Watches nothing."""

    def __getattr__(self, _name: str) -> Any:
        return lambda *_: None


@pytest.mark.slow
def test_a_killed_worker_is_told_in_one_sentence() -> None:
    ended = subprocess.run([sys.executable, "-c", KILLED], cwd=ROOT, capture_output=True, text=True, check=False)
    run, batch = ended.stdout.splitlines()
    ended_outside = "was ended from outside, perhaps because memory ran out"
    assert run.startswith("RunError ")
    assert f"{ended_outside}: --resume goes on" in run
    assert batch.startswith("LostTaskError ")
    assert f"{ended_outside}: the same command" in batch


@pytest.mark.slow
def test_a_full_disk_at_the_end_of_a_diagnosis_is_one_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> Path:
        raise OSError(28, "No space left on device")

    found = diagnosed(record(repeats=1, evolution=False, normal=False))
    monkeypatch.setattr("wirewear.views.diagnosis_page.write_text", full)
    with pytest.raises(ResultError, match=r"^cannot write the diagnosis to .*: no space left on device\.$"):
        write_diagnosis(found, tmp_path / "out")


@pytest.mark.slow
def test_a_full_disk_at_a_checkpoint_says_how_to_go_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Version 8318817 ended with a segmentation fault."""

    def full(*_: object) -> Path:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("wirewear.simulation.checkpoint.write_bytes", full)
    with pytest.raises(ResultError) as refused:
        run_study(coarse(), fidelity="quick", output=tmp_path)
    assert str(refused.value) == (
        f"cannot write the checkpoint {tmp_path / 'checkpoint.h5'}: no space left on device; --resume goes on once it "
        "can be written."
    )
    assert read_result(tmp_path).status == "running"


def test_a_folder_that_cannot_be_entered_is_one_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def forbidden(self: Path, *_: object, **__: object) -> bool:
        raise PermissionError(13, "Permission denied", str(self))

    write_result(tmp_path / "result.h5", result())
    monkeypatch.setattr(Path, "is_dir", forbidden)
    ended = CliRunner().invoke(cli, ["show", str(tmp_path / "result.h5")])
    assert told(ended).endswith("can be neither read nor written: permission denied.")


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (["diagnose", "r", "--output", "o"], "interrupted; nothing was written."),
        (["run", "s.toml"], "interrupted; --resume goes on from the last checkpoint."),
        (["converge", "s.toml"], "interrupted; the same command goes on."),
        (["sweep", "s.toml"], "interrupted; the same command goes on."),
        (["import", "m.toml", "--output", "o"], "interrupted; no file is left half written."),
    ],
)
def test_each_command_says_what_its_interruption_leaves(
    monkeypatch: pytest.MonkeyPatch, command: list[str], words: str
) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("wirewear.records.read_record", interrupted)
    monkeypatch.setattr("wirewear.kinds.load_any_study", interrupted)
    monkeypatch.setattr("wirewear.sweeps.load_sweep", interrupted)
    monkeypatch.setattr("wirewear.records.importing.import_record", interrupted)
    ended = CliRunner().invoke(cli, command)
    assert ended.exit_code == 130
    assert ended.stderr.strip().endswith(f"wirewear: {words}")


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Scene]:
    """A folder with what commands read, and the process that starts them."""
    with Commands() as commands:
        made = Scene(tmp_path_factory.mktemp("hardships"), commands, Random(5))
        make_given(commands, made.given, made.cache)
        yield made


@pytest.mark.slow
@pytest.mark.parametrize("name", ["run", "planar", "import", "export"])
def test_nothing_is_lost_or_wrong_after_kills_full_disks_and_lost_permissions(scene: Scene, name: str) -> None:
    (command,) = (one for one in COMMANDS if one.name == name)
    expected = undisturbed(scene, command)
    for what, trials in {"kills": 2, "full": 1, "denied": 1}.items():
        assert list(tried(scene, command, expected, what, range(trials))) == []
    # A command takes longer at one time than at another: it may have ended before each of its kills.
    later = iter(range(2, 30))
    while not scene.tally[f"{name}, kills: killed"] + scene.tally[f"{name}, kills with an empty cache: killed"]:
        assert list(tried(scene, command, expected, "kills", [next(later)])) == []


@pytest.mark.slow
def test_a_command_under_hardship_is_a_process_of_its_own_that_meets_it(scene: Scene, tmp_path: Path) -> None:
    whole = scene.commands.run(tmp_path, ("effects",), tmp_path / "cache")
    assert (whole.status, whole.errors) == (0, "")
    unknown = scene.commands.run(tmp_path, ("check", "none"), tmp_path / "cache")
    assert unknown.sentence
    ended = scene.commands.run(tmp_path, ("effects",), tmp_path / "cache", Hardship(kill_after_s=0.0), whole=True)
    assert ended.status == -signal.SIGKILL
    (tmp_path / "closed").mkdir(mode=0o000)
    denied = scene.commands.run(tmp_path, ("check", "closed"), tmp_path / "cache", Hardship(common=True))
    assert denied.sentence
    assert denied.errors.endswith("Path 'closed' is not readable.\n")


@pytest.mark.slow
def test_no_flipped_bit_of_any_kind_of_file_changes_an_answer_without_a_word() -> None:
    counts = flipped_bits.run(flips=20, seed=6)
    assert {how for _, how in counts} <= {"refused", "left out", "told", "the same"}
    assert len({kind for kind, _ in counts}) == 24


def test_a_changed_answer_and_a_traceback_are_found_out(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_bytes(b"1")

    def ended(read: flipped_bits.Kind, data: bytes) -> str:
        return flipped_bits.how_it_ended(read, flipped_bits.spelled("1"), tmp_path, data)

    plain = flipped_bits.Kind("a.txt", lambda at: (at / "a.txt").read_text())
    assert [ended(plain, data) for data in (b"1", b"2", b"\xff")] == [
        *("the same", "ANOTHER ANSWER", "TRACEBACK UnicodeDecodeError"),
    ]

    def refuse(_folder: Path) -> object:
        raise WirewearError("no.\nno.")

    assert ended(flipped_bits.Kind("a.txt", refuse), b"1") == "NO SENTENCE"


@pytest.mark.slow
def test_mutants_of_every_input_are_read_or_refused_in_a_sentence() -> None:
    # In a process of its own: threads of libraries do not survive the forks.
    ended = subprocess.run(
        [sys.executable, "-m", "studies.benchmarks.fuzz_inputs", "--seed", "3", "--count", "250"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert sum(int(count) for count in re.findall(r" read (\d+)", ended.stdout)) > 30
    assert len(re.findall(r"^.*; at most ", ended.stdout, re.MULTILINE)) == 47


def load_by_name() -> object:
    return __import__("pickle").loads(b"cos\ngetcwd\n.")


@pytest.mark.parametrize(
    ("deed", "found"),
    [
        (lambda at: (at / "elsewhere.txt").write_text(""), "open "),
        (lambda at: (at / "elsewhere").mkdir(), "os.mkdir "),
        (lambda _: os.system("true"), "os.system "),
        (lambda _: load_by_name(), "pickle.find_class "),
        (lambda at: (at / "out.txt").write_text(""), None),
        (lambda _: getattr(ctypes.CDLL(None), "mknod")(b"unseen.txt", 0o100644, 0), "unseen.txt "),  # noqa: B009
        (lambda at: (at / "given.txt").read_bytes(), None),
        (lambda _: ctypes.CDLL("libm.so.6"), "ctypes.dlopen "),
        (lambda _: ctypes.CDLL(str(OPENBLAS)), None),
    ],
)
def test_a_reader_that_does_what_it_was_not_asked_to_is_found_out(
    tmp_path: Path, deed: object, found: str | None
) -> None:
    assert callable(deed)
    reader = Reader({}, (), deed, ("out.txt",), usual=frozenset({"ctypes.dlopen (None,)"}))
    ending = fuzz_inputs.ended(reader, {"given.txt": b"1"}, tmp_path)
    assert ending.how == "read"
    assert ending.wrong is None if found is None else str(ending.wrong).startswith(f"not asked for: {found}")


def wait_for_ever(_folder: Path) -> object:
    time.sleep(1000.0)
    return None


def work_for_ever(_folder: Path) -> object:
    while True:
        pass


@pytest.mark.slow
@pytest.mark.parametrize(("read", "most_wait_s"), [(work_for_ever, 180.0), (wait_for_ever, 1.0)])
def test_a_reader_that_hangs_is_found_out_also_on_a_busy_machine(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, read: Callable[[Path], object], most_wait_s: float
) -> None:
    monkeypatch.setattr(watched_child, "LONGEST_s", 1.0)
    monkeypatch.setattr(watched_child, "MOST_WAIT_s", most_wait_s)
    ending = fuzz_inputs.ended(Reader({}, (), read), {}, tmp_path)
    assert ending.how == "hang"
    assert "s on the processor" in str(ending.wrong) or "no end after 1 s" in str(ending.wrong)


def test_a_reader_that_dies_or_takes_too_much_memory_is_found_out(tmp_path: Path) -> None:
    def die(_folder: Path) -> object:
        os.kill(os.getpid(), signal.SIGUSR1)
        return None

    assert fuzz_inputs.ended(Reader({}, (), die), {}, tmp_path).wrong == "ended by SIGUSR1"
    greedy = fuzz_inputs.ended(Reader({}, (), lambda _: bytearray(watched_child.MOST_BYTES)), {}, tmp_path)
    assert str(greedy.wrong).startswith("MemoryError")


def test_what_stands_in_for_a_part_of_the_program_goes_again() -> None:
    reader = Reader({}, (), lambda _: None, stand_ins={"studies.benchmarks.watched_child:MOST_BYTES": 1})
    with fuzz_inputs.stood_in_for(reader):
        assert watched_child.MOST_BYTES == 1
    assert watched_child.MOST_BYTES > 1
    held = Reader({}, (), lambda _: None, stand_ins={"studies.benchmarks.forked_commands:Ended.sentence": True})
    with fuzz_inputs.stood_in_for(held):
        assert Ended(1, "", 0.0).sentence
    assert not Ended(1, "", 0.0).sentence


def test_a_reader_that_fails_otherwise_is_found_out(tmp_path: Path) -> None:
    def wrong(_folder: Path) -> object:
        raise ZeroDivisionError("division by zero")

    reader = Reader({"a.txt": b"some words"}, ("a.txt",), wrong)
    ending = fuzz_inputs.ended(reader, {"a.txt": b""}, tmp_path)
    assert ending.how == "traceback"
    assert str(ending.wrong).startswith("ZeroDivisionError: division by zero (test_broken_commands.py line ")
    first, again = (fuzz_inputs.mutant(reader, 1, 7) for _ in range(2))
    assert first == again
    assert len({fuzz_inputs.mutant(reader, 1, index)["a.txt"] for index in range(50)}) > 30
