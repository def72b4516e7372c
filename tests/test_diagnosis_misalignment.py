"""Motion that leans against the load, as the fast model foresees it, beside the independent model."""

from functools import cache

import numpy as np
import pytest

from tests.diagnosis_cases import nominal, states, with_effect
from tests.independent_records import independent_record
from wirewear.diagnosis.model.forward import simulate
from wirewear.diagnosis.model.setup import Array

pytestmark = pytest.mark.slow

LEANING = {"angle_deg": 2.5}

#: Of the first loop: displacement, tangential and normal force.
Loop = tuple[Array, Array, Array]


@cache
def independent(*, leaning: bool) -> Loop:
    loop = independent_record({"misalignment": LEANING} if leaning else None, repeats=1, drive="stroke").loops[0]
    assert loop.normal_force_N is not None
    return loop.displacement_um, loop.tangential_force_N, loop.normal_force_N


@cache
def foreseen(*, leaning: bool) -> Loop:
    setup = nominal("stroke")
    course = simulate(states(), with_effect(setup, "misalignment", LEANING) if leaning else setup, np.array([100.0]))
    channels = course.displacement_um, course.tangential_force_N, course.normal_force_N
    x, q, p = (channel[0].ravel() for channel in channels)
    return x, q, p


def ripple_N_per_um(plain: Loop, leaning: Loop) -> float:
    """By which the load rises along the motion; the noise of both records is the same."""
    return float(np.polyfit(leaning[0], leaning[2] - plain[2], 1)[0])


def bend_um(loop: Loop) -> float:
    """Displacement at ±1 N less twice that at none, mean over both branches while they stick."""
    x, q = np.roll(loop[0], -int(np.argmin(loop[0]))), np.roll(loop[1], -int(np.argmin(loop[0])))
    top, means = int(np.argmax(x)), np.zeros(3)
    for branch in (slice(0, top), slice(top, None)):
        near = np.abs(q[branch]) < 1.15
        order = np.argsort(q[branch][near])
        means += 0.5 * np.interp([-1.0, 0.0, 1.0], q[branch][near][order], x[branch][near][order])
    return float(means[0] + means[2] - 2.0 * means[1])


def test_a_wire_that_climbs_presses_the_loading_spring() -> None:
    model, rig = (ripple_N_per_um(of(leaning=False), of(leaning=True)) for of in (foreseen, independent))
    assert rig > 3e-5
    assert model == pytest.approx(rig, rel=0.1)


def test_the_holder_yields_to_the_force_along_the_motion_not_to_that_along_the_plane() -> None:
    """Without it, branches of a misaligned contact look as if the reading leant with the square of the force."""
    model, rig = (bend_um(of(leaning=True)) - bend_um(of(leaning=False)) for of in (foreseen, independent))
    assert model == pytest.approx(rig, abs=0.1)
