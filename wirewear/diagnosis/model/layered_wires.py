"""What a rough layer changes of the wear states: two wires that wear on an elastic foundation with the layer on it.

A soft layer spreads the pressure, so that a wider and shallower groove is worn, whose slopes grow evenly along the
stroke. The walls at its ends stay away, and outlive the layer for a while. The layer closes by s ln(1 + p/p_c) under a
pressure p (`solvers.RoughLayer`), and only the difference from wires without it is used. What a scar remembers is one
height: the mean of those under which it was worn, late wear weighing more. Lengths are in slip amplitudes δ, depths and
heights in δ²/R.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property, lru_cache, partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RegularGridInterpolator
from scipy.optimize import brentq

from solvers import RoughLayer
from wirewear.base.errors import ResultError
from wirewear.base.identity import identity_of
from wirewear.diagnosis.model.nominal import kept_or_made
from wirewear.diagnosis.model.worn_wires import (
    Pressing,
    Worn,
    WornWires,
    contact_radius,
    equilibrium,
    foundation,
    scars,
    slopes,
    wearing,
)

Array = NDArray[np.float64]

#: Heights under which a scar is worn, as shares of the highest; heights then present, as shares of these; and volumes.
_HEIGHTS = np.array([0.0, 0.04, 0.16, 0.36, 0.64, 1.0])
_PRESENT = np.array([0.0, 0.1, 0.25, 0.5, 1.0])
_VOLUMES = np.array([0.0, 3e-4, 1e-3, 3e-3, 0.01, 0.03, 0.07, 0.15, 0.3, 0.6, 1.0])

#: Tangential over normal compliance of the solver's layer, and its engagement pressure.
SHEAR_RATIO, ENGAGEMENT_MPa = RoughLayer(0.0).shear_ratio, RoughLayer(0.0).engagement_pressure_MPa

#: Points of a layer's law that are computed, and the lowest over the highest of its pressures.
_POINTS, _LOWEST = 160, 1e-6

#: Least growth of the volume at a step: a foundation that yields to it wears like a stiffer one within a few per cent.
_GROWTH = 0.005

#: How often a contact's radius and its pressures are found in turn for another height.
_SWEEPS = 2

#: Half the grid's width over the radius of the largest scar, and the least such radius.
_MARGIN, _LEAST_RADIUS = 1.08, 1.0


@dataclass(frozen=True)
class LayeredCase:
    """What such a table depends on: radius of the fresh contact and stroke in slip amplitudes, the highest layer in
    δ²/R, p_c δ²/P, the largest V R/δ⁴, and the moving wire's share of the wear.
    """

    fresh_radius: float
    stroke: float
    highest: float
    engagement: float
    most_worn: float
    moving_share: float


@dataclass(frozen=True, eq=False)
class LayeredWires:
    """Changes by layers of `heights` s R/δ² (k), the first of none, under which both wires wore volumes V R/δ⁴ (n).

    What is then `present` of a layer, as a share of its height (j,), presses the worn wires.

    Attributes:
        loops: (k, j, n, m + 3) slope of θ in δ/R at m positions from mid-stroke to an end, logarithm of the contact's
            radius, approach of the wires in δ²/R, and the layer's mean closure over its height, which is no change.
        scars: (k, n, 6) depths of the moving and of the fixed wire's scar in δ²/R, and logarithms of their lengths and
            widths, wire by wire.
    """

    heights: Array
    present: Array
    volumes: Array
    loops: Array
    scars: Array

    def at(self, worn_under: Array, height: Array, similarity: Array) -> Array:
        """What `loops` hold (n, m + 3) at heights (n,) under which the scar was worn, present heights, and V R/δ⁴."""
        under = np.maximum(worn_under, height)
        share = np.divide(height, under, out=np.zeros_like(height), where=under > 0.0)
        return np.asarray(self._of_loops(np.stack([self._height(under), share, self._volume(similarity)], axis=-1)))

    def scar(self, worn_under: float, similarity: float) -> tuple[Array, Array]:
        """Changes of the scars' depths (2,), and of the logarithms of their lengths and widths (2, 2)."""
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
    """The height (n,) under which a scar was worn: the mean of those at volumes (n,), which do not fall, to a power.

    Before the first volume the layer was as it is there.
    """
    total = worn**power
    weights = np.diff(total, prepend=0.0)
    middle = 0.5 * (height + np.concatenate([height[:1], height[:-1]]))
    return np.asarray(np.divide(np.cumsum(weights * middle), total, out=height.copy(), where=total > 0.0))


