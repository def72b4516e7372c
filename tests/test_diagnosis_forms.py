"""An effect is a cause, not a formula: what runs in, wears in or fills by another law is recognised all the same."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.diagnosis_cases import diagnosed, nominal, record
from wirewear.base.course import Course
from wirewear.diagnosis.infer.inference import Fit
from wirewear.diagnosis.infer.shrink import Shrink
from wirewear.diagnosis.infer.weighing import SEPARABLE, classes_of, weigh
from wirewear.diagnosis.model.candidates import library
from wirewear.diagnosis.model.setup import Setup
from wirewear.effects import Chain
from wirewear.effects.contact import RoughnessCompliance, ThirdBodyLayer
from wirewear.views.diagnosis_values import Cause, Estimate
from wirewear.views.diagnosis_wording import explanations, sentence_of

RUNNING_IN = {"initial": 0.45, "final": 0.62, "cycles": 3000.0}


def fits(count: int, evidences: tuple[float, ...] = ()) -> list[Fit]:
    candidates = library(nominal())[:count]
    evidence = evidences or (0.0,) * count
    return [
        Fit((one,), np.zeros(1), np.eye(1), nominal(), 1.0, value)
        for one, value in zip(candidates, evidence, strict=True)
    ]


@pytest.mark.seconds
@given(st.integers(2, 8), st.integers(0, 10_000))
def test_members_of_a_class_are_near_and_classes_could_not_be_joined(count: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    matrix = random.uniform(0.0, 2.0 * SEPARABLE, (count, count))
    matrix = np.maximum(matrix, matrix.T)
    np.fill_diagonal(matrix, 0.0)
    own = fits(count)
    place = {one.names[0]: i for i, one in enumerate(own)}
    groups = [[place[name] for name in members] for members in classes_of(own, matrix)]
    assert sorted(i for group in groups for i in group) == list(range(count))
    assert all(matrix[np.ix_(group, group)].max() < SEPARABLE for group in groups)
    for i, one in enumerate(groups):
        assert all(matrix[np.ix_(one, other)].max() >= SEPARABLE for other in groups[:i])


@pytest.mark.seconds
@given(misfit=st.floats(0.4, 3.0))
def test_evidence_counts_by_what_the_best_leaves(misfit: float) -> None:
    """As if all variances were so much larger or smaller: twice the evidence and twice the misfit are the same."""
    none = Fit((), np.zeros(0), np.zeros((0, 0)), nominal(), 9.0, -4.5)
    known = weigh(none, fits(2, (-1.0, -4.0)), (), (), 1.0, 2.0)
    scaled = Fit((), np.zeros(0), np.zeros((0, 0)), nominal(), 9.0 * misfit, -4.5 * misfit)
    found = weigh(scaled, fits(2, (-1.0 * misfit, -4.0 * misfit)), (), (), misfit, 2.0)
    assert found.outside == pytest.approx(known.outside)
    for names, probability in known.probabilities.items():
        assert found.probabilities[names] == pytest.approx(probability)


def chain_of(setup: Setup, cycles: np.ndarray, worn_um3: np.ndarray | None = None) -> Chain:
    worn = np.zeros_like(cycles) if worn_um3 is None else worn_um3
    return setup.chain(250.0, 2000.0, cycles, np.zeros_like(cycles), worn)


def test_a_course_of_another_steepness_keeps_its_ends_and_its_63_percent() -> None:
    plain, slow = Course(0.4, 0.6, 1000.0), Course(0.4, 0.6, 1000.0, steepness=0.5)
    for cycle in (0.0, 1000.0, 1e9):
        assert slow.at(cycle) == pytest.approx(plain.at(cycle))
    assert slow.at(100.0) > plain.at(100.0)
    assert slow.at(5000.0) < plain.at(5000.0)
    at = np.array([10.0, 300.0, 2e4])
    assert slow.at(at) == pytest.approx([slow.at(float(cycle)) for cycle in at])
    assert slow.times(2.0).at(300.0) == pytest.approx(2.0 * slow.at(300.0))


def test_kinetics_of_the_second_order_go_hyperbolically_and_of_none_evenly_until_they_are_over() -> None:
    at = np.array([1.0, 500.0, 1000.0, 3000.0])
    second, none = Course(1.0, 0.0, 1000.0, order=1.0), Course(1.0, 0.0, 1000.0, order=-1.0)
    assert 1.0 / second.at(at) - 1.0 == pytest.approx((math.e - 1.0) * at / 1000.0)
    assert none.at(at) == pytest.approx(np.maximum(1.0 - (1.0 - 1.0 / math.e) * at / 1000.0, 0.0))
    assert [second.at(float(cycle)) for cycle in at] == pytest.approx(second.at(at))
    nearly = Course(1.0, 0.0, 1000.0, order=1e-4)
    assert nearly.at(at) == pytest.approx(Course(1.0, 0.0, 1000.0).at(at), rel=1e-3)


def test_what_stays_of_a_rough_layer_is_a_spring_and_a_full_bed_grows_no_thicker() -> None:
    cycles = np.array([1.0, 1e9])
    rough = RoughnessCompliance(2.0, 1000.0, lasting=0.3)
    added = [
        rough.foreseen(chain_of(nominal(), cycles)).compliance_um_per_N
        for rough in (rough, replace(rough, lasting=0.0))
    ]
    own = chain_of(nominal(), cycles).compliance_um_per_N
    assert added[0][1] - own[1] == pytest.approx(0.3 * (added[1][0] - own[0]), rel=2e-3)
    assert added[1][1] == pytest.approx(own[1])
    worn = np.array([1e3, 1e6])
    chain = chain_of(nominal(), cycles, worn)
    depth = worn / np.sqrt(chain.worn_area2_um4)
    full = ThirdBodyLayer(0.4, 500.0, full_um=1e-3).foreseen(chain)
    assert full.retained_fraction * depth == pytest.approx([1e-3, 1e-3], rel=1e-3)
    assert ThirdBodyLayer(0.4, 500.0).foreseen(chain).retained_fraction == pytest.approx([0.4, 0.4])


@pytest.mark.slow
def test_running_in_by_another_law_is_named_with_its_ends() -> None:
    answer = diagnosed(record({"friction_evolution": {**RUNNING_IN, "steepness": 0.6}})).diagnosis
    assert answer.verdict == "explained"
    assert answer.causes[0].effect == "friction_evolution"
    low, high = answer.causes[0].parameters["final"].interval95
    assert low < RUNNING_IN["final"] < high
    low, high = answer.causes[0].form["steepness"].interval95
    assert low < 0.6 < high < 1.0
    assert any("follows another law" in note for note in answer.notes)


@pytest.mark.parametrize(
    ("none", "begins"), [(0.4, "There may be a gap, though none is likeliest;"), (0.2, "There is a gap;")]
)
def test_an_open_answer_states_no_gap_that_is_less_likely_than_none(none: float, begins: str) -> None:
    flattened = Cause("plasticity", 0.3, {"flattening_um": Estimate(0.45, (0.3, 0.7))})
    causes = sorted((flattened, Cause("none", none, {})), key=lambda cause: -cause.probability)
    shrink = Shrink(1.0, 1.0, 1.0, 0.0, (0.0, 0.0), 0.0, (9,), None, None)
    said = sentence_of("ambiguous", causes, (), shrink, ())
    assert said.startswith(begins)
    assert "plasticity, flattening 0.45 µm" in said


def test_effects_that_cannot_be_told_apart_are_one_explanation_and_so_are_the_halves_of_a_pair() -> None:
    causes = [Cause("third_body", 0.2, {}, joint=True), Cause("free_play", 0.2, {}, joint=True), Cause("none", 0.3, {})]
    causes += [Cause("tangential_compliance", 0.18, {}), Cause("rotational_compliance", 0.1, {})]
    found = explanations(causes, [("rotational_compliance", "tangential_compliance")])
    words = ["third body together with free play", "no gap", "tangential compliance or its like"]
    assert [(one.words, round(one.probability, 9)) for one in found] == list(zip(words, (0.4, 0.3, 0.28), strict=True))
