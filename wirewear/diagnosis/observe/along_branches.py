"""Observables along a loop's branches: displacements at equal force where they stick, forces at equal displacement
where they slide.

A branch sticks after its reversal up to the knee, where sliding begins. Just past the knee, the excess over the force
farther on is read, which shows adhesion after a reversal and not the scar's slope. A shelf is a stretch of a branch at
zero force, by free play; a wall is the slope of a scar towards the end of the stroke.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Array
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.observe import observable
from wirewear.diagnosis.observe.local_lines import (
    CHORD_ERROR,
    OUTLYING,
    LocalLine,
    ObservedBranch,
    force_at,
    knees_alike,
    knees_of,
)
from wirewear.diagnosis.observe.measured_loops import FORCE_WINDOW, POSITION_WINDOW, ReducedLoop
from wirewear.diagnosis.observe.observed_record import Reading
from wirewear.diagnosis.surrogate.forward import PredictedLoops
from wirewear.diagnosis.surrogate.sensed_loops import read_along, still_to_come
from wirewear.loops.noise import noise_factor

_OF_STICK = constants("observe.along_branches.stick")

#: Levels as shares of the force at mid-stroke.
FORCES = _OF_STICK.numbers("forces")

#: With at most this many samples on a stick branch, it is read at them: nothing is known between. Of a shelf at Q = 0
#: one sample may catch any place: none is read within this share of the force.
FEW_SAMPLES, SHELF_SHARE = _OF_STICK.count("few_samples"), _OF_STICK.number("shelf_share")

#: Displacements are read from at most so many samples on a side, and from those within so many of the force's steps.
STICK_NEAR, STEPS_NEAR = _OF_STICK.count("stick_near"), _OF_STICK.number("steps_near")

_OF_SHELF = constants("observe.along_branches.shelf")

#: Forces up to this share of the plateau's count as none: the zero of a force may be off, or a guide lean.
SHARE = _OF_SHELF.number("share")

#: Solver differences: share of the travel.
TRAVEL_SHARE = _OF_SHELF.number("travel_share")

_KNOWN = constants("observe.along_branches.plateau")

#: Places along a branch as shares of the reading's amplitude; the first lies so far past the knee at least.
POSITIONS = _KNOWN.numbers("positions")
PAST_KNEE = _KNOWN.number("past_knee")

#: The end of a branch begins at this share of the amplitude.
TIP = _KNOWN.number("tip")

#: Beyond that share of it walls stand, whose shape solvers see apart: over a shorter share are they alike there.
WALL_PLACE, REACH_WALL = _KNOWN.each("wall_place", "reach_wall")
_OF_KNEE_PEAK = constants("observe.along_branches.knee_peak")

#: Solver differences: share of the peak that slopes make, and of how high walls are there.
PEAK_SHARE = _OF_KNEE_PEAK.number("peak_share")

#: Walls are high where slopes raise the force by this share of it.
WALL_HEIGHT = _OF_KNEE_PEAK.number("wall_height")
_OF_WINDOWS = constants("observe.along_branches.knee")

#: Windows of travel past the knee in amplitudes: where a peak stands, and beyond it.
PEAK, BEYOND = _OF_WINDOWS.pair("peak"), _OF_WINDOWS.pair("beyond")


class Stick(observable.ByLocalLines):
    """Displacement at equal force on the stick branches. Levels are forces in N, in the branch's direction."""

    name = "stick"
    words, unit = "displacement at equal force", "um"
    zones = (observable.Zone("stick", "stick, after a reversal", "just after a reversal"),)
    sides = ("ahead of", "behind")
    simulated = of_branches = True

    def sites(self, reading: Reading) -> list[observable.Site]:
        """Sites at forces below the knees of all repeats, where the contact sticks."""
        sites = []
        for cycle in reading.cycles:
            for side, sign in enumerate((1, -1)):
                branches = [loop.branches[side] for loop in reading.at(cycle)]
                sites += [observable.Site(cycle, sign, level) for level in _levels(branches, reading.force_N)]
        return sites

    def line(self, loop: ReducedLoop, site: observable.Site) -> LocalLine | None:
        branch = loop.branches[int(site.branch < 0)]
        # Samples of a shelf at Q = 0, which noise scatters about it, say nothing of the branch beyond it.
        apart = abs(site.level) - OUTLYING * loop.sample_noise_N
        window = FORCE_WINDOW * loop.mid_force_N
        # Within less than the steps to either side, a level is that of the edge between two of them.
        window = max(min(window, max(apart, 0.5 * window)), STEPS_NEAR * loop.force_step_N)
        return displacement_at(branch, site.level, window, loop)

    def predict(self, predicted: PredictedLoops, sites: observable.Sites) -> Array:
        """Displacements (n,) in µm, linear between the model's points; a force beyond a loop's tips gives the end of
        the branch.
        """
        x, q, row = observable.branches_of(predicted, sites)
        return sites.branch * read_along(np.maximum.accumulate(q, axis=1), x, row, sites.level)

    def solver_error(self, loops: observable.ModelLoops, sites: observable.Sites) -> observable.SolverSize:
        """Solver differences in µm. Smooth: the shift of the branch by another force at its reversal. Of each number,
        and common to all: the shift of readings on a shelf by an error of the force's zero.
        """
        turned = observable.SLOPE_SHARE * loops.rise_N(sites) * loops.stick_compliance_um_per_N(sites)
        unsure_N = observable.FORCE_ERROR * loops.scale.force_N
        crossing = loops.travel_um(sites, unsure_N)
        # Where nothing slides as a whole, the branch is all that there is: its zero is a scatter of its own.
        sticks = loops.predicted.slip_um[observable.rows_of(loops.predicted, sites)] == 0.0
        smooth = 4.0 * unsure_N * loops.stick_compliance_um_per_N(sites)
        crossing = np.where(sticks, np.maximum(crossing - smooth, 0.0), crossing) / np.sqrt(12.0)
        # A drive that repeats itself leaves every branch at the same place of a shelf.
        return observable.SolverSize(turned, crossing, crossing * sites.branch)

    def along(self, sites: observable.Sites) -> Array:
        return sites.level

    def smoothness(self, sites: observable.Sites, scale: observable.Scale) -> observable.Smoothness:
        along = sites.level / scale.force_N / observable.REACH
        return replace(observable.Smoothness.of_whole_loops(len(sites)), along=along)


