"""The whole-cycle wear step: symmetries change nothing, laws and books hold, every seam of the model wears."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

import solvers
from solvers.wear_step.symmetry import mirrored
from tests.bodies import LOAD_N, RADIUS_mm, condensed_wire
from tests.solvers.wear_jumps import (
    INCREMENTS,
    RATES,
    LINE_STROKE_mm,
    MESH_mm,
    RIG_N_per_mm,
    STROKE_mm,
    at_the_end,
    depths,
    even_across,
    jumped,
    line_contact,
    whole_of,
    wires,
    worn,
)
from wirewear.verification.hertz import scaled_patch

pytestmark = pytest.mark.seconds
CYCLES = 300.0  #: Cycles after which the wires are worn by as much as they approach under the load.


@pytest.fixture(scope="module")
def problem() -> solvers.ContactProblem:
    return wires()


def turned(angle_deg: float) -> solvers.ContactProblem:
    """Wires that cross at another angle, which leaves them only the turn by half a circle."""
    right = wires()
    upper = solvers.place(condensed_wire(MESH_mm), upper=True, axis_angle_rad=float(np.radians(angle_deg)))
    return replace(right, upper=upper)


@pytest.mark.parametrize("angle_deg", [90.0, 60.0])
def test_folding_a_cycle_by_its_symmetries_leaves_every_depth_as_it_is(angle_deg: float) -> None:
    posed = turned(angle_deg)
    symmetry = solvers.symmetry_of(posed)
    assert symmetry.order == (4 if angle_deg == 90.0 else 2)
    assert symmetry.half_cycle is not None
    with threadpool_limits(1, user_api="blas"):
        start, half = solvers.closed_trace(posed, worn(posed, 50.0), solvers.Drive(STROKE_mm), INCREMENTS, symmetry)
        # A trace that has the symmetries to the last bit, which round-off in Newton's method does not leave.
        if symmetry.across is not None:
            half = replace(half, states=tuple(even_across(state, symmetry.across) for state in half.states))
        start = replace(
            mirrored(half.states[-1], symmetry.half_cycle),
            primary_slid=start.primary_slid,
            secondary_slid=start.secondary_slid,
        )
        whole = whole_of(start, half, symmetry.half_cycle)
        unfolded = solvers.jump_cycles(lambda *_: posed, start, whole, solvers.Symmetry(), 50.0, CYCLES)
        folds = [
            (symmetry, half),
            (solvers.Symmetry(half_cycle=symmetry.half_cycle), half),
            (solvers.Symmetry(symmetry.across), whole),
        ]
        for kept, trace in folds:
            folded = solvers.jump_cycles(lambda *_: posed, start, trace, kept, 50.0, CYCLES)
            assert folded.unknowns <= 0.7 * unfolded.unknowns or kept.order == 1
            for one, other in zip(depths(posed, folded.state), depths(posed, unfolded.state), strict=True):
                assert np.abs(one - other).max() < 1e-10 * other.max()
            assert folded.state.wear.energy_mJ == pytest.approx(unfolded.state.wear.energy_mJ, rel=1e-11)


def test_a_leaning_motion_has_no_half_cycle_symmetry_and_wears_all_the_same(problem: solvers.ContactProblem) -> None:
    leaning = solvers.misaligned(problem, np.radians(5.0))
    assert solvers.symmetry_of(leaning).half_cycle is None
    assert solvers.symmetry_of(leaning).across is not None
    state = worn(leaning, CYCLES)
    upright = worn(problem, CYCLES)
    assert state.wear.energy_mJ == pytest.approx(upright.wear.energy_mJ, rel=0.05)
    upper = depths(leaning, state)[0]
    # The plane of contact descends along the motion: the way up presses harder, which no mirror undoes.
    assert np.abs(upper - upper[:, ::-1]).max() > 1e-3 * upper.max()


def test_depths_are_never_negative_and_never_shrink(problem: solvers.ContactProblem) -> None:
    state = at_the_end(problem)
    for cycles in (5.0, 30.0, 200.0, 1000.0):
        after = jumped(problem, state, cycles).state
        for old, new in zip(depths(problem, state), depths(problem, after), strict=True):
            assert new.min() >= 0.0
            assert (new - old).min() >= 0.0
        state = after


def test_which_body_carries_the_pressures_matters_less_the_finer_the_mesh() -> None:
    differences = []
    for element_mm in (0.02, 0.01):
        one, other = line_contact(element_mm), line_contact(element_mm, primary_is_upper=False)
        first, second = (worn(posed, 100.0, 400.0, stroke_mm=LINE_STROKE_mm) for posed in (one, other))
        assert first.wear.energy_mJ == pytest.approx(second.wear.energy_mJ, rel=2e-3)
        pairs = zip(depths(one, first), depths(other, second), strict=True)
        differences.append(max(float(np.linalg.norm(here - there) / np.linalg.norm(there)) for here, there in pairs))
    assert differences[1] < 0.5 * differences[0] < 0.02


def test_metres_and_newtons_take_the_same_iterations_as_millimetres(problem: solvers.ContactProblem) -> None:
    def in_metres(body: solvers.CondensedBody) -> solvers.CondensedBody:
        return solvers.CondensedBody.whole(scaled_patch(body.patch, RADIUS_mm, 1e-3), 1e-3 * body.compliance)

    metres = replace(
        problem,
        upper=solvers.place(in_metres(condensed_wire(MESH_mm)), upper=True, axis_angle_rad=np.pi / 2),
        lower=solvers.place(in_metres(condensed_wire(MESH_mm, 0.08, 0.11)), upper=False, axis_angle_rad=0.0),
        holder=solvers.Holder(LOAD_N, 1e-3 / RIG_N_per_mm),
        # mm3/mJ is m3/J times 1e6; a joule is 1e3 mJ and a cubic metre 1e9 mm3.
        wear=solvers.WearRates(*RATES).scaled(1e-6),
    )
    small = jumped(problem, at_the_end(problem), CYCLES)
    # Symmetries are found by absolute distances between nodes: without any, both take the whole path.
    plain, large = (
        jumped(posed, at_the_end(posed, stroke), CYCLES, symmetry=solvers.Symmetry(), stroke_mm=stroke)
        for posed, stroke in ((problem, STROKE_mm), (metres, 1e-3 * STROKE_mm))
    )
    assert (large.iterations, large.unknowns, large.active) == (plain.iterations, plain.unknowns, plain.active)
    assert large.pressure_change == pytest.approx(plain.pressure_change, rel=1e-6)
    for one, other, folded in zip(
        depths(metres, large.state), depths(problem, plain.state), depths(problem, small.state), strict=True
    ):
        assert 1e3 * one == pytest.approx(other, rel=1e-5, abs=1e-12)
        assert folded == pytest.approx(other, rel=1e-4, abs=1e-10)


def test_jumps_are_of_second_order() -> None:
    contact = line_contact()
    state = worn(contact, 100.0, 300.0, 600.0, 2000.0, stroke_mm=LINE_STROKE_mm)
    ends = []
    for parts in (1, 2, 4, 8):
        after = state
        for _ in range(parts):
            after = jumped(contact, after, 300.0 / parts, stroke_mm=LINE_STROKE_mm).state
        ends.append(np.concatenate([depth.ravel() for depth in depths(contact, after)]))
    errors = [float(np.linalg.norm(coarse - fine)) for coarse, fine in pairwise(ends)]
    assert errors[0] > 3.3 * errors[1] > 3.3 * 3.3 * errors[2]
    assert errors[0] < 1e-3 * float(np.linalg.norm(ends[-1]))


def test_the_change_of_pressures_falls_with_the_jump() -> None:
    contact = line_contact()
    state = worn(contact, 100.0, 200.0, stroke_mm=LINE_STROKE_mm)
    large, small = (
        jumped(contact, state, cycles, stroke_mm=LINE_STROKE_mm).pressure_change for cycles in (200.0, 50.0)
    )
    assert 2.0 < large / small < 8.0


@pytest.mark.first_case
@pytest.mark.parametrize(
    ("layer", "least", "most"),
    # Roughness spreads the load, so that the scar is shallower; debris fills a part of it, so that it is deeper.
    [(solvers.RoughLayer(1.5e-4), 0.7, 0.99), (solvers.ThirdBody(0.3, modulus_MPa=2e4), 1.01, 1.3)],
    ids=["rough", "third body"],
)
def test_layers_between_the_surfaces_wear_with_the_books_in_order(
    problem: solvers.ContactProblem, layer: solvers.RoughLayer | solvers.ThirdBody, least: float, most: float
) -> None:
    layered = replace(problem, layers=(layer,))
    state = worn(layered, 20.0, CYCLES)
    areas = layered.primary.patch.node_areas()
    assert areas @ state.wear.primary_depth.ravel() == pytest.approx(RATES[0] * state.wear.energy_mJ, rel=1e-12)
    bare = worn(problem, 20.0, CYCLES)
    assert state.wear.energy_mJ == pytest.approx(bare.wear.energy_mJ, rel=0.05)
    assert least < state.wear.primary_depth.max() / bare.wear.primary_depth.max() < most


def test_a_coefficient_that_changes_wears_by_its_values_within_the_jump(problem: solvers.ContactProblem) -> None:
    def fading(cycle: float, _energy_mJ: float) -> solvers.ContactProblem:
        return replace(problem, wear=problem.wear.scaled(1.0 - 0.5 * (cycle - 1.0) / CYCLES))

    start = at_the_end(problem)
    constant, changing = jumped(problem, start, CYCLES), jumped(problem, start, CYCLES, problem_at=fading)
    halved = jumped(replace(problem, wear=problem.wear.scaled(0.5)), start, CYCLES)
    areas = problem.primary.patch.node_areas()
    volumes = [float(areas @ jump.state.wear.primary_depth.ravel()) for jump in (halved, changing, constant)]
    assert volumes[0] < volumes[1] < volumes[2]
    # A straight fall from 1 to 1/2 is worth its mean, 3/4, where the energy per cycle stays what it is.
    assert volumes[1] / volumes[2] == pytest.approx(0.75, rel=0.01)


def test_a_line_contact_wears_as_the_energy_says() -> None:
    contact = line_contact()
    wear = worn(contact, 100.0, 400.0, stroke_mm=LINE_STROKE_mm).wear
    for rate, body, depth in (
        (RATES[0], contact.upper, wear.primary_depth),
        (RATES[1], contact.lower, wear.secondary_depth),
    ):
        assert body.patch.node_areas() @ depth.ravel() == pytest.approx(rate * wear.energy_mJ, rel=1e-12)
        assert np.abs(depth - depth[::-1]).max() < 1e-9 * depth.max()
