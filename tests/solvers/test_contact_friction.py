"""Frictional contact of crossed wires: partial slip, gross slip behind a rig, symmetry."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from scipy.sparse import csr_matrix

from geometry.arrays import Array, IntArray
from solvers import ContactProblem, ContactState, IncrementReport
from solvers.contact import advance
from solvers.newton.equations import _solved
from solvers.wear_step import coupled as coupled_equations
from solvers.wear_step.coupled import Coupled, SimilarEquations, as_a_whole, position_by_position
from tests.bodies import FRICTION, LOAD_N, STEEL, AMPLITUDE_mm, RADIUS_mm, RIG_N_per_mm, crossed_wires, driven, pressed
from wirewear import reference

COUNT, POSITIONS, NODES = 240, 4, 30
COARSE_mm, FINE_mm = 0.010, 0.007
LIMIT_N = FRICTION * LOAD_N
PER_CYCLE = 40
Slip = tuple[list[ContactState], list[list[IncrementReport]]]


def matrix(seed: int = 1, change: float = 0.0) -> tuple[Array, Array, Array]:
    """Dense blocks of pressures and a height at each position, and what couples them through few nodes, much stronger;
    and those that differ from them by a share.
    """
    chance = np.random.default_rng(seed)
    near = np.exp(-np.abs(np.subtract.outer(np.arange(COUNT), np.arange(COUNT))) / 20.0) + 0.1 * np.eye(COUNT)
    faced = np.arange(COUNT)[:, None] % NODES == np.arange(NODES)
    blocks, opened, worked = (
        part * (1.0 + change * chance.normal(size=part.shape)) for part in (near, 3.0 * faced, 2.0 * faced)
    )
    return blocks, opened, worked


def whole(parts: tuple[Array, Array, Array], unknowns: IntArray) -> tuple[Array, Callable[[], Coupled]]:
    """The matrix of some unknowns and then of the heights, and its parts."""
    near, opened, worked = (part[unknowns] for part in parts)
    position = unknowns // (COUNT // POSITIONS)
    blocks, size = [], len(unknowns)
    dense = np.zeros((size + POSITIONS, size + POSITIONS))
    for k in range(POSITIONS):
        own = np.append(np.flatnonzero(position == k), size + k)
        block = np.ones((len(own), len(own)), order="F")
        block[:-1, :-1], block[-1, -1] = near[own[:-1]][:, unknowns[own[:-1]]], -0.5
        dense[np.ix_(own, own)] = block
        blocks.append(block)
    dense[:size, :size] += opened @ worked.T
    return dense, partial(Coupled, blocks, csr_matrix(opened), csr_matrix(worked))


@pytest.mark.parametrize("change", [0.0, 1e-4, 1e-2, 0.3])
def test_equations_that_changed_are_solved_whatever_the_change(change: float) -> None:
    similar, every = SimilarEquations(), np.arange(COUNT)
    some, others = np.delete(every, [3, 77]), np.delete(every, [5])
    for unknowns, parts in ((some, matrix()), (others, matrix(2, change)), (every, matrix(3, change))):
        dense, coupled = whole(parts, unknowns)
        rhs = np.cos(np.arange(len(dense)))
        numbers = np.concatenate([unknowns, COUNT + np.arange(POSITIONS)])
        usual = float(np.median(dense.diagonal()[: len(unknowns)]))
        found = similar.solution(numbers, rhs, 2.0 + np.sin(rhs), usual, dense.__matmul__, coupled)
        exact = np.linalg.solve(dense, rhs)
        assert found == pytest.approx(exact, rel=1e-7, abs=1e-9 * np.abs(exact).max())


def test_factors_of_positions_and_of_the_whole_matrix_solve_alike() -> None:
    dense, coupled = whole(matrix(), np.arange(COUNT))
    rhs = np.cos(np.arange(len(dense)))
    for factored in (as_a_whole, position_by_position):
        for precision, error in ((np.float32, 1e-3), (np.float64, 1e-9)):
            solved = factored(coupled(), precision)
            assert solved is not None
            assert solved(rhs) == pytest.approx(np.linalg.solve(dense, rhs), rel=error, abs=error)


def test_where_positions_share_few_nodes_no_factors_are_larger_than_one_of_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(coupled_equations, "MANY_UNKNOWNS", 0)
    monkeypatch.setattr(coupled_equations, "as_a_whole", lambda *_: pytest.fail("factors of the whole matrix"))
    dense, coupled = whole(matrix(), np.arange(COUNT))
    numbers = np.arange(len(dense))
    ones, similar = np.ones(len(dense)), SimilarEquations()
    assert similar.solution(numbers, np.cos(numbers), ones, 1.0, dense.__matmul__, coupled) is not None


@pytest.fixture(scope="module")
def mindlin() -> reference.PartialSlipPoint:
    steel = reference.Elastic(STEEL.youngs_modulus_MPa, STEEL.poissons_ratio)
    radius = reference.hertz_point(LOAD_N, RADIUS_mm, reference.contact_modulus(steel, steel)).major_semi_axis_mm
    return reference.partial_slip_point(LOAD_N, FRICTION, radius, reference.tangential_contact_modulus(steel, steel))


def sines(count: int, sign: float = 1.0) -> Array:
    """Drive positions of a sine from rest, PER_CYCLE increments a cycle."""
    return np.asarray(sign * AMPLITUDE_mm * np.sin(2.0 * np.pi * np.arange(1, count + 1) / PER_CYCLE))


def forces(reports: list[list[IncrementReport]]) -> Array:
    return np.array([pieces[-1].tangential_force for pieces in reports])


def works(reports: list[list[IncrementReport]]) -> Array:
    return np.array([sum(piece.friction_work for piece in pieces) for pieces in reports])


def loop_area(drive: Array, force: Array) -> float:
    return 0.5 * abs(float(np.sum(drive * np.roll(force, -1) - np.roll(drive, -1) * force)))


@pytest.fixture(scope="module")
def rig() -> ContactProblem:
    return crossed_wires(COARSE_mm, long_patch=True, rig_N_per_mm=RIG_N_per_mm)


@pytest.fixture(scope="module")
def gross_slip(rig: ContactProblem) -> tuple[list[ContactState], list[list[IncrementReport]]]:
    """A first quarter from rest and then a closed cycle."""
    return driven(rig, pressed(rig)[0], sines(PER_CYCLE + PER_CYCLE // 4))


@pytest.mark.parametrize("least", [1e-2, 1e-10])
def test_many_equations_are_solved_as_exactly_as_double_precision_allows(least: float) -> None:
    chance, size = np.random.default_rng(3), 401
    left, right = (np.linalg.qr(chance.normal(size=(size, size)))[0] for _ in range(2))
    stiff, wanted = left * np.geomspace(1.0, least, size) @ right, chance.normal(size=size)
    found = _solved(np.asfortranarray(stiff), stiff @ wanted)
    assert found is not None
    np.testing.assert_allclose(stiff @ found, stiff @ wanted, atol=1e-12)
    np.testing.assert_allclose(found, wanted, atol=1e-12 / least)


@pytest.mark.seconds
def test_below_the_threshold_the_centre_sticks_and_the_edge_slips(mindlin: reference.PartialSlipPoint) -> None:
    problem = crossed_wires(FINE_mm)
    drive = 0.9 * LIMIT_N / mindlin.stiffness_N_per_mm
    states, reports = driven(problem, pressed(problem)[0], np.linspace(0.0, drive, 7)[1:])
    last = reports[-1][-1]
    assert 0 < last.sticking < last.active
    traction, distance = states[-1].traction, np.linalg.norm(problem.primary.node_positions, axis=1)
    loaded = traction[:, 2] > 0.0
    used = np.linalg.norm(traction[loaded, :2], axis=1) / (FRICTION * traction[loaded, 2])
    assert used[distance[loaded].argmin()] < 0.3
    # Friction cones stand on inclined surfaces, so the share in the plane is not exactly 1.
    assert used[distance[loaded] > 0.9 * distance[loaded].max()] == pytest.approx(1.0, abs=0.1)
    stuck_area = last.sticking * FINE_mm**2
    assert np.sqrt(stuck_area / np.pi) == pytest.approx(
        float(reference.stick_radius(mindlin, last.tangential_force)), rel=0.2
    )


@pytest.mark.parametrize("share", [0.3, 0.6, 0.9])
@pytest.mark.parametrize(("mesh_mm", "tolerance"), [(FINE_mm, 0.07), pytest.param(0.005, 0.04, marks=pytest.mark.slow)])
def test_partial_slip_follows_cattaneo_and_mindlin_in_series_with_the_wires_bulk(
    mindlin: reference.PartialSlipPoint, share: float, mesh_mm: float, tolerance: float
) -> None:
    problem = crossed_wires(mesh_mm)
    drives = share * LIMIT_N / mindlin.stiffness_N_per_mm * np.array([0.01, 0.25, 0.5, 0.75, 1.0])
    force = forces(driven(problem, pressed(problem)[0], drives)[1])
    # The upper wire rolls on its grip under a force across its axis, which half-spaces do not: this linear part is
    # taken from the first, sticking increment.
    bulk = drives[0] / force[0] - 1.0 / mindlin.stiffness_N_per_mm
    assert 0.0 < bulk * mindlin.stiffness_N_per_mm < 0.25
    expected = reference.loading_displacement(mindlin, force[-1]) + bulk * force[-1]
    assert drives[-1] == pytest.approx(float(expected), rel=tolerance)


def test_gross_slip_needs_friction_times_load_on_an_unworn_surface(gross_slip: Slip) -> None:
    _, reports = gross_slip
    force = forces(reports)
    assert force.max() == pytest.approx(LIMIT_N, rel=2e-3)
    assert force.min() == pytest.approx(-LIMIT_N, rel=2e-3)
    sliding = [pieces[-1] for pieces in reports if pieces[-1].sticking == 0]
    assert len(sliding) > 20
    assert all(abs(piece.tangential_force) == pytest.approx(LIMIT_N, rel=2e-3) for piece in sliding)
    assert max(piece.slip_direction_error for piece in sliding) < 1e-3


def test_forces_balance_in_every_increment(rig: ContactProblem, gross_slip: Slip) -> None:
    states, reports = gross_slip
    for state, pieces in zip(states, reports, strict=True):
        assert pieces[-1].force_error < 1e-9
        assert pieces[-1].penetration < 1e-6
        assert pieces[-1].tangential_force == pytest.approx(RIG_N_per_mm * state.holder_x, abs=1e-8)
        assert state.primary_force.sum(axis=0) == pytest.approx(state.secondary_force.sum(axis=0), abs=1e-9)
        # Friction cones stand on surfaces inclined by up to a / R = 0.06 against the plane.
        shear = np.linalg.norm(state.traction[:, :2], axis=1)
        assert np.all(shear <= np.tan(np.arctan(FRICTION) + 0.06) * state.traction[:, 2] + 1e-9)
    assert not states[-1].wear.primary_depth.any()


def test_friction_work_is_the_area_of_the_closed_loop(gross_slip: Slip) -> None:
    states, reports = gross_slip
    drive = np.array([state.drive for state in states[-PER_CYCLE:]])
    work = float(works(reports)[-PER_CYCLE:].sum())
    # Straight lines between the increments cut the loop's corners.
    assert work == pytest.approx(loop_area(drive, forces(reports)[-PER_CYCLE:]), rel=0.004)


@pytest.mark.seconds
def test_friction_work_of_few_increments_is_the_area_of_a_loop_of_many(rig: ContactProblem, gross_slip: Slip) -> None:
    start = gross_slip[0][PER_CYCLE // 4 - 1]

    def closed(count: int) -> tuple[Array, Array, float]:
        drives = AMPLITUDE_mm * np.cos(2.0 * np.pi * np.arange(1, count + 1) / count)
        _, reports = driven(rig, start, drives)
        return drives, forces(reports), float(works(reports).sum())

    fine_drives, fine_forces, fine_work = closed(320)
    area = loop_area(fine_drives, fine_forces)
    assert fine_work == pytest.approx(area, rel=5e-4)
    for count in (16, 32):
        assert closed(count)[2] == pytest.approx(area, rel=1e-3)


def test_slip_counts_under_the_pressures_at_both_ends_of_an_increment(rig: ContactProblem) -> None:
    problem = replace(rig, primary_is_upper=False)
    states, reports = driven(problem, pressed(problem)[0], sines(PER_CYCLE // 4))
    before, after = states[5], states[6]
    areas, report = problem.primary.patch.node_areas(), reports[6][-1]
    slid = after.primary_slid - before.primary_slid
    path = after.drive - before.drive - (after.holder_x - before.holder_x)
    both = (before.traction[:, 2] > 0.0) & (after.traction[:, 2] > 0.0)
    one = (before.traction[:, 2] > 0.0) ^ (after.traction[:, 2] > 0.0)
    assert slid[both] == pytest.approx(path, rel=0.05)
    assert one.any()
    assert slid[one] == pytest.approx(0.5 * path, rel=0.05)
    mean = 0.5 * (before.traction[:, 2] + after.traction[:, 2])
    assert report.friction_work == pytest.approx(FRICTION * path * float(areas @ mean), rel=0.01)


def test_energy_and_stiffness_of_a_loop_are_closed_forms(gross_slip: Slip, mindlin: reference.PartialSlipPoint) -> None:
    states, reports = gross_slip
    closed = reference.dissipated_energy(mindlin, AMPLITUDE_mm, RIG_N_per_mm)
    assert closed == pytest.approx(0.2580, rel=2e-3)
    assert float(works(reports)[-PER_CYCLE:].sum()) == pytest.approx(closed, rel=0.05)
    top = int(np.argmax([state.drive for state in states]))
    before, after = states[top], states[top + 1]
    slope = (forces(reports)[top] - forces(reports)[top + 1]) / (before.drive - after.drive)
    assert 1.0 / slope == pytest.approx(1.0 / RIG_N_per_mm + 1.0 / mindlin.stiffness_N_per_mm, rel=0.05)


def test_mirrored_motion_gives_mirrored_forces(rig: ContactProblem, gross_slip: Slip) -> None:
    count = PER_CYCLE // 2
    mirrored, reports = driven(rig, pressed(rig)[0], sines(count, sign=-1.0))
    assert forces(reports) == pytest.approx(-forces(gross_slip[1][:count]), abs=1e-6)
    for one, other in zip(gross_slip[0][:count], mirrored, strict=True):
        assert other.holder_x == pytest.approx(-one.holder_x, abs=1e-8)
        assert other.holder_z == pytest.approx(one.holder_z, abs=1e-8)
        shape = rig.primary.patch.shape
        # The upper wire lies across the motion: its transverse axis is the motion's.
        image = other.traction.reshape(*shape, 3)[:, ::-1] * [-1.0, 1.0, 1.0]
        assert image == pytest.approx(one.traction.reshape(*shape, 3), abs=1e-4 * one.traction.max())


def test_swapped_roles_give_the_same_loop_within_mesh_error(rig: ContactProblem, gross_slip: Slip) -> None:
    count = PER_CYCLE // 2
    swapped = crossed_wires(COARSE_mm, long_patch=True, rig_N_per_mm=RIG_N_per_mm, primary_is_upper=False)
    _, reports = driven(swapped, pressed(swapped)[0], sines(count))
    assert forces(reports) == pytest.approx(forces(gross_slip[1][:count]), abs=0.01 * LIMIT_N)
    assert works(reports).sum() == pytest.approx(works(gross_slip[1][:count]).sum(), rel=0.01)


@pytest.mark.parametrize("share", [2.0, 4.0])
def test_what_comes_into_contact_in_an_increment_is_sheared_from_where_it_touches(share: float) -> None:
    problem, found, iterations = crossed_wires(COARSE_mm, long_patch=True), [], []
    for count in (1, 32):
        state, steps = pressed(problem)[0], 0
        for part in np.arange(1, count + 1) / count:
            state, reports = advance(problem, state, 1e-4 * part, 0.0, load_share=1.0 + (share - 1.0) * part)
            steps += sum(report.iterations for report in reports)
        found.append(reports[-1].tangential_force)
        iterations.append(steps)
    assert found[0] == pytest.approx(found[1], rel=0.025)
    assert iterations[0] <= 6
