"""Results of a fit: parameters with their intervals, and the figures behind them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import stdtrit

from geometry.arrays import Array
from wirewear.base.frame import notebook_table
from wirewear.base.units import UNIT_SYMBOLS
from wirewear.diagnosis.fit.fast_fit import FITTED
from wirewear.records import AnyRecord
from wirewear.results import RunResult
from wirewear.test import AnyStudy

#: Logarithm of the factor beyond which an interval is as good as open: Student's t of two tests leaves at most that.
_OPEN = float(stdtrit(1, 0.975))


@dataclass(frozen=True)
class FittedParameter:
    """Fitted number and the interval that contains the true one with a probability of 95 %."""

    value: float
    interval95: tuple[float, float]
    unit: str  #: A key of `wirewear.base.units.UNIT_SYMBOLS`.
    repeats: int  #: Number of tests that it is based on.

    @classmethod
    def of_repeats(cls, values: ArrayLike, unit: str, deviation: float = 0.0) -> FittedParameter:
        """Mean of one value for each test, with an interval by Student's t for their scatter.

        deviation: known standard deviation of an error that all tests share, added to the interval in squares. For
        positive values the interval is that of the logarithm, so that both ends are positive. A single value has no
        scatter.
        """
        found = np.atleast_1d(np.asarray(values, dtype=np.float64))
        count, mean = found.size, float(found.mean())
        scatter = float(found.std(ddof=1)) if count > 1 else 0.0
        wide = float(stdtrit(count - 1, 0.975)) * scatter / np.sqrt(count) if count > 1 else 0.0
        half = float(np.hypot(wide, 1.96 * deviation))
        if (found > 0.0).all():
            factor = float(np.exp(min(half / mean, _OPEN)))
            return cls(mean, (mean / factor, mean * factor), unit, count)
        return cls(mean, (mean - half, mean + half), unit, count)

    @property
    def deviation(self) -> float:
        """Standard deviation of a normal distribution with this 95 % interval."""
        return (self.interval95[1] - self.interval95[0]) / 3.92


@dataclass(frozen=True, eq=False, repr=False)
class FittedTest:
    """Result of fitting a record: a study of its test with the fitted parameters."""

    record: AnyRecord
    study: AnyStudy
    #: Fitted parameters of the study by name; absent if the record does not show them.
    parameters: dict[str, FittedParameter]
    found: dict[str, FittedParameter]  #: Further figures by name: energies, volumes, stiffnesses of loop and contact.
    notes: tuple[str, ...] = field(default=())  #: Sentences on what is missing or assumed.
    rigid_N_per_mm: float = 1e6  #: Stiffness from which the loops cannot resolve the rig's.

    def __repr__(self) -> str:
        found = ", ".join(f"{name} = {one.value:.4g}" for name, one in self.parameters.items())
        return f"<Fit of {self.record.name!r}: {found}>"

    def _repr_html_(self) -> str:
        rows = {
            name: f"{one.value:.4g} ({one.interval95[0]:.4g} to {one.interval95[1]:.4g}){UNIT_SYMBOLS[one.unit]}"
            for name, one in (self.parameters | self.found).items()
        }
        return notebook_table(f"fit of “{self.record.name}”", rows, note=" ".join(self.notes))


@dataclass(frozen=True, eq=False)
class CheckedRun:
    """A run of the fitted study beside its record.

    result: the run. cycles: (c,). measured, simulated: (c, FITTED) figures of the record and of the run; NaN where
    missing. deviations: (c, FITTED) standard deviations of one test.
    """

    result: RunResult
    cycles: Array
    measured: Array
    simulated: Array
    deviations: Array

    @property
    def differences(self) -> dict[str, float]:
        """Mean relative difference over the cycles, run less record, by name of each figure that both have."""
        found = {}
        for place, name in enumerate(FITTED):
            share = self.simulated[:, place] / self.measured[:, place] - 1.0
            if np.isfinite(share).any():
                found[name] = float(np.nanmean(share))
        return found

    @property
    def scatters(self) -> float | None:
        """Root mean square of all differences over the standard deviations of one test; None if no figure is common."""
        both = np.isfinite(self.simulated - self.measured)
        off = (self.simulated - self.measured)[both] / self.deviations[both]
        return float(np.sqrt(np.mean(off**2))) if both.any() else None
