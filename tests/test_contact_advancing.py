"""Increments that Newton's method does not solve at once: they are cut, and no longer led by a guess."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from threadpoolctl import threadpool_limits

from solvers import Drive, NotConvergedError, place
from solvers.contact import ContactProblem, advance, advancing, unloaded_state
from solvers.contact.acceptance import largest_within
from solvers.contact.advancing import IncrementFailedError
from solvers.contact.linearisation import faced
from solvers.contact_state import FirstGuess
from solvers.fretting import anew
from solvers.newton import iteration
from tests.bodies import LOAD_N, condensed_wire, crossed_wires, driven, pressed
from tests.studies import MINIMAL
from tests.wear_jumps import INCREMENTS, RATES, at_the_end, jumped
from wirewear import parse_study
from wirewear.simulation import discretise

STROKE_mm = 4.0e-4
NEXT_TO_NOTHING_mm = 1e-9

MESH_mm = 0.010
# Stick, slip and reversal, but not the knee between them, where a coarse mesh decides.
STEPS_mm = 1e-3 * np.array([0.1, 0.2, 1.5, 4.0, 3.9, 1.0])


def test_bodies_pressed_anew_around_worn_scars_leave_no_friction_on_what_sticks() -> None:
    problem = crossed_wires(0.005, wear=RATES)
    worn = jumped(problem, at_the_end(problem, STROKE_mm), 2e4, stroke_mm=STROKE_mm).state
    assert worn.core.sum() > 4
    with threadpool_limits(limits=1, user_api="blas"):
        state = anew(problem, worn, Drive(NEXT_TO_NOTHING_mm), INCREMENTS)
    core = np.flatnonzero(worn.core)
    frames = faced(problem, state, core, state.drive, state.holder_x, state.holder_tilt).frames
    pressure, *friction = np.einsum("ikj,ij->ki", frames, state.traction[core])
    assert np.hypot(*friction).max() < 1e-3 * problem.friction * pressure.max()


@pytest.mark.slow
def test_wear_beside_a_core_does_not_open_it_where_the_nodes_of_both_bodies_do_not_meet() -> None:
    upper, lower = crossed_wires(0.005, wear=RATES).upper, crossed_wires(0.0047).lower
    problem = replace(crossed_wires(0.005, wear=RATES), upper=upper, lower=lower)
    fresh = at_the_end(problem, STROKE_mm)
    worn = jumped(problem, fresh, 2e4, stroke_mm=STROKE_mm).state
    core = np.flatnonzero(worn.core)
    gap = [
        faced(problem, replace(worn, wear=of.wear), core, worn.drive, worn.holder_x, worn.holder_tilt).gap
        for of in (fresh, worn)
    ]
    assert worn.wear.secondary_depth.max() > 1e-5
    np.testing.assert_allclose(gap[1], gap[0], atol=1e-3 * worn.wear.secondary_depth.max())


def _band(edge: float, nodes: int = 24) -> np.ndarray:
    """Nodal pressures of a band of uniform pressure 1 from 0 to `edge`: nodes within carry the load of all of it.

    Half of the last node's area, and what of the next ends beyond it, is the last node's.
    """
    line = np.zeros(nodes)
    last = int(edge)
    line[1 : last + 1] = 1.0
    line[last] += edge - last - 0.5
    return line


@given(st.floats(4.5, 16.4))
def test_where_the_rim_falls_between_nodes_does_not_show(edge: float) -> None:
    """Nodal pressures swing between a half and one and a half of the true one."""
    assert largest_within(_band(edge)[:, None]) == pytest.approx(1.0, abs=0.26)
    assert largest_within(np.outer(_band(edge), _band(12.0))) == pytest.approx(1.0, abs=0.26)


@pytest.mark.parametrize(("slip_mm", "told"), [(1e-6, 0.1), (1e-17, 0.0)])
def test_slip_that_is_round_off_has_no_direction_that_friction_could_miss(
    monkeypatch: pytest.MonkeyPatch, slip_mm: float, told: float
) -> None:
    """One node under pressure whose friction lies 0.1 rad off the slip; the bodies close by a micrometre."""
    monkeypatch.setattr(iteration, "unbalanced_force", lambda *_: 0.0)
    system = SimpleNamespace(friction=SimpleNamespace(none=False), compliance=SimpleNamespace(layer=0.0))
    conditions = SimpleNamespace(
        system=system, count=1, world=lambda normal, tangential: np.column_stack([tangential, normal])
    )
    state = SimpleNamespace(
        normal=np.array([1000.0]),
        tangential=np.array([[600.0, 0.0]]),
        slip=slip_mm * np.array([[np.cos(0.1), np.sin(0.1)]]),
        gap=np.zeros(1),
        elastic=1e-3,
        holder_x=0.0,
        height=0.0,
        tilt=0.0,
    )
    friction = SimpleNamespace(stick=np.array([False]), direction=np.array([[-1.0, 0.0]]))
    found = iteration.converged_outcome(
        cast("Any", conditions), cast("Any", state), np.array([True]), cast("Any", friction), 3
    )
    assert found.slip_direction_error == pytest.approx(told, abs=1e-9)
    assert found.slip_length[0] == pytest.approx(slip_mm)


def turned(angle_deg: float) -> ContactProblem:
    body, motion = condensed_wire(MESH_mm), np.radians(angle_deg)
    return replace(
        crossed_wires(MESH_mm),
        lower=place(body, upper=False, axis_angle_rad=-motion),
        upper=place(body, upper=True, axis_angle_rad=np.pi / 2 - motion),
    )


def forces(problem: ContactProblem) -> list[float]:
    return [pieces[-1].tangential_force for pieces in driven(problem, pressed(problem)[0], STEPS_mm)[1]]


def test_motion_across_the_lower_wire_is_motion_along_the_upper_one() -> None:
    swapped = replace(turned(90.0), primary_is_upper=False)
    assert forces(swapped) == pytest.approx(forces(turned(0.0)), abs=1e-6 * LOAD_N)


def test_the_fine_patches_reach_as_far_as_the_crossing_of_the_crowns_travels_along_each_wire() -> None:
    reach = {}
    for angle in (0, 30, 90, -30):
        text = MINIMAL.replace("frequency_Hz", f"motion_angle_deg = {angle}\nfrequency_Hz")
        plan = discretise(parse_study(text, "s.toml"), "quick")
        reach[angle] = (plan.moving.axial.half_extent_mm, plan.fixed.axial.half_extent_mm)
    assert reach[30] == pytest.approx(reach[-30])
    assert reach[90] == pytest.approx(reach[0][::-1], rel=1e-6)
    still = reach[0][1]
    assert reach[30] == pytest.approx((still + 0.06 * np.cos(np.pi / 6), still + 0.06 * np.sin(np.pi / 6)), rel=1e-6)


@pytest.fixture(scope="module")
def problem() -> ContactProblem:
    return crossed_wires(0.02)


def solved(*, longest_mm: float, misleading: bool) -> tuple[Any, list[tuple[float, bool]]]:
    """A stand-in for one increment's solution, which fails beyond a length or by a guess, and its calls."""
    calls: list[tuple[float, bool]] = []

    def solve(_problem: Any, state: Any, drive: float, _cycles: float, **kwargs: Any) -> tuple[Any, Any]:
        guessed = kwargs["expected"] is not None
        calls.append((drive, guessed))
        if (misleading and guessed) or drive - state.drive > longest_mm * (1.0 + 1e-9):
            raise IncrementFailedError("it does not converge")
        return type(state)(drive), None

    return solve, calls


