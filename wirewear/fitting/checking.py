"""A fit checked by a finite element run with its parameters."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from wirewear.fitting.loops_of_tests import FITTED, loops_of_tests
from wirewear.fitting.values import FittedTest
from wirewear.kinds import kind_of
from wirewear.loops import LoopError
from wirewear.records.exporting import true_loop
from wirewear.results import read_loops

if TYPE_CHECKING:
    from wirewear.results import RunResult

Array = NDArray[np.float64]
ObserverOf = Callable[[str], "AbstractContextManager[Any]"]


@dataclass(frozen=True, eq=False)
class CheckedRun:
    """Figures (cycles, FITTED) of the record, of the run, and what a test scatters; NaN where one is missing."""

    result: RunResult
    cycles: Array
    measured: Array
    simulated: Array
    deviations: Array

    @property
    def differences(self) -> dict[str, float]:
        """Mean relative difference, run less record, of each figure; those that both have."""
        found = {}
        for place, name in enumerate(FITTED):
            share = self.simulated[:, place] / self.measured[:, place] - 1.0
            if np.isfinite(share).any():
                found[name] = float(np.nanmean(share))
        return found

    @property
    def scatters(self) -> float | None:
        """Root mean square of all differences over what one test scatters; None where run and record share none."""
        both = np.isfinite(self.simulated - self.measured)
        off = (self.simulated - self.measured)[both] / self.deviations[both]
        return float(np.sqrt(np.mean(off**2))) if both.any() else None


def check_by_run(fitted: FittedTest, output: Path, fidelity: str, observer_of: ObserverOf | None = None) -> CheckedRun:
    """Run the fitted study, and set its loops beside those of the record.

    Raises:
        StudyError, SolverError, RunError: the run cannot be made or written.
    """
    from wirewear.simulation import NoObserver

    tests = loops_of_tests(fitted.record)
    quiet = observer_of or (lambda _: nullcontext(NoObserver()))
    kind, length_mm = kind_of(fitted.record), fitted.record.tables.length_mm
    (result,) = kind.run(fitted.study, fidelity=fidelity, output=output, observer_of=quiet)
    whole = result if length_mm is None else result.of_length(length_mm)
    loops = {loop.cycle: true_loop(loop) for loop in read_loops(whole)}
    simulated = np.full((tests.cycles.size, len(FITTED)), np.nan)
    for row, cycle in enumerate(tests.cycles):
        if (loop := loops.get(int(cycle))) is None:
            continue
        try:
            figures = loop.figures(fitted.record.tables.conditions.normal_load_N)
        except LoopError:
            continue
        values = (getattr(figures, name) for name in FITTED)
        simulated[row] = [np.nan if value is None else value.value for value in values]
    return CheckedRun(result, tests.cycles, tests.mean, simulated, tests.deviations)
