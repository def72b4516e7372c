"""Jumps of a contact whose sticking core shrinks: judged by the cycle after them, they wear as many short ones do."""

from dataclasses import replace

import pytest
from threadpoolctl import threadpool_limits

from solvers import ContactProblem, JumpController, RoughLayer
from solvers.contact import unloaded_state
from tests.bodies import crossed_wires
from tests.wear_jumps import INCREMENTS, RATES, at_the_end
from wirewear.effects import Age
from wirewear.simulation import cycler
from wirewear.simulation.cycler import Cycler, Motion
from wirewear.simulation.cycling import WholeCycles
from wirewear.simulation.tally import Tally

RIG_N_per_mm = 20.0
STROKE_mm = 0.045
LAYER_mm = 1e-3
WEARS_IN_cycles = 1e3
CYCLES = 3e3
MILESTONES = (10.0, 100.0, 1000.0)


def rough(bare: ContactProblem, age: Age) -> ContactProblem:
    """The wires with a layer that wears in, which leaves the load to an ever smaller contact."""
    return replace(bare, layers=(RoughLayer(LAYER_mm).worn_in(age.cycles, WEARS_IN_cycles),))


def course(largest_share: float, cycles: float = CYCLES, *, resumed: bool = False) -> tuple[float, float, float]:
    """Energy (mJ) that has worn after all cycles, how many were traced, and which share of the core still sticks.

    A run that is `resumed` after every jump knows nothing of a cycle traced before.
    """
    bare = crossed_wires(0.005, rig_N_per_mm=RIG_N_per_mm, wear=RATES)
    motion, tally = Motion(STROKE_mm, INCREMENTS, INCREMENTS, False, unloaded_state, rough), Tally()

    def begun() -> WholeCycles:
        return WholeCycles(Cycler(motion, tally, lambda *_: None), JumpController(0.1, largest_share=largest_share))

    jumps = begun()
    state = at_the_end(rough(bare, Age(0.0, 0.0)), STROKE_mm)
    sticking, done, wanted = state.core.sum(), 1.0, jumps.first_jump
    with threadpool_limits(1, user_api="blas"):
        while done < cycles:
            step = jumps.step(bare, state, done, wanted, MILESTONES, cycles)
            state, wanted, done = step.state, step.next_jump, done + step.jump
            jumps = begun() if resumed else jumps
    return state.wear.energy_mJ, tally.counters.simulated_cycles, float(state.core.sum() / sticking)


@pytest.mark.slow
def test_a_core_that_shrinks_wears_by_few_judged_jumps_as_by_many_short_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    short, many, left = course(0.15)
    judged, few, _ = course(1.0)
    monkeypatch.setattr(cycler, "change_by_work", lambda *_: 0.0)
    unjudged, _, _ = course(1.0)
    assert left < 0.5
    assert few < 0.75 * many
    assert judged == pytest.approx(short, rel=0.03)
    assert unjudged < 0.9 * short


@pytest.mark.slow
def test_a_run_resumed_after_every_jump_wears_as_much_and_counts_as_many_cycles() -> None:
    at_once, traced, _ = course(1.0, 100.0)
    resumed, again, _ = course(1.0, 100.0, resumed=True)
    assert resumed == pytest.approx(at_once, rel=1e-6)
    assert again == traced
