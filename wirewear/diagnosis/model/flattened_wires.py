"""What flattening before any wear changes of the wear states that follow: two wires on an elastic foundation.

Both wires give way by half the overlap of their unworn shapes, the moving one along the whole stroke. What is left is
a contact as wide as the flat across the motion and short along it, in a groove that reaches past the slip: no hooks
at first, steep ends as soon as wear has dug into the flat, until the scar has outgrown it. Crossed wires wear by
Archard's law under the pressures of a Winkler foundation (Johnson, Contact Mechanics, 1985, section 4.3), and only the
difference from wires that were not flattened is used. Lengths are in slip amplitudes δ, depths in δ²/R.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy.interpolate import RegularGridInterpolator

from wirewear.diagnosis.model.scar_figures import scar_figures

Array = NDArray[np.float64]

#: Flattenings and worn volumes that are followed, as shares of the deepest and of the largest.
_FLATTENINGS = np.array([0.0, 0.04, 0.12, 0.3, 0.6, 1.0])
_VOLUMES = np.array([0.0, 0.0025, 0.0075, 0.018, 0.036, 0.07, 0.14, 0.26, 0.48, 1.0])

#: The largest volume over that of the deepest flat: by then little is left of it.
_OUTWORN = 4.0

#: Half-columns of the grid, about; half its width over the radius of the largest scar.
_COLUMNS, _MARGIN = 16, 1.08

#: Foundation stiffness times the contact's radius over E*: between 16/(3π), with which a fresh contact has Hertz's load
#: and radius together, and 3π/16, by which a half-space yields on average under the even pressure of a worn one
#: (Johnson, eq. 3.29); their geometric mean.
_FOUNDATION = 1.0

#: Share of the largest step that keeps an explicit wear law from oscillating, and largest growth of the volume.
_STABLE, _GROWTH = 0.95, 0.3

#: Newton steps for the approach, and by which share of the load they may miss.
_NEWTON_STEPS, _NEWTON_TOLERANCE = 40, 1e-3


@dataclass(frozen=True, eq=False)
class FlatteningChange:
    """Changes by flattening at (n,) moments.

    Attributes:
        slope: (n, m) of θ in δ/R, at the `positions` of `FlattenedWires`.
        stiffness: (n,) logarithm of the contact's stiffness.
        approach: (n,) by which wear has let the wires come nearer, in δ²/R.
        depth: (n, 2) of the moving and of the fixed wire's scar, in δ²/R.
        extent: (n, 2, 2) logarithm of the scars' lengths and widths, by wire.
        volume: (n, 2) of the flats themselves, in δ⁴/R.
    """

    slope: Array
    stiffness: Array
    approach: Array
    depth: Array
    extent: Array
    volume: Array


@dataclass(frozen=True, eq=False)
class FlattenedWires:
    """Changes by `flattenings` h R/δ² (k), the first of none, after worn `volumes` V R/δ⁴ of both wires (n).

    `positions` (m,) are s/δ from 0 to 1; `table` holds (k, n, …) of what `FlatteningChange` does, volumes (k, 2) apart.
    """

    flattenings: Array
    volumes: Array
    positions: Array
    table: FlatteningChange

    def at(self, flattening: Array, similarity: Array) -> FlatteningChange:
        """The changes at (n,) moments, each at its own h R/δ² and V R/δ⁴."""
        late = np.maximum(similarity / self.volumes[-1], 1.0)
        start = self.volumes[1]
        where = np.minimum(flattening, self.flattenings[-1]), np.log(similarity / late + start)
        axes = self.flattenings, np.log(self.volumes + start)

        def read(table: Array, count: int = 2) -> Array:
            # Round-off may lead past an end.
            known = RegularGridInterpolator(axes[:count], table, bounds_error=False, fill_value=None)
            return np.asarray(known(np.stack(where[:count], axis=-1)))

        table = self.table
        return FlatteningChange(
            # Past the largest volume, what is left fades as the scar grows.
            read(table.slope) / late[:, None],
            read(table.stiffness) / late,
            read(table.approach),
            read(table.depth),
            read(table.extent) / late[:, None, None],
            read(table.volume, 1),
        )


@dataclass(frozen=True, eq=False)
class _Wires:
    """Both wires at several flattenings (k): half of the plane, y ≥ 0; by symmetry only positions s ≥ 0 are needed.

    What they have lost is `fixed` (k, y, x) and `moving` (k, y, X), X reaching a stroke further to either side.
    """

    x: Array
    y: Array
    s: Array
    fixed: Array
    moving: Array

    @property
    def step(self) -> float:
        """Distance of the grid's points, and of the positions."""
        return float(self.y[1])

    @property
    def moving_x(self) -> Array:
        """Places along the moving wire (X,)."""
        half = self.moving.shape[-1] // 2
        return self.step * np.arange(-half, half + 1.0)

    @property
    def areas(self) -> Array:
        """Areas of a point of each row (y,), those of y < 0 added."""
        return np.where(self.y > 0.0, 2.0, 1.0) * self.step**2

    def windows(self, moving: Array) -> Array:
        """A field (k, y, X) of the moving wire above the fixed one's grid at every position (k, y, s, x): a view."""
        return sliding_window_view(moving, self.x.size, axis=-1)[:, :, self.s.size - 1 :]

    def within(self, reach: float) -> _Wires:
        """Views of the part up to so far from the middle."""
        half = min(int(reach / self.step) + 2, self.y.size - 1)
        cut = self.y.size - 1 - half
        along = slice(cut, self.x.size - cut)
        further = slice(cut, self.moving.shape[-1] - cut)
        rows = slice(0, half + 1)
        return _Wires(self.x[along], self.y[rows], self.s, self.fixed[:, rows, along], self.moving[:, rows, further])

    def worn(self, pressure: Array, moving_share: float, volume: float) -> None:
        """Wear by a volume (of a load 1, over all positions evenly) that goes to both wires, in place."""
        weights = np.full(self.s.size, volume / (self.s.size - 1))
        weights[[0, -1]] *= 0.5
        rubbed = pressure * weights[:, None]
        fixed = rubbed.sum(axis=2)
        self.fixed[...] += 0.5 * (1.0 - moving_share) * (fixed + fixed[:, :, ::-1])
        moving = np.zeros_like(self.moving)
        for place in range(self.s.size):
            start = self.s.size - 1 + place
            moving[:, :, start : start + self.x.size] += rubbed[:, :, place]
        self.moving[...] += 0.5 * moving_share * (moving + moving[:, :, ::-1])


