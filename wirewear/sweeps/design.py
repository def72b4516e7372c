"""Which values the varied keys have in each run: a grid, a Latin hypercube, or Saltelli's design."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import product
from math import exp, log, log2, prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wirewear.base.errors import StudyError
from wirewear.base.quantity import counted
from wirewear.sweeps.tables import GRID, LATIN_HYPERCUBE, LOGARITHMIC, SOBOL, SweepTables, Vary

#: Values are rounded to so many digits, so that one design is the same everywhere to the last bit.
DIGITS = 12


#: Runs of a sweep: at ten seconds each, four months of a core.
MOST_RUNS = 1_000_000


@dataclass(frozen=True)
class VariedInput:
    """A varied key: from `low` to `high`, spread evenly or over their logarithm, or over a grid's `values`."""

    key: str
    low: float
    high: float
    logarithmic: bool
    values: tuple[float, ...] = ()

    def at(self, share: float) -> float:
        """The value at a share of the way from the lower to the upper end."""
        if self.logarithmic:
            value = exp(log(self.low) + share * log(self.high / self.low))
        else:
            value = self.low + share * (self.high - self.low)
        return float(f"{value:.{DIGITS}g}")


@dataclass(frozen=True, eq=False)
class Design:
    """Points (n, d) of d factors, with the shares of the way between their ends that they stand for."""

    kind: str
    factors: tuple[VariedInput, ...]
    shares: NDArray[np.float64]
    points: NDArray[np.float64]

    @property
    def keys(self) -> tuple[str, ...]:
        """The varied keys, in the points' order."""
        return tuple(factor.key for factor in self.factors)

    @cached_property
    def problem(self) -> dict[str, Any]:
        """The factors as SALib describes them, in shares."""
        count = len(self.factors)
        return {"num_vars": count, "names": list(self.keys), "bounds": [[0.0, 1.0]] * count}

    def values(self, place: int) -> dict[str, float]:
        """The varied keys' values in the run of that place."""
        return dict(zip(self.keys, self.points[place].tolist(), strict=True))


def design_of(tables: SweepTables, where: str) -> Design:
    """The design that a sweep asks for.

    Raises:
        StudyError: a key is named twice, or its ends, its values or the samples do not go with the design.
    """
    keys = [vary.key for vary in tables.vary]
    twice = next((key for key in keys if keys.count(key) > 1), None)
    if twice is not None:
        raise StudyError(f"{twice} is varied twice in {where}: give it once.")
    if tables.design == GRID:
        return _grid([_of_values(vary, where) for vary in tables.vary], tables, where)
    factors = tuple(_between_ends(vary, tables.design, where) for vary in tables.vary)
    if tables.samples is None:
        raise StudyError(f"samples is missing in {where}: a design by {tables.design} needs their number.")
    runs = tables.samples * (len(factors) + 2 if tables.design == SOBOL else 1)
    _require_countable(runs, f"samples = {tables.samples}", "give fewer", where)
    shares = _drawn(tables.design, len(factors), tables.samples, tables.seed, where)
    points = np.array([[factor.at(share) for factor, share in zip(factors, row, strict=True)] for row in shares])
    return Design(tables.design, factors, shares, points)


def _drawn(kind: str, factors: int, samples: int, seed: int, where: str) -> NDArray[np.float64]:
    if kind == LATIN_HYPERCUBE:
        from scipy.stats import qmc

        shares: NDArray[np.float64] = qmc.LatinHypercube(factors, rng=np.random.default_rng(seed)).random(samples)
        return shares
    if samples & (samples - 1):
        near = 2 ** round(log2(samples))
        raise StudyError(f"samples in {where} is {samples}, but Sobol's sequence takes a power of 2 such as {near}.")
    from SALib.sample import sobol

    problem = {"num_vars": factors, "names": [str(n) for n in range(factors)], "bounds": [[0.0, 1.0]] * factors}
    drawn: NDArray[np.float64] = sobol.sample(problem, samples, calc_second_order=False, seed=seed)
    return drawn


def _grid(factors: list[VariedInput], tables: SweepTables, where: str) -> Design:
    if tables.samples is not None:
        raise StudyError(f"samples in {where} does not go with a grid, whose runs follow from the values.")
    runs = prod(len(factor.values) for factor in factors)
    _require_countable(runs, "the grid", "give fewer values, or draw samples of a latin-hypercube", where)
    points = np.array(list(product(*(factor.values for factor in factors))))
    low, high = points.min(axis=0), points.max(axis=0)
    return Design(GRID, tuple(factors), (points - low) / (high - low), points)


def _require_countable(runs: int, what: str, remedy: str, where: str) -> None:
    if runs > MOST_RUNS:
        raise StudyError(
            f"{what} in {where} asks for {counted(runs)} runs, where a sweep takes at most {counted(MOST_RUNS)}: "
            f"{remedy}."
        )


def _of_values(vary: Vary, where: str) -> VariedInput:
    if vary.values is None or vary.low is not None or vary.high is not None:
        raise StudyError(f"{vary.key} in {where} must give values, and no ends, as the design is a grid.")
    return VariedInput(vary.key, min(vary.values), max(vary.values), vary.scale == LOGARITHMIC, vary.values)


def _between_ends(vary: Vary, kind: str, where: str) -> VariedInput:
    if vary.low is None or vary.high is None or vary.values is not None:
        raise StudyError(f"{vary.key} in {where} must give low and high, and no values, as the design is {kind}.")
    if not vary.low < vary.high:
        raise StudyError(f"{vary.key} in {where} goes from {vary.low:g} to {vary.high:g}: low must be below high.")
    if vary.scale == LOGARITHMIC and vary.low <= 0.0:
        raise StudyError(f"{vary.key} in {where} begins at {vary.low:g}, where a logarithmic scale needs more than 0.")
    return VariedInput(vary.key, vary.low, vary.high, vary.scale == LOGARITHMIC)


SAMPLED = (LATIN_HYPERCUBE, SOBOL)
