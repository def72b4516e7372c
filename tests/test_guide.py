"""First guesses from a cycle before: found by the drive, on the stroke that was recorded or is its mirror image."""

import numpy as np
import pytest

from solvers.guide import Guide
from solvers.wear_step.symmetry import Mirror, with_images

MIRROR = Mirror(-1.0, 1.0, np.array([2, 1, 0]), np.array([1, 0]))


def half(side: float) -> Guide:
    """The stroke that starts at side x 0.06 mm."""
    drive = side * np.array([0.05, 0.01, -0.03, -0.06])
    traction = np.random.default_rng(4).uniform(size=(4, 3, 3))
    phase = np.array([0.1, 0.2, 0.3, 0.5]) + (0.0 if side > 0.0 else 0.5)
    return Guide(phase, drive, 0.1 * drive + side * 0.007, np.array([1.0, 2.0, 3.0, 4.0]), traction)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_stroke_that_was_recorded_is_guessed_by_its_drive_whatever_the_phase(side: float) -> None:
    guide = half(side)
    guess = guide.at(float(guide.phase[0]), float(guide.drive[2]) + 1e-9)
    assert guess is not None
    assert guess.holder_x == pytest.approx(guide.holder_x[2], abs=1e-9)
    assert np.array_equal(guess.traction, guide.traction[2])
    between = guide.at(float(guide.phase[0]), 0.5 * float(guide.drive[1] + guide.drive[2]))
    assert between is not None
    assert between.holder_x == pytest.approx(0.5 * (guide.holder_x[1] + guide.holder_x[2]))


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_other_stroke_is_not_guessed_unless_a_mirror_makes_it(side: float) -> None:
    guide = half(side)
    other = 0.75 if side > 0.0 else 0.25
    assert guide.at(other, 0.0) is None
    whole = with_images(guide, MIRROR)
    assert np.all(np.diff(whole.phase) > 0.0)
    for drive in (-0.04, 0.0, 0.03):
        there, back = whole.at(0.25, drive), whole.at(0.75, -drive)
        assert there is not None
        assert back is not None
        assert back.holder_x == pytest.approx(-there.holder_x)
        assert back.traction == pytest.approx(there.traction[MIRROR.primary] * MIRROR.signs)


def test_a_whole_cycle_and_one_without_symmetry_stay_as_they_are() -> None:
    guide = half(1.0)
    assert with_images(guide, None) is guide
    whole = with_images(guide, MIRROR)
    assert with_images(whole, MIRROR) is whole


def test_a_stroke_begins_where_the_other_one_ends() -> None:
    whole = with_images(half(1.0), MIRROR)
    start = whole.at(0.01, 0.06)
    assert start is not None
    assert start.holder_x == pytest.approx(whole.holder_x[-1])
