"""Travel without force after a reversal, where few samples lie on a stick branch: a play's shelf shows in it.

Of many samples `stick.py` reads displacements on both sides of a shelf. Of few, those at zero force tell how long it is
at the least, and those before and after them how long at the most.
"""

from __future__ import annotations

import numpy as np

from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.model.forward import LoopCourse
from wirewear.diagnosis.model.setup import Array, Setup
from wirewear.diagnosis.observe.differences import ModelLoops, SolverSize, travel_um
from wirewear.diagnosis.observe.local_lines import ObservedBranch
from wirewear.diagnosis.observe.measured_loops import ReducedLoop
from wirewear.diagnosis.observe.observable import OfLoops, OfWholeLoops, Zone
from wirewear.diagnosis.observe.reading import Reading
from wirewear.diagnosis.observe.sites import Site, Sites
from wirewear.diagnosis.observe.stick import FREE_SHARE, SIZE_um, has_few_samples

_KNOWN = constants("observe.shelf")

#: Forces up to this share of the plateau's count as none: the zero of a force may be off, or a guide lean.
SHARE = _KNOWN.number("share")

#: Noise of a force lies below that window by this factor, or the window is wider.
DEVIATIONS = _KNOWN.number("deviations")

#: Solver differences: share of the travel, beside those of two displacements.
TRAVEL_SHARE = _KNOWN.number("travel_share")


class ShelfTravel(OfLoops, OfWholeLoops):
    """One a branch. Levels are the largest forces in N that count as none."""

    name = "shelf"
    words, unit = "travel without force", "um"
    zones = (Zone("shelf", "shelf, where the force is zero", "after a reversal"),)

    def sites(self, reading: Reading) -> list[Site]:
        """Branches of few samples, in all repeats."""
        level = max(SHARE * reading.force_N, DEVIATIONS * reading.sample_noise_N)
        return [
            Site(cycle, sign, level)
            for cycle in reading.cycles
            for side, sign in enumerate((1, -1))
            if has_few_samples([loop.branches[side] for loop in reading.at(cycle)], reading.force_N)
        ]

    def read(self, loop: ReducedLoop, site: Site) -> tuple[float, float]:
        """As the samples say; half of the variance of what they allow is each reading's own."""
        travel, unsure = travel_between(loop.branches[int(site.branch < 0)], site.level)
        return travel, float(np.hypot(np.sqrt(0.5) * unsure, loop.displacement_noise_um))

    def predict(self, course: LoopCourse, sites: Sites) -> Array:
        """Between the same forces, linear between the model's points."""
        return travel_um(course, sites, -sites.level, sites.level)

    def common_error(self, reading: Reading, sites: Sites) -> Array:
        """A drive that repeats itself takes its samples at the same places of every branch: the other half."""
        unsure = [
            travel_between(loop.branches[int(site.branch < 0)], site.level)[1]
            for site in sites
            for loop in reading.at(site.cycle)
        ]
        usual = float(np.nanmedian(unsure)) if np.isfinite(unsure).any() else 0.0
        return np.full(len(sites), np.sqrt(0.5) * usual)

    def solver_error(self, loops: ModelLoops, sites: Sites) -> SolverSize:
        """A share of the travel, and errors of two displacements."""
        travel = self.predict(loops.course, sites)
        return SolverSize(np.hypot(np.sqrt(2.0) * SIZE_um, TRAVEL_SHARE * travel), hooked=False)

    def free_size(self, setup: Setup, predicted: Array) -> Array:
        """A share of the amplitude."""
        return np.full(predicted.size, FREE_SHARE * setup.amplitude_um)


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