@lru_cache(maxsize=16)
def layered_wires(case: LayeredCase) -> LayeredWires:
    """The table of a case, from the cache or made now, in about a second."""
    identity = identity_of(vars(case), ("wirewear/diagnosis/model",), {})

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
    closure = _closure(case)
    # The fourth power of a radius is what wear takes for it, over a number.
    radius = max((4.0 * case.most_worn / np.pi + (2.0 * closure) ** 2) ** 0.25, _LEAST_RADIUS)
    wires = WornWires.unworn(heights.size, _MARGIN * radius + 0.5 * case.fresh_radius)
    guess = 0.1 * case.fresh_radius**2 + closure * _HEIGHTS[:, None] ** 0.5 + np.zeros(wires.s.size)
    pressing = partial(pressing_layers, heights=heights, engagement=case.engagement)
    loops, marks = [], []
    for volume, now in zip(
        volumes.tolist(),
        wearing(wires, volumes, case.fresh_radius, guess, case.moving_share, pressing, _GROWTH),
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


def _closure(case: LayeredCase) -> float:
    """Approach of rigid unworn wires with the highest layer: 2π p_c (s (exp(w/s) − 1) − w) is the load."""
    load = 1.0 / (2.0 * np.pi * case.engagement * case.highest)
    return case.highest * float(brentq(lambda share: np.expm1(share) - share - load, 0.0, np.log1p(load) + 2.0))


def _under(wires: WornWires, worn: Worn, heights: Array, volume: float, case: LayeredCase) -> Array:
    """What `LayeredWires` hold of loops (k, m + 3), not yet as changes, of worn wires under layers of heights (k,)."""
    radius, approach = worn.radius, worn.approach
    for _ in range(_SWEEPS):
        pressing = pressing_layers(foundation(case.fresh_radius, radius, _GROWTH * volume), heights, case.engagement)
        part, pressure, approach = equilibrium(wires, pressing, approach)
        radius = contact_radius(part, pressure)
    closed = np.einsum("kysx,kysx,y->k", pressure, np.log1p(pressure / case.engagement), part.areas) / wires.s.size
    return np.column_stack([slopes(part, pressure), np.log(radius), approach.mean(axis=1), closed])


def pressing_layers(stiffness: Array, heights: Array, engagement: float) -> Pressing:
    """How overlaps press foundations of stiffnesses (k,) with layers of heights (k,)."""
    return partial(_pressures, stiffness=stiffness, heights=heights, engagement=engagement)


def _pressures(overlap: Array, stiffness: Array, heights: Array, engagement: float) -> tuple[Array, Array]:
    pressure, derivative = np.zeros((2, *overlap.shape))
    shares = np.concatenate([[0.0], np.geomspace(_LOWEST, 1.0, _POINTS)])
    for own, elastic, height, into, change in zip(overlap, stiffness, heights, pressure, derivative, strict=True):
        known = shares * elastic * max(float(own.max()), _LOWEST)
        closed = known / elastic + height * np.log1p(known / engagement)
        into[...] = np.interp(np.maximum(own, 0.0), closed, known)
        change[...] = np.where(own > 0.0, 1.0 / (1.0 / elastic + height / (into + engagement)), 0.0)
    return pressure, derivative
