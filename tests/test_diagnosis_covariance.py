"""What differs between tests and between solvers without any gap, as the diagnosis expects it, whatever its sizes."""

from dataclasses import replace
from random import Random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.arrays import Array
from tests.diagnosis_cases import nominal, record, states
from wirewear.diagnosis.infer.covariance import Covariance, estimate, remainder, solver_covariance, tolerated
from wirewear.diagnosis.infer.inference import Problem
from wirewear.diagnosis.model.setup import Setup
from wirewear.diagnosis.model.wear_states import WearStates
from wirewear.diagnosis.observe import Observable, Site, channels
from wirewear.diagnosis.observe.evolution import Energy, LargestForce, SlipAmplitude
from wirewear.diagnosis.observe.plateau import KneePeak, PlateauForce
from wirewear.diagnosis.observe.reduction import Layout, Observations, all_observables, reduce
from wirewear.diagnosis.observe.scars import ProfileDepths, ScarFigures, ScarSkew
from wirewear.diagnosis.observe.stick import ShelfTravel, Stick
from wirewear.records.tables import Tolerance

CYCLES = (1, 300, 10_000, 100_000)

#: Some numbers of every observable of loops.
SITES: dict[type[Observable], list[Site]] = {
    PlateauForce: [
        Site(cycle, sign, sign * at) for cycle in CYCLES for sign in (1, -1) for at in (-20.0, 0.0, 46.0, 54.0)
    ],
    Stick: [Site(cycle, sign, force) for cycle in CYCLES for sign in (1, -1) for force in (-0.6, 0.0, 0.6)],
    ShelfTravel: [Site(cycle, sign, 0.1) for cycle in CYCLES for sign in (1, -1)],
    KneePeak: [Site(cycle, sign) for cycle in CYCLES for sign in (1, -1)],
    channels.Amplitude: [Site(cycle) for cycle in CYCLES],
    channels.NormalForce: [Site(cycle) for cycle in CYCLES],
    channels.NormalForceByDirection: [Site(cycle) for cycle in CYCLES],
    channels.NormalForceAtEnds: [Site(cycle) for cycle in CYCLES],
    channels.NormalForceBySides: [Site(cycle) for cycle in CYCLES],
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
    channels.NormalForce,
    channels.NormalForceByDirection,
    channels.NormalForceAtEnds,
    channels.NormalForceBySides,
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


def covariance_of(observed: Observations) -> Covariance:
    return estimate(states(), nominal("sensor"), observed)


def correlations(covariance: Array) -> Array:
    sizes = np.sqrt(np.diag(covariance))
    return np.asarray(covariance / np.outer(sizes, sizes))


@pytest.mark.seconds
@pytest.mark.parametrize("cycles", [1.0, 1e3, 1e5])
def test_every_number_has_an_error_of_the_solvers_and_the_covariance_is_definite(cycles: float) -> None:
    whole = layout()
    setup = replace(nominal(), cycles=cycles)
    within = tolerated(states(), setup, whole, Tolerance().model_dump())
    covariance = solver_covariance(states(), setup, whole) + within
    np.testing.assert_allclose(covariance, covariance.T, rtol=1e-12)
    assert np.diag(covariance).min() > 0.0
    assert np.linalg.eigvalsh(correlations(covariance)).min() > 1e-9


@pytest.mark.seconds
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


@pytest.mark.seconds
def test_a_stroke_that_wanders_alike_in_every_test_is_no_gap() -> None:
    """Repeats agree on what their drive does: they tell nothing of it."""
    observed = reduce(record(repeats=3))
    strokes = observed.layout.of_kind(channels.Amplitude)
    total = covariance_of(observed).total[np.ix_(strokes, strokes)]
    wander = 0.002 * nominal("sensor").amplitude_um * np.linspace(-1.0, 1.0, int(strokes.sum()))
    assert wander @ np.linalg.solve(total, wander) < 4.0


@pytest.mark.seconds
def test_whitened_gap_free_residuals_are_standard_deviates_at_most() -> None:
    """Records of the model itself differ by noise and scatter alone, so less than solvers are allowed to."""
    observed = reduce(record(repeats=3))
    covariance = covariance_of(observed)
    problem = Problem.of(states(), nominal("sensor"), observed.layout, covariance)
    whitened = problem.whitened(problem.setup)
    assert np.mean(whitened**2) < 1.0
    assert np.abs(whitened).max() < 4.0
