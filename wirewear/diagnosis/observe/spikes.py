"""Spikes of coarse loops left out, as the other loops of the record tell them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from wirewear.diagnosis.calibration import constants
from wirewear.loops.noise import spikes
from wirewear.records import AnyRecord, MeasuredLoop
from wirewear.records.loop_statistics import of_equal_times

_KNOWN = constants("observe.spikes")

#: Loops of more samples do without: their readings are local fits that leave spikes out.
FEWEST_SAMPLES, MOST_SAMPLES = _KNOWN.count("fewest_samples"), _KNOWN.count("most_samples")

#: Loops of equal times that must be there to say what is usual.
FEWEST_LOOPS = _KNOWN.count("fewest_loops")


def without_spikes(record: AnyRecord) -> AnyRecord:
    """The record without the samples of coarse loops that are spikes in any channel: NaN."""
    spiky: dict[int, MeasuredLoop] = {}
    for group in of_equal_times([loop for loop in record.loops if loop.cycle > 0]):
        if len(group) < FEWEST_LOOPS or not FEWEST_SAMPLES <= group[0].time_s.size <= MOST_SAMPLES:
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
