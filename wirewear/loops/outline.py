"""Points of a loop in no order of time, such as those digitised from a figure, put in order along the loop."""

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Array
from wirewear.loops.sensor import enclosed_area

MOST_POINTS = 3000  #: More points than this are no digitised loop, and would take long.


def outline(x: Array, y: Array) -> NDArray[np.intp] | None:
    """Indices (n,) that put points (x, y) in order along their loop; None where the points are already in order of
    time, do not lie on a loop, or are more than MOST_POINTS.

    The order is the shortest closed tour, found by reversing stretches of a first one (Croes, Operations Research 6
    (1958) 791).
    """
    count = len(x)
    width, height = float(np.ptp(x)), float(np.ptp(y))
    if count > MOST_POINTS or not width > 0.0 or not height > 0.0:
        return None
    points = np.column_stack([(x - x.min()) / width, (y - y.min()) / height])
    given = step_lengths(points, np.arange(count))
    # A drive passes the stroke in more than a step, unless the branches run the same way.
    leaping = np.abs(np.diff(points[:, 0], append=points[0, 0])) > 0.5
    leaps = int(np.count_nonzero(leaping))
    if not leaps and _sweeps(points[:, 0]) <= 2:
        return None
    # First order of the points: the upper branch by rising x, then the lower branch by falling x.
    line = np.interp(points[:, 0], *_middle_line(points))
    upper = points[:, 1] > line
    up, down = np.flatnonzero(upper), np.flatnonzero(~upper)
    order = shortened(points, np.concatenate([up[np.argsort(points[up, 0])], down[np.argsort(-points[down, 0])]]))
    tour = step_lengths(points, order)
    # A loop in order of time is no longer than three outlines; a log of several cycles is one outline a cycle. Points
    # in any order are so far from the next ones, on average, in shares of the box around them.
    scattered = given.sum() > 3.0 * tour.sum() and given.mean() > 0.2
    # Of an outlier, the leap back comes at once.
    apart = not np.any(leaping & np.roll(leaping, 1))
    same_way = leaps in {1, 2} and apart and _sweeps(points[:, 0]) <= 2 * leaps
    area = abs(enclosed_area(points[order, 0], points[order, 1]))
    gap = np.abs(np.diff(points[order, 0], append=points[order[0], 0])).max()
    # The outline encloses at least a share of the box around it, as points on one curve do not, and neighbours on it
    # are no farther apart along the stroke.
    if not (scattered or same_way) or area < 0.05 or gap > 0.4 or _sweeps(points[order, 0]) > 2:
        return None
    return order


def step_lengths(points: Array, order: NDArray[np.intp]) -> Array:
    """Distances (n,) from each point of a closed tour to the next. points: (n, 2); order: (n,) indices into them."""
    path = points[order]
    return np.asarray(np.linalg.norm(np.roll(path, -1, axis=0) - path, axis=1))


def _sweeps(level: Array) -> int:
    """Number of times that samples pass from one end of the stroke to the other, including the step that closes the
    loop.
    """
    ends = np.where(level > 0.75, 1, np.where(level < 0.25, -1, 0))
    ends = ends[ends != 0]
    return int(np.count_nonzero(ends != np.roll(ends, 1)))


def _middle_line(points: Array) -> tuple[Array, Array]:
    """Line halfway between the highest and the lowest points, as x (k,) and y (k,), in up to twelve parts of the
    stroke.
    """
    parts = np.minimum((points[:, 0] * 12).astype(int), 11)
    held = [part for part in range(12) if np.any(parts == part)]
    middle = [0.5 * float(points[parts == part, 1].max() + points[parts == part, 1].min()) for part in held]
    return (np.array(held) + 0.5) / 12.0, np.array(middle)


def shortened(points: Array, order: NDArray[np.intp]) -> NDArray[np.intp]:
    """The closed tour `order` (n,), indices into points (n, 2), with stretches reversed as long as that shortens it, at
    most 20 rounds. `order` is changed in place and returned.
    """
    count = len(order)
    for _ in range(20):
        turned = False
        for i in range(count - 2):
            path = points[order]
            here, after = path[i], path[i + 1]
            others, next_ones = path[i + 2 :], np.roll(path, -1, axis=0)[i + 2 :]
            saved = (
                np.linalg.norm(after - here)
                + np.linalg.norm(next_ones - others, axis=1)
                - np.linalg.norm(others - here, axis=1)
                - np.linalg.norm(next_ones - after, axis=1)
            )
            best = int(np.argmax(saved))
            if saved[best] > 1e-12:
                stop = i + 2 + best
                order[i + 1 : stop + 1] = order[i + 1 : stop + 1][::-1].copy()
                turned = True
        if not turned:
            break
    return order
