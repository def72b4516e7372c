"""What differs between tests and between solvers without any gap, as the diagnosis expects it, whatever its sizes."""

from dataclasses import replace
from random import Random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.diagnosis_cases import nominal, record, states
from wirewear.diagnosis.infer.covariance import Covariance, estimate
from wirewear.diagnosis.infer.inference import Problem
from wirewear.diagnosis.infer.solver_differences import derivatives, free_covariance, remainder, solver_covariance
from wirewear.diagnosis.model.setup import Array, Setup
from wirewear.diagnosis.model.wear_states import WearStates
from wirewear.diagnosis.observe.amplitude import Amplitude
from wirewear.diagnosis.observe.evolution import Energy, LargestForce, SlipAmplitude
from wirewear.diagnosis.observe.knee_peak import KneePeak
from wirewear.diagnosis.observe.layout import Layout
from wirewear.diagnosis.observe.normal_along import (
    NormalForce,
    NormalForceAtEnds,
    NormalForceByDirection,
    NormalForceBySides,
)
from wirewear.diagnosis.observe.observable import Observable
from wirewear.diagnosis.observe.plateau import PlateauForce
from wirewear.diagnosis.observe.profiles import ProfileDepths
from wirewear.diagnosis.observe.reduction import Observations, reduce
from wirewear.diagnosis.observe.registry import LIBRARY, all_observables
from wirewear.diagnosis.observe.scars import ScarFigures, ScarSkew
from wirewear.diagnosis.observe.shelf import ShelfTravel
from wirewear.diagnosis.observe.sites import Site
from wirewear.diagnosis.observe.stick import Stick

CYCLES = (1, 300, 10_000, 100_000)

#: Some numbers of every observable of loops.
SITES: dict[type[Observable], list[Site]] = {
    PlateauForce: [
        Site(cycle, sign, sign * at) for cycle in CYCLES for sign in (1, -1) for at in (-20.0, 0.0, 46.0, 54.0)
    ],
    Stick: [Site(cycle, sign, force) for cycle in CYCLES for sign in (1, -1) for force in (-0.6, 0.0, 0.6)],
    ShelfTravel: [Site(cycle, sign, 0.1) for cycle in CYCLES for sign in (1, -1)],
    KneePeak: [Site(cycle, sign) for cycle in CYCLES for sign in (1, -1)],
    Amplitude: [Site(cycle) for cycle in CYCLES],
    NormalForce: [Site(cycle) for cycle in CYCLES],
    NormalForceByDirection: [Site(cycle) for cycle in CYCLES],
    NormalForceAtEnds: [Site(cycle) for cycle in CYCLES],
    NormalForceBySides: [Site(cycle) for cycle in CYCLES],
    Energy: [Site(cycle) for cycle in CYCLES],
    SlipAmplitude: [Site(cycle) for cycle in CYCLES],
    LargestForce: [Site(cycle) for cycle in CYCLES],
    ScarFigures: [Site(CYCLES[-1], wire=wire, figure="depth") for wire in ("moving", "fixed")],
    ScarSkew: [Site(CYCLES[-1], wire=wire) for wire in ("moving", "fixed")],
    # Wires have none.
    ProfileDepths: [],
}

#: Those in newtons.
FORCES = (
    PlateauForce,
    KneePeak,
    NormalForce,
    NormalForceByDirection,
    NormalForceAtEnds,
    NormalForceBySides,
    LargestForce,
)


def layout(*kinds: type[Observable]) -> Layout:
    return Layout.of_sites(*((one, SITES[type(one)]) for one in all_observables() if not kinds or type(one) in kinds))


def heavier(setup: Setup, factor: float) -> Setup:
    """The same test under so many times the load: forces and energies grow, displacements and volumes do not."""
    return replace(
        setup,
        load_N=factor * setup.load_N,
        compliance_um_per_N=setup.compliance_um_per_N / factor,
        normal_spring_N_per_um=factor * setup.normal_spring_N_per_um,
        wear_um3_per_mJ=setup.wear_um3_per_mJ / factor,
    )


