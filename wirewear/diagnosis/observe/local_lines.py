"""Values of a branch at a place, by lines through the samples near it, and how their errors hang together."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.model.setup import Array
from wirewear.diagnosis.observe.noise_of_samples import noise_factor, noise_product

#: A force level lies on the stick branch if it is below this share of the rise from reversal to knee.
STICK_SHARE = constants("observe.branch").number("stick_share")

_KNOWN = constants("observe.local_lines")

#: A force is read from at least so many samples, however far they lie; a displacement from at most so many on a side.
FEW_NEAR, STICK_NEAR = _KNOWN.count("few_near"), _KNOWN.count("stick_near")

#: A line through samples at so many windows misses as much of a curve as their noise makes unsure.
STRAIGHT = _KNOWN.number("straight")

#: A straight line between two samples may miss a curved stick branch by this share of their distance.
CHORD_ERROR = _KNOWN.number("chord_error")

#: Deviations from which on samples of a branch are outliers.
OUTLYING = _KNOWN.number("outlying")


@dataclass(frozen=True, eq=False)
class ObservedBranch:
    """One branch of a measured loop in order of travel: displacement and force times its direction, so that they rise.

    All arrays are (m,); the normal force is None where it was not measured. `reversal_N` is the force at which the
    other branch ends, from which this one begins.
    """

    sign: int
    displacement_um: Array
    force_N: Array
    knee: int
    normal_N: Array | None = None
    reversal_N: float = np.inf

    @property
    def knee_um(self) -> float:
        """Displacement at which sliding begins, times the direction."""
        return float(self.displacement_um[self.knee])

    @property
    def stick_top_N(self) -> float:
        """Force up to which the branch sticks for certain."""
        low = min(float(self.force_N[: self.knee + 1].min()), self.reversal_N)
        return low + STICK_SHARE * (float(self.force_N[self.knee]) - low)

    @property
    def step_at_zero_um(self) -> float:
        """Displacement between the samples before and after the force changes its sign; 0 where it does not."""
        after = int(np.count_nonzero(self.force_N[: self.knee + 1] <= 0.0))
        if not 0 < after <= self.knee:
            return 0.0
        return float(abs(self.displacement_um[after] - self.displacement_um[after - 1]))


class Noisy(Protocol):
    """A loop whose noise is known."""

    @property
    def displacement_noise_um(self) -> float:
        """Of one sample."""

    @property
    def sample_noise_N(self) -> float:
        """Of one sample."""

    @property
    def force_noise_N(self) -> float:
        """Of one of many whose mean is taken."""

    @property
    def correlation(self) -> float:
        """Of neighbouring samples."""


@dataclass(frozen=True, eq=False)
class LocalLine:
    """What a line through some samples of a branch gives at a place: a value and its error, by weights of the samples.

    `order` (m,) are the samples' numbers on the branch. Two lines of one branch share samples, and so part of their
    errors: `sampled` is the share of it that comes from the samples, not from a curve that a line misses.
    """

    value: float
    error: float
    weights: Array
    order: NDArray[np.intp]
    sampled: float = 1.0

    def correlation(self, other: LocalLine, of_neighbours: float) -> float:
        """Of both values' errors, the samples being so alike to their neighbours."""
        own, others = (noise_factor(one.weights, one.order, of_neighbours) for one in (self, other))
        shared = noise_product(self.weights, self.order, other.weights, other.order, of_neighbours) / (own * others)
        return self.sampled * other.sampled * shared