def has_few_samples(branches: list[ObservedBranch], force_N: float) -> bool:
    """True if a repeat's stick branch has at most `FEW_SAMPLES` samples, so that branches are read at these. branches:
    the same branch of each repeat. force_N: force at mid-stroke.
    """
    return min(q.size for q in _samples(branches, force_N)) <= FEW_SAMPLES


def _samples(branches: list[ObservedBranch], force_N: float) -> list[Array]:
    """Forces of the samples that certainly stick, for each branch."""
    top, lowest = min(branch.stick_top_N for branch in branches), FORCES[0] * force_N
    seen = [branch.force_N[: branch.knee + 1] for branch in branches]
    return [q[(q > lowest) & (q < min(top, FORCES[-1] * force_N))] for q in seen]


def _levels(branches: list[ObservedBranch], force_N: float) -> list[float]:
    """Forces at which stick branches are read: evenly spread, or those of the samples if there are few."""
    samples = _samples(branches, force_N)
    count = min(q.size for q in samples)
    if count > FEW_SAMPLES:
        return [at * force_N for at in FORCES if at * force_N < min(branch.stick_top_N for branch in branches)]
    if count == 0:
        return []
    levels = np.median([q[:count] for q in samples], axis=0)
    return sorted(float(at) for at in levels if abs(at) > SHELF_SHARE * force_N)


class ShelfTravel(observable.OfLoops):
    """Travel in µm of a branch along its shelf, while |force| stays below a site's `level` in N, as with free play."""

    name = "shelf"
    words, unit = "travel without force", "um"
    zones = (observable.Zone("shelf", "shelf, where the force is zero", "after a reversal"),)

    def sites(self, reading: Reading) -> list[observable.Site]:
        """A site for each branch that has few samples while it sticks (`has_few_samples`) in some repeat."""
        level = max(SHARE * reading.force_N, OUTLYING * reading.sample_noise_N)
        return [
            observable.Site(cycle, sign, level)
            for cycle in reading.cycles
            for side, sign in enumerate((1, -1))
            if has_few_samples([loop.branches[side] for loop in reading.at(cycle)], reading.force_N)
        ]

    def read(self, loop: ReducedLoop, site: observable.Site) -> tuple[float, float]:
        """Travel in µm and its noise, which includes half the variance by the distance between samples; `common_error`
        has the other half.
        """
        travel, unsure = travel_between(loop.branches[int(site.branch < 0)], site.level)
        return travel, float(np.hypot(np.sqrt(0.5) * unsure, loop.displacement_noise_um))

    def predict(self, predicted: PredictedLoops, sites: observable.Sites) -> Array:
        return observable.travel_um(predicted, sites, -sites.level, sites.level)

    def common_error(self, reading: Reading, sites: observable.Sites) -> Array:
        """Standard deviation (n,) in µm of the error that all repeats share, equal for all sites. It is half the
        variance by the samples' spacing: a repeatable drive samples every branch at the same displacements.
        """
        unsure = [
            travel_between(loop.branches[int(site.branch < 0)], site.level)[1]
            for site in sites
            for loop in reading.at(site.cycle)
        ]
        usual = float(np.nanmedian(unsure)) if np.isfinite(unsure).any() else 0.0
        return np.full(len(sites), np.sqrt(0.5) * usual)

    def solver_error(self, loops: observable.ModelLoops, sites: observable.Sites) -> observable.SolverSize:
        return observable.SolverSize(TRAVEL_SHARE * self.predict(loops.predicted, sites), hooked=False)


