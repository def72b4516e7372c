"""Search for the surface on which most of a map of heights lies, among random ones through a few of its points.

Candidates are rated by how many points lie on them, at several distances within which a point counts, and by how few
stand above: wear only removes material. The border of a map, which is likely unworn, counts as much as all of it.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geometry.arrays import Array, BoolArray
from wirewear.records.spikes import FINEST_um, noise_um
from wirewear.records.unworn_bodies import Surface, jacobian

#: Places along a map and along a profile that are weighed, medians of points; of so many points at least.
PLACES, PLACES_OF_LINE, KNOWN = 36, 160, 0.3

#: Surfaces at random in each of so many rounds, fewer for a direction; the best at each scale are fitted so many times.
DRAWN, FEWER, ROUNDS, KEPT, FITTED = 800, 200, 3, 2, 4

#: The border of a map that is weighed as much as all of it, as a share of its size; what stands above counts so much.
BORDER, RAISED = 0.1, 3.0


def block_medians(
    places: Array, values: Array, parts: int = PLACES, known: float = KNOWN
) -> tuple[Array, Array, Array, BoolArray]:
    """Medians of groups of neighbouring points: places (2, m), values (m,), counts (m,), and marks of those at the
    border.
    """
    shape = values.shape
    most = parts if min(shape) > 1 else parts * PLACES_OF_LINE // PLACES
    steps = [max(-(-n // most), 1) for n in shape]
    padded = [(0, -n % step) for n, step in zip(shape, steps, strict=True)]

    def grouped(one: Array) -> Array:
        whole = np.pad(one, padded, constant_values=np.nan)
        cut = whole.reshape(whole.shape[0] // steps[0], steps[0], whole.shape[1] // steps[1], steps[1])
        return cut.transpose(0, 2, 1, 3).reshape(cut.shape[0], cut.shape[2], -1)

    groups = grouped(values)
    count = np.isfinite(groups).sum(axis=2)
    whole = np.isfinite(grouped(places[0])).sum(axis=2)
    taken = count >= np.maximum(known * whole, 1)
    middle = np.stack([np.nanmean(grouped(one)[taken], axis=1) for one in places])
    border = np.zeros(taken.shape, dtype=bool)
    for axis, held in ((0, taken.any(axis=1)), (1, taken.any(axis=0))):
        if shape[axis] > 1 and held.any():
            first, last = np.flatnonzero(held)[[0, -1]]
            place = np.arange(held.size)
            deep = max(BORDER * (last - first + 1), 1.0)
            near = (place < first + deep) | (place > last - deep)
            border |= near[:, None] if axis == 0 else near[None, :]
    return middle, np.nanmedian(groups[taken], axis=1), count[taken], border[taken]


def sought(surface: Surface, places: Array, height: Array, start: Array) -> tuple[Array, float]:
    """Parameters of the best of many random surfaces, and the distance within which points lie on it.

    start: those of the position, or all, at which the search begins.
    """
    noise, random, found, scale = noise_um(height), np.random.default_rng(0), start, FINEST_um
    flat = places.reshape(2, -1)
    for _ in range(ROUNDS):
        rest = height - surface.height(found, flat).reshape(height.shape)
        at, rest, count, border = block_medians(places, rest)
        sharp = FINEST_um + 1.25 * noise / float(np.sqrt(np.median(count)))
        weighed = Candidates(rest, jacobian(surface, found, at, found.size)[1], border, sharp, _range(rest, sharp))
        change, scale, _ = weighed.best(random)
        found = found + change
    return found, scale


def _range(rest: Array, sharp: float) -> float:
    low, high = np.percentile(rest, (1.0, 99.0))
    return max(float(high - low), 20.0 * sharp)


def direction_deg(x: Array, y: Array, height: Array, curvatures_per_mm: tuple[float, float]) -> float:
    """Direction in degrees from x, in (−90°, 90°], of the axis of a body in a map of heights (n_x, n_y).

    x, y, height: lines (n_x,), (n_y,) and heights in µm. curvatures_per_mm: along and across the axis. It is the
    direction for which most heights lie on the sum of a paraboloid with these curvatures and a plane.
    """
    places = np.stack(np.meshgrid(x - x.mean(), y - y.mean(), indexing="ij"))
    (u, v), z, count, border = block_medians(places, height, parts=24)
    sharp = FINEST_um + 1.25 * noise_um(height) / float(np.sqrt(np.median(count)))
    slopes = np.column_stack([np.ones_like(u), u / np.ptp(x), v / np.ptp(y)])
    k, m = curvatures_per_mm

    def weight(angle_deg: float) -> float:
        cosine, sine = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
        flat = z + 5e-4 * (k * (u * cosine + v * sine) ** 2 + m * (v * cosine - u * sine) ** 2)
        weighed = Candidates(flat - np.median(flat), slopes, border, sharp, _range(z, sharp))
        return weighed.best(np.random.default_rng(0), FEWER)[2]

    return float(max(np.arange(-85.0, 91.0, 5.0), key=weight))


@dataclass(frozen=True, eq=False)
class Candidates:
    """Heights (m,) of points above a surface, and their derivatives by its parameters (m, k), to rate other
    parameters.
    """

    rest: Array
    slopes: Array
    border: BoolArray
    sharp: float  #: Smallest standard deviation of a height.
    range: float  #: Range of the heights.

    @cached_property
    def scales(self) -> Array:
        """Trial distances in µm within which points count as lying on a surface."""
        return np.asarray(2.5 * self.sharp * 2.0 ** np.arange(np.log2(max(self.range / (10.0 * self.sharp), 2.0))))

    def best(self, random: np.random.Generator, count: int = DRAWN) -> tuple[Array, float, float]:
        """The best of many candidate surfaces: change of the parameters (k,), trial distance, and weight, the largest
        of all.

        count: number of random candidates, each through as many points as it has parameters; half through border
        points.
        """
        size, (_, k) = self.rest.size, self.slopes.shape
        at_border = np.flatnonzero(self.border)
        ends, anywhere = (random.integers(most, size=(count // 2, k)) for most in (at_border.size, size))
        drawn = np.vstack([at_border[ends], anywhere])
        matrices, right = self.slopes[drawn], self.rest[drawn]
        sound = np.abs(np.linalg.det(matrices)) > 1e-4
        changes: Array = np.vstack([np.zeros(k), np.linalg.solve(matrices[sound], right[sound][..., None])[..., 0]])
        weights = self.weights(changes)
        changes = np.array([
            self._fitted(changes[one], float(scale))
            for place, scale in enumerate(self.scales)
            for one in np.argsort(weights[:, place])[-KEPT:]
        ])  # fmt: skip
        weights = self.weights(changes)
        one, place = np.unravel_index(int(weights.argmax()), weights.shape)
        return np.array(changes[one], dtype=np.float64), float(self.scales[place]), float(weights[one, place])

    def weights(self, changes: Array) -> Array:
        """Weights (n, scales) of surfaces with changed parameters (n, k), as log-likelihoods for each trial distance.

        A point within the distance counts by how much smaller this is than the range of heights.
        """
        found = np.empty((len(changes), self.scales.size))
        parts = np.stack([np.full(self.rest.size, 1.0 / self.rest.size), self.border / max(self.border.sum(), 1)])
        # A few at a time stay within the processor's cache.
        for few in range(0, len(changes), 50):
            off = self.rest - changes[few : few + 50] @ self.slopes.T
            for place, scale in enumerate(self.scales):
                far = off / scale
                on = np.maximum(1.0 - far * far, 0.0) - RAISED * (far > 1.0)
                found[few : few + 50, place] = (on @ parts.T).mean(axis=1) * np.log(self.range / scale)
        return found

    def _fitted(self, change: Array, scale: float) -> Array:
        for _ in range(FITTED):
            near = np.abs(self.rest - self.slopes @ change) < scale
            if np.count_nonzero(near) <= change.size:
                break
            change = np.asarray(np.linalg.lstsq(self.slopes[near], self.rest[near], rcond=None)[0])
        return change
