"""Numbers of any length, any text in any field, full disks and lost processes: one sentence each, never a traceback."""

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from io import StringIO
from pathlib import Path
from threading import Thread
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from rich.console import Console

from solvers import plugins
from solvers.errors import SolverError
from solvers.friction_laws import friction_laws
from tests.diagnosis_cases import diagnosed, record
from tests.studies import MINIMAL
from tests.synthetic_results import result
from tests.test_import import GERMAN, german, mapped
from tests.test_import import cycle as cycle_of
from tests.test_simulate import coarse
from wirewear import (
    RecordError,
    ResultError,
    StudyError,
    read_record,
    read_result,
    run_study,
    write_record,
    write_result,
)
from wirewear.blind.scoring.answers import read_answer
from wirewear.cli import cli
from wirewear.diagnosis import write_diagnosis
from wirewear.diagnosis.infer.where import _compared
from wirewear.diagnosis.observe import registry as observables
from wirewear.diagnosis.observe.registry import all_observables
from wirewear.diagnosis.observe.scars import ScarFigures
from wirewear.effects import all_effects, registry
from wirewear.errors import BlindError, WirewearError
from wirewear.processes import within
from wirewear.records.importing import import_record
from wirewear.records.importing.readers.registry import readers
from wirewear.records.values import MeasuredScar
from wirewear.simulation import ProgressBar, RunObserver
from wirewear.simulation.observers import Moment
from wirewear.study import parse_study

ROOT = Path(__file__).resolve().parent.parent
cycle = cycle_of


def told(ended: Result) -> str:
    assert ended.exit_code == 2, ended.output
    assert "Traceback" not in ended.output
    (sentence,) = ended.stderr.strip().splitlines()[-1:]
    assert sentence.startswith("wirewear: ")
    return sentence


@pytest.mark.parametrize("digits", [309, 400, 5000])
@pytest.mark.parametrize("key", ["cycles", "normal_load_N", "friction"])
def test_a_number_of_any_length_is_out_of_range(digits: int, key: str) -> None:
    line = next(line for line in MINIMAL.splitlines() if line.startswith(f"{key} ="))
    with pytest.raises(StudyError) as refused:
        parse_study(MINIMAL.replace(line, f"{key} = {'9' * digits}"), "s.toml")
    assert len(str(refused.value)) < 200
    if digits < 4300:  # what Python reads
        assert f"is a number of {digits} digits, but must lie between" in str(refused.value)


@pytest.mark.parametrize("encoding", ["zlib", "hex", "rot13", "base64", "idna", "punycode", "undefined"])
def test_an_encoding_that_is_none_of_text_is_refused(tmp_path: Path, cycle: Any, encoding: str) -> None:
    (tmp_path / "cycle_1_rep1.txt").write_bytes(german(*cycle).encode("latin-1"))
    with pytest.raises(RecordError, match="must be an encoding of text such as"):
        import_record(mapped(tmp_path, GERMAN.replace('"latin-1"', f'"{encoding}"')))


@pytest.mark.parametrize("name", ["latin-1", "cp1252", "utf_16", "UTF-16-LE", "utf-32", "shift_jis", "mac_roman"])
def test_an_encoding_of_text_is_taken(tmp_path: Path, cycle: Any, name: str) -> None:
    (tmp_path / "cycle_1_rep1.txt").write_bytes(german(*cycle).replace("ü", "u").encode(name))
    assert import_record(mapped(tmp_path, GERMAN.replace('"latin-1"', f'"{name}"'))).cycles == (1,)


def test_a_pattern_that_would_need_for_ever_is_refused_in_time(tmp_path: Path, cycle: Any) -> None:
    (tmp_path / f"cycle_{'1' * 60}_rep1.txt").write_bytes(german(*cycle).encode("latin-1"))
    bad = GERMAN.replace(r"cycle_(?P<cycle>\d+)_rep(?P<repeat>\d+)", r"cycle_(?P<cycle>(\d+)+)x(?P<repeat>\d+)")
    with within(10.0), pytest.raises(RecordError, match="takes too long on the file's name"):
        import_record(mapped(tmp_path, bad))


