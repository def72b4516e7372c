"""A cycle's two strokes one by one: how far each has come, and what a holder in series makes of its forces."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from studies.blind.generators.signals import FINER, Array, Signals

#: What a holder gives way by [µm] at displacements [µm] and tangential forces (n,) of a stroke in a direction, ±1.
Give = Callable[[Array, Array, int], Array]


def since_reversal(signals: Signals) -> tuple[Array, Array]:
    """Way since the last reversal [µm], and direction of motion, ±1: (n,) each."""
    read = signals.displacement_um
    top, low = float(signals.time_s[read.argmax()]), float(signals.time_s[read.argmin()])
    falling = (signals.time_s - top) % signals.period_s < (low - top) % signals.period_s
    passed = np.where(falling, read.max() - read, read - read.min())
    return np.asarray(passed), np.where(falling, -1.0, 1.0)


def through_holder(signals: Signals, give: Give) -> Signals:
    """The channels of a drive that holds its stroke while the holder in series gives way.

    A stroke's forces come later by what the holder has given since the reversal. The contact's own stroke is shorter.
    """
    tangential, normal = signals.tangential_force_N.copy(), signals.normal_force_N.copy()
    for direction in (1, -1):
        rows = _rows_of_stroke(signals.displacement_um, direction)
        fine = np.linspace(0.0, rows.size - 1.0, FINER * (rows.size - 1) + 1)
        place, force, load = (
            np.interp(fine, np.arange(rows.size), channel[rows])
            for channel in (signals.displacement_um, signals.tangential_force_N, signals.normal_force_N)
        )
        driven = direction * (place + give(place, force, direction))
        way = np.maximum.accumulate(driven - driven[0])
        asked = direction * (signals.displacement_um[rows] - place[0])
        way *= float(asked[-1] / way[-1])
        tangential[rows], normal[rows] = np.interp(asked, way, force), np.interp(asked, way, load)
    return replace(signals, tangential_force_N=tangential, normal_force_N=normal)


def _rows_of_stroke(displacement: Array, direction: int) -> NDArray[np.intp]:
    """Rows of a periodic channel from one reversal to the next, both included."""
    low, top = displacement.argmin(), displacement.argmax()
    first, ended = (low, top) if direction > 0 else (top, low)
    count = displacement.size
    return np.asarray((first + np.arange((ended - first) % count + 1)) % count)
