"""A running test: what each loop so far shows, and what is dissipated and worn by then."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import nan

import numpy as np

from geometry.arrays import Array
from wirewear.loops import LoopError
from wirewear.records import AnyRecord
from wirewear.records.evolution_checks import energy_so_far_J
from wirewear.records.values import MeasuredLoop


@dataclass(frozen=True)
class FollowedLoop:
    """Figures of one loop of a running test.

    clock: local date and time at which it was first seen. friction: coefficient by geometry, NaN where the loop does
    not slide or no load is known. force_ratio: largest Q/P. refused: why the loop cannot be analysed; "" if it can.
    """

    repeat: int
    cycle: int
    time_s: float
    clock: str
    regime: str = ""
    friction: float = nan
    force_ratio: float = nan
    slip_amplitude_um: float = nan
    dissipated_energy_mJ: float = nan
    refused: str = ""


def followed_loop(loop: MeasuredLoop, load_N: float | None, frequency_Hz: float, clock: str) -> FollowedLoop:
    """The figures of a loop. load_N: stands in for a normal force that was not measured."""
    known = loop.repeat, loop.cycle, loop.cycle / frequency_Hz, clock
    try:
        found = loop.figures(load_N)
    except LoopError as refusal:
        return FollowedLoop(*known, refused=str(refusal))
    friction, largest = (
        nan if one is None else one.value for one in (found.friction_geometry_independent, found.friction_max)
    )
    return FollowedLoop(
        *known, found.regime, friction, largest, found.slip_amplitude_um.value, found.dissipated_energy_mJ.value
    )


def energies_J(record: AnyRecord, loops: Sequence[FollowedLoop]) -> Array:
    """Friction energy (n,) in J that each of n loops' repeat has dissipated by then; NaN before the first loop with an
    energy.
    """
    found = np.full(len(loops), nan)
    for repeat in {one.repeat for one in loops}:
        own = [place for place, one in enumerate(loops) if one.repeat == repeat and one.dissipated_energy_mJ > 0.0]
        own = [place for place in own if loops[place].cycle > 0]
        if own:
            cycles = np.array([float(loops[place].cycle) for place in own])
            found[own] = energy_so_far_J(record, cycles, np.array([loops[place].dissipated_energy_mJ for place in own]))
    return found