class At:
    """A state of which nothing but the drive counts."""

    def __init__(self, drive: float) -> None:
        self.drive = drive


def test_a_guess_that_leads_astray_is_not_followed_once_the_increment_is_cut(
    monkeypatch: pytest.MonkeyPatch, problem: ContactProblem
) -> None:
    solve, calls = solved(longest_mm=1.0, misleading=True)
    monkeypatch.setattr(advancing, "solve_increment", solve)
    guess = FirstGuess(0.0, 1.0, np.zeros((1, 3)))
    start: Any = At(0.0)
    state, reports = advance(problem, start, 1.0, 0.0, guess)
    assert state.drive == pytest.approx(1.0)
    assert len(reports) == 2
    assert [guessed for _, guessed in calls] == [True, False, False]


def test_an_increment_that_no_cut_helps_fails_with_the_place_and_the_reason(
    monkeypatch: pytest.MonkeyPatch, problem: ContactProblem
) -> None:
    solve, _ = solved(longest_mm=0.0, misleading=False)
    monkeypatch.setattr(advancing, "solve_increment", solve)
    with pytest.raises(NotConvergedError, match=r"at a displacement of 0.000 um, .* 1/256 increment: it does not conv"):
        advance(problem, unloaded_state(problem), 1.0, 0.0)
