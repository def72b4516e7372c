"""Remarks of a check, and statistics of all loops on which checks are based."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Literal

import numpy as np

from geometry.arrays import Array, BoolArray, IntArray
from wirewear.base.words import counted
from wirewear.loops import LoopFigures
from wirewear.loops.drive import uneven
from wirewear.loops.noise import clipped, noises, outside_neighbours, sample_noise, step_of
from wirewear.loops.sensor import enclosed_areas
from wirewear.records.values import AnyRecord, MeasuredLoop

FEWEST_SAMPLES = 16  #: A loop with fewer complete samples is no loop.

#: Noise, as a share of the amplitude, that a loop's own course between so many samples resembles at most: its
#: curvature and, in exported simulations, the corners of straight lines. Of such, 24 to 64 samples of a noiseless loop
#: scattered by up to 3.5e-3, 92 to 128 by up to 6e-4, 200 and more by up to 2e-5; fewer samples show no noise.
COURSE = ((200, 1e-4), (90, 1e-3), (24, 5e-3), (0, np.inf))

ONE_SIGN = 0.1  #: A force that keeps its sign falls below zero by noise alone, a share of its largest.


CHUNK = 256  #: Loops that are worked on at once; bounds the memory needed.

MOST_LISTED = 8
ALIKE = 0.01  #: Conditions are rounded to this share of themselves, and alike within it.


def of_equal_times(loops: Iterable[MeasuredLoop]) -> list[list[MeasuredLoop]]:
    """Groups of complete loops sampled at the same times within a microsecond, the largest group first."""
    groups: dict[bytes, list[MeasuredLoop]] = {}
    for loop in loops:
        if loop.complete is loop:
            groups.setdefault(np.round(loop.time_s - loop.time_s[0], 6).tobytes(), []).append(loop)
    return sorted(groups.values(), key=len, reverse=True)


@dataclass(frozen=True, eq=False)
class LoopStatistics:
    """Statistics of n loops, each field (n,) in the record's order; NaN for loops with too few samples.

    samples, missing: complete samples, and samples that lack a channel. time_errors: samples whose time does not
    increase. period_s: duration of the cycle. *_amplitude, *_offset: half the distance between the 1 % and 99 %
    quantiles, and the middle between them. *_noise: standard deviation of one sample. *_gap: share of the range by
    which a loop fails to close, beyond noise and the usual step. displacement_jump: largest step over the range.
    *_saturated: 1 if clipped. force_folded: 1 if the force never changes sign but falls to zero and rises again twice
    in a cycle. normal_force_N: median. outliers: samples that stand out in either channel.
    """

    repeat: IntArray
    cycle: IntArray
    samples: IntArray
    missing: IntArray
    time_errors: Array
    period_s: Array
    displacement_amplitude_um: Array
    displacement_offset_um: Array
    displacement_noise_um: Array
    displacement_gap: Array
    displacement_jump: Array
    displacement_saturated: Array
    force_amplitude_N: Array
    force_offset_N: Array
    force_noise_N: Array
    force_gap: Array
    force_saturated: Array
    force_folded: Array
    normal_force_N: Array
    normal_saturated: Array
    energy_mJ: Array
    outliers: Array


def loop_statistics(loops: Sequence[MeasuredLoop]) -> LoopStatistics:
    """Statistics of each loop, in the order of `loops`, from its samples that lack no channel."""
    complete = [loop.complete for loop in loops]
    samples = np.array([loop.time_s.size for loop in complete], dtype=np.int64)
    columns = {name: np.full(len(loops), np.nan) for name in _COMPUTED}
    for size in np.unique(samples[samples >= FEWEST_SAMPLES]):
        alike = np.flatnonzero(samples == size)
        for start in range(0, alike.size, CHUNK):
            places = alike[start : start + CHUNK]
            for name, values in _chunk([complete[place] for place in places]).items():
                columns[name][places] = values
    return LoopStatistics(
        repeat=np.array([loop.repeat for loop in loops], dtype=np.int64),
        cycle=np.array([loop.cycle for loop in loops], dtype=np.int64),
        samples=samples,
        missing=np.array([loop.time_s.size for loop in loops], dtype=np.int64) - samples,
        **columns,
    )


_COMPUTED = tuple(
    name for name in LoopStatistics.__annotations__ if name not in ("repeat", "cycle", "samples", "missing")
)


def _chunk(loops: Sequence[MeasuredLoop]) -> dict[str, Array]:
    time, x, q = (
        np.stack([getattr(loop, n) for loop in loops]) for n in ("time_s", "displacement_um", "tangential_force_N")
    )
    step = np.diff(time, axis=1)
    x_outliers, x_noise = _outliers(x)
    q_outliers, q_noise = _outliers(q)
    x_low, x_high = np.percentile(x, [1, 99], axis=1)
    q_low, q_high = np.percentile(q, [1, 99], axis=1)
    clean_x, clean_q = (_healed(v, bad) for v, bad in ((x, x_outliers), (q, q_outliers)))
    normal = [np.nan if loop.normal_force_N is None else float(np.median(loop.normal_force_N)) for loop in loops]
    return {
        "time_errors": np.count_nonzero(step <= 0.0, axis=1).astype(float),
        "period_s": _periods(time),
        "displacement_amplitude_um": 0.5 * (x_high - x_low),
        "displacement_offset_um": 0.5 * (x_high + x_low),
        "displacement_noise_um": _in_time(x_noise, x, time),
        "displacement_gap": _gap(clean_x, x_noise, x_high - x_low),
        "displacement_jump": np.abs(np.diff(clean_x, axis=1)).max(axis=1) / np.maximum(np.ptp(clean_x, axis=1), 1e-300),
        "displacement_saturated": _saturated(x, beside=q),
        "force_amplitude_N": 0.5 * (q_high - q_low),
        "force_offset_N": 0.5 * (q_high + q_low),
        "force_noise_N": _in_time(q_noise, q, time),
        "force_gap": _gap(clean_q, q_noise, q_high - q_low),
        "force_saturated": _saturated(q, beside=x),
        "force_folded": np.array([_folded(*loop) for loop in zip(clean_x, clean_q, strict=True)], dtype=float),
        "normal_force_N": np.array(normal),
        "normal_saturated": _saturated([loop.normal_force_N for loop in loops], beside=x),
        "energy_mJ": 1e-3 * enclosed_areas(clean_x, clean_q),
        "outliers": np.count_nonzero(x_outliers | q_outliers, axis=1).astype(float),
    }


def _periods(time: Array) -> Array:
    """Duration (l,) of each loop's cycle for times (l, n), including the step from the last sample to the next cycle.

    It uses the median step if steps are even, so that a single wrong time does not matter.
    """
    step = np.diff(time, axis=1)
    spanned = (time[:, -1] - time[:, 0]) * time.shape[1] / step.shape[1]
    return np.asarray(np.where(uneven(time), spanned, np.median(step, axis=1) * time.shape[1]))


def _in_time(noise: Array, values: Array, time: Array) -> Array:
    """Noise (l,) of loops (l, n), recomputed with the sample times of loops with uneven steps."""
    noise_in_time = noise.copy()
    for place in np.flatnonzero(uneven(time)):
        noise_in_time[place] = sample_noise(values[place], time[place])
    return noise_in_time


def _outliers(values: Array) -> tuple[BoolArray, Array]:
    """Marks (l, n) of outlying samples, and the noise of each loop (l,)."""
    noise = noises(values)
    # An outlier is this many standard deviations of noise outside what its neighbours bracket.
    return outside_neighbours(values, lambda steps: 8.0 * noise[:, None] + 2.5 * steps[2]), noise


def _healed(values: Array, bad: BoolArray) -> Array:
    """Samples (l, n) with outliers replaced by the median of their neighbours."""
    if not bad.any():
        return values
    neighbours = np.stack([np.roll(values, shift, axis=1) for shift in (-2, -1, 1, 2)])
    return np.where(bad, np.median(neighbours, axis=0), values)


def _gap(values: Array, noise: Array, extent: Array) -> Array:
    """Distance between start and end of each loop beyond noise and a step, over its range (l,)."""
    step = np.diff(values, axis=1)
    end, start = values[:, -1] + 0.5 * step[:, -1], values[:, 0] - 0.5 * step[:, 0]
    # Start and end of a loop, led on, scatter by some two standard deviations of noise; this many open no loop.
    usual = 8.0 * noise + np.percentile(np.abs(step), 99, axis=1)
    share: Array = np.maximum(np.abs(end - start) - usual, 0.0) / np.where(extent > 0.0, extent, np.inf)
    return share


def _saturated(channels: Iterable[Array | None], beside: Array) -> Array:
    """Array (l,): 1 for channels of loops (l, n) clipped at the end of their range; `beside` is another channel (l, n).

    Where a plateau may lie within one reading step, clipping counts only if most loops end at the same value.
    """
    pairs = zip(channels, beside, strict=True)
    found = [None if one is None else clipped(one, beside=other) for one, other in pairs]
    ends = Counter(value for one in found if one is not None for value in one.values)
    stop = 0.5 * len(found)
    return np.array([float(one is not None and (one.sure or any(ends[v] > stop for v in one.values))) for one in found])


def coarse_step_of(values: Array) -> float:
    """Reading step of a channel (n,) in its unit; 0 if more than a third of its samples differ."""
    known = values[np.isfinite(values)]
    return step_of(known) if 3 <= np.unique(known).size <= known.size / 3 else 0.0


def _folded(x: Array, q: Array) -> bool:
    """True if the force keeps its sign and rises from zero twice while the displacement rises once."""
    size = np.abs(q)
    peak = float(size.max())
    low, high = float(q.min()), float(q.max())
    one_signed = low > -ONE_SIGN * peak or high < ONE_SIGN * peak
    return one_signed and _rises(size / max(peak, 1e-300)) == 2 and _rises((x - x.min()) / max(np.ptp(x), 1e-300)) == 1


def _rises(share: Array) -> int:
    """Number of times that a closed course, scaled to 0 … 1, passes from its lowest to its highest third."""
    ends = np.where(share > 2.0 / 3.0, 1, np.where(share < 1.0 / 3.0, -1, 0))
    ends = ends[ends != 0]
    return int(np.count_nonzero((ends > 0) & (np.roll(ends, 1) < 0)))


def plural(count: int, noun: str) -> str:
    """Number with its noun: "1 loop", "3 loops"."""
    return f"{counted(count)} {noun}{'' if count == 1 else 's'}"


def listed(values: Sequence[int]) -> str:
    """Numbers as text, shortened: "1, 2, 3 and 12 more"."""
    shown = ", ".join(counted(value) for value in values[:MOST_LISTED])
    more = len(values) - MOST_LISTED
    return f"{shown} and {more} more" if more > 0 else shown


def unlike_conditions(
    pairs: Mapping[str, tuple[float | None, float | None]], cycles: tuple[float, float]
) -> str | None:
    """Sentence on the conditions in which a run and a record differ; None if they are of the same test.

    pairs: values of run and record by key, None for unstated ones. cycles: length of the run and of the record's test;
    the run may be longer.
    """
    differ = [
        f"{key} is {own:.4g} in the run and {other:.4g} in the record"
        for key, (own, other) in pairs.items()
        if own is not None and other is not None and abs(own - other) > ALIKE * max(abs(own), abs(other))
    ]
    if cycles[0] < cycles[1]:
        differ.append(f"the run ends after {cycles[0]:.9g} cycles and the record after {cycles[1]:.9g}")
    return f"The run and the record are not of the same test: {', '.join(differ)}." if differ else None


@dataclass(frozen=True)
class Remark:
    """Finding of a check: a "problem" makes figures unreliable, a "note" is for information; topic: a heading, text: a
    sentence.
    """

    level: Literal["problem", "note"]
    topic: str
    text: str
    refuses: bool = False  #: True if the record therefore allows no conclusion.


@dataclass(frozen=True)
class RecordReport:
    """Result of a check.

    repeats, cycles: their numbers. loops, samples: counts. supports, cannot: sentences on conclusions that the record
    supports and cannot support. metadata: lines "key: value".
    """

    name: str
    repeats: tuple[int, ...]
    cycles: tuple[int, ...]
    loops: int
    samples: int
    remarks: tuple[Remark, ...]
    supports: tuple[str, ...]
    cannot: tuple[str, ...]
    metadata: tuple[str, ...] = ()

    @property
    def problems(self) -> tuple[Remark, ...]:
        """Those remarks that make figures unreliable, without the notes."""
        return tuple(remark for remark in self.remarks if remark.level == "problem")

    def to_json(self) -> dict[str, object]:
        """The report as dicts, lists, texts and numbers by its fields' names."""
        return asdict(self)


@dataclass(frozen=True, eq=False)
class CheckedRecord:
    """A record with statistics of all its loops; by (repeat, cycle), figures of those analysed in full, or the reason
    why one cannot be.
    """

    record: AnyRecord
    statistics: LoopStatistics
    figures: dict[tuple[int, int], LoopFigures]
    refused: dict[tuple[int, int], str]


def where(checked: CheckedRecord, wrong: BoolArray) -> str:
    """Text on the loops marked in `wrong` (n,): "3 of 21 loops (first: repeat 1, cycle 100)"."""
    first = int(np.argmax(wrong))
    s = checked.statistics
    return (
        f"{int(np.count_nonzero(wrong))} of {plural(wrong.size, 'loop')} "
        f"(first: repeat {s.repeat[first]}, cycle {s.cycle[first]})"
    )
