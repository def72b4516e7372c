"""Spikes of a map: single points that stand out, as optical profilometers give them at steep walls and dirt."""

from collections.abc import Sequence

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.ndimage import label

from geometry.arrays import Array, BoolArray, IntArray

#: A spike is beyond all points so near by more than these spread, and so many deviations of the noise.
NEAR, NEAR_ON_LINE, FAR = 3, 8, 8.0

MOST_TOGETHER = 4  #: More points beside one another are no single ones.

#: The border of a map, of so large a share of it, holds no more of what is worn than another share.
BORDER, MOST_AT_BORDER = 0.04, 0.02

FINEST_um = 1e-3  #: Nothing is known better than this of a height.


def noise_um(levels: Array) -> float:
    """Standard deviation in µm of the noise of heights (n_x, n_y), from differences between neighbouring points."""
    found = []
    for axis in (0, 1):
        # Of a straight line nothing is left in second differences, of noise √6 times its deviation.
        second = np.diff(levels, 2, axis=axis) if levels.shape[axis] > 2 else np.zeros(0)
        if (second := second[np.isfinite(second)]).size:
            found.append(1.4826 * float(np.median(np.abs(second - np.median(second)))) / np.sqrt(6.0))
    return max(min(found, default=0.0), FINEST_um)


def without_spikes(levels: Array) -> tuple[Array, BoolArray]:
    """Levels (n_x, n_y) in µm with spikes replaced by interpolation between neighbours, and marks (n_x, n_y) of the
    spikes. Missing points are NaN and stay so. A profile has n_y = 1.
    """
    least, spikes = FAR * noise_um(levels), np.zeros(levels.shape, dtype=bool)
    candidates = np.argwhere(_beyond_lines(levels, least))
    if not candidates.size:
        return levels, spikes
    reach = [0 if size == 1 else NEAR if min(levels.shape) > 1 else NEAR_ON_LINE for size in levels.shape]
    near = sliding_window_view(
        np.pad(levels, [(own, own) for own in reach], constant_values=np.nan), [2 * own + 1 for own in reach]
    )
    for part in np.array_split(candidates, len(candidates) // 10_000 + 1):
        around = np.sort(near[tuple(part.T)].reshape(len(part), -1), axis=1)  # with what is missing at the end
        known = np.isfinite(around).sum(axis=1)
        # Of the points about it, some may be spikes, too.
        cut = np.minimum(known // 4, MOST_TOGETHER)
        rows = np.arange(len(part))
        low, high = around[rows, cut], around[rows, np.maximum(known - 1 - cut, 0)]
        off, spread = levels[tuple(part.T)], np.maximum(high - low, least)
        spikes[tuple(part.T)] = (off < low - spread) | (off > high + spread)
    groups, _ = label(spikes, np.ones((3, 3)))
    spikes &= np.bincount(groups.ravel())[groups] <= MOST_TOGETHER
    bare = np.where(spikes, np.nan, levels)
    found = np.array(bare)
    for place in np.argwhere(spikes):
        between, spread = _between(bare, place, reach)
        at = tuple(place)
        spikes[at] = abs(levels[at] - between) > max(spread, least)
        found[at] = between if spikes[at] else levels[at]
    return found, spikes


def as_measured(depth_um: Array, spikes_um: Array | None) -> Array:
    """Depths in µm with the measured values of spikes put back. spikes_um: as large as depth_um, NaN where there is no
    spike; None for none at all.
    """
    return depth_um if spikes_um is None else np.where(np.isfinite(spikes_um), spikes_um, depth_um)


def border_text(share: float, where: str) -> str:
    """Sentence on the share of the worn volume that lies along the border, negative if piled up; "" if it is small.
    where: names the surface.
    """
    if abs(share) < MOST_AT_BORDER:
        return ""
    much = f"{abs(share):.1%} of what is worn" if abs(share) < 1.0 else "more than is worn in all"
    what = f"{much} lies" if share > 0.0 else f"{much} is piled up"
    return (
        f"{what} along the border of {where}, which cuts the scar off, or whose outermost points are off; a map that "
        "reaches farther beyond the scar would help, or one without those points"
    )


def spikes_text(spikes_um: Array | None, depth_um: Array, where: str) -> str:
    """Sentence on how many spikes stand out of a surface and by how much; "" if spikes_um is None. spikes_um, depth_um:
    as in `as_measured`. where: names the surface.
    """
    if spikes_um is None:
        return ""
    count = int(np.isfinite(spikes_um).sum())
    far = float(np.nanmax(np.abs(spikes_um - np.nan_to_num(depth_um))))
    return (
        f"{count} single point{'s' * (count > 1)} of {where} stand{'s' * (count == 1)} out by up to {far:.3g} µm, as "
        f"at steep walls and dirt: {'they are' if count > 1 else 'it is'} left out"
    )


def _beyond_lines(levels: Array, least: float) -> BoolArray:
    """Marks of points that stand out to the same side from both neighbours along each line."""
    found = np.zeros(levels.shape, dtype=bool)
    wide = np.pad(levels, NEAR + 1, constant_values=np.nan)
    for side in (1.0, -1.0):
        out = np.isfinite(levels)
        for axis in (axis for axis in (0, 1) if levels.shape[axis] > 1):
            for way in (1, -1):
                # What is missing shows nothing.
                near = [~(side * (levels - _beside(wide, axis, way * step)) <= least) for step in (NEAR, NEAR + 1)]
                out &= near[0] | near[1]
        found |= out
    return found


def _beside(wide: Array, axis: int, step: int) -> Array:
    """Levels `step` points farther along an axis, from levels padded by NEAR + 1 points."""
    border = NEAR + 1
    starts = [border + (step if own == axis else 0) for own in (0, 1)]
    first, second = (slice(start, start + size - 2 * border) for start, size in zip(starts, wide.shape, strict=True))
    return wide[first, second]


def _between(levels: Array, place: IntArray, reach: Sequence[int]) -> tuple[float, float]:
    """Level at the index `place` (2,) by a plane through known points around it, and the spread of these about the
    plane.
    """
    first = np.maximum(place - reach, 0)
    near = levels[tuple(slice(a, b + own + 1) for a, b, own in zip(first, place, reach, strict=True))]
    at: IntArray = np.argwhere(np.isfinite(near))
    columns, known = np.column_stack([np.ones(len(at)), at - (place - first)]), near[tuple(at.T)]
    plane = np.linalg.lstsq(columns, known, rcond=None)[0]
    return float(plane[0]), float(np.ptp(known - columns @ plane)) if known.size else 0.0
