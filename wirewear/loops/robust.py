"""Robust statistics and straight-line fits that outliers cannot pull."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geometry.arrays import Array

_RIDGE = 1e-13  # Keeps columns that coincide on few samples solvable.
CHOICE = 1.2  # widens standard deviations: weights and degree were chosen with the same data that are fitted


def median_deviation(values: Array) -> float:
    """Robust standard deviation of values (n,) about zero: 1.4826 × the median of their sizes; 0 if there are none."""
    middle = len(values) // 2
    # np.median's generality costs more than all the rest of a small fit
    return float(1.4826 * np.partition(np.abs(values), middle)[middle]) if len(values) else 0.0


def biweight(residuals: Array, scale: float) -> Array:
    """Tukey's biweights (n,), from 0 to 1, of residuals (n,): 0 beyond six scales; all 1 unless scale > 0."""
    if scale <= 0.0:
        return np.ones_like(residuals)
    inside = np.maximum(1.0 - (residuals / (6.0 * scale)) ** 2, 0.0)
    weights: Array = inside**2
    return weights


@dataclass(frozen=True)
class LinearFit:
    """Weighted least-squares fit: coefficients (p,), their covariance (p, p), residuals (n,) and the residuals'
    weighted standard deviation, `scale`.
    """

    coefficients: Array
    covariance: Array
    residuals: Array
    scale: float


def fit_linear(design: Array, values: Array, iterations: int = 4) -> LinearFit:
    """Fit values (n,) by design (n, p) × coefficients, reweighting `iterations` times by Tukey's biweights.

    The covariance (p, p) follows from the weighted residuals' scale, times CHOICE for weights taken from the same data.
    """
    count, parameters = design.shape
    weights = np.ones(count)
    scaled, norm = _scaled(design)
    floor = 1e-12 * float(np.max(np.abs(values), initial=0.0))
    ridge = _RIDGE * np.eye(parameters)
    for _ in range(iterations):
        weighted = scaled.T * weights
        # the few columns are scaled and nearly orthogonal: normal equations are accurate and fastest
        inverse = np.linalg.inv(weighted @ scaled + ridge)
        coefficients = inverse @ (weighted @ values)
        residuals = values - scaled @ coefficients
        scale = median_deviation(residuals) * float(np.sqrt(count / max(count - parameters, 1)))
        if scale <= floor:
            break
        weights = biweight(residuals, scale)
    spread = float(np.sqrt(np.sum(weights * residuals**2) / max(np.sum(weights) - parameters, 1.0)))
    covariance = (CHOICE * spread) ** 2 * inverse / np.outer(norm, norm)
    return LinearFit(coefficients / norm, covariance, residuals, spread)


def mean_misfits(designs: Sequence[Array], values: Array) -> Array:
    """Mean size (k,) of what least squares by each of k designs (n, p) leave of values (n,)."""
    scaled, norm = _scaled(np.stack(designs))
    across = scaled.transpose(0, 2, 1)
    solved = np.linalg.solve(across @ scaled + _RIDGE * np.eye(norm.shape[1]), across @ values[:, None])
    return np.asarray(np.abs(values - (scaled @ solved)[:, :, 0]).mean(axis=1))


def _scaled(design: Array) -> tuple[Array, Array]:
    """Columns (..., n, p) at a length of 1, and their lengths (..., p), 1 of columns of zeros."""
    norm = np.linalg.norm(design, axis=-2)
    norm = np.where(norm > 0.0, norm, 1.0)
    return design / norm[..., None, :], norm


def best_fit(designs: Sequence[Array], values: Array) -> int:
    """Index of the design (n, p) by which values (n,) are fitted best: with the least n ln s² + p ln n (Schwarz's
    criterion), where s is the robust scale of the residuals.
    """
    count = len(values)
    floor = 1e-12 * float(np.max(np.abs(values), initial=1e-300))
    scores = []
    for design in designs:
        scale = max(fit_linear(design, values, 2).scale, floor)
        scores.append(2.0 * count * np.log(scale) + design.shape[1] * np.log(count))
    return int(np.argmin(scores))


@dataclass(frozen=True)
class RobustLine:
    """Line y = intercept + slope·x with the slope's standard deviation, infinite if the points do not spread in x."""

    slope: float
    intercept: float
    slope_deviation: float


def fit_line(x: Array, y: Array, x_noise: float, y_noise: float) -> RobustLine:
    """Line through at least two points (x, y), each (n,), with errors in both coordinates (Deming's regression with
    biweights).

    x_noise, y_noise: standard deviations of one point; if both are 0, only y counts as uncertain.
    """
    if x_noise <= 0.0 and y_noise <= 0.0:
        x_noise, y_noise = 0.0, 1.0
    weights = np.ones_like(x)
    slope, middle_x, middle_y = 0.0, 0.0, 0.0
    for _ in range(5):
        total = weights.sum()
        middle_x, middle_y = float(weights @ x / total), float(weights @ y / total)
        dx, dy = x - middle_x, y - middle_y
        slope = _deming_slope(
            float(weights @ dx**2), float(weights @ dy**2), float(weights @ (dx * dy)), x_noise, y_noise
        )
        residuals = dy - slope * dx
        scale = max(median_deviation(residuals), float(np.hypot(y_noise, slope * x_noise)))
        weights = biweight(residuals, scale)
    spread = np.sqrt(float(weights @ residuals**2) / max(len(x) - 2, 1))
    extent = float(weights @ dx**2) - float(weights.sum()) * x_noise**2
    deviation = float(spread / np.sqrt(extent)) if extent > 1e-12 * float(np.max(x**2, initial=0.0)) else math.inf
    return RobustLine(slope, middle_y - slope * middle_x, deviation)


def _deming_slope(xx: float, yy: float, xy: float, x_noise: float, y_noise: float) -> float:
    if x_noise <= 0.0:
        return xy / xx if xx > 0.0 else 0.0
    ratio = (y_noise / x_noise) ** 2
    difference = yy - ratio * xx
    root = float(np.hypot(difference, 2.0 * np.sqrt(ratio) * xy))
    if xy == 0.0:
        return 0.0
    # the two forms are equal; each avoids cancellation on its side
    return (difference + root) / (2.0 * xy) if difference >= 0.0 else 2.0 * ratio * xy / (root - difference)
