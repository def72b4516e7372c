"""Measured maps of scars at the end of a test.

A spike is a single point that stands out of its neighbours.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from geometry.arrays import Array
from wirewear.base.errors import RecordError
from wirewear.records.levelling import CERTAIN, WELL_KNOWN, Unworn, unworn_surface
from wirewear.records.spikes import BORDER, FINEST_um, as_measured, border_text, noise_um, spikes_text, without_spikes
from wirewear.records.unworn_bodies import LevelSurface
from wirewear.results.scar import SCAR_FIGURES, Scar, called, scar_figures

WIDEST = 3  #: Widest gap along a line that is bridged, in points: reflexes and dirt; what is wider, `check` shows.
SCAR_STEP_um, SCAR_MARGIN_um = 5.0, 20.0  #: Distance of a scar map's points, and unworn margin around the scar.
FEWEST_LEVELLED, OFF_ZERO = 100, 0.1  #: Fewer points show no zero, nor is it known better than a share of the noise.


@dataclass(frozen=True, eq=False)
class MeasuredScar:
    """Worn depths (n_x, n_y) in µm of one repeat's body at the end, over x_um (n_x,) along the motion and y_um (n_y,)
    across; NaN where the map has no point.

    spikes_um: (n_x, n_y) measured depths of spikes, NaN elsewhere; None if there are none. levelling_notes: sentences
    on how the map was levelled.
    """

    repeat: int
    body: str
    x_um: Array
    y_um: Array
    depth_um: Array
    spikes_um: Array | None = None
    levelling_notes: tuple[str, ...] = ()

    @property
    def points(self) -> dict[str, Array]:
        """The map's known points as measured, spikes included, as columns x_um, y_um and depth_um (n,)."""
        x, y = np.meshgrid(self.x_um, self.y_um, indexing="ij")
        depth = as_measured(self.depth_um, self.spikes_um)
        known = np.isfinite(depth)
        return {"x_um": x[known], "y_um": y[known], "depth_um": depth[known]}

    @property
    def field(self) -> tuple[Array, Array, Array]:
        """Lines x (n_x,) and y (n_y,), and depths (n_x, n_y), all in µm."""
        return self.x_um, self.y_um, self.depth_um

    def of_field(self, depth_um: Array) -> "MeasuredScar":
        """Copy of the map with other depths (n_x, n_y), 0 where it has no point."""
        return replace(self, depth_um=np.where(np.isfinite(self.depth_um), depth_um, 0.0), spikes_um=None)

    @property
    def spans_um(self) -> dict[str, float]:
        """Depth, length along the motion and width across, in µm by name."""
        return {name: self.figures[name] for name in SCAR_FIGURES[1:]}

    @classmethod
    def from_points(cls, repeat: int, body: str, x_um: Array, y_um: Array, depth_um: Array) -> "MeasuredScar":
        """Map of points (n,) on the lines of a grid, in any order. Raises RecordError if they lie on no grid."""
        x, y, measured = grid_of(repeat, x_um, y_um, depth_um)
        depth, spikes = without_spikes(measured)
        depth.setflags(write=False)
        return cls(repeat, body, x, y, depth, np.where(spikes, measured, np.nan) if spikes.any() else None)

    @classmethod
    def of_run(cls, scar: Scar, repeat: int, noise_um: float, random: np.random.Generator) -> "MeasuredScar":
        """Map of a simulated scar with x along the motion, as a profilometer reads it; noise_um: standard deviation of
        one depth.
        """
        x, y = scar.sliding_coordinates(scar.axial_um[:, None], scar.transverse_um[None, :])
        worn = scar.depth_um > 0.01 * scar.max_depth_um
        if not worn.any():
            worn = np.ones_like(worn)
        # Between nodes depth falls to that of the next, however far that is.
        beside = np.pad(worn, 1)
        near = sum(beside[i : i + worn.shape[0], j : j + worn.shape[1]] for i in range(3) for j in range(3)) > 0
        lines = []
        for coordinate in (x, y):
            reach, end = (float(np.abs(coordinate[nodes]).max()) for nodes in (worn, near))
            half = SCAR_STEP_um * np.ceil(max(reach + SCAR_MARGIN_um, end) / SCAR_STEP_um)
            lines.append(np.arange(-half, half + 0.5 * SCAR_STEP_um, SCAR_STEP_um))
        depth = scar.sampled(*lines)
        return cls(repeat, scar.body, lines[0], lines[1], depth + noise_um * random.standard_normal(depth.shape))

    def turned(self, angle_deg: float) -> "MeasuredScar":
        """Map turned counter-clockwise about its origin, on lines along the new x and y with the old spacing. Quarter
        turns keep every point. A remaining angle that moves no point by half a line's spacing is neglected.
        """
        quarters, rest_deg = divmod(angle_deg + 45.0, 90.0)
        x, y, depth, spikes = self.x_um, self.y_um, self.depth_um, self.spikes_um
        for _ in range(int(quarters) % 4):
            x, y, depth = -y[::-1], x, depth[:, ::-1].T
            spikes = None if spikes is None else spikes[:, ::-1].T
        rest = np.radians(rest_deg - 45.0)
        step = min(float(np.median(np.diff(line))) for line in (x, y))
        if abs(rest) * np.hypot(np.abs(x).max(), np.abs(y).max()) > 0.5 * step:
            before = x, y
            x, y, depth = _turned(*before, depth, float(rest), step)
            spikes = None if spikes is None else _carried(before, spikes, float(rest), (x, y))
        depth = np.ascontiguousarray(depth)
        depth.setflags(write=False)
        return replace(self, x_um=x, y_um=y, depth_um=depth, spikes_um=spikes)

    @property
    def spikes_note(self) -> str:
        """Sentence on the number of spikes; "" if there are none."""
        return spikes_text(self.spikes_um, self.depth_um, f"the {called(self.body)}'s scar of repeat {self.repeat}")

    @property
    def border_note(self) -> str:
        """Sentence if the border of the map holds much of the worn volume, see `border_text`; else ""."""
        known = np.isfinite(self.depth_um)
        border = np.zeros_like(known)
        for axis in (0, 1):
            deep = max(round(BORDER * known.shape[axis]), 1)
            place, count = known.cumsum(axis=axis), known.sum(axis=axis, keepdims=True)
            border |= known & ((place <= deep) | (place > count - deep))
        whole = float(self.worn_um.sum())
        share = float(self.worn_um[border].sum()) / whole if whole > 0.0 else 0.0
        return border_text(share, f"the {called(self.body)}'s map of repeat {self.repeat}")

    def bridged(self) -> "tuple[MeasuredScar, str]":
        """Copy of the map with gaps of up to WIDEST points interpolated, and a sentence on them and on wider gaps;
        the map itself and "" if there are none.
        """
        depth = self._filled(WIDEST)
        fill = np.isfinite(depth) & ~np.isfinite(self.depth_um)
        if not fill.any():
            return self, self.lost
        depth.setflags(write=False)
        note = (
            f"{np.mean(fill):.1%} of the points of the {called(self.body)}'s map, repeat {self.repeat}, were not "
            f"measured: gaps of up to {WIDEST} points are interpolated"
        )
        return replace(self, depth_um=depth), "; ".join(filter(None, (note, self.lost)))

    @property
    def lost(self) -> str:
        """Sentence on the part of the worn volume in gaps of more than WIDEST points, which are interpolated from their
        borders alone; "" if it is little.
        """
        whole = float(np.maximum(self.worn_um, 0.0).sum())
        inside = float(np.maximum(self.worn_um, 0.0)[~np.isfinite(self._filled(WIDEST))].sum())
        if inside <= WELL_KNOWN * whole:
            return ""
        return (
            f"{inside / whole:.0%} of the worn volume of the {called(self.body)}, repeat {self.repeat}, lie in wider "
            "gaps, where the map shows none of it: a map that reaches into them would help"
        )

    def _filled(self, widest: int) -> Array:
        """Depths (n_x, n_y) with gaps of up to `widest` points interpolated along x and y."""
        both = np.stack([_along(self.y_um, self.depth_um, widest), _along(self.x_um, self.depth_um.T, widest).T])
        known = np.isfinite(both)
        means = np.where(known, both, 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
        return np.where(~np.isfinite(self.depth_um) & known.any(axis=0), means, self.depth_um)

    @cached_property
    def _level(self) -> Unworn | None:
        """Level of what is not worn; None if the map does not show it."""
        if np.count_nonzero(np.isfinite(self.depth_um)) < FEWEST_LEVELLED:
            return None
        places = np.stack(np.meshgrid(self.x_um, self.y_um, indexing="ij"))
        found = unworn_surface(LevelSurface(), places, -self.depth_um, np.zeros(1))
        return None if found.doubtful else found

    @property
    def ground_um(self) -> float:
        """Depth in µm that the map shows where nothing is worn; 0 if it cannot be distinguished from 0."""
        ground = -float(self._level.parameters[0]) if self._level else 0.0
        return ground if abs(ground) > max(OFF_ZERO * noise_um(self.depth_um), FINEST_um) else 0.0

    @cached_property
    def worn_um(self) -> Array:
        """Depths (n_x, n_y) in µm below the unworn surface (`ground_um`), interpolated where no point is known."""
        return np.nan_to_num(self._filled(max(self.depth_um.shape)) - self.ground_um)

    @cached_property
    def figures(self) -> dict[str, float]:
        """Figures of the scar (SCAR_FIGURES) in µm and µm³ by name."""
        return dict(zip(SCAR_FIGURES, scar_figures(self.x_um, self.y_um, self.worn_um), strict=True))

    @property
    def sizes(self) -> str:
        deep, deepest = self.figures["depth"], float(self.worn_um.max())
        # On a map of few points, or of much noise, the deepest points differ by more than a depth is read to.
        single = f" ({deepest:.3g} at the deepest point)" if deepest > 1.005 * deep > 0.0 else ""
        return f"{deep:.3g} µm deep{single}, {1e6 * self.volume_mm3:.4g}·10⁻⁶ mm³"

    def volume_of(self, _length_mm: float | None) -> float:
        """Worn volume in mm³; the length has no effect, as a map covers the whole contact."""
        return self.volume_mm3

    @property
    def volume_mm3(self) -> float:
        return 1e-9 * self.figures["volume"]

    @property
    def doubt_mm3(self) -> float:
        """Half of the worn volume's 95 % interval, for the level of what is not worn alone; 0 if no level is seen."""
        return 1e-9 * CERTAIN * self._level.doubt_um3 if self._level else 0.0

    @property
    def rim_um(self) -> Array:
        """Depths (n,) in µm at the map's edge: the first and last known one of every line along x and along y."""
        known = np.isfinite(self.depth_um)
        ends = [depth[has][[0, -1]] for depth, has in zip(self.depth_um, known, strict=True) if has.any()]
        ends += [depth[has][[0, -1]] for depth, has in zip(self.depth_um.T, known.T, strict=True) if has.any()]
        return np.concatenate(ends) if ends else np.array([])

    @property
    def gaps(self) -> float:
        """Share of missing points among those with known points on all four sides; 0 without any."""
        known = np.isfinite(self.depth_um)
        within = np.ones_like(known)
        for axis in (0, 1):
            for sign in (1, -1):
                flipped = np.flip(known, axis) if sign < 0 else known
                before = np.logical_or.accumulate(flipped, axis=axis)
                within &= np.flip(before, axis) if sign < 0 else before
        return float(np.mean(~known[within])) if within.any() else 0.0


def grid_of(repeat: int, x_um: Array, y_um: Array, level_um: Array) -> tuple[Array, Array, Array]:
    """Lines x (n_x,), y (n_y,) and levels (n_x, n_y) of points (n,) on a grid, in any order; NaN where there is no
    point. repeat: for the message. Raises RecordError if the points lie on no grid.
    """
    lines = np.unique(x_um).size, np.unique(y_um).size
    # Before a grid is made of them: points at random would need a huge one, of which they fill hardly any.
    if min(lines) < 2 or x_um.size < 0.25 * lines[0] * lines[1]:
        raise RecordError(
            f"the {x_um.size} points of repeat {repeat} lie on {lines[0]} × {lines[1]} lines, which is no grid."
        )
    x, x_place = np.unique(x_um, return_inverse=True)
    y, y_place = np.unique(y_um, return_inverse=True)
    level = np.full((x.size, y.size), np.nan)
    level[x_place, y_place] = level_um
    return x, y, level


def _carried(lines: tuple[Array, Array], spikes: Array, angle: float, onto: tuple[Array, Array]) -> Array:
    """Spikes of a map over the grid `lines`, on the grid `onto` (n_x, n_y) of the same map turned by an angle in rad.

    Each spike moves to the nearest point of the new grid; all other points are NaN.
    """
    found = np.full((onto[0].size, onto[1].size), np.nan)
    at = np.argwhere(np.isfinite(spikes))
    x, y = lines[0][at[:, 0]], lines[1][at[:, 1]]
    places = x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle)
    nearest = [np.abs(line[:, None] - place).argmin(axis=0) for line, place in zip(onto, places, strict=True)]
    found[nearest[0], nearest[1]] = spikes[tuple(at.T)]
    return found


