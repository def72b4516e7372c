"""Force just past the knee over that beyond it: adhesion after a reversal shows there."""

from __future__ import annotations

import numpy as np

from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.model.forward import LoopCourse
from wirewear.diagnosis.model.setup import Array, Setup
from wirewear.diagnosis.observe.knee import computed_peaks_N, peak_N
from wirewear.diagnosis.observe.measured_loops import ReducedLoop
from wirewear.diagnosis.observe.observable import OfLoops, OfWholeLoops, Zone
from wirewear.diagnosis.observe.reading import Reading
from wirewear.diagnosis.observe.sites import ModelLoops, Scale, Site, Sites, Smoothness, SolverSize, rows_of

_KNOWN = constants("observe.knee_peak")

#: Solver differences: shares of the plateau force, of the peak that slopes make, and of how high walls are there.
FORCE_SHARE, PEAK_SHARE, WALL_SHARE = _KNOWN.each("force_share", "peak_share", "wall_share")

#: Walls are high where slopes raise the force by this share of it.
WALL_HEIGHT = _KNOWN.number("wall_height")


class KneePeak(OfLoops, OfWholeLoops):
    """One a branch, positive along +x."""

    name = "knee"
    words, unit = "force just past the knee over that beyond", "N"
    zones = (Zone("knee", "knee, where sliding begins"),)

    def sites(self, reading: Reading) -> list[Site]:
        """Both branches of every loop."""
        return [Site(cycle, sign) for cycle in reading.cycles for sign in (1, -1)]

    def read(self, loop: ReducedLoop, site: Site) -> tuple[float, float]:
        """Means over two windows past the knee."""
        branch = loop.branches[int(site.branch < 0)]
        x = branch.displacement_um[branch.knee :]
        peak, weight = peak_N(x - x[0], branch.force_N[branch.knee :], loop.amplitude_um, loop.correlation)
        return branch.sign * peak, loop.sample_noise_N * weight

    def predict(self, course: LoopCourse, sites: Sites) -> Array:
        """The same of computed branches."""
        peaks = computed_peaks_N(course.displacement_um, course.tangential_force_N)
        return np.asarray(sites.branch * peaks[rows_of(course, sites), (sites.branch < 0).astype(int)])

    def solver_error(self, loops: ModelLoops, sites: Sites) -> SolverSize:
        """How steep a wall begins depends on the elements as soon as there is one, and no more once it is high."""
        force, rise = loops.scale.force_N, loops.rise_N(sites)
        high = rise / (1.0 + rise / (WALL_HEIGHT * force))
        size = np.hypot(FORCE_SHARE * force, PEAK_SHARE * np.abs(self.predict(loops.course, sites)))
        return SolverSize(np.hypot(size, WALL_SHARE * high), wall=-sites.branch.astype(float))

    def free_size(self, setup: Setup, predicted: Array) -> Array:
        """The plateau force."""
        return np.full(predicted.size, setup.plateau_force_N)

    def smoothness(self, sites: Sites, scale: Scale) -> Smoothness:  # noqa: ARG002
        """Each branch has its knee at a wall of its own."""
        whole = Smoothness.of_whole_loops(len(sites))
        return Smoothness(whole.along, 0.0, whole.rough, whole.family)
