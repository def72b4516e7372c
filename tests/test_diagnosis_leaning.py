"""Readings that lean against the force by more than the contact yields: they run backwards while it sticks."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.diagnosis_cases import diagnosed, nominal, record, states, with_effect
from wirewear.diagnosis.model.forward import simulate
from wirewear.diagnosis.observe.measured_loops import reduced_loop
from wirewear.records import ExperimentRecord

COUPLING = "displacement_load_coupling"


def leaning(linear: float, quadratic: float = 0.0) -> ExperimentRecord:
    """A record of a rigid holder and an imposed stroke whose reading then follows the force as well."""
    plain = record(stiffness_N_per_mm="rigid", drive="stroke", evolution=False)
    loops = [
        replace(
            loop,
            displacement_um=loop.displacement_um
            + linear * loop.tangential_force_N
            + quadratic * loop.tangential_force_N**2,
        )
        for loop in plain.loops
    ]
    return replace(plain, loops=tuple(loops))


@pytest.mark.slow
@pytest.mark.parametrize("linear", [-5.0, -3.2, -1.2])
def test_load_coupling_is_named_whether_or_not_the_reading_runs_back(linear: float) -> None:
    answer = diagnosed(leaning(linear, -0.1 * linear)).diagnosis
    assert answer.verdict == "explained"
    assert answer.causes[0].effect == COUPLING
    found = answer.causes[0].parameters["linear_um_per_N"]
    assert found.interval95[0] <= linear <= found.interval95[1]
    assert found.value == pytest.approx(linear, rel=0.1)


def test_the_branches_of_a_reading_that_runs_back_begin_at_the_reversal() -> None:
    one = leaning(-3.2)
    for loop in one.loops:
        for branch in reduced_loop(loop, one.tables.noise).branches:
            assert branch.force_N[0] < -0.5 * branch.force_N.max()
            assert branch.displacement_um[branch.knee] < branch.displacement_um[0] - 4.0


@pytest.mark.parametrize("linear", [-5.0, -3.2])
def test_they_begin_there_after_walls_have_grown_too(linear: float) -> None:
    """A flank that falls from a wall is long: halfway down it the contact still sticks."""
    one = leaning(linear, -0.9)
    for loop in one.loops:
        for branch in reduced_loop(loop, one.tables.noise).branches:
            assert -branch.force_N[:3].min() > 0.85 * branch.force_N[-20:].max()
            assert branch.force_N[-3:].max() > 0.85 * branch.force_N[-20:].max()


@settings(max_examples=12, deadline=None)
@given(linear=st.floats(-12.0, 8.0), quadratic=st.floats(-1.5, 1.5), cycles=st.sampled_from([100.0, 10_000.0, 1e5]))
def test_a_drive_that_holds_a_reading_holds_its_extent_wherever_it_is_outermost(
    linear: float, quadratic: float, cycles: float
) -> None:
    values = {"linear_um_per_N": linear, "quadratic_um_per_N2": quadratic}
    setup = with_effect(nominal("sensor"), COUPLING, values)
    x = simulate(states(), setup, np.array([cycles])).displacement_um
    np.testing.assert_allclose(0.5 * (x.max() - x.min()), setup.amplitude_um, rtol=2e-3)


def test_a_reading_that_leans_far_is_outermost_where_sliding_begins() -> None:
    setup = with_effect(nominal("sensor"), COUPLING, {"linear_um_per_N": -12.0, "quadratic_um_per_N2": 0.0})
    x = simulate(states(), setup, np.array([100.0, 10_000.0])).displacement_um
    # Nominally the rig yields 6 µm/N.
    assert np.all(x[:, 0, 0] > x[:, 0].min(axis=1) + 5.0)
