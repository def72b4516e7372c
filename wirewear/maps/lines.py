"""Tests for maps from records and results of line contacts: per millimetre, so that contacts of all lengths compare.

The lines at which contacts slide and crack are left out: how far a line contact gives way depends on its bodies' size,
and no closed form has it.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from wirewear.line_records.exporting import measured_loop
from wirewear.line_records.values import BODIES
from wirewear.loops import LoopError, LoopFigures
from wirewear.maps.values import MappedTest, WornTest
from wirewear.planar.readings import read_planar_loops
from wirewear.records.energies import accumulated_energy_J

if TYPE_CHECKING:
    from wirewear.line_records import LineRecord
    from wirewear.planar.results import PlanarResult
    from wirewear.records.values import MeasuredLoop

Read = tuple[MappedTest, list[tuple[int, LoopFigures]]]


def of_line_record(record: LineRecord, path: Path) -> Read:
    """A measured test, and the figures of its loops by cycle."""
    asked, length = record.tables.conditions, record.tables.contact.length_mm
    loads = [float(np.nanmedian(one.normal_force_N)) for one in record.loops if one.normal_force_N is not None]
    load = float(np.mean(loads)) if loads else asked.normal_load_N
    areas = [{one.repeat: one.area_um2 for one in record.profiles_of(body)} for body in BODIES]
    worn = tuple(
        WornTest(energy / length, 1e-6 * (areas[0][repeat] + areas[1][repeat]))
        for repeat in sorted(set(areas[0]) & set(areas[1]))
        if (energy := accumulated_energy_J(record, repeat)) is not None
    )
    test = MappedTest(
        name=record.name,
        source=record.tables.metadata.source or "record",
        path=str(path),
        normal_load_N=load / length,
        displacement_amplitude_um=asked.displacement_amplitude_um,
        worn=worn,
        cracks=record.tables.metadata.cracks,
        per_mm=True,
    )
    return test, _figures(record.loops, asked.normal_load_N)


def of_line_result(result: PlanarResult, path: Path) -> Read:
    """A simulated test, and the figures of its loops by cycle."""
    evolution, asked = result.evolution, result.study["conditions"]
    worn: tuple[WornTest, ...] = ()
    if evolution["cycle"].size:
        area = sum(float(evolution[f"{body}_worn_area_um2"][-1]) for body in BODIES)
        worn = (WornTest(float(evolution["accumulated_energy_J_per_mm"][-1]), 1e-6 * area),) if area > 0.0 else ()
    load = float(asked["normal_load_N_per_mm"])
    test = MappedTest(
        name=result.label,
        source="simulated",
        path=str(path),
        normal_load_N=load,
        displacement_amplitude_um=float(asked["displacement_amplitude_um"]),
        worn=worn,
        per_mm=True,
    )
    return test, _figures([measured_loop(loop, 1, 1.0) for loop in read_planar_loops(result)], load)


def _figures(loops: Sequence[MeasuredLoop], load_N: float) -> list[tuple[int, LoopFigures]]:
    found = []
    for loop in loops:
        with suppress(LoopError):
            found.append((loop.cycle, loop.figures(load_N)))
    return found
