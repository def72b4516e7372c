"""Worn volume against friction energy as a straight line, by least squares, with Student's t for its intervals."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import stdtrit

from geometry.arrays import Array


@dataclass(frozen=True)
class RegressionLine:
    """V = slope · (ΣE_d − threshold); intervals hold the true values with a probability of 95 %.

    Attributes:
        slope_mm3_per_J: worn volume per friction energy.
        slope_interval95: of the slope; infinite where there is one test more than nothing to tell it by.
        threshold_J: energy below which nothing wears; 0 for a line through the origin.
        threshold_interval95: by the scatter of slope and intercept.
        explained: share of the volumes' scatter about their mean that the line explains (R²); NaN where they agree.
        tests: how many there are.
    """

    slope_mm3_per_J: float
    slope_interval95: tuple[float, float]
    threshold_J: float
    threshold_interval95: tuple[float, float]
    explained: float
    tests: int


def line_through_origin(energy_J: ArrayLike, volume_mm3: ArrayLike) -> RegressionLine:
    """The line V = α ΣE_d of tests (n,), n ≥ 1 (Fouvry et al., Wear 255 (2003) 287)."""
    x, y = np.asarray(energy_J, dtype=np.float64), np.asarray(volume_mm3, dtype=np.float64)
    square = float(x @ x)
    slope = float(x @ y) / square
    left = y - slope * x
    # One test alone lies on its line, which nothing tells the uncertainty of.
    half = _quantile(x.size - 1) * np.sqrt(float(left @ left) / (x.size - 1) / square) if x.size > 1 else np.inf
    return RegressionLine(slope, (slope - half, slope + half), 0.0, (0.0, 0.0), _explained(y, left), x.size)


def line_with_threshold(energy_J: ArrayLike, volume_mm3: ArrayLike) -> RegressionLine:
    """The line V = α (ΣE_d − E_th) of tests (n,), n ≥ 3, of different energies.

    The threshold's interval takes slope and intercept to first order.
    """
    x, y = np.asarray(energy_J, dtype=np.float64), np.asarray(volume_mm3, dtype=np.float64)
    middle, mean = float(x.mean()), float(y.mean())
    square = float(np.sum((x - middle) ** 2))
    slope = float((x - middle) @ (y - mean)) / square
    left = y - mean - slope * (x - middle)
    variance = float(left @ left) / (x.size - 2)
    threshold = middle - mean / slope if slope else float("nan")
    # Mean and slope are uncorrelated.
    of_slope, of_mean = variance / square, variance / x.size
    t = _quantile(x.size - 2)
    half = t * np.sqrt(of_slope)
    wide = t * np.sqrt(of_mean / slope**2 + (mean / slope**2) ** 2 * of_slope) if slope else float("inf")
    return RegressionLine(
        slope,
        (slope - half, slope + half),
        threshold,
        (threshold - wide, threshold + wide),
        _explained(y, left),
        x.size,
    )


def _quantile(free: int) -> float:
    return float(stdtrit(free, 0.975)) if free > 0 else float("inf")


def _explained(y: Array, left: Array) -> float:
    spread = float(np.sum((y - y.mean()) ** 2))
    return 1.0 - float(left @ left) / spread if spread > 0.0 else float("nan")
