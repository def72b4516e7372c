"""What is given where something else is needed is called what it is, with the command that takes it."""

import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from tests import synthetic_results
from tests.studies import MINIMAL
from wirewear.app.cli import cli
from wirewear.base.recognising import Held, recognised
from wirewear.records import read_record, write_record
from wirewear.results import write_result

pytestmark = pytest.mark.seconds
STUDIES = Path(__file__).parents[2] / "studies"
RECORD = STUDIES / "steel_wires" / "example_records" / "no_gap"


@pytest.fixture(autouse=True)
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with one of everything."""
    monkeypatch.chdir(tmp_path)
    shutil.copytree(RECORD, "record")
    Path("study.toml").write_text(MINIMAL, encoding="utf-8")
    shutil.copy(STUDIES / "rig_sensitivity" / "sweep.toml", "sweep.toml")
    Path("mapping.toml").write_text('[loops]\nfiles = ["a.csv"]\n', encoding="utf-8")
    Path("german.csv").write_text("Zeit [s];Kraft [N]\n0,1;-1,2\n", encoding="latin-1")
    Path("scar.xyz").write_text("0.0 1.5 -2e-3\n", encoding="utf-8")
    Path("book.xlsx").write_bytes(b"PK\x03\x04\xff")
    Path("letter.txt").write_text("Dear colleague,\n", encoding="utf-8")
    write_result(Path("run/result.h5"), synthetic_results.result())
    return tmp_path


def invoked(line: str) -> Result:
    return CliRunner().invoke(cli, line.split())


@pytest.mark.parametrize(
    ("name", "held"),
    [
        ("record", Held.RECORD),
        ("record/experiment.toml", Held.RECORD),
        ("record/loops.csv", Held.NUMBERS),
        ("run", Held.RUN),
        ("run/result.h5", Held.RUN),
        ("study.toml", Held.STUDY),
        ("sweep.toml", Held.SWEEP),
        ("mapping.toml", Held.MAPPING),
        ("german.csv", Held.NUMBERS),
        ("scar.xyz", Held.NUMBERS),
        ("book.xlsx", Held.NUMBERS),
        ("letter.txt", None),
        (".", Held.FILES),
        ("nowhere", None),
    ],
)
def test_what_a_path_holds_is_seen_by_its_contents(name: str, held: Held | None) -> None:
    assert recognised(Path(name)) == held


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        (
            "run german.csv",
            "german.csv is a file of measured numbers, and no study: `wirewear new --mapping german.csv` ",
        ),
        ("run record", "record is a record, and no study: `wirewear check record` "),
        ("run run", "run is a result of a run, and no study: `wirewear report run` "),
        (
            "run mapping.toml",
            "mapping.toml is a mapping of measured files, and no study: `wirewear import mapping.toml ",
        ),
        ("run sweep.toml", "sweep.toml is a sweep, and no study: `wirewear sweep sweep.toml` "),
        ("mesh scar.xyz", "scar.xyz is a file of measured numbers, and no study"),
        ("sweep study.toml", "study.toml is a study, and no sweep: `wirewear run study.toml` "),
        ("check study.toml", "study.toml is a study, and no record: `wirewear run study.toml` "),
        ("check german.csv", "german.csv is a file of measured numbers, and no record"),
        ("fit run --output o", "run is a result of a run, and no record"),
        ("diagnose record --model german.csv --output o", "german.csv is a file of measured numbers, and no study"),
        ("compare record record --output o", "record is a record, and no result of a run"),
        ("fields record --cycle 1", "record is a record, and no result of a run"),
        ("maps study.toml", "study.toml is a study, and no record or result of a run"),
        ("loops study.toml", "study.toml is a study, and no file of measured numbers or record or result of a run"),
        ("new german.csv", "german.csv holds numbers: `wirewear new "),
        ("new --mapping study.toml", "study.toml is a study, and no file of measured numbers"),
        ("new --mapping .", "mapping.toml exists already, and is not overwritten"),
        ("import . --output o", ". is a folder of measured files, and no mapping"),
        ("loops .", ". is a folder of measured files, and no file of measured numbers or record"),
    ],
)
def test_a_file_of_another_kind_is_named_with_the_command_that_takes_it(line: str, sentence: str) -> None:
    ended = invoked(line)
    assert ended.exit_code == 2, ended.output
    assert sentence in ended.stderr.splitlines()[-1]


@pytest.mark.slow
def test_a_comparison_takes_run_and_record_in_either_order() -> None:
    write_record(Path("loops"), replace(read_record(Path("record")), scars=()))
    ended = invoked("compare loops run --output exchanged")
    assert ended.exit_code == 0, ended.output
    assert "loops is a record and run a run: they are exchanged" in ended.stderr
    assert invoked("compare run loops --output given").exit_code == 0
    tables = [Path(name, "differences.csv").read_bytes() for name in ("exchanged", "given")]
    assert tables[0] == tables[1]
