"""Motion along any direction in the plane of contact."""

from dataclasses import replace

import numpy as np
import pytest

from solvers.contact import ContactProblem
from solvers.placement import place
from tests.bodies import FRICTION, LOAD_N, condensed_wire, crossed_wires, driven, pressed
from tests.studies import MINIMAL
from wirewear import parse_study
from wirewear.simulation import discretise

MESH_mm = 0.010
# Stick, slip and reversal, but not the knee between them, where a coarse mesh decides.
STEPS_mm = 1e-3 * np.array([0.1, 0.2, 1.5, 4.0, 3.9, 1.0])


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


def test_equal_crossed_wires_answer_alike_in_every_direction() -> None:
    assert forces(turned(45.0)) == pytest.approx(forces(turned(0.0)), abs=0.01 * FRICTION * LOAD_N)


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
