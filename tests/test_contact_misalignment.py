"""A motion line tilted out of the contact plane: mean force under a dead weight, ripple of a sprung load."""

from dataclasses import replace
from math import atan, radians, tan

import numpy as np
import pytest

from solvers.contact import ContactProblem
from solvers.errors import SolverError
from solvers.holder import Holder
from solvers.misalignment import misaligned
from tests.bodies import FRICTION, LOAD_N, AMPLITUDE_mm, crossed_wires, driven, pressed

COARSE_mm = 0.010
ANGLE = radians(2.0)
#: To one end of the stroke, to the other, and back to the first.
WAY = AMPLITUDE_mm * np.array([0.3, 0.6, 0.9, 0.6, 0.3, 0.0, -0.3, -0.6, -0.9, -0.6, -0.3, 0.0, 0.3, 0.6, 0.9])


@pytest.fixture(scope="module")
def straight() -> ContactProblem:
    return crossed_wires(COARSE_mm, long_patch=True)


def run(problem: ContactProblem) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Tangential force, normal force and height of the holder above its place when just pressed."""
    start, _ = pressed(problem)
    states, reports = driven(problem, start, WAY)
    last = [pieces[-1] for pieces in reports]
    return (
        np.array([report.tangential_force for report in last]),
        np.array([report.normal_force for report in last]),
        np.array([state.holder_z - start.holder_z for state in states]),
    )


def test_without_friction_the_force_is_the_load_times_the_slope(straight: ContactProblem) -> None:
    force, load, height = run(misaligned(replace(straight, friction=0.0), ANGLE))
    assert force == pytest.approx(np.full(len(WAY), LOAD_N * tan(ANGLE)), rel=0.01)
    assert load == pytest.approx(np.full(len(WAY), LOAD_N), rel=1e-9)
    assert height == pytest.approx(WAY * tan(ANGLE), abs=1e-3 * AMPLITUDE_mm)


def test_sliding_takes_the_force_of_a_body_on_an_inclined_plane(straight: ContactProblem) -> None:
    force, _, _ = run(misaligned(straight, ANGLE))
    level, _, _ = run(straight)
    out, back = 0.3 * AMPLITUDE_mm == WAY, -0.6 * AMPLITUDE_mm == WAY
    rising, falling = float(force[out][-1]), float(force[back][0])
    # Curvature takes a little off the level force, too; the inclined plane tells how much the slope adds.
    phi = atan(float(level[out][-1]) / LOAD_N)
    assert rising == pytest.approx(LOAD_N * tan(phi + ANGLE), rel=2e-3)
    assert falling == pytest.approx(-LOAD_N * tan(phi - ANGLE), rel=2e-3)
    mean = 0.5 * (rising + falling)
    assert mean == pytest.approx(LOAD_N * tan(ANGLE) * (1.0 + FRICTION**2), rel=0.02)


def test_a_loading_spring_turns_the_rise_into_a_ripple_in_phase_with_the_motion(straight: ContactProblem) -> None:
    stiffness = 20.0
    _, load, height = run(misaligned(replace(straight, holder=Holder(LOAD_N, 0.0, stiffness)), ANGLE))
    assert load - LOAD_N == pytest.approx(stiffness * height, abs=1e-9)
    assert load - LOAD_N == pytest.approx(
        stiffness * WAY * tan(ANGLE), abs=0.02 * stiffness * AMPLITUDE_mm * tan(ANGLE)
    )


def test_the_opposite_angle_mirrors_the_forces(straight: ContactProblem) -> None:
    force, _, _ = run(misaligned(straight, ANGLE))
    mirrored = misaligned(straight, -ANGLE)
    _, reports = driven(mirrored, pressed(mirrored)[0], -WAY)
    assert [-pieces[-1].tangential_force for pieces in reports] == pytest.approx(force, abs=2e-3 * LOAD_N)


def test_aligned_motion_changes_nothing(straight: ContactProblem) -> None:
    first, second = run(straight), run(misaligned(straight, 0.0))
    assert all(np.array_equal(a, b) for a, b in zip(first, second, strict=True))


def test_a_senseless_angle_is_refused(straight: ContactProblem) -> None:
    with pytest.raises(SolverError, match="between -30 and 30 degrees"):
        misaligned(straight, radians(45.0))