def force_at(
    branch: ObservedBranch, at_um: float, window_um: float, sample_noise_N: float = 1.0, correlation: float = 0.0
) -> LocalLine | None:
    """Force on the sliding part at a position by a local line; None where no samples are near."""
    x, q, first = branch.displacement_um[branch.knee :], branch.force_N[branch.knee :], branch.knee
    near = np.abs(x - at_um) < window_um
    if np.count_nonzero(near) < FEW_NEAR:
        # Of few samples the one at the knee may still stick: only those beyond it are known to slide.
        x, q, first = x[1:], q[1:], first + 1
        if x.size < FEW_NEAR or at_um < x.min():
            return None
        near = np.zeros(x.size, dtype=bool)
        near[np.argsort(np.abs(x - at_um))[:FEW_NEAR]] = True
    away, force = x[near] - at_um, q[near]
    if away.size < 2 or np.ptp(away) < 1e-9 or away.min() > window_um or away.max() < -window_um:
        return None
    # What a line misses of a curve goes with the square of how far it reaches; plateaus bend towards their ends.
    bent = (at_um / max(float(x.max()), window_um)) ** 2
    missed = bent * (float(np.abs(away).max()) / (STRAIGHT * window_um)) ** 2
    sampled = (1.0 + missed**2) ** -0.5
    design, order = np.stack([np.ones_like(away), away], axis=1), first + np.flatnonzero(near)
    for _ in range(2):
        inverse = np.linalg.pinv(design)
        rest = force - design @ (inverse @ force)
        spread = 1.4826 * float(np.median(np.abs(rest)))
        good = np.abs(rest) <= OUTLYING * spread + 1e-12
        design, force, order = design[good], force[good], order[good]
    weights = np.linalg.pinv(design)[0]
    error = sample_noise_N * noise_factor(weights, order, correlation)
    return LocalLine(float(weights @ force), error, weights, order, sampled)


def displacement_at(branch: ObservedBranch, level_N: float, window_N: float, loop: Noisy) -> LocalLine | None:
    """Displacement at which the stick branch reaches a force; None where it does not."""
    x, q = branch.displacement_um, branch.force_N
    end = min(branch.knee + 2, x.size - 1)
    # Counting is right where the first crossing is not: a single outlier moves it by one sample.
    right = int(np.count_nonzero(q[: end + 1] <= level_N))
    if right in (0, end + 1):
        return None
    left = right - 1
    local = np.arange(max(0, left - STICK_NEAR), min(end, right + STICK_NEAR) + 1)
    local = local[np.abs(q[local] - level_N) < window_N]
    if local.size >= 4 and np.ptp(q[local]) > 2.0 * loop.force_noise_N:
        away = q[local] - level_N
        slope, at = np.polyfit(away, x[local], 1)
        rest = x[local] - at - slope * away
        good = np.abs(rest) <= OUTLYING * (1.4826 * np.median(np.abs(rest))) + 1e-12
        if np.count_nonzero(good) >= 3 and np.ptp(away[good]) > 0.0:
            slope, at = np.polyfit(away[good], x[local][good], 1)
        else:
            good = np.ones(local.size, dtype=bool)
        weights = np.linalg.pinv(np.stack([np.ones(np.count_nonzero(good)), away[good]], axis=1))[0]
        error = _sample_error(loop, slope) * noise_factor(weights, local[good], loop.correlation)
        return LocalLine(float(at), error, weights, local[good])
    # Noise may turn the two around, or make them one: then the level lies between them somewhere.
    rise, step = float(q[right] - q[left]), float(x[right] - x[left])
    share = float(np.clip((level_N - q[left]) / rise, 0.0, 1.0)) if rise > 0.0 else 0.5
    slope = step / max(rise, loop.sample_noise_N)
    both = np.array([1.0 - share, share])
    error = _sample_error(loop, slope) * noise_factor(both, np.arange(2), loop.correlation)
    # A chord is right at its ends.
    whole = float(np.hypot(error, 4.0 * share * (1.0 - share) * CHORD_ERROR * step))
    return LocalLine(float(x[left] + share * step), whole, both, np.array([left, right]), error / whole)


def _sample_error(loop: Noisy, slope_um_per_N: float) -> float:
    """Error of a displacement that one sample tells, whose force is unsure, too [µm]."""
    return float(np.hypot(loop.displacement_noise_um, slope_um_per_N * loop.sample_noise_N))
