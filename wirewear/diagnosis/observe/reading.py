"""A record read: its loops made ready, beside its evolution and its scars, from which observables are measured."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from wirewear.base.errors import RecordError
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.observe.measured_loops import ReducedLoop, of_one_recorder, reduced_loop
from wirewear.loops import LoopError
from wirewear.records import AnyRecord, MeasuredEvolution, MeasuredProfile, MeasuredScar

_KNOWN = constants("observe.reading")

#: Logged cycles that are used at most.
MOST_CYCLES = _KNOWN.count("most_cycles")


@dataclass(frozen=True, eq=False)
class Reading:
    """All repeats of a record; `notes` say which loops were left out and why.

    Of a record without loops, `asked_um` and `asked_N` stand in for their amplitude and force. `depth_noise_um` is
    the stated error of one depth of a profile. `body_names` begin with the driven one.
    """

    loops: tuple[ReducedLoop, ...]
    evolution: tuple[MeasuredEvolution, ...]
    scars: tuple[MeasuredScar, ...]
    last_cycle: int
    notes: tuple[str, ...]
    profiles: tuple[MeasuredProfile, ...] = ()
    asked_um: float = 1.0
    asked_N: float = 1.0
    depth_noise_um: float = 0.0
    body_names: tuple[str, ...] = ()

    @property
    def repeats(self) -> tuple[int, ...]:
        return tuple(sorted({one.repeat for part in (self.loops, self.profiles) for one in part}))

    @property
    def cycles(self) -> list[int]:
        return sorted({loop.cycle for loop in self.loops})

    @cached_property
    def amplitude_um(self) -> float:
        """Amplitude of the loops, the median."""
        return float(np.median([loop.amplitude_um for loop in self.loops])) if self.loops else self.asked_um

    @cached_property
    def force_N(self) -> float:
        """Force of the loops at mid-stroke, the median."""
        return float(np.median([loop.mid_force_N for loop in self.loops])) if self.loops else self.asked_N

    @cached_property
    def sample_noise_N(self) -> float:
        """Noise of one sample of the force, the median."""
        return float(np.median([loop.sample_noise_N for loop in self.loops])) if self.loops else 0.0

    def at(self, cycle: int) -> list[ReducedLoop]:
        """Loops of all repeats at a cycle."""
        return [loop for loop in self.loops if loop.cycle == cycle]


def read(record: AnyRecord) -> Reading:
    """The loops, evolution and scars or profiles of a record; profiles alone suffice.
    Raises RecordError if no loop of the record slides as a whole, or none can be read.
    """
    notes: list[str] = []
    loops = list(_loops(record, notes))
    tables, asked = record.tables, record.tables.conditions
    if not loops and (tables.needs_loops or not record.scars):
        raise RecordError(
            f"nothing of the record {record.name!r} can be diagnosed: {notes[0] if notes else 'no loop, no profile'}"
        )
    # Worn surfaces go by their own name: scars or profiles.
    surfaces: dict[str, Any] = {"scars": (), "profiles": (), f"{tables.worn.name}s": record.scars}
    return Reading(
        tuple(of_one_recorder(loops)) if loops else (),
        record.evolution,
        last_cycle=int(asked.cycles),
        notes=tuple(notes),
        asked_um=asked.displacement_amplitude_um,
        asked_N=(tables.stated.final_friction or 1.0) * asked.normal_load_N,
        depth_noise_um=tables.depth_noise_um,
        body_names=tables.body_names,
        **surfaces,
    )


def spread_cycles(cycles: Sequence[int], most: int) -> list[int]:
    """At most so many cycles, spread evenly over their logarithm, first and last among them."""
    if len(cycles) <= most:
        return list(cycles)
    wanted = np.linspace(np.log(max(cycles[0], 1)), np.log(max(cycles[-1], 1)), most)
    known = np.log(np.maximum(cycles, 1))
    return sorted({cycles[int(np.argmin(np.abs(known - at)))] for at in wanted})


def _loops(record: AnyRecord, notes: list[str]) -> Iterator[ReducedLoop]:
    for cycle in spread_cycles([cycle for cycle in record.cycles if cycle > 0], MOST_CYCLES):
        for loop in (one for one in record.loops if one.cycle == cycle):
            try:
                yield reduced_loop(loop, record.tables.noise)
            except (LoopError, ValueError, IndexError) as error:
                notes.append(f"the loop of {loop.name} was left out: {error}")
