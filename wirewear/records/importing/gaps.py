"""Points of a scar map that were not measured: small gaps are interpolated, since a volume takes them for unworn."""

from dataclasses import replace

import numpy as np

from wirewear.records.values import Array, MeasuredScar

#: Widest gap along a line that is bridged, in points: reflexes and dirt; what is wider, `check` tells.
WIDEST = 3


def bridged(scar: MeasuredScar) -> tuple[MeasuredScar, tuple[str, ...]]:
    """The scar with small gaps interpolated along its lines, and a sentence on how many points that were."""
    depth = np.array(scar.depth_um)
    both = np.stack([_along(scar.y_um, depth), _along(scar.x_um, depth.T).T])
    known = np.isfinite(both)
    means = np.where(known, both, 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
    fill = ~np.isfinite(depth) & known.any(axis=0)
    if not fill.any():
        return scar, ()
    depth[fill] = means[fill]
    depth.setflags(write=False)
    told = (
        f"{np.mean(fill):.1%} of the points of the {scar.wire} wire's map, repeat {scar.repeat}, were not measured: "
        f"gaps of up to {WIDEST} points are interpolated"
    )
    return replace(scar, depth_um=depth), (told,)


def _along(line: Array, depth: Array) -> Array:
    """Depths (n, m) over a line (m,) between the known ones beside a gap; NaN elsewhere."""
    known, place = np.isfinite(depth), np.arange(line.size)
    before = np.maximum.accumulate(np.where(known, place, -1), axis=1)
    after = np.minimum.accumulate(np.where(known, place, line.size)[:, ::-1], axis=1)[:, ::-1]
    small = ~known & (before >= 0) & (after < line.size) & (after - before - 1 <= WIDEST)
    rows, columns = np.nonzero(small)
    left, right = before[small], after[small]
    share = (line[columns] - line[left]) / (line[right] - line[left])
    found = np.full(depth.shape, np.nan)
    found[small] = (1.0 - share) * depth[rows, left] + share * depth[rows, right]
    return found
