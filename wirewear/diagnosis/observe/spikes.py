"""Spikes of coarse loops, told by the other loops of the record.

In a dense loop a spike stands out of its neighbours. Where a stick branch is a handful of samples, a spike there, or
at the knee, may lie between its neighbours; but what a sample is off the curve through these is alike in all loops.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from wirewear.diagnosis.model.setup import Array
from wirewear.records import ExperimentRecord, MeasuredLoop
from wirewear.records.loop_groups import of_equal_times

#: Loops of more samples do without: their readings are local fits that leave spikes out.
MOST_SAMPLES = 128

#: Loops of equal times that must be there to say what is usual.
FEWEST_LOOPS = 4

#: A spike lies so many of the usual deviations off; these are at least this share of the channel's extent, and more
#: than round-off where it never changes.
OUTLYING, LEAST_DEVIATION, ROUND_OFF = 8.0, 1e-3, 1e-9

#: How far a sample is off may change from loop to loop by this share of what is usual there.
BENT = 0.1

#: The cubic through two neighbours on either side, at even times.
_NEIGHBOURS, _WEIGHTS = (-2, -1, 1, 2), (-1.0 / 6.0, 4.0 / 6.0, 4.0 / 6.0, -1.0 / 6.0)


def without_spikes(record: ExperimentRecord) -> ExperimentRecord:
    """The record without the samples of coarse loops that are spikes in any channel: NaN."""
    spiky: dict[int, MeasuredLoop] = {}
    for group in of_equal_times([loop for loop in record.loops if loop.cycle > 0]):
        if len(group) < FEWEST_LOOPS or not 8 <= group[0].time_s.size <= MOST_SAMPLES:
            continue
        channels = [[loop.displacement_um for loop in group], [loop.tangential_force_N for loop in group]]
        normal = [loop.normal_force_N for loop in group if loop.normal_force_N is not None]
        if len(normal) == len(group):
            channels.append(normal)
        found = np.logical_or.reduce([spikes(np.stack(channel)) for channel in channels])
        for loop, bad in zip(group, found, strict=True):
            if bad.any():
                spiky[id(loop)] = replace(loop, displacement_um=np.where(bad, np.nan, loop.displacement_um))
    return replace(record, loops=tuple(spiky.get(id(loop), loop) for loop in record.loops)) if spiky else record


def spikes(loops: Array) -> NDArray[np.bool_]:
    """Which samples of periodic loops (m, n) at equal times are off their neighbours as those of no other loop are.

    One by one, as a spike draws the curve through its neighbours.
    """
    values = loops.copy()
    found = np.zeros(values.shape, dtype=bool)
    typical = np.median(values, axis=0)
    least = LEAST_DEVIATION * float(np.ptp(typical)) + ROUND_OFF * max(float(np.abs(typical).max()), 1.0)
    for _ in range(max(values.shape[1] // 10, 1)):
        off = values - _through_neighbours(values)
        usual = np.median(off, axis=0)
        away = np.abs(off - usual)
        deviation = 1.4826 * np.median(away, axis=0)
        # Of few loops a deviation may be small by chance, and a knee that moves with the wear bends another sample.
        bent = np.max([np.roll(np.abs(usual), shift) for shift in (-1, 0, 1)], axis=0)
        deviation = np.max(
            [deviation, np.full_like(bent, max(float(np.median(deviation)), least)), BENT * bent], axis=0
        )
        excess = away / deviation
        rows, worst = np.arange(len(values)), excess.argmax(axis=1)
        spiky = excess[rows, worst] > OUTLYING
        if not spiky.any():
            break
        # The curves through its neighbours are drawn off too, by less.
        rows, near = rows[spiky], (worst[spiky, None] + np.array([0, *_NEIGHBOURS])) % values.shape[1]
        worst = near[np.arange(rows.size), away[rows[:, None], near].argmax(axis=1)]
        found[rows, worst] = True
        values[rows, worst] += usual[worst] - off[rows, worst]
    return found


def _through_neighbours(values: Array) -> Array:
    parts = [weight * np.roll(values, -shift, axis=1) for shift, weight in zip(_NEIGHBOURS, _WEIGHTS, strict=True)]
    return np.asarray(np.sum(parts, axis=0))
