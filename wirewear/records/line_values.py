"""A line contact's record as a value: loops, evolution, worn profiles."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from wirewear.records.line_tables import LineRecordTables
from wirewear.records.values import MeasuredEvolution, MeasuredLoop, loop_among

Array = NDArray[np.float64]

BODIES = ("pad", "specimen")

#: Depth, relative to the deepest point, that bounds the scar.
EDGE = 0.01

#: Noise (three deviations) is small below this share of the depth; a profile keeps so many means beside one another.
CLEAR, FEWEST_ACROSS = 0.1, 8


@dataclass(frozen=True, eq=False)
class MeasuredProfile:
    """Worn depth of one repeat's body along the sliding direction at the end, arrays (n,); negative: piled up."""

    repeat: int
    body: str
    x_um: Array
    depth_um: Array

    @property
    def edges_um(self) -> tuple[float, float]:
        """Where the depth first falls to 1 % of its largest, to either side of the deepest point; or the ends.

        In a shallow scar noise alone would do that anywhere: there it is the mean of neighbours that falls.
        """
        deepest = int(self.smooth_um.argmax())
        out = np.flatnonzero(self.smooth_um <= self._level_um)
        left, right = out[out < deepest], out[out > deepest]
        return (
            self._crossing(int(left[-1]), int(left[-1]) + 1) if len(left) else float(self.x_um[0]),
            self._crossing(int(right[0]), int(right[0]) - 1) if len(right) else float(self.x_um[-1]),
        )

    @cached_property
    def smooth_um(self) -> Array:
        """Depths (n,) as means of so many neighbours that noise is small beside the scar; as they are in a deep one."""
        depth = self.depth_um
        # Of a straight line nothing is left in second differences, of noise √6 times its deviation.
        noise = 1.4826 * float(np.median(np.abs(np.diff(depth, 2)))) / np.sqrt(6.0) if depth.size > 2 else 0.0
        deep, smooth = float(depth.max()), depth
        for _ in range(2):
            count = min(int((3.0 * noise / (CLEAR * deep)) ** 2), depth.size // FEWEST_ACROSS) if deep > 0.0 else 0
            if count < 2:
                return smooth
            padded = np.pad(depth, (count // 2, (count - 1) // 2), mode="reflect")
            smooth = np.convolve(padded, np.full(count, 1.0 / count), mode="valid")
            deep = float(smooth.max())
        return smooth

    @property
    def width_um(self) -> float:
        """Distance of the edges."""
        left, right = self.edges_um
        return right - left

    @property
    def area_um2(self) -> float:
        """Worn cross-section between the edges."""
        x, depth = self._worn
        return float(np.trapezoid(depth, x))

    @property
    def centre_um(self) -> float:
        """Centre of the worn cross-section; NaN where nothing is worn."""
        x, depth = self._worn
        return float(np.trapezoid(x * depth, x)) / self.area_um2 if self.area_um2 > 0.0 else float("nan")

    @property
    def _level_um(self) -> float:
        return EDGE * float(self.smooth_um.max())

    @property
    def _worn(self) -> tuple[Array, Array]:
        """Places and depths from edge to edge."""
        left, right = self.edges_um
        inside = (self.x_um > left) & (self.x_um < right)
        ends = np.interp((left, right), self.x_um, self.depth_um)
        return np.r_[left, self.x_um[inside], right], np.r_[ends[0], self.depth_um[inside], ends[1]]

    def _crossing(self, out: int, worn: int) -> float:
        """The place between two neighbours at which the depth passes the edges' level."""
        rise = float(self.smooth_um[worn] - self.smooth_um[out])
        share = (self._level_um - float(self.smooth_um[out])) / rise if rise > 0.0 else 0.0
        return float(self.x_um[out] + share * (self.x_um[worn] - self.x_um[out]))


@dataclass(frozen=True, eq=False)
class LineRecord:
    """All that is recorded of a line contact; forces and energies are those of the whole contact."""

    contact_kind: ClassVar[str] = "line-contact"

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

    @property
    def has_scars(self) -> bool:
        """Whether worn bodies were measured."""
        return bool(self.profiles)

    def profiles_of(self, body: str) -> tuple[MeasuredProfile, ...]:
        """The profiles of a body, repeat by repeat."""
        return tuple(profile for profile in self.profiles if profile.body == body)