def test_time_runs_out_in_the_main_thread_only() -> None:
    ran = []

    def aside() -> None:
        with within(0.01):
            ran.append(sum(range(1_000_000)))

    thread = Thread(target=aside)
    thread.start()
    thread.join()
    assert ran
    before = signal.getsignal(signal.SIGALRM)
    with pytest.raises(TimeoutError), within(0.05):
        signal.pause()
    assert signal.getsignal(signal.SIGALRM) == before


EVOLUTION = """
[evolution]
files = "evolution.csv"
columns = { cycle = "cycle", repeat = "repeat" }
"""
SCARS = """
[scars.moving]
files = "scar.csv"
columns = { x_um = "x", y_um = "y", depth_um = "d", repeat = "repeat" }
"""


@pytest.mark.parametrize("value", ["nan", "inf", "1e300", "9" * 200, "-1", "1.5"])
@pytest.mark.parametrize(
    ("table", "file", "rows"),
    [
        (EVOLUTION, "evolution.csv", "cycle,repeat\n{},1\n"),
        (EVOLUTION, "evolution.csv", "cycle,repeat\n1,{}\n"),
        (SCARS, "scar.csv", "x,y,d,repeat\n0,0,1,{}\n"),
    ],
)
def test_what_counts_nothing_is_no_cycle_and_no_repeat(
    tmp_path: Path, cycle: Any, table: str, file: str, rows: str, value: str
) -> None:
    (tmp_path / "cycle_1_rep1.txt").write_bytes(german(*cycle).encode("latin-1"))
    (tmp_path / file).write_text(rows.format(value))
    with pytest.raises(RecordError, match=r"(cycle|repeat) is .*, but must be a whole number between 0 and 1e\+\d+\.$"):
        import_record(mapped(tmp_path, GERMAN + table))


def test_a_cycle_of_two_hundred_digits_in_a_files_name_is_refused(tmp_path: Path, cycle: Any) -> None:
    (tmp_path / f"cycle_{'9' * 200}_rep1.txt").write_bytes(german(*cycle).encode("latin-1"))
    with pytest.raises(RecordError, match="cycle is 1e\\+200, but must be a whole number between 0 and"):
        import_record(mapped(tmp_path, GERMAN))


def test_points_at_random_are_no_grid_wherever_they_come_from() -> None:
    """On version 8318817, 60 000 of them asked for 26.8 GiB."""
    random = np.random.default_rng(0)
    x, y, depth = random.normal(size=(3, 60_000))
    with pytest.raises(RecordError, match="60000 points of repeat 1 lie on 60000 × 60000 lines, which is no grid"):
        MeasuredScar.from_points(1, "moving", x, y, depth)


@pytest.mark.parametrize("name", ["[/]", "[red]x[/red]", "a [/b] c", "\\[/]"])
def test_a_name_may_look_like_markup(name: str) -> None:
    shown = StringIO()
    console = Console(file=shown, force_terminal=True)
    with ProgressBar(name, console) as bar:
        bar.stage(name)
        bar.moved(Moment(1.0, 2, 0.0, 0.0, 0.5, 1.0))
        bar.note(name)
    assert f"wirewear: {name}" in shown.getvalue()


def test_a_name_may_look_like_a_script_on_the_page_of_a_diagnosis(tmp_path: Path) -> None:
    name = "</title><script>alert(1)</script>"
    one = record(repeats=1, evolution=False, normal=False)
    named = replace(one, tables=one.tables.model_copy(update={"name": name}))
    write_diagnosis(diagnosed(named), tmp_path)
    (page,) = tmp_path.glob("*.html")
    assert "alert(1)" in page.read_text()
    assert "<script>alert" not in page.read_text()


# Processes, disks, output


def killed(_observer: RunObserver) -> str:
    os.kill(os.getpid(), signal.SIGKILL)
    return "never"


