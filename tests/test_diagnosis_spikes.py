"""Spikes of coarse loops that lie between their neighbours, told by the other loops."""

from dataclasses import replace

import numpy as np
import pytest

from tests.diagnosis_cases import record
from wirewear.diagnosis.observe.spikes import without_spikes
from wirewear.loops.spikes import spikes
from wirewear.records import ExperimentRecord, MeasuredLoop
from wirewear.records.loop_groups import of_equal_times


def spoiled(made: ExperimentRecord, place: int, sample: int, **shift: float) -> ExperimentRecord:
    """The record with one sample of one loop off."""
    loops = list(made.loops)
    for name, off in shift.items():
        values = getattr(loops[place], name).copy()
        values[sample] += off
        loops[place] = replace(loops[place], **{name: values})
    return replace(made, loops=tuple(loops))


def left_out(made: ExperimentRecord) -> dict[int, list[int]]:
    """Samples left out of each loop."""
    found = {place: np.flatnonzero(np.isnan(loop.displacement_um)) for place, loop in enumerate(made.loops)}
    return {place: bad.tolist() for place, bad in found.items() if bad.size}


def alike(samples: int) -> ExperimentRecord:
    """Twelve loops of one recorder that starts all of them at the same place of the stroke."""
    made = record(samples=4096, repeats=3)
    loops = []
    for loop in made.loops:
        rising = np.roll(loop.displacement_um, -256) > 0.0
        start = int(np.argmin(np.abs(loop.displacement_um) + np.where(rising, 0.0, 1e3)))
        at = (start + np.arange(samples) * 4096 // samples) % 4096
        loops.append(
            replace(
                loop,
                time_s=np.arange(samples) / (3.0 * samples),
                displacement_um=loop.displacement_um[at],
                tangential_force_N=loop.tangential_force_N[at],
                normal_force_N=None if loop.normal_force_N is None else loop.normal_force_N[at],
            )
        )
    return replace(made, loops=tuple(loops))


@pytest.mark.parametrize("samples", [40, 96])
def test_a_spike_is_left_out_wherever_it_lies_and_nothing_else(samples: int) -> None:
    made = alike(samples)
    assert left_out(without_spikes(made)) == {}
    for sample in range(0, samples, 5):
        assert left_out(without_spikes(spoiled(made, 4, sample, displacement_um=9.0))) == {4: [sample]}
        assert left_out(without_spikes(spoiled(made, 4, sample, normal_force_N=-0.2))) == {4: [sample]}
    flat = samples // 8
    assert left_out(without_spikes(spoiled(made, 4, flat, tangential_force_N=-0.2))) == {4: [flat]}


def test_what_all_loops_show_is_no_spike() -> None:
    made = alike(40)
    shown = made
    for place in range(len(made.loops)):
        shown = spoiled(shown, place, 7, tangential_force_N=0.3)
    assert left_out(without_spikes(shown)) == {}


def test_dense_loops_few_loops_and_loops_of_unlike_times_are_left_alone() -> None:
    dense = spoiled(alike(200), 4, 50, displacement_um=9.0)
    assert without_spikes(dense) is dense
    few = spoiled(alike(40), 1, 7, displacement_um=9.0)
    few = replace(few, loops=few.loops[:3])
    assert without_spikes(few) is few
    unlike = spoiled(alike(40), 4, 7, displacement_um=9.0)
    loops = [replace(loop, time_s=loop.time_s * (1.0 + 0.01 * place)) for place, loop in enumerate(unlike.loops)]
    assert left_out(without_spikes(replace(unlike, loops=tuple(loops)))) == {}


def test_several_spikes_of_a_loop_are_found_one_by_one() -> None:
    random = np.random.default_rng(2)
    loops = np.sin(2.0 * np.pi * np.arange(64) / 64) + 0.003 * random.standard_normal((9, 64))
    loops[3, [10, 12, 40]] += (0.3, -0.2, 0.1)
    assert np.argwhere(spikes(loops)).tolist() == [[3, 10], [3, 12], [3, 40]]


def test_loops_are_grouped_by_their_times() -> None:
    def loop(count: int, missing: bool = False) -> MeasuredLoop:
        values = np.arange(count, dtype=float)
        force = np.where(values == 3.0, np.nan, values) if missing else values
        return MeasuredLoop(1, 1, values, values, force, None)

    groups = of_equal_times([loop(20), loop(30), loop(30), loop(30, missing=True), loop(20), loop(30)])
    assert [[one.time_s.size for one in group] for group in groups] == [[30, 30, 30], [20, 20]]
    assert of_equal_times([]) == []


def test_a_channel_that_never_changes_but_for_round_off_has_no_spikes() -> None:
    random = np.random.default_rng(4)
    still = np.full((6, 40), 2.0)
    assert not spikes(still).any()
    assert not spikes(still + 4e-16 * random.integers(0, 2, still.shape)).any()
    assert not spikes(np.zeros((6, 40))).any()
