"""Loops of all kinds of disturbance, with truths in closed form: figures are bounded, and hold the truth or are noted.

A clipped loop has noise: without any, a clipped plateau is the flat one of less friction. With ringing, the largest
force is the ringing's own. A 95 % interval misses one truth in twenty, so that of all figures of a loop next to none is
off by more than twice its interval, and nineteen in twenty by no more than it; 3 % beside stand for what the figures'
definitions leave open.
"""

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.closed_form_loops import Disturbance, MasingLoop
from tests.test_loops_bounds import assert_bounded
from wirewear.loops import LoopError, LoopFigures, Measured, analyse_loop

OPEN = 0.03

#: Share of figures that are still out of twice their interval without a note: 11 of 6 200 of two thousand loops, and 2
#: of the 450 of the first 150.
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

KINDS: dict[str, Callable[[int], Any]] = {
    "noise alone": lambda _: st.just({}),
    "cycles": lambda _: st.fixed_dictionaries({"cycles": st.floats(0.9, 3.0)}),
    "clipped": lambda _: st.fixed_dictionaries({"clip": st.floats(0.5, 1.1), "clip_one_side": st.booleans()}),
    "late": lambda samples: st.fixed_dictionaries({"lag_samples": st.floats(0.0, min(6.0, samples / 16))}),
    "drift": lambda _: st.fixed_dictionaries({"drift": st.floats(-0.2, 0.2)}),
    "ringing": lambda _: st.fixed_dictionaries(
        {"ringing": st.floats(0.0, 0.8), "ring_period_samples": st.sampled_from([2.0, 2.5, 5.0, 10.0])}
    ),
}


@st.composite
def loops(draw: st.DrawFn) -> MasingLoop:
    """Friction from 0.001 to 1.5; the elastic travel takes up to nine tenths of the amplitude."""
    friction, load = 10.0 ** draw(st.floats(-3.0, 0.176)), draw(st.floats(0.5, 20.0))
    amplitude, elastic = draw(st.floats(5.0, 500.0)), 10.0 ** draw(st.floats(-2.7, -0.05))
    of_contact = draw(st.floats(0.02, 0.95))
    rig_um = elastic * (1.0 - of_contact) * amplitude
    return MasingLoop(
        friction=friction,
        normal_force_N=load,
        contact_um=amplitude - rig_um,
        yield_um=elastic * of_contact * amplitude,
        power=draw(st.sampled_from([1.0, 1.5, 2.0])),
        rig_N_per_um=friction * load / rig_um,
        play_um=draw(st.one_of(st.just(0.0), st.floats(0.02, 0.3))) * amplitude,
        wall=draw(st.one_of(st.just(0.0), st.floats(0.0, 0.4))),
    )


@st.composite
def disturbances(draw: st.DrawFn) -> Disturbance:
    samples, kind = draw(st.integers(40, 400)), draw(st.sampled_from(sorted(KINDS)))
    noises = [0.003, 0.01] if kind == "clipped" else [0.0, 0.003, 0.01]
    return Disturbance(
        samples=samples,
        phase=draw(st.floats(0.0, 1.0)),
        noise=draw(st.sampled_from(noises)),
        sign=draw(st.sampled_from([-1.0, 1.0])),
        force_offset=draw(st.floats(-0.3, 0.3)),
        displacement_offset=draw(st.floats(-2.0, 2.0)),
        seed=draw(st.integers(0, 10**6)),
        **draw(KINDS[kind](samples)),
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


def check(examples: int, seen: list[tuple[str, float, str]]) -> None:
    @settings(max_examples=examples, derandomize=True, database=None, suppress_health_check=list(HealthCheck))
    @given(loops(), disturbances())
    def each(loop: MasingLoop, disturbance: Disturbance) -> None:
        time, displacement, force = disturbance.of(loop)
        try:
            figures = analyse_loop(displacement, force, loop.normal_force_N, time_s=time)
        except LoopError:
            return
        assert disturbance.cycles < 1.5
        assert_bounded(figures)
        compared = truths(loop, disturbance)
        for name in sorted(compared.keys() - excused(figures)):
            figure = getattr(figures, name)
            if figure is not None:
                seen.append((name, off(figure, compared[name]), f"{loop} {disturbance}"))

    each()


def assert_held(seen: list[tuple[str, float, str]]) -> None:
    """Nineteen in twenty within the interval, and next to none out of twice of it.

    What is left: plays of which a handful of samples tell one flank, and rounds of ringing that few samples resolve.
    """
    assert sum(far <= 1.0 for _, far, _ in seen) > 0.95 * len(seen)
    outside = [item for item in seen if item[1] > 2.0]
    assert len(outside) <= LEFT * len(seen), "\n".join(f"{name}: {far:.1f} {what}" for name, far, what in outside)


def test_figures_of_disturbed_loops_hold_the_truth_or_are_noted() -> None:
    seen: list[tuple[str, float, str]] = []
    check(150, seen)
    assert_held(seen)


@pytest.mark.slow
def test_figures_of_two_thousand_disturbed_loops_hold_the_truth_or_are_noted() -> None:
    seen: list[tuple[str, float, str]] = []
    check(2000, seen)
    assert_held(seen)
