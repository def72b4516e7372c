"""The force just past the knee: adhesion at reversals shows there and nowhere else."""

from dataclasses import replace

import numpy as np
import pytest

from tests.diagnosis_cases import NOISE_N, nominal, record, states
from wirewear.diagnosis.model.forward import simulate
from wirewear.diagnosis.observe.knee import computed_peaks_N, knee_index, peak_N
from wirewear.diagnosis.observe.knee_peak import KneePeak
from wirewear.diagnosis.observe.reduction import reduce
from wirewear.records import MeasuredLoop


def _branch(peak_N: float = 0.0, samples: int = 400) -> tuple[np.ndarray, np.ndarray, float]:
    """Displacement and force of a branch that sticks up to 1 N over 10 of 120 µm; a peak decays over 4 µm past it."""
    x = np.linspace(-60.0, 60.0, samples)
    force = np.minimum(-1.0 + 2.0 * (x + 60.0) / 10.0, 1.0)
    past = np.maximum(x + 50.0, 0.0)
    return x, force + np.where(x > -50.0, peak_N * np.exp(-past / 4.0), 0.0), 60.0


def test_the_knee_is_where_sliding_begins() -> None:
    x, force, amplitude = _branch()
    assert x[knee_index(x + 60.0, force, 1.0, amplitude)] == pytest.approx(-50.0, abs=0.5)


def test_a_flat_plateau_has_no_peak_and_adhesion_has_one() -> None:
    for size in (0.0, 0.3):
        x, force, amplitude = _branch(size)
        peak, factor = peak_N(x + 50.0, force, amplitude)
        # Mean of exp(−s/4) over 0.9 to 7.2 µm.
        expected = size * 4.0 * (np.exp(-0.9 / 4.0) - np.exp(-7.2 / 4.0)) / 6.3
        assert peak == pytest.approx(expected, abs=0.012)
        assert factor == pytest.approx(np.sqrt(1.0 / 21.0 + 1.0 / 40.0), rel=0.05)


def test_windows_with_too_few_samples_tell_nothing() -> None:
    x, force, amplitude = _branch(0.3, samples=20)
    assert np.isnan(peak_N(x + 50.0, force, amplitude)[0])


def test_measured_and_computed_peaks_of_one_model_agree() -> None:
    observed = reduce(record(repeats=1, scatter=0.0, samples=400))
    knee = observed.layout.of_kind(KneePeak)
    computed = observed.layout.observed(simulate(states(), nominal("sensor"), observed.layout.cycles))
    assert knee.sum() == 8
    assert np.abs(observed.values[0, knee] - computed[knee]).max() < 5.0 * observed.noise[0, knee].max()


def test_both_branches_of_a_computed_loop_have_the_same_peak() -> None:
    x, force, _ = _branch(0.3)
    peaks = computed_peaks_N(np.stack([x, -x])[None], np.stack([force, -force])[None])
    assert peaks[0, 0] == pytest.approx(peaks[0, 1])
    assert peaks[0, 0] > 0.1


def test_adhesion_is_seen_in_a_record() -> None:
    one = record(repeats=1, samples=400)

    def sticky(loop: MeasuredLoop) -> MeasuredLoop:
        x, force = loop.displacement_um, loop.tangential_force_N
        forward = np.gradient(x) > 0.0
        knee = {True: -48.0, False: 48.0}
        past = np.where(forward, x - knee[True], knee[False] - x)
        lift = np.where(past > 0.0, 0.3 * np.exp(-np.maximum(past, 0.0) / 4.0), 0.0)
        return replace(loop, tangential_force_N=force + np.where(forward, lift, -lift))

    plain, adhesive = (reduce(replace(one, loops=loops)) for loops in (one.loops, tuple(map(sticky, one.loops))))
    peaks = []
    for own in (plain, adhesive):
        knee = own.layout.of_kind(KneePeak)
        peaks.append(own.layout.branch[knee] * own.values[0, knee])
    # Means over so many samples leave 0.27 of their noise.
    assert (peaks[1] - peaks[0]).min() > 5.0 * NOISE_N * 0.27


def test_the_knee_stays_where_a_drive_turns_between_two_samples() -> None:
    """The first sample has most of the rise behind it, which the other branch's end knows; walls pass for the rest."""
    x = np.arange(-59.4, 60.0, 0.6)
    force = np.minimum(-2.2 + 4.33 * (x + 60.0), 1.1 + 0.5 * (1.0 - np.exp(-(x + 59.0) / 20.0)))
    unknown, known = (x[knee_index(x + 60.0, force, 1.6, 60.0, reversal)] for reversal in (np.inf, -2.2))
    assert known == pytest.approx(-59.0, abs=0.6)
    assert unknown > -50.0