def _along(line: Array, depth: Array, widest: int) -> Array:
    """Depths (n, m) interpolated over a line (m,) in gaps of up to `widest` points; NaN elsewhere."""
    known, place = np.isfinite(depth), np.arange(line.size)
    before = np.maximum.accumulate(np.where(known, place, -1), axis=1)
    after = np.minimum.accumulate(np.where(known, place, line.size)[:, ::-1], axis=1)[:, ::-1]
    small = ~known & (before >= 0) & (after < line.size) & (after - before - 1 <= widest)
    rows, columns = np.nonzero(small)
    left, right = before[small], after[small]
    share = (line[columns] - line[left]) / (line[right] - line[left])
    found = np.full(depth.shape, np.nan)
    found[small] = (1.0 - share) * depth[rows, left] + share * depth[rows, right]
    return found


def _turned(x: Array, y: Array, depth: Array, angle: float, step: float) -> tuple[Array, Array, Array]:
    """Lines x, y and depths of a map interpolated on a grid turned by an angle in rad; NaN beyond the map."""
    from scipy.interpolate import RegularGridInterpolator

    cosine, sine = np.cos(angle), np.sin(angle)
    corner_x, corner_y = np.meshgrid(x[[0, -1]], y[[0, -1]])
    corners = (corner_x * cosine - corner_y * sine, corner_x * sine + corner_y * cosine)
    lines = [step * np.arange(np.ceil(at.min() / step), np.floor(at.max() / step) + 1) for at in corners]
    new_x, new_y = np.meshgrid(*lines, indexing="ij")
    at = (new_x * cosine + new_y * sine, new_y * cosine - new_x * sine)
    found: Array = RegularGridInterpolator((x, y), depth, bounds_error=False, fill_value=np.nan)(at)
    return lines[0], lines[1], found
