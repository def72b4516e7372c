"""Channels as a whole: the displacement's amplitude, and the normal force along the stroke while the contact slides.

Whatever guides the load shows in the normal force, and nothing that wears: the scar lifts the wires by micrometres.
"""

from abc import abstractmethod

import numpy as np

from geometry.arrays import Array, BoolArray
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.model.forward import LoopCourse
from wirewear.diagnosis.model.readings import SLIDING
from wirewear.diagnosis.model.setup import Setup
from wirewear.diagnosis.observe.measured_loops import ReducedLoop
from wirewear.diagnosis.observe.observable import OfLoops, Site, Sites, Zone, rows_of
from wirewear.diagnosis.observe.reading import Reading

_KNOWN = constants("observe.normal_along")

#: The middle of the stroke reaches so far, its ends begin there, as shares of the amplitude.
MIDDLE, OUTER = _KNOWN.each("middle", "outer")

#: Samples that a part of the stroke has at least.
FEWEST = _KNOWN.count("fewest")


class _OfNormalForce(OfLoops):
    """Read where the normal force was measured."""

    simulated = True

    def sites(self, reading: Reading) -> list[Site]:
        """Every cycle at which a repeat has it."""
        return [Site(cycle) for cycle in reading.cycles if any(loop.normal_N for loop in reading.at(cycle))]

    def whole(self, setup: Setup, predicted: Array) -> Array:
        """The load."""
        return np.full(predicted.size, setup.load_N)


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


class _AlongStroke(OfLoops):
    """Mean load of one part of the stroke less that of another, over both branches."""

    unit = "N"

    @abstractmethod
    def parts(self, place: Array) -> tuple[BoolArray, BoolArray]:
        """Which places, over the amplitude, belong to one part, and which to the other."""

    def sites(self, reading: Reading) -> list[Site]:
        """Every cycle at which a repeat has it."""
        return [
            Site(cycle)
            for cycle in reading.cycles
            if any(branch.normal_N is not None for loop in reading.at(cycle) for branch in loop.branches)
        ]

    def read(self, loop: ReducedLoop, site: Site) -> tuple[float, float]:  # noqa: ARG002
        """The mean of what each branch says."""
        values, variances = [], []
        for branch in loop.branches:
            if branch.normal_N is None:
                return np.nan, np.nan
            slides = np.arange(branch.displacement_um.size) > branch.knee
            place = branch.sign * branch.displacement_um / loop.amplitude_um
            one, other = (branch.normal_N[slides & part] for part in self.parts(place))
            if min(one.size, other.size) < FEWEST:
                return np.nan, np.nan
            values.append(float(np.median(one) - np.median(other)))
            # The mean of a branch has this error, of all its samples together.
            variances.append(loop.normal_error_N**2 * np.count_nonzero(slides) * (1.0 / one.size + 1.0 / other.size))
        # A median of normal deviates scatters by a factor √(π/2) more than their mean.
        return 0.5 * sum(values), float(0.5 * np.sqrt(0.5 * np.pi * sum(variances)))

    def predict(self, course: LoopCourse, sites: Sites) -> Array:
        """The same of computed branches."""
        x, load = course.displacement_um, course.normal_force_N[..., SLIDING:]
        place = x[..., SLIDING:] / (0.5 * np.ptp(x, axis=(1, 2)))[:, None, None]
        one, other = (_medians(load, part) for part in self.parts(place))
        both = np.isfinite(one) & np.isfinite(other)
        found: Array = 0.5 * np.subtract(one, other, out=np.zeros_like(one), where=both).sum(axis=1)
        return found[rows_of(course, sites)]


def _medians(values: Array, chosen: BoolArray) -> Array:
    """Medians (...) of the chosen ones among values (..., m), infinite where none is."""
    ordered = np.sort(np.where(chosen, values, np.inf), axis=-1)
    count = np.count_nonzero(chosen, axis=-1)[..., None]
    low, high = (np.take_along_axis(ordered, np.maximum(at, 0), axis=-1) for at in ((count - 1) // 2, count // 2))
    medians: Array = 0.5 * (low + high)[..., 0]
    return medians


class NormalForceAtEnds(_AlongStroke):
    """Both ends of the stroke beside its middle."""

    name = "normal_ends"
    words = "normal force, ends of the stroke less its middle"
    zones = (Zone("normal_ends", "normal force at the ends"),)

    def parts(self, place: Array) -> tuple[BoolArray, BoolArray]:
        """What lies outside, what lies inside."""
        return np.abs(place) > OUTER, np.abs(place) < MIDDLE


class NormalForceBySides(_AlongStroke):
    """The end at +x less that at −x, as each branch reaches them while it slides."""

    name = "normal_sides"
    words = "normal force, one side of the stroke less the other"
    zones = (Zone("normal_sides", "normal force by side"),)

    def parts(self, place: Array) -> tuple[BoolArray, BoolArray]:
        """What lies to the right, what lies to the left."""
        return place > MIDDLE, place < -MIDDLE


class Amplitude(OfLoops):
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
