"""Friction energy of a whole test, summed over its cycles from what was logged."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from wirewear.base.course import enclosed_energy
from wirewear.loops import LoopError
from wirewear.records.remarks import LoggedTest

Array = NDArray[np.float64]


def accumulated_energy_J(record: LoggedTest, repeat: int) -> float | None:
    """ΣE_d of one test, from its evolution, or from its loops' areas; None where neither has an energy.

    Between two logged cycles the energy per cycle is a power of the cycles; before the first and after the last it
    stays.
    """
    cycles, energies = energy_per_cycle(record, repeat)
    if not cycles.size:
        return None
    end = float(max(record.tables.conditions.cycles, cycles[-1]))
    steps = enclosed_energy(np.append(cycles, end), np.append(energies, energies[-1]))
    return 1e-3 * (float(energies[0] * cycles[0]) + steps)


def energy_per_cycle(record: LoggedTest, repeat: int) -> tuple[Array, Array]:
    """Cycles (n,), increasing, and their energies in mJ; of the evolution, or where it has none of the loops."""
    for part in record.evolution:
        cycle, energy = part.columns["cycle"], part.columns["dissipated_energy_mJ"]
        known = np.isfinite(energy) & (energy > 0.0) & (cycle > 0)
        if part.repeat == repeat and known.any():
            return cycle[known], energy[known]
    rows = []
    for loop in record.loops:
        if loop.repeat == repeat and loop.cycle > 0:
            try:
                rows.append((float(loop.cycle), loop.figures(None).dissipated_energy_mJ.value))
            except LoopError:
                continue
    found = np.array(rows).reshape(-1, 2)
    return found[:, 0], found[:, 1]
