"""The blind seal and scored answers of version 8318817, which bound neither records nor the log of scored runs."""

import json
import shutil
from collections.abc import Callable
from functools import partial
from hashlib import sha256
from pathlib import Path

import pytest

from tests.early_faults import EXAM, refused
from tests.early_faults import command as given

pytestmark = pytest.mark.slow

command = partial(given, program=EXAM)

NO_GAP = {
    "format": 1,
    "verdict": "no_gap",
    "gap": {"shrink": 0.0, "predicted_shrink": 0.0, "confirmed": None},
    "causes": [],
    "equivalent": [],
    "undetectable": [],
}
CERTAIN: list[dict[str, object]] = [
    {"effect": effect, "probability": 1.0, "parameters": {}} for effect in ("free_play", "sensor_lag")
]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a sealed batch of two and diagnoses of both."""
    folder = tmp_path_factory.mktemp("made")
    ended = command(folder, "make", "b", "--cases", "2", "--seed", "3", "--tests", "1", "--jobs", "1")
    assert ended.returncode == 0, ended.stderr
    for record in ("case_001", "case_002"):
        (folder / "d" / record).mkdir(parents=True)
        (folder / "d" / record / "diagnosis.json").write_text(json.dumps(NO_GAP))
    return folder


@pytest.fixture
def batch(made: Path, tmp_path: Path) -> Path:
    """A copy of that folder."""
    return Path(shutil.copytree(made, tmp_path / "copy"))


def score() -> tuple[str, ...]:
    """Arguments that score the batch."""
    return ("score", "b", "d", "--key", "b.key")


def hash_of(record: Path) -> str:
    """A record's hash as a manifest states it."""
    digest = sha256()
    for path in sorted(record.iterdir()):
        digest.update(path.name.encode() + b"\0" + sha256(path.read_bytes()).digest())
    return digest.hexdigest()


def exchange_a_record(folder: Path) -> None:
    """With its hash in the manifest."""
    loops, path = folder / "b" / "case_001" / "loops.csv", folder / "b" / "manifest.json"
    loops.write_text(loops.read_text().replace("1", "2", 5))
    manifest = json.loads(path.read_text())
    assert manifest["cases"]["case_001"]["sha256"] != hash_of(loops.parent)
    manifest["cases"]["case_001"]["sha256"] = hash_of(loops.parent)
    path.write_text(json.dumps(manifest))


def forget_what_was_scored(folder: Path) -> None:
    """Delete the log of a run that was scored."""
    ended = command(folder, *score())
    assert ended.returncode == 0, ended.stderr
    (folder / "b" / "scored_runs.jsonl").unlink()


def be_certain_twice(folder: Path) -> None:
    """Two causes of probability one."""
    (folder / "d" / "case_001" / "diagnosis.json").write_text(json.dumps({**NO_GAP, "verdict": "explained",
                                                                          "causes": CERTAIN}))  # fmt: skip


def nest_without_end(folder: Path) -> None:
    """A hundred thousand brackets."""
    (folder / "d" / "case_001" / "diagnosis.json").write_text("[" * 100_000)


def test_a_sealed_batch_is_scored(batch: Path) -> None:
    assert command(batch, *score()).returncode == 0


@pytest.mark.parametrize("deed", [exchange_a_record, forget_what_was_scored, be_certain_twice, nest_without_end])
def test_what_was_not_sealed_or_is_no_answer_is_not_scored(batch: Path, deed: Callable[[Path], None]) -> None:
    deed(batch)
    assert refused(command(batch, *score()))
