"""Uncertainty budgets of measured figures after the GUM (JCGM 100:2008): contributions, combined, expanded."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, sqrt
from typing import Literal

import numpy as np
from scipy.stats import t as students_t

Distribution = Literal["normal", "rectangular", "t"]

COVERAGE = 0.95  #: Probability that a figure lies within its expanded uncertainty.


@dataclass(frozen=True)
class Contribution:
    """One line of a budget.

    kind: "A" for an evaluation by statistics of repeats, "B" for any other. value: estimate of the input, in `unit`.
    uncertainty: its standard uncertainty. sensitivity: change of the figure per unit of the input. freedom: degrees of
    freedom. how: where it comes from.
    """

    source: str
    kind: Literal["A", "B"]
    value: float
    unit: str
    distribution: Distribution
    uncertainty: float
    sensitivity: float
    freedom: float = inf
    how: str = ""

    @property
    def share(self) -> float:
        """Standard uncertainty of the figure by this contribution alone, in the figure's unit."""
        return abs(self.sensitivity) * self.uncertainty


@dataclass(frozen=True)
class Budget:
    """A figure with its contributions, which are independent."""

    name: str
    symbol: str
    value: float
    unit: str
    contributions: tuple[Contribution, ...]

    @property
    def combined(self) -> float:
        """Combined standard uncertainty (GUM, equation 10)."""
        return sqrt(sum(one.share**2 for one in self.contributions))

    @property
    def freedom(self) -> float:
        """Effective degrees of freedom (Welch and Satterthwaite; GUM, equation G.2b)."""
        lost = sum(one.share**4 / one.freedom for one in self.contributions)
        return self.combined**4 / lost if lost > 0.0 else inf

    @property
    def coverage(self) -> float:
        """Coverage factor for a probability of 95 %: Student's t at the effective degrees of freedom, rounded down."""
        whole = np.floor(round(self.freedom, 1)) if self.freedom < 1e6 else inf
        return float(students_t.ppf(0.5 * (1.0 + COVERAGE), max(whole, 1.0)))

    @property
    def expanded(self) -> float:
        return self.coverage * self.combined


def of_repeats(values: Sequence[float], unit: str, expected: float, why: str) -> Contribution:
    """What tests on fresh specimens scatter by, for the mean of their values. expected: relative scatter that stands in
    where there is one test alone; why: where that comes from.
    """
    count, mean = len(values), float(np.mean(values))
    if count < 2:
        return Contribution(
            "scatter between specimens", "B", mean, unit, "normal", expected * abs(mean), 1.0, how=f"one test: {why}"
        )
    deviation = float(np.std(values, ddof=1)) / sqrt(count)
    how = f"standard deviation of the mean of {count} tests"
    return Contribution("scatter between specimens", "A", mean, unit, "t", deviation, 1.0, count - 1.0, how)


def of_gain(channel: str, relative: float, sensitivity: float) -> Contribution:
    """The calibration of a channel: read over true, 1, with a relative standard uncertainty. sensitivity: of the figure
    per unit of that ratio.
    """
    return Contribution(f"calibration, {channel}", "B", 1.0, "1", "normal", relative, sensitivity, how="as stated")
