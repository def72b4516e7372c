"""The scorer of the blind check on folders: batches, keys, runs, diagnoses, and the command."""

import json
import re
import shutil
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from studies.blind import default_key_path, make_batch, score_batch
from studies.blind.commands import exam
from studies.blind.errors import BlindError
from studies.blind.generators.files import record_hash
from studies.blind.scoring.answers import Answer, read_answer
from studies.blind.scoring.history import logged_run
from studies.blind.scoring.judging import Truth
from studies.blind.sealing import opened, read_key_file, salted, sealed
from tests.blind_answers import perfect
from tests.blind_batches import PlainModel
from wirewear.base.reading import with_checksum


def to_json(said: Answer) -> dict[str, Any]:
    """The contract's JSON of an answer."""
    return {
        "format": 1,
        "verdict": said.verdict,
        "gap": {"shrink": said.shrink, "predicted_shrink": said.predicted_shrink, "confirmed": None},
        "causes": [
            {
                "effect": c.effect,
                # Of a pair each takes its half.
                "probability": c.probability / max(sum(other.joint for other in said.causes), 1),
                "parameters": {n: {"value": sum(i) / 2, "interval95": list(i)} for n, i in c.intervals.items()},
                **({"joint": True} if c.joint else {}),
            }
            for c in said.causes
        ],
        "equivalent": [sorted(members) for members in said.equivalent],
        "undetectable": [],
    }


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a batch of twenty, its key, and perfect diagnoses of all but two of its records."""
    root = tmp_path_factory.mktemp("made")
    make_batch(root / "batch", cases=20, seed=5, generator=PlainModel())
    data = opened((root / "batch" / "key.json.enc").read_bytes(), read_key_file(root / "batch.key"), "key")
    for truth in data["truths"][2:]:
        own = root / "diagnoses" / truth["case"]
        own.mkdir(parents=True)
        (own / "diagnosis.json").write_text(json.dumps(to_json(perfect(Truth.of_key(truth)))))
    return root


@pytest.fixture
def batch(made: Path, tmp_path: Path) -> tuple[Path, Path, Path]:
    """The batch, the diagnoses and the key, to be altered at will."""
    shutil.copytree(made, tmp_path, dirs_exist_ok=True)
    return tmp_path / "batch", tmp_path / "diagnoses", tmp_path / "batch.key"


@pytest.mark.seconds
def test_a_batch_is_scored_from_its_folders(batch: tuple[Path, Path, Path]) -> None:
    folder, diagnoses, key = batch
    score = score_batch(folder, diagnoses, key_path=key)
    report = json.loads((diagnoses / "score.json").read_text())
    assert report == json.loads(json.dumps(score.report))
    assert report["unanswered"] == 2
    assert report["run"]["run"] == 1
    assert report["false_alarms"]["value"] == 0.0
    page = (diagnoses / "score.html").read_text()
    assert page.count("<svg ") == 5
    assert "data:image" not in page
    assert not re.search(r"""(src|href)=["'](?!data:|#)""", page)
    assert "2 records have no diagnosis and count as wrong." in page
    effect = next(j.truth for j in score.judgements if j.truth.kind == "single")
    name, value = next(iter(effect.parameters[effect.effects[0]].items()))
    assert f"{effect.effects[0].replace('_', ' ')}: {name.replace('_', ' ')} {value:.4g}" in page.replace("_", " ")


def test_an_exchanged_key_is_refused(batch: tuple[Path, Path, Path]) -> None:
    folder, diagnoses, key = batch
    secret = read_key_file(key)
    truth = opened((folder / "key.json.enc").read_bytes(), secret, "key")
    truth["truths"][0]["kind"] = "single" if truth["truths"][0]["kind"] == "none" else "none"
    (folder / "key.json.enc").write_bytes(sealed(salted(truth), secret))
    with pytest.raises(BlindError, match="exchanged afterwards"):
        score_batch(folder, diagnoses, key_path=key)


def test_an_altered_record_is_refused(batch: tuple[Path, Path, Path]) -> None:
    folder, diagnoses, key = batch
    with (folder / "case_003" / "loops.csv").open("a") as file:
        file.write("\n")
    with pytest.raises(BlindError, match="case_003 was altered"):
        score_batch(folder, diagnoses, key_path=key)


