"""The challenge: what is published tells nothing, and a file of answers gets the score that it deserves."""

import zipfile
from pathlib import Path

import pytest

from studies import challenge
from studies.blind.errors import BlindError
from tests.exam.blind_batches import PlainModel

pytestmark = pytest.mark.seconds


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    folder, keys = (tmp_path_factory.mktemp(name) for name in ("challenge", "keys"))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(challenge, "PARTS", {name: challenge.Part(PlainModel, 10, 2) for name in ("wires", "balls")})
        challenge.make(folder, keys, 5, ("wires", "balls"), lambda _: None)
    return folder, keys


def test_an_archive_is_always_the_same_and_holds_no_key(made: tuple[Path, Path], tmp_path: Path) -> None:
    folder, _ = made
    hashes = {challenge.pack(folder, tmp_path / name) for name in ("a.zip", "b.zip")}
    assert len(hashes) == 1
    names = zipfile.ZipFile(tmp_path / "a.zip").namelist()
    assert {"README.md", "wires/manifest.json", "balls/case_010/loops.csv"} <= {*names}
    assert not any(name.endswith((".key", ".sealed")) for name in names)
    with pytest.raises(BlindError, match="another challenge"):
        challenge.require_sealed(folder)


def test_right_answers_cost_nothing_and_those_that_see_no_gap_miss_all(made: tuple[Path, Path], tmp_path: Path) -> None:
    folder, keys = made
    right = [(one.case, "+".join(one.hypotheses), 1.0) for one in challenge.truths_of(folder, keys)]
    scores = []
    never = [(name, "none", 1.0) for name, *_ in right]
    for rows in (right, never, challenge.nearest(folder, folder, keys)):
        challenge.write_answers(tmp_path / "answers.csv", rows)
        scores.append(challenge.score(folder, keys, challenge.read_answers(tmp_path / "answers.csv")))
    perfect, blind, nearest = scores
    assert (perfect["cost"], perfect["detection"]["value"], perfect["alarms"]["value"]) == (0.0, 1.0, 0.0)
    assert (blind["detection"]["hits"], blind["alarms"]["hits"], blind["isolation"]) == (0, 0, 0.0)
    assert blind["cost"] == pytest.approx(blind["detection"]["of"] / 20)
    # A record is the nearest to itself.
    assert nearest["cost"] == 0.0


def test_of_a_diagnosis_classes_and_pairs_are_kept(tmp_path: Path) -> None:
    pair = [{"effect": effect, "probability": 0.3, "joint": True} for effect in ("free_play", "spring", "lag")]
    said = {"causes": [*pair, {"effect": "none", "probability": 0.1}], "equivalent": [["spring", "lag"]]}
    challenge.write_answers(tmp_path / "answers.csv", challenge.rows_of("wires/case_001", said))
    answer = challenge.read_answers(tmp_path / "answers.csv")["wires/case_001"]
    assert answer.verdict == "explained"
    assert answer.equivalent == (frozenset({"spring", "lag"}),)
    assert sum(cause.probability for cause in answer.causes if cause.joint) == pytest.approx(0.9)
