"""The noise of samples and the outliers among them, told from their neighbours."""

from collections.abc import Callable

import numpy as np

from geometry.arrays import Array, BoolArray
from wirewear.loops.robust import median_deviation

#: The cubic through two neighbours on either side, at even times: a sample is their mean with these weights.
NEIGHBOURS, WEIGHTS = (-2, -1, 1, 2), np.array([-1.0, 4.0, 4.0, -1.0]) / 6.0

#: By what a sample's distance to that cubic scatters more than the sample itself.
_SCATTER = float(np.sqrt(1.0 + np.sum(WEIGHTS**2)))

#: Samples of a cycle from which on those next to a reversal's hook resolve it.
_DENSE = 100

#: A spike lies so many of the usual deviations off; these are at least this share of the channel's extent, and more
#: than round-off where it never changes.
OUTLYING, LEAST_DEVIATION, ROUND_OFF = 8.0, 1e-3, 1e-9

#: How far a sample is off may change from loop to loop by this share of what is usual there.
BENT = 0.1


def through_neighbours(loops: Array) -> Array:
    """For each sample of closed loops (m, n) at even times the cubic through its four neighbours there."""
    parts = (weight * np.roll(loops, -shift, axis=1) for shift, weight in zip(NEIGHBOURS, WEIGHTS, strict=True))
    return np.asarray(sum(parts))


def noises(loops: Array) -> Array:
    """Standard deviations (m,) of one sample of closed loops (m, n) at even times (robust)."""
    return 1.4826 * np.median(np.abs(loops - through_neighbours(loops)), axis=1) / _SCATTER


def sample_noise(values: Array, time: Array) -> float:
    """Standard deviation of one sample, from its distance to the cubic through four neighbours (robust)."""
    count = len(values)
    centre = np.arange(2, count - 2)
    offsets = np.array([-2, -1, 1, 2])
    distance = time[centre[:, None] + offsets] - time[centre, None]
    weights = np.ones_like(distance)
    # times that all but coincide give weights that are not finite, and those samples are left out below
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for j in range(4):
            for k in range(4):
                if k != j:
                    weights[:, j] *= distance[:, k] / (distance[:, k] - distance[:, j])
    # very uneven spacing would extrapolate wildly: such samples say nothing
    sound = np.max(np.abs(weights), axis=1) < 3.0
    if np.count_nonzero(sound) < 4:
        return float(np.ptp(values)) * 1e-2
    centre, weights = centre[sound], weights[sound]
    prediction = np.sum(weights * values[centre[:, None] + offsets], axis=1)
    error = (values[centre] - prediction) / np.sqrt(1.0 + np.sum(weights**2, axis=1))
    rough = median_deviation(error)
    usual = error[np.abs(error) <= 3.0 * rough]
    # the median alone scatters by a tenth; the bulk is sharper, and 0.9867 restores what its cut tails hold
    return float(np.sqrt(np.mean(usual**2)) / 0.9867) if len(usual) else rough


def noise_along(values: Array) -> float:
    """Standard deviation of one sample of a branch (n,), from the distances to the middles of neighbours."""
    return median_deviation(values[1:-1] - 0.5 * (values[:-2] + values[2:])) / float(np.sqrt(1.5))


def outliers(values: Array, time: Array) -> BoolArray:
    """Samples (n,) of a closed loop outside what their neighbours allow.

    Of the four steps between neighbours the second smallest counts, as an outlier among them spoils two; where samples
    are few, a hook at a reversal is as steep as an outlier, and the middle of the four counts.
    """
    extent = float(np.subtract(*np.percentile(values, [99, 1])))
    noise, dense = sample_noise(values, time), len(values) >= _DENSE

    def allowed(steps: Array) -> Array:
        step = steps[1] if dense else 0.5 * (steps[1] + steps[2])
        return np.asarray(5.0 * noise + 2.5 * step + 1e-9 * extent)

    return np.asarray(outside_neighbours(values[None], allowed)[0])


def outside_neighbours(loops: Array, allowed: Callable[[Array], Array]) -> BoolArray:
    """Samples of closed loops (m, n) outside what their three neighbours on either side bracket.

    The medians of the two sides bracket a sample of any monotone stretch. Noise and the neighbours' own steps widen the
    bracket, as a sharp tip stands out by two of them: `allowed` says by how much, given the sizes of the four steps
    between neighbours (4, m, n), the smallest first.
    """
    left = [np.roll(loops, shift, axis=1) for shift in (1, 2, 3)]
    right = [np.roll(loops, -shift, axis=1) for shift in (1, 2, 3)]
    one, other = np.median(left, axis=0), np.median(right, axis=0)
    steps = np.abs([left[1] - left[0], left[2] - left[1], right[1] - right[0], right[2] - right[1]])
    allowance = allowed(np.sort(steps, axis=0))
    outside: BoolArray = (loops < np.minimum(one, other) - allowance) | (loops > np.maximum(one, other) + allowance)
    return outside


def spikes(loops: Array) -> BoolArray:
    """Which samples of periodic loops (m, n) at equal times are off their neighbours as those of no other loop are.

    One by one, as a spike draws the curve through its neighbours.
    """
    values = loops.copy()
    found = np.zeros(values.shape, dtype=bool)
    typical = np.median(values, axis=0)
    least = LEAST_DEVIATION * float(np.ptp(typical)) + ROUND_OFF * max(float(np.abs(typical).max()), 1.0)
    for _ in range(max(values.shape[1] // 10, 1)):
        off = values - through_neighbours(values)
        usual = np.median(off, axis=0)
        away = np.abs(off - usual)
        deviation = 1.4826 * np.median(away, axis=0)
        # Of few loops a deviation may be small by chance, and a knee that moves with the wear bends another sample.
        bent = np.max([np.roll(np.abs(usual), shift) for shift in (-1, 0, 1)], axis=0)
        deviation = np.max(
            [deviation, np.full_like(bent, max(float(np.median(deviation)), least)), BENT * bent], axis=0
        )
        excess = away / deviation
        rows, worst = np.arange(len(values)), excess.argmax(axis=1)
        spiky = excess[rows, worst] > OUTLYING
        if not spiky.any():
            break
        # The curves through its neighbours are drawn off too, by less.
        rows, near = rows[spiky], (worst[spiky, None] + np.array([0, *NEIGHBOURS])) % values.shape[1]
        worst = near[np.arange(rows.size), away[rows[:, None], near].argmax(axis=1)]
        found[rows, worst] = True
        values[rows, worst] += usual[worst] - off[rows, worst]
    return found
