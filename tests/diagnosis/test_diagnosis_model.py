"""The fast forward model against closed forms."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry.arrays import Array
from studies.blind.generators.independent.friction import LAWS
from tests.diagnosis.diagnosis_cases import diagnosed, nominal, record, states, with_effect
from tests.diagnosis.layouts import layout
from tests.worked_examples import install_example
from wirewear.base.course import Course
from wirewear.diagnosis.answer import Cause, Diagnosis, Estimate
from wirewear.diagnosis.infer.covariance import HELD, components
from wirewear.diagnosis.infer.inference import Fit
from wirewear.diagnosis.infer.shrink import Shrink
from wirewear.diagnosis.infer.weighing import SEPARABLE, classes_of, weigh
from wirewear.diagnosis.infer.where import GapFinding
from wirewear.diagnosis.observe.channels import loop_area
from wirewear.diagnosis.observe.observable import ModelLoops, Scale
from wirewear.diagnosis.observe.reduction import _all_observables, reduce
from wirewear.diagnosis.surrogate.candidates import library
from wirewear.diagnosis.surrogate.forward import simulate
from wirewear.diagnosis.surrogate.inputs import SurrogateInputs
from wirewear.diagnosis.surrogate.loop_states import FULL_SLIP
from wirewear.diagnosis.surrogate.sensed_loops import KNEE, MIDDLE
from wirewear.diagnosis.wording import _one, explanations, sentence_of, share
from wirewear.effects import Chain
from wirewear.effects.contact import RoughnessCompliance, ThirdBodyLayer
from wirewear.records import ExperimentRecord, RecordTables
from wirewear.views.diagnosis_page import ten_lines

FORCE_N = 1.24  #: µP of the first loops, before the scar gives them slopes.
FIRST = np.array([2.0])


def test_each_predicts_sizes_and_places_every_number_that_it_lists() -> None:
    whole = layout()
    course = simulate(states(), nominal(), whole.cycles)
    loops = ModelLoops(nominal(), course)
    for part in whole:
        one, count = part.observable, len(part.sites)
        predicted = one.predict(course, part.sites)
        assert predicted.shape == one.solver_error(loops, part.sites).size.shape == (count,)
        assert set(one.zone(part.sites, 60.0)) <= {zone.name for zone in one.zones}
        assert one.smoothness(part.sites, Scale(60.0, 1.24)).along.shape == (count,)


def test_what_is_measured_of_the_models_own_loops_is_what_it_predicts() -> None:
    observed = reduce(record(repeats=1, scatter=0.0, samples=400))
    predicted = observed.layout.observed(simulate(states(), nominal("sensor"), observed.layout.cycles))
    size = np.sqrt(observed.noise[0] ** 2 + (observed.common**2).sum(axis=1))
    for part in observed.layout:
        away = (observed.values[0] - predicted)[part.rows] / size[part.rows]
        assert np.sqrt(np.mean(away**2)) < 3.0, part.observable.name


def test_the_worked_example_of_docs_measures_what_it_predicts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    example = install_example("An observable", tmp_path, monkeypatch)
    own = [one for one in _all_observables.__wrapped__() if one.name == example.name]
    observed = reduce(record(repeats=1, scatter=0.0, samples=400), own)
    predicted = observed.layout.observed(simulate(states(), nominal("sensor"), observed.layout.cycles))
    assert predicted.size > 3
    assert np.sqrt(np.mean(((observed.values[0] - predicted) / observed.noise[0]) ** 2)) < 3.0
    assert set(observed.layout.zones(60.0)) == {example.name}


def stating(one: ExperimentRecord, **changes: object) -> ExperimentRecord:
    """The record with other entries in its tables; those of `stated` are added."""
    data = one.tables.model_dump(exclude_none=True, exclude_unset=True)
    for key, value in changes.items():
        data[key] = {**data.get(key, {}), **value} if isinstance(value, dict) else value
    return replace(one, tables=RecordTables.model_validate(data))


@pytest.mark.slow
def test_a_wide_scatter_that_is_stated_makes_a_difference_of_its_size_no_gap() -> None:
    """A friction 6 % off is a gap to a laboratory that repeats within 1 %, and none to one that scatters by 5 %."""
    one = record({"friction_offset": {"friction": 0.66}}, repeats=1, seed=2)
    close = diagnosed(stating(one, scatter={"friction": 0.01})).diagnosis
    wide = diagnosed(stating(one, scatter={"friction": 0.06})).diagnosis
    assert close.verdict != "no_gap"
    assert wide.verdict == "no_gap"
    assert np.isfinite(close.shrink.before)


def areas(setup: SurrogateInputs, cycles: Array = FIRST) -> Array:
    course = simulate(states(), setup, cycles)
    return loop_area(course.displacement_um, course.tangential_force_N)


@pytest.mark.parametrize("softer", [0.0, 0.5, 1.0])
def test_a_softer_knee_encloses_what_the_books_say(softer: float) -> None:
    setup = replace(nominal(), compliance_um_per_N=0.0, micro_slip=softer)
    course = simulate(states(), setup, FIRST)
    assert areas(setup)[0] == pytest.approx(course.energy_mJ[0], rel=2e-3)


def test_micro_slip_of_another_order_is_that_of_iwans_spread_thresholds() -> None:
    setup = replace(nominal(), compliance_um_per_N=0.0, micro_slip=float(np.log(2.5 / FULL_SLIP)))
    course = simulate(states(), setup, FIRST)
    x, q = course.displacement_um[0, 0, : KNEE + 1], course.tangential_force_N[0, 0, : KNEE + 1]
    share, travel = (q - q[0]) / (q[-1] - q[0]), (x - x[0]) / (x[-1] - x[0])
    assert share == pytest.approx(LAWS["iwan"].share(2.5 * travel), abs=1e-6)


def test_a_force_beyond_friction_is_held_by_the_walls_of_the_scar_and_unworn_by_the_largest_stroke_alone() -> None:
    held_N, largest_um, ends = 1.5, 100.0, (1, 2)
    share = held_N / nominal().amplitude_um
    held = replace(nominal(), held="tangential", held_share=share, largest_um=largest_um)
    course = simulate(states(), held, np.array([1.0, 1e5]))
    assert np.abs(course.tangential_force_N).max(axis=ends)[1] == pytest.approx(held_N, rel=1e-3)
    assert 0.5 * np.ptp(course.displacement_um, axis=ends)[0] == pytest.approx(largest_um)
    assert course.slip_um[1] < 0.5 * largest_um


def test_a_stroke_under_a_force_that_walls_hold_is_known_as_well_as_the_walls() -> None:
    whole, share = layout(), 1.5 / nominal().amplitude_um
    held = replace(nominal(), held="tangential", held_share=share, largest_um=100.0)
    course = simulate(states(), held, whole.cycles)
    (part,) = (one for one in whole if one.observable.name == "amplitude")
    size = np.sqrt(np.diag(components(states(), held, whole)[HELD])[part.rows])[-1]
    error_N = 0.061 * ModelLoops(held, course).rise_N(part.sites)[-1]
    other = simulate(states(), replace(held, held_share=share + error_N / held.amplitude_um), whole.cycles)
    moved_um = part.observable.predict(other, part.sites) - part.observable.predict(course, part.sites)
    assert size == pytest.approx(abs(moved_um[-1]), rel=0.3)
    assert HELD not in components(states(), nominal(), whole)


def test_walls_lift_the_wires_against_the_spring_that_presses_them() -> None:
    """The load at a place is that in mid-stroke and the spring's; forces follow it, both branches alike."""
    lifted = replace(states(), lift_N=np.outer(states().load_drop_N, [0.3, 0.1]))
    flat, raised = (simulate(one, nominal(), np.array([1e5])) for one in (states(), lifted))
    end = float(raised.normal_force_N[0, 0, -1] - raised.normal_force_N[0, 0, MIDDLE])
    drop = nominal().load_N - float(raised.normal_force_N[0, 0, MIDDLE])
    assert end == pytest.approx(0.4 * drop, rel=0.01)
    assert raised.normal_force_N[0, 0] == pytest.approx(raised.normal_force_N[0, 1])
    ratio = raised.normal_force_N[0, 0, KNEE:] / flat.normal_force_N[0, 0, KNEE:]
    forces = raised.tangential_force_N[0, 0, KNEE:] / flat.tangential_force_N[0, 0, KNEE:]
    assert forces == pytest.approx(ratio, rel=1e-3)


