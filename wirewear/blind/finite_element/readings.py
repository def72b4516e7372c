"""From the loops of a finite element run to noise-free readings at any cycle, on the rig's waveform."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from wirewear.blind.cases import TrueEffect
from wirewear.blind.finite_element.changes import SATURATION
from wirewear.blind.nominal import Nominal
from wirewear.blind.nuisances import Nuisances, SpecimenDraw
from wirewear.blind.sampling import Channels
from wirewear.blind.waveform import SAMPLES
from wirewear.effects import Age, Effect, Seam, applied
from wirewear.results import Loop
from wirewear.sensor import LoopSignals, Sensor

Array = NDArray[np.float64]


def retimed(loop: Loop, shape: Array) -> Channels:
    """A loop gone through in the time of another waveform: without inertia, forces follow from place and direction.

    `shape` (n,) lies between −1 and 1 and turns once at each.
    """
    place = loop.displacement_um
    top, low, count = int(place.argmax()), int(place.argmin()), place.size
    rising = (low + np.arange((top - low) % count + 1)) % count
    falling = (top + np.arange((low - top) % count + 1))[::-1] % count
    wanted = np.interp(shape, (-1.0, 1.0), (place[low], place[top]))
    at = np.arange(shape.size)
    back = (at - int(shape.argmax())) % shape.size <= (int(shape.argmin()) - int(shape.argmax())) % shape.size
    forces = [
        np.where(back, np.interp(wanted, place[falling], q[falling]), np.interp(wanted, place[rising], q[rising]))
        for q in (loop.tangential_force_N, loop.normal_force_N)
    ]
    return wanted, forces[0], forces[1]


def between(loops: Sequence[tuple[int, Channels]], cycle: int) -> Channels:
    """The channels at a cycle, interpolated in its logarithm between those of logged loops."""
    cycles = np.array([number for number, _ in loops], dtype=float)
    after = int(np.clip(np.searchsorted(cycles, cycle), 1, len(loops) - 1))
    low, high = cycles[after - 1], cycles[after]
    share = float(np.clip(np.log(cycle / low) / np.log(high / low), 0.0, 1.0))
    before, then = loops[after - 1][1], loops[after][1]
    first, second, third = ((1.0 - share) * one + share * other for one, other in zip(before, then, strict=True))
    return first, second, third


def read_test(
    loops: Sequence[Loop],
    changes: Sequence[Effect[object]],
    effects: Sequence[TrueEffect],
    nominal: Nominal,
    nuisances: Nuisances,
    draw: SpecimenDraw,
) -> Iterator[tuple[int, Channels]]:
    """Noise-free readings at every cycle of which anything is recorded."""
    shape = nuisances.waveform.shape()
    true = [(loop.cycle, retimed(loop, shape)) for loop in loops]
    period = 1.0 / nominal.frequency_Hz
    time = period * np.arange(SAMPLES) / SAMPLES
    cubic = _saturation_per_N2(effects, nominal)
    for cycle in nuisances.all_cycles:
        displacement, force, normal = between(true, cycle)
        sensor = applied(changes, Seam.SENSOR, Sensor(), Age(float(cycle), 0.0))
        read = sensor.read(LoopSignals(time, displacement, force, normal, period))
        load = normal if read.normal_force_N is None else read.normal_force_N
        yield (
            cycle,
            (
                read.displacement_um + draw.displacement_zero_um,
                read.tangential_force_N - cubic * force**3 + draw.force_zero_N,
                load,
            ),
        )


def _saturation_per_N2(effects: Sequence[TrueEffect], nominal: Nominal) -> float:
    """Of a force cell that reads ever less than it bears: Q' = Q − s Q³."""
    lost = sum(true.parameters["loss_at_plateau"] for true in effects if true.effect == SATURATION)
    return lost / (nominal.friction * nominal.load_N) ** 2
