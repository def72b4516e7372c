"""A line contact's record as a value: loops, evolution, worn profiles."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wirewear.line_records.tables import LineRecordTables
from wirewear.records.values import MeasuredEvolution, MeasuredLoop, loop_among

Array = NDArray[np.float64]

BODIES = ("pad", "specimen")

#: Depth, relative to the deepest point, that bounds the scar.
EDGE = 0.01


@dataclass(frozen=True, eq=False)
class MeasuredProfile:
    """Worn depth of one repeat's body along the sliding direction at the end, arrays (n,); negative: piled up."""

    repeat: int
    body: str
    x_um: Array
    depth_um: Array

    @property
    def edges_um(self) -> tuple[float, float]:
        """Where the depth first falls to 1 % of its largest, to either side of the deepest point; or the ends."""
        deepest, level = int(self.depth_um.argmax()), EDGE * float(self.depth_um.max())
        out = np.flatnonzero(self.depth_um <= level)
        left, right = out[out < deepest], out[out > deepest]
        return (
            float(self.x_um[left[-1] if len(left) else 0]),
            float(self.x_um[right[0] if len(right) else -1]),
        )

    @property
    def area_um2(self) -> float:
        """Worn cross-section between the edges."""
        left, right = self.edges_um
        worn = (self.x_um >= left) & (self.x_um <= right)
        return float(np.trapezoid(self.depth_um[worn], self.x_um[worn]))


@dataclass(frozen=True, eq=False)
class LineRecord:
    """All that is recorded of a line contact; forces and energies are those of the whole contact."""

    tables: LineRecordTables
    loops: tuple[MeasuredLoop, ...] = ()
    evolution: tuple[MeasuredEvolution, ...] = ()
    profiles: tuple[MeasuredProfile, ...] = ()
    notes: tuple[str, ...] = ()
    path: Path | None = None

    @property
    def name(self) -> str:
        """Title of the experiment."""
        return self.tables.name

    @property
    def repeats(self) -> tuple[int, ...]:
        """Numbers of the repeats that something is recorded of."""
        parts: tuple[tuple[MeasuredLoop | MeasuredEvolution | MeasuredProfile, ...], ...]
        parts = self.loops, self.evolution, self.profiles
        return tuple(sorted({one.repeat for part in parts for one in part}))

    @property
    def cycles(self) -> tuple[int, ...]:
        """Cycles with loops."""
        return tuple(sorted({loop.cycle for loop in self.loops}))

    def loop(self, repeat: int, cycle: int) -> MeasuredLoop:
        """One loop.

        Raises:
            RecordError: the record has none of that repeat and cycle.
        """
        return loop_among(self.loops, repeat, cycle, self.name)

    def profiles_of(self, body: str) -> tuple[MeasuredProfile, ...]:
        """The profiles of a body, repeat by repeat."""
        return tuple(profile for profile in self.profiles if profile.body == body)
