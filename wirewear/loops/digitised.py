"""Points of a loop without an order of time, such as those read off a published picture, joined along its outline."""

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Array, BoolArray
from wirewear.loops.sensor import enclosed_area

FEWEST_SLIPS = 4  #: So many single samples that fall alike are slips, and no chance.

#: A way from one side of the loop to the other is a reversal if it begins and ends beyond this share of the plateaus.
OF_PLATEAU = 0.5

MOST_POINTS = 3000  #: More points than this are no digitised loop, and would take long.

#: A loop in order of time is no longer than so many outlines; a log of several cycles is one outline a cycle.
DISORDER = 3.0

LEAST_STEP = 0.2  #: Points in any order are so far from the next ones, on average, in shares of the box around them.
WIDEST_GAP = 0.4  #: Neighbours on the outline are no farther apart along the stroke.
LEAST_AREA = 0.05  #: The outline encloses at least this share of the box around it, as points on one curve do not.


def signal_among(flagged: BoolArray, force: Array, time: Array, noise: float) -> BoolArray:
    """Which of the forces (n,) of a closed loop that were flagged as outliers are none."""
    middle = 0.5 * float(np.percentile(force, 5) + np.percentile(force, 95))
    kept = _alike_dips(force, flagged, middle) | _usual_jumps(force, flagged, middle)
    for sample in np.flatnonzero(flagged & ~kept):
        kept[sample] = _continues_a_line(time, force, int(sample), noise)
    return kept


def _continues_a_line(time: Array, force: Array, sample: int, noise: float) -> bool:
    """Whether a sample of a closed loop goes on as those before it do, or those after it go on from it.

    So do the tip of a stick and the first sample after a slip, but no outlier.
    """
    count = len(force)
    period = (time[-1] - time[0]) * count / (count - 1)
    for side in (-1, 1):
        near = (sample + side * np.arange(1, 4)) % count
        t = side * ((side * (time[near] - time[sample])) % period)
        if np.ptp(t) <= 0.0:
            continue
        slope, level = np.polyfit(t, force[near], 1)
        rest = float(np.abs(force[near] - level - slope * t).max())
        jump = abs(force[sample] - force[(sample - side) % count])
        near_enough = 4.0 * noise + 0.1 * jump
        if rest <= near_enough and abs(force[sample] - level) <= near_enough + rest:
            return True
    return False


def _alike_dips(force: Array, flagged: BoolArray, middle: float) -> BoolArray:
    """Flagged forces (n,) that fall towards the loop's middle, not beyond it, and are many: slips of one sample."""
    size = np.abs(force - middle)
    level = float(np.percentile(size, 60))
    before, after = np.roll(force, 1), np.roll(force, -1)
    sides = np.sign(np.stack([before, force, after]) - middle)
    same_side = (sides[0] == sides[1]) & (sides[2] == sides[1])
    dips = flagged & same_side & (size < 0.97 * level) & (size > 0.1 * level)
    return dips if np.count_nonzero(dips) >= FEWEST_SLIPS else np.zeros_like(flagged)


def _usual_jumps(force: Array, flagged: BoolArray, middle: float) -> BoolArray:
    """Flagged forces (n,) within the range of their branch, to which the others jump as far many times."""
    rest = force[~flagged]
    steps = np.diff(rest, prepend=rest[-1])
    # A stiff rig's reversals jump, too, twice in every loop.
    jumps = np.sort(np.abs(steps[~_of_reversals(rest - middle, steps)]))
    own = np.minimum(np.abs(force - np.roll(force, 1)), np.abs(np.roll(force, -1) - force))
    often = jumps.size - np.searchsorted(jumps, 0.7 * own) >= FEWEST_SLIPS
    far = np.abs(force - middle)
    inside = (far <= np.abs(rest - middle).max()) & (far >= 0.1 * np.abs(rest - middle).max())
    usual: BoolArray = flagged & often & inside
    return usual


