"""Right effects that leave something: what an answer makes of them, and what is no cause at all."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from studies.blind.generators.cases import Case, TrueEffect
from studies.blind.generators.independent.model import IndependentModel
from studies.blind.generators.nominal import BallNominal
from studies.blind.generators.nuisances import Nuisances, Scatter
from studies.blind.generators.waveform import Waveform
from tests.diagnosis.diagnosis_cases import nominal, record, states
from tests.diagnosis.layouts import at_sites
from wirewear.diagnosis import diagnose
from wirewear.diagnosis.answer import Cause, Estimate
from wirewear.diagnosis.infer.covariance import estimate
from wirewear.diagnosis.infer.inference import Fit, Problem, fit
from wirewear.diagnosis.infer.resembling import imitations
from wirewear.diagnosis.infer.search import PAIR_GAIN, gain_needed, pair_fits
from wirewear.diagnosis.infer.shrink import Shrink
from wirewear.diagnosis.infer.weighing import Weighed, classes_of
from wirewear.diagnosis.notes import of_remainder, remaining
from wirewear.diagnosis.observe import Site
from wirewear.diagnosis.observe.channels import own_noise
from wirewear.diagnosis.observe.reduction import reduce
from wirewear.diagnosis.observe.scars import ScarSkew
from wirewear.diagnosis.surrogate.candidates import Candidate, library
from wirewear.diagnosis.surrogate.forward import simulate
from wirewear.diagnosis.wording import sentence_of
from wirewear.records import AnyRecord

SPRING_N_per_mm, PLAY_um = 7200.0, 2.9
PAIR = ("free_play", "tangential_compliance")


def candidate(name: str) -> Candidate:
    return next(one for one in library(nominal()) if one.name == name)


def fitted(*names: str) -> Fit:
    return Fit(tuple(map(candidate, names)), np.zeros(0), np.zeros((0, 0)), nominal(), 0.0, 0.0)


def test_the_largest_force_of_a_loop_with_an_outlying_sample_is_left_out() -> None:
    cycles = np.geomspace(10.0, 1e5, 40)
    figures = 1.2 * (1.0 + 0.002 * np.random.default_rng(1).standard_normal(40)) * (1.0 + (cycles / 1e5) ** 0.5)
    spoiled = figures.copy()
    spoiled[[9, 30]] *= 1.06
    noise, sound = own_noise(cycles, spoiled)
    assert np.flatnonzero(~sound).tolist() == [9, 30]
    assert noise == pytest.approx(0.002, rel=0.4)
    assert own_noise(cycles, figures)[1].all()


def test_an_angle_far_beyond_what_is_expected_is_found() -> None:
    true = 20.0
    layout = at_sites((ScarSkew(), [Site(100_000, level=float(wire)) for wire in (0, 1)]))
    angle = candidate("crossing_angle_error")
    mean = layout.computed(
        states(), nominal().with_effect(angle.effect(np.array([angle.parameters["angle_deg"].coordinate(true)])))
    )[0]
    problem = Problem(states(), nominal(), layout, mean, np.eye(2) / 0.006)
    found = fit(problem, [angle])
    assert angle.values(found.coordinates)["angle_deg"] == pytest.approx(true, rel=0.02)


def test_explanations_are_fitted_with_a_law_of_friction_far_from_mindlins() -> None:
    observed, setup, spring = reduce(record(repeats=1)), nominal("sensor"), candidate("tangential_compliance")
    problem = Problem.of(states(), setup, observed.layout, estimate(states(), setup, observed))
    true = np.array([spring.parameters["stiffness_N_per_mm"].coordinate(150.0)])
    softer = replace(spring.applied(setup, true), micro_slip=2.5 * states().freedoms["micro_slip"])
    found = fit(replace(problem, mean=problem.predicted(softer)), [spring])
    assert found.free == pytest.approx([2.5], abs=0.3)
    assert spring.values(found.coordinates)["stiffness_N_per_mm"] == pytest.approx(150.0, rel=0.02)


@pytest.mark.parametrize("micro_slip", [1.0, 2.0, 4.4])
def test_a_contact_that_sticks_longer_is_moved_as_far_over_the_same_scar(micro_slip: float) -> None:
    mindlin, longer = (
        simulate(states(), replace(nominal("stroke"), micro_slip=one), np.array([100.0, 1e5]))
        for one in (0.0, micro_slip)
    )
    assert 0.5 * np.ptp(longer.displacement_um, axis=(1, 2)) == pytest.approx(60.0, rel=1e-5)
    # What the scar adds to friction at the ends follows from wear by less energy alone.
    ends = [loops.tangential_force_N.max(axis=(1, 2)) for loops in (mindlin, longer)]
    assert ends[1] == pytest.approx(ends[0], rel=0.012)


@pytest.mark.seconds
def test_a_pair_is_found_although_another_single_effect_leads() -> None:
    spring = {"tangential_compliance": {"stiffness_N_per_mm": 150.0}, "free_play": {"gap_um": 6.0}}
    observed, setup = reduce(record(spring, repeats=1)), nominal("sensor")
    problem = Problem.of(states(), setup, observed.layout, estimate(states(), setup, observed))
    lag, *pair = (fit(problem, [candidate(name)]) for name in ("sensor_lag:force", *PAIR))
    found = pair_fits(problem, fit(problem, ()), [replace(lag, log_evidence=0.0), *pair])
    assert set(max(found, key=lambda one: one.merit).names) == set(PAIR)


@pytest.mark.seconds
def test_a_wear_rate_looks_like_wear_that_changes_and_free_play_like_nothing_else() -> None:
    observed, setup = reduce(record(repeats=1)), nominal("sensor")
    problem = Problem.of(states(), setup, observed.layout, estimate(states(), setup, observed))

    def alike(name: str, value: float) -> list[str]:
        one = candidate(name)
        true = np.array([next(iter(one.parameters.values())).coordinate(value)])
        found = fit(replace(problem, mean=problem.predicted(one.applied(setup, true))), [one], [true])
        for misfit, needed in ((0.7, 0.7), (2.0, 1.0)):
            left = replace(found, distance2=misfit * problem.mean.size)
            assert gain_needed(problem, left) == pytest.approx(needed * PAIR_GAIN)
        return [own.family for own in imitations(problem, found)]

    assert alike("wear_rate_offset", 1.5) == ["wear that goes faster and slower over the test"]
    assert alike("free_play", 6.0) == []
    assert "holder whose compliance changes over the test" not in alike("tangential_compliance", 200.0)


def test_what_all_likely_explanations_share_is_sure_and_what_acts_beside_it_is_open() -> None:
    def pair(effect: str, probability: float) -> list[Cause]:
        play = Cause("free_play", probability, {"gap_um": Estimate(1.1, (0.9, 1.3))}, joint=True)
        return [play, Cause(effect, probability, {"coefficient": Estimate(0.1, (0.08, 0.12))}, joint=True)]

    checked = Shrink(2.0, 1.0, 1.0, 1.0, (1.0, 1.0), 1.0, (), None, 0.0)
    said = partial(sentence_of, "ambiguous", equivalent=(), shrink=checked, where=())
    alone = Cause("free_play", 0.2, {"gap_um": Estimate(1.12, (0.9, 1.3))})
    shared = said([*pair("misalignment", 0.25), alone, *pair("force_crosstalk", 0.1)])
    assert shared.startswith("Free play, gap 1.1 µm (0.9 to 1.3), is there for sure, and its numbers hold")
    assert "misalignment, coefficient 0.1 (0.08 to 0.12), or force crosstalk, " in shared
    assert shared.endswith("or nothing, which this record cannot tell.")
    assert "for sure" not in said([*pair("misalignment", 0.25), Cause("friction_offset", 0.4, {})])


def test_effects_that_are_one_beside_another_are_a_class_though_neither_explains_alone() -> None:
    rotation = "rotational_compliance"
    fits = [fitted("free_play"), fitted(*PAIR), fitted("free_play", rotation)]
    matrix = np.full((3, 3), np.inf)
    np.fill_diagonal(matrix, 0.0)
    matrix[1, 2] = matrix[2, 1] = 0.1
    classes = classes_of(fits, matrix)
    assert sorted(map(sorted, classes)) == [["free_play"], [rotation, "tangential_compliance"]]
    shares = {(): 0.0, PAIR: 0.45, ("free_play", rotation): 0.45}
    assert Weighed(shares, 0.1, classes).verdict == "explained"


def test_an_explanation_keeps_what_it_has_together_with_an_unknown_cause_and_no_more() -> None:
    beside = {(): 0.04, PAIR: 0.95}
    weighed = Weighed({(): 0.0, PAIR: 0.01}, 0.99, (), beside)
    assert weighed.verdict == "unexplained"
    credited = weighed.with_remainder(PAIR)
    assert credited.verdict == "explained"
    assert credited.mass(PAIR) == pytest.approx(0.96)
    assert credited.outside == pytest.approx(0.04)
    # An unknown cause that does all by itself is none that remains.
    alone = replace(weighed, beside={(): 0.95, PAIR: 0.04})
    assert alone.with_remainder(PAIR).verdict == "unexplained"


def test_what_remains_is_stated_with_its_share() -> None:
    sentence = of_remainder(remaining(0.021, ()))
    assert sentence == " These numbers hold, though 2 % of the gap is not explained; it stands out nowhere by itself."
    assert of_remainder(None) == ""


def ball_record(*effects: TrueEffect) -> AnyRecord:
    """A ball of half an inch that another model slides on a flat, by Dahl's law of friction."""
    cycles = (100, 1000, 5000, 20000)
    nuisances = Nuisances(
        repeats=3, scatter=Scatter(friction=0.01, load=0.004, wear=0.04, angle_deg=0.0), displacement_noise_um=0.12,
        force_noise_N=0.35, correlation=0.0, outlier_share=0.0, waveform=Waveform(0.0, 0.0), amplitude_drift=0.0,
        drive="stroke", samples=256, has_normal_force=True, has_evolution=True, has_scars=False,
        loop_cycles=(cycles,) * 3, evolution_cycles=(20, 50, 300, 3000),
    )  # fmt: skip
    case = Case("ball", "pair" if effects else "none", None, effects, (), BallNominal(), nuisances, 2)
    return IndependentModel().make(case).record


@pytest.mark.slow
def test_spring_and_play_of_a_ball_are_explained_and_nothing_is_where_nothing_changed() -> None:
    """As soft as its rig, the contact shows how its friction begins to slide, which is no cause of a gap."""
    spring = TrueEffect("tangential_compliance", {"stiffness_N_per_mm": SPRING_N_per_mm})
    found = diagnose(ball_record(spring, TrueEffect("free_play", {"gap_um": PLAY_um}))).diagnosis
    assert found.verdict == "explained"
    values = {name: one for cause in found.causes[:4] for name, one in cause.parameters.items()}
    for name, true in (("stiffness_N_per_mm", SPRING_N_per_mm), ("gap_um", PLAY_um)):
        low, high = values[name].interval95
        assert low < true < high
    assert diagnose(ball_record()).diagnosis.verdict == "no_gap"
