"""The scripts beside studies: a wrong input ends in one sentence, told before anything is computed."""

import os
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest
from click.testing import CliRunner

from studies.blind import make_batch
from tests.blind_batches import PlainModel
from wirewear.faces.study_script import StudyScript

ROOT = Path(__file__).parent.parent

#: Arguments of every script, X standing for the wrong input: where it reads one, otherwise where it would write.
ARGUMENTS = {
    "benchmarks.bench_calculix": "--output X",
    "benchmarks.bench_condensation": "--contact-mesh-um X",
    "benchmarks.bench_half_space": "--points X",
    "benchmarks.bench_record_check": "--samples X",
    "benchmarks.bench_scaling": "--contact-mesh-um X",
    "benchmarks.bench_wear_paths": "--output X",
    "benchmarks.engines": "X",
    "benchmarks.flipped_bits": "--flips X",
    "benchmarks.frozen_loop": "X X",
    "benchmarks.fuzz_inputs": "--count X",
    "benchmarks.fuzz_records": "--only X",
    "benchmarks.hardships": "--only X",
    "benchmarks.inside_convergence": "X X",
    "benchmarks.random_studies": "--output X",
    "benchmarks.wirewear_side": "10 X out.json",
    "blind.ablations": "answers X",
    "blind.batch": "X --cases 1 --seed 1",
    "blind.compare": "X",
    "blind.conformal": "answers X",
    "blind.fair_sizes": "X X",
    "blind.own_sizes": "X X",
    "blind.forest": "X X answers",
    "blind.frozen": "X",
    "blind.frozen_anew": "X --tier T0",
    "blind.intervals": "--answered X X",
    "diagnosis.check": "X",
    "diagnosis.confirmed_shrinks": "answers X",
    "diagnosis.effect_errors": "X",
    "diagnosis.gap_free": "X",
    "diagnosis.gap_free_chances": "X",
    "diagnosis.layer_memory": "X",
    "diagnosis.odd_rigs": "X",
    "diagnosis.other_laws": "X",
    "diagnosis.repeatability": "X",
    "diagnosis.second_opinion": "answers X",
    "diagnosis.solver_sizes": "X",
    "effects.gallery": "--output X",
    "mccoll2004.compare": "X",
    "partial_slip.compare": "X",
    "rig_sensitivity.compare": "X",
    "rig_sensitivity.slurm_cluster": "--walltime 1 --jobs X",
    "rig_stiffness_2d.article": "--output X",
    "small_stroke.compare": "X",
    "steel_wires.compare": "X",
    "steel_wires.diagnose": "X",
    "titanium_energy.compare": "--output X",
    "titanium_oxygenation.compare": "X",
    "tribometers.article": "--output X",
    "tribometers.judge": "X",
}

#: What tells that a script reads arguments.
READS_ARGUMENTS = ("@click.command", "@comparison_command", "import argparse", "sys.argv[1:]")

#: Those that only write: an empty folder is what they ask for.
ONLY_WRITE = {
    "benchmarks.bench_calculix",
    "benchmarks.bench_wear_paths",
    "benchmarks.engines",
    "benchmarks.random_studies",
    "blind.batch",
    "blind.frozen",
    "blind.frozen_anew",
    "diagnosis.gap_free",
    "diagnosis.odd_rigs",
    "diagnosis.other_laws",
    "effects.gallery",
    "titanium_energy.compare",
    "rig_stiffness_2d.article",
    "tribometers.article",
}

#: Those that read no file at all.
READ_NOTHING = {
    "benchmarks.bench_condensation",
    "benchmarks.bench_half_space",
    "benchmarks.bench_record_check",
    "benchmarks.bench_scaling",
    "benchmarks.flipped_bits",
    "benchmarks.fuzz_inputs",
    "benchmarks.fuzz_records",
    "benchmarks.hardships",
    "benchmarks.wirewear_side",
}


@pytest.fixture(autouse=True)
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with an empty one in it, and files that are nothing under the names of what scripts read."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "empty").mkdir()
    (tmp_path / "answers").mkdir()
    (tmp_path / "text").write_text("hello\n", encoding="utf-8")
    (tmp_path / "junk" / "case_001").mkdir(parents=True)
    for name in ("score.json", "manifest.json", "result.h5", "table.parquet", "experiment.toml"):
        (tmp_path / "junk" / name).write_text("[]\n", encoding="utf-8")
    for name in ("experiment.toml", "truth.json", "diagnosis.json"):
        (tmp_path / "junk" / "case_001" / name).write_text("[1]\n", encoding="utf-8")
    return tmp_path


def scripts() -> list[str]:
    """Every module of studies that is a command, or would read arguments in another way."""
    return [
        ".".join(path.relative_to(ROOT / "studies").with_suffix("").parts)
        for path in sorted((ROOT / "studies").rglob("*.py"))
        if any(sign in path.read_text(encoding="utf-8") for sign in READS_ARGUMENTS)
    ]


def test_every_script_is_tried() -> None:
    assert scripts() == sorted(ARGUMENTS)


@pytest.mark.first_case
@pytest.mark.seconds
@pytest.mark.parametrize(
    ("script", "given"),
    [
        (script, given)
        for script in sorted(ARGUMENTS)
        for given in (("text",) if script in ONLY_WRITE | READ_NOTHING else ("empty", "text", "nowhere", "junk"))
    ],
)
def test_a_wrong_input_of_a_script_is_one_sentence(script: str, given: str) -> None:
    main = import_module(f"studies.{script}").main
    assert isinstance(main, StudyScript)
    ended = CliRunner().invoke(main, ARGUMENTS[script].replace("X", given).split())
    assert isinstance(ended.exception, SystemExit), repr(ended.exception)
    assert ended.exit_code == 2
    *before, told = ended.stderr.splitlines()
    if "Usage:" not in ended.stderr:
        assert not before
        assert told.startswith(f"{script.rpartition('.')[2]}: ")


@pytest.fixture(scope="module")
def batch(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("batches") / "records"
    make_batch(folder, cases=4, seed=12, generator=PlainModel())
    return folder


def run_by_their_path() -> list[str]:
    """Scripts whose first lines say that they are run by their path, as `make run` runs what compares a study."""
    files = (file for file in (ROOT / "studies").glob("*/*.py"))
    named = ((str(file.relative_to(ROOT)), file.read_text(encoding="utf-8")) for file in files)
    return sorted(name for name, text in named if f"python {name}" in text or name.endswith("/compare.py"))


@pytest.mark.slow
@pytest.mark.parametrize("script", [name for name in run_by_their_path() if not name.startswith("studies/blind/")])
def test_a_script_that_is_run_by_its_path_starts_from_any_folder(script: str, tmp_path: Path) -> None:
    without = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    command = [sys.executable, str(ROOT / script), "--help"]
    ended = subprocess.run(command, cwd=tmp_path, env=without, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.startswith("Usage: ")
