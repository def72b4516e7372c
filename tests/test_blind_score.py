"""The scorer of the blind check, itself tested: known answers score as they must."""

import json
import re
import shutil
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from tests.blind_batches import PlainModel
from wirewear.blind import default_key_path, make_batch, score_batch
from wirewear.blind.cases import exact_class, planned_cases
from wirewear.blind.generator import LIBRARY_EFFECTS
from wirewear.blind.scoring.answers import Answer, NamedCause, read_answer
from wirewear.blind.scoring.figures import batch_figures
from wirewear.blind.scoring.history import logged_run
from wirewear.blind.scoring.judging import Truth, classes_of, judged
from wirewear.blind.scoring.score import judge_all
from wirewear.blind.scoring.statistics import (
    Share,
    area_interval,
    area_under_curve,
    calibration_error,
    reliability,
    roc_curve,
)
from wirewear.blind.scoring.table import aim_rows
from wirewear.blind.sealing import opened, read_key_file, salted, sealed
from wirewear.cli import cli
from wirewear.errors import BlindError


def truths_of(number: int, seed: int = 1) -> tuple[Truth, ...]:
    """Truths of a plan, the gap's size following the ease."""
    random = np.random.default_rng(seed)
    return tuple(
        Truth(
            case=case.name,
            kind=case.kind,
            ease=case.ease,
            effects=tuple(effect.effect for effect in case.effects),
            parameters={effect.effect: effect.parameters for effect in case.effects},
            gap_in_scatter=0.0 if case.ease is None else float(random.uniform(*((1, 6), (6, 40))[case.ease == "easy"])),
        )
        for case in planned_cases(number, seed, LIBRARY_EFFECTS, PlainModel().outside)
    )


def a_truth(kind: str, effect: str | None = None) -> Truth:
    return Truth("case_001", kind, None if effect is None else "easy", (effect,) if effect else (), {}, 9.0)


def answer(
    verdict: str,
    causes: Mapping[str, float] | None = None,
    *,
    joint: bool = False,
    equivalent: Sequence[frozenset[str]] = (),
    intervals: Mapping[str, Mapping[str, tuple[float, float]]] | None = None,
    shrink: float | None = None,
    predicted: float | None = None,
) -> Answer:
    named = tuple(
        NamedCause(effect, probability, (intervals or {}).get(effect, {}), joint)
        for effect, probability in (causes or {}).items()
    )
    return Answer(verdict, named, tuple(equivalent), frozenset(), shrink, predicted, None)


def perfect(truth: Truth) -> Answer:
    if truth.kind == "none":
        return answer("no_gap", {"none": 1.0})
    if truth.kind in ("outside", "left_out"):
        return answer("unexplained", {"outside_library": 1.0})
    intervals = {e: {n: (v - 1.0, v + 1.0) for n, v in truth.parameters[e].items()} for e in truth.effects}
    causes = dict.fromkeys(truth.effects, 1.0)
    joint = truth.kind == "pair"
    return answer("explained", causes, joint=joint, intervals=intervals, shrink=0.95, predicted=0.97)


def figures(truths: Sequence[Truth], answers: Mapping[str, Answer | None]) -> dict[str, Any]:
    return batch_figures(judge_all(truths, answers), {})


TRUTHS = truths_of(400)


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


def test_a_shuffled_key_scores_at_chance() -> None:
    truths = truths_of(2000)
    random = np.random.default_rng(0)
    shuffled = random.permutation(len(truths))
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


def test_always_the_commonest_effect_scores_as_often_as_that_effect_comes() -> None:
    effects = Counter(truth.effects[0] for truth in TRUTHS if truth.kind == "single")
    commonest, times = max(effects.items(), key=lambda item: (len(exact_class(item[0])) == 1, item[1]))
    found = figures(TRUTHS, {truth.case: answer("explained", {commonest: 0.9}) for truth in TRUTHS})
    assert found["top1"]["hits"] == times
    assert found["top1"]["of"] == sum(effects.values())
    assert found["right_given_detection"]["value"] == found["top1"]["value"]
    assert found["false_alarms"]["value"] == 1.0
    assert found["open_set"]["auroc"]["value"] == 0.5
    assert found["pairs"]["both"]["hits"] == 0
    # Nine in ten stated where nearly none is right.
    assert found["calibration_error"] > 0.8


