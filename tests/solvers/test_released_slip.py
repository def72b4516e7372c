"""Slip that follows the strain as friction fades or grows: what a jump predicts against a cycle traced after it."""

from dataclasses import replace

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

import solvers
from geometry import Cylinder, Elastic, Flat, GradedAxis, PlanarGeometry, PlanarMesh, Profile, build_planar
from tests.bodies import crossed_wires, pressed
from tests.solvers.wear_jumps import INCREMENTS, RATES, at_the_end, jumped, wires
from wirewear import reference

MESH_mm = 0.005
#: By the rig's stiffness, 0 where it is rigid; some two thirds of the fresh contact's radius stick.
STROKES_mm = {0.0: 4.0e-4, 20.0: 0.045}
CYCLES = 5000.0


@pytest.mark.seconds
@pytest.mark.parametrize("rig_N_per_mm", STROKES_mm)
def test_friction_work_after_a_jump_is_that_of_a_cycle_on_worn_surfaces(rig_N_per_mm: float) -> None:
    stroke = STROKES_mm[rig_N_per_mm]
    problem = crossed_wires(MESH_mm, long_patch=False, rig_N_per_mm=rig_N_per_mm or None, wear=RATES)
    start = at_the_end(problem, stroke)
    symmetry = solvers.symmetry_of(problem)
    quarter, folded, whole = (
        jumped(problem, start, CYCLES, symmetry=kept, stroke_mm=stroke)
        for kept in (symmetry, solvers.Symmetry(symmetry.across), solvers.Symmetry())
    )
    before, after = work(problem, start, stroke), work(problem, whole.state, stroke)
    assert abs(after / before - 1.0) > 0.15
    for jump in (quarter, whole):
        assert jump.friction_work == pytest.approx(after, abs=0.3 * abs(after - before))
    # What lies on the plane of the mirror is neither loaded twice nor left out.
    assert folded.friction_work == pytest.approx(whole.friction_work, rel=1e-6)
    depths = folded.state.wear.primary_depth, whole.state.wear.primary_depth
    assert depths[0] == pytest.approx(depths[1], abs=1e-6 * float(depths[1].max()))


def work(problem: solvers.ContactProblem, state: solvers.ContactState, stroke_mm: float) -> float:
    with threadpool_limits(limits=1, user_api="blas"):
        drive, none = solvers.Drive(stroke_mm), solvers.Symmetry()
        return solvers.closed_trace(problem, state, drive, INCREMENTS, none)[1].friction_work


@pytest.mark.seconds
@pytest.mark.parametrize(("rig_N_per_mm", "stroke_mm"), [(None, 1.2e-3), (167.0, 9.0e-3)])
def test_where_all_of_a_contact_slides_a_little_it_slides_farther_as_its_load_fades(
    rig_N_per_mm: float | None, stroke_mm: float
) -> None:
    free = crossed_wires(MESH_mm, long_patch=False, rig_N_per_mm=rig_N_per_mm, wear=RATES)
    approach = -pressed(free)[0].holder_z
    problem = replace(free, holder=replace(free.holder, approach_mm=approach))
    jump = jumped(problem, at_the_end(problem, stroke_mm), 400.0, stroke_mm=stroke_mm)
    assert jump.uncertain
    assert not jump.state.core.any()
    # Without what the strain gives back the jump predicts 7 and 37 % less work than the cycle after it does.
    assert jump.friction_work == pytest.approx(work(problem, jump.state, stroke_mm), rel=0.02)


@pytest.mark.seconds
def test_behind_a_soft_rig_slip_gives_up_what_a_growing_friction_takes() -> None:
    soft = wires(rig_N_per_mm=20.0)
    stroke, cycles = 0.08, 20.0
    grown = {0.0: replace(soft, friction=0.4), cycles: replace(soft, friction=0.6)}
    start = at_the_end(grown[0.0], stroke)
    jump = jumped(soft, start, cycles, stroke_mm=stroke, problem_at=lambda n, _: grown[0.0 if n < cycles else cycles])
    before, after = work(grown[0.0], start, stroke), work(grown[cycles], jump.state, stroke)
    assert jump.uncertain
    # The force is half as large again, and of 40 um that are left to slide at either side only 20 um remain.
    assert after == pytest.approx(0.75 * before, rel=0.1)
    assert jump.friction_work == pytest.approx(after, rel=0.05)


