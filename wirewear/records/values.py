"""An experiment record as a value: loops of each repeat and cycle, evolution, scars."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from wirewear.base.errors import RecordError
from wirewear.loops import LoopFigures, analyse_loop
from wirewear.loops.signals import LoopSignals
from wirewear.records.tables import RecordTables
from wirewear.results.scar import worn_volume_mm3

Array = NDArray[np.float64]

WIRES = ("moving", "fixed")


@dataclass(frozen=True, eq=False)
class MeasuredLoop:
    """One cycle of one repeat as the sensors read it, in the order of its samples.

    All arrays have shape (n,); `time_s` counts from the start of the cycle, `tangential_force_N` is positive when it
    resists motion in +x, `normal_force_N` is None where it was not measured. NaN is a sample that is missing.
    """

    repeat: int
    cycle: int
    time_s: Array
    displacement_um: Array
    tangential_force_N: Array
    normal_force_N: Array | None
    _analysed: dict[float | None, LoopFigures] = field(default_factory=dict, init=False, repr=False)

    @property
    def name(self) -> str:
        """What the loop is called in a sentence."""
        return f"repeat {self.repeat}, cycle {self.cycle}"

    @property
    def complete(self) -> "MeasuredLoop":
        """The loop without the samples of which a channel is missing."""
        channels = [self.time_s, self.displacement_um, self.tangential_force_N]
        if self.normal_force_N is not None:
            channels.append(self.normal_force_N)
        keep: NDArray[np.bool_] = np.logical_and.reduce([np.isfinite(channel) for channel in channels])
        return self if keep.all() else self.taken(keep)

    def taken(self, keep: NDArray[np.bool_]) -> "MeasuredLoop":
        """The loop's samples that are to be kept."""
        normal = None if self.normal_force_N is None else self.normal_force_N[keep]
        channels = (self.time_s[keep], self.displacement_um[keep], self.tangential_force_N[keep], normal)
        return MeasuredLoop(self.repeat, self.cycle, *channels)

    def signals(self, period_s: float | None = None) -> LoopSignals:
        """The loop's channels, for a sensor."""
        return LoopSignals(self.time_s, self.displacement_um, self.tangential_force_N, self.normal_force_N, period_s)

    def read_as(self, signals: LoopSignals) -> "MeasuredLoop":
        """The loop with other displacements and forces."""
        return replace(
            self,
            displacement_um=signals.displacement_um,
            tangential_force_N=signals.tangential_force_N,
            normal_force_N=signals.normal_force_N,
        )

    def figures(self, normal_load_N: float | None = None) -> LoopFigures:
        """Figures of the loop, analysed once; `normal_load_N` stands in for a normal force that was not measured.

        Raises:
            LoopError: the samples make no loop.
        """
        if normal_load_N not in self._analysed:
            loop = self.complete
            normal = normal_load_N if loop.normal_force_N is None else loop.normal_force_N
            figures = analyse_loop(loop.displacement_um, loop.tangential_force_N, normal, time_s=loop.time_s)
            self._analysed[normal_load_N] = figures
        return self._analysed[normal_load_N]


@dataclass(frozen=True, eq=False)
class MeasuredEvolution:
    """One repeat's figures over the cycles, columns of shape (n,): `columns["cycle"]` increases; NaN is missing."""

    repeat: int
    columns: Mapping[str, Array]


def loop_among(loops: Iterable[MeasuredLoop], repeat: int, cycle: int, name: str) -> MeasuredLoop:
    """One loop of a record of that name.

    Raises:
        RecordError: there is none of that repeat and cycle.
    """
    for loop in loops:
        if (loop.repeat, loop.cycle) == (repeat, cycle):
            return loop
    raise RecordError(f"the record {name!r} has no loop of repeat {repeat} at cycle {cycle}.")


#: A map of which fewer points are given than this share of its grid is no grid.
LEAST_FILLED = 0.25


