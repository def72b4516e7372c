"""The scorer of the blind check, itself tested: known answers score as they must, in folders and by command."""

import json
import re
import shutil
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from studies.blind import default_key_path, make_batch, score_batch
from studies.blind.commands import exam
from studies.blind.errors import BlindError
from studies.blind.generators.cases import exact_class
from studies.blind.generators.files import record_hash
from studies.blind.intervals import distance
from studies.blind.scoring import statistics
from studies.blind.scoring.answers import Answer, read_answer
from studies.blind.scoring.figures import batch_figures
from studies.blind.scoring.history import logged_run
from studies.blind.scoring.judging import Truth, judged
from studies.blind.sealing import opened, read_key_file, salted, sealed
from tests.browser import page_faults
from tests.exam.blind_batches import PlainModel, a_truth, answer, figures, perfect, truths_of
from wirewear.base.files import with_checksum
from wirewear.effects import all_effects

STIFFNESS = all_effects()["tangential_compliance"].parameters()["stiffness_N_per_mm"]
TRUTHS = truths_of(400)


@given(st.floats(10.0, 1e4), st.floats(1.05, 10.0), st.floats(0.0, 3.0), st.sampled_from((1.0, -1.0)))
def test_a_truth_so_many_reaches_away_is_that_far_on_the_parameters_own_scale(
    value: float, factor: float, reaches: float, side: float
) -> None:
    """A stiffness is as uncertain upwards as downwards by a factor."""
    ends = value / factor, value * factor
    assert distance(STIFFNESS, value, ends, value * factor ** (side * reaches)) == pytest.approx(reaches, abs=1e-9)


def test_a_perfect_diagnosis_scores_perfectly() -> None:
    found = figures(TRUTHS, {truth.case: perfect(truth) for truth in TRUTHS})
    assert found["false_alarms"]["value"] == 0.0
    for name in ("detected", "top1", "top2", "top1_large", "right_given_detection", "set_coverage"):
        assert found[name]["value"] == 1.0, name
    assert found["calibration_error"] == 0.0
    assert found["parameters"]["coverage"]["value"] == 1.0
    assert found["open_set"]["auroc"]["value"] == 1.0
    assert found["pairs"]["both"]["value"] == 1.0
    assert found["shrink"]["predicted_less_achieved"] == pytest.approx(0.02)
    counts = np.array(found["confusion"]["counts"])
    columns = [found["confusion"]["answers"].index(truth) for truth in found["confusion"]["truths"]]
    assert counts.sum() == sum(truth.kind != "pair" for truth in TRUTHS)
    assert sum(counts[row, column] for row, column in enumerate(columns)) == counts.sum()


@pytest.mark.seconds
def test_a_shuffled_key_scores_at_chance() -> None:
    truths = truths_of(2000)
    shuffled = np.random.default_rng(0).permutation(len(truths))
    answers = {truth.case: perfect(truths[other]) for truth, other in zip(truths, shuffled, strict=True)}
    found = figures(truths, answers)
    # Each answer is drawn from the plan's own: the class is right as often as two draws agree.
    single = [t for t in truths if t.kind == "single"]
    firsts = Counter(min(exact_class(t.effects[0])) for t in truths if t.kind in ("single", "pair"))
    chance = np.mean([firsts[min(exact_class(t.effects[0]))] / len(truths) for t in single])
    low, high = found["top1"]["interval95"]
    assert low <= chance <= high
    assert chance < 0.06
    assert abs(found["open_set"]["auroc"]["value"] - 0.5) < 0.04
    assert found["false_alarms"]["value"] == pytest.approx(0.8, abs=0.05)


def test_never_an_answer_is_wrong_about_everything_and_no_case_is_removed() -> None:
    found = figures(TRUTHS, {})
    assert found["unanswered"] == found["cases"] == 400
    assert found["top1"]["hits"] == found["detected"]["hits"] == found["set_coverage"]["hits"] == 0
    assert found["top1"]["of"] == sum(truth.kind == "single" for truth in TRUTHS)
    assert found["false_alarms"]["of"] == 80


def test_a_diagnosis_blind_to_small_gaps_separates_the_open_set_above_five_scatters_only() -> None:
    small = answer("no_gap", {"none": 0.99})
    found = figures(TRUTHS, {t.case: perfect(t) if t.gap_in_scatter > 5.0 else small for t in TRUTHS})["open_set"]
    assert found["auroc_large"]["value"] == 1.0
    assert found["rejected_large"]["outside"]["value"] == found["rejected_large"]["left_out"]["value"] == 1.0
    seen = np.mean([t.gap_in_scatter > 5.0 for t in TRUTHS if t.is_open])
    assert found["auroc"]["value"] == pytest.approx(0.5 + 0.5 * seen, abs=1e-4)
    assert sum(found["auroc_large"]["of"]) < sum(found["auroc"]["of"])


