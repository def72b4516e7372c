"""Displacement amplitude of the logged loops."""

from __future__ import annotations

import numpy as np

from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.model.forward import LoopCourse
from wirewear.diagnosis.model.setup import Array, Setup
from wirewear.diagnosis.observe.differences import ModelLoops, SolverSize
from wirewear.diagnosis.observe.measured_loops import ReducedLoop
from wirewear.diagnosis.observe.observable import OfLoops, OfWholeLoops, Zone
from wirewear.diagnosis.observe.reading import Reading
from wirewear.diagnosis.observe.sites import Site, Sites, rows_of

_KNOWN = constants("observe.amplitude")

#: Solver differences, relative.
SHARE = _KNOWN.number("share")


class Amplitude(OfLoops, OfWholeLoops):
    """Half of a loop's extent."""

    name = "amplitude"
    words, unit = "displacement amplitude", "um"
    zones = (Zone("amplitude", "displacement amplitude"),)

    def sites(self, reading: Reading) -> list[Site]:
        """Every loop."""
        return [Site(cycle) for cycle in reading.cycles]

    def read(self, loop: ReducedLoop, site: Site) -> tuple[float, float]:  # noqa: ARG002
        """As the loop was cleaned."""
        return loop.amplitude_um, loop.amplitude_error_um

    def predict(self, course: LoopCourse, sites: Sites) -> Array:
        """Half of the computed loop's extent."""
        x = course.displacement_um
        return np.asarray(0.5 * (x.max(axis=(1, 2)) - x.min(axis=(1, 2))))[rows_of(course, sites)]

    def solver_error(self, loops: ModelLoops, sites: Sites) -> SolverSize:
        """A share of it."""
        return SolverSize(SHARE * np.abs(self.predict(loops.course, sites)))

    def free_size(self, setup: Setup, predicted: Array) -> Array:  # noqa: ARG002
        """Its own."""
        return np.abs(predicted)
