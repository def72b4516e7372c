"""Force at equal displacement on the plateaus of both branches."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.model.forward import LoopCourse
from wirewear.diagnosis.model.readings import still_to_come
from wirewear.diagnosis.model.setup import Array, Setup
from wirewear.diagnosis.observe.local_lines import LocalLine, force_at
from wirewear.diagnosis.observe.measured_loops import POSITION_WINDOW, ReducedLoop
from wirewear.diagnosis.observe.observable import ByLocalLines, Zone
from wirewear.diagnosis.observe.reading import Reading
from wirewear.diagnosis.observe.sites import ROUGH, ModelLoops, Scale, Site, Sites, Smoothness, SolverSize

_KNOWN = constants("observe.plateau")

#: Places along a branch as shares of the reading's amplitude; the first lies so far past the knee at least.
POSITIONS = _KNOWN.numbers("positions")
PAST_KNEE = _KNOWN.number("past_knee")

#: The end of a branch begins at this share of the amplitude.
TIP = _KNOWN.number("tip")

#: Solver differences: shares of the force that slopes add, and of the plateau force.
SLOPE_SHARE, FORCE_SHARE = _KNOWN.each("slope_share", "force_share")

#: They are alike over this share of the amplitude.
REACH = _KNOWN.number("reach")

#: Beyond that share of it walls stand, whose shape solvers see apart: over a shorter share are they alike there.
WALL_PLACE, REACH_WALL, ROUGH_WALL = _KNOWN.each("wall_place", "reach_wall", "rough_wall")


class PlateauForce(ByLocalLines):
    """Levels are displacements in µm."""

    name = "plateau"
    words, unit = "force at equal displacement", "N"
    zones = (
        Zone("plateau", "plateau", "on the plateaus"),
        Zone("tip", "end of the stroke", "at the ends of the stroke"),
    )
    simulated = True

    def sites(self, reading: Reading) -> list[Site]:
        """Even places past the knee of every repeat."""
        amplitude = reading.amplitude_um
        sites = []
        for cycle in reading.cycles:
            for side, sign in enumerate((1, -1)):
                knee = max(loop.branches[side].knee_um for loop in reading.at(cycle)) / amplitude
                sites += [Site(cycle, sign, sign * at * amplitude) for at in POSITIONS if at > knee + PAST_KNEE]
        return sites

    def line(self, loop: ReducedLoop, site: Site) -> LocalLine | None:
        """Through the samples near the place."""
        branch, window_um = loop.branches[int(site.branch < 0)], POSITION_WINDOW * loop.amplitude_um
        return force_at(branch, branch.sign * site.level, window_um, loop.sample_noise_N, loop.correlation)

    def predict(self, course: LoopCourse, sites: Sites) -> Array:
        """Linear between the model's points."""
        values = np.empty(len(sites))
        for cycle, sign, places in sites.branches:
            row, side = int(np.searchsorted(course.cycles, cycle)), int(sign < 0)
            x, q = course.displacement_um[row, side], course.tangential_force_N[row, side]
            values[places] = np.interp(sign * sites.level[places], still_to_come(sign * x), q)
        return values

    def solver_error(self, loops: ModelLoops, sites: Sites) -> SolverSize:
        """Ripples of the worn surface, and a share of the force."""
        size = np.hypot(SLOPE_SHARE * loops.rise_N(sites), FORCE_SHARE * loops.scale.force_N)
        return SolverSize(size, wall=np.sign(sites.level))

    def free_size(self, setup: Setup, predicted: Array) -> Array:
        """The plateau force."""
        return np.full(predicted.size, setup.plateau_force_N)

    def zone(self, sites: Sites, amplitude_um: float) -> NDArray[np.str_]:
        """The end of the stroke is one of its own."""
        return np.where(self.along(sites) > TIP * amplitude_um, "tip", "plateau")

    def along(self, sites: Sites) -> Array:
        """Displacement in the branch's direction."""
        return sites.level * sites.branch

    def smoothness(self, sites: Sites, scale: Scale) -> Smoothness:
        """Smooth along the stroke, least at the walls."""
        whole = Smoothness.of_whole_loops(len(sites))
        along = self.along(sites) / scale.amplitude_um
        beyond = np.maximum(np.abs(along) - WALL_PLACE, 0.0)
        lengths = np.sign(along) * ((np.abs(along) - beyond) / REACH + beyond / REACH_WALL)
        return Smoothness(lengths, 1.0, np.where(beyond > 0.0, ROUGH_WALL, ROUGH), whole.family)