@lru_cache(maxsize=16)
def flattened_wires(fresh_radius: float, stroke: float, deepest: float, moving_share: float = 0.5) -> FlattenedWires:
    """Changes by flattenings of up to `deepest` h R/δ² along ±`stroke`, of which the moving wire takes a share of wear.

    `fresh_radius` is that of the unworn contact; it and the stroke are in slip amplitudes.
    """
    flattenings = deepest * _FLATTENINGS
    wires = _flattened(flattenings, stroke, fresh_radius)
    flats = np.stack([(lost * wires.areas[:, None]).sum(axis=(1, 2)) for lost in (wires.moving, wires.fixed)], axis=1)
    volumes = _OUTWORN * float(flats[-1].sum()) * _VOLUMES
    approach = flattenings[:, None] + 0.1 * fresh_radius**2 + np.zeros(wires.s.size)
    radius = np.full(flattenings.size, fresh_radius)
    kept, worn = [], 0.0
    for wanted in volumes:
        while True:
            stiffness = 0.75 * _FOUNDATION / (fresh_radius**3 * radius)
            part, pressure, approach = _equilibrium(wires, stiffness, approach)
            radius = _contact_radius(part, pressure)
            if worn >= wanted:
                break
            step = min(_STABLE / float(stiffness.max()), max(_GROWTH * worn, 0.3 * float(volumes[1])), wanted - worn)
            part.worn(pressure, moving_share, step)
            worn += step
        kept.append(_state(wires, part, pressure, approach, radius))
    slope, size, near, depth, extent = (np.stack(column, axis=1) for column in zip(*kept, strict=True))
    near = near - near[:, :1]
    # Before any wear there is no scar to compare with.
    extent[:, 0] = extent[:, 1]
    change = FlatteningChange(
        slope - slope[:1],
        np.log(size / size[:1]),
        near - near[:1],
        depth - depth[:1],
        np.log(extent / extent[:1]),
        flats,
    )
    return FlattenedWires(flattenings, volumes, wires.s, change)