def test_never_an_answer_is_wrong_about_everything_and_no_case_is_removed() -> None:
    found = figures(TRUTHS, {})
    assert found["unanswered"] == found["cases"] == 400
    assert found["top1"]["hits"] == found["detected"]["hits"] == found["set_coverage"]["hits"] == 0
    assert found["top1"]["of"] == sum(truth.kind == "single" for truth in TRUTHS)
    assert found["false_alarms"]["of"] == 80


def test_no_gap_everywhere_raises_no_alarm_and_finds_nothing() -> None:
    found = figures(TRUTHS, {truth.case: answer("no_gap", {"none": 0.99}) for truth in TRUTHS})
    assert found["false_alarms"]["value"] == found["detected"]["value"] == 0.0
    assert found["right_given_detection"]["value"] is None


def single(effect: str) -> Truth:
    return Truth("case_1", "single", "easy", (effect,), {effect: {}}, 9.0)


def test_members_of_an_exact_class_are_one_answer() -> None:
    said = judged(single("tangential_compliance"), answer("explained", {"rotational_compliance": 0.9}))
    assert said.first_right
    assert said.class_size == 2


def test_a_declared_equivalent_is_right_and_widens_the_class() -> None:
    pair = frozenset({"tangential_compliance", "displacement_load_coupling"})
    said = answer("ambiguous", {"displacement_load_coupling": 0.6, "friction_offset": 0.3}, equivalent=[pair])
    assert judged(single("rotational_compliance"), said).first_right
    assert judged(single("rotational_compliance"), said).class_size == 3
    undeclared = answer("ambiguous", {"displacement_load_coupling": 0.6, "friction_offset": 0.3})
    assert not judged(single("rotational_compliance"), undeclared).first_right


def test_probabilities_of_a_class_add_up_and_no_further_than_one() -> None:
    said = answer("explained", {"tangential_compliance": 0.45, "rotational_compliance": 0.5, "free_play": 0.05})
    assert judged(single("tangential_compliance"), said).truth_probability == pytest.approx(0.95)
    twice = answer("explained", {"tangential_compliance": 0.9, "rotational_compliance": 0.9})
    assert judged(single("tangential_compliance"), twice).truth_probability == 1.0


def test_the_second_place_counts_for_the_first_two_only() -> None:
    said = judged(single("free_play"), answer("ambiguous", {"friction_offset": 0.5, "free_play": 0.4}))
    assert (said.first_right, said.second_right) == (False, True)


def test_a_gap_that_was_overlooked_is_no_right_answer_however_probable_the_truth() -> None:
    said = judged(single("free_play"), answer("no_gap", {"none": 0.5, "free_play": 0.4}))
    assert (said.first_right, said.second_right, said.gap_seen) == (False, True, False)


def test_an_effect_that_was_left_out_is_right_unexplained() -> None:
    truth = Truth("case_1", "left_out", "easy", ("free_play",), {"free_play": {"gap_um": 3.0}}, 9.0)
    assert judged(truth, answer("unexplained", {"outside_library": 0.8})).first_right
    assert not judged(truth, answer("explained", {"tangential_compliance": 0.8})).first_right
    same = answer(
        "explained", {"tangential_compliance": 0.8}, equivalent=[frozenset({"free_play", "tangential_compliance"})]
    )
    assert judged(truth, same).first_right


def test_a_pair_counts_in_whole_and_in_part() -> None:
    truth = Truth("case_1", "pair", "easy", ("free_play", "misalignment"), {}, 9.0)
    both = answer("explained", {"free_play": 0.9, "misalignment": 0.9}, joint=True)
    one = answer("explained", {"free_play": 0.9, "misalignment": 0.05})
    assert [judged(truth, a).pair_found for a in (both, one, answer("no_gap"), None)] == [2, 1, 0, 0]


def test_parameter_intervals_are_compared_with_the_true_value() -> None:
    truth = Truth("case_1", "single", "easy", ("free_play",), {"free_play": {"gap_um": 3.0}}, 9.0)
    for interval, covered in (((2.5, 3.5), True), ((3.1, 3.5), False)):
        said = answer("explained", {"free_play": 1.0}, intervals={"free_play": {"gap_um": interval}})
        assert judged(truth, said).parameters == {"free_play.gap_um": covered}


