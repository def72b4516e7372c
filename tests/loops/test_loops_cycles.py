"""Cycles of a drive, found by where it turns: ripples are none, blocks of smaller strokes are."""

from collections.abc import Sequence

import numpy as np
import pytest

from geometry.arrays import Array
from wirewear.loops import analyse_loop
from wirewear.loops.cycles import cycles_between, split_cycles, turns_of
from wirewear.records.importing.guessed_conditions import frequency_of

SAMPLES = 200


def noisy(x: Array) -> Array:
    return x + 0.1 * np.random.default_rng(0).standard_normal(x.size)


@pytest.mark.parametrize("start", [0.0, 0.1, 0.25, 0.3])
@pytest.mark.parametrize("often", [5.0, 9.0, 16.7, 27.0, 50.0])
@pytest.mark.parametrize("ripple_um", [2.0, 4.0, 8.0])
def test_a_drive_that_ripples_has_the_cycles_of_its_stroke(start: float, often: float, ripple_um: float) -> None:
    time = np.arange(3 * SAMPLES) / SAMPLES
    x = noisy(60.0 * np.sin(2.0 * np.pi * (time + start)) + ripple_um * np.sin(2.0 * np.pi * often * time + 0.3))
    parts = split_cycles(x)
    assert len(parts) == 3
    assert all(np.ptp(x[part]) > 110.0 for part in parts)
    one = x[:SAMPLES]
    assert cycles_between(one, turns_of(one)) == pytest.approx(1.0, abs=0.13)


@pytest.mark.parametrize("rising", [0.5, 0.3, 0.2])
@pytest.mark.parametrize("often", [9.0, 27.3])
def test_ripples_on_the_slow_sweep_of_a_drive_with_a_fast_return_are_no_cycles(rising: float, often: float) -> None:
    time = np.arange(3 * SAMPLES) / SAMPLES
    drive = np.interp((time + 0.1) % 1.0, [0.0, rising, 1.0], [-60.0, 60.0, -60.0])
    assert len(split_cycles(noisy(drive + 8.0 * np.sin(2.0 * np.pi * often * time)))) == 3


@pytest.mark.parametrize(
    "amplitudes_um",
    [
        (4,) * 9 + (60,) * 3,
        (60,) * 2 + (4,) * 5 + (60,) * 2,
        (60, 20) * 4,
        (5, 10, 20, 40, 60),
        (60,) + (4,) * 20 + (60,),
    ],
)
def test_blocks_of_smaller_strokes_are_cycles_of_their_own(amplitudes_um: Sequence[float]) -> None:
    phase = 2.0 * np.pi * np.arange(SAMPLES * len(amplitudes_um)) / SAMPLES
    x = noisy(np.repeat(np.array(amplitudes_um, dtype=float), SAMPLES) * np.sin(phase))
    found = [0.5 * float(np.ptp(x[part])) for part in split_cycles(x)]
    assert found == pytest.approx(amplitudes_um, abs=0.5)


@pytest.mark.parametrize(("share", "ratio"), [(0.0, 1.0), (0.05, 16.7), (0.2, 7.1)])
@pytest.mark.parametrize("cycles", [3.0, 5.4])
@pytest.mark.parametrize("start", [0.0, 1.0, 0.5 * np.pi])
def test_the_frequency_of_a_drive_is_right_under_ripples(
    share: float, ratio: float, cycles: float, start: float
) -> None:
    time = np.arange(int(1000 * cycles)) / 3000.0
    phase = 6.0 * np.pi * time
    x = 50.0 * (np.sin(phase + start) + 0.2 * np.sin(2.0 * phase) + share * np.sin(ratio * phase + 0.4))
    found, doubt = frequency_of({"displacement_um": x, "time_s": time}, {})
    assert found == pytest.approx(3.0, rel=5e-4)
    assert not doubt


@pytest.mark.parametrize(("ripple_um", "often", "samples"), [(4.0, 23, 600), (6.0, 11, 800), (5.0, 23, 2000)])
def test_the_friction_of_a_contact_that_a_ripple_unloads_is_that_at_which_it_slides(
    ripple_um: float, often: int, samples: int
) -> None:
    angle = 2.0 * np.pi * np.arange(2 * samples) / samples
    x, force = ripple_um * np.sin(often * angle) - 60.0 * np.cos(angle), np.full(2 * samples, -1.2)
    for place, step in enumerate(np.diff(x)):
        force[place + 1] = np.clip(force[place] + 0.167 * step, -1.2, 1.2)
    x, force = noisy(x)[samples:], noisy(20.0 * force)[samples:] / 20.0
    figures = analyse_loop(x, force, 2.0)
    for found in (figures.friction_max, figures.friction_geometry_independent, figures.friction_forward):
        assert found is not None
        assert found.value == pytest.approx(0.6, rel=0.01)
    assert figures.end_hook_ratio is not None
    assert figures.end_hook_ratio.value == pytest.approx(1.0, rel=0.01)