def _of_reversals(away: Array, steps: Array) -> BoolArray:
    """Which steps (n,) to samples of a closed loop, so far from its middle (n,), lead from one plateau to the other."""
    least = OF_PLATEAU * float(np.percentile(np.abs(away), 60))
    # Runs of steps one way, of a loop that begins where one ends.
    first = int(np.argmax(np.sign(steps) != np.sign(np.roll(steps, 1))))
    signs = np.sign(np.roll(steps, -first))
    starts = np.flatnonzero(np.diff(signs, prepend=np.nan) != 0.0)
    found = np.zeros(steps.size, dtype=bool)
    for start, end in zip(starts, [*starts[1:], steps.size], strict=True):
        before, after = (away[(first + at) % away.size] for at in (start - 1, end - 1))
        if before * after < 0.0 and min(abs(before), abs(after)) > least:
            found[(first + np.arange(start, end)) % steps.size] = True
    return found


def outline(x: Array, y: Array) -> NDArray[np.intp] | None:
    """An order of points (n,) along the loop on which they lie; None where they come in order of time, or on no loop.

    Points in any order, and branches that both run the same way, are put in order. The shortest closed tour is sought
    by turning round stretches of one that goes about the middle (Croes, Operations Research 6 (1958) 791).
    """
    count = len(x)
    width, height = float(np.ptp(x)), float(np.ptp(y))
    if count > MOST_POINTS or not width > 0.0 or not height > 0.0:
        return None
    points = np.column_stack([(x - x.min()) / width, (y - y.min()) / height])
    given = _steps(points, np.arange(count))
    # A drive passes the stroke in more than a step, unless the branches run the same way.
    leaping = np.abs(np.diff(points[:, 0], append=points[0, 0])) > 0.5
    leaps = int(np.count_nonzero(leaping))
    if not leaps and _sweeps(points[:, 0]) <= 2:
        return None
    order = _shortened(points, _about_the_middle(points))
    tour = _steps(points, order)
    scattered = given.sum() > DISORDER * tour.sum() and given.mean() > LEAST_STEP
    # Of an outlier, the leap back comes at once.
    apart = not np.any(leaping & np.roll(leaping, 1))
    same_way = leaps in {1, 2} and apart and _sweeps(points[:, 0]) <= 2 * leaps
    area = abs(enclosed_area(points[order, 0], points[order, 1]))
    gap = np.abs(np.diff(points[order, 0], append=points[order[0], 0])).max()
    if not (scattered or same_way) or area < LEAST_AREA or gap > WIDEST_GAP or _sweeps(points[order, 0]) > 2:
        return None
    return order


def _steps(points: Array, order: NDArray[np.intp]) -> Array:
    path = points[order]
    return np.asarray(np.linalg.norm(np.roll(path, -1, axis=0) - path, axis=1))


def _sweeps(level: Array) -> int:
    """How often samples pass from one end of the stroke to the other, the closing step included."""
    ends = np.where(level > 0.75, 1, np.where(level < 0.25, -1, 0))
    ends = ends[ends != 0]
    return int(np.count_nonzero(ends != np.roll(ends, 1)))


def _about_the_middle(points: Array) -> NDArray[np.intp]:
    """Upper branch by rising x, then the lower one by falling x: told apart by a middle line along the loop."""
    line = np.interp(points[:, 0], *_middle_line(points))
    upper = points[:, 1] > line
    up, down = np.flatnonzero(upper), np.flatnonzero(~upper)
    return np.concatenate([up[np.argsort(points[up, 0])], down[np.argsort(-points[down, 0])]])


def _middle_line(points: Array) -> tuple[Array, Array]:
    """Middle between the highest and the lowest point of each of twelve parts of the stroke."""
    parts = np.minimum((points[:, 0] * 12).astype(int), 11)
    held = [part for part in range(12) if np.any(parts == part)]
    middle = [0.5 * float(points[parts == part, 1].max() + points[parts == part, 1].min()) for part in held]
    return (np.array(held) + 0.5) / 12.0, np.array(middle)


def _shortened(points: Array, order: NDArray[np.intp]) -> NDArray[np.intp]:
    """The tour with stretches turned round as long as that shortens it."""
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
