"""Pressed bodies that yield, beside the curves of Jackson and Green and of Kogut and Etsion, and beside themselves."""

from dataclasses import replace

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

import solvers
from geometry import ContactPatch, Cylinder
from geometry.arrays import Array
from solvers.contact_state import ContactState, IncrementReport
from solvers.laws.yielding import PressureLimit
from tests.bodies import pressed
from tests.solvers import test_contact_bodies as known
from wirewear.reference import hertz_point
from wirewear.verification.near_zone import RATIO, jackson_green, kogut_etsion

pytestmark = pytest.mark.seconds
MODULUS_MPa = known.MODULUS_MPa / 0.75 / 2.0  # E*, of two incompressible half-spaces.
HERTZ = hertz_point(known.LOAD_N, known.RADIUS_mm, MODULUS_MPa)


@pytest.fixture(scope="module")
def elastic() -> solvers.ContactProblem:
    """Crossed cylinders on half-spaces, five elements to the contact's radius."""
    lines = known.STEP_mm * np.arange(-9.0, 10.0)
    patch = ContactPatch(lines, lines, np.arange(361).reshape(19, 19), Cylinder(known.RADIUS_mm))
    body = solvers.CondensedBody.whole(patch, known.HalfSpace(patch.grid()).dense)
    return known.crossed(body)


def limit_at(beyond: float) -> PressureLimit:
    """What bodies bear whose load is so many times that of first yield."""
    stress = HERTZ.peak_pressure_MPa / (RATIO * beyond ** (1.0 / 3.0))
    return PressureLimit(stress, RATIO, known.LOAD_N / beyond, HERTZ.approach_mm)


def test_printed_bodies_bear_what_they_did_under_any_load_up_to_it() -> None:
    fresh, load = limit_at(8.7), known.LOAD_N
    limit = fresh.borne_MPa(1234.0, load, 0.3 * fresh.overlap_mm)
    unloaded, again, more = limit.at_nodes(load * np.array([0.2, 1.0, 3.0]), np.full(3, 0.3 * fresh.overlap_mm)).limit
    assert (unloaded, again) == pytest.approx((1234.0, 1234.0), rel=1e-5)
    assert more / again == pytest.approx(float(fresh.limit_MPa(3.0 * load) / fresh.limit_MPa(load)), rel=1e-5)


def prints_of(state: ContactState) -> tuple[Array, Array]:
    primary, secondary = state.wear.prints
    assert primary is not None
    assert secondary is not None
    return primary, secondary


def yielded(elastic: solvers.ContactProblem, limit: PressureLimit) -> tuple[ContactState, IncrementReport]:
    return pressed(replace(elastic, limit=limit))


def test_bodies_that_do_not_reach_their_limit_are_elastic_bit_for_bit(elastic: solvers.ContactProblem) -> None:
    (state, report), (own, of) = pressed(elastic), yielded(elastic, limit_at(0.5))
    assert np.array_equal(own.traction, state.traction)
    assert (own.holder_z, of) == (state.holder_z, report)
    assert not any(print_mm.any() for print_mm in prints_of(own))


@pytest.mark.parametrize("beyond", [1.5, 4.1, 8.7, 27.0])
def test_force_at_a_penetration_is_that_of_published_curves(elastic: solvers.ContactProblem, beyond: float) -> None:
    """The limit is fitted to largest pressures of finite elements, which know nothing of either curve."""
    limit = limit_at(beyond)
    state, report = yielded(elastic, limit)
    # The mesh alone makes the elastic contact so much stiffer.
    mesh = -pressed(elastic)[0].holder_z / HERTZ.approach_mm
    approach = -state.holder_z / mesh
    assert report.normal_force == pytest.approx(known.LOAD_N, rel=1e-6)
    assert report.max_pressure == pytest.approx(limit.limit_MPa(known.LOAD_N), rel=0.01)
    at = approach, known.RADIUS_mm, MODULUS_MPa, limit.yield_stress_MPa
    assert jackson_green(*at) == pytest.approx(known.LOAD_N, rel=0.05)
    assert kogut_etsion(*at) == pytest.approx(known.LOAD_N, rel=0.07)


def test_pressed_again_bodies_are_elastic_and_under_more_load_they_yield_again(elastic: solvers.ContactProblem) -> None:
    problem = replace(elastic, limit=limit_at(8.7))
    state, _ = pressed(problem)
    for share, yields in ((0.5, False), (1.0, False), (1.3, True)):
        other = replace(problem, holder=solvers.Holder(share * known.LOAD_N))
        again, _ = solvers.press(other, replace(solvers.unloaded_state(other), wear=state.wear))
        (before, _), (after, _) = prints_of(state), prints_of(again)
        assert (float((after - before).max()) > 0.02 * before.max()) == yields
        assert yields or np.abs(after - before).max() < 1e-4 * before.max()


@pytest.mark.parametrize(("share", "primary", "secondary"), [(0.5, 1.0, 1.0), (1.0, 2.0, 0.0), (0.0, 0.0, 2.0)])
def test_equal_bodies_share_the_print_and_else_the_softer_one_takes_it(
    elastic: solvers.ContactProblem, share: float, primary: float, secondary: float
) -> None:
    areas = elastic.surface.areas
    whole = sum(float(areas @ print_mm.ravel()) for print_mm in prints_of(yielded(elastic, limit_at(8.7))[0]))
    state, _ = yielded(elastic, replace(limit_at(8.7), upper_share=share))
    left = [2.0 * float(areas @ print_mm.ravel()) / whole for print_mm in prints_of(state)]
    assert left == pytest.approx([primary, secondary], abs=0.03)


def test_work_is_stored_or_plastic(elastic: solvers.ContactProblem) -> None:
    """Of a constant limit, for one that grows with the load does work of its own."""
    limit = PressureLimit(0.5 * HERTZ.peak_pressure_MPa, 1.0, 1e6, HERTZ.approach_mm)
    problem = replace(elastic, limit=limit, friction=0.0)
    state = replace(solvers.unloaded_state(problem), load_share=0.0, pressed_z=0.0)
    places, loads = [0.0], [0.0]
    shares = np.concatenate([np.linspace(0.0, 1.0, 25)[1:] ** 1.5, np.linspace(1.0, 0.02, 25)[1:] ** 1.5])
    with threadpool_limits(limits=1, user_api="blas"):
        for share in shares:
            state, reports = solvers.advance(problem, state, 0.0, 0.0, load_share=float(share))
            places.append(-state.holder_z)
            loads.append(reports[-1].normal_force)
    work, stored = np.trapezoid(loads[:25], places[:25]), -np.trapezoid(loads[24:], places[24:])
    assert state.wear.plastic_mJ > 0.2 * work
    assert work == pytest.approx(stored + state.wear.plastic_mJ, rel=5e-3)
