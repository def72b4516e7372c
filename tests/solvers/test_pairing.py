"""Coupling of two surfaces that face each other with different meshes."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from threadpoolctl import threadpool_limits

from geometry import GradedAxis
from geometry.arrays import Array
from solvers import Drive, NotConvergedError, place
from solvers.contact import ContactProblem, advance, advancing, unloaded_state
from solvers.contact.acceptance import largest_within
from solvers.contact.increment import IncrementFailedError
from solvers.contact.problem import faced
from solvers.contact_state import FirstGuess
from solvers.elasticity.pairing import Pairing, pair, primary_surface, vertical_gap
from solvers.elasticity.placement import PlacedBody
from solvers.fretting import restarted
from solvers.newton import iteration
from solvers.newton.terms import Iterate
from tests.bodies import LOAD_N, RADIUS_mm, condensed_wire, crossed_wires, driven, pressed, rigid
from tests.solvers.wear_jumps import INCREMENTS, RATES, at_the_end, jumped
from tests.studies import MINIMAL
from wirewear import parse_study
from wirewear.simulation import discretise

FLAT_mm = 1e9


def even(half_mm: float, count: int) -> Array:
    return np.linspace(-half_mm, half_mm, count)


def fresh(body: PlacedBody) -> Array:
    return np.zeros(body.patch.shape)


def paired(primary: PlacedBody, secondary: PlacedBody, offset_mm: tuple[float, float] = (0.0, 0.0)) -> Pairing:
    nodes = np.arange(primary.patch.size)
    return pair(primary_surface(primary), secondary, nodes, np.array(offset_mm), fresh(primary), fresh(secondary))


def upper_and_lower(
    upper_lines: Array, lower_lines: Array, radius_mm: float = RADIUS_mm, angle_rad: float = np.pi / 2
) -> tuple[PlacedBody, PlacedBody]:
    upper = rigid(upper_lines, upper_lines, upper=True, angle_rad=angle_rad, radius_mm=radius_mm)
    return upper, rigid(lower_lines, lower_lines, upper=False, angle_rad=0.0, radius_mm=radius_mm)


GRADED = GradedAxis(0.004, 0.012, 0.012, 0.04).lines()


@pytest.mark.seconds
@settings(max_examples=25)
@given(st.floats(-0.03, 0.03), st.floats(-0.03, 0.03), st.floats(0.0, np.pi))
def test_the_transfer_is_a_partition_of_unity_at_any_position_and_angle(x: float, y: float, angle: float) -> None:
    primary, secondary = upper_and_lower(GRADED, even(0.12, 21), angle_rad=angle)
    pairing = paired(primary, secondary, (x, y))
    assert pairing.inside.all()
    assert pairing.areas == pytest.approx(primary.patch.node_areas(), rel=1e-12)
    for operator in (pairing.primary, pairing.secondary):
        assert np.asarray(operator.sum(axis=1)).ravel() == pytest.approx(pairing.areas, rel=1e-12)


def test_the_moment_error_is_that_of_lumping_forces_to_nodes_off_the_centre_of_their_support() -> None:
    # The primary's force acts at the node, the secondary's at the centroid of the node's shape function. They differ
    # by a third of the difference of the spacings on either side: nothing on an even grid.
    primary, secondary = upper_and_lower(GRADED, even(0.06, 17), angle_rad=0.0)
    offset = np.array([0.0071, -0.0033])
    pairing = paired(primary, secondary, (float(offset[0]), float(offset[1])))
    traction = np.random.default_rng(1).uniform(size=primary.patch.size)
    at_primary = (pairing.primary.T @ traction) @ primary.node_positions
    at_secondary = (pairing.secondary.T @ traction) @ (secondary.node_positions + offset)
    before, after = np.diff(GRADED, prepend=GRADED[0]), np.diff(GRADED, append=GRADED[-1])
    shift = (after - before) / 3.0
    i, j = np.divmod(np.arange(primary.patch.size), len(GRADED))
    # An upper body along x has its transverse axis along -y.
    lever = np.column_stack([shift[i], -shift[j]])
    assert at_secondary - at_primary == pytest.approx((pairing.areas * traction) @ lever, abs=1e-12)


@pytest.mark.parametrize("primary_is_upper", [True, False])
def test_uniform_pressure_crosses_matching_meshes_to_round_off(primary_is_upper: bool) -> None:
    bodies = upper_and_lower(even(0.04, 11), even(0.04, 11), FLAT_mm, angle_rad=0.0)
    primary, secondary = bodies if primary_is_upper else bodies[::-1]
    pairing = paired(primary, secondary)
    pressure = np.ones(primary.patch.size)
    assert pairing.primary.T @ pressure == pytest.approx(primary.patch.node_areas(), rel=1e-12)
    assert pairing.secondary.T @ pressure == pytest.approx(secondary.patch.node_areas(), rel=1e-9)


@pytest.mark.seconds
@given(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5))
def test_uniform_pressure_crosses_equally_fine_meshes_to_round_off_wherever_they_stand(x: float, y: float) -> None:
    spacing = 0.004
    primary, secondary = upper_and_lower(even(0.04, 21), even(0.08, 41), FLAT_mm)
    forces = paired(primary, secondary, (x * spacing, y * spacing)).secondary.T @ np.ones(primary.patch.size)
    middle = np.abs(secondary.node_positions).max(axis=1) < 0.03
    assert forces[middle] == pytest.approx(np.full(middle.sum(), spacing**2), rel=1e-9)


def test_frames_are_right_handed_orthonormal_and_point_up() -> None:
    primary, secondary = upper_and_lower(GRADED, even(0.12, 25))
    frames = paired(primary, secondary, (0.01, 0.02)).frames
    assert frames @ frames.transpose(0, 2, 1) == pytest.approx(np.broadcast_to(np.eye(3), frames.shape), abs=1e-14)
    assert np.linalg.det(frames) == pytest.approx(np.ones(len(frames)))
    assert np.all(frames[:, 0, 2] > 0.9)
    assert np.all(frames[:, 1, 0] > 0.9)


def test_the_gap_of_crossed_cylinders_is_the_sum_of_their_heights() -> None:
    upper, lower = upper_and_lower(GRADED, even(0.08, 41))
    x, y = upper.node_positions.T
    shift = 0.0123
    exact = 2.0 * RADIUS_mm - np.sqrt(RADIUS_mm**2 - x**2) - np.sqrt(RADIUS_mm**2 - y**2)
    gap = vertical_gap(primary_surface(upper), lower, np.array([shift, 0.0]), fresh(upper), fresh(lower))
    assert gap == pytest.approx(exact, abs=1e-12)


@pytest.mark.parametrize("primary_is_upper", [True, False])
def test_the_paired_gap_is_the_exact_one_with_the_secondary_averaged_over_elements(primary_is_upper: bool) -> None:
    # Averaging y^2 / 2R with a hat function of half-width h adds h^2 / 12R.
    spacing = 0.004
    bodies = upper_and_lower(even(0.04, 21), even(0.08, 41))
    primary, secondary = bodies if primary_is_upper else bodies[::-1]
    inner = np.flatnonzero(np.abs(primary.node_positions).max(axis=1) < 0.03)
    pairing = paired(primary, secondary)
    x, y = primary.node_positions[inner].T
    exact = 2.0 * RADIUS_mm - np.sqrt(RADIUS_mm**2 - x**2) - np.sqrt(RADIUS_mm**2 - y**2)
    assert pairing.gap[inner] - exact == pytest.approx(np.full(len(inner), spacing**2 / (12.0 * RADIUS_mm)), rel=0.05)


def test_wear_opens_the_gap_by_the_depth_on_either_body() -> None:
    upper, lower = upper_and_lower(even(0.04, 21), even(0.04, 15))
    surface, still = primary_surface(upper), np.zeros(2)
    unworn = vertical_gap(surface, lower, still, fresh(upper), fresh(lower))
    worn = vertical_gap(surface, lower, still, np.full(upper.patch.shape, 0.001), np.full(lower.patch.shape, 0.002))
    assert worn - unworn == pytest.approx(np.full(upper.patch.size, 0.003), rel=1e-9)


def test_swapped_roles_see_the_same_gap_and_opposite_offsets() -> None:
    lines = even(0.04, 21)
    upper, lower = upper_and_lower(lines, lines)
    shift = np.array([0.004, 0.0])
    from_above = vertical_gap(primary_surface(upper), lower, shift, fresh(upper), fresh(lower))
    from_below = vertical_gap(primary_surface(lower), upper, -shift, fresh(lower), fresh(upper))
    above = {tuple(np.round(p / 1e-6).astype(int)): g for p, g in zip(upper.node_positions, from_above, strict=True)}
    common = 0
    for position, gap in zip(lower.node_positions + shift, from_below, strict=True):
        key = tuple(np.round(position / 1e-6).astype(int))
        if key in above and np.isfinite(gap):
            common += 1
            assert gap == pytest.approx(above[key], abs=1e-9)
    assert common == 20 * 21


def test_nodes_beside_the_other_patch_are_flagged_and_have_no_gap() -> None:
    primary, secondary = upper_and_lower(even(0.04, 21), even(0.04, 21))
    pairing = paired(primary, secondary, (0.03, 0.0))
    x = primary.node_positions[:, 0]
    assert np.array_equal(pairing.inside, x - 0.03 >= -0.04 + 0.004 - 1e-9)
    gap = vertical_gap(primary_surface(primary), secondary, np.array([0.03, 0.0]), fresh(primary), fresh(secondary))
    assert np.array_equal(np.isinf(gap), x - 0.03 < -0.04 - 1e-9)


def test_depths_read_at_nodes_stay_where_they_are_and_averaged_ones_spread() -> None:
    primary, secondary = upper_and_lower(even(0.04, 9), even(0.04, 9))
    surface, depth = primary_surface(primary), fresh(secondary)
    worn_node = depth.size // 2
    depth.flat[worn_node] = 1e-3
    middle = np.arange(depth.size)
    opened = [
        pair(surface, secondary, middle, np.zeros(2), fresh(primary), depth, at_nodes=at_nodes).gap
        - pair(surface, secondary, middle, np.zeros(2), fresh(primary), fresh(secondary), at_nodes=at_nodes).gap
        for at_nodes in (True, False)
    ]
    assert np.flatnonzero(opened[0] > 1e-12).size == 1
    assert opened[0].max() == pytest.approx(1e-3)
    assert np.flatnonzero(opened[1] > 1e-12).size == 9


STROKE_mm = 4.0e-4
NEXT_TO_NOTHING_mm = 1e-9
MESH_mm = 0.010
# Stick, slip and reversal, but not the knee between them, where a coarse mesh decides.
STEPS_mm = 1e-3 * np.array([0.1, 0.2, 1.5, 4.0, 3.9, 1.0])


def test_bodies_pressed_again_around_worn_scars_leave_no_friction_on_what_sticks() -> None:
    problem = crossed_wires(0.005, wear=RATES)
    worn = jumped(problem, at_the_end(problem, STROKE_mm), 2e4, stroke_mm=STROKE_mm).state
    assert worn.core.sum() > 4
    with threadpool_limits(limits=1, user_api="blas"):
        state = restarted(problem, worn, Drive(NEXT_TO_NOTHING_mm), INCREMENTS)
    core = np.flatnonzero(worn.core)
    frames = faced(problem, state, core, state.drive, state.holder_x, state.holder_tilt).frames
    pressure, *friction = np.einsum("ikj,ij->ki", frames, state.traction[core])
    assert np.hypot(*friction).max() < 1e-3 * problem.friction * pressure.max()


@pytest.mark.slow
def test_wear_beside_a_core_opens_nothing_where_nodes_do_not_meet() -> None:
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


@pytest.mark.parametrize("shape", [(7, 6), (7, 1)])
def test_a_peak_counts_whole_inside_and_as_its_elements_mean_on_the_rim(shape: Any) -> None:
    for node in np.ndindex(shape):
        pressure = np.ones(shape)
        pressure[node] = 9.0
        inside = all(n == 1 or 0 < i < n - 1 for i, n in zip(node, shape, strict=True))
        assert largest_within(pressure) == (9.0 if inside else 3.0 if shape[1] > 1 else 5.0)


@pytest.mark.parametrize(("slip_mm", "expected"), [(1e-6, 0.1), (1e-17, 0.0)])
def test_slip_that_is_round_off_has_no_direction_that_friction_could_miss(
    monkeypatch: pytest.MonkeyPatch, slip_mm: float, expected: float
) -> None:
    """One node under pressure whose friction lies 0.1 rad off the slip; the bodies close by a micrometre."""
    monkeypatch.setattr(iteration, "unbalanced_force", lambda *_: 0.0)
    system = SimpleNamespace(friction=SimpleNamespace(none=False), compliance=SimpleNamespace(layer=0.0))
    conditions = SimpleNamespace(system=system, nodes=SimpleNamespace(frames=np.eye(3)[None, [2, 0, 1]]))
    no, yes, zero = np.array([False]), np.array([True]), np.zeros(1)
    state = Iterate(
        normal=np.array([1000.0]), tangential=np.array([[600.0, 0.0]]), height=0.0, holder_x=0.0, tilt=0.0, gap=zero,
        slip=slip_mm * np.array([[np.cos(0.1), np.sin(0.1)]]), elastic=1e-3, active=yes, touching=1, fresh=0, stick=no,
        near_stick=no, follows=yes, verge=no, direction=np.array([[-1.0, 0.0]]), augmentation=zero, limit=zero,
    )  # fmt: skip
    found = iteration.converged_outcome(cast("Any", conditions), state, state, 3)
    assert found.slip_direction_error == pytest.approx(expected, abs=1e-9)
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
        return replace(state, drive=drive), None

    return solve, calls


def test_a_guess_that_leads_astray_is_not_followed_once_the_increment_is_cut(
    monkeypatch: pytest.MonkeyPatch, problem: ContactProblem
) -> None:
    solve, calls = solved(longest_mm=1.0, misleading=True)
    monkeypatch.setattr(advancing, "solve_increment", solve)
    state, reports = advance(problem, unloaded_state(problem), 1.0, 0.0, FirstGuess(0.0, 1.0, np.zeros((1, 3))))
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
