"""What flattening before any wear changes of the wear states that follow: two wires on an elastic foundation.

Both wires give way by half the overlap of their unworn shapes, the moving one along the whole stroke. What is left is
a contact as wide as the flat across the motion and short along it, in a groove that reaches past the slip: no hooks
at first, steep ends as soon as wear has dug into the flat, until the scar has outgrown it. Crossed wires wear by
Archard's law under the pressures of a Winkler foundation (Johnson, Contact Mechanics, 1985, section 4.3), and only the
difference from wires that were not flattened is used. Lengths are in slip amplitudes δ, depths in δ²/R.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RegularGridInterpolator

from wirewear.diagnosis.model.worn_wires import WornWires, elastic, scars, slopes, wearing

Array = NDArray[np.float64]

#: Flattenings and worn volumes that are followed, as shares of the deepest and of the largest.
_FLATTENINGS = np.array([0.0, 0.04, 0.12, 0.3, 0.6, 1.0])
_VOLUMES = np.array([0.0, 0.0025, 0.0075, 0.018, 0.036, 0.07, 0.14, 0.26, 0.48, 1.0])

#: The largest volume over that of the deepest flat: by then little is left of it.
_OUTWORN = 4.0

#: Half the grid's width over the radius of the largest scar.
_MARGIN = 1.08


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


@lru_cache(maxsize=16)
def flattened_wires(fresh_radius: float, stroke: float, deepest: float, moving_share: float = 0.5) -> FlattenedWires:
    """Changes by flattenings of up to `deepest` h R/δ² along ±`stroke`, of which the moving wire takes a share of wear.

    `fresh_radius` is that of the unworn contact; it and the stroke are in slip amplitudes.
    """
    flattenings = deepest * _FLATTENINGS
    wires = _flattened(flattenings, stroke, fresh_radius)
    flats = np.stack([(lost * wires.areas[:, None]).sum(axis=(1, 2)) for lost in (wires.moving, wires.fixed)], axis=1)
    volumes = _OUTWORN * float(flats[-1].sum()) * _VOLUMES
    guess = flattenings[:, None] + 0.1 * fresh_radius**2 + np.zeros(wires.s.size)
    kept = []
    for now in wearing(wires, volumes, fresh_radius, guess, moving_share, lambda own: partial(elastic, stiffness=own)):
        figures = scars(wires)
        kept.append(
            (slopes(now.part, now.pressure), now.radius, now.approach.mean(axis=1), figures[:, :, 1], figures[:, :, 2:])
        )
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


def _flattened(flattenings: Array, stroke: float, fresh_radius: float) -> WornWires:
    """Unworn wires, flattened by half the overlap of their unworn shapes wherever they meet during the stroke."""
    deepest = float(flattenings[-1])
    flat = (2.0 * deepest) ** 1.5 * stroke / 1.5 + np.pi * deepest**2
    extent = _MARGIN * (4.0 * (1.0 + _OUTWORN) * flat / np.pi) ** 0.25 + 0.5 * fresh_radius
    wires = WornWires.unworn(flattenings.size, extent)
    overlap = flattenings[:, None, None] - 0.5 * wires.y[:, None] ** 2
    past = np.maximum(np.abs(wires.moving_x) - stroke, 0.0)
    return replace(
        wires,
        fixed=0.5 * np.maximum(overlap - 0.5 * wires.x**2, 0.0),
        moving=0.5 * np.maximum(overlap - 0.5 * past**2, 0.0),
    )
