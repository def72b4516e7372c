"""What a rough layer, or flattening before any wear, changes of the wear states: two wires on an elastic foundation.

A soft layer spreads the pressure, so that a wider and shallower groove is worn, whose slopes grow evenly along the
stroke. The walls at its ends stay away, and outlive the layer for a while. The layer closes by s ln(1 + p/p_c) under a
pressure p (`solvers.RoughLayer`). What a scar remembers is one height: the mean of those under which it was worn, late
wear weighing more.

Flattened wires give way by half the overlap of their unworn shapes, the moving one along the whole stroke. What is left
is a contact as wide as the flat across the motion and short along it, in a groove that reaches past the slip: no hooks
at first, steep ends as soon as wear has dug into the flat, until the scar has outgrown it.

Only the difference from wires without either is used. Lengths are in slip amplitudes δ, depths and heights in δ²/R.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import cached_property, lru_cache, partial
from math import prod
from pathlib import Path

import numpy as np
from scipy.interpolate import RegularGridInterpolator
from scipy.optimize import brentq

from geometry.arrays import Array
from solvers import RoughLayer
from wirewear.base.cache import identity_of
from wirewear.base.errors import ResultError
from wirewear.diagnosis.surrogate.nominal import kept_or_made
from wirewear.diagnosis.surrogate.worn_wires import (
    Pressing,
    Worn,
    WornWires,
    contact_radius,
    elastic,
    equilibrium,
    foundation,
    limited,
    scars,
    slopes,
    wearing,
)

#: Heights under which a scar is worn, as shares of the highest; heights then present, as shares of these; and volumes.
_HEIGHTS = np.array([0.0, 0.04, 0.16, 0.36, 0.64, 1.0])
_PRESENT = np.array([0.0, 0.1, 0.25, 0.5, 1.0])
_VOLUMES = np.array([0.0, 3e-4, 1e-3, 3e-3, 0.01, 0.03, 0.07, 0.15, 0.3, 0.6, 1.0])

#: Tangential over normal compliance of the solver's layer, and its engagement pressure.
SHEAR_RATIO, ENGAGEMENT_MPa = RoughLayer(0.0).shear_ratio, RoughLayer(0.0).engagement_pressure_MPa

#: Points of a layer's law that are computed, and the lowest over the highest of its pressures.
_POINTS, _LOWEST = 160, 1e-6

#: Least growth of the volume at a step: a foundation that yields to it wears like a stiffer one within a few per cent.
_LEAST_GROWTH = 0.005


#: Half the grid's width over the radius of the largest scar, and the least such radius.
_MARGIN, _LEAST_RADIUS = 1.08, 1.0

#: Flattenings, prints' approaches and worn volumes that are followed, as shares of the deepest and of the largest.
_FLATTENINGS = np.array([0.0, 0.04, 0.12, 0.3, 0.6, 1.0])
_PRINTS = np.array([0.0, 0.04, 0.12, 0.2, 0.4, 1.0])
_FLAT_VOLUMES = np.array([0.0, 0.0025, 0.0075, 0.018, 0.036, 0.07, 0.14, 0.26, 0.48, 1.0])

#: Prints are followed on a grid so much finer, where so many steps find the load within a share; they are worn off by
#: scars wider by a factor.
_FINER, _PRINT_STEPS, _PRINT_TOLERANCE, _SLID_WIDER = 3, 30, 1e-3, 1.2
#: Stiffness of a fresh contact's foundation that has Hertz's load and radius together, over that of `foundation`.
_FRESH = 16.0 / (3.0 * np.pi)

#: Power of the worn volume with which wear weighs in what a scar remembers of a layer: that which leaves least of the
#: change of slopes of wires worn under six layers that wear in (`python -m studies.diagnosis.layer_memory`).
LAYER_MEMORY = 2.0

#: The largest volume over that of the deepest flat: by then little is left of it.
_OUTWORN = 4.0


@dataclass(frozen=True)
class LayeredCase:
    """Case for which a table of changes by rough layers is computed; dimensionless, with slip amplitude δ and wires'
    radius R.

    fresh_radius: radius of the unworn contact over δ. stroke: over δ. highest: largest layer height over δ²/R.
    engagement: p_c δ²/P, P the load. most_worn: largest V R/δ⁴. moving_share: share of the wear that the moving wire
    loses. along: curvature of the gap along the motion over that across.
    """

    fresh_radius: float
    stroke: float
    highest: float
    engagement: float
    most_worn: float
    moving_share: float
    along: float = 1.0


@dataclass(frozen=True, eq=False)
class LayeredWires:
    """Changes of loops and scars by layers of given height, between wires that wore under layers.

    heights: (k,) s R/δ² under which the scar was worn, the first 0. present: (j,) height now over the one worn under.
    volumes: (n,) V R/δ⁴ of both wires.
    """

    heights: Array
    present: Array
    volumes: Array
    #: (k, j, n, m + 3) slope of θ in δ/R at m positions from mid-stroke to an end, logarithm of the contact's radius,
    #: approach of the wires in δ²/R, and the layer's mean closure over its height, which is no change.
    loops: Array
    #: (k, n, 6) depths of the moving and of the fixed wire's scar in δ²/R, and logarithms of their lengths and widths,
    #: wire by wire.
    scars: Array

    def at(self, worn_under: Array, height: Array, similarity: Array) -> Array:
        """Rows (n, m + 3) of `loops`, interpolated at n moments. worn_under: layer height under which the scar was
        worn. height: the present one, both over δ²/R. similarity: V R/δ⁴. All (n,).
        """
        under = np.maximum(worn_under, height)
        share = np.divide(height, under, out=np.zeros_like(height), where=under > 0.0)
        return np.asarray(self._of_loops(np.stack([self._height(under), share, self._volume(similarity)], axis=-1)))

    def scar(self, worn_under: float, similarity: float) -> tuple[Array, Array]:
        """Changes of depths (2,) in δ²/R, and of the logarithms of lengths and widths (2, 2), of the moving and the
        fixed scar. worn_under: layer height over δ²/R under which the scars were worn. similarity: V R/δ⁴.
        """
        where = np.array([self._height(np.array(worn_under)), self._volume(np.array(similarity))])
        found = self._of_scars(where)[0]
        return found[:2], found[2:].reshape(2, 2)

    def _height(self, height: Array) -> Array:
        return np.asarray(np.minimum(height, self.heights[-1]))

    def _volume(self, similarity: Array) -> Array:
        return np.asarray(np.log(np.minimum(similarity, self.volumes[-1]) + self.volumes[1]))

    @cached_property
    def _of_loops(self) -> RegularGridInterpolator:
        axes = self._height(self.heights), self.present, self._volume(self.volumes)
        return RegularGridInterpolator(axes, self.loops, bounds_error=False, fill_value=None)

    @cached_property
    def _of_scars(self) -> RegularGridInterpolator:
        axes = self._height(self.heights), self._volume(self.volumes)
        return RegularGridInterpolator(axes, self.scars, bounds_error=False, fill_value=None)


def remembered(height: Array, worn: Array, power: float) -> Array:
    """Effective layer height (n,) under which a scar was worn: mean of heights (n,) over the worn volume raised to
    `power`. worn: (n,) volumes, which do not decrease. Before the first volume the height is taken to be constant.
    """
    total = worn**power
    weights = np.diff(total, prepend=0.0)
    middle = 0.5 * (height + np.concatenate([height[:1], height[:-1]]))
    return np.asarray(np.divide(np.cumsum(weights * middle), total, out=height.copy(), where=total > 0.0))


@lru_cache(maxsize=16)
def layered_wires(case: LayeredCase) -> LayeredWires:
    """How layers or flattening change the wear of wires in a case: kept in memory and on disk, else computed in about a
    second.
    """
    identity = identity_of(vars(case), ("wirewear/diagnosis/surrogate",), {})

    def made(folder: Path) -> tuple[LayeredWires, Path]:
        table, path = _made(case), folder / "layers.npz"
        with path.open("wb") as file:
            np.savez(file, **{field.name: getattr(table, field.name) for field in fields(table)})
        return table, path

    return kept_or_made(f"layers-{identity.name}.npz", _read, made)[0]


def _read(path: Path) -> LayeredWires:
    try:
        with np.load(path) as file:
            return LayeredWires(**{field.name: file[field.name] for field in fields(LayeredWires)})
    except (OSError, ValueError, KeyError) as problem:
        raise ResultError(f"{path} cannot be read: {problem}") from problem


def _made(case: LayeredCase) -> LayeredWires:
    heights, volumes = case.highest * _HEIGHTS, case.most_worn * _VOLUMES
    # Approach of rigid unworn wires with the highest layer: 2π p_c (s (exp(w/s) − 1) − w)/√along is the load.
    load = case.along**0.5 / (2.0 * np.pi * case.engagement * case.highest)
    closure = case.highest * float(brentq(lambda share: np.expm1(share) - share - load, 0.0, np.log1p(load) + 2.0))
    # The fourth power of a radius is what wear takes for it, over a number.
    worn = 4.0 * case.most_worn * case.along**0.5 / np.pi
    radius = max((worn + (2.0 * closure) ** 2) ** 0.25, _LEAST_RADIUS)
    wires = WornWires.unworn(heights.size, _MARGIN * radius + 0.5 * case.fresh_radius, case.along)
    guess = 0.1 * case.fresh_radius**2 + closure * _HEIGHTS[:, None] ** 0.5 + np.zeros(wires.s.size)
    pressing = partial(pressing_layers, heights=heights, engagement=case.engagement)
    loops, marks = [], []
    for volume, now in zip(
        volumes.tolist(),
        wearing(wires, volumes, case.fresh_radius, guess, case.moving_share, pressing, _LEAST_GROWTH),
        strict=True,
    ):
        loops.append(np.stack([_under(wires, now, share * heights, volume, case) for share in _PRESENT], axis=1))
        figures = scars(wires)
        marks.append(np.concatenate([figures[:, :, 1], figures[:, :, 2:].reshape(-1, 4)], axis=1))
    along, scar = np.stack(loops, axis=2), np.stack(marks, axis=1)
    # Before any wear there is no scar to compare with.
    scar[:, 0, 2:] = scar[:, 1, 2:]
    scar[:, :, 2:] = np.log(scar[:, :, 2:])
    along[..., :-1] -= along[:1, ..., :-1].copy()
    return LayeredWires(heights, _PRESENT, volumes, along, scar - scar[:1])


def _under(wires: WornWires, worn: Worn, heights: Array, volume: float, case: LayeredCase) -> Array:
    """What `LayeredWires` hold of loops (k, m + 3), not yet as changes, of worn wires under layers of heights (k,)."""
    radius, approach = worn.radius, worn.approach
    # How often a contact's radius and its pressures are found in turn for another height.
    for _ in range(2):
        pressing = pressing_layers(
            foundation(case.fresh_radius, radius, _LEAST_GROWTH * volume), heights, case.engagement
        )
        part, pressure, approach = equilibrium(wires, pressing, approach)
        radius = contact_radius(part, pressure)
    closed = np.einsum("kysx,kysx,y->k", pressure, np.log1p(pressure / case.engagement), part.areas) / wires.s.size
    return np.column_stack([slopes(part, pressure), np.log(radius), approach.mean(axis=1), closed])


def pressing_layers(stiffness: Array, heights: Array, engagement: float) -> Pressing:
    """A function from overlaps (k, y, s, x) to pressures and their derivative, of foundations of stiffnesses (k,) under
    layers of heights (k,). engagement: pressure p_c at which a layer closes, see the module's head; all dimensionless.
    """
    return partial(_pressures, stiffness=stiffness, heights=heights, engagement=engagement)


def _pressures(overlap: Array, stiffness: Array, heights: Array, engagement: float) -> tuple[Array, Array]:
    pressure, derivative = np.zeros((2, *overlap.shape))
    shares = np.concatenate([[0.0], np.geomspace(_LOWEST, 1.0, _POINTS)])
    for own, stiff, height, into, change in zip(overlap, stiffness, heights, pressure, derivative, strict=True):
        known = shares * stiff * max(float(own.max()), _LOWEST)
        closed = known / stiff + height * np.log1p(known / engagement)
        into[...] = np.interp(np.maximum(own, 0.0), closed, known)
        change[...] = np.where(own > 0.0, 1.0 / (1.0 / stiff + height / (into + engagement)), 0.0)
    return pressure, derivative


@dataclass(frozen=True, eq=False)
class FlatteningChange:
    """Changes of loops and scars at n moments by flattening of the wires before any wear."""

    slope: Array  #: (n, m) change of θ in δ/R at the `positions` of `FlattenedWires`.
    stiffness: Array  #: (n,) change of the logarithm of the contact's stiffness.
    approach: Array  #: (n,) in δ²/R, by which the wires came nearer through wear.
    depth: Array  #: (n, 2) in δ²/R, of the moving and of the fixed wire's scar.
    extent: Array  #: (n, 2, 2) change of the logarithms of length and width, by wire.
    volume: Array  #: (n, 2) in δ⁴/R, taken by the flattening itself, by wire.


@dataclass(frozen=True, eq=False)
class FlattenedWires:
    """Table of changes by flattening.

    flattenings: (k,) approach h R/δ² of the unworn wires, the first 0. volumes: (n,) V R/δ⁴ worn since. positions: (m,)
    s/δ from 0 to 1. table: arrays (k, n, …) for the fields of `FlatteningChange`.
    """

    flattenings: Array
    volumes: Array
    positions: Array
    table: FlatteningChange

    def at(self, flattening: Array, before: Array | float = 0.0, *, similarity: Array) -> FlatteningChange:
        """The changes at n moments from flattening `before` to `flattening`, h R/δ² (n,), at similarity V R/δ⁴ (n,);
        larger flattenings count as the largest.
        """
        late = np.maximum(similarity / self.volumes[-1], 1.0)
        worn = np.log(similarity / late + self.volumes[1])
        flattened = np.minimum(np.broadcast_arrays(flattening, before), self.flattenings[-1])
        after, first = self._changes(np.stack([flattened, np.broadcast_to(worn, flattened.shape)], axis=-1))
        kept = {one.name: getattr(self.table, one.name).shape[2:] for one in fields(self.table)}
        ends = np.cumsum([prod(shape) for shape in kept.values()])[:-1]
        columns = zip(kept.items(), np.split(after - first, ends, axis=1), strict=True)
        found = FlatteningChange(**{name: column.reshape(-1, *shape) for (name, shape), column in columns})
        # Past the largest volume, what is left fades as the scar grows.
        return replace(
            found,
            slope=found.slope / late[:, None],
            stiffness=found.stiffness / late,
            extent=found.extent / late[:, None, None],
        )

    @cached_property
    def _changes(self) -> RegularGridInterpolator:
        """All fields of the table side by side, over flattening and logarithm of volume; round-off may lead past an
        end.
        """
        axes = self.flattenings, np.log(self.volumes + self.volumes[1])
        columns = [getattr(self.table, one.name) for one in fields(self.table)]
        together = np.concatenate([one.reshape(*one.shape[:2], -1) for one in columns], axis=2)
        return RegularGridInterpolator(axes, together, bounds_error=False, fill_value=None)


@lru_cache(maxsize=16)
def flattened_wires(
    fresh_radius: float, stroke: float, deepest: float, moving_share: float = 0.5, along: float = 1.0, *, slid: bool
) -> FlattenedWires:
    """Table of changes by flattenings h R/δ² from 0 to `deepest`.

    fresh_radius, stroke: radius of the unworn contact and stroke to either side, in slip amplitudes. moving_share:
    share of the wear that the moving wire loses. along: curvature of the gap along the motion over that across. slid:
    True for the prints of bodies that yield as they slide, by the approach that pressing alone keeps.
    """
    flattenings = deepest * (_PRINTS if slid else _FLATTENINGS)
    wires, limit = (_printed if slid else _flattened)(flattenings, stroke, fresh_radius, along)
    press = elastic if limit is None else partial(limited, limit=limit)
    volumes = _OUTWORN * float(wires.volumes[-1].sum()) * _FLAT_VOLUMES
    guess = flattenings[:, None] + 0.1 * fresh_radius**2 + np.zeros(wires.s.size)
    kept = []
    held = fresh_radius, guess, moving_share, lambda own: partial(press, stiffness=own), 0.0, limit
    for volume, now in zip(volumes, wearing(wires, volumes, *held), strict=True):
        figures = scars(wires)
        flats = wires.volumes - volume * np.array([moving_share, 1.0 - moving_share])
        of_loops = slopes(now.part, now.pressure), now.radius, now.approach.mean(axis=1)
        kept.append((*of_loops, figures[:, :, 1], figures[:, :, 2:], flats))
    slope, size, near, depth, extent, flats = (np.stack(column, axis=1) for column in zip(*kept, strict=True))
    near = near - near[:, :1]
    # Before any wear there is no scar to compare with.
    extent[:, 0] = extent[:, 1]
    change = FlatteningChange(
        slope - slope[:1],
        np.log(size / size[:1]),
        near - near[:1],
        depth - depth[:1],
        np.log(extent / extent[:1]),
        flats - flats[:1],
    )
    return FlattenedWires(flattenings, volumes, wires.s, change)


def _flattened(flattenings: Array, stroke: float, fresh_radius: float, along: float) -> tuple[WornWires, None]:
    """Unworn wires, flattened by half the overlap of their unworn shapes wherever they meet during the stroke, and no
    limits of their pressures.
    """
    wires = WornWires.unworn(flattenings.size, _extent(float(flattenings[-1]), stroke, fresh_radius, along), along)
    overlap = flattenings[:, None, None] - 0.5 * wires.y[:, None] ** 2
    past = np.maximum(np.abs(wires.moving_x) - stroke, 0.0)
    fixed, moving = (0.5 * np.maximum(overlap - 0.5 * along * x**2, 0.0) for x in (wires.x, past))
    return replace(wires, fixed=fixed, moving=moving), None


def _extent(deepest: float, stroke: float, fresh_radius: float, along: float) -> float:
    """Half the width of a grid of wires that outwear flats of this approach."""
    flat = (2.0 * deepest) ** 1.5 * stroke / 1.5 + np.pi * deepest**2 / along**0.5
    return float(_MARGIN * (4.0 * (1.0 + _OUTWORN) * flat * along**0.5 / np.pi) ** 0.25 + 0.5 * fresh_radius)


def _printed(kept: Array, stroke: float, fresh_radius: float, along: float) -> tuple[WornWires, Array]:
    """Unworn wires with the prints of pressing and sliding to and fro, and the limits (k,) of pressures of later wear.

    kept: (k,) approaches that pressing alone keeps. On fresh metal the front half of the contact bears the load, so
    that sliding goes on printing (Bowden & Tabor, The Friction and Lubrication of Solids (1950)); each wire takes half.
    """
    extent = _SLID_WIDER * _extent(float(kept[-1]), stroke, fresh_radius, along)
    wires, fine = (WornWires.unworn(kept.size, extent, along, finer) for finer in (1, _FINER))
    stiffness = _FRESH * foundation(fresh_radius, np.sqrt(fresh_radius**2 + 2.0 * kept))
    limit = np.array([_limit_of(own, 1.5 / (np.pi * fresh_radius**2)) for own in kept.tolist()])
    places, own, most = fine.s.size - 1, stiffness[:, None, None], limit[:, None, None]
    grid_area = float(fine.areas.sum()) * fine.x.size
    unworn, approach = 0.5 * (along * fine.x**2 + fine.y[:, None] ** 2), kept + 0.1 * fresh_radius**2
    for at in [*range(places), *range(places, -places, -1), *range(-places, places + 1)]:
        moving = fine.moving[:, :, places + at : places + at + fine.x.size]
        gap = unworn + fine.fixed + moving
        # Where all that touches is at the limit, Newton's step has no length: the middle of what holds the root has.
        low, high = gap.min(axis=(1, 2)), gap.max(axis=(1, 2)) + 1.0 / (stiffness * grid_area)
        for _ in range(_PRINT_STEPS):
            pressure = own * np.maximum(approach[:, None, None] - gap, 0.0)
            rising = own * ((pressure > 0.0) & (pressure < most))
            load, rim = (np.einsum("kyx,y->k", one, fine.areas) for one in (np.minimum(pressure, most), rising))
            if float(np.abs(load - 1.0).max()) < _PRINT_TOLERANCE:
                break
            low, high = np.where(load < 1.0, approach, low), np.where(load < 1.0, high, approach)
            approach = approach - (load - 1.0) / np.maximum(rim, 1e-9)
            approach = np.where((low < approach) & (approach < high), approach, 0.5 * (low + high))
        closed = 0.5 * np.maximum(pressure - most, 0.0) / own
        fine.fixed[...] += closed
        moving += closed
    for of_wires, found in ((wires.fixed, fine.fixed), (wires.moving, fine.moving)):
        of_wires[...] = 0.5 * (found + found[:, :, ::-1])[:, ::_FINER, ::_FINER]
    return wires, limit


def _limit_of(kept: float, peak: float) -> float:
    """Limit of pressures under which bodies keep an approach (`reference.kept_approach`); peak: the elastic contact's
    largest pressure.
    """
    if kept == 0.0:
        return 1e9
    return float(brentq(lambda limit: (1.0 - (limit / peak) ** 1.5) / (2.0 * np.pi * limit) - kept, 1e-6, peak))
