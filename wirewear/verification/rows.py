"""One line of the verification table, and what is derived from errors on several meshes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from math import isfinite, log
from typing import Any


@dataclass(frozen=True)
class Row:
    """A computed figure beside its closed form; passes when |error| <= tolerance.

    error: (computed - exact) / scale, the scale being |exact| unless the problem names another.
    raw_error: the same without the correction for the wires' bulk, None where nothing is corrected.
    order: observed order of convergence from the next coarser mesh, None on the coarsest and where there is but one.
    """

    problem: str
    quantity: str
    computed: float
    exact: float
    error: float
    tolerance: float
    raw_error: float | None = None
    order: float | None = None

    @property
    def passed(self) -> bool:
        """Whether the error is a number within the tolerance."""
        return bool(isfinite(self.error) and abs(self.error) <= self.tolerance)

    def as_dict(self) -> dict[str, Any]:
        """All fields and `passed`, for JSON."""
        return asdict(self) | {"passed": self.passed}


def compared(
    problem: str,
    quantity: str,
    computed: float,
    exact: float,
    tolerance: float,
    *,
    scale: float | None = None,
    raw: float | None = None,
    order: float | None = None,
) -> Row:
    """A row whose errors are relative to `scale`, or to |exact| when none is given."""
    size = abs(exact) if scale is None else scale
    raw_error = None if raw is None else (raw - exact) / size
    return Row(problem, quantity, computed, exact, (computed - exact) / size, tolerance, raw_error, order)


def observed_order(coarse_error: float, fine_error: float, refinement: float) -> float:
    """Order q of errors ~ h^q on two meshes whose sizes have the ratio `refinement` > 1; NaN when an error is zero."""
    if coarse_error == 0.0 or fine_error == 0.0:
        return float("nan")
    return log(abs(coarse_error) / abs(fine_error)) / log(refinement)


def largest_growth(errors: Sequence[float], floor: float) -> float:
    """Largest ratio |error| / |error before| from coarse to fine; errors below `floor` count as having fallen."""
    ratios = [0.0 if abs(fine) <= floor else abs(fine) / max(abs(coarse), floor) for coarse, fine in pairwise(errors)]
    return max(ratios, default=0.0)


def falling(problem: str, quantity: str, errors: Sequence[float], floor: float) -> Row:
    """A row that passes when no error exceeds the one on the next coarser mesh."""
    growth = largest_growth(errors, floor)
    return Row(problem, f"{quantity}: error over coarser mesh's, ≤ 1", growth, 1.0, max(growth - 1.0, 0.0), 0.0)
