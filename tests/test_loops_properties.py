"""Loops of all kinds of disturbance, with truths in closed form: figures are bounded, and hold the truth or are noted.

A clipped loop has noise: without any, a clipped plateau is the flat one of less friction. With ringing, the largest
force is the ringing's own. A 95 % interval misses one truth in twenty, so that of all figures of a loop next to none is
off by more than twice its interval, and nineteen in twenty by no more than it; 3 % beside stand for what the figures'
definitions leave open.
"""

from collections.abc import Callable, Iterator
from random import Random
from typing import Any

import pytest

from tests.synthetic_loops import Disturbance, MasingLoop
from tests.test_loops_bounds import assert_bounded
from wirewear.loops import LoopError, LoopFigures, Measured, analyse_loop

OPEN = 0.03

#: Share of figures that are still out of twice their interval without a note: 28 of 7 406 of two thousand loops, 17 of
#: them coefficients of friction from energies of loops that hardly slide, and 1 of the 539 of the first 150.
LEFT = 0.005

#: What a note says of which figures; by other notes none is excused.
NOTED = {
    "stiffness is coarse": {"measured_stiffness_N_per_um"},
    "samples late": {"measured_stiffness_N_per_um"},
    "passes its later peaks": {"energy_ratio"},
    "the force falls again and again": {"energy_ratio"},
    "is clipped": None,
    "ellipse without a plateau": None,
    "loop is open by": None,
    "they were reversed": None,
}

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
        friction=friction,
        normal_force_N=load,
        contact_um=amplitude - rig_um,
        yield_um=elastic * of_contact * amplitude,
        power=random.choice([1.0, 1.5, 2.0]),
        rig_N_per_um=friction * load / rig_um,
        play_um=random.choice([0.0, random.uniform(0.02, 0.3)]) * amplitude,
        wall=random.choice([0.0, random.uniform(0.0, 0.4)]),
    )


def drawn_disturbance(random: Random) -> Disturbance:
    samples, kind = random.randint(40, 400), random.choice(sorted(KINDS))
    return Disturbance(
        samples=samples,
        phase=random.random(),
        noise=random.choice([0.003, 0.01] if kind == "clipped" else [0.0, 0.003, 0.01]),
        sign=random.choice([-1.0, 1.0]),
        force_offset=random.uniform(-0.3, 0.3),
        displacement_offset=random.uniform(-2.0, 2.0),
        seed=random.randrange(10**6),
        **KINDS[kind](random, samples),
    )


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


def assert_held(seen: list[tuple[str, float, str]]) -> None:
    """Nineteen in twenty within the interval, and next to none out of twice of it.

    What is left: plays of which a handful of samples tell one flank, and rounds of ringing that few samples resolve.
    """
    assert sum(far <= 1.0 for _, far, _ in seen) > 0.95 * len(seen)
    outside = [item for item in seen if item[1] > 2.0]
    assert len(outside) <= LEFT * len(seen), "\n".join(f"{name}: {far:.1f} {what}" for name, far, what in outside)


def test_figures_of_disturbed_loops_hold_the_truth_or_are_noted() -> None:
    assert_held(list(figures_of(150)))


@pytest.mark.slow
def test_figures_of_two_thousand_disturbed_loops_hold_the_truth_or_are_noted() -> None:
    assert_held(list(figures_of(2000)))