def killed_maker() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


class Silent:
    """Watches nothing."""

    def __getattr__(self, _name: str) -> Any:
        return lambda *_: None


# In a process of its own, so that what dies with it takes no other test along.
KILLED = """
from tests.test_hardships import Silent, killed, killed_maker
from wirewear.engine import LocalProcesses, results_of
from wirewear.errors import WirewearError
from wirewear.simulation.side_by_side import run_side_by_side
engine = LocalProcesses(1)
for begin in (lambda: run_side_by_side([killed], [Silent()], engine), lambda: results_of(engine, [killed_maker])):
    try:
        begin()
    except WirewearError as error:
        print(type(error).__name__, error)
"""


@pytest.mark.slow
def test_a_killed_worker_is_told_in_one_sentence() -> None:
    ended = subprocess.run([sys.executable, "-c", KILLED], cwd=ROOT, capture_output=True, text=True, check=False)
    run, batch = ended.stdout.splitlines()
    ended_outside = "was ended from outside, perhaps because memory ran out"
    assert run.startswith("RunError ")
    assert f"{ended_outside}: --resume goes on" in run
    assert batch.startswith("LostTaskError ")
    assert f"{ended_outside}: the same command" in batch


def test_a_full_disk_at_the_end_of_a_diagnosis_is_one_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> Path:
        raise OSError(28, "No space left on device")

    found = diagnosed(record(repeats=1, evolution=False, normal=False))
    monkeypatch.setattr("wirewear.diagnosis.report.page.write_text", full)
    with pytest.raises(ResultError, match=r"^cannot write the diagnosis to .*: no space left on device\.$"):
        write_diagnosis(found, tmp_path / "out")


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


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no device that is full")
@pytest.mark.parametrize("arguments", [["effects"], ["effects", "--json"], ["tribometers", "FILE", "--json"]])
def test_output_that_is_full_is_one_sentence(arguments: list[str]) -> None:
    file = str(ROOT / "studies" / "tribometers" / "tribometers.csv")
    command = [
        sys.executable,
        "-c",
        "from wirewear.cli import main; main()",
        *(file if word == "FILE" else word for word in arguments),
    ]
    with Path("/dev/full").open("w") as full:
        ended = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert ended.returncode == 2, ended.stderr
    assert ended.stderr.strip() == "wirewear: the output can be neither read nor written: no space left on device."


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
        (["blind", "make", "b", "--cases", "1", "--seed", "1"], "interrupted; the same command goes on with a batch."),
        (["import", "m.toml", "--output", "o"], "interrupted; no file is left half written."),
    ],
)
def test_each_command_says_what_its_interruption_leaves(
    monkeypatch: pytest.MonkeyPatch, command: list[str], words: str
) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("wirewear.records.read_record", interrupted)
    monkeypatch.setattr("wirewear.cli.studies.load_any_study", interrupted)
    monkeypatch.setattr("wirewear.cli.studies.load_study", interrupted)
    monkeypatch.setattr("wirewear.blind.make_batch", interrupted)
    monkeypatch.setattr("wirewear.records.importing.import_record", interrupted)
    ended = CliRunner().invoke(cli, command)
    assert ended.exit_code == 130
    assert ended.stderr.strip().endswith(f"wirewear: {words}")


def test_an_interruption_while_the_program_starts_is_one_sentence() -> None:
    code = """
import sys

class Interrupting:
    def find_spec(self, name, *_):
        if name == "wirewear.simulation":
            raise KeyboardInterrupt

sys.meta_path.insert(0, Interrupting())
from wirewear.cli import main
main()
"""
    ended = subprocess.run([sys.executable, "-c", code, "effects"], capture_output=True, text=True, check=False)
    assert ended.returncode == 130
    assert ended.stderr == "wirewear: interrupted; nothing was written.\n"


# Code and files of others


class BadPoint:
    """An entry point whose module raises."""

    name, value, group = "gremlin", "gremlins:Gremlin", "any"

    def load(self) -> object:
        raise ZeroDivisionError("division by zero\nand more")