COUPLING = "displacement_load_coupling"


@pytest.mark.parametrize(
    ("changed", "lost_mJ", "within"),
    [
        (replace(nominal(), compliance_um_per_N=nominal().compliance_um_per_N + 5.0), 4e-3 * 5.0 * FORCE_N**2, 0.02),
        (with_effect(nominal(), "free_play", {"gap_um": 4.0}), 2e-3 * 4.0 * FORCE_N, 0.03),
        (with_effect(nominal(), COUPLING, {"linear_um_per_N": 4.0, "quadratic_um_per_N2": 0.0}), 0.0, 2e-3),
        (with_effect(nominal(), COUPLING, {"linear_um_per_N": 0.0, "quadratic_um_per_N2": 1.0}), 0.0, 2e-3),
        (replace(nominal(), force_offset_N=0.05), 0.0, 2e-3),
    ],
    ids=["spring", "play", "linear coupling", "quadratic coupling", "zero of the force"],
)
def test_springs_and_play_take_their_share_of_the_energy_and_readings_none(
    changed: SurrogateInputs, lost_mJ: float, within: float
) -> None:
    cycles = FIRST if lost_mJ else np.array([100.0, 1e4])
    before = areas(nominal(), cycles)
    assert before - areas(changed, cycles) == pytest.approx(lost_mJ, abs=within * (lost_mJ or before.min()))


