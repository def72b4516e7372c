"""How the independent model's loops are logged: noise on shelves, forces that do not reverse, tips and spikes."""

from dataclasses import replace

import numpy as np
import pytest

from studies.blind.generators.independent.sensing import read
from studies.blind.generators.sampling import despiked, loop_figures
from tests.test_blind_model import RIGID, at


@pytest.mark.parametrize("offset_N", [0.0, 0.07])
def test_noise_on_the_shelf_of_a_free_play_does_not_decide_the_logged_slip_amplitude(offset_N: float) -> None:
    world = replace(RIGID, rig=replace(RIGID.rig, play_mm=5e-3))
    [snapshot] = at(world, 300, points=12)
    seen = read(world, snapshot.loop, 300)
    displacement, force = 1e3 * seen.displacement_mm[::4], seen.tangential_force_N[::4] + offset_N
    random = np.random.default_rng(0)
    noisy = [force + 0.008 * random.standard_normal(force.size) for _ in range(20)]
    widths = [loop_figures(displacement, one)["slip_amplitude_um"] for one in noisy]
    # The play takes half of itself from each side: slip is what is left of the stroke.
    assert np.mean(widths) == pytest.approx(59.5 - 2.5, abs=0.3)
    assert np.std(widths) < 0.1


def test_a_loop_whose_force_does_not_reverse_has_no_slip_amplitude() -> None:
    phase = 2.0 * np.pi * np.arange(200) / 200
    assert loop_figures(60.0 * np.sin(phase), 2.0 + np.cos(phase))["slip_amplitude_um"] == 0.0


def test_the_tips_of_a_coarse_loop_are_no_spikes() -> None:
    place = 60.0 * np.sin(2.0 * np.pi * np.arange(40) / 40)
    assert despiked(place) == pytest.approx(place)
    spiked = place.copy()
    spiked[3] += 30.0
    assert despiked(spiked)[3] == pytest.approx(place[3], abs=15.0)
