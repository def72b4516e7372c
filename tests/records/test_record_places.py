"""Where records are put: in one step, in place of nothing that was not made in the same way, and never of an input."""

import ctypes
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.commands import wirewear
from tests.records.loop_files import HEAD
from tests.records.point_records import run_of_wires
from wirewear import RecordError, read_record, write_record, write_result
from wirewear.records.importing import import_record
from wirewear.results.export import write_flat_tables

STUDIES = Path(__file__).parents[2] / "studies"
HAND_WRITTEN, SWEEP = STUDIES / "steel_wires" / "example_records" / "no_gap", STUDIES / "rig_sensitivity" / "sweep.toml"
LOOPS = """[loops]
files = "raw.csv"
[loops.columns]
displacement_um = "displacement_um"
tangential_force_N = "tangential_force_N"
cycle = "cycle"
repeat = "repeat"
"""


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a mapping and its file, a hand-written record, and a result."""
    folder = tmp_path / "home"
    folder.mkdir()
    monkeypatch.chdir(folder)
    shutil.copy(HAND_WRITTEN / "loops.csv", "raw.csv")
    Path("mapping.toml").write_text(HEAD.replace("cycles = 1000", "cycles = 100000") + LOOPS, encoding="utf-8")
    shutil.copytree(HAND_WRITTEN, "by_hand")
    write_result(Path("run.h5"), run_of_wires())
    return folder


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("[!.]*") if path.is_file()}


@pytest.mark.parametrize(
    "command",
    [
        "import mapping.toml --output .",
        "import mapping.toml --output by_hand",
        "export run.h5 --as-record by_hand",
        "export run.h5 --as-record .",
        "export run.h5 --as-heights by_hand",
        "export run.h5 --as-tables by_hand",
        "calibrate steel_wires --variant rigid --fidelity quick --record by_hand --output by_hand",
        "fit by_hand --output by_hand",
        "compare run.h5 by_hand --output by_hand",
        "new by_hand --output by_hand/experiment.toml",
    ],
)
def test_no_command_writes_into_its_input_or_a_record_made_otherwise(home: Path, command: str) -> None:
    before = contents(home)
    refused = wirewear(*command.split(), code=2)
    assert refused.stderr.count("\n") == 1
    assert contents(home) == before


@pytest.mark.parametrize("kind", ["raw", "link", "folder", "below"])
def test_no_option_lets_an_import_replace_what_it_reads(home: Path, kind: str) -> None:
    Path("loops.csv").write_bytes(Path("raw.csv").read_bytes())
    mapping = Path("mapping.toml")
    mapping.write_text(mapping.read_text(encoding="utf-8").replace("raw.csv", "loops.csv"), encoding="utf-8")
    Path("link").symlink_to(home)
    output = {"raw": ".", "link": "link", "folder": str(home), "below": "../home"}[kind]
    before = contents(home)
    assert (
        "which the record is made of" in wirewear("import", mapping, "--output", output, "--overwrite", code=2).stderr
    )
    assert contents(home) == before


def test_an_import_replaces_its_own_record_as_long_as_that_is_as_it_was_written(home: Path) -> None:
    made, table = home / "record", home / "record" / "experiment.toml"
    wirewear("import", "mapping.toml", "--output", "record")
    shutil.copy(made / "loops.csv", made / "evolution.csv")
    (made / "fit").mkdir()
    (made / "fit" / "notes.txt").write_text("mine", encoding="utf-8")
    mapping = Path("mapping.toml")
    mapping.write_text(mapping.read_text(encoding="utf-8").replace("cycles = 100000", "cycles = 200000"), "utf-8")
    wirewear("import", "mapping.toml", "--output", "record")
    assert "cycles = 200000" in table.read_text(encoding="utf-8")
    assert contents(made).keys() == {"experiment.toml", "loops.csv", "fit/notes.txt"}
    assert not list(home.glob(".*"))

    shutil.copy(mapping, "other.toml")
    assert "not made of the same file" in wirewear("import", "other.toml", "--output", "record", code=2).stderr
    table.write_text(table.read_text(encoding="utf-8").replace("200000", "300000"), encoding="utf-8")
    assert "changed by hand" in wirewear("import", "mapping.toml", "--output", "record", code=2).stderr
    wirewear("import", "mapping.toml", "--output", "record", "--overwrite")
    assert "cycles = 200000" in table.read_text(encoding="utf-8")


def test_an_import_overwrites_a_hand_written_record_and_others_files_when_asked_alone(home: Path) -> None:
    wirewear("import", "mapping.toml", "--output", "by_hand", "--overwrite")
    assert contents(home / "by_hand").keys() == {"experiment.toml", "loops.csv"}
    others = home / "others"
    others.mkdir()
    (others / "loops.csv").write_text("another", encoding="utf-8")
    assert "others holds loops.csv" in wirewear("import", "mapping.toml", "--output", "others", code=2).stderr
    assert (others / "loops.csv").read_text(encoding="utf-8") == "another"


def test_tables_and_heights_are_exported_over_none_that_are_there(home: Path) -> None:
    (home / "data").mkdir()
    Path("data/loops.csv").write_text("raw", encoding="utf-8")
    for option in ("--as-tables", "--as-heights"):
        assert "loops.csv exists already" in wirewear("export", "run.h5", option, "data", code=2).stderr
        assert contents(home / "data") == {"loops.csv": b"raw"}
    wirewear("export", "run.h5", "--as-tables", "data", "--overwrite")


@pytest.mark.parametrize(
    ("command", "file"),
    [
        ("run cylinder_on_flat", "loops.csv"),
        ("run steel_wires", "rigid/report.html"),
        ("run steel_wires --resume", "rigid/report.html"),
        ("run steel_wires", "result.h5"),
        (f"sweep {SWEEP}", "table.csv"),
        (f"sweep {SWEEP}", "rows.jsonl"),
        ("fit by_hand", "stated.toml"),
    ],
)
def test_runs_sweeps_and_fits_replace_nothing_that_they_have_not_written(home: Path, command: str, file: str) -> None:
    place = home / "data" / file
    place.parent.mkdir(parents=True)
    place.write_text("raw", encoding="utf-8")
    assert "not overwritten" in wirewear(*command.split(), "--output", "data", code=2).stderr
    assert contents(home / "data") == {file: b"raw"}
    assert "without a name" in wirewear(*command.split(), "--output", "", code=2).stderr


def test_a_fit_replaces_no_study_that_was_not_fitted(home: Path) -> None:
    Path("study.toml").write_text("mine", encoding="utf-8")
    assert "was not fitted" in wirewear("fit", "by_hand", "--output", ".", code=2).stderr
    assert (home / "study.toml").read_text(encoding="utf-8") == "mine"


ENDED = """
import os, sys
from pathlib import Path
from wirewear import read_record, write_record
import wirewear.base.writing as writing
left, real = int(sys.argv[1]), writing._synchronise
def counted(path):
    global left
    left -= 1
    if left < 0:
        os._exit(9)
    real(path)
