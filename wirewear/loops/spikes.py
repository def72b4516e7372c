"""Spikes of coarse loops, told by the other loops of a test.

In a dense loop a spike stands out of its neighbours. Where a stick branch is a handful of samples, a spike there, or
at the knee, may lie between its neighbours; but what a sample is off the curve through these is alike in all loops.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from wirewear.loops.noise import NEIGHBOURS, through_neighbours
from wirewear.loops.robust import Array

#: A spike lies so many of the usual deviations off; these are at least this share of the channel's extent, and more
#: than round-off where it never changes.
OUTLYING, LEAST_DEVIATION, ROUND_OFF = 8.0, 1e-3, 1e-9

#: How far a sample is off may change from loop to loop by this share of what is usual there.
BENT = 0.1


def spikes(loops: Array) -> NDArray[np.bool_]:
    """Which samples of periodic loops (m, n) at equal times are off their neighbours as those of no other loop are.

    One by one, as a spike draws the curve through its neighbours.
    """
    values = loops.copy()
    found = np.zeros(values.shape, dtype=bool)
    typical = np.median(values, axis=0)
    least = LEAST_DEVIATION * float(np.ptp(typical)) + ROUND_OFF * max(float(np.abs(typical).max()), 1.0)
    for _ in range(max(values.shape[1] // 10, 1)):
        off = values - through_neighbours(values)
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
        rows, near = rows[spiky], (worst[spiky, None] + np.array([0, *NEIGHBOURS])) % values.shape[1]
        worst = near[np.arange(rows.size), away[rows[:, None], near].argmax(axis=1)]
        found[rows, worst] = True
        values[rows, worst] += usual[worst] - off[rows, worst]
    return found
