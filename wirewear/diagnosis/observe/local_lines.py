"""A branch of a measured loop, its knee, and values read from it by lines through nearby samples.

The knee is where sliding begins: before it the branch sticks, behind it the branch slides.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Array
from wirewear.diagnosis.calibration import constants
from wirewear.loops.branches import FALLEN
from wirewear.loops.noise import noise_factor, noise_product

#: A force level lies on the stick branch if it is below this share of the rise from reversal to knee.
STICK_SHARE = constants("observe.local_lines.branch").number("stick_share")

_KNOWN = constants("observe.local_lines")

#: A force is read from at least so many samples, however far they lie.
FEW_NEAR = _KNOWN.count("few_near")

#: A straight line between two samples may miss a curved stick branch by this share of their distance.
CHORD_ERROR = _KNOWN.number("chord_error")

#: Deviations from which on a sample, a figure or a harmonic is none of its noise's.
OUTLYING = _KNOWN.number("outlying")

#: A drive rests if more than so many samples of a branch are within this share of the amplitude from its end.
_MOST_AT_END, _RESTS_WITHIN = _KNOWN.each("most_at_end", "rests_within")

#: The knee is where the share of the rise leads the travel, in this many amplitudes, the most.
KNEE_TRAVEL, KNEE_EARLY = constants("observe.local_lines.knee").each("travel", "early")


@dataclass(frozen=True, eq=False)
class ObservedBranch:
    """One branch of a measured loop in order of travel, its m displacements and forces multiplied by its direction
    `sign`.

    knee: index of the sample at the knee. normal_N: (m,) normal force; None if not measured. reversal_N: force, in this
    branch's direction, at which the other branch ends; infinite if unknown.
    """

    sign: int
    displacement_um: Array
    force_N: Array
    knee: int
    normal_N: Array | None = None
    reversal_N: float = np.inf

    @property
    def knee_um(self) -> float:
        """Displacement in µm at the knee, in the branch's direction."""
        return float(self.displacement_um[self.knee])

    @cached_property
    def sliding(self) -> slice:
        """Samples from the knee to the last one before the force falls because the drive has reversed."""
        past = self.force_N[self.knee :]
        end = self.knee + int(np.flatnonzero(past > FALLEN * np.median(past))[-1]) + 1
        # Where a drive rests the force follows a load that varies, and not the place.
        rests = self.displacement_um > self.displacement_um.max() * (1.0 - _RESTS_WITHIN)
        return slice(self.knee, min(end, int(rests.argmax()) + 1) if rests.mean() > _MOST_AT_END else end)

    @property
    def stick_top_N(self) -> float:
        """Force in N, in the branch's direction, up to which it certainly sticks: `STICK_SHARE` of its rise to the
        knee.
        """
        low = min(float(self.force_N[: self.knee + 1].min()), self.reversal_N)
        return low + STICK_SHARE * (float(self.force_N[self.knee]) - low)

    @property
    def step_at_zero_um(self) -> float:
        """Distance in µm between the samples on either side of zero force; 0 if the branch does not pass it before the
        knee.
        """
        after = int(np.count_nonzero(self.force_N[: self.knee + 1] <= 0.0))
        if not 0 < after <= self.knee:
            return 0.0
        return float(abs(self.displacement_um[after] - self.displacement_um[after - 1]))


def knee_index(travel_um: Array, force_N: Array, top_N: float, amplitude_um: float, reversal_N: float = np.inf) -> int:
    """Index of the knee on a branch (m,): where the force, as a share of its rise, leads the travel most.

    travel_um: (m,) from the reversal. top_N: force at mid-stroke. reversal_N: force at which the other branch ends, as
    a sharp reversal has risen far by this branch's first sample; infinite if unknown.
    """
    return int(knees_of(travel_um, force_N, np.array([top_N]), np.array([amplitude_um]), reversal_N))