def single(effect: str) -> Truth:
    return Truth("case_1", "single", "easy", (effect,), {effect: {}}, 9.0)


def test_a_declared_equivalent_is_right_and_an_overlooked_gap_is_not_however_probable_the_truth() -> None:
    pair = frozenset({"tangential_compliance", "displacement_load_coupling"})
    said = answer("ambiguous", {"displacement_load_coupling": 0.6, "friction_offset": 0.3}, equivalent=[pair])
    assert judged(single("rotational_compliance"), said).first_right
    assert judged(single("rotational_compliance"), said).class_size == 3
    undeclared = answer("ambiguous", {"displacement_load_coupling": 0.6, "friction_offset": 0.3})
    assert not judged(single("rotational_compliance"), undeclared).first_right
    overlooked = judged(single("free_play"), answer("no_gap", {"none": 0.5, "free_play": 0.4}))
    assert (overlooked.first_right, overlooked.second_right, overlooked.gap_seen) == (False, True, False)


def test_the_probability_on_the_truth_is_a_mean_over_gaps_that_are_seen() -> None:
    seen = judged(single("free_play"), answer("explained", {"free_play": 0.8}))
    overlooked = judged(single("free_play"), answer("no_gap", {"none": 0.7, "free_play": 0.2}))
    alarm = judged(a_truth("none"), answer("explained", {"free_play": 0.9}))
    assert batch_figures([seen, overlooked, alarm], {})["truth_probability_detected"] == pytest.approx(0.8)


def test_an_effect_that_was_left_out_is_right_unexplained() -> None:
    truth = Truth("case_1", "left_out", "easy", ("free_play",), {"free_play": {"gap_um": 3.0}}, 9.0)
    assert judged(truth, answer("unexplained", {"outside_library": 0.8})).first_right
    assert not judged(truth, answer("explained", {"tangential_compliance": 0.8})).first_right
    same = answer(
        "explained", {"tangential_compliance": 0.8}, equivalent=[frozenset({"free_play", "tangential_compliance"})]
    )
    assert judged(truth, same).first_right


@pytest.mark.parametrize(("seam", "right"), [("loading", True), ("sensor", False), ("", False)])
def test_an_unexplained_gap_is_placed_at_its_seam_or_not(seam: str, right: bool) -> None:
    truth = a_truth("outside", "bent_guide")
    named = replace(answer("unexplained", {"outside_library": 1.0}), seam=seam)
    assert judged(truth, named).right_seam is right
    found = batch_figures([judged(truth, named)], {})["open_set"]["right_seam_large"]
    assert (found["hits"], found["of"]) == (int(right), 1)


def test_the_class_set_holds_the_fewest_classes_with_nine_tenths() -> None:
    said = answer("ambiguous", {"friction_offset": 0.6, "free_play": 0.31, "misalignment": 0.09})
    sizes = {effect: judged(single(effect), said) for effect in ("friction_offset", "free_play", "misalignment")}
    assert [j.set_holds_truth for j in sizes.values()] == [True, True, False]
    assert sizes["free_play"].set_size == 2


def test_wilsons_interval_is_that_of_the_closed_form() -> None:
    hits, of, z = 7, 10, 1.959964
    middle = (hits / of + z**2 / (2 * of)) / (1 + z**2 / of)
    half = z / (1 + z**2 / of) * np.sqrt(0.7 * 0.3 / of + z**2 / (4 * of**2))
    assert statistics.Share(hits, of).interval95 == pytest.approx((middle - half, middle + half), abs=1e-6)
    assert statistics.Share(0, 0).interval95 is None


@given(st.lists(st.integers(0, 5), min_size=1, max_size=15), st.lists(st.integers(0, 5), min_size=1, max_size=15))
def test_the_area_is_the_share_of_pairs_won_and_lies_under_the_curve(positive: list[int], negative: list[int]) -> None:
    area = statistics.area_under_curve(positive, negative)
    pairs = [1.0 if p > n else 0.5 * (p == n) for p in positive for n in negative]
    assert area == pytest.approx(np.mean(pairs))
    false, true = statistics.roc_curve(positive, negative)
    assert np.trapezoid(true, false) == pytest.approx(area)
    interval = statistics.area_interval(positive, negative)
    assert interval is not None
    assert 0.0 <= interval[0] <= interval[1] <= 1.0


def test_probabilities_that_mean_what_they_say_are_calibrated() -> None:
    random = np.random.default_rng(4)
    stated = random.random(20000)
    right = random.random(20000) < stated
    assert (statistics.calibration_error(statistics.reliability(list(stated), list(right))) or 1.0) < 0.01
    assert statistics.calibration_error(statistics.reliability(list(stated), [True] * 20000)) == pytest.approx(
        0.5, abs=0.01
    )


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
    assert page_faults(diagnoses / "score.html") == []
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