def _flattened(flattenings: Array, stroke: float, fresh_radius: float) -> _Wires:
    """Unworn wires, flattened by half the overlap of their unworn shapes wherever they meet during the stroke."""
    deepest = float(flattenings[-1])
    flat = (2.0 * deepest) ** 1.5 * stroke / 1.5 + np.pi * deepest**2
    extent = _MARGIN * (4.0 * (1.0 + _OUTWORN) * flat / np.pi) ** 0.25 + 0.5 * fresh_radius
    places = max(round(_COLUMNS / extent), 4)
    step = 1.0 / places
    half = int(np.ceil(extent / step))
    x, y = step * np.arange(-half, half + 1.0), step * np.arange(half + 1.0)
    along = step * np.arange(-half - places, half + places + 1.0)
    overlap = flattenings[:, None, None] - 0.5 * y[:, None] ** 2
    past = np.maximum(np.abs(along) - stroke, 0.0)
    return _Wires(
        x,
        y,
        step * np.arange(places + 1.0),
        0.5 * np.maximum(overlap - 0.5 * x**2, 0.0),
        0.5 * np.maximum(overlap - 0.5 * past**2, 0.0),
    )


def _equilibrium(wires: _Wires, stiffness: Array, approach: Array) -> tuple[_Wires, Array, Array]:
    """Pressures (k, y, s, x) that carry a load of 1, and approaches (k, s), by Newton's method from a first guess.

    The part of the wires on which they touch comes first: unworn shapes that do not overlap bear nothing.
    """
    reach = 0.0
    for _ in range(_NEWTON_STEPS):
        needed = float(np.sqrt(2.0 * max(approach.max(), 0.0)))
        if needed > reach:
            reach = 1.1 * needed
            part = wires.within(reach)
            unworn = 0.5 * (part.x**2 + part.y[:, None, None] ** 2)
            gap = unworn + part.fixed[:, :, None] + part.windows(part.moving)
            lowest = gap.min(axis=(1, 3)) + 1e-6
            approach = np.maximum(approach, lowest)
        overlap = np.maximum(approach[:, None, :, None] - gap, 0.0)
        load, touching = (
            np.einsum("kysx,y->ks", field, part.areas) * stiffness[:, None]
            for field in (overlap, (overlap > 0.0).astype(float))
        )
        if float(np.abs(load - 1.0).max()) < _NEWTON_TOLERANCE:
            break
        approach = np.maximum(approach - (load - 1.0) / np.maximum(touching, 1e-9), lowest)
    return part, stiffness[:, None, None, None] * overlap, approach


def _contact_radius(wires: _Wires, pressure: Array) -> Array:
    """Radius (k,) of the circle that carries an even pressure as concentrated as this one, mean over the positions."""
    squares = np.einsum("kysx,kysx,y->ks", pressure, pressure, wires.areas)
    return np.asarray(np.sqrt((1.0 / squares).mean(axis=1) / np.pi))


def _state(wires: _Wires, part: _Wires, pressure: Array, approach: Array, radius: Array) -> tuple[Array, ...]:
    """Mean slopes (k, s) of the surface between both wires, contact radii, approaches, and figures of the scars."""
    fixed = part.x + np.gradient(part.fixed, part.step, axis=-1)
    slope = 0.5 * (fixed[:, :, None] - part.windows(np.gradient(part.moving, part.step, axis=-1)))
    mean = np.einsum("kysx,kysx,y->ks", pressure, slope, part.areas)
    figures = np.array(
        [
            [_figures(x, wires.y, depth) for x, depth in ((wires.moving_x, moving), (wires.x, fixed))]
            for moving, fixed in zip(wires.moving, wires.fixed, strict=True)
        ]
    )
    return mean - mean[:, :1], radius, approach.mean(axis=1), figures[:, :, 1], figures[:, :, 2:]


def _figures(x: Array, y: Array, depth: Array) -> list[float]:
    whole = np.concatenate([depth[:0:-1], depth])
    return scar_figures(x, np.concatenate([-y[:0:-1], y]), whole.T)
