"""Worn depth from a height profile across a scar: the unworn face is fitted, level and tilted, and subtracted."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from geometry import Cylinder, Flat
from wirewear.base.errors import RecordError
from wirewear.planar.tables import Face
from wirewear.records.importing.profilometry import ABOUT, LEAST_UNWORN, deviation
from wirewear.records.line_values import Array, MeasuredProfile

#: Fewer points tell no face.
FEWEST_POINTS = 20

#: Shares of a profile at either end that are taken to be unworn at first.
MARGIN = 0.15


@dataclass(frozen=True, eq=False)
class LevelledProfile:
    """A profile with what it was made of: heights (n,) and the fitted face (n,) in µm, None where depths were given."""

    profile: MeasuredProfile
    height_um: Array | None = None
    face_um: Array | None = None


def levelled(
    file: Path, repeat: int, body: str, face: Face | Flat, heights: tuple[Array, Array], *, subtract: bool
) -> LevelledProfile:
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
    return LevelledProfile(MeasuredProfile(repeat, body, x - scar, depth), height, fitted)


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