@dataclass(frozen=True, eq=False)
class MeasuredScar:
    """Worn depth of one repeat's wire at the end: `depth_um` (n_x, n_y) over `x_um` (n_x,) and `y_um` (n_y,).

    x is the sliding direction. NaN stands where the map has no point.
    """

    repeat: int
    wire: str
    x_um: Array
    y_um: Array
    depth_um: Array

    @classmethod
    def from_points(cls, repeat: int, wire: str, x_um: Array, y_um: Array, depth_um: Array) -> "MeasuredScar":
        """The map of points (n,) that lie on the lines of a grid, in any order.

        Raises:
            RecordError: they do not.
        """
        lines = np.unique(x_um).size, np.unique(y_um).size
        # Before a grid is made of them: points at random would need a huge one.
        if min(lines) < 2 or x_um.size < LEAST_FILLED * lines[0] * lines[1]:
            raise RecordError(
                f"the {x_um.size} points of repeat {repeat} lie on {lines[0]} × {lines[1]} lines, which is no grid."
            )
        x, x_place = np.unique(x_um, return_inverse=True)
        y, y_place = np.unique(y_um, return_inverse=True)
        depth = np.full((x.size, y.size), np.nan)
        depth[x_place, y_place] = depth_um
        depth.setflags(write=False)
        return cls(repeat, wire, x, y, depth)

    def turned(self, angle_deg: float) -> "MeasuredScar":
        """The map turned about its origin, on lines of the new x and y that are as dense as its own.

        Quarters of a turn keep every point. The rest is left out where it moves no point by half of a line's distance.
        """
        quarters, rest_deg = divmod(angle_deg + 45.0, 90.0)
        x, y, depth = self.x_um, self.y_um, self.depth_um
        for _ in range(int(quarters) % 4):
            x, y, depth = -y[::-1], x, depth[:, ::-1].T
        rest = np.radians(rest_deg - 45.0)
        step = min(float(np.median(np.diff(line))) for line in (x, y))
        if abs(rest) * np.hypot(np.abs(x).max(), np.abs(y).max()) > 0.5 * step:
            x, y, depth = _turned(x, y, depth, float(rest), step)
        depth = np.ascontiguousarray(depth)
        depth.setflags(write=False)
        return replace(self, x_um=x, y_um=y, depth_um=depth)

    @property
    def volume_mm3(self) -> float:
        """Worn volume [mm³]."""
        return worn_volume_mm3(self.x_um, self.y_um, self.depth_um)

    @property
    def rim_um(self) -> Array:
        """Depths (n,) at which the map ends: the first and the last known one of every line along x and along y."""
        known = np.isfinite(self.depth_um)
        ends = [depth[has][[0, -1]] for depth, has in zip(self.depth_um, known, strict=True) if has.any()]
        ends += [depth[has][[0, -1]] for depth, has in zip(self.depth_um.T, known.T, strict=True) if has.any()]
        return np.concatenate(ends) if ends else np.array([])

    @property
    def gaps(self) -> float:
        """Share of the map's points that are missing, of those with known ones on all four sides along the lines."""
        known = np.isfinite(self.depth_um)
        within = np.ones_like(known)
        for axis in (0, 1):
            for sign in (1, -1):
                flipped = np.flip(known, axis) if sign < 0 else known
                before = np.logical_or.accumulate(flipped, axis=axis)
                within &= np.flip(before, axis) if sign < 0 else before
        return float(np.mean(~known[within])) if within.any() else 0.0


def _turned(x: Array, y: Array, depth: Array, angle: float, step: float) -> tuple[Array, Array, Array]:
    """A map between points interpolated at those of a grid that is turned by an angle [rad]; NaN beyond the map."""
    from scipy.interpolate import RegularGridInterpolator

    cosine, sine = np.cos(angle), np.sin(angle)
    corner_x, corner_y = np.meshgrid(x[[0, -1]], y[[0, -1]])
    corners = (corner_x * cosine - corner_y * sine, corner_x * sine + corner_y * cosine)
    lines = [step * np.arange(np.ceil(at.min() / step), np.floor(at.max() / step) + 1) for at in corners]
    new_x, new_y = np.meshgrid(*lines, indexing="ij")
    at = (new_x * cosine + new_y * sine, new_y * cosine - new_x * sine)
    found: Array = RegularGridInterpolator((x, y), depth, bounds_error=False, fill_value=np.nan)(at)
    return lines[0], lines[1], found


@dataclass(frozen=True, eq=False)
class ExperimentRecord:
    """A record of format 1; `notes` are sentences about what was passed over on reading.

    Loops are ordered by repeat and cycle. `path` is the folder that it was read from, or None.
    """

    contact_kind: ClassVar[str] = "crossed-wires"

    tables: RecordTables
    loops: tuple[MeasuredLoop, ...]
    evolution: tuple[MeasuredEvolution, ...] = ()
    scars: tuple[MeasuredScar, ...] = ()
    notes: tuple[str, ...] = ()
    path: Path | None = None

    @property
    def name(self) -> str:
        """Title of the experiment."""
        return self.tables.name

    @property
    def repeats(self) -> tuple[int, ...]:
        """Numbers of the repeats that have loops, increasing."""
        return tuple(sorted({loop.repeat for loop in self.loops}))

    @property
    def cycles(self) -> tuple[int, ...]:
        """Cycles of which at least one repeat has a loop, increasing."""
        return tuple(sorted({loop.cycle for loop in self.loops}))

    def loops_at(self, cycle: int) -> tuple[MeasuredLoop, ...]:
        """All repeats' loops of that cycle."""
        return tuple(loop for loop in self.loops if loop.cycle == cycle)

    def loop(self, repeat: int, cycle: int) -> MeasuredLoop:
        """One loop.

        Raises:
            RecordError: the record has none of that repeat and cycle.
        """
        return loop_among(self.loops, repeat, cycle, self.name)

    @property
    def has_scars(self) -> bool:
        """Whether worn wires were measured."""
        return bool(self.scars)

    def scars_of(self, wire: str) -> tuple[MeasuredScar, ...]:
        """All repeats' scars of the "moving" or the "fixed" wire."""
        return tuple(scar for scar in self.scars if scar.wire == wire)