def knees_of(
    travel_um: Array, force_N: Array, top_N: Array, amplitude_um: Array, reversal_N: float = np.inf
) -> NDArray[np.intp]:
    """Indices (...) of the knees of branches (..., m), see `knee_index`; forces at mid-stroke and amplitudes are (...,
    1).
    """
    leads_N = _leads_N(travel_um, force_N, top_N, amplitude_um, reversal_N)
    knees: NDArray[np.intp] = np.argmax(leads_N, axis=-1)
    return np.maximum(knees, 1)


def knees_alike(branch: ObservedBranch, top_N: float, amplitude_um: float, noise_N: float) -> tuple[int, int]:
    """First and last index of the samples of a branch that noise may make its knee: of a round one there are several.

    top_N: force at mid-stroke. noise_N: standard deviation of a sample's force.
    """
    travel_um = branch.displacement_um - branch.displacement_um[0]
    leads_N = _leads_N(travel_um, branch.force_N, np.array([top_N]), amplitude_um, branch.reversal_N)
    alike = np.flatnonzero(leads_N >= leads_N[branch.knee] - np.sqrt(2.0) * noise_N)
    return int(alike[0]), int(alike[-1])


def _leads_N(travel_um: Array, force_N: Array, top_N: Array, amplitude_um: float | Array, reversal_N: float) -> Array:
    """By how much forces (..., m) have risen since the reversal beyond those of a slow, even rise to the force at
    mid-stroke; a knee has most. -inf late in the stroke.
    """
    low = np.minimum(force_N[..., : max(3, force_N.shape[-1] // 6)].min(axis=-1, keepdims=True), reversal_N)
    even = np.maximum(top_N - low, 1e-12) * travel_um / np.maximum(KNEE_TRAVEL * amplitude_um, 1e-12)
    return np.where(travel_um < KNEE_EARLY * amplitude_um, force_N - low - even, -np.inf)


@dataclass(frozen=True, eq=False)
class LocalLine:
    """Value read from a line through nearby samples of a branch, with its standard error, both in the unit of the
    value.

    weights, order: (k,) the samples' weights in the value, and their indices on the branch. sampled: share of the error
    by the samples' noise, the rest being the curve's departure from a line.
    """

    value: float
    error: float
    weights: Array
    order: NDArray[np.intp]
    sampled: float = 1.0

    def correlation(self, other: LocalLine, of_neighbours: float) -> float:
        """Correlation of this value's error with another's of the same branch, by the samples that they share.
        of_neighbours: correlation of the noise of neighbouring samples.
        """
        own, others = (noise_factor(one.weights, one.order, of_neighbours) for one in (self, other))
        shared = noise_product(self.weights, self.order, other.weights, other.order, of_neighbours) / (own * others)
        return self.sampled * other.sampled * shared


def force_at(
    branch: ObservedBranch, at_um: float, window_um: float, sample_noise_N: float = 1.0, correlation: float = 0.0
) -> LocalLine | None:
    """Force in N while sliding at a displacement, by a local line or parabola; None if no samples are near.

    at_um: displacement in the branch's direction. window_um: samples within this distance are used. sample_noise_N:
    noise of one force sample. correlation: of the noise of neighbouring samples.
    """
    x, q, first = branch.displacement_um[branch.sliding], branch.force_N[branch.sliding], branch.knee
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
    # Few samples reach farther than the window: there a wall is no line.
    degree = 2 if float(np.abs(away).max()) > window_um and away.size > 3 else 1
    design, order = np.vander(away / window_um, degree + 1, increasing=True), first + np.flatnonzero(near)
    for _ in range(2):
        inverse = np.linalg.pinv(design)
        rest = force - design @ (inverse @ force)
        spread = 1.4826 * float(np.median(np.abs(rest)))
        good = np.abs(rest) <= OUTLYING * spread + 1e-12
        design, force, order = design[good], force[good], order[good]
    weights = np.linalg.pinv(design)[0]
    error = sample_noise_N * noise_factor(weights, order, correlation)
    return LocalLine(float(weights @ force), error, weights, order)