def test_the_worn_volume_is_the_coefficient_times_the_energy() -> None:
    cycles = np.geomspace(1.0, 1e5, 60)
    course = simulate(states(), nominal(), cycles)
    energy = np.trapezoid(np.append(course.energy_mJ[0], course.energy_mJ), np.append(0.0, cycles))
    assert course.volume_um3[-1] == pytest.approx(30.0 * energy, rel=0.01)


def test_scars_grow_on_where_less_slip_or_more_wear_leads_beyond_the_nominal_run() -> None:
    whole = states()
    columns = {name: own[:-2] for name, own in vars(whole).items() if np.shape(own)[:1] == whole.volume_um3.shape}
    expected, found = (simulate(one, nominal(), np.array([1e5])).scars for one in (whole, replace(whole, **columns)))
    assert expected[:, 0].sum() > 4.0 * columns["volume_um3"][-1]
    assert found == pytest.approx(expected, rel=0.1)


def test_the_drive_holds_the_reading_or_the_true_stroke() -> None:
    gained = with_effect(nominal("sensor"), "displacement_gain", {"gain": 1.05})
    read = simulate(states(), gained, FIRST).displacement_um
    assert 0.5 * np.ptp(read) == pytest.approx(60.0, rel=1e-3)
    read = simulate(states(), replace(gained, drive="stroke"), FIRST).displacement_um
    assert 0.5 * np.ptp(read) == pytest.approx(63.0, rel=1e-3)


@pytest.mark.seconds
def test_every_effect_that_loops_show_moves_an_observable() -> None:
    layout = reduce(record()).layout
    before = layout.observed(simulate(states(), nominal(), layout.cycles))
    for candidate in library(nominal(), states()):
        # A yield stress shows where it is low, others where they are high.
        ends = (candidate.applied(nominal(), np.full(len(candidate.unknowns), end)) for end in (-1.0, 1.0))
        found = [layout.observed(simulate(states(), end, layout.cycles)) for end in ends]
        moved = float(np.nanmax(np.abs(np.array(found) - before)))
        assert (moved > 1e-4) == (candidate.name != "crossing_angle_error"), candidate.name


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
    matrix = np.random.default_rng(seed).uniform(0.0, 2.0 * SEPARABLE, (count, count))
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
    assert sum(known.probabilities.values()) + known.outside == pytest.approx(1.0)
    assert found.outside == pytest.approx(known.outside)
    for names, probability in known.probabilities.items():
        assert found.probabilities[names] == pytest.approx(probability)


