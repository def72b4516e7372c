"""Scars and loops interpolated to finer grids, so that pictures show surfaces and not elements.

Between grid points a field follows monotone cubics (F. N. Fritsch & R. E. Carlson, SIAM J. Numer. Anal. 17 (1980) 238),
along one axis after the other: smooth, through every computed value, and never beyond its neighbours. Where a field
falls to zero between two grid points, it is extrapolated from inside to find its edge: a depth like a bent thin plate,
other fields linearly.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import scipy
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import spsolve

from geometry.arrays import Array, BoolArray
from wirewear.results import Loop, Scar
from wirewear.results.scar import FIELD_COLUMNS, FURTHER_COLUMNS

MOST_LOOPS = 6

#: Points along a smooth loop, beside its samples; loops of fewer samples are drawn as they are.
POINTS, CLOSED_FROM = 400, 5

Mask = BoolArray
MaskedField = np.ma.MaskedArray[tuple[int, ...], np.dtype[np.float64]]

RINGS = 2  #: Rings of points around the area that get a value.
_RIDGE = 1e-10  #: What keeps points determined that no difference reaches, as a share of the largest weight.
_THIN = -0.1  #: Smoothed by a point, ±1 within and without an area: rings of one point have −0.23, right corners −0.05.
_LEAST_SHARE = 0.01  #: What lies below this share of the largest pressure or slip is drawn as nothing.

# A scar's edge lies between a ninth and nearly all of the way from its last point: the depth is taken to go on from
# there to minus this many times its value at the next point.
_BELOW = (0.05, 8.0)


_NEIGHBOURS = [(a, t) for a in (-1, 0, 1) for t in (-1, 0, 1) if (a, t) != (0, 0)]


def chosen_cycles(logged: Sequence[int], most: int = MOST_LOOPS) -> tuple[int, ...]:
    """At most `most` of the logged cycles: all, or first, last and the powers of ten between, thinned evenly."""
    cycles = sorted(set(logged))
    decades = [c for c in cycles if 10 ** round(np.log10(max(c, 1))) == c]
    wanted = cycles if len(cycles) <= most else sorted({cycles[0], *decades, cycles[-1]})
    places = np.unique(np.linspace(0, len(wanted) - 1, min(most, len(wanted))).round().astype(int))
    return tuple(wanted[place] for place in places)


def smooth_loop(loop: Loop, points: int = POINTS) -> tuple[Array, Array]:
    """(displacement in µm, force in N) along the closed loop through all of its samples, see `smooth_curve`."""
    return smooth_curve(loop.displacement_um, loop.tangential_force_N, points)


def smooth_curve(displacement_um: Array, force: Array, points: int = POINTS) -> tuple[Array, Array]:
    """(displacement, force) along a closed smooth loop through all samples (n,), at `points` places or more, the last
    one the first. Monotone cubics over the length along the loop, never beyond neighbouring samples; a loop of fewer
    than CLOSED_FROM samples is only closed.
    """
    x, q = (np.append(values, values[0]) for values in (displacement_um, force))
    # Slopes of forces that next to no friction leaves would not be finite.
    widths = [float(np.ptp(values)) or 1.0 for values in (x, q)]
    parts = [values / width for values, width in zip((x, q), widths, strict=True)]
    lengths = np.hypot(*map(np.diff, parts))
    passed = np.concatenate([[True], lengths > 0.0])
    if passed.sum() < CLOSED_FROM:
        return x, q
    parts, lengths = [values[passed] for values in parts], lengths[lengths > 0.0]
    at = np.concatenate([[0.0], np.cumsum(lengths)])
    around = np.concatenate([at[-4:-1] - at[-1], at, at[-1] + at[1:4]])
    fine = np.unique(np.concatenate([np.linspace(0.0, at[-1], points), at]))
    one, other = (
        width * scipy.interpolate.PchipInterpolator(around, np.concatenate([v[-4:-1], v, v[1:4]]))(fine)
        for v, width in zip(parts, widths, strict=True)
    )
    one[-1], other[-1] = one[0], other[0]
    return one, other


def extended(first: Array, second: Array, values: Array, inside: Mask) -> Array:
    """A copy of values (n_1, n_2), extrapolated to RINGS rings of points around `inside` (n_1, n_2) like a thin plate.
    first, second: grid lines (n_1,) and (n_2,).
    """
    band = sliding_window_view(np.pad(inside, RINGS), (2 * RINGS + 1,) * 2).any(axis=(2, 3)) & ~inside
    if not inside.any() or not band.any():
        return values
    rows = sparse.vstack([_bending(first, second, inside | band, axis) for axis in (0, 1)]
                         + [_twist(first, second, inside | band)]).tocsc()  # fmt: skip
    free, known = np.flatnonzero(band), np.flatnonzero(inside)
    plate = rows[:, free]
    normal = (plate.T @ plate).tocsc()
    normal += _RIDGE * normal.diagonal().max() * sparse.eye_array(free.size, format="csc")
    whole = values.copy()
    whole.ravel()[free] = spsolve(normal, -plate.T @ (rows[:, known] @ values.ravel()[known]))
    return whole


def _bending(first: Array, second: Array, known: Mask, axis: int) -> sparse.coo_array:
    """Rows of second differences along an axis, wherever all three points are known."""
    line, along = (first, known) if axis == 0 else (second, known.T)
    index = np.arange(known.size).reshape(known.shape)
    index = index if axis == 0 else index.T
    before, after = np.diff(line)[:-1], np.diff(line)[1:]
    place, other = np.nonzero(along[:-2] & along[1:-1] & along[2:])
    low, high = 2.0 / (before * (before + after)), 2.0 / (after * (before + after))
    return _rows(
        [index[place + step, other] for step in (0, 1, 2)], [low[place], -(low + high)[place], high[place]], known.size
    )


def _twist(first: Array, second: Array, known: Mask) -> sparse.coo_array:
    """Rows of mixed differences over cells whose four corners are known, weighted as in the bending energy."""
    index = np.arange(known.size).reshape(known.shape)
    i, j = np.nonzero(known[:-1, :-1] & known[1:, :-1] & known[:-1, 1:] & known[1:, 1:])
    weight = 2.0**0.5 / (np.diff(first)[i] * np.diff(second)[j])
    corners = [index[i, j], index[i + 1, j], index[i, j + 1], index[i + 1, j + 1]]
    return _rows(corners, [weight, -weight, -weight, weight], known.size)


def _rows(points: list[NDArray[np.int_]], weights: list[Array], size: int) -> sparse.coo_array:
    count = points[0].size
    place = np.tile(np.arange(count), len(points))
    return sparse.coo_array((np.concatenate(weights), (place, np.concatenate(points))), shape=(count, size))


def smooth_scar(scar: Scar) -> Scar:
    """A scar with its worn depth on a finer grid that contains its own; other fields are zero there, and prints and
    debris are left out. The scar ends where the depth, extrapolated from inside, becomes zero.
    """
    inside, near, _ = _carried_on(scar, scar.depth_um, 0.0)
    beyond = extended(scar.axial_um, scar.transverse_um, scar.depth_um, inside)
    # A point that is hardly worn beside deep ones bounds nothing: the edge lies at it, and a bound would make a notch.
    deep = np.where(scar.depth_um > _BELOW[0] * near, scar.depth_um, 0.0)
    _, near_deep, _ = _carried_on(scar, deep, 0.0)
    lowest = np.where(near_deep > 0.0, -_BELOW[1] * near_deep, beyond)
    depth = np.where(inside, scar.depth_um, np.clip(beyond, np.minimum(lowest, 0.0), -_BELOW[0] * near))
    axial, transverse = _finer(scar.axial_um), _finer(scar.transverse_um)
    finer = np.maximum(_interpolated(scar, depth, axial, transverse), 0.0)
    fields: dict[str, Any] = dict.fromkeys(FIELD_COLUMNS, np.zeros_like(finer)) | {"depth_um": finer}
    fields |= dict.fromkeys(FURTHER_COLUMNS)
    return replace(scar, axial_um=axial, transverse_um=transverse, **fields)


def smooth_field(scar: Scar, field: str, over_um: float = 0.0) -> tuple[Array, Array, MaskedField]:
    """(finer grid lines (n_a,), (n_t,) in µm, values (n_a, n_t)) of a field of the scar, masked where it is zero.

    field: name of the attribute. over_um: length along the motion over which it is averaged. Unlike a depth, pressure
    or slip may end abruptly: the area gets a smooth outline of its own.
    """
    from scipy.ndimage import gaussian_filter, uniform_filter

    values: Array = getattr(scar, field)
    inside, near, beyond = _carried_on(scar, values, _LEAST_SHARE * float(values.max()))
    extended = np.where(inside, values, np.clip(beyond, 0.0, near))
    axial, transverse = _finer(scar.axial_um), _finer(scar.transverse_um)
    steps = [(fine.size - 1) / (values.shape[k] - 1) for k, fine in enumerate((axial, transverse))]
    area = _interpolated(scar, np.where(inside, 1.0, -1.0), axial, transverse)
    # The corners of an outline are rounded by a grid point; points that round-off alone puts on either side of it lie
    # outside.
    outside = gaussian_filter(area, steps) <= 1e-9
    # Lone points and rings of them, as a contact that sticks shows in the end, would be rounded off altogether.
    thin = inside & (gaussian_filter(np.where(inside, 1.0, -1.0), 1.0) < _THIN)
    outside &= _interpolated(scar, np.where(thin, 1.0, -1.0), axial, transverse) <= 0.0
    shown = _interpolated(scar, extended, axial, transverse)
    lengths = scar.wire_coordinates(over_um, 0.0)
    spans = zip(lengths, (axial, transverse), strict=True)
    size = [max(1, round(abs(float(length)) / float(np.median(np.diff(line))))) for length, line in spans]
    weight = uniform_filter(np.where(outside, 0.0, 1.0), size)
    mean = uniform_filter(np.where(outside, 0.0, shown), size) / np.maximum(weight, 1e-12)
    return axial, transverse, np.ma.masked_where(outside, mean)


def worn_half_extent(scars: Sequence[Scar]) -> tuple[float, float]:
    """Largest |x| and |y| in µm, along and across the motion, with more than 1 % of the largest depth of all scars; of
    unworn scars, of their grid.
    """
    least = 0.01 * max(scar.max_depth_um for scar in scars)
    half_x = half_y = 0.0
    for scar in scars:
        x, y = scar.sliding_coordinates(scar.axial_um[:, None], scar.transverse_um[None, :])
        worn = scar.depth_um > least
        if not least or not worn.any():
            worn = np.ones_like(worn)
        half_x, half_y = max(half_x, float(abs(x[worn]).max())), max(half_y, float(abs(y[worn]).max()))
    return half_x, half_y


def _finer(line: Array) -> Array:
    """Grid line (n,) with further points spread evenly between its own, at least 400 in all."""
    # Points that a picture needs along each axis of a scar's grid, at least.
    parts = int(np.ceil(400 / (line.size - 1)))
    between = line[:-1, None] + np.diff(line)[:, None] * (np.arange(parts) / parts)
    return np.append(between.ravel(), line[-1])


def _interpolated(scar: Scar, values: Array, axial: Array, transverse: Array) -> Array:
    along = scipy.interpolate.PchipInterpolator(scar.axial_um, values, axis=0)(axial)
    return np.asarray(scipy.interpolate.PchipInterpolator(scar.transverse_um, along, axis=1)(transverse))


def _carried_on(scar: Scar, values: Array, least: float) -> tuple[BoolArray, Array, Array]:
    """Three arrays (n_a, n_t): where a field exceeds `least`, and two estimates at each point from neighbours that do.

    The estimates are the mean of these neighbours, and the mean of linear extrapolations through them; 0 without any.
    """
    inside = values > least
    near, beyond, count = np.zeros_like(values), np.zeros_like(values), np.zeros_like(values)
    for step_a, step_t in _NEIGHBOURS:
        counts = _from(inside.astype(np.float64), step_a, step_t)
        neighbour = _from(values, step_a, step_t)
        slope = neighbour - _from(neighbour, step_a, step_t)
        near += counts * neighbour
        (a_near, a_far), (t_near, t_far) = _spans(scar.axial_um, step_a), _spans(scar.transverse_um, step_t)
        lengthening = np.hypot(a_near[:, None], t_near) / np.hypot(a_far[:, None], t_far)
        beyond += counts * (neighbour + slope * lengthening)
        count += counts
    count = np.maximum(count, 1.0)
    return inside, near / count, beyond / count


def _from(values: Array, step_a: int, step_t: int) -> Array:
    """Value of the neighbour at this step from each point; zero beyond the grid's edge."""
    padded = np.pad(values, 1)
    return padded[1 + step_a :, 1 + step_t :][: values.shape[0], : values.shape[1]]


def _spans(line: Array, step: int) -> tuple[Array, Array]:
    """Distances from each point to its neighbour in the direction of `step`, and from there to the next, (n,) each."""
    if step == 0:
        return np.zeros_like(line), np.zeros_like(line)
    widths = np.pad(np.diff(line), 2, mode="edge")
    place = np.arange(line.size) + 2
    return (widths[place], widths[place + 1]) if step > 0 else (widths[place - 1], widths[place - 2])
