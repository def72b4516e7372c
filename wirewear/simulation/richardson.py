"""Where a figure tends to as a resolution is refined: Richardson's extrapolation from three values, with its error.

L. F. Richardson, Phil. Trans. R. Soc. A 210 (1911) 307; the safeguards are those of P. J. Roache, Verification and
Validation in Computational Science and Engineering, Hermosa, 1998, chapter 5.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isnan, nan

# Orders seen outside these are luck or noise. Nothing in the solver is of a higher order than the second.
_LEAST_ORDER, _LARGEST_ORDER = 0.5, 2.0
# Changes below this share of the value are round-off.
_ROUND_OFF = 1e-9


@dataclass(frozen=True)
class Limit:
    """Where three values tend to.

    error: of the limit; all that was extrapolated, or all that the values differ where they show no trend.
    order: with which they tend there, None where they show no trend.
    """

    value: float
    error: float
    order: float | None


def richardson(spacings: Sequence[float], values: Sequence[float]) -> Limit:
    """The limit of values at three spacings, from coarse to fine, taken to err by a power of the spacing; NaN of NaN.

    Raises:
        ValueError: there are not three of each, or the spacings do not fall.
    """
    if len(spacings) != 3 or len(values) != 3 or not spacings[0] > spacings[1] > spacings[2] > 0.0:
        raise ValueError("an extrapolation needs three falling spacings and their values")
    coarse, middle, fine = values
    if any(isnan(value) for value in values):
        return Limit(nan, nan, None)
    first, second = middle - coarse, fine - middle
    if max(abs(first), abs(second)) <= _ROUND_OFF * abs(fine):
        return Limit(fine, 0.0, None)
    if first * second <= 0.0:
        return Limit(fine, max(values) - min(values), None)
    order = _order(spacings, first / second)
    beyond = second / ((spacings[1] / spacings[2]) ** order - 1.0)
    return Limit(fine + beyond, abs(beyond), order)


def _order(spacings: Sequence[float], ratio: float) -> float:
    """The order at which errors fall so that the two changes have this ratio, within what can be believed."""
    from scipy.optimize import brentq

    coarse, middle, fine = spacings

    def excess(order: float) -> float:
        return float((coarse**order - middle**order) / (middle**order - fine**order)) - ratio

    if excess(_LEAST_ORDER) >= 0.0:
        return _LEAST_ORDER
    if excess(_LARGEST_ORDER) <= 0.0:
        return _LARGEST_ORDER
    return float(brentq(excess, _LEAST_ORDER, _LARGEST_ORDER))
