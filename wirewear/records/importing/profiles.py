"""From a laboratory's files to the worn profiles of a line contact: levelled against the unworn face."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from geometry import Cylinder, Flat
from wirewear.base.errors import RecordError
from wirewear.planar.tables import Face
from wirewear.records.importing.height_maps import height_map
from wirewear.records.importing.mapping import PROFILOMETER, ProfileSource
from wirewear.records.importing.profilometry import ABOUT, LEAST_UNWORN, deviation
from wirewear.records.importing.sources import columns_of_levels, files_of, numbers_in_name
from wirewear.records.line_tables import LineTest
from wirewear.records.surfaces import Array, MeasuredProfile

#: Fewer points tell no face.
FEWEST_POINTS = 20

#: Shares of a profile at either end that are taken to be unworn at first.
MARGIN = 0.15


def levelled(
    file: Path, repeat: int, body: str, face: Face | Flat, heights: tuple[Array, Array], *, subtract: bool
) -> MeasuredProfile:
    """The worn depth of heights over places, both (n,) in µm, their zero at the scar's middle.

    The ends are taken to be unworn. From there the fit goes on to all points beside the scar, of which those that lie
    far off count for little: what is worn or piled up does not pull it. Along a cylinder level and tilt suffice, as a
    shift of its crown is a tilt; a flat's edges are sought, too.

    Raises:
        RecordError: there are too few points.
    """
    x, height = heights
    if x.size < FEWEST_POINTS or np.ptp(x) <= 0.0:
        raise RecordError(
            f"{file}: a profile of heights needs {FEWEST_POINTS} points beside one another, not {x.size}."
        )
    middle = 0.5 * (float(x[0]) + float(x[-1]))
    fitted = _fitted_face(face, x - middle, height) if subtract else np.zeros_like(height)
    depth = fitted - height
    weight = np.maximum(depth, 0.0) ** 2
    scar = float(weight @ x) / float(weight.sum()) if weight.any() else middle
    return MeasuredProfile(repeat, body, x - scar, depth, height, fitted)


def _fitted_face(face: Face | Flat, x: Array, height: Array) -> Array:
    """The unworn surface (n,) under heights at places x from the middle."""
    half = 0.5 * float(np.ptp(x))
    shifts = not isinstance(face, Cylinder | Flat)

    def surface(parameters: Array, at: Array) -> Array:
        level, tilt, aside = parameters
        places = 1e-3 * (at - (aside * half if shifts else 0.0))
        shape = 1e3 * face.height(np.column_stack([places, np.zeros_like(places)]))
        return np.asarray(level + tilt * at / half + shape)

    def fit(chosen: NDArray[np.bool_], start: Array, scale: float) -> Array:
        def off(parameters: Array) -> Array:
            return np.asarray(surface(parameters, x[chosen]) - height[chosen])

        return np.asarray(least_squares(off, start, loss="cauchy", f_scale=scale).x)

    ends = np.abs(x) >= (1.0 - 2.0 * MARGIN) * half
    line = np.polyfit(x[ends] / half, height[ends] - surface(np.zeros(3), x[ends]), 1)
    start = np.array([line[1], line[0], 0.0])
    rough = deviation(height[ends] - surface(start, x[ends]))
    start = fit(ends, start, rough)
    rough = deviation(height[ends] - surface(start, x[ends]))
    left, right = MeasuredProfile(0, "", x, surface(start, x) - height).edges_um
    bare = np.abs(x - 0.5 * (left + right)) > 0.5 * ABOUT * (right - left)
    # A scar that leaves too little beside it is only told from what is not worn by its depth.
    return surface(fit(bare if np.mean(bare) > LEAST_UNWORN else np.ones_like(bare), start, rough), x)


def profiles_of(source: ProfileSource, body: str, home: Path, tables: LineTest) -> Iterator[MeasuredProfile]:
    """The profiles of a body that a source's files hold, below their unworn faces.

    Raises:
        RecordError: a file cannot be read or lacks something, or a repeat is there twice.
    """
    face = dict(zip(tables.bodies, (tables.pad.profile, Flat()), strict=True))[body]
    seen: dict[int, Path] = {}
    for place, file in enumerate(files_of(source, home)):
        # Without a pattern, files stand for repeats in their order.
        repeat = numbers_in_name(file, source).get("repeat", source.repeat + place)
        for one in _profiles_in(file, source, body, face, repeat):
            number = one.repeat
            if number in seen:
                raise RecordError(
                    f"{file}: [profiles.{body}] finds repeat {number} twice, first in {seen[number].name}: "
                    "name_pattern or a column must tell them apart."
                )
            seen[number] = file
            yield one


def _profiles_in(
    file: Path, source: ProfileSource, body: str, face: Face | Flat, repeat: int
) -> Iterator[MeasuredProfile]:
    if source.kind == PROFILOMETER:
        heights = _line_of_map(file, source)
        yield levelled(file, repeat, body, face, heights, subtract=source.subtract_face)
        return
    given, columns = columns_of_levels(file, source, source.columns, f"profiles.{body}", repeat, source.step_um)
    for number in np.unique(columns["repeat"]):
        own = (columns["repeat"] == number) & np.isfinite(columns["x_um"]) & np.isfinite(columns[given])
        x, level = _in_order(columns["x_um"][own], columns[given][own])
        if x.size < 3:
            raise RecordError(f"{file}: the {body}'s profile of repeat {number:g} has fewer than three points.")
        if given == "depth_um":
            yield MeasuredProfile(int(number), body, x, level)
        else:
            yield levelled(file, int(number), body, face, (x, level), subtract=source.subtract_face)


def _in_order(x: Array, level: Array) -> tuple[Array, Array]:
    """Points by their place; of several in one place the mean."""
    places, where, count = np.unique(x, return_inverse=True, return_counts=True)
    return places, np.bincount(where, weights=level) / count


def _line_of_map(file: Path, source: ProfileSource) -> tuple[Array, Array]:
    """Places along the motion and the mean height across it, both (n,) in µm."""
    x, y, height = height_map(file, source.scale)
    if source.axis == "y":
        x, height = y, height.T
    known = np.isfinite(height)
    count = known.sum(axis=1)
    line = np.where(known, height, 0.0).sum(axis=1) / np.maximum(count, 1)
    return x[count > 0], line[count > 0]
