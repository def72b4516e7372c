"""Worn depth from a profilometer's height map of a wire: the unworn cylinder is fitted and subtracted."""

from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

from wirewear.errors import RecordError
from wirewear.records.importing.height_maps import height_map
from wirewear.records.importing.mapping import ScarSource
from wirewear.records.values import Array, MeasuredScar

#: Points that the fitted cylinder is sought on, at most; a map has often millions.
MOST_POINTS = 20_000

#: Fewer points tell no cylinder.
FEWEST_POINTS = 100


def scar_of_map(file: Path, source: ScarSource, wire: str, repeat: int, diameter_mm: float) -> MeasuredScar:
    """The scar of a height map in any format that SurfaceTopography reads; the origin is put at the scar's middle.

    Raises:
        RecordError: SurfaceTopography cannot read the file, or the map lacks its size or unit.
    """
    return _scar(file, source, wire, repeat, diameter_mm, *height_map(file))


def scar_of_heights(
    file: Path, source: ScarSource, wire: str, repeat: int, diameter_mm: float, points: tuple[Array, Array, Array]
) -> MeasuredScar:
    """The scar of points x, y, height (n,) in µm; points off a grid are laid on one as dense as they are.

    Raises:
        RecordError: the points are too few, or lie beyond the wire.
    """
    x, y, height = (values[np.isfinite(points[0] + points[1])] for values in points)
    if x.size < FEWEST_POINTS:
        raise RecordError(f"{file}: a scar's map of heights needs {FEWEST_POINTS} points, not {x.size}.")
    try:
        grid = MeasuredScar.from_points(repeat, wire, x, y, height)
    except RecordError:
        return _scar(file, source, wire, repeat, diameter_mm, *_gridded(x, y, height))
    return _scar(file, source, wire, repeat, diameter_mm, grid.x_um, grid.y_um, np.array(grid.depth_um))


def _gridded(x: Array, y: Array, height: Array) -> tuple[Array, Array, Array]:
    """Points (n,) interpolated onto a grid that has about as many; NaN outside of what they enclose."""
    from scipy.interpolate import griddata

    known = np.isfinite(height)
    x, y, height = x[known], y[known], height[known]
    step = float(np.sqrt(np.ptp(x) * np.ptp(y) / x.size))
    lines = [np.linspace(v.min(), v.max(), max(int(np.ptp(v) / step), 2)) for v in (x, y)]
    places = np.meshgrid(*lines, indexing="ij")
    return lines[0], lines[1], np.asarray(griddata((x, y), height, tuple(places)))


def _scar(
    file: Path, source: ScarSource, wire: str, repeat: int, diameter_mm: float, x: Array, y: Array, height: Array
) -> MeasuredScar:
    x, y = x - 0.5 * (x[0] + x[-1]), y - 0.5 * (y[0] + y[-1])
    if source.axis == "y":
        # Turned by a quarter about the normal, so that the wire's axis lies along the map's x.
        x, y, height = y, -x[::-1], height[::-1].T
    if source.subtract_wire:
        height, middle = _unrolled(file, x, y, height, 500.0 * diameter_mm)
        y = y - middle
    depth = np.where(np.isfinite(height), np.maximum(-height, 0.0), np.nan)
    weight = np.nan_to_num(depth) ** 2
    x = x - float((weight.sum(axis=1) @ x) / weight.sum()) if weight.sum() > 0.0 else x
    if wire == "fixed":
        # The fixed wire runs across the motion: its axis is y in the record.
        x, y, depth = -y[::-1], x, depth[:, ::-1].T
    return MeasuredScar(repeat, wire, np.ascontiguousarray(x), np.ascontiguousarray(y), np.ascontiguousarray(depth))


def _unrolled(file: Path, x: Array, y: Array, height: Array, radius_um: float) -> tuple[Array, float]:
    """Height above the unworn cylinder (axis near x), and the y of its crown.

    Least squares with a loss that counts points far below the surface for little: what is worn does not pull the fit.
    """
    known = np.flatnonzero(np.isfinite(height.ravel()))
    if known.size < FEWEST_POINTS or np.ptp(y) > 1.9 * radius_um:
        raise RecordError(
            f"{file}: the map must lie within the wire's width, {2.0 * radius_um:g} µm, and hold "
            f"{FEWEST_POINTS} points."
        )
    chosen = known[:: max(known.size // MOST_POINTS, 1)]
    grid_x, grid_y = np.meshgrid(x, y, indexing="ij")
    at_x, at_y, z = grid_x.ravel()[chosen], grid_y.ravel()[chosen], height.ravel()[chosen]
    extent = np.array([1.0, float(np.ptp(y)), 1.0 / float(np.ptp(x)), float(np.ptp(y)) / float(np.ptp(x))])

    def cylinder(parameters: Array, px: Array, py: Array) -> Array:
        top, crown, tilt, turn = parameters * extent
        across = np.clip(py - crown - turn * px, -radius_um, radius_um)
        surface: Array = top + tilt * px + np.sqrt(radius_um**2 - across**2) - radius_um
        return surface

    start = np.array([float(np.nanpercentile(z, 99)), 0.0, 0.0, 0.0])
    fit = least_squares(lambda p: z - cylinder(p, at_x, at_y), start, loss="cauchy", f_scale=1.0)
    fit = least_squares(lambda p: z - cylinder(p, at_x, at_y), fit.x, loss="cauchy", f_scale=0.2)
    return height - cylinder(fit.x, grid_x, grid_y), float(fit.x[1] * extent[1])