def heavier_states(factor: float) -> WearStates:
    own = states()
    return replace(
        own,
        normal_load_N=factor * own.normal_load_N,
        stiffness_N_per_um=factor * own.stiffness_N_per_um,
        load_drop_N=factor * own.load_drop_N,
        lift_N=factor * own.lift_N,
    )


def wandering(observed: Observations, share: float) -> Observations:
    """The observations with strokes that grow by this share in one repeat and shrink in another."""
    values = observed.values.copy()
    at = np.flatnonzero(observed.layout.of_kind(Amplitude))
    rise = np.linspace(-1.0, 1.0, at.size)
    for repeat, sign in enumerate((1.0, -1.0)):
        values[repeat, at] += share * sign * rise * nominal("sensor").amplitude_um
    return replace(observed, values=values)


def covariance_of(observed: Observations) -> Covariance:
    return estimate(states(), nominal("sensor"), observed)


def correlations(covariance: Array) -> Array:
    sizes = np.sqrt(np.diag(covariance))
    return np.asarray(covariance / np.outer(sizes, sizes))


@pytest.mark.parametrize("cycles", [1.0, 1e3, 1e5])
def test_every_number_has_an_error_of_the_solvers_and_the_covariance_is_definite(cycles: float) -> None:
    whole = layout()
    covariance = solver_covariance(states(), replace(nominal(), cycles=cycles), whole)
    np.testing.assert_allclose(covariance, covariance.T, rtol=1e-12)
    assert np.diag(covariance).min() > 0.0
    assert np.linalg.eigvalsh(correlations(covariance)).min() > 1e-9


def test_by_how_much_a_scar_adds_friction_is_unsure_in_the_middle_of_the_stroke_once_it_is_worn() -> None:
    own, middle = states(), layout(PlateauForce)
    worn = np.linspace(0.0, 1.0, own.log_similarity.size)
    angle = np.zeros_like(own.angle)
    angle[:, 0] = 0.04 * worn
    steeper = replace(own, angle=angle)
    change_N = derivatives(steeper, nominal(), middle, {"angle_rise": 1.0})[:, 0]
    here = np.flatnonzero(middle.parts[0].sites.level == 0.0)
    sites = middle.parts[0].sites
    forward, back = (change_N[here[sites.branch[here] == side]] for side in (1, -1))
    np.testing.assert_allclose(forward, -back, rtol=1e-6)
    assert np.all(np.diff(forward) > 0.0)
    friction = nominal().friction
    most_N = nominal().load_N * (np.tan(np.arctan(friction) + 0.04) - friction)
    assert 0.0 <= forward[0] < forward[-1] <= most_N * 1.01
    assert not derivatives(own, nominal(), middle, {"angle_rise": 1.0}).any()


def test_every_observable_of_the_library_is_among_those_tested() -> None:
    assert set(SITES) == set(LIBRARY)


@settings(max_examples=4, deadline=None)
@given(st.randoms(use_true_random=False))
def test_the_order_in_which_numbers_are_listed_changes_nothing(random: Random) -> None:
    parts = [(one, [*SITES[type(one)]]) for one in all_observables()]
    random.shuffle(parts)
    for _, sites in parts:
        random.shuffle(sites)
    shuffled = Layout.of_sites(*parts)
    whole = layout()

    def names(one: Layout) -> list[tuple[str, Site]]:
        return [(part.observable.name, site) for part in one for site in part.sites]

    place = [names(shuffled).index(name) for name in names(whole)]
    for compute in (remainder, solver_covariance):
        expected, found = (compute(states(), nominal(), one) for one in (whole, shuffled))
        np.testing.assert_allclose(found[np.ix_(place, place)], expected, rtol=1e-9, atol=1e-14)


@pytest.mark.parametrize("factor", [0.5, 3.0])
def test_under_another_load_solvers_differ_by_the_same_share_of_the_forces(factor: float) -> None:
    forces = layout(*FORCES)
    own = remainder(states(), nominal(), forces)
    other = remainder(heavier_states(factor), heavier(nominal(), factor), forces)
    np.testing.assert_allclose(other, factor**2 * own, rtol=1e-6, atol=1e-12)