@pytest.mark.seconds
def test_a_record_exchanged_with_its_hash_in_the_manifest_is_refused(batch: tuple[Path, Path, Path]) -> None:
    """On version 8318817 such a batch was scored."""
    folder, diagnoses, key = batch
    with (folder / "case_003" / "loops.csv").open("a") as file:
        file.write("\n")
    manifest = json.loads((folder / "manifest.json").read_text())
    manifest["cases"]["case_003"]["sha256"] = record_hash(folder / "case_003")
    (folder / "manifest.json").write_text(json.dumps(manifest))
    with pytest.raises(BlindError, match="its records are not those that the key has sealed"):
        score_batch(folder, diagnoses, key_path=key)


@pytest.mark.parametrize("how", ["deleted", "shortened", "rewritten", "broken"])
def test_a_log_that_was_altered_is_refused(batch: tuple[Path, Path, Path], how: str) -> None:
    folder, diagnoses, key = batch
    for _ in range(3):
        logged_run(folder, diagnoses, {"top1": 0.5}, key)
    log = folder / "scored_runs.jsonl"
    lines = log.read_text().splitlines()
    changed = {
        "deleted": [],
        "shortened": lines[:2],
        "rewritten": [lines[0], lines[1].replace("0.5", "0.9"), lines[2]],
        "broken": [*lines[:2], "{"],
    }[how]
    log.write_text("".join(f"{line}\n" for line in changed))
    with pytest.raises(BlindError, match=r"was altered|cannot be read as JSON"):
        logged_run(folder, diagnoses, {"top1": 0.5}, key)


def test_the_key_of_another_batch_opens_nothing(batch: tuple[Path, Path, Path], tmp_path: Path) -> None:
    folder, diagnoses, _ = batch
    make_batch(tmp_path / "other", cases=1, seed=5, generator=PlainModel())
    with pytest.raises(BlindError, match="does not open"):
        score_batch(folder, diagnoses, key_path=default_key_path(tmp_path / "other"))


def test_a_diagnosis_that_changed_since_it_was_written_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "diagnosis.json"
    file.write_text(json.dumps(with_checksum({"verdict": "explained", "causes": [], "gap": {"shrink": 0.91}})))
    assert read_answer(file).shrink == 0.91
    file.write_text(file.read_text().replace("0.91", "0.99"))
    with pytest.raises(BlindError, match=r"diagnosis.json is not as it was written: it is damaged, or was changed\.$"):
        read_answer(file)


def test_the_contracts_example_is_read(tmp_path: Path) -> None:
    example = {
        "format": 1,
        "verdict": "explained",
        "gap": {
            "shrink": 0.99,
            "predicted_shrink": 0.98,
            "confirmed": {"shrink": 0.97, "after": 1.1, "effects": ["x"]},
        },
        "causes": [
            {
                "effect": "tangential_compliance",
                "probability": 0.97,
                "parameters": {"stiffness_N_per_mm": {"value": 165.0, "interval95": [158, 173]}},
            }
        ],
        "equivalent": [["tangential_compliance", "rotational_compliance"]],
        "undetectable": ["crossing_angle_error"],
    }
    (tmp_path / "diagnosis.json").write_text(json.dumps(example))
    said = read_answer(tmp_path / "diagnosis.json")
    assert said.achieved_shrink == 0.97
    assert said.causes[0].intervals == {"stiffness_N_per_mm": (158.0, 173.0)}


@pytest.mark.seconds
def test_the_command_makes_and_scores_and_says_where_things_are(batch: tuple[Path, Path, Path], tmp_path: Path) -> None:
    folder, diagnoses, key = batch
    scored = CliRunner().invoke(exam, ["score", str(folder), str(diagnoses), "--key", str(key)])
    assert scored.exit_code == 0, scored.output
    assert "class right, gaps above 5 scatters" in scored.output
    refused = CliRunner().invoke(exam, ["score", str(folder), str(tmp_path / "nowhere"), "--key", str(key)])
    assert refused.exit_code == 2
    assert refused.output.startswith("wirewear: there is no folder")
