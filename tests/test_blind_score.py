"""The scorer of the blind check, itself tested: known answers score as they must."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from studies.blind.generators.cases import exact_class
from studies.blind.intervals import distance
from studies.blind.scoring.answers import NamedCause, answer_of
from studies.blind.scoring.figures import batch_figures
from studies.blind.scoring.judging import Truth, classes_of, judged
from studies.blind.scoring.statistics import (
    Share,
    area_interval,
    area_under_curve,
    calibration_error,
    reliability,
    roc_curve,
)
from studies.blind.scoring.table import aim_rows
from tests.blind_answers import a_truth, answer, figures, perfect, truths_of
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


def test_an_estimate_that_stands_at_the_end_of_its_range_knows_nothing_beyond() -> None:
    assert distance(STIFFNESS, 200.0, (100.0, 200.0), 200.0) == 0.0
    assert distance(STIFFNESS, 200.0, (100.0, 200.0), 201.0) == float("inf")


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


def test_a_diagnosis_blind_to_small_gaps_separates_the_open_set_above_five_scatters_only() -> None:
    small = answer("no_gap", {"none": 0.99})
    found = figures(TRUTHS, {t.case: perfect(t) if t.gap_in_scatter > 5.0 else small for t in TRUTHS})["open_set"]
    assert found["auroc_large"]["value"] == 1.0
    assert found["rejected_large"]["outside"]["value"] == found["rejected_large"]["left_out"]["value"] == 1.0
    seen = np.mean([t.gap_in_scatter > 5.0 for t in TRUTHS if t.is_open])
    assert found["auroc"]["value"] == pytest.approx(0.5 + 0.5 * seen, abs=1e-4)
    assert sum(found["auroc_large"]["of"]) < sum(found["auroc"]["of"])


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


@pytest.mark.parametrize(("seam", "right"), [("loading", True), ("sensor", False), ("", False)])
def test_an_unexplained_gap_is_told_at_its_seam_or_not(seam: str, right: bool) -> None:
    truth = a_truth("outside", "bent_guide")
    told = replace(answer("unexplained", {"outside_library": 1.0}), seam=seam)
    assert judged(truth, told).right_seam is right
    found = batch_figures([judged(truth, told)], {})["open_set"]["right_seam_large"]
    assert (found["hits"], found["of"]) == (int(right), 1)


def test_no_seam_is_judged_where_a_cause_is_named_or_known() -> None:
    assert judged(a_truth("outside", "bent_guide"), answer("explained", {"free_play": 1.0})).right_seam is None
    assert judged(a_truth("left_out", "free_play"), answer("unexplained", {"outside_library": 1.0})).right_seam is None


def test_the_seam_of_an_answer_is_that_of_the_family_that_it_resembles_first() -> None:
    data = {"verdict": "unexplained", "causes": [], "resembles": [{"seam": "holder"}, {"seam": "sensor"}]}
    assert answer_of(data).seam == "holder"
    assert answer_of({"verdict": "no_gap", "causes": []}).seam == ""


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
    # An effect that is listed twice, alone and beside another one, is judged where it is likelier.
    twice = tuple(NamedCause("free_play", p, {"gap_um": ends}, True) for p, ends in ((0.6, (2.5, 3.5)), (0.1, (0, 1))))
    listed = replace(answer("explained"), causes=twice)
    assert judged(truth, listed).parameters == {"free_play.gap_um": True}


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
