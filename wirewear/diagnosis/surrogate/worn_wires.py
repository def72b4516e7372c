"""Two bodies such as crossed wires that wear on an elastic foundation: their gap, their pressures, and their worn
depths.

Wear follows Archard's law under the pressures of a Winkler foundation (Johnson, Contact Mechanics, 1985, section 4.3).
The approach is the distance by which the unworn bodies would overlap. Arrays (k, y, s, x) hold k cases, rows y ≥ 0
across the motion, positions s ≥ 0 of the stroke, and places x along it. Lengths are in slip amplitudes δ, depths in
δ²/R, the load is 1.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from geometry.arrays import Array
from wirewear.results.scar import scar_figures

#: From overlaps (k, y, s, x) to the pressures that they take, and their derivative.
Pressing = Callable[[Array], tuple[Array, Array]]


#: Share of the largest step that keeps an explicit wear law from oscillating, and largest growth of the volume.
_STABLE, _GROWTH = 0.95, 0.3

#: Beyond a limit, pressures of a foundation rise by this share of the stiffness.
_RISE = 0.05

#: Newton steps for the approach, and by which share of the load they may miss.
_NEWTON_STEPS, _NEWTON_TOLERANCE = 40, 1e-3


@dataclass(frozen=True, eq=False)
class WornWires:
    """Two wires with the gap (along·x² + y²)/2, in k cases, for y ≥ 0 and positions s ≥ 0 of the stroke; symmetry gives
    the rest.

    x, y, s: grid lines. fixed: (k, y, x) worn depths of the fixed wire. moving: (k, y, X) of the moving one, where X
    reaches a stroke further to either side. Other bodies have this gap in sheared coordinates (`Gap`).
    """

    x: Array
    y: Array
    s: Array
    fixed: Array
    moving: Array
    along: float = 1.0

    @classmethod
    def unworn(cls, count: int, extent: float, along: float = 1.0, finer: int = 1) -> WornWires:
        """`count` pairs of unworn wires on a grid that reaches from the middle to `extent`, in δ, across the motion.
        along: the gap's curvature along the motion over its curvature across it. finer: parts of a usual grid's step.
        """
        places = max(round(16 / extent * max(along, 1.0) ** 0.5), 4)
        half, rows = (finer * int(np.ceil(reach * places)) for reach in (extent / along**0.5, extent))
        places *= finer
        step = 1.0 / places
        x, y = step * np.arange(-half, half + 1.0), step * np.arange(rows + 1.0)
        fixed, moving = (np.zeros((count, y.size, x.size + 2 * more)) for more in (0, places))
        return cls(x, y, step * np.arange(places + 1.0), fixed, moving, along)

    @property
    def step(self) -> float:
        """Spacing in δ of the grid lines x and y and of the positions s."""
        return float(self.y[1])

    @property
    def moving_x(self) -> Array:
        """Coordinates (X,) in δ of the grid lines along the moving wire."""
        half = self.moving.shape[-1] // 2
        return self.step * np.arange(-half, half + 1.0)

    @property
    def areas(self) -> Array:
        """Areas (y,) in δ² that a point of each row stands for, its mirror image at −y included."""
        return np.where(self.y > 0.0, 2.0, 1.0) * self.step**2

    @property
    def volumes(self) -> Array:
        """Volumes (k, 2) in δ⁴/R that the moving and the fixed wire lack."""
        return np.stack([np.einsum("kyx,y->k", one, self.areas) for one in (self.moving, self.fixed)], axis=1)

    def windows(self, moving: Array) -> Array:
        """A view (k, y, s, x) of a field (k, y, X) of the moving wire, as it lies above the fixed wire's grid at each
        position s.
        """
        return sliding_window_view(moving, self.x.size, axis=-1)[:, :, self.s.size - 1 :]

    def within(self, reach: float) -> WornWires:
        """The part of the grid up to `reach` across from the middle; its depths are views, so that they wear with
        these.
        """
        cut = max(self.x.size // 2 - int(reach / self.along**0.5 / self.step) - 2, 0)
        x, further = slice(cut, self.x.size - cut), slice(cut, self.moving.shape[-1] - cut)
        rows = slice(0, int(reach / self.step) + 3)
        fixed, moving = self.fixed[:, rows, x], self.moving[:, rows, further]
        return replace(self, x=self.x[x], y=self.y[rows], fixed=fixed, moving=moving)

    def worn(self, pressure: Array, moving_share: float, volume: float) -> None:
        """Wear both wires in place. pressure: (k, y, s, x), under a load of 1. volume: that each pair loses, in δ⁴/R.
        moving_share: share of it that the moving wire loses.
        """
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

    def printed(self, closed: Array) -> None:
        """Print both wires in place, each by half of the largest closure (k, y, s, x) of the positions."""
        fixed, moving = closed.max(axis=2), np.zeros_like(self.moving)
        for place in range(self.s.size):
            start = self.s.size - 1 + place
            into = moving[:, :, start : start + self.x.size]
            np.maximum(into, closed[:, :, place], out=into)
        self.fixed[...] += 0.5 * np.maximum(fixed, fixed[:, :, ::-1])
        self.moving[...] += 0.5 * np.maximum(moving, moving[:, :, ::-1])


class Worn(NamedTuple):
    """Wires in k cases after a worn volume.

    part: the part that touches. pressure: (k, y, s, x) on it. approach: (k, s). radius: (k,) of the contact.
    """

    part: WornWires
    pressure: Array
    approach: Array
    radius: Array


def elastic(overlap: Array, stiffness: Array) -> tuple[Array, Array]:
    """Pressures (k, y, s, x) of a foundation under overlaps (k, y, s, x), and their derivative by the overlap;
    stiffness: (k,).
    """
    own = stiffness[:, None, None, None]
    return own * np.maximum(overlap, 0.0), own * (overlap > 0.0)


def limited(overlap: Array, stiffness: Array, limit: Array) -> tuple[Array, Array]:
    """(pressures, their ratios to overlaps, 0 without contact), of the shape of overlaps (k, …), of foundations of
    stiffnesses (k,) whose pressures hardly rise beyond limits (k,).
    """
    free, rising = elastic(overlap, stiffness)
    most = limit[:, None, None, None]
    pressure = np.where(free > most, most + _RISE * (free - most), free)
    return pressure, rising * np.divide(pressure, free, out=np.ones_like(free), where=free > 0.0)


def wearing(
    wires: WornWires,
    volumes: Array,
    fresh_radius: float,
    approach: Array,
    moving_share: float,
    pressing: Callable[[Array], Pressing],
    least_growth: float = 0.0,
    limit: Array | None = None,
) -> Iterator[Worn]:
    """Wear k pairs of wires in place, and yield their state when each of the increasing `volumes` is worn.

    fresh_radius: of the unworn contact. approach: (k, s) first guess. moving_share: share of the wear that the moving
    wire loses. pressing: makes the function from overlaps to pressures from stiffnesses (k,). least_growth: share of
    the volume by which each step may at least grow; foundations are softened as far as stability needs for it. limit:
    (k,) pressures beyond which wires are printed, with `pressing` by `limited`.
    """
    radius = np.full(wires.fixed.shape[0], fresh_radius)
    worn = 0.0
    for wanted in volumes:
        while True:
            stiffness = foundation(fresh_radius, radius, least_growth * worn)
            part, pressure, approach = equilibrium(wires, pressing(stiffness), approach)
            radius = contact_radius(part, pressure)
            if limit is not None:
                beyond = np.maximum(pressure - limit[:, None, None, None], 0.0)
                part.printed(beyond / (_RISE * stiffness[:, None, None, None]))
            if worn >= wanted:
                break
            step = min(_STABLE / float(stiffness.max()), max(_GROWTH * worn, 0.3 * float(volumes[1])), wanted - worn)
            part.worn(pressure, moving_share, step)
            worn += step
        yield Worn(part, pressure, approach, radius)


def foundation(fresh_radius: float, radius: Array, step: float = 0.0) -> Array:
    """Elastic stiffnesses (k,) of the foundation under contacts of radii (k,); fresh_radius: of the unworn contact.
    step: volume worn in one explicit step, for whose stability stiffnesses are limited; 0 for no limit.
    """
    # Foundation stiffness times the contact's radius over E*: between 16/(3π), with which a fresh contact has Hertz's
    # load and radius together, and 3π/16, by which a half-space yields on average under the even pressure of a worn one
    # (Johnson, eq. 3.29); their geometric mean.
    stiffness = 0.75 * 1.0 / (fresh_radius**3 * radius)
    return stiffness if step == 0.0 else np.minimum(stiffness, _STABLE / step)


def equilibrium(wires: WornWires, pressing: Pressing, approach: Array) -> tuple[WornWires, Array, Array]:
    """The part of the wires that touches, pressures (k, y, s, x) on it that carry a load of 1, and approaches (k, s).
    pressing: from overlaps to pressures and their derivative. approach: (k, s) first guess. By Newton's method.
    """
    reach = 0.0
    for _ in range(_NEWTON_STEPS):
        needed = float(np.sqrt(2.0 * max(approach.max(), 0.0)))
        if needed > reach:
            reach = 1.1 * needed
            part = wires.within(reach)
            unworn = 0.5 * (part.along * part.x**2 + part.y[:, None, None] ** 2)
            gap = unworn + part.fixed[:, :, None] + part.windows(part.moving)
            lowest = gap.min(axis=(1, 3)) + 1e-6
            approach = np.maximum(approach, lowest)
        pressure, stiffness = pressing(approach[:, None, :, None] - gap)
        load, touching = (np.einsum("kysx,y->ks", field, part.areas) for field in (pressure, stiffness))
        if float(np.abs(load - 1.0).max()) < _NEWTON_TOLERANCE:
            break
        approach = np.maximum(approach - (load - 1.0) / np.maximum(touching, 1e-9), lowest)
    return part, pressure, approach


def contact_radius(wires: WornWires, pressure: Array) -> Array:
    """Radius (k,) of a circle under even pressure with the same mean square of pressure; mean over the positions s."""
    squares = np.einsum("kysx,kysx,y->ks", pressure, pressure, wires.areas)
    return np.asarray(np.sqrt((1.0 / squares).mean(axis=1) / np.pi))


def slopes(part: WornWires, pressure: Array) -> Array:
    """Mean slopes (k, s) of the surface between both wires, weighted by pressure (k, y, s, x), less the one in
    mid-stroke.
    """
    fixed = part.along * part.x + np.gradient(part.fixed, part.step, axis=-1)
    slope = 0.5 * (fixed[:, :, None] - part.windows(np.gradient(part.moving, part.step, axis=-1)))
    mean = np.einsum("kysx,kysx,y->ks", pressure, slope, part.areas)
    return np.asarray(mean - mean[:, :1])


def scars(wires: WornWires) -> Array:
    """Volume, depth, length and width (`SCAR_FIGURES`) of both scars in k states of wear: (k, 2, 4), the moving wire
    first; lengths in δ, depths in δ²/R.
    """
    return np.array(
        [
            [_figures(x, wires.y, depth) for x, depth in ((wires.moving_x, moving), (wires.x, fixed))]
            for moving, fixed in zip(wires.moving, wires.fixed, strict=True)
        ]
    )


def _figures(x: Array, y: Array, depth: Array) -> list[float]:
    whole = np.concatenate([depth[:0:-1], depth])
    return scar_figures(x, np.concatenate([-y[:0:-1], y]), whole.T)
