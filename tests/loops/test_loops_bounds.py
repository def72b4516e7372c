"""Figures of loops obey the bounds of physics, whatever rings, hooks or is read badly, and hold the truth or are noted.

Of loops of all kinds of disturbance truths are in closed form. A clipped loop has noise: without any, a clipped plateau
is the flat one of less friction. With ringing, the largest force is the ringing's own. A 95 % interval misses one truth
in twenty, so that of all figures of a loop next to none is off by more than twice its interval, and nineteen in twenty
by no more than it; 3 % beside stand for what the figures' definitions leave open.
"""

from collections.abc import Callable, Iterator
from random import Random
from typing import Any

import numpy as np
import pytest

from tests.loops.masing_loops import Disturbance, MasingLoop
from tests.synthetic_loops import Recipe, SyntheticLoop, disturbed
from wirewear.loops import LoopError, LoopFigures, Measured, analyse_loop
from wirewear.loops.branches import Branch, split_branches, upright
from wirewear.loops.cleaning import clean_loop
from wirewear.views.loops_report import rounded

AMPLITUDE_um, SLIDING_N = 2000.0, 2.08


def ringing(seed: int) -> LoopFigures:
    """46 samples a cycle of a drive with fast turns; the force slides at once and rings after each reversal."""
    random = np.random.default_rng(seed)
    phase = (np.arange(46) + random.random()) / 46
    displacement = -AMPLITUDE_um * np.cos(2.0 * np.pi * phase)
    since = (phase % 0.5) * 2.0
    ring = 2.4 * np.exp(-since / 0.25) * np.cos(np.pi * (46 * since / 2.0 + random.random()))
    force = np.where(phase % 1.0 < 0.5, 1.0, -1.0) * (SLIDING_N + ring) + 0.15 * random.standard_normal(46)
    return analyse_loop(displacement, force, 20.0, time_s=phase)


def assert_bounded(figures: LoopFigures) -> None:
    assert 0.0 <= figures.slip_amplitude_um.value <= figures.displacement_amplitude_um.value
    for ratio in (figures.energy_ratio, figures.system_free_ratio):
        assert ratio is None or 0.0 <= ratio.value <= 1.0
    if figures.friction_energy is not None and figures.friction_max is not None:
        assert 0.0 <= figures.friction_energy.value <= figures.friction_max.value


@pytest.mark.parametrize("seed", range(12))
def test_a_coarse_force_that_rings_after_reversals_keeps_its_slip_and_friction(seed: int) -> None:
    figures = ringing(seed)
    assert_bounded(figures)
    assert figures.slip_amplitude_um.value == pytest.approx(AMPLITUDE_um, rel=0.05)
    assert figures.friction_energy is not None
    assert figures.friction_energy.value == pytest.approx(SLIDING_N / 20.0, rel=0.15)


@pytest.mark.parametrize("friction", [0.001, 0.01, 0.05])
@pytest.mark.parametrize("rig_stiffness", [1e9, 167.0])
def test_slip_under_hooks_above_the_plateau_is_all_that_a_contact_slides(friction: float, rig_stiffness: float) -> None:
    loop = SyntheticLoop(Recipe(friction, end_slope_rad=0.15, hook_power=3.0, rig_stiffness=rig_stiffness))
    _, displacement, force = loop.sampled(200, 0.2)
    figures = analyse_loop(displacement, force, 2.0)
    assert figures.slip_amplitude_um.value == pytest.approx(loop.own_amplitude_um, rel=0.02)
    assert figures.friction_energy is not None
    assert figures.friction_energy.value == pytest.approx(friction, rel=0.02)
    assert any("energy over four times" in note for note in figures.notes)
    assert_bounded(figures)


@pytest.mark.seconds
@pytest.mark.parametrize("samples", [128, 200, 256])
@pytest.mark.parametrize("noise", [0.0, 0.003])
@pytest.mark.parametrize("rig_N_per_um", [1e6, 0.6])
@pytest.mark.parametrize("wall", [0.5, 1.0, 1.05, 1.3, 1.5, 1.7, 2.5])
def test_walls_higher_than_the_friction_are_no_play_and_leave_the_friction_within_its_interval(
    wall: float, rig_N_per_um: float, noise: float, samples: int
) -> None:
    loop = MasingLoop(0.6, 5.0, 60.0, 2.0, 1.5, rig_N_per_um, wall=wall)
    time, displacement, force = Disturbance(samples, phase=0.3, noise=noise).of(loop)
    figures = analyse_loop(displacement, force, loop.normal_force_N, time_s=time)
    assert figures.free_play_um is None
    assert figures.friction_energy is not None
    for figure, truth in (
        (figures.friction_energy, loop.friction),
        (figures.slip_amplitude_um, 1e3 * loop.energy_mJ / (4.0 * loop.limit_N)),
    ):
        assert figure.interval95[0] - 0.01 * truth <= truth <= figure.interval95[1] + 0.01 * truth