@pytest.mark.parametrize(
    ("found", "noun", "error"),
    [
        (all_effects, "effect", StudyError),
        (friction_laws, "friction law", SolverError),
        (all_observables, "observable", WirewearError),
        (readers, "reader", RecordError),
    ],
)
def test_a_plug_in_that_raises_when_it_is_loaded_is_named(
    monkeypatch: pytest.MonkeyPatch, found: Callable[[], object], noun: str, error: type[Exception]
) -> None:
    monkeypatch.setattr(plugins, "entry_points", lambda **_: [BadPoint()])
    caches = (registry._all_effects, friction_laws, observables._all_observables, readers)
    for cache in caches:
        cache.cache_clear()
    try:
        with pytest.raises(error) as refused:
            found()
    finally:
        monkeypatch.undo()
        for cache in caches:
            cache.cache_clear()
    assert str(refused.value).removesuffix(".") == (
        f"the {noun} 'gremlin' of an installed package cannot be loaded from gremlins:Gremlin (ZeroDivisionError: "
        "division by zero): mend or uninstall that package"
    )


def test_a_diagnosis_of_a_hundred_thousand_brackets_is_refused(tmp_path: Path) -> None:
    (tmp_path / "diagnosis.json").write_text("[" * 100_000)
    with pytest.raises(BlindError, match=r"diagnosis\.json cannot be read as JSON \(it is nested too deep\)\.$"):
        read_answer(tmp_path / "diagnosis.json")


def outside(tmp_path: Path) -> Path:
    """A file that no record and no mapping may quote."""
    secret = tmp_path / "secret.csv"
    secret.write_text("root:x:0:0:hidden words\n")
    return secret


@pytest.mark.parametrize("name", ["/etc/passwd", "../secret.csv", "a/../../secret.csv"])
def test_a_mapping_names_no_file_outside_its_folder(tmp_path: Path, name: str) -> None:
    outside(tmp_path)
    (tmp_path / "lab").mkdir()
    with pytest.raises(RecordError, match="must name files beside the mapping or in folders there") as refused:
        import_record(mapped(tmp_path / "lab", GERMAN.replace("cycle_*.txt", name)))
    assert "hidden" not in str(refused.value)


def test_links_out_of_a_folder_are_not_followed(tmp_path: Path, cycle: Any) -> None:
    secret, lab = outside(tmp_path), tmp_path / "lab"
    lab.mkdir()
    (lab / "cycle_1_rep1.txt").symlink_to(secret)
    with pytest.raises(RecordError, match=r"leads out of the folder .*lab, which is not followed\.$") as refused:
        import_record(mapped(lab, GERMAN))
    assert "hidden" not in str(refused.value)
    folder = write_record(tmp_path / "record", record(repeats=1, evolution=False, normal=False))
    (folder / "loops.csv").unlink()
    (folder / "loops.csv").symlink_to(secret)
    with pytest.raises(RecordError, match=r"loops in \[files\] .* leads out of the folder"):
        read_record(folder)


def test_a_link_to_a_record_and_links_within_it_are_followed(tmp_path: Path) -> None:
    folder = write_record(tmp_path / "record", record(repeats=1, evolution=False, normal=False))
    (folder / "loops.csv").rename(folder / "kept.csv")
    (folder / "loops.csv").symlink_to("kept.csv")
    (tmp_path / "link").symlink_to(folder)
    assert read_record(tmp_path / "link").repeats == (1,)


@pytest.mark.parametrize(
    ("difference", "words"),
    [
        (-2.295, "9.9 times smaller than the model"),
        (2.3026, "10 times larger than the model"),
        (0.1, "10.5 % above the model"),
        (-0.1, "9.5 % below the model"),
    ],
)
def test_a_logarithm_is_told_as_a_ratio(difference: float, words: str) -> None:
    assert f"{_compared(ScarFigures(), difference)} the model" == words
