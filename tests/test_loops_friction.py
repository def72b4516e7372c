"""Friction and scar slope resolved over the slip position."""

import numpy as np
import pytest

from tests.synthetic_loops import Recipe, SyntheticLoop, disturbed
from wirewear.loops import position_resolved_friction

RECIPE = Recipe(end_slope_rad=0.2, hook_power=2.0)
LOOP = SyntheticLoop(RECIPE)
# sliding takes up Q/K_s in the rig and 1.5 Q/K_c in the contact
SLIDING_STIFFNESS = 1e-3 / (1.0 / RECIPE.rig_stiffness + 1.5 / RECIPE.contact_stiffness)


@pytest.mark.parametrize(("noise", "within"), [(0.0, 0.005), (0.005, 0.02)])
def test_friction_is_uniform_and_the_slope_is_the_scars(noise: float, within: float) -> None:
    time, displacement, force = LOOP.sampled(400)
    displacement, force = disturbed(displacement, force, 2, noise, 0.0, 1.24)
    resolved = position_resolved_friction(
        displacement, force, 2.0, time_s=time, system_stiffness_N_per_um=SLIDING_STIFFNESS
    )
    x = resolved.slip_position_um
    inner = np.abs(x) < 0.8 * np.abs(x).max()
    np.testing.assert_allclose(resolved.friction[inner], 0.62, rtol=2.0 * within)
    reach = LOOP.own_amplitude_um - LOOP.slides_within_um
    expected = 0.2 * np.sign(x) * (x / reach) ** 2
    np.testing.assert_allclose(resolved.slope_angle_rad[inner], expected[inner], atol=within)


def test_friction_that_varies_along_the_slip_is_seen_where_it_varies() -> None:
    _, displacement, force = SyntheticLoop(Recipe(rig_stiffness=1e6)).sampled(400)
    patchy = force * (1.0 + 0.2 * np.exp(-(((displacement - 20.0) / 8.0) ** 2)))
    resolved = position_resolved_friction(displacement, patchy, 2.0)
    assert resolved.slip_position_um[np.argmax(resolved.friction)] == pytest.approx(20.0, abs=2.0)
    assert resolved.friction.max() == pytest.approx(1.2 * 0.62, rel=0.01)
