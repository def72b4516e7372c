"""From fits to classes of effects that a record cannot tell apart."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.diagnosis_cases import nominal
from wirewear.diagnosis.infer.inference import Fit
from wirewear.diagnosis.infer.weighing import SEPARABLE, Weighed, classes_of, relevant, weigh
from wirewear.diagnosis.model.candidates import library
from wirewear.diagnosis.model.setup import Array

NEAR, FAR = 0.5 * SEPARABLE, 2.0 * SEPARABLE


def fits(count: int, evidences: tuple[float, ...] = ()) -> list[Fit]:
    candidates = library(nominal())[:count]
    evidence = evidences or (0.0,) * count
    return [
        Fit((one,), np.zeros(1), np.eye(1), nominal(), 1.0, value)
        for one, value in zip(candidates, evidence, strict=True)
    ]


def distances(count: int, *near: tuple[int, int]) -> Array:
    matrix = np.full((count, count), FAR)
    for one, other in near:
        matrix[one, other] = matrix[other, one] = NEAR
    np.fill_diagonal(matrix, 0.0)
    return matrix


def test_a_chain_of_near_effects_is_no_class_as_its_ends_are_far() -> None:
    chain = fits(3)
    first, second, third = (one.names[0] for one in chain)
    assert classes_of(chain, distances(3, (0, 1), (1, 2))) in (((first, second), (third,)), ((first,), (second, third)))


def test_effects_near_to_each_other_are_one_class_in_the_order_of_their_fits() -> None:
    four = fits(4)
    names = [one.names[0] for one in four]
    assert classes_of(four, distances(4, (0, 2))) == ((names[0], names[2]), (names[1],), (names[3],))


def test_one_effect_is_a_class_and_none_are_none() -> None:
    assert classes_of(fits(1), np.zeros((1, 1))) == ((fits(1)[0].names[0],),)
    assert classes_of([], np.zeros((0, 0))) == ()


def test_effects_exactly_as_far_as_is_separable_are_two_classes() -> None:
    matrix = np.array([[0.0, SEPARABLE], [SEPARABLE, 0.0]])
    assert len(classes_of(fits(2), matrix)) == 2
    assert len(classes_of(fits(2), np.nextafter(matrix, 0.0))) == 1


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


def test_fits_of_equal_evidence_keep_the_librarys_order() -> None:
    own = fits(3, (1.0, 5.0, 5.0 + 1e-9))
    assert [one.names for one in relevant(own)] == [own[1].names, own[2].names, own[0].names]


@pytest.mark.parametrize("count", [0, 2])
def test_what_is_far_less_likely_is_not_compared(count: int) -> None:
    own = fits(3, (0.0, *(-11.0,) * count, *(-13.0,) * (2 - count)))
    assert len(relevant(own)) == 1 + count


@given(misfit=st.floats(0.4, 3.0))
def test_evidence_counts_by_what_the_best_leaves(misfit: float) -> None:
    """As if all variances were so much larger or smaller: twice the evidence and twice the misfit are the same."""
    none = Fit((), np.zeros(0), np.zeros((0, 0)), nominal(), 9.0, -4.5)
    known = weigh(none, fits(2, (-1.0, -4.0)), (), -9.0, (), 1.0, 0.0)
    scaled = Fit((), np.zeros(0), np.zeros((0, 0)), nominal(), 9.0 * misfit, -4.5 * misfit)
    found = weigh(scaled, fits(2, (-1.0 * misfit, -4.0 * misfit)), (), -9.0 * misfit, (), misfit, 0.0)
    assert found.outside == pytest.approx(known.outside)
    for names, probability in known.probabilities.items():
        assert found.probabilities[names] == pytest.approx(probability)


@pytest.mark.parametrize("lead", [-0.01, 0.01])
def test_a_distortion_beside_none_is_believed_with_none_whatever_effect_leads(lead: float) -> None:
    """An effect that happens to lead none by a hair lent its own small belief to what stands beside none."""
    none = Fit((), np.zeros(0), np.zeros((0, 0)), nominal(), 9.0, -4.5)
    found = weigh(none, fits(2, (-4.5 + lead, -9.0)), (), -9.0, (), 1.0, 0.0, {(): [17.0, 0.0]})
    assert found.outside > 0.9
    rivalled = weigh(none, fits(2, (-4.5 + lead, -9.0)), (), -9.0, (), 1.0, 0.0, {(): [17.0, 0.0]}, rival=12.0)
    assert rivalled.outside < 0.1


def test_effects_that_are_one_class_lead_together() -> None:
    """A spring and a rotation that no record tells apart are one answer, each with half of its probability."""
    springs = ("rotational_compliance", "tangential_compliance")
    probabilities = {(): 0.31, (springs[0],): 0.16, (springs[1],): 0.31, ("free_play",): 0.2}
    probabilities |= {(springs[0], "free_play"): 0.01, (springs[1], "free_play"): 0.01}
    assert Weighed(probabilities, 0.0, (springs, ("free_play",))).leading == pytest.approx(0.47)
    assert Weighed({**probabilities, (springs[0],): 0.0}, 0.0, (springs,)).leading == pytest.approx(0.31)
    assert Weighed({(): 1.0}, 0.0, ()).leading == 0.0
