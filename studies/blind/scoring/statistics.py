"""Figures of a batch: shares with Wilson intervals, areas under a curve, calibration."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

CONFIDENCE = 0.95
BINS = 10  #: Bins of the reliability diagram.


@dataclass(frozen=True)
class Share:
    """How many of how many, with Wilson's 95 % interval (Wilson, J. Am. Stat. Assoc. 22 (1927) 209)."""

    hits: int
    of: int

    @property
    def value(self) -> float | None:
        """hits / of; None if `of` is 0."""
        return self.hits / self.of if self.of else None

    @property
    def interval95(self) -> tuple[float, float] | None:
        """Wilson's interval; None if `of` is 0."""
        if not self.of:
            return None
        from scipy.stats import binomtest

        interval = binomtest(self.hits, self.of).proportion_ci(CONFIDENCE, method="wilson")
        return float(interval.low), float(interval.high)

    def to_json(self) -> dict[str, object]:
        """Share, interval and counts."""
        interval = self.interval95
        return {
            "value": None if self.value is None else round(self.value, 4),
            "interval95": None if interval is None else [round(end, 4) for end in interval],
            "hits": self.hits,
            "of": self.of,
        }


def share(marks: Sequence[bool]) -> Share:
    """The share of marks that are set."""
    return Share(sum(marks), len(marks))


def area_under_curve(positive: Sequence[float], negative: Sequence[float]) -> float | None:
    """Probability that a positive scores above a negative, ties counting half; None if there are none of either."""
    if not len(positive) or not len(negative):
        return None
    from scipy.stats import rankdata

    ranks = rankdata(np.concatenate([positive, negative]))
    wins = ranks[: len(positive)].sum() - 0.5 * len(positive) * (len(positive) + 1)
    return float(wins / (len(positive) * len(negative)))


def area_interval(positive: Sequence[float], negative: Sequence[float]) -> tuple[float, float] | None:
    """Wilson's interval of an area, with the sample that Hanley and McNeil's standard error is worth.

    Source: Hanley & McNeil, Radiology 143 (1982) 29, eq. 1.
    """
    area = area_under_curve(positive, negative)
    if area is None:
        return None
    n, m = len(positive), len(negative)
    # An area of 1 would have no error; half a pair is taken off it.
    held = float(np.clip(area, 0.5 / (n * m), 1.0 - 0.5 / (n * m)))
    q1, q2 = held / (2.0 - held), 2.0 * held**2 / (1.0 + held)
    variance = (held * (1.0 - held) + (n - 1) * (q1 - held**2) + (m - 1) * (q2 - held**2)) / (n * m)
    worth = held * (1.0 - held) / max(variance, 1e-12)
    z2 = 1.959964**2
    middle = (held + z2 / (2.0 * worth)) / (1.0 + z2 / worth)
    half = np.sqrt(z2 * (held * (1.0 - held) / worth + z2 / (4.0 * worth**2))) / (1.0 + z2 / worth)
    return max(float(middle - half), 0.0), min(float(middle + half), 1.0)


def roc_curve(positive: Sequence[float], negative: Sequence[float]) -> tuple[list[float], list[float]]:
    """Share of negatives and of positives above each threshold, from (0, 0) to (1, 1)."""
    thresholds = np.unique(np.concatenate([positive, negative]))[::-1]
    false = [0.0] + [float(np.mean(np.asarray(negative) >= t)) for t in thresholds]
    true = [0.0] + [float(np.mean(np.asarray(positive) >= t)) for t in thresholds]
    return false, true


@dataclass(frozen=True)
class ReliabilityBin:
    """Cases whose leading hypothesis had a probability in a range: the mean of it and the share that were right."""

    low: float
    high: float
    probability: float
    right: Share


def reliability(probability: Sequence[float], right: Sequence[bool]) -> list[ReliabilityBin]:
    """Bins of equal width that hold cases."""
    edges = np.linspace(0.0, 1.0, BINS + 1)
    place = np.clip(np.digitize(probability, edges) - 1, 0, BINS - 1) if len(probability) else np.array([], dtype=int)
    bins = []
    for index in np.unique(place):
        inside = np.flatnonzero(place == index).tolist()
        mean = float(np.mean([probability[i] for i in inside]))
        marks = share([right[i] for i in inside])
        bins.append(ReliabilityBin(float(edges[index]), float(edges[index + 1]), mean, marks))
    return bins


def calibration_error(bins: Sequence[ReliabilityBin]) -> float | None:
    """Mean distance between probability and share right, weighted with the cases (expected calibration error)."""
    total = sum(b.right.of for b in bins)
    if not total:
        return None
    return sum(b.right.of * abs(b.probability - (b.right.value or 0.0)) for b in bins) / total
