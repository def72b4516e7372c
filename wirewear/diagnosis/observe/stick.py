"""Displacement at equal force while the contact sticks after a reversal."""

from dataclasses import replace

import numpy as np

from geometry.arrays import Array
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.model.forward import LoopCourse
from wirewear.diagnosis.model.readings import read_along
from wirewear.diagnosis.observe import observable
from wirewear.diagnosis.observe.local_lines import CHORD_ERROR, OUTLYING, LocalLine, ObservedBranch
from wirewear.diagnosis.observe.measured_loops import FORCE_WINDOW, ReducedLoop
from wirewear.diagnosis.observe.reading import Reading
from wirewear.loops.noise import noise_factor

_KNOWN = constants("observe.stick")

#: Levels as shares of the force at mid-stroke.
FORCES = _KNOWN.numbers("forces")

#: With at most this many samples on a stick branch, it is read at them: nothing is known between. Of a shelf at Q = 0
#: one sample may catch any place: none is read within this share of the force.
FEW_SAMPLES, SHELF_SHARE = _KNOWN.count("few_samples"), _KNOWN.number("shelf_share")

#: Displacements are read from at most so many samples on a side.
STICK_NEAR = constants("observe.local_lines").count("stick_near")

_OF_SHELF = constants("observe.shelf")

#: Forces up to this share of the plateau's count as none: the zero of a force may be off, or a guide lean.
SHARE = _OF_SHELF.number("share")

#: Solver differences: share of the travel.
TRAVEL_SHARE = _OF_SHELF.number("travel_share")


class Stick(observable.ByLocalLines):
    """Levels are forces in the branch's direction in N."""

    name = "stick"
    words, unit = "displacement at equal force", "um"
    zones = (observable.Zone("stick", "stick, after a reversal", "just after a reversal"),)
    sides = ("ahead of", "behind")
    simulated = True

    def sites(self, reading: Reading) -> list[observable.Site]:
        """Forces below the knees of all repeats."""
        sites = []
        for cycle in reading.cycles:
            for side, sign in enumerate((1, -1)):
                branches = [loop.branches[side] for loop in reading.at(cycle)]
                sites += [observable.Site(cycle, sign, level) for level in _levels(branches, reading.force_N)]
        return sites

    def line(self, loop: ReducedLoop, site: observable.Site) -> LocalLine | None:
        """Through the samples near the force."""
        branch = loop.branches[int(site.branch < 0)]
        return displacement_at(branch, site.level, FORCE_WINDOW * loop.mid_force_N, loop)

    def predict(self, course: LoopCourse, sites: observable.Sites) -> Array:
        """Linear between the model's points; past a loop's tips a force crosses no branch, which ends there."""
        x, q, row = observable.branches_of(course, sites)
        return sites.branch * read_along(np.maximum.accumulate(q, axis=1), x, row, sites.level)

    def solver_error(self, loops: observable.ModelLoops, sites: observable.Sites) -> observable.SolverSize:
        """Where a branch turns under another force, it lies elsewhere as a whole."""
        turned = observable.SLOPE_SHARE * loops.rise_N(sites) * loops.stick_compliance_um_per_N(sites)
        crossing = loops.travel_um(sites, observable.FORCE_ERROR * loops.scale.force_N) / np.sqrt(12.0)
        # A drive that repeats itself leaves every branch at the same place of a shelf.
        return observable.SolverSize(turned, crossing, crossing * sites.branch)

    def along(self, sites: observable.Sites) -> Array:
        """Force in the branch's direction."""
        return sites.level

    def smoothness(self, sites: observable.Sites, scale: observable.Scale) -> observable.Smoothness:
        """Smooth over the force."""
        along = sites.level / scale.force_N / observable.REACH
        return replace(observable.Smoothness.of_whole_loops(len(sites)), along=along)


def has_few_samples(branches: list[ObservedBranch], force_N: float) -> bool:
    """Whether one of the stick branches of several repeats is read at its samples, being few."""
    return min(q.size for q in _samples(branches, force_N)) <= FEW_SAMPLES


def _samples(branches: list[ObservedBranch], force_N: float) -> list[Array]:
    """Forces of the samples that stick for certain, branch by branch."""
    top, lowest = min(branch.stick_top_N for branch in branches), FORCES[0] * force_N
    seen = [branch.force_N[: branch.knee + 1] for branch in branches]
    return [q[(q > lowest) & (q < min(top, FORCES[-1] * force_N))] for q in seen]


