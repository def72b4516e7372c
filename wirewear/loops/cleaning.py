"""From raw samples to one clean cycle: checks, order of time, direction of turning, outliers, noise."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geometry.arrays import Array
from wirewear.loops.clock import read_clock
from wirewear.loops.cycles import MOST_CYCLES, WHOLE, cycle_starts, cycles_between, signal_among, turns_of
from wirewear.loops.drive import Drift, drift_of, rough, smooth_periodic
from wirewear.loops.figures import LoopError
from wirewear.loops.noise import clipped, outliers, sample_noise, step_of
from wirewear.loops.outline import outline
from wirewear.loops.sensor import enclosed_area

FEWEST_SAMPLES = 16

JOINED = "the points come in no order of time and were joined along the loop's outline, none of them left out"


#: Readings of this size or more, and changes by its inverse or less, are none; their fourth powers still are numbers.
LARGEST = 1e50

FALLING = -0.5  #: No contact and no reading makes the force correlate so with the displacement.

NORMAL_CLIPPED = (
    "the normal force is clipped at the end of its range, where samples read exactly the same while the others "
    "scatter: coefficients of friction are left out"
)

NEGATIVE = "the normal force is negative where it presses, so its sign was changed"

OPENS = (
    "the normal force falls to zero within the cycle, where the contact opens: coefficients of friction are left out"
)


HOLDS = "the {} keeps each reading for {:.2g} samples: the first of each is taken, and the others are left out"

#: A channel is kept for some samples at a time if it is for so many as a mean, if runs that are as long but for a
#: sample have that share of all samples, and if it goes farther than so many of its steps from one to the next.
KEPT, ALIKE, FARTHER = 1.4, 0.9, 2.5

#: Range of a normal force over its mean from which on it counts as one that varies within the cycle.
VARIES = 0.1

DRIFTS = "the displacement drifts by {:.3g} µm within the loop, {:.1%} of its stroke: that was taken out"

BACKWARDS = (
    "the samples run backwards in time, or the force is late by more than the contact slides: they were reversed"
)


@dataclass(frozen=True)
class CleanLoop:
    """One cycle of n samples in order of time, without outliers, clockwise as a loop that dissipates energy."""

    displacement_um: Array  #: (n,) freed from noise where a smooth drive explains it, and from a certain drift.
    raw_displacement_um: Array  #: (n,) the same samples as read.
    force_N: Array  #: Tangential force (n,).
    normal_force_N: Array | None  #: (n,) smoothed; None if not given, clipped or zero within the cycle.
    time: Array  #: Times of the samples, in any unit (n,).
    times_known: bool  #: True if times were given; else samples count as evenly spread.
    index: NDArray[np.intp]  #: (n,) position of each sample in the input.
    displacement_noise_um: float  #: Standard deviation of one entry of displacement_um.
    raw_noise_um: float  #: Standard deviation of one entry of raw_displacement_um.
    smoothed: bool  #: True if `displacement_um` is smoothed.
    force_noise_N: float  #: Standard deviation of one tangential force.
    normal_noise_N: float  #: Standard deviation of the mean normal force.
    outliers: tuple[int, ...]  #: Positions in the input of the samples left out.
    notes: tuple[str, ...]  #: Sentences on assumptions and corrections.
    past: int = 0  #: Number of samples left out because they lie past one cycle.
    #: Displacement per force that was added to both displacements (see `wirewear.loops.branches.upright`); 0: none.
    lean_um_per_N: float = 0.0
    #: Possible drift, µm per unit of `time`; another period would explain the samples as well. 0: none.
    may_drift_by: float = 0.0

    @cached_property
    def force_step_N(self) -> float:
        """Resolution of the tangential force, 0 if it has none, see `step_of`."""
        return step_of(self.force_N)

    @property
    def amplitude_noise_um(self) -> float:
        """Standard deviation of the drive's amplitude: that of the displacements if they are smoothed, as it is common
        to all; else 0.
        """
        return self.displacement_noise_um if self.smoothed else 0.0

    @property
    def without_drift(self) -> "CleanLoop":
        """Copy of the loop with its possible drift, `may_drift_by`, removed from the displacement."""
        moved = self.may_drift_by * (self.time - float(self.time.mean()))
        return replace(self, displacement_um=self.displacement_um - moved, may_drift_by=0.0)

    def taken(self, order: NDArray[np.intp]) -> "CleanLoop":
        """Copy of the loop with the samples of these indices, in their order."""
        normal = None if self.normal_force_N is None else self.normal_force_N[order]
        return replace(
            self,
            displacement_um=self.displacement_um[order],
            raw_displacement_um=self.raw_displacement_um[order],
            force_N=self.force_N[order],
            normal_force_N=normal,
            time=self.time[order],
            index=self.index[order],
        )

    def noted(self, note: str) -> "CleanLoop":
        return replace(self, notes=(*self.notes, note))

    def without_smooth_drive(self) -> "CleanLoop":
        """Copy of the loop with displacements as read, not smoothed."""
        raw = self.raw_displacement_um
        return replace(self, displacement_um=raw, displacement_noise_um=self.raw_noise_um, smoothed=False)


def clean_loop(
    displacement_um: ArrayLike,
    tangential_force_N: ArrayLike,
    normal_force_N: ArrayLike | None = None,
    *,
    time_s: ArrayLike | None = None,
) -> CleanLoop:
    """Check one cycle of samples and return it cleaned. Arguments, None for what is not known, and errors are those of
    `wirewear.loops.analyse_loop`. Raises LoopError.
    """
    displacement = _channel(displacement_um, "displacement_um")
    count = len(displacement)
    if count < FEWEST_SAMPLES:
        raise LoopError(f"a loop needs at least {FEWEST_SAMPLES} samples, not {count}")
    force = _channel(tangential_force_N, "tangential_force_N", count)
    normal, pulled = _normal_channel(normal_force_N, count)
    time = np.arange(count, dtype=float) if time_s is None else _channel(time_s, "time_s", count)
    _require_change(displacement, "displacement_um")
    _require_change(force, "tangential_force_N")
    clock = read_clock(time, displacement, force)
    if clock.time_s is None:
        time_s, time = None, np.arange(count, dtype=float)
    else:
        time = clock.time_s
    _require_change(time - time[0], "time_s")

    read, displacement, force, kept = _read_anew(displacement, force)
    notes = [one for one in (clock.note, kept) if one] + _clipping_notes(displacement[read], force[read])
    if normal is not None and clipped(normal, beside=displacement) is not None:
        normal, notes = None, [*notes, NORMAL_CLIPPED]
    joined = outline(displacement, force) if time_s is None else None
    if joined is not None:
        # Along the outline nothing tells time, so that places stand in for it.
        time[joined] = np.arange(count, dtype=float)
    order = np.argsort(time, kind="stable")
    order = order[np.concatenate([[True], np.diff(time[order]) > 0.0])]
    order = order[np.isin(order, read)]
    _require_enough(order, count)
    past, drift = 0, Drift()
    if joined is None:
        whole = _one_cycle(order, displacement)
        # A drift may bring the drive back to its first place too early.
        drift = drift_of(time[order], displacement[order])
        if drift.certain:
            displacement = displacement - drift.rate * (time - float(time[order].mean()))
            whole = _one_cycle(order, displacement)
            moved, stroke = abs(drift.rate) * float(np.ptp(time[whole])), float(np.ptp(displacement[whole]))
            notes.append(DRIFTS.format(moved, moved / stroke))
        past = len(order) - len(whole)
        order = _without_outliers(whole, time, displacement, force)
    _require_enough(order, count)
    drive = smooth_periodic(time[order], displacement[order]) if joined is None else rough(displacement[order])
    position = drive.values[~drive.outliers]
    order = order[~drive.outliers]
    _require_enough(order, count)
    # What stood out may have been all there was.
    _require_change(force[order], "tangential_force_N")
    smooth_normal, normal_noise = _smooth_normal(normal, time, order)
    opens = normal is not None and smooth_normal is None
    loop = CleanLoop(
        displacement_um=position,
        raw_displacement_um=displacement[order],
        force_N=force[order],
        normal_force_N=smooth_normal,
        time=time[order],
        times_known=time_s is not None,
        index=order,
        displacement_noise_um=drive.deviation,
        raw_noise_um=drive.noise,
        smoothed=drive.smoothed,
        force_noise_N=sample_noise(force[order], time[order]),
        normal_noise_N=normal_noise,
        outliers=tuple(sorted(set(read.tolist()) - set(order.tolist()))),
        past=past,
        may_drift_by=drift.rate if drive.smoothed and not drift.certain else 0.0,
        notes=(
            *(() if joined is None else (JOINED,)),
            *((OPENS,) if opens else ()),
            *((NEGATIVE,) if pulled else ()),
            *notes,
        ),
    )
    return _turned(_closed(loop))


def _require_enough(order: NDArray[np.intp], count: int) -> None:
    if len(order) < FEWEST_SAMPLES:
        raise LoopError(f"only {len(order)} of {count} samples are usable, where at least {FEWEST_SAMPLES} are needed")


def _channel(values: ArrayLike, name: str, length: int | None = None) -> Array:
    try:
        channel = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise LoopError(f"{name} must hold numbers only") from None
    if channel.ndim != 1:
        raise LoopError(f"{name} must be one row of samples, not an array of {channel.ndim} dimensions")
    if length is not None and len(channel) != length:
        raise LoopError(f"{name} has {len(channel)} samples where displacement_um has {length}")
    broken = np.flatnonzero(~(np.abs(channel) < LARGEST))
    if len(broken):
        limit = "finite" if not np.isfinite(channel[broken[0]]) else f"below {LARGEST:g} in size, as any sensor reads"
        raise LoopError(f"{name} must be {limit}, but sample {broken[0]} is {channel[broken[0]]:g}")
    return channel


def _read_anew(displacement: Array, force: Array) -> tuple[NDArray[np.intp], Array, Array, str | None]:
    """Indices of the samples at which a sample-and-hold channel takes a new reading, both channels, and a note on it.

    If both channels hold their readings, the slower one gives the indices and the other is interpolated. If neither
    does, all samples are taken and the note is None.
    """
    channels = {"displacement": displacement, "tangential force": force}
    found = {name: read for name, values in channels.items() if (read := _readings(values)) is not None}
    every = np.arange(force.size)
    if not found:
        return every, displacement, force, None
    name, read = min(found.items(), key=lambda one: one[1].size)
    channels |= {other: np.interp(every, at, channels[other][at]) for other, at in found.items() if other != name}
    return read, channels["displacement"], channels["tangential force"], HOLDS.format(name, force.size / read.size)


def _readings(values: Array) -> NDArray[np.intp] | None:
    """Indices at which a channel (n,) that holds its value for several samples takes a new one; None if it does not
    hold.
    """
    starts = np.flatnonzero(np.diff(values, prepend=np.nan) != 0.0)
    runs = np.diff(np.append(starts, values.size))
    if starts.size < FEWEST_SAMPLES or values.size < KEPT * starts.size:
        return None
    usual = int(np.median(runs))
    alike = np.abs(runs - usual) <= 1
    far = float(np.quantile(np.abs(np.diff(values[starts])), ALIKE))
    if runs[alike].sum() < ALIKE * values.size or far < FARTHER * step_of(values):
        return None
    # A shorter run at the beginning was read before.
    return starts if runs[0] >= usual else starts[1:]


def _normal_channel(values: ArrayLike | None, length: int) -> tuple[Array | None, bool]:
    """Normal force, positive where it presses, and True if its sign was changed; a single number keeps its sign."""
    if values is None:
        return None, False
    one = np.ndim(values) == 0
    normal = _channel(np.full(length, values) if one else values, "normal_force_N", length)
    turned = not one and float(np.percentile(normal, 98)) < 0.0
    if turned:
        normal = -normal
    if not np.median(normal) and normal.min() >= 0.0:
        raise LoopError("normal_force_N is zero for half of the cycle or more: the bodies are apart")
    if not np.median(normal) > 1.0 / LARGEST:
        raise LoopError(f"normal_force_N must be positive (pressing), but its median is {np.median(normal):g}")
    return normal, turned


def _clipping_notes(displacement: Array, force: Array) -> list[str]:
    """Notes on channels of which up to 5 % of the samples are clipped.

    Raises LoopError if more are, as the loop's size is then unknown.
    """
    notes = []
    found = {"displacement": clipped(displacement), "tangential force": clipped(force, beside=displacement)}
    for name, clip in found.items():
        if clip is None:
            continue
        unit, doubt = "µm" if name == "displacement" else "N", "" if clip.sure else ", or flat within one step"
        said = f"the {name} is clipped at the end of its range{doubt}: {clip.text} {unit}, while the others scatter"
        # A loop of which a larger share of a channel's samples is clipped is no measurement.
        if clip.sure and np.count_nonzero(clip.samples) > 0.05 * force.size:
            raise LoopError(f"{said}, so that neither friction nor energy can be determined")
        notes.append(f"{said}; its largest value is a lower bound")
    return notes


def _require_change(channel: Array, name: str) -> None:
    if np.ptp(channel) <= max(1e-9 * np.max(np.abs(channel)), 1.0 / LARGEST):
        raise LoopError(f"{name} never changes, so there is no loop to analyse")


def _without_outliers(order: NDArray[np.intp], time: Array, displacement: Array, force: Array) -> NDArray[np.intp]:
    """Indices of the samples that are no outliers in either channel; repeated, as one outlier can hide another beside
    it.

    Force peaks of stick-slip and of static friction stay.
    """
    signal = np.zeros(time.size, bool)
    while len(order) >= FEWEST_SAMPLES:
        odd_force = outliers(force[order], time[order]) & ~signal[order]
        if odd_force.any():
            noise = sample_noise(force[order], time[order])
            signal[order] |= signal_among(odd_force, force[order], time[order], noise)
        outside = outliers(displacement[order], time[order]) | (odd_force & ~signal[order])
        if not outside.any():
            break
        order = order[~outside]
    return order


def _smooth_normal(normal: Array | None, time: Array, order: NDArray[np.intp]) -> tuple[Array | None, float]:
    """Smoothed normal force of the samples in order, and the deviation of its mean; None if it falls to zero."""
    if normal is None:
        return None, 0.0
    if np.ptp(normal) == 0.0:
        return normal[order], 0.0
    smooth = smooth_periodic(time[order], normal[order], lowest_harmonic=0)
    if not np.all(smooth.values > 0.0):
        return None, 0.0
    return smooth.values, smooth.noise / float(np.sqrt(len(order)))


def _one_cycle(order: NDArray[np.intp], displacement: Array) -> NDArray[np.intp]:
    """Indices in order, without the samples behind one full cycle.

    Raises LoopError if the samples hold more than a cycle and a quarter.
    """
    path = displacement[order]
    turns = turns_of(path)
    cycles = cycles_between(path, turns)
    if cycles > MOST_CYCLES:
        raise LoopError(
            f"the samples sweep the stroke {round(2.0 * cycles)} times where one cycle was expected: they are "
            f"{cycles:.3g} cycles of the drive"
        )
    starts = cycle_starts(path, turns)
    ends = starts[starts > WHOLE * len(order) / MOST_CYCLES]
    # Fewer samples past one cycle than 2 % do no harm.
    return order[: ends[0]] if ends.size and ends[0] < 0.98 * len(order) else order


def _closed(loop: CleanLoop) -> CleanLoop:
    """Loop with a note if its ends do not meet. Raises LoopError if they differ by more than half of the stroke."""
    low, high = np.percentile(loop.displacement_um, [1, 99])
    level = (loop.displacement_um - low) / (high - low)
    gap = float(abs(level[-1] - level[0]))
    if gap > 0.5:
        raise LoopError(
            f"the samples end {gap:.0%} of the stroke away from where they start: this is not a whole cycle"
            f"{', but half of one, as where a count steps twice a cycle' if gap > 0.9 else ''}"
        )
    if gap > max(0.05, 3.0 * float(np.max(np.abs(np.diff(level)), initial=0.0))):
        return loop.noted(f"the loop is open by {gap:.0%} of the stroke and was closed by a straight line")
    return loop


def _turned(loop: CleanLoop) -> CleanLoop:
    """Loop that dissipates energy: reversed in time if its force rises with the displacement, else with opposite force.
    A load that varies stiffens and softens the contact, by which a loop that hardly slips may turn either way round.

    Raises LoopError if it dissipates although its force falls where the displacement rises.
    """
    area = enclosed_area(loop.displacement_um, loop.force_N)
    thin = 5.0 * loop.force_noise_N * float(np.sqrt(np.sum(np.diff(loop.displacement_um) ** 2)))
    # Of both over the way, however many samples lie where.
    way = np.abs(np.diff(loop.displacement_um, append=loop.displacement_um[0]))
    (own, both), (_, other) = np.cov(loop.displacement_um, loop.force_N, aweights=way + np.roll(way, 1))
    lean = float(both / np.sqrt(own * other))
    if area >= -thin and lean < FALLING:
        raise LoopError(
            "the force falls where the displacement rises, and yet the loop turns as one that dissipates: the force "
            "has the other sign, and is late by more than the contact slides or runs backwards in time"
        )
    load = loop.normal_force_N
    if area >= -thin or (lean > 0.0 and load is not None and np.ptp(load) > VARIES * load.mean()):
        return loop
    if lean > 0.0:
        backwards = replace(loop, time=-loop.time)
        return backwards.taken(np.arange(len(loop.index))[::-1]).noted(BACKWARDS)
    opposite = replace(loop, force_N=-loop.force_N)
    return opposite.noted("the tangential force drives the motion as given, so its sign was changed")