@pytest.mark.parametrize("noise", [0.0, 0.003])
def test_walls_on_a_soft_rig_that_hide_the_plateau_leave_the_slip_within_its_interval(noise: float) -> None:
    for contact_um, wall in ((60.0, 15.0), (60.0, 30.0), (60.0, 60.0), (1.6, 0.0)):
        loop = MasingLoop(0.6, 5.0, contact_um, 2.0, 1.5, 0.6, wall=wall)
        time, displacement, force = Disturbance(200, phase=0.3, noise=noise).of(loop)
        figures = analyse_loop(displacement, force, loop.normal_force_N, time_s=time)
        low, high = figures.slip_amplitude_um.interval95
        assert low <= 1e3 * loop.energy_mJ / (4.0 * loop.limit_N) <= high or not wall
        assert any("stiffens" in note for note in figures.notes) == (wall >= 30.0)


@pytest.mark.seconds
@pytest.mark.parametrize("noise", [0.0, 0.005, 0.02])
@pytest.mark.parametrize("friction", [0.02, 0.6, 1.5])
def test_a_rectangular_loop_fills_its_box_and_no_more(friction: float, noise: float) -> None:
    _, displacement, force = SyntheticLoop(Recipe(friction, rig_stiffness=1e9, contact_stiffness=1e6)).sampled(120, 0.1)
    for seed in range(10):
        assert_bounded(analyse_loop(*disturbed(displacement, force, seed, noise, 0.0), 2.0))


Array = np.ndarray
#: Readings that lean against the force: up to eight times what this rig yields, 12 % of its stroke; µm/N and µm/N².
LEANS = ((-0.6, 0.0), (-1.5, 0.4), (-3.2, -0.5), (-5.0, 0.0), (-5.0, 1.5))
STIFF = Recipe(rig_stiffness=5e4)


def leaning(displacement: Array, force: Array, linear: float, quadratic: float) -> Array:
    return np.asarray(displacement + linear * force + quadratic * force**2)


def parted(displacement: Array, force: Array, time: Array | None = None) -> tuple[Branch, Branch]:
    return split_branches(upright(clean_loop(displacement, force, time_s=time)))


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


OPEN = 0.03
#: Share of figures that are still out of twice their interval without a note: 28 of 7 406 of two thousand loops, 17 of
#: them coefficients of friction from energies of loops that hardly slide, and 1 of the 539 of the first 150.
LEFT = 0.005
#: What a note says of which figures; by other notes none is excused.
NOTED = {
    "stiffness is coarse": {"measured_stiffness_N_per_um"}, "samples late": {"measured_stiffness_N_per_um"},
    "passes its later peaks": {"energy_ratio"}, "the force falls again and again": {"energy_ratio"},
    "is clipped": None, "ellipse without a plateau": None, "loop is open by": None, "they were reversed": None,
}  # fmt: skip

KINDS: dict[str, Callable[[Random, int], dict[str, Any]]] = {
    "noise alone": lambda *_: {},
    "cycles": lambda random, _: {"cycles": random.uniform(0.9, 3.0)},
    "clipped": lambda random, _: {"clip": random.uniform(0.5, 1.1), "clip_one_side": random.random() < 0.5},
    "late": lambda random, samples: {"lag_samples": random.uniform(0.0, min(6.0, samples / 16))},
    "drift": lambda random, _: {"drift": random.uniform(-0.2, 0.2)},
    "ringing": lambda random, _: {
        "ringing": random.uniform(0.0, 0.8),
        "ring_period_samples": random.choice([2.0, 2.5, 5.0, 10.0]),
    },
}


