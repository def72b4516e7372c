"""Force of the sliding branches: at equal displacement, and just past the knee over that beyond it.

A peak past the knee, which adhesion after a reversal makes, is no slope of the scar.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Array
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.model.forward import LoopCourse
from wirewear.diagnosis.model.readings import read_along, still_to_come
from wirewear.diagnosis.observe import observable
from wirewear.diagnosis.observe.local_lines import LocalLine, force_at, knees_of
from wirewear.diagnosis.observe.measured_loops import POSITION_WINDOW, ReducedLoop
from wirewear.diagnosis.observe.reading import Reading
from wirewear.loops.noise import noise_factor

_KNOWN = constants("observe.plateau")

#: Places along a branch as shares of the reading's amplitude; the first lies so far past the knee at least.
POSITIONS = _KNOWN.numbers("positions")
PAST_KNEE = _KNOWN.number("past_knee")

#: The end of a branch begins at this share of the amplitude.
TIP = _KNOWN.number("tip")

#: Beyond that share of it walls stand, whose shape solvers see apart: over a shorter share are they alike there.
WALL_PLACE, REACH_WALL = _KNOWN.each("wall_place", "reach_wall")

_OF_KNEE_PEAK = constants("observe.knee_peak")

#: Solver differences: share of the peak that slopes make, and of how high walls are there.
PEAK_SHARE = _OF_KNEE_PEAK.number("peak_share")

#: Walls are high where slopes raise the force by this share of it.
WALL_HEIGHT = _OF_KNEE_PEAK.number("wall_height")

_OF_WINDOWS = constants("observe.knee")

#: Windows of travel past the knee in amplitudes: where a peak stands, and beyond it.
PEAK, BEYOND = _OF_WINDOWS.pair("peak"), _OF_WINDOWS.pair("beyond")


class PlateauForce(observable.ByLocalLines):
    """Levels are displacements in µm."""

    name = "plateau"
    words, unit = "force at equal displacement", "N"
    zones = (
        observable.Zone("plateau", "plateau", "on the plateaus"),
        observable.Zone("tip", "end of the stroke", "at the ends of the stroke"),
    )
    simulated = True

    def sites(self, reading: Reading) -> list[observable.Site]:
        """Even places past the knee of every repeat."""
        amplitude = reading.amplitude_um
        sites = []
        for cycle in reading.cycles:
            for side, sign in enumerate((1, -1)):
                knee = max(loop.branches[side].knee_um for loop in reading.at(cycle)) / amplitude
                sites += [
                    observable.Site(cycle, sign, sign * at * amplitude) for at in POSITIONS if at > knee + PAST_KNEE
                ]
        return sites

    def line(self, loop: ReducedLoop, site: observable.Site) -> LocalLine | None:
        """Through the samples near the place."""
        branch, window_um = loop.branches[int(site.branch < 0)], POSITION_WINDOW * loop.amplitude_um
        return force_at(branch, branch.sign * site.level, window_um, loop.sample_noise_N, loop.correlation)

    def predict(self, course: LoopCourse, sites: observable.Sites) -> Array:
        """Linear between the model's points."""
        x, q, row = observable.branches_of(course, sites)
        return sites.branch * read_along(still_to_come(x), q, row, self.along(sites))

    def solver_error(self, loops: observable.ModelLoops, sites: observable.Sites) -> observable.SolverSize:
        """Ripples of the worn surface."""
        return observable.SolverSize(observable.SLOPE_SHARE * loops.rise_N(sites))

    def zone(self, sites: observable.Sites, amplitude_um: float) -> NDArray[np.str_]:
        """The end of the stroke is one of its own."""
        return np.where(self.along(sites) > TIP * amplitude_um, "tip", "plateau")

    def along(self, sites: observable.Sites) -> Array:
        """Displacement in the branch's direction."""
        return sites.level * sites.branch

    def smoothness(self, sites: observable.Sites, scale: observable.Scale) -> observable.Smoothness:
        """Smooth along the stroke, least at the walls."""
        along = self.along(sites) / scale.amplitude_um
        beyond = np.maximum(np.abs(along) - WALL_PLACE, 0.0)
        lengths = np.sign(along) * ((np.abs(along) - beyond) / observable.REACH + beyond / REACH_WALL)
        return replace(observable.Smoothness.of_whole_loops(len(sites)), along=lengths)


class KneePeak(observable.OfLoops):
    """One a branch, positive along +x."""

    name = "knee"
    words, unit = "force just past the knee over that beyond", "N"
    zones = (observable.Zone("knee", "knee, where sliding begins"),)

    def sites(self, reading: Reading) -> list[observable.Site]:
        """Both branches of every loop."""
        return [observable.Site(cycle, sign) for cycle in reading.cycles for sign in (1, -1)]

    def read(self, loop: ReducedLoop, site: observable.Site) -> tuple[float, float]:
        """Means over two windows past the knee."""
        branch = loop.branches[int(site.branch < 0)]
        x = branch.displacement_um[branch.knee :]
        peak, weight = peak_N(x - x[0], branch.force_N[branch.knee :], loop.amplitude_um, loop.correlation)
        return branch.sign * peak, loop.sample_noise_N * weight

    def predict(self, course: LoopCourse, sites: observable.Sites) -> Array:
        """The same of computed branches."""
        peaks = computed_peaks_N(course.displacement_um, course.tangential_force_N)
        return np.asarray(sites.branch * peaks[observable.rows_of(course, sites), (sites.branch < 0).astype(int)])

    def solver_error(self, loops: observable.ModelLoops, sites: observable.Sites) -> observable.SolverSize:
        """How steep a wall begins depends on the elements as soon as there is one, and no more once it is high."""
        rise = loops.rise_N(sites)
        high = rise / (1.0 + rise / (WALL_HEIGHT * loops.scale.force_N))
        size = PEAK_SHARE * np.abs(self.predict(loops.course, sites))
        return observable.SolverSize(np.hypot(size, PEAK_SHARE * high))

    def smoothness(self, sites: observable.Sites, scale: observable.Scale) -> observable.Smoothness:  # noqa: ARG002
        """Each branch has its knee at a wall of its own."""
        return replace(observable.Smoothness.of_whole_loops(len(sites)), turned=0.0)


def peak_N(past_um: Array, force_N: Array, amplitude_um: float, correlation: float = 0.0) -> tuple[float, float]:
    """Mean force of a branch (m,) in the window of the peak less that beyond, and the factor from noise to its error.

    `past_um` is measured from the knee. NaN where a window holds too few samples.
    """
    near, far = ((past_um >= low * amplitude_um) & (past_um <= high * amplitude_um) for low, high in (PEAK, BEYOND))
    counts = int(near.sum()), int(far.sum())
    if counts[0] < 2 or counts[1] < 3:
        return np.nan, np.nan
    weights = near / counts[0] - far / counts[1]
    used = np.flatnonzero(weights)
    return float(weights @ force_N), noise_factor(weights[used], used, correlation)


def computed_peaks_N(displacement_um: Array, force_N: Array) -> Array:
    """The same of computed branches (n, 2, m), both in order of travel, (n, 2)."""
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
    """Forces (..., k) at travels, linear between the points (..., m) of each branch."""
    known, values = (one.reshape(-1, one.shape[-1]) for one in (travel, force))
    rows = np.repeat(np.arange(len(known)), at.shape[-1])
    return read_along(known, values, rows, at.ravel()).reshape(at.shape)
