"""Debris that moves to the contact's edge: its balance, its steady thickness, its limits, what it protects."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import solvers
from geometry.arrays import Array
from solvers.laws.debris import staying
from tests.solvers.wear_jumps import RATES, LINE_LOAD_N_per_mm, at_the_end, jumped, line_contact

pytestmark = pytest.mark.seconds
RETAINED = 0.4
SMALL_STROKE_mm = 0.012  #: Small beside the contact, which then rests on both bodies.


def worn(
    flow: solvers.DebrisFlow | None, *jumps: float, rates: tuple[float, float] = RATES, retained: float = RETAINED
) -> list[solvers.ContactState]:
    """States of a line contact after each of some jumps."""
    layers = (solvers.ThirdBody(retained),) if retained else ()
    contact = replace(line_contact(wear=solvers.WearRates(*rates)), layers=layers, debris=flow)
    states = [at_the_end(contact, SMALL_STROKE_mm)]
    for cycles in jumps:
        states.append(jumped(contact, states[-1], cycles, stroke_mm=SMALL_STROKE_mm).state)
    return states


def volumes(state: solvers.ContactState) -> tuple[Array, Array]:
    """Volumes per mm of length that the pad and the flat have lost, and of the debris of each."""
    contact = line_contact()
    areas, wear = (contact.primary.node_areas, contact.secondary.node_areas), state.wear
    return tuple(  # type: ignore[return-value]
        np.array([area @ field.ravel() for area, field in zip(areas, pair, strict=True)])
        for pair in (wear.depths, wear.debris(RETAINED))
    )


@given(st.lists(st.floats(0.0, 30.0), min_size=1, max_size=8), st.floats(1e-3, 20.0))
def test_thickness_follows_the_exponential_of_its_balance_over_any_steps(steps: list[float], rate: float) -> None:
    thickness = 0.5
    for step in steps:
        before, made = staying(np.array([rate * step]))
        thickness = float((before * thickness + made * 2.0 * step)[0])
    settled = 2.0 / rate
    assert thickness == pytest.approx(settled + (0.5 - settled) * np.exp(-rate * sum(steps)), rel=1e-9, abs=1e-9)


def test_debris_settles_where_what_wears_equals_what_leaves() -> None:
    moving = 0.4
    *_, before, last = worn(solvers.DebrisFlow(moving), 100.0, 200.0, 400.0, 800.0, 100.0)
    wear, contact = last.wear, line_contact()
    x, touches = contact.primary.patch.axial_mm, last.traction[:, 2] > 0.0
    # At the other end of the stroke the mirror image of these nodes touches.
    half = float(np.abs(x[touches]).max()) + 0.5 * contact.primary.patch.smallest_element
    source = RETAINED * (wear.primary_depth - before.wear.primary_depth).ravel() / 100.0
    path = (wear.energy_mJ - before.wear.energy_mJ) / 100.0 / (contact.friction * LINE_LOAD_N_per_mm)
    inside = np.abs(x) < 0.6 * half
    settled = (source * (half - np.abs(x)) / (moving * path))[inside]
    assert wear.debris(RETAINED)[0].ravel()[inside] == pytest.approx(settled, rel=0.01)


def test_what_wears_stays_or_leaves() -> None:
    for state in worn(solvers.DebrisFlow(0.01), 50.0, 400.0, 800.0)[1:]:
        lost, there = volumes(state)
        assert (there > 0.0).all()
        assert (there < RETAINED * lost).all()
    assert lost == pytest.approx(RATES[0] * state.wear.energy_mJ, rel=1e-12)


def test_no_debris_leaves_without_motion_and_all_of_it_with_fast_motion() -> None:
    still, bed = worn(solvers.DebrisFlow(0.0), 50.0, 400.0)[-1], worn(None, 50.0, 400.0)[-1]
    assert still.wear.primary_depth == pytest.approx(bed.wear.primary_depth, rel=1e-9, abs=1e-14)
    assert still.wear.debris(RETAINED)[0] == pytest.approx(RETAINED * still.wear.primary_depth, rel=1e-9, abs=1e-15)
    fast, bare = worn(solvers.DebrisFlow(1e6), 50.0, 400.0)[-1], worn(None, 50.0, 400.0, retained=0.0)[-1]
    assert fast.wear.primary_depth == pytest.approx(bare.wear.primary_depth, abs=1e-3 * bare.wear.primary_depth.max())
    assert fast.wear.energy_mJ == pytest.approx(bare.wear.energy_mJ, rel=1e-4)


def test_debris_protects_the_more_the_thicker_it_is() -> None:
    bare = solvers.DebrisFlow(0.01)
    free, covered = (worn(flow, 50.0, 400.0, 800.0)[-1] for flow in (bare, replace(bare, protecting_mm=5e-5)))
    shares = [volumes(state)[0].sum() / (sum(RATES) * state.wear.energy_mJ) for state in (free, covered)]
    assert shares[0] == pytest.approx(1.0, rel=1e-9)
    assert 0.3 < shares[1] < 0.9


@pytest.mark.parametrize("wrong", [{"moving": -0.1}, {"moving": 0.1, "protecting_mm": 0.0}])
def test_debris_without_sense_is_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(solvers.SolverError, match="debris must move"):
        solvers.DebrisFlow(**wrong)
