"""Planar bodies that stick together over their contact: against half-planes, and against a run with friction."""

import numpy as np
import pytest

from geometry import Cylinder, Elastic, Flat, GradedAxis, PlanarGeometry, PlanarMesh, Profile, build_planar
from solvers import (
    ContactProblem,
    Holder,
    WearRates,
    advance,
    condense,
    move_stuck,
    place,
    press,
    unloaded_state,
)
from wirewear import reference

HALF_WIDTH_mm = 0.1
SOFT, STIFF = Elastic(70_000.0, 0.33), Elastic(210_000.0, 0.3)


def body(profile: Profile, half_width_mm: float, height_mm: float, a: float = HALF_WIDTH_mm, n: int = 16) -> PlanarMesh:
    along = GradedAxis(a / n, 1.2 * a, a, 3.0 * a)
    return build_planar(PlanarGeometry(profile, half_width_mm, height_mm, along, 0.05 * height_mm, 1.2))


@pytest.fixture(scope="module")
def wide() -> PlanarMesh:
    return body(Flat(), 60.0, 60.0)


def test_wide_bodies_of_different_materials_are_as_stiff_as_half_planes(wide: PlanarMesh) -> None:
    motion = move_stuck(wide, wide, STIFF, SOFT, HALF_WIDTH_mm)
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
    stuck = move_stuck(pad, flat, STIFF, STIFF, a).force_N_per_mm2
    upper, lower = (condense(b.mesh, b.patch, STIFF) for b in (pad, flat))
    problem = ContactProblem(
        upper=place(upper, upper=True, axis_angle_rad=0.0),
        lower=place(lower, upper=False, axis_angle_rad=0.0),
        holder=Holder(load),
        friction=friction,
        wear=WearRates(),
    )
    state, _ = press(problem, unloaded_state(problem))
    farthest = 1.5 * friction * load / stuck
    for drive in np.linspace(0.0, farthest, 6)[1:]:
        state, _ = advance(problem, state, float(drive), 0.0)
    assert abs(state.primary_force[:, 0].sum()) == pytest.approx(friction * load, rel=1e-3)
    step = 0.01 * farthest
    after, _ = advance(problem, state, farthest - step, 0.0)
    change = abs(float((after.primary_force - state.primary_force)[:, 0].sum()))
    assert change / step == pytest.approx(stuck, rel=0.01)


def test_bodies_change_places_without_changing_the_force_and_no_node_of_the_joint_parts() -> None:
    wide = body(Flat(), 10.0, 10.0)
    motion = move_stuck(wide, wide, SOFT, STIFF, HALF_WIDTH_mm)
    swapped = move_stuck(wide, wide, STIFF, SOFT, HALF_WIDTH_mm)
    assert swapped.force_N_per_mm2 == pytest.approx(motion.force_N_per_mm2, rel=1e-6)
    nodes, x = wide.patch.nodes[:, 0], wide.patch.axial_mm
    inside, beside = np.abs(x) <= HALF_WIDTH_mm, np.abs(x) > 1.5 * HALF_WIDTH_mm
    parted = np.abs(motion.upper_displacement - motion.lower_displacement)[nodes].max(axis=1)
    assert parted[inside].max() == 0.0
    assert parted[beside].min() > 0.0