def test_the_class_set_holds_the_fewest_classes_with_nine_tenths() -> None:
    said = answer("ambiguous", {"friction_offset": 0.6, "free_play": 0.31, "misalignment": 0.09})
    sizes = {effect: judged(single(effect), said) for effect in ("friction_offset", "free_play", "misalignment")}
    assert [j.set_holds_truth for j in sizes.values()] == [True, True, False]
    assert sizes["free_play"].set_size == 2


def test_classes_that_overlap_become_one() -> None:
    classes = classes_of([frozenset("ab"), frozenset("bc"), frozenset("de")])
    assert classes["a"] == frozenset("abc")
    assert classes["d"] == frozenset("de")
    assert classes["tangential_compliance"] == exact_class("rotational_compliance")


def test_wilsons_interval_is_that_of_the_closed_form() -> None:
    hits, of, z = 7, 10, 1.959964
    middle = (hits / of + z**2 / (2 * of)) / (1 + z**2 / of)
    half = z / (1 + z**2 / of) * np.sqrt(0.7 * 0.3 / of + z**2 / (4 * of**2))
    assert Share(hits, of).interval95 == pytest.approx((middle - half, middle + half), abs=1e-6)
    assert Share(0, 0).interval95 is None


@given(st.lists(st.integers(0, 5), min_size=1, max_size=15), st.lists(st.integers(0, 5), min_size=1, max_size=15))
def test_the_area_is_the_share_of_pairs_won_and_lies_under_the_curve(positive: list[int], negative: list[int]) -> None:
    area = area_under_curve(positive, negative)
    pairs = [1.0 if p > n else 0.5 * (p == n) for p in positive for n in negative]
    assert area == pytest.approx(np.mean(pairs))
    false, true = roc_curve(positive, negative)
    assert np.trapezoid(true, false) == pytest.approx(area)
    interval = area_interval(positive, negative)
    assert interval is not None
    assert 0.0 <= interval[0] <= interval[1] <= 1.0


def test_probabilities_that_mean_what_they_say_are_calibrated() -> None:
    random = np.random.default_rng(4)
    stated = random.random(20000)
    right = random.random(20000) < stated
    assert (calibration_error(reliability(list(stated), list(right))) or 1.0) < 0.01
    assert calibration_error(reliability(list(stated), [True] * 20000)) == pytest.approx(0.5, abs=0.01)


