"""Areas, noise and outliers of loops have one home."""

import numpy as np
import pytest

from wirewear.loops.area import enclosed_area, enclosed_areas
from wirewear.loops.noise import noises, outliers, outside_neighbours, sample_noise

PHASE = np.linspace(0.0, 2.0 * np.pi, 200, endpoint=False)


def test_the_area_is_signed_closes_itself_and_does_not_mind_the_origin() -> None:
    x, y = np.array([0.0, 0.0, 3.0, 3.0]), np.array([0.0, 2.0, 2.0, 0.0])
    assert enclosed_area(x, y) == 6.0
    assert enclosed_area(x[::-1], y[::-1]) == -6.0
    assert enclosed_area(x + 1e9, y - 1e9) == 6.0
    np.testing.assert_array_equal(enclosed_areas(np.stack([x, 2.0 * x]), np.stack([y, y])), [6.0, 12.0])


def test_noise_is_found_on_even_and_on_uneven_times_alike() -> None:
    random = np.random.default_rng(1)
    samples = np.sin(PHASE) + random.normal(0.0, 0.01, (50, PHASE.size))
    assert noises(samples) == pytest.approx(0.01, rel=0.35)
    assert float(np.median(noises(samples))) == pytest.approx(0.01, rel=0.05)
    assert sample_noise(samples[0], PHASE) == pytest.approx(0.01, rel=0.2)


def test_only_what_its_neighbours_do_not_bracket_is_outside() -> None:
    loops = np.stack([np.sin(PHASE), np.sign(np.sin(PHASE + 0.01))])
    loops[0, 40] += 0.5
    found = outside_neighbours(loops, lambda steps: 2.5 * steps[2] + 1e-9)
    assert np.flatnonzero(found[0]).tolist() == [40]
    assert not found[1].any()
    assert np.flatnonzero(outliers(loops[0], PHASE)).tolist() == [40]
