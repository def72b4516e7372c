"""Slip that follows the strain as friction fades or grows: what a jump foresees against a cycle traced after it."""

from dataclasses import replace

import pytest
from threadpoolctl import threadpool_limits

from solvers import ContactProblem, ContactState, RoughLayer, Symmetry, closed_trace, symmetry_of
from tests.bodies import crossed_wires, pressed
from tests.wear_jumps import INCREMENTS, RATES, at_the_end, jumped, wires

pytestmark = pytest.mark.seconds

MESH_mm = 0.005
#: By the rig's stiffness, 0 where it is rigid; some two thirds of the fresh contact's radius stick.
STROKES_mm = {0.0: 4.0e-4, 20.0: 0.045}
CYCLES = 5000.0


@pytest.mark.parametrize("rig_N_per_mm", STROKES_mm)
@pytest.mark.parametrize("folded", [True, False])
def test_friction_work_after_a_jump_is_that_of_the_cycle_on_the_worn_surfaces(
    rig_N_per_mm: float, folded: bool
) -> None:
    stroke = STROKES_mm[rig_N_per_mm]
    problem = crossed_wires(MESH_mm, long_patch=False, rig_N_per_mm=rig_N_per_mm or None, wear=RATES)
    symmetry = symmetry_of(problem) if folded else Symmetry()
    start = at_the_end(problem, stroke)
    jump = jumped(problem, start, CYCLES, symmetry=symmetry, stroke_mm=stroke)
    before, after = work(problem, start, stroke), work(problem, jump.state, stroke)
    assert abs(after / before - 1.0) > 0.15
    assert jump.friction_work == pytest.approx(after, abs=0.3 * abs(after - before))


def work(problem: ContactProblem, state: ContactState, stroke_mm: float) -> float:
    with threadpool_limits(limits=1, user_api="blas"):
        return closed_trace(problem, state, stroke_mm, INCREMENTS, Symmetry())[1].friction_work


@pytest.mark.parametrize(("rig_N_per_mm", "stroke_mm"), [(None, 1.2e-3), (167.0, 9.0e-3)])
def test_where_all_of_a_contact_slides_a_little_it_slides_farther_as_its_load_fades(
    rig_N_per_mm: float | None, stroke_mm: float
) -> None:
    free = crossed_wires(MESH_mm, long_patch=False, rig_N_per_mm=rig_N_per_mm, wear=RATES)
    approach = -pressed(free)[0].holder_z
    problem = replace(free, holder=replace(free.holder, approach_mm=approach))
    start = at_the_end(problem, stroke_mm)
    jump = jumped(problem, start, 400.0, stroke_mm=stroke_mm)
    assert jump.uncertain
    assert not jump.state.core.any()
    # Without what the strain gives back the jump foresees 7 and 37 % less work than the cycle after it does.
    assert jump.friction_work == pytest.approx(work(problem, jump.state, stroke_mm), rel=0.02)


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


@pytest.mark.parametrize(("rig_N_per_mm", "stroke_mm"), [(None, 6.0e-4), (20.0, 0.045)])
def test_a_layer_that_wears_in_leaves_its_shear_to_the_slip(rig_N_per_mm: float | None, stroke_mm: float) -> None:
    layer = RoughLayer(1e-4)
    bare = crossed_wires(MESH_mm, long_patch=False, rig_N_per_mm=rig_N_per_mm, wear=RATES)

    def problem_at(cycles: float, _energy_mJ: float) -> ContactProblem:
        return replace(bare, layers=(layer.worn_in(cycles, 4e3),))

    rough = problem_at(0.0, 0.0)
    start = at_the_end(rough, stroke_mm)
    jump = jumped(rough, start, 2e3, stroke_mm=stroke_mm, problem_at=problem_at)
    before, after = work(rough, start, stroke_mm), work(problem_at(2e3, 0.0), jump.state, stroke_mm)
    assert after > 1.05 * before
    assert jump.friction_work == pytest.approx(after, abs=0.2 * (after - before))