@pytest.mark.seconds
@pytest.mark.parametrize(("rig_N_per_mm", "stroke_mm"), [(None, 6.0e-4), (20.0, 0.045)])
def test_a_layer_that_wears_in_leaves_its_shear_to_the_slip(rig_N_per_mm: float | None, stroke_mm: float) -> None:
    bare = crossed_wires(MESH_mm, long_patch=False, rig_N_per_mm=rig_N_per_mm, wear=RATES)

    def problem_at(cycles: float, _energy_mJ: float) -> solvers.ContactProblem:
        return replace(bare, layers=(solvers.RoughLayer(1e-4 * np.exp(-cycles / 4e3)),))

    rough = problem_at(0.0, 0.0)
    start = at_the_end(rough, stroke_mm)
    jump = jumped(rough, start, 2e3, stroke_mm=stroke_mm, problem_at=problem_at)
    before, after = work(rough, start, stroke_mm), work(problem_at(2e3, 0.0), jump.state, stroke_mm)
    assert after > 1.05 * before
    assert jump.friction_work == pytest.approx(after, abs=0.2 * (after - before))


HALF_WIDTH_mm = 0.1
SOFT, STIFF = Elastic(70_000.0, 0.33), Elastic(210_000.0, 0.3)


def body(profile: Profile, half_width_mm: float, height_mm: float, a: float = HALF_WIDTH_mm, n: int = 16) -> PlanarMesh:
    along = GradedAxis(a / n, 1.2 * a, a, 3.0 * a)
    return build_planar(PlanarGeometry(profile, half_width_mm, height_mm, along, 0.05 * height_mm, 1.2))


@pytest.fixture(scope="module")
def wide() -> PlanarMesh:
    return body(Flat(), 60.0, 60.0)


def test_wide_bodies_of_different_materials_are_as_stiff_as_half_planes(wide: PlanarMesh) -> None:
    motion = solvers.move_stuck(wide, wide, STIFF, SOFT, HALF_WIDTH_mm)
    first, second = STIFF, SOFT
    exact = reference.half_plane_line_stiffness(first, second, HALF_WIDTH_mm, 1.0, 1.0)
    # Between different materials shear also presses, which the closed form leaves out.
    assert motion.stiffness_between(1.0) == pytest.approx(exact, rel=0.02)


@pytest.mark.slow
def test_a_contact_run_just_after_its_reversal_is_as_stiff_as_the_stuck_bodies() -> None:
    """Round pad on a flat, slid forth until all of it slips, then back by a hundredth of that."""
    load, radius, friction = 50.0, 6.0, 0.8
    exact = reference.hertz_line(load, radius, reference.contact_modulus(*(reference.Elastic(210_000.0, 0.3),) * 2))
    a = exact.half_width_mm
    pad, flat = (body(p, 5.0, 5.0, a, 24) for p in (Cylinder(radius, curved_along=True), Flat()))
    stuck = solvers.move_stuck(pad, flat, STIFF, STIFF, a).force_N_per_mm2
    upper, lower = (solvers.condense(b.mesh, b.patch, STIFF) for b in (pad, flat))
    problem = solvers.ContactProblem(
        upper=solvers.place(upper, upper=True, axis_angle_rad=0.0),
        lower=solvers.place(lower, upper=False, axis_angle_rad=0.0),
        holder=solvers.Holder(load),
        friction=friction,
        wear=solvers.WearRates(),
    )
    state, _ = solvers.press(problem, solvers.unloaded_state(problem))
    farthest = 1.5 * friction * load / stuck
    for drive in np.linspace(0.0, farthest, 6)[1:]:
        state, _ = solvers.advance(problem, state, float(drive), 0.0)
    assert abs(state.primary_force[:, 0].sum()) == pytest.approx(friction * load, rel=1e-3)
    step = 0.01 * farthest
    after, _ = solvers.advance(problem, state, farthest - step, 0.0)
    change = abs(float((after.primary_force - state.primary_force)[:, 0].sum()))
    assert change / step == pytest.approx(stuck, rel=0.01)


def test_bodies_change_places_without_changing_the_force_and_no_node_of_the_joint_parts() -> None:
    wide = body(Flat(), 10.0, 10.0)
    motion = solvers.move_stuck(wide, wide, SOFT, STIFF, HALF_WIDTH_mm)
    swapped = solvers.move_stuck(wide, wide, STIFF, SOFT, HALF_WIDTH_mm)
    assert swapped.force_N_per_mm2 == pytest.approx(motion.force_N_per_mm2, rel=1e-6)
    nodes, x = wide.patch.nodes[:, 0], wide.patch.axial_mm
    inside, beside = np.abs(x) <= HALF_WIDTH_mm, np.abs(x) > 1.5 * HALF_WIDTH_mm
    parted = np.abs(motion.upper_displacement - motion.lower_displacement)[nodes].max(axis=1)
    assert parted[inside].max() == 0.0
    assert parted[beside].min() > 0.0
