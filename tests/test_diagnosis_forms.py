"""An effect is a cause, not a formula: what runs in, wears in or fills by another law is recognised all the same."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.diagnosis_cases import diagnosed, nominal, record, states, with_effect
from wirewear.base.course import Course
from wirewear.diagnosis.infer.covariance import form_columns
from wirewear.diagnosis.infer.inference import Fit
from wirewear.diagnosis.infer.search import _joint_starts
from wirewear.diagnosis.infer.weighing import SEPARABLE, Weighed, classes_of, relevant, weigh
from wirewear.diagnosis.model.candidates import Candidate, library
from wirewear.diagnosis.model.setup import Array, Setup
from wirewear.diagnosis.observe.reduction import reduce
from wirewear.effects import Chain, all_effects, effects_of_tables
from wirewear.effects.friction_evolution import FrictionEvolution
from wirewear.effects.roughness_compliance import RoughnessCompliance
from wirewear.effects.third_body import ThirdBodyLayer

NEAR, FAR = 0.5 * SEPARABLE, 2.0 * SEPARABLE

RUNNING_IN = {"initial": 0.45, "final": 0.62, "cycles": 3000.0}


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
    """An effect that happens to lead none by a hair passed its own small probability on to what stands beside none."""
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


def test_a_form_is_no_parameter_and_no_key_of_a_file() -> None:
    effect = FrictionEvolution(**RUNNING_IN)
    assert set(effect.values) == set(RUNNING_IN)
    assert effect.table() == {"name": "friction_evolution", **RUNNING_IN}
    with pytest.raises(ValueError, match="has no parameter"):
        effects_of_tables([{"name": "friction_evolution", **RUNNING_IN, "steepness": 0.5}])


def test_every_effect_acts_in_the_form_of_its_source_unless_told_otherwise() -> None:
    with_forms = {name for name, kind in all_effects().items() if kind.forms()}
    assert {"friction_evolution", "wear_rate_evolution", "roughness_compliance", "third_body"} <= with_forms
    assert FrictionEvolution(**RUNNING_IN) == FrictionEvolution(**RUNNING_IN, steepness=1.0)


def test_the_freedom_of_form_moves_observables_as_another_form_does() -> None:
    observed = reduce(record(repeats=1))
    setup = with_effect(nominal(), "friction_evolution", RUNNING_IN)
    columns = form_columns(states(), setup, observed.layout)
    assert list(columns) == [("friction_evolution", "steepness"), ("friction_evolution", "order")]
    early = observed.layout.of_kind(*{type(part.observable) for part in observed.layout}) & (
        observed.layout.cycle < 1e4
    )
    late = observed.layout.cycle >= 1e5
    moved = np.abs(columns["friction_evolution", "steepness"])
    assert moved[early].max() > 10.0 * moved[late].max()
    assert form_columns(states(), nominal(), observed.layout) == {}


def test_forms_stand_behind_parameters_and_are_the_source_s_where_nothing_is_known() -> None:
    candidate = next(one for one in library(nominal()) if one.name == "friction_evolution")
    assert list(candidate.unknowns) == [*RUNNING_IN, "steepness", "order"]
    middle = candidate.effect(np.zeros(5))
    assert middle == FrictionEvolution(**{name: getattr(middle, name) for name in RUNNING_IN})
    one_deviation = np.array([0.0, 0.0, 0.0, 1.0, 1.0])
    found = candidate.values(one_deviation)
    assert FrictionEvolution.forms()["steepness"].coordinate(found["steepness"]) == pytest.approx(1.0)
    assert FrictionEvolution.forms()["order"].coordinate(found["order"]) == pytest.approx(1.0)
    assert all(start.size == 5 and not start[-2:].any() for start in candidate.starts())


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


def test_line_contacts_have_no_forms_of_a_bed_that_only_wires_have() -> None:
    """Their bed is computed along the profile; a limit to its thickness would empty scars that are much deeper."""
    wires, lines = (Candidate.of(ThirdBodyLayer, {}, contact=kind) for kind in ("crossed-wires", "line-contact"))
    assert {"growth", "full_um"} <= set(wires.forms)
    assert not {"growth", "full_um"} & set(lines.forms)
    assert set(lines.parameters) == set(wires.parameters)


def test_searches_for_pairs_of_scars_begin_with_forms_as_their_sources_have_them() -> None:
    """Places of forms, too, would make thousands of beginnings of some hundred."""
    one, other = (Candidate.of(kind, nominal().stated) for kind in (ThirdBodyLayer, FrictionEvolution))
    fits = [
        Fit((it,), np.zeros(len(it.unknowns)), np.eye(len(it.unknowns)), nominal(), 1.0, 0.0) for it in (one, other)
    ]
    starts = np.array(_joint_starts(fits[0], fits[1], alone=True))
    names = [*one.unknowns, *other.unknowns]
    forms = [name in {**one.forms, **other.forms} for name in names]
    assert any(forms)
    assert not starts[:, forms].any()
    assert len(starts) == 1 + 3 ** (len(names) - sum(forms)) == 1 + len(np.unique(starts[1:], axis=0))
