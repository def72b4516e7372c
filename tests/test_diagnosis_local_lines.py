"""Lines through the samples near a place: neighbouring ones share samples, and so part of their error."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.diagnosis_cases import record
from wirewear.diagnosis.model.setup import Array
from wirewear.diagnosis.observe.branch import ObservedBranch
from wirewear.diagnosis.observe.local_lines import LocalLine, force_at
from wirewear.diagnosis.observe.plateau import PlateauForce
from wirewear.diagnosis.observe.reading import read
from wirewear.diagnosis.observe.sites import Sites
from wirewear.diagnosis.observe.stick import Stick

WINDOW_um = 4.2


def plateau(samples: int, force: Array | float = 1.2) -> ObservedBranch:
    """A branch of an eccentric's stroke whose plateau has no slope, from which noise is to be read."""
    at = -60.0 * np.cos(np.pi * np.linspace(0.0, 1.0, samples))
    return ObservedBranch(1, at, force + np.zeros(samples), 3)


def line(branch: ObservedBranch, at_um: float) -> LocalLine:
    found = force_at(branch, at_um, WINDOW_um)
    assert found is not None
    return found


@pytest.mark.parametrize("samples", [48, 200])
def test_errors_of_neighbouring_places_hang_together_as_many_noisy_branches_say(samples: int) -> None:
    random = np.random.default_rng(4)
    places = (-9.0, 0.0, 6.0)
    noisy = [plateau(samples, 1.2 + random.normal(0.0, 0.01, samples)) for _ in range(1500)]
    read_off = np.array([[line(branch, at).value for at in places] for branch in noisy])
    seen = np.corrcoef(read_off.T)
    lines = [line(plateau(samples), at) for at in places]
    for i, one in enumerate(lines):
        for j, other in enumerate(lines):
            # Lines that reach far have an error of their own beside that of the samples.
            foreseen = one.correlation(other, 0.0) / (one.sampled * other.sampled)
            assert seen[i, j] == pytest.approx(foreseen, abs=0.08)


def test_lines_without_a_common_sample_share_errors_of_correlated_noise_only() -> None:
    left, right = (line(plateau(400), at) for at in (-20.0, 20.0))
    assert left.correlation(right, 0.0) == 0.0
    near = line(plateau(400), -11.0)
    assert 0.0 < left.correlation(near, 0.8) < 0.5


def test_a_line_that_must_reach_far_has_most_of_its_error_to_itself_where_plateaus_bend() -> None:
    fine, coarse = line(plateau(400), 36.0), line(plateau(16), 36.0)
    assert fine.sampled > 0.95
    assert coarse.sampled < 0.6
    assert line(plateau(16), 0.0).sampled == 1.0


def test_lines_are_believed_to_miss_most_where_they_miss_most_of_a_wall() -> None:
    """Of a wall in the fourth power of the place: at mid-stroke nothing, further out the more the fewer samples."""
    missed, own = {}, {}
    for samples in (16, 24, 40, 96):
        wall = 0.2 * np.cos(np.pi * np.linspace(0.0, 1.0, samples)) ** 4
        for at in (0.0, 36.0):
            found = line(plateau(samples, wall), at)
            missed[at, samples] = abs(found.value - 0.2 * (at / 60.0) ** 4)
            own[at, samples] = np.sqrt(1.0 - found.sampled**2)
    assert missed[0.0, 16] < 0.1 * missed[36.0, 16]
    assert own[0.0, 16] == 0.0
    further = [(missed[36.0, samples], own[36.0, samples]) for samples in (96, 40, 24, 16)]
    assert all(a[0] < b[0] and a[1] < b[1] for a, b in pairwise(further))


@settings(max_examples=20, deadline=None)
@given(samples=st.integers(20, 300), correlation=st.floats(0.0, 0.9))
def test_errors_that_hang_together_are_a_covariance(samples: int, correlation: float) -> None:
    lines = [force_at(plateau(samples), at, WINDOW_um) for at in np.linspace(-40.0, 54.0, 12)]
    found = [one for one in lines if one is not None]
    matrix = np.array(
        [[1.0 if one is other else one.correlation(other, correlation) for other in found] for one in found]
    )
    assert np.linalg.eigvalsh(matrix).min() > 0.0


@pytest.mark.parametrize("kind", [PlateauForce, Stick])
def test_numbers_of_different_loops_share_no_sample(kind: type[PlateauForce] | type[Stick]) -> None:
    one = record(repeats=1)
    reading = read(replace(one, loops=one.loops[:2]))
    observable = kind()
    sites = Sites.of(observable.sites(reading))
    alike = observable.alike(reading, 1, sites)
    apart = (sites.cycle[:, None] != sites.cycle) | (sites.branch[:, None] != sites.branch)
    assert not alike[apart].any()
    assert np.array_equal(alike, alike.T)
    assert np.array_equal(np.diag(alike), np.ones(len(sites)))
