"""What the diagnosis of line contacts reads: the state of a loop, a profile about its middle, known beforehand."""

import numpy as np
import pytest

from geometry.arrays import Array
from wirewear.diagnosis.observe.scars import read_profile
from wirewear.diagnosis.surrogate.line_states import LineStates, WornProfiles, _row, _with_stuck
from wirewear.diagnosis.surrogate.line_wear import WornLine
from wirewear.records import MeasuredProfile
from wirewear.results import Loop

FRICTION, LOAD_N, STIFFNESS_N_per_um = 0.6, 100.0, 8.0
AMPLITUDE_um = 40.0


def loop(full: float) -> Loop:
    """Slip begins along q(x) of F/K (1 − (1 − q)^(1/F)), then the contact slides on a plane; from mid-stroke on."""
    rise = 2.0 * FRICTION * LOAD_N
    share = 1.0 - (1.0 - np.linspace(0.0, 1.0, 200)) ** 2
    travel = full / STIFFNESS_N_per_um * rise * (1.0 - (1.0 - share) ** (1.0 / full))
    travel = np.append(travel, np.linspace(travel[-1], 2.0 * AMPLITUDE_um, 400)[1:])
    force = rise * np.append(share, np.ones(399)) - 0.5 * rise
    x, q = np.append(travel[:-1] - AMPLITUDE_um, AMPLITUDE_um - travel[:-1]), np.append(force[:-1], -force[:-1])
    x, q = np.roll(x, -300), np.roll(q, -300)
    time = np.arange(x.size) / x.size
    return Loop(7, time, x, x, q, np.full(x.size, LOAD_N), np.zeros(x.size))


@pytest.mark.parametrize("full", [1.0001, 1.05])
def test_a_loop_of_a_line_contact_gives_its_slip_friction_stiffness_and_load(full: float) -> None:
    row = _row(loop(full), FRICTION)
    assert row is not None
    cycle, shape, slip, slope, angle, stiffness, load, lift = row
    assert (cycle, shape) == (7, full)
    assert stiffness == pytest.approx(STIFFNESS_N_per_um, rel=0.01)
    assert slip == pytest.approx(AMPLITUDE_um - full * FRICTION * LOAD_N / STIFFNESS_N_per_um, rel=0.01)
    assert np.abs(np.concatenate([slope, angle, lift])).max() < 1e-3
    assert load == pytest.approx(LOAD_N)


def test_a_predicted_profile_has_the_area_that_its_body_loses_and_reaches_as_far_as_it_slips() -> None:
    place = np.linspace(-1.6, 1.6, 321)
    own = WornProfiles(np.array([400.0]), place, 0.75 * np.maximum(1.0 - place**2, 0.0)[None], 0.4, 20.0, 0.5)
    both = WornLine(np.zeros(1), np.array([0.0, 1e-3]), np.zeros((2, 1)), np.ones(2), np.array([0.1, 0.1]))
    x, depth = LineStates._profile(LineStates.__new__(LineStates), own, 500.0, 30.0, both, both)
    assert np.trapezoid(depth, x) == pytest.approx(0.4 * 500.0, rel=1e-3)
    assert np.ptp(x[depth > 0.0]) == pytest.approx(2.0 * (100.0 + 0.5 * 10.0), rel=0.02)


def cattaneo(x: Array, stuck: float) -> Array:
    """Hertz's pressure times the slip of Cattaneo, the integral of √(x² − c²), by a sum."""
    slope = np.sqrt(np.maximum(x**2 - stuck**2, 0.0))
    slip = np.abs(np.cumsum(slope) - 0.5 * slope.sum()) * (x[1] - x[0])
    return np.asarray(np.sqrt(np.maximum(1.0 - x**2, 0.0)) * slip)


@pytest.mark.parametrize("after", [0.0, 0.25, 0.7])
def test_a_profile_that_sticks_elsewhere_is_worn_where_cattaneo_slips(after: float) -> None:
    x = np.linspace(-1.0, 1.0, 4001)
    place, depth = _with_stuck(x, cattaneo(x, 0.45), 0.45, after)
    expected = cattaneo(x, after) * np.trapezoid(cattaneo(x, 0.45), x) / np.trapezoid(cattaneo(x, after), x)
    assert np.interp(x, place, depth)[5:-5] == pytest.approx(expected[5:-5], abs=0.02 * expected.max())


def test_a_profile_is_read_about_its_middle_with_its_roughness_and_the_error_of_its_zero() -> None:
    random = np.random.default_rng(5)
    x = np.linspace(-150.0, 150.0, 301)
    depth = 5.0 * np.maximum(1.0 - ((x - 50.0) / 100.0) ** 2, 0.0) + 0.15 + 0.1 * random.standard_normal(x.size)
    read = read_profile(MeasuredProfile(1, "pad", x, depth))
    assert x - read.x_um == pytest.approx(np.full(x.size, 50.0), abs=1.0)
    # Running means over 21 µm widen it by a few.
    assert read.half_width_um == pytest.approx(103.0, rel=0.03)
    assert read.rough_um == pytest.approx(0.1, rel=0.15)
    assert read.zero_um == pytest.approx(0.15, abs=0.04)
    assert read.alike < 0.1
    # A mean of neighbours that are not alike is known √n better.
    assert read.error_of(16, 0.0) == pytest.approx(0.25 * read.rough_um, rel=0.15)
    assert read.error_of(4, 2.0) == pytest.approx(1.0, rel=0.15)
