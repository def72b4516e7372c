"""From the loops of a finite element run to noise-free readings at any cycle, timed by the rig's waveform.

Loops are read at their increments and nowhere between: a straight line from increment to increment cuts the corners of
a loop, which a logger of more samples would have seen. So these rigs sample by place, as one whose encoder triggers it.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from studies.blind.generators.cases import TrueEffect
from studies.blind.generators.finite_element.changes import instruments_of
from studies.blind.generators.nominal import Nominal
from studies.blind.generators.nuisances import Nuisances, SpecimenDraw
from studies.blind.generators.sampling import Channels
from studies.blind.generators.signals import Signals, read_by
from wirewear.effects import Age, Effect, Seam, applied
from wirewear.loops import LoopSignals, Sensor
from wirewear.results import Loop

Array = NDArray[np.float64]


def moments(loop: Loop, shape: Array) -> Array:
    """Shares of a cycle after which another waveform comes by the places of a loop that starts at mid-stroke (n,).

    Without inertia, forces follow from place and direction, whenever a place is reached. `shape` (m,) lies between −1
    and 1 at even times, starts at mid-stroke and turns once at each.
    """
    place = loop.displacement_um / np.abs(loop.displacement_um).max()
    top, low = int(place.argmax()), int(place.argmin())
    turn, back = int(shape.argmax()), int(shape.argmin())
    even = np.arange(shape.size + 1) / shape.size
    closed = np.append(shape, shape[0])
    return np.concatenate(
        [
            np.interp(place[: top + 1], closed[: turn + 1], even[: turn + 1]),
            np.interp(-place[top + 1 : low + 1], -closed[turn : back + 1], even[turn : back + 1]),
            np.interp(place[low + 1 :], closed[back:], even[back:]),
        ]
    )


def channels_of(loop: Loop) -> Channels:
    """What there is to be measured of a loop, at its increments."""
    return loop.displacement_um, loop.tangential_force_N, loop.normal_force_N


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
    time_s: Array,
) -> Iterator[tuple[int, Channels]]:
    """Noise-free readings at every cycle of which anything is recorded, at the times of the loops' increments (n,)."""
    true = [(loop.cycle, channels_of(loop)) for loop in loops]
    period = 1.0 / nominal.frequency_Hz
    instruments = instruments_of(effects, nominal)
    for cycle in nuisances.all_cycles:
        displacement, force, normal = between(true, cycle)
        if instruments:
            changed = read_by(instruments, Signals(time_s, period, displacement, force, normal), cycle)
            displacement, force, normal = (changed.displacement_um, changed.tangential_force_N, changed.normal_force_N)
        sensor = applied(changes, Seam.SENSOR, Sensor(), Age(float(cycle), 0.0))
        read = sensor.read(LoopSignals(time_s, displacement, force, normal, period))
        load = normal if read.normal_force_N is None else read.normal_force_N
        yield (
            cycle,
            (read.displacement_um + draw.displacement_zero_um, read.tangential_force_N + draw.force_zero_N, load),
        )