def _levels(branches: list[ObservedBranch], force_N: float) -> list[float]:
    """Forces at which stick branches are read: even ones, or those of the samples themselves where these are few."""
    samples = _samples(branches, force_N)
    count = min(q.size for q in samples)
    if count > FEW_SAMPLES:
        return [at * force_N for at in FORCES if at * force_N < min(branch.stick_top_N for branch in branches)]
    if count == 0:
        return []
    levels = np.median([q[:count] for q in samples], axis=0)
    return sorted(float(at) for at in levels if abs(at) > SHELF_SHARE * force_N)


class ShelfTravel(observable.OfLoops):
    """One a branch. Levels are the largest forces in N that count as none."""

    name = "shelf"
    words, unit = "travel without force", "um"
    zones = (observable.Zone("shelf", "shelf, where the force is zero", "after a reversal"),)

    def sites(self, reading: Reading) -> list[observable.Site]:
        """Branches of few samples, in all repeats."""
        level = max(SHARE * reading.force_N, OUTLYING * reading.sample_noise_N)
        return [
            observable.Site(cycle, sign, level)
            for cycle in reading.cycles
            for side, sign in enumerate((1, -1))
            if has_few_samples([loop.branches[side] for loop in reading.at(cycle)], reading.force_N)
        ]

    def read(self, loop: ReducedLoop, site: observable.Site) -> tuple[float, float]:
        """As the samples say; half of the variance of what they allow is each reading's own."""
        travel, unsure = travel_between(loop.branches[int(site.branch < 0)], site.level)
        return travel, float(np.hypot(np.sqrt(0.5) * unsure, loop.displacement_noise_um))

    def predict(self, course: LoopCourse, sites: observable.Sites) -> Array:
        """Between the same forces, linear between the model's points."""
        return observable.travel_um(course, sites, -sites.level, sites.level)

    def common_error(self, reading: Reading, sites: observable.Sites) -> Array:
        """A drive that repeats itself takes its samples at the same places of every branch: the other half."""
        unsure = [
            travel_between(loop.branches[int(site.branch < 0)], site.level)[1]
            for site in sites
            for loop in reading.at(site.cycle)
        ]
        usual = float(np.nanmedian(unsure)) if np.isfinite(unsure).any() else 0.0
        return np.full(len(sites), np.sqrt(0.5) * usual)

    def solver_error(self, loops: observable.ModelLoops, sites: observable.Sites) -> observable.SolverSize:
        """A share of the travel."""
        return observable.SolverSize(TRAVEL_SHARE * self.predict(loops.course, sites), hooked=False)


def travel_between(branch: ObservedBranch, level_N: float) -> tuple[float, float]:
    """Travel [µm] of a branch from −`level_N` to `level_N`, and its standard deviation; NaN of too few samples.

    It lies between that of the samples of such forces and that of those before and after them, evenly. With fewer than
    two of such forces nothing speaks for a shelf: the branch goes straight then, which a play of less travel may hide.
    Where a reading leans against the force, travel is negative.
    """
    end = min(branch.knee + 2, branch.force_N.size)
    x, q = branch.displacement_um[:end], branch.force_N[:end]
    # Counting is right where the first crossing is not: a single outlier moves it by one sample.
    before, after = int(np.count_nonzero(q < -level_N)) - 1, int(np.count_nonzero(q <= level_N))
    if before < 0 or after >= end:
        return np.nan, np.nan
    inside = x[before + 1 : after]
    inner, outer = float(inside[-1] - inside[0]) if inside.size else 0.0, float(x[after] - x[before])
    unsure = abs(outer - inner) / np.sqrt(12.0)
    if inside.size > 1:
        return 0.5 * (inner + outer), unsure
    rising = np.maximum.accumulate(q[before : after + 1])
    low, high = np.interp((-level_N, level_N), rising, x[before : after + 1])
    return float(high - low), unsure


def displacement_at(branch: ObservedBranch, level_N: float, window_N: float, loop: ReducedLoop) -> LocalLine | None:
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


def _sample_error(loop: ReducedLoop, slope_um_per_N: float) -> float:
    """Error of a displacement that one sample tells, whose force is unsure, too [µm]."""
    return float(np.hypot(loop.displacement_noise_um, slope_um_per_N * loop.sample_noise_N))