writing._synchronise = counted
record = read_record("by_hand")
write_record("record", record.__class__(record.tables, record.loops[:5]))
"""


@pytest.mark.seconds
def test_a_record_whose_writer_is_killed_is_the_one_before_or_the_one_after(home: Path) -> None:
    write_record(home / "record", read_record(home / "by_hand"))
    before = contents(home / "record")
    for left in (5, 9):
        ended = subprocess.run([sys.executable, "-c", ENDED, str(left)], cwd=home, check=False)
        found = contents(home / "record")
        assert (found == before) == (ended.returncode == 9)
        assert len(read_record(home / "record").loops) == (
            5 if ended.returncode == 0 else len(read_record(home / "by_hand").loops)
        )
    assert ended.returncode == 0


@pytest.mark.parametrize("exchanged", [True, False])
def test_what_was_there_stays_when_a_record_cannot_be_put_in_place(
    home: Path, monkeypatch: pytest.MonkeyPatch, *, exchanged: bool
) -> None:
    record = read_record(home / "by_hand")
    write_record(home / "record", record)
    before = contents(home)
    rename = Path.rename

    def failing(self: Path, target: Path) -> Path:
        if ".partial" in self.name:
            raise OSError("full")
        return rename(self, target)

    if not exchanged:
        # As on a file system that exchanges no folders.
        monkeypatch.setattr(ctypes, "CDLL", lambda _: object())
        monkeypatch.setattr(Path, "rename", failing)
    else:
        monkeypatch.setattr("wirewear.base.writing._exchange", lambda *_: failing(Path(".partial"), home))
    with pytest.raises(RecordError, match="cannot write the record"):
        write_record(home / "record", record)
    assert contents(home) == before
    monkeypatch.undo()
    os.chdir(home)
    if not exchanged:
        monkeypatch.setattr(ctypes, "CDLL", lambda _: object())
        write_record("record", record)
        assert contents(home) == before


def test_readers_hear_of_a_killed_writers_record_and_the_next_writer_restores_it(
    home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    wirewear("import", "mapping.toml", "--output", "record")
    before, rename = contents(home), Path.rename

    def killed(self: Path, target: Path) -> Path:
        if ".partial" in self.name:
            raise KeyboardInterrupt
        return rename(self, target)

    with monkeypatch.context() as patch:
        patch.setattr(ctypes, "CDLL", lambda _: object())
        patch.setattr(Path, "rename", killed)
        with pytest.raises(KeyboardInterrupt):
            write_record(home / "record", read_record(home / "by_hand"), overwrite=True)
    assert not (home / "record").exists()
    with pytest.raises(RecordError, match=r"the record before is in .*record\.before\."):
        read_record(home / "record")
    # It is not one that may be overwritten: the next writer finds it in its place.
    assert "was not made of the same file" in wirewear("export", "run.h5", "--as-record", "record", code=2).stderr
    assert contents(home) == before


def test_a_record_is_not_put_in_place_of_the_folder_that_the_command_runs_in(
    home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (home / "empty").mkdir()
    monkeypatch.chdir(home / "empty")
    assert "was started in" in wirewear("import", "../mapping.toml", "--output", ".", code=2).stderr


def test_a_record_is_not_put_in_place_of_a_mounted_disk(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Path, "is_mount", lambda path: path.name == "disk")
    assert "a disk is mounted at disk" in wirewear("import", "mapping.toml", "--output", "disk", code=2).stderr


def test_names_that_are_no_text_in_utf_8_are_names_of_outputs_and_inputs(home: Path) -> None:
    folder = Path(os.fsdecode(b"bad\xff"))
    folder.mkdir()
    for name in ("mapping.toml", "raw.csv"):
        shutil.copy(name, folder)
    mapping = folder / "mapping.toml"
    for output in (folder / "record", folder / "record", home / "record"):
        write_record(output, import_record(mapping), made_of=[mapping])
        assert read_record(output).loops
    for form in ("csv", "parquet"):
        assert write_flat_tables(run_of_wires(), folder / form, form)[0].is_file()


def test_a_link_to_a_record_stays_a_link(home: Path) -> None:
    (home / "record").mkdir()
    (home / "link").symlink_to("record")
    for _ in range(2):
        wirewear("import", "mapping.toml", "--output", "link")
    assert (home / "link").is_symlink()
    assert (home / "record" / "experiment.toml").is_file()
