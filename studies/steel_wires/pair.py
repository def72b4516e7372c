"""The steel wires' test on a rigid and on a compliant rig: both runs, and the figures of their loops."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from wirewear import ResultError
from wirewear.loops import LoopFigures, Measured, analyse_loop
from wirewear.results import Loop, RunResult, read_results

#: Cycles whose loops and sections the article shows; from the middle one on it calls the loops plainly distorted.
EARLY, DISTORTED, LATE = 100, 10_000, 100_000

WIRES = ("moving", "fixed")


@dataclass(frozen=True)
class Pair:
    """Results of one test on a rigid and on a compliant rig."""

    rigid: RunResult
    compliant: RunResult

    @property
    def runs(self) -> tuple[RunResult, RunResult]:
        """Both runs, the real rig first."""
        return self.compliant, self.rigid


def read_pair(folder: Path) -> Pair:
    """The runs "rigid" and "compliant" in `folder`. Raises ResultError if one of them is missing or cannot be read."""
    runs = {result.variant: result for result in read_results(folder)}
    if missing := {"rigid", "compliant"} - runs.keys():
        raise ResultError(f"{folder} lacks the variant(s) {', '.join(sorted(missing))}, which the comparison needs")
    for name in ("rigid", "compliant"):
        if not runs[name].loops or not {"wires", "conditions", "contact", "wear", "holder"} <= runs[name].study.keys():
            raise ResultError(f"the variant {name} in {folder} has logged no loop or is no run of this study with wear")
    return Pair(runs["rigid"], runs["compliant"])


def analysed(loop: Loop) -> LoopFigures:
    """The figures of a simulated loop."""
    return analyse_loop(loop.displacement_um, loop.tangential_force_N, loop.normal_force_N, time_s=loop.time_s)


def value_of(measured: Measured | None) -> float:
    """NaN, of which no statement holds, where the figure has no meaning."""
    return np.nan if measured is None else measured.value