def chain_of(setup: SurrogateInputs, cycles: np.ndarray, worn_um3: np.ndarray | None = None) -> Chain:
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
        rough.predicted(chain_of(nominal(), cycles)).compliance_um_per_N
        for rough in (rough, replace(rough, lasting=0.0))
    ]
    own = chain_of(nominal(), cycles).compliance_um_per_N
    assert added[0][1] - own[1] == pytest.approx(0.3 * (added[1][0] - own[0]), rel=2e-3)
    assert added[1][1] == pytest.approx(own[1])
    worn = np.array([1e3, 1e6])
    chain = chain_of(nominal(), cycles, worn)
    depth = worn / np.sqrt(chain.worn_area2_um4)
    full = ThirdBodyLayer(0.4, 500.0, full_um=1e-3).predicted(chain)
    assert full.retained_fraction * depth == pytest.approx([1e-3, 1e-3], rel=1e-3)
    assert ThirdBodyLayer(0.4, 500.0).predicted(chain).retained_fraction == pytest.approx([0.4, 0.4])


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
    zones = tuple(GapFinding("plateau", "middle", (1, 9), 0.4, 2.0, text) for text in ("one", "two", "three"))
    answer = Diagnosis("a", "b", "ambiguous", said, shrink, {}, None, zones, tuple(causes), (), (), None, ())
    assert [line.split()[1] for line in ten_lines(answer).splitlines() if line.startswith("  where:")] == ["one", "two"]


@pytest.mark.parametrize("share_of_wear", [0.05, 0.14])
def test_an_answer_without_a_gap_names_what_the_record_does_not_rule_out_and_what_would(share_of_wear: float) -> None:
    shrink = Shrink(1.0, 1.0, 1.0, 0.0, (0.0, 0.0), 0.0, (9,), None, None)
    wear = Cause("wear_rate_offset", share_of_wear, {"factor": Estimate(0.6, (0.35, 1.04))})
    asked = {"what": "the scars", "splits": ["none", "wear_rate_offset"], "why": ""}
    said = sentence_of("no_gap", [Cause("none", 0.8, {}), wear], (), shrink, (), asked=asked)
    open_to = "does not rule out wear rate offset, factor 0.6 (0.35 to 1.04); the scars would tell."
    assert said.endswith(open_to) == (share_of_wear > 0.1)


def test_effects_that_look_alike_are_one_explanation_and_so_are_the_halves_of_a_pair() -> None:
    causes = [Cause("third_body", 0.2, {}, joint=True), Cause("free_play", 0.2, {}, joint=True), Cause("none", 0.3, {})]
    causes += [Cause("tangential_compliance", 0.18, {}), Cause("rotational_compliance", 0.1, {})]
    found = explanations(causes, [("rotational_compliance", "tangential_compliance")])
    words = ["third body together with free play", "no gap", "tangential compliance or its like"]
    assert [(one.words, round(one.probability, 9)) for one in found] == list(zip(words, (0.4, 0.3, 0.28), strict=True))
    assert [share(value) for value in (0.004, found[0].probability, 0.996)] == ["< 1 %", "40 %", "> 99 %"]
    assert _one(causes[3], [("rotational_compliance", "tangential_compliance")]).startswith(
        "one of rotational compliance or tangential compliance, which"
    )


def test_a_check_that_shows_no_gap_claims_no_shrink() -> None:
    seen, unseen = (
        Shrink(4.4, 0.57, 0.98, 1.0, (1.0, 1.0), 1.0, (9,), None, None),
        Shrink(1.09, 0.32, 1.0, 1.0, (1.0, 1.0), 1.0, (9,), None, None),
    )
    cause = Cause("free_play", 0.99, {"gap_um": Estimate(3.0, (2.9, 3.1))})
    answers = [
        Diagnosis("a", "b", "explained", "", one, {}, None, (), (cause,), (), (), None, ()) for one in (seen, unseen)
    ]
    checked, silent = (next(line for line in ten_lines(one).splitlines() if "check on" in line) for one in answers)
    assert "falls from 4.40 to 0.57 scatters, chance alone leaves 0.98; shrink 100 % (100 % to 100 %)" in checked
    assert "shrink" not in silent
    assert "tests may scatter hides the gap" in silent