def travel_between(branch: ObservedBranch, level_N: float) -> tuple[float, float]:
    """Travel in µm of a branch from −`level_N` to `level_N`, and its standard deviation; NaN if there are too few
    samples.

    It is the mean of the distances between the innermost and between the outermost samples that bracket these forces.
    With fewer than two samples inside, the branch is taken as straight there. Travel is negative where a sensor's
    deflection by the force exceeds it.
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
    """Displacement in µm at which the stick branch reaches a force; None if it does not reach it. window_N: samples
    within this distance of the force are used. loop: gives the noise.
    """
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
    """Error in µm of a displacement from one sample, including that of its force."""
    return float(np.hypot(loop.displacement_noise_um, slope_um_per_N * loop.sample_noise_N))


class PlateauForce(observable.ByLocalLines):
    """Force at equal displacement while sliding. Levels are displacements in µm."""

    name = "plateau"
    words, unit = "force at equal displacement", "N"
    zones = (
        observable.Zone("plateau", "plateau", "on the plateaus"),
        observable.Zone("tip", "end of the stroke", "at the ends of the stroke"),
    )
    simulated = of_branches = True

    def sites(self, reading: Reading) -> list[observable.Site]:
        """Displacements, evenly spread, past the knee of every repeat; the stroke's ends for loops in partial slip."""
        amplitude = reading.amplitude_um
        sites = []
        for cycle in reading.cycles:
            for side, sign in enumerate((1, -1)):
                loops = reading.at(cycle)
                knee = max(loop.branches[side].knee_um for loop in loops) / amplitude
                if any(loop.sticks for loop in loops):
                    knee = TIP - PAST_KNEE
                sites += [
                    observable.Site(cycle, sign, sign * at * amplitude) for at in POSITIONS if at > knee + PAST_KNEE
                ]
        return sites

    def line(self, loop: ReducedLoop, site: observable.Site) -> LocalLine | None:
        branch, window_um = loop.branches[int(site.branch < 0)], POSITION_WINDOW * loop.amplitude_um
        branch = replace(branch, knee=0) if loop.sticks else branch
        return force_at(branch, branch.sign * site.level, window_um, loop.sample_noise_N, loop.correlation)

    def predict(self, predicted: PredictedLoops, sites: observable.Sites) -> Array:
        x, q, row = observable.branches_of(predicted, sites)
        return sites.branch * read_along(still_to_come(x), q, row, self.along(sites))

    def solver_error(self, loops: observable.ModelLoops, sites: observable.Sites) -> observable.SolverSize:
        """Solver differences: the share `SLOPE_SHARE` of the force that slopes add, as worn surfaces have ripples."""
        return observable.SolverSize(observable.SLOPE_SHARE * loops.rise_N(sites))

    def zone(self, sites: observable.Sites, amplitude_um: float) -> NDArray[np.str_]:
        return np.where(self.along(sites) > TIP * amplitude_um, "tip", "plateau")

    def along(self, sites: observable.Sites) -> Array:
        return sites.level * sites.branch

    def smoothness(self, sites: observable.Sites, scale: observable.Scale) -> observable.Smoothness:
        along = self.along(sites) / scale.amplitude_um
        beyond = np.maximum(np.abs(along) - WALL_PLACE, 0.0)
        lengths = np.sign(along) * ((np.abs(along) - beyond) / observable.REACH + beyond / REACH_WALL)
        return replace(observable.Smoothness.of_whole_loops(len(sites)), along=lengths)


