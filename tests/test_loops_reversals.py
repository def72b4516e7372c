"""Branches part where the drive turns, whatever the displacement reading makes of the force."""

import numpy as np
import pytest

from tests.synthetic_loops import Recipe, SyntheticLoop, disturbed
from wirewear.loops import analyse_loop
from wirewear.loops.branches import Branch, split_branches
from wirewear.loops.cleaning import clean_loop
from wirewear.loops.reversals import upright

Array = np.ndarray

#: Readings that lean against the force: up to eight times what this rig yields, 12 % of its stroke; µm/N and µm/N².
LEANS = ((-0.6, 0.0), (-1.5, 0.4), (-3.2, -0.5), (-5.0, 0.0), (-5.0, 1.5))
STIFF = Recipe(rig_stiffness=5e4)


def leaning(displacement: Array, force: Array, linear: float, quadratic: float) -> Array:
    return np.asarray(displacement + linear * force + quadratic * force**2)


def parted(displacement: Array, force: Array, time: Array | None = None) -> tuple[Branch, Branch]:
    return split_branches(upright(clean_loop(displacement, force, time_s=time)))


def fallen(branch: Branch) -> int:
    """Samples of a branch whose force has not yet come, or is already gone again: those of the other one."""
    half = 0.5 * float(branch.force_N.max())
    return int(np.count_nonzero(branch.force_N[3 * len(branch.samples) // 4 :] < half))


@pytest.mark.parametrize(("linear", "quadratic"), LEANS)
@pytest.mark.parametrize("phase", [0.0, 0.13, 0.61])
@pytest.mark.parametrize("samples", [48, 200])
def test_branches_are_the_same_whatever_function_of_the_force_is_added(
    linear: float, quadratic: float, phase: float, samples: int
) -> None:
    time, displacement, force = SyntheticLoop(STIFF).sampled(samples, phase)
    alone = parted(displacement, force, time)
    for one, other in zip(alone, parted(leaning(displacement, force, linear, quadratic), force, time), strict=True):
        # A sample or two beside a reversal may go with either: those by which an upright flank is left.
        assert len(set(one.samples.tolist()) ^ set(other.samples.tolist())) <= 4


@pytest.mark.parametrize(("linear", "quadratic"), LEANS)
def test_noise_leaves_the_branches_of_a_leaning_reading_where_they_are(linear: float, quadratic: float) -> None:
    time, displacement, force = SyntheticLoop(STIFF).sampled(200, 0.3)
    for seed in range(5):
        noisy = disturbed(leaning(displacement, force, linear, quadratic), force, seed, noise=0.004, outlier_share=0.0)
        for branch in parted(*noisy, time):
            assert fallen(branch) == 0
            assert float(branch.force_N[0]) < -0.4 * float(branch.force_N.max())


@pytest.mark.parametrize(("linear", "quadratic"), LEANS)
def test_figures_that_the_lean_leaves_alone_are_measured_and_no_stiffness_is(linear: float, quadratic: float) -> None:
    """∮Q df(Q) = 0, and a loop's width at a force is shifted as a whole."""
    time, displacement, force = SyntheticLoop(STIFF).sampled(200, 0.3)
    alone = analyse_loop(displacement, force, 2.0, time_s=time)
    read = leaning(displacement, force, linear, quadratic)
    found = analyse_loop(read, force, 2.0, time_s=time)
    assert found.dissipated_energy_mJ.value == pytest.approx(alone.dissipated_energy_mJ.value, rel=0.005)
    assert found.slip_amplitude_um.value == pytest.approx(alone.slip_amplitude_um.value, rel=0.005)
    assert found.displacement_amplitude_um.value == pytest.approx(0.5 * np.ptp(read), rel=0.001)
    assert found.friction_max is not None
    assert found.friction_max.value == pytest.approx(0.62, rel=0.02)
    assert found.regime == "gross slip"
    if linear < -1.0:
        assert found.measured_stiffness_N_per_um is None
        assert any("runs on while the force already falls" in note for note in found.notes)
