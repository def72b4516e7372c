"""Travel without force on stick branches of few samples: what they allow, and what a play adds to it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.diagnosis_cases import nominal, record, states, with_effect
from wirewear.diagnosis.infer.search import search
from wirewear.diagnosis.infer.solver_differences import remainder
from wirewear.diagnosis.model.forward import simulate
from wirewear.diagnosis.model.setup import Array
from wirewear.diagnosis.observe.branch import ObservedBranch
from wirewear.diagnosis.observe.evolution import SlipAmplitude
from wirewear.diagnosis.observe.layout import Layout
from wirewear.diagnosis.observe.reduction import Observations, reduce
from wirewear.diagnosis.observe.shelf import ShelfTravel, travel_between
from wirewear.diagnosis.observe.sites import Site

#: Samples of a loop with which its stick branches have few.
FEW = 60


def branch(shelf_um: float, phase: float, step_um: float) -> ObservedBranch:
    """A branch that rises to 1 N by 2 N/µm, floats over the shelf at zero, rises to 1 N and slides."""
    x = np.arange(phase * step_um, 60.0, step_um)
    force = np.clip(2.0 * x, 0.0, 1.0) - 1.0 + np.clip(2.0 * (x - 0.5 - shelf_um), 0.0, 1.0)
    return ObservedBranch(1, x, force, int(np.argmax(force > 1.0 - 1e-9)))


def shelves(observed: Observations) -> Array:
    rows = observed.layout.of_kind(ShelfTravel)
    values: Array = observed.values[0, rows]
    return values


@given(shelf_um=st.floats(0.0, 8.0), phase=st.floats(0.0, 1.0), step_um=st.floats(0.05, 3.0))
def test_the_true_travel_lies_within_what_samples_allow_wherever_they_fall(
    shelf_um: float, phase: float, step_um: float
) -> None:
    travel, unsure = travel_between(branch(shelf_um, phase, step_um), 0.1)
    if np.isfinite(travel):
        # Between ±0.1 N the elastic parts take 0.05 µm each. Between one sample and the next lies any length.
        assert abs(travel - shelf_um - 0.1) <= np.sqrt(12.0) * unsure + 1e-9
        assert unsure <= 2.0 * step_um / np.sqrt(12.0) + 1e-9


@given(phase=st.floats(0.0, 1.0), step_um=st.floats(0.05, 0.4))
def test_an_even_flank_has_its_own_travel_without_bias(phase: float, step_um: float) -> None:
    travel, _ = travel_between(branch(0.0, phase, step_um), 0.04)
    assert np.isnan(travel) or travel == pytest.approx(0.04, abs=1e-6) or step_um < 0.04 + 1e-9


def test_a_reading_that_runs_back_has_a_negative_travel() -> None:
    forth = branch(0.0, 0.5, 0.2)
    back = ObservedBranch(1, -forth.displacement_um, forth.force_N, forth.knee)
    travel, unsure = travel_between(forth, 0.1)
    assert travel_between(back, 0.1) == (-travel, unsure)


def test_a_branch_that_begins_without_force_tells_nothing() -> None:
    force = np.linspace(-0.05, 1.0, 30)
    assert np.isnan(travel_between(ObservedBranch(1, np.linspace(0.0, 60.0, 30), force, 20), 0.1)).all()


def test_shelves_are_read_where_samples_are_few_and_only_there() -> None:
    few, many = (reduce(record(repeats=1, samples=count)) for count in (FEW, 400))
    assert few.layout.of_kind(ShelfTravel).any()
    assert not many.layout.of_kind(ShelfTravel).any()


def test_a_play_lengthens_the_computed_travel_by_its_gap() -> None:
    layout = reduce(record(repeats=1, samples=FEW)).layout
    rows = layout.of_kind(ShelfTravel)
    plain, loose = (
        layout.observed(simulate(states(), setup, layout.cycles))[rows]
        for setup in (nominal("sensor"), with_effect(nominal("sensor"), "free_play", {"gap_um": 3.0}))
    )
    np.testing.assert_allclose(loose - plain, 3.0, atol=0.1)


@pytest.mark.slow
def test_a_play_of_few_samples_is_measured_within_what_they_allow_and_named() -> None:
    one = reduce(record({"free_play": {"gap_um": 3.0}}, repeats=1, samples=FEW))
    plain = reduce(record(repeats=1, samples=FEW))
    assert np.median(shelves(one)) - np.median(shelves(plain)) == pytest.approx(3.0, abs=1.0)
    found = search(states(), nominal("sensor"), one)
    assert found.best.names == ("free_play",)
    unseen = search(states(), nominal("sensor"), plain)
    assert unseen.best.log_evidence - unseen.none.log_evidence < 2.0


def test_slip_amplitudes_read_on_a_shelf_are_unsure_together() -> None:
    layout = Layout.of_sites((SlipAmplitude(), [Site(cycle) for cycle in (100, 100_000)]))
    plain = nominal("sensor")
    firm, loose = (
        remainder(states(), setup, layout) for setup in (plain, with_effect(plain, "free_play", {"gap_um": 3.0}))
    )
    # Anywhere on most of a shelf of 3 µm: up to 3/√12 for what all readings share.
    assert 0.5 < (loose[0, 1] - firm[0, 1]) / (3.0**2 / 12.0) <= 1.0
    assert firm[0, 1] < 0.1 * loose[0, 1]