def test_walls_that_solvers_compute_higher_move_forces_and_no_scar() -> None:
    whole = layout()
    covariance = remainder(states(), nominal(), whole)
    scars = whole.of_kind(ScarFigures, ScarSkew)
    assert np.all(covariance[np.ix_(scars, ~scars)] == 0.0)
    late = whole.cycle == CYCLES[-1]
    between = correlations(covariance)[np.ix_(whole.of_kind(Energy) & late, whole.of_kind(LargestForce) & late)]
    # A higher wall takes slip, and energy with it.
    assert between.max() < -0.05


def test_both_branches_of_a_loop_differ_alike_under_a_turn_of_the_loop_but_knees_do_not() -> None:
    turned = {}
    for kind in (PlateauForce, Stick, KneePeak):
        one = layout(kind)
        correlation = correlations(free_covariance(one, nominal(), np.ones(len(one)), 0.1))
        (sites,) = (part.sites for part in one)
        there, back = (
            (sites.cycle == CYCLES[0]) & (sites.branch == sign) & (np.abs(sites.level) < 1e-9) for sign in (1, -1)
        )
        turned[kind] = float(correlation[there, back][0])
    assert turned[PlateauForce] == pytest.approx(turned[Stick])
    assert -1.0 < turned[PlateauForce] < -0.2
    assert turned[KneePeak] == 0.0


def test_what_differs_hangs_together_less_the_more_decades_of_cycles_lie_between() -> None:
    one = layout(Amplitude)
    decades = correlations(remainder(states(), nominal(), one))[0]
    assert list(decades) == sorted(decades, reverse=True)
    assert decades[-1] < 0.1


def test_free_differences_grow_with_their_size_and_are_zero_at_none() -> None:
    one = layout()
    small, large, none = (free_covariance(one, nominal(), np.ones(len(one)), share) for share in (0.1, 0.2, 0.0))
    np.testing.assert_allclose(large, 4.0 * small)
    assert not none.any()


def test_strokes_that_wander_between_repeats_are_scatter_and_take_the_stick_branches_along() -> None:
    steady = reduce(record(repeats=2))
    calm, moved = covariance_of(steady), covariance_of(wandering(steady, 0.01))
    for kind in (Amplitude, Stick):
        rows = steady.layout.of_kind(kind)
        assert (np.diag(moved.between)[rows] > 1.5 * np.diag(calm.between)[rows]).all()
    strokes = np.flatnonzero(steady.layout.of_kind(Amplitude))
    # The stroke of one test says little of the same test's stroke three decades later.
    assert correlations(moved.between[np.ix_(strokes, strokes)])[0, -1] < 0.7


def test_one_repeat_is_expected_to_wander_too() -> None:
    observed = reduce(record(repeats=1))
    one = covariance_of(observed)
    sampling = observed.noise[0, observed.layout.of_kind(Amplitude)]
    assert np.sqrt(np.diag(one.between)[observed.layout.of_kind(Amplitude)]).min() > sampling.max()


def test_a_stroke_that_wanders_alike_in_every_test_is_no_gap() -> None:
    """Repeats agree on what their drive does: they tell nothing of it."""
    observed = reduce(record(repeats=3))
    strokes = observed.layout.of_kind(Amplitude)
    total = covariance_of(observed).total[np.ix_(strokes, strokes)]
    wander = 0.002 * nominal("sensor").amplitude_um * np.linspace(-1.0, 1.0, int(strokes.sum()))
    assert wander @ np.linalg.solve(total, wander) < 4.0


def test_repeats_that_scatter_more_are_known_worse() -> None:
    calm, wild = (covariance_of(reduce(record(repeats=3, scatter=scatter))) for scatter in (1.0, 6.0))
    assert wild.scatter["friction"] > 2.0 * calm.scatter["friction"]
    assert np.trace(wild.between) > 2.0 * np.trace(calm.between)


def test_whitened_gap_free_residuals_are_standard_deviates_at_most() -> None:
    """Records of the model itself differ by noise and scatter alone, so less than solvers are allowed to."""
    observed = reduce(record(repeats=3))
    covariance = covariance_of(observed)
    problem = Problem.of(states(), nominal("sensor"), observed.layout, covariance)
    whitened = problem.whitened(problem.setup)
    assert np.mean(whitened**2) < 1.0
    assert np.abs(whitened).max() < 4.0