def to_json(said: Answer) -> dict[str, Any]:
    """The contract's JSON of an answer."""
    return {
        "format": 1,
        "verdict": said.verdict,
        "gap": {"shrink": said.shrink, "predicted_shrink": said.predicted_shrink, "confirmed": None},
        "causes": [
            {
                "effect": c.effect,
                "probability": c.probability,
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


def test_a_batch_is_scored_from_its_folders(batch: tuple[Path, Path, Path]) -> None:
    folder, diagnoses, key = batch
    score = score_batch(folder, diagnoses, key_path=key)
    report = json.loads((diagnoses / "score.json").read_text())
    assert report == json.loads(json.dumps(score.report))
    assert report["unanswered"] == 2
    assert report["run"]["run"] == 1
    assert report["false_alarms"]["value"] == 0.0
    page = (diagnoses / "score.html").read_text()
    assert page.count("data:image/png;base64,") == 2
    assert not re.search(r"""(src|href)=["'](?!data:)""", page)
    assert "2 records have no diagnosis and count as wrong." in page
    effect = next(j.truth for j in score.judgements if j.truth.kind == "single")
    name, value = next(iter(effect.parameters[effect.effects[0]].items()))
    assert f"{effect.effects[0].replace('_', ' ')}: {name.replace('_', ' ')} {value:.4g}" in page.replace("_", " ")


def test_every_scored_run_is_logged_and_counted(batch: tuple[Path, Path, Path]) -> None:
    folder, diagnoses, _ = batch
    first, again = (logged_run(folder, diagnoses, {"top1": 1.0}) for _ in range(2))
    assert (first["run"], again["run"], again["different_diagnoses_before"]) == (1, 2, 0)
    next(diagnoses.rglob("diagnosis.json")).unlink()
    assert logged_run(folder, diagnoses, {"top1": 0.9})["different_diagnoses_before"] == 1
    lines = [json.loads(line) for line in (folder / "scored_runs.jsonl").read_text().splitlines()]
    assert [line["run"] for line in lines] == [1, 2, 3]
    assert all(line["wirewear"] and len(line["source_sha256"]) == 64 for line in lines)


def test_baselines_and_an_oracle_stand_beside_the_diagnosis(batch: tuple[Path, Path, Path]) -> None:
    folder, diagnoses, key = batch
    for name in (path.name for path in folder.glob("case_*")):
        for place, said in (
            ("oracle", answer("explained", {"free_play": 1.0}, shrink=0.99)),
            ("baselines/chi2", answer("explained", {"friction_offset": 1.0})),
        ):
            own = diagnoses / place / name
            own.mkdir(parents=True)
            (own / "diagnosis.json").write_text(json.dumps(to_json(said)))
    score = score_batch(folder, diagnoses, key_path=key)
    report = score.report
    assert report["shrink"]["regret"] == pytest.approx(0.04)
    assert report["shrink"]["regret_within_aim"]["value"] == 1.0
    # Gaps that were not found are not left out: without an answer the whole shrink is lost.
    known = [j for j in score.judgements if j.truth.kind in ("single", "pair")]
    lost = [0.04 if j.gap_seen else 0.99 for j in known]
    assert report["shrink"]["regret_of_all"] == pytest.approx(np.mean(lost), abs=1e-4)
    assert max(lost) == 0.99
    assert report["baselines"]["chi2"]["false_alarms"]["value"] == 1.0


def test_an_aim_counts_as_met_for_sure_only_if_its_whole_interval_meets_it() -> None:
    few = batch_figures([judged(a_truth("none"), answer("no_gap"))] * 2, {})
    many = batch_figures([judged(a_truth("none"), answer("no_gap"))] * 200, {})
    marks = [next(row.mark for row in aim_rows(f) if row.what.startswith("false alarms")) for f in (few, many)]
    assert marks == ["met (too few cases to be sure)", "met"]


def test_a_wrong_cause_of_an_unknown_effect_counts_among_the_effects_named() -> None:
    said = answer("explained", {"free_play": 1.0})
    found = batch_figures(
        [judged(a_truth("outside", "clamp_slip"), said), judged(a_truth("single", "free_play"), said)], {}
    )
    assert found["right_given_detection"]["value"] == 1.0
    assert (found["true_where_named"]["hits"], found["true_where_named"]["of"]) == (1, 2)


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


def test_the_key_of_another_batch_opens_nothing(batch: tuple[Path, Path, Path], tmp_path: Path) -> None:
    folder, diagnoses, _ = batch
    make_batch(tmp_path / "other", cases=1, seed=5, generator=PlainModel())
    with pytest.raises(BlindError, match="does not open"):
        score_batch(folder, diagnoses, key_path=default_key_path(tmp_path / "other"))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{", "cannot be read as JSON"),
        ("[]", "has no verdict"),
        ('{"verdict": "maybe"}', "has no verdict"),
        ('{"verdict": "explained", "causes": [{"effect": "free_play"}]}', "not a diagnosis of format 1"),
        ('{"verdict": "explained", "causes": [{"effect": "free_play", "probability": 3}]}', "not a diagnosis"),
    ],
)
def test_a_file_that_is_no_diagnosis_is_refused_in_a_sentence(tmp_path: Path, text: str, words: str) -> None:
    (tmp_path / "diagnosis.json").write_text(text)
    with pytest.raises(BlindError, match=words):
        read_answer(tmp_path / "diagnosis.json")


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


def test_the_command_makes_and_scores_and_says_where_things_are(batch: tuple[Path, Path, Path], tmp_path: Path) -> None:
    folder, diagnoses, key = batch
    scored = CliRunner().invoke(cli, ["blind", "score", str(folder), str(diagnoses), "--key", str(key)])
    assert scored.exit_code == 0, scored.output
    assert "class right, gaps above 5 scatters" in scored.output
    refused = CliRunner().invoke(cli, ["blind", "score", str(folder), str(tmp_path / "nowhere"), "--key", str(key)])
    assert refused.exit_code == 2
    assert refused.output.startswith("wirewear: there is no folder")
