"""An observable that detects a bent guide, which presses the bodies together harder at the ends of the stroke."""

import numpy as np
from numpy.typing import NDArray

from wirewear.diagnosis.observe import (
    ModelLoops,
    OfLoops,
    PredictedLoops,
    Reading,
    ReducedLoop,
    Site,
    Sites,
    SolverSize,
    Zone,
    rows_of,
)


class NormalBowl(OfLoops):
    """Normal force beyond 60 % of the stroke less that within 30 %, mean of both branches."""

    name = "normal_bowl"
    words, unit = "normal force at the ends of the stroke over that in the middle", "N"
    zones = (Zone("normal_bowl", "normal force along the stroke"),)

    def sites(self, reading: Reading) -> list[Site]:
        """The cycles that have a normal force."""
        return [Site(cycle) for cycle in reading.cycles if any(loop.normal_N for loop in reading.at(cycle))]

    def read(self, loop: ReducedLoop, site: Site) -> tuple[float, float]:  # noqa: ARG002
        """Difference of the medians of both parts, N."""
        bowls, shares = [], []
        for branch in loop.branches:
            if branch.normal_N is None:
                return np.nan, np.nan
            place = np.abs(branch.displacement_um[branch.knee :]) / loop.amplitude_um
            force = branch.normal_N[branch.knee :]
            ends, middle = force[place > 0.6], force[place < 0.3]
            if min(ends.size, middle.size) < 3:
                return np.nan, np.nan
            bowls.append(np.median(ends) - np.median(middle))
            shares.append(force.size * (1.0 / ends.size + 1.0 / middle.size))
        return float(np.mean(bowls)), loop.normal_error_N * float(np.sqrt(np.mean(shares)))

    def predict(self, predicted: PredictedLoops, sites: Sites) -> NDArray[np.float64]:
        """Normal force (n,) in N of computed loops: mean at the ends of the stroke less mean in its middle."""
        place = np.abs(predicted.displacement_um) / np.abs(predicted.displacement_um).max(axis=(1, 2), keepdims=True)
        force = predicted.normal_force_N
        ends, middle = (np.nanmean(np.where(there, force, np.nan), axis=(1, 2)) for there in (place > 0.6, place < 0.3))
        difference: NDArray[np.float64] = (ends - middle)[rows_of(predicted, sites)]
        return difference

    def solver_error(self, loops: ModelLoops, sites: Sites) -> SolverSize:
        """Standard deviation (n,) in N by which two solvers may differ: 0.2 % of the load."""
        return SolverSize(np.full(len(sites), 0.002 * loops.setup.load_N))