def drawn_loop(random: Random) -> MasingLoop:
    """Friction from 0.001 to 1.5; the elastic travel takes up to nine tenths of the amplitude."""
    friction, load = 10.0 ** random.uniform(-3.0, 0.176), random.uniform(0.5, 20.0)
    amplitude, elastic = random.uniform(5.0, 500.0), 10.0 ** random.uniform(-2.7, -0.05)
    of_contact = random.uniform(0.02, 0.95)
    rig_um = elastic * (1.0 - of_contact) * amplitude
    return MasingLoop(
        friction=friction, normal_force_N=load, contact_um=amplitude - rig_um,
        yield_um=elastic * of_contact * amplitude, power=random.choice([1.0, 1.5, 2.0]),
        rig_N_per_um=friction * load / rig_um, play_um=random.choice([0.0, random.uniform(0.02, 0.3)]) * amplitude,
        wall=random.choice([0.0, random.uniform(0.0, 0.4)]),
    )  # fmt: skip


def drawn_disturbance(random: Random) -> Disturbance:
    samples, kind = random.randint(40, 400), random.choice(sorted(KINDS))
    return Disturbance(
        samples=samples, phase=random.random(),
        noise=random.choice([0.003, 0.01] if kind == "clipped" else [0.0, 0.003, 0.01]),
        sign=random.choice([-1.0, 1.0]), force_offset=random.uniform(-0.3, 0.3),
        displacement_offset=random.uniform(-2.0, 2.0), seed=random.randrange(10**6), **KINDS[kind](random, samples),
    )  # fmt: skip


def truths(loop: MasingLoop, disturbance: Disturbance) -> dict[str, float]:
    energy, slip = loop.energy_mJ, loop.slip_um
    found = {
        "dissipated_energy_mJ": energy,
        "slip_amplitude_um": slip,
        "friction_energy": 1e3 * energy / (4.0 * loop.normal_force_N * slip),
        "friction_geometry_independent": loop.friction,
        "measured_stiffness_N_per_um": loop.stiffness_N_per_um,
    }
    ringless = {} if disturbance.ringing else {"energy_ratio": energy / (4e-3 * loop.amplitude_um * loop.largest_N)}
    return found | ringless


def off(figure: Measured, truth: float) -> float:
    """How far a truth lies beyond a figure, in half widths of its interval, but for what definitions leave open."""
    half = max(0.5 * (figure.interval95[1] - figure.interval95[0]), 1e-12 * abs(truth))
    return max(abs(figure.value - truth) - OPEN * abs(truth), 0.0) / half


def excused(figures: LoopFigures) -> set[str]:
    said = [names for words, names in NOTED.items() if any(words in note for note in figures.notes)]
    return set(vars(figures)) if None in said else set().union(*(names for names in said if names))


def figures_of(count: int) -> Iterator[tuple[str, float, str]]:
    """Of so many loops, drawn independently of one another: each figure's name, how far its truth lies off, the loop.

    Shares are counted of them, so that no search for failing examples may choose them.
    """
    random = Random(20261126)
    for _ in range(count):
        loop, disturbance = drawn_loop(random), drawn_disturbance(random)
        time, displacement, force = disturbance.of(loop)
        try:
            figures = analyse_loop(displacement, force, loop.normal_force_N, time_s=time)
        except LoopError:
            continue
        assert disturbance.cycles < 1.5
        assert_bounded(figures)
        compared = truths(loop, disturbance)
        for name in sorted(compared.keys() - excused(figures)):
            figure = getattr(figures, name)
            if figure is not None:
                yield name, off(figure, compared[name]), f"{loop} {disturbance}"


@pytest.mark.parametrize(
    "count", [pytest.param(150, marks=pytest.mark.seconds), pytest.param(2000, marks=pytest.mark.slow)]
)
def test_figures_of_disturbed_loops_hold_the_truth_or_are_noted(count: int) -> None:
    """Nineteen in twenty within the interval, and next to none out of twice of it.

    What is left: plays of which a handful of samples show one flank, and rounds of ringing that few samples resolve.
    """
    seen = list(figures_of(count))
    assert sum(far <= 1.0 for _, far, _ in seen) > 0.95 * len(seen)
    outside = [item for item in seen if item[1] > 2.0]
    assert len(outside) <= LEFT * len(seen), "\n".join(f"{name}: {far:.1f} {what}" for name, far, what in outside)


@pytest.mark.parametrize(
    ("value", "half", "shown"),
    [(0.6, 1e-12, ("0.6", "1e-12")), (52.8123, 0.02, ("52.81", "0.02")), (3e-14, 1e-15, ("0", "1e-15"))],
)
def test_no_more_digits_are_shown_than_mean_something(value: float, half: float, shown: tuple[str, str]) -> None:
    assert rounded(Measured(value, (value - half, value + half))) == shown
