"""The normal force while the contact slides: its mean, and by how much the branch towards +x has more of it."""

from __future__ import annotations

import numpy as np

from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.model.branches import SLIDING
from wirewear.diagnosis.model.forward import LoopCourse
from wirewear.diagnosis.model.setup import Array, Setup
from wirewear.diagnosis.observe.differences import ModelLoops, SolverSize
from wirewear.diagnosis.observe.measured_loops import ReducedLoop
from wirewear.diagnosis.observe.observable import OfLoops, OfWholeLoops, Zone
from wirewear.diagnosis.observe.reading import Reading
from wirewear.diagnosis.observe.sites import Site, Sites, rows_of

_KNOWN = constants("observe.normal_force")

#: Solver differences, relative to the load: of the mean, and of the difference.
MEAN_SHARE, DIRECTION_SHARE = _KNOWN.each("mean_share", "direction_share")

#: A difference of free shape between both branches may be so large a share of the load.
FREE_SHARE = _KNOWN.number("free_share")


class _OfNormalForce(OfLoops, OfWholeLoops):
    """Read where the normal force was measured."""

    simulated = True

    def sites(self, reading: Reading) -> list[Site]:
        """Every cycle at which a repeat has it."""
        return [Site(cycle) for cycle in reading.cycles if any(loop.normal_N for loop in reading.at(cycle))]


class NormalForce(_OfNormalForce):
    """Mean of both branches."""

    name = "normal"
    words, unit = "normal force", "N"
    zones = (Zone("normal", "normal force"),)

    def read(self, loop: ReducedLoop, site: Site) -> tuple[float, float]:  # noqa: ARG002
        """Mean over what slides."""
        if loop.normal_N is None:
            return np.nan, np.nan
        return float(np.mean(loop.normal_N)), loop.normal_error_N / float(np.sqrt(2.0))

    def predict(self, course: LoopCourse, sites: Sites) -> Array:
        """Mean over what slides."""
        p = course.normal_force_N
        return np.asarray(p[:, :, SLIDING:].mean(axis=(1, 2)))[rows_of(course, sites)]

    def solver_error(self, loops: ModelLoops, sites: Sites) -> SolverSize:
        """A share of it."""
        return SolverSize(MEAN_SHARE * np.abs(self.predict(loops.course, sites)))

    def free_size(self, setup: Setup, predicted: Array) -> Array:  # noqa: ARG002
        """Its own."""
        return np.abs(predicted)


class NormalForceByDirection(_OfNormalForce):
    """Mean of the branch towards +x less that of the other."""

    name = "normal_direction"
    words, unit = "normal force, forward less backward", "N"
    zones = (Zone("normal_direction", "normal force by direction"),)

    def read(self, loop: ReducedLoop, site: Site) -> tuple[float, float]:  # noqa: ARG002
        """Means over what slides."""
        if loop.normal_N is None:
            return np.nan, np.nan
        return loop.normal_N[0] - loop.normal_N[1], loop.normal_error_N * float(np.sqrt(2.0))

    def predict(self, course: LoopCourse, sites: Sites) -> Array:
        """Means over what slides."""
        forward, backward = (course.normal_force_N[:, side, SLIDING:].mean(axis=1) for side in (0, 1))
        return np.asarray(forward - backward)[rows_of(course, sites)]

    def solver_error(self, loops: ModelLoops, sites: Sites) -> SolverSize:
        """A share of the load."""
        return SolverSize(np.full(len(sites), DIRECTION_SHARE * loops.setup.load_N))

    def free_size(self, setup: Setup, predicted: Array) -> Array:
        """A share of the load."""
        return np.full(predicted.size, FREE_SHARE * setup.load_N)
