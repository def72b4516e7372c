"""Forecast of the time, memory and disk that a sweep takes, from its first runs.

The size of a run is the root of the bytes that it needs, which grows in proportion to its number of unknowns.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wirewear.base.errors import WirewearError
from wirewear.base.memory import size_text
from wirewear.base.words import counted
from wirewear.sweeps.sweep import Sweep, SweepRow

POWERS = (0.0, 2.5)  #: Powers beyond these come from runs that are too alike in size to show it.


#: Bytes of a row in journal and tables, and of a kept result for each unknown; measured.
ROW_BYTES, RESULT_BYTES = 1_500, 60.0


@dataclass(frozen=True)
class Forecast:
    """Cost of a sweep on `workers` workers: CPU time of all runs, peak memory of one worker, and disk space."""

    runs: int
    workers: int
    cpu_s: float
    peak_bytes: float
    disk_bytes: float

    @property
    def wall_s(self) -> float:
        """Time in s from start to end, on workers that do nothing else."""
        return self.cpu_s / max(min(self.workers, self.runs), 1)

    @property
    def sentence(self) -> str:
        workers = "one worker" if self.workers == 1 else f"{self.workers} workers"
        return (
            f"{counted(self.runs)} runs on {workers} take about {time_text(self.wall_s)} "
            f"({time_text(self.cpu_s)} of CPU time), {size_text(self.peak_bytes)} of memory a worker and "
            f"{size_text(self.disk_bytes)} of disk."
        )


def sizes_of(sweep: Sweep) -> np.ndarray:
    """Size of each run (n,): the root of the bytes that it needs, which grows as its number of unknowns; interpolated
    between 200 planned ones at most; NaN for all if none can be planned.
    """
    count = len(sweep)
    # Runs that are planned to know the sizes of all.
    planned = np.unique(np.linspace(0, count - 1, min(count, 200)).round().astype(int))
    found = np.array([_size(sweep, int(place)) for place in planned])
    known = np.isfinite(found)
    if not known.any():
        return np.full(count, np.nan)
    sizes: np.ndarray = np.interp(np.arange(count), planned[known], found[known])
    return sizes


def pilots(sizes: np.ndarray) -> list[int]:
    """Indices of the runs that come first, for the forecast: of middle, largest and smallest size, each once."""
    order = np.argsort(sizes, kind="stable")
    return list(dict.fromkeys(int(order[place]) for place in (order.size // 2, order.size - 1, 0)))


def forecast(sweep: Sweep, sizes: np.ndarray, rows: Sequence[SweepRow], workers: int) -> Forecast:
    """Cost of a sweep on `workers` workers, from all runs' sizes and rows that ended, one of which has CPU time."""
    done = [row for row in rows if row.cpu_s > 0.0]
    at, cpu = np.array([sizes[row.number - 1] for row in done]), np.array([row.cpu_s for row in done])
    power = _power(at, cpu)
    scale = float(np.exp(np.mean(np.log(cpu) - power * np.log(at))))
    expected = scale * sizes**power
    expected[[row.number - 1 for row in done]] = cpu
    kept = RESULT_BYTES * float(sizes.sum()) if sweep.keep_results else 0.0
    peak = max(row.peak_bytes for row in done) * float(max((sizes.max() / at.max()) ** 2, 1.0))
    return Forecast(len(sweep), workers, float(expected.sum()), peak, ROW_BYTES * len(sweep) + kept)


def time_text(seconds: float) -> str:
    """Duration in words with two significant digits, such as ``12 min``."""
    for unit, length in (("s", 1.0), ("min", 60.0), ("h", 3600.0), ("days", 86400.0)):
        if seconds < 99.5 * length or unit == "days":
            return f"{float(f'{seconds / length:.2g}'):,.4g} {unit}"
    raise AssertionError


def _power(sizes: np.ndarray, cpu_s: np.ndarray) -> float:
    if np.ptp(np.log(sizes)) < np.log(1.3):
        # They do not show it; measured, docs/accuracy.md.
        return 1.3
    return float(np.clip(np.polyfit(np.log(sizes), np.log(cpu_s), 1)[0], *POWERS))


def _size(sweep: Sweep, place: int) -> float:
    from wirewear.simulation import needed_memory  # What simulates takes half a second to load.

    try:
        return float(needed_memory(sweep.study_of(place), sweep.fidelity) ** 0.5)
    except WirewearError:
        return float("nan")