class KneePeak(observable.OfLoops):
    """Peak in N where sliding begins (the knee of a branch) over the force farther on, one number for each branch; a
    peak against motion in +x is positive, one against the motion back is negative.
    """

    name = "knee"
    words, unit = "force just past the knee over that beyond", "N"
    zones = (observable.Zone("knee", "knee, where sliding begins"),)
    of_branches = True

    def sites(self, reading: Reading) -> list[observable.Site]:
        return [observable.Site(cycle, sign) for cycle in reading.cycles for sign in (1, -1)]

    def read(self, loop: ReducedLoop, site: observable.Site) -> tuple[float, float]:
        branch = loop.branches[int(site.branch < 0)]

        def read_from(knee: int) -> tuple[float, float]:
            x = branch.displacement_um[knee:]
            return peak_N(x - x[0], branch.force_N[knee:], loop.amplitude_um, loop.correlation)

        alike = knees_alike(branch, loop.mid_force_N, loop.amplitude_um, loop.sample_noise_N)
        found = {knee: read_from(knee) for knee in {branch.knee, *alike}}
        peak, weight = found[branch.knee]
        apart_N = np.nan_to_num(np.ptp([found[knee][0] for knee in alike]))
        return branch.sign * peak, float(np.hypot(loop.sample_noise_N * weight, 0.5 * apart_N))

    def predict(self, predicted: PredictedLoops, sites: observable.Sites) -> Array:
        peaks = computed_peaks_N(predicted.displacement_um, predicted.tangential_force_N)
        return np.asarray(sites.branch * peaks[observable.rows_of(predicted, sites), (sites.branch < 0).astype(int)])

    def solver_error(self, loops: observable.ModelLoops, sites: observable.Sites) -> observable.SolverSize:
        """Solver differences in N at the beginning of a wall, which depend on element size, but hardly on the wall's
        height.
        """
        rise = loops.rise_N(sites)
        high = rise / (1.0 + rise / (WALL_HEIGHT * loops.scale.force_N))
        size = PEAK_SHARE * np.abs(self.predict(loops.predicted, sites))
        return observable.SolverSize(np.hypot(size, PEAK_SHARE * high))

    def smoothness(self, sites: observable.Sites, scale: observable.Scale) -> observable.Smoothness:  # noqa: ARG002
        return replace(observable.Smoothness.of_whole_loops(len(sites)), turned=0.0)


def peak_N(past_um: Array, force_N: Array, amplitude_um: float, correlation: float = 0.0) -> tuple[float, float]:
    """(peak, ratio): by how much a branch's force is larger just past the knee than farther on, in N, and the standard
    deviation of that difference over the noise of one sample.

    past_um, force_N: (m,) displacement from the knee in µm, and force, at the branch's m samples. amplitude_um: of the
    loop's displacement. The peak is the mean force within the window `PEAK` less the mean within `BEYOND`, both given
    in amplitudes past the knee. correlation: coefficient (0 to 1) between the noise of neighbouring samples. Both are
    NaN if `PEAK` holds fewer than 2 or `BEYOND` fewer than 3 samples.
    """
    near, far = ((past_um >= low * amplitude_um) & (past_um <= high * amplitude_um) for low, high in (PEAK, BEYOND))
    counts = int(near.sum()), int(far.sum())
    if counts[0] < 2 or counts[1] < 3:
        return np.nan, np.nan
    weights = near / counts[0] - far / counts[1]
    used = np.flatnonzero(weights)
    return float(weights @ force_N), noise_factor(weights[used], used, correlation)


def computed_peaks_N(displacement_um: Array, force_N: Array) -> Array:
    """`peak_N` (n, 2) of both branches of computed loops (n, 2, m) in order of travel."""
    sign = np.array([1.0, -1.0])[:, None]
    x, q = sign * displacement_um, sign * force_N
    travel = x - x[..., :1]
    amplitude = 0.5 * travel[..., -1:]
    passed = still_to_come(travel)
    knee = knees_of(travel, q, _read(passed, q, amplitude), amplitude)
    from_knee = np.take_along_axis(travel, knee[..., None], axis=-1)
    past = np.concatenate([np.linspace(*PEAK, 6), np.linspace(*BEYOND, 6)])
    at = _read(passed, q, from_knee + amplitude * past)
    peaks: Array = at[..., :6].mean(axis=-1) - at[..., 6:].mean(axis=-1)
    return peaks


def _read(travel: Array, force: Array, at: Array) -> Array:
    """Forces (..., k) at travels (..., k), linear between the points (..., m) of each branch."""
    known, values = (one.reshape(-1, one.shape[-1]) for one in (travel, force))
    rows = np.repeat(np.arange(len(known)), at.shape[-1])
    return read_along(known, values, rows, at.ravel()).reshape(at.shape)
