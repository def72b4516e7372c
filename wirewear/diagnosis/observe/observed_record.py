"""Record prepared for reading observables: coarse loops repaired, loops reduced, with its evolution and scars.

Loops of a coarse simulation, resampled densely, are straight lines between few corners. The lines cut off the corner
between stick and slip, which looks like a softer rig, a rough layer or a wall of another slope; such loops are
therefore read at their corners. Columns of the evolution with other definitions are left out.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from geometry.arrays import Array
from wirewear.base.errors import RecordError
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.observe.local_lines import OUTLYING
from wirewear.diagnosis.observe.measured_loops import LEAST_NOISE, ReducedLoop, of_one_recorder, reduced_loop
from wirewear.loops import LoopError
from wirewear.loops.noise import outliers, sample_noise
from wirewear.records import AnyRecord, MeasuredEvolution, MeasuredLoop, MeasuredProfile, MeasuredScar
from wirewear.records.checking import analysed
from wirewear.records.evolution_checks import other_definitions
from wirewear.records.remarks import of_equal_times

_KNOWN = constants("observe.observed_record.reading")

#: Logged cycles that are used at most.
MOST_CYCLES = _KNOWN.count("most_cycles")

_OF_CORNERS = constants("observe.observed_record.corners")

#: Numbers of corners that are tried (with more, lines cut little of a loop), and samples that a line has at least.
FEWEST_CORNERS, MOST_CORNERS = _OF_CORNERS.count("fewest_corners"), _OF_CORNERS.count("most_corners")
SAMPLES_A_LINE = _OF_CORNERS.count("samples_a_line")

#: Lines with the right corners must beat those with corners half a line later by so many roots of their number, in
#: log-likelihood: noise alone was seen to make four in one record of 171.
LEAST_ADVANTAGE = _OF_CORNERS.number("least_advantage")

#: What they leave of both channels is about alike: lines that happen to follow a displacement cut the corners of the
#: force. Half as long, they leave a mean square smaller by less than this (seen of correlated noise: up to 2.2; of
#: curves that lines follow by chance: 2.4).
MOST_UNLIKE, MOST_GAINED = _OF_CORNERS.each("most_unlike", "most_gained")

#: A corner is known from samples that weigh at least so much together.
LEAST_WEIGHT = _OF_CORNERS.number("least_weight")

#: Lines bend at all of their corners: the median bend is at least this share of the largest, unlike of a triangle.
LEAST_BEND = _OF_CORNERS.number("least_bend")

#: Of so many loops the mean is taken at most, evenly chosen.
MOST_LOOPS = _OF_CORNERS.count("most_loops")


@dataclass(frozen=True, eq=False)
class Reading:
    """Loops, evolution and worn surfaces of all repeats of a record, prepared for reading.

    last_cycle: the end of the test. notes: sentences on the loops that were left out. asked_um, asked_N: amplitude and
    friction force that stand in for the loops' if there are none. depth_noise_um: stated error of one depth of a
    profile. body_names: the driven body first.
    """

    loops: tuple[ReducedLoop, ...]
    evolution: tuple[MeasuredEvolution, ...]
    scars: tuple[MeasuredScar, ...]
    last_cycle: int
    notes: tuple[str, ...]
    profiles: tuple[MeasuredProfile, ...] = ()
    asked_um: float = 1.0
    asked_N: float = 1.0
    depth_noise_um: float = 0.0
    body_names: tuple[str, ...] = ()

    @property
    def repeats(self) -> tuple[int, ...]:
        return tuple(sorted({one.repeat for part in (self.loops, self.profiles) for one in part}))

    @property
    def cycles(self) -> list[int]:
        return sorted({loop.cycle for loop in self.loops})

    @cached_property
    def amplitude_um(self) -> float:
        """Median displacement amplitude of the loops in µm; `asked_um` without loops."""
        return float(np.median([loop.amplitude_um for loop in self.loops])) if self.loops else self.asked_um

    @cached_property
    def force_N(self) -> float:
        """Median force of the loops at mid-stroke in N; `asked_N` without loops."""
        return float(np.median([loop.mid_force_N for loop in self.loops])) if self.loops else self.asked_N

    @cached_property
    def sample_noise_N(self) -> float:
        """Median noise of one force sample in N; 0 without loops."""
        return float(np.median([loop.sample_noise_N for loop in self.loops])) if self.loops else 0.0

    def at(self, cycle: int) -> list[ReducedLoop]:
        """The loops at a cycle, one for each repeat that has it."""
        return [loop for loop in self.loops if loop.cycle == cycle]


def read(record: AnyRecord) -> Reading:
    """Prepare loops, evolution and worn surfaces of a record for reading; profiles alone suffice. Raises RecordError if
    no loop can be read, and no profiles replace them.
    """
    notes: list[str] = []
    loops = list(_loops(record, notes))
    tables, asked = record.tables, record.tables.conditions
    if not loops and (tables.needs_loops or not record.scars):
        raise RecordError(
            f"nothing of the record {record.name!r} can be diagnosed: {notes[0] if notes else 'no loop, no profile'}"
        )
    # Worn surfaces go by their own name: scars or profiles.
    surfaces: dict[str, Any] = {"scars": (), "profiles": ()}
    surfaces |= {f"{tables.worn.name}s": record.scars} if record.scars else {}
    return Reading(
        tuple(of_one_recorder(loops)) if loops else (),
        record.evolution,
        last_cycle=int(asked.cycles),
        notes=tuple(notes),
        asked_um=asked.displacement_amplitude_um,
        asked_N=(tables.stated.final_friction or 1.0) * asked.normal_load_N,
        depth_noise_um=tables.depth_noise_um,
        body_names=tables.body_names,
        **surfaces,
    )


def spread_cycles(cycles: Sequence[int], most: int) -> list[int]:
    """At most `most` of the increasing cycles, spread evenly over their logarithm, including the first and the last."""
    if len(cycles) <= most:
        return list(cycles)
    wanted = np.linspace(np.log(max(cycles[0], 1)), np.log(max(cycles[-1], 1)), most)
    known = np.log(np.maximum(cycles, 1))
    return sorted({cycles[int(np.argmin(np.abs(known - at)))] for at in wanted})


def _loops(record: AnyRecord, notes: list[str]) -> Iterator[ReducedLoop]:
    for cycle in spread_cycles([cycle for cycle in record.cycles if cycle > 0], MOST_CYCLES):
        for loop in (one for one in record.loops if one.cycle == cycle):
            try:
                yield reduced_loop(loop, record.tables.noise, record.tables.conditions.normal_load_N)
            except (LoopError, ValueError, IndexError) as error:
                notes.append(f"the loop of {loop.name} was left out: {error}")


@dataclass(frozen=True, eq=False)
class _Lines:
    """Periodic lines between evenly spaced corners: hat functions (n, corners), and the pseudo-inverse (corners, n)."""

    hats: Array
    inverse: Array

    @classmethod
    def between(cls, corners: int, shares: Array, offset: float = 0.0) -> _Lines:
        """Lines with corners at (i + offset)/corners of a cycle, for samples at shares (n,) of the cycle."""
        place = (shares * corners - offset) % corners
        first = np.minimum(place.astype(np.intp), corners - 1)
        rows = np.arange(shares.size)
        hats = np.zeros((shares.size, corners))
        hats[rows, first] = 1.0 - (place - first)
        hats[rows, (first + 1) % corners] += place - first
        return cls(hats, np.linalg.pinv(hats.T @ hats, rcond=1e-12, hermitian=True) @ hats.T)

    def at_corners(self, values: Array) -> Array:
        """Values at the corners (corners,) of lines fitted to samples (n,), without outliers."""
        found, kept = self.inverse @ values, np.ones(values.size, dtype=bool)
        least = 1e-12 * float(np.ptp(values))
        for _ in range(values.size // 10):
            away = np.where(kept, np.abs(values - self.hats @ found), 0.0)
            worst = int(away.argmax())
            kept[worst] = False
            usual = OUTLYING * 1.4826 * float(np.median(away)) + least
            if away[worst] <= usual or not np.all(self.hats[kept].sum(axis=0) > LEAST_WEIGHT):
                break
            found = np.asarray(np.linalg.lstsq(self.hats[kept], values[kept], rcond=None)[0])
        return found

    def squares(self, values: Array, noise: float) -> float:
        """Sum of squared residuals of samples (n,) in units of their noise; each counts at most as an outlier."""
        rest = (values - self.hats @ (self.inverse @ values)) / noise
        return float(np.minimum(rest**2, OUTLYING**2).sum())


def repaired(record: AnyRecord) -> tuple[AnyRecord, tuple[str, ...]]:
    """Copy of a record with coarse loops read at their corners and without columns of other definitions, and sentences
    on both.
    """
    own, notes = of_own_definitions(record)
    read, note = read_at_corners(own)
    return read, ((note,) if note else ()) + notes


def read_at_corners(record: AnyRecord) -> tuple[AnyRecord, str | None]:
    """Copy of a record whose loops are straight lines between few points, reduced to these points, and a sentence on
    it; the record itself and None for other loops.
    """
    frequency = record.tables.conditions.frequency_Hz
    loops = [loop for loop in record.loops if loop.cycle > 0]
    alike = next(iter(of_equal_times(loops)), [])
    count = corners_of(alike[:: -(-len(alike) // MOST_LOOPS)], frequency) if alike else None
    if count is None:
        return record, None
    shares = _shares(alike[0], frequency)
    lines = _Lines.between(count, shares)
    chosen = {id(loop) for loop in alike}
    read = [_at_corners(loop, lines, frequency) if id(loop) in chosen else loop for loop in record.loops]
    note = (
        f"the loops are straight lines between {count} points a cycle, as a simulation of {count} increments leaves "
        f"them: they were read at those points, not at the {shares.size} samples between"
    )
    return replace(record, loops=tuple(read)), note


def corners_of(loops: Sequence[MeasuredLoop], frequency_Hz: float) -> int | None:
    """Number of points in a cycle between which loops, all sampled at the same times, are straight lines; None for
    curves.

    Corners are at even times from the beginning of the cycle. In the mean of all loops noise is small enough: lines
    with the right corners leave noise alone, and must fit both channels better than lines shifted by half a line, which
    fit a smooth curve equally well.
    """
    if not loops or loops[0].time_s.size < FEWEST_CORNERS * SAMPLES_A_LINE:
        return None
    shares = _shares(loops[0], frequency_Hz)
    # Means in which neighbours stand in for outliers.
    channels = [
        np.mean([_healed(getattr(loop, name), shares) for loop in loops], axis=0)
        for name in ("displacement_um", "tangential_force_N")
    ]
    noise = [max(sample_noise(mean, shares), LEAST_NOISE * float(np.ptp(mean))) for mean in channels]
    if min(noise) == 0.0:
        return None

    def left(corners: int, offset: float = 0.0) -> Array:
        lines = _Lines.between(corners, shares, offset)
        return np.array([lines.squares(mean, own) for mean, own in zip(channels, noise, strict=True)])

    samples, best, count = shares.size, 0.0, None
    for corners in range(FEWEST_CORNERS, min(samples // SAMPLES_A_LINE, MOST_CORNERS) + 1, 2):
        squares = left(corners)
        dispersion = np.maximum(squares / (samples - corners), 1.0)
        if dispersion[1] > MOST_UNLIKE**2 * dispersion[0] or dispersion.max() > OUTLYING**2:
            continue
        advantage = float(np.min((left(corners, 0.5) - squares) / dispersion)) / (2.0 * np.sqrt(corners))
        if advantage > max(best, LEAST_ADVANTAGE):
            best, count = advantage, corners
    if count is None or not _bends_throughout(_Lines.between(count, shares), channels[0]):
        return None
    if 2 * count >= samples:
        return count
    # A curve would be followed much better by lines half as long.
    more = np.maximum(left(2 * count) / (samples - 2 * count), 1.0)
    fewer = np.maximum(left(count) / (samples - count), 1.0)
    return count if np.all(fewer < MOST_GAINED * more) else None


def _bends_throughout(lines: _Lines, values: Array) -> bool:
    corners = lines.at_corners(values)
    bends = np.abs(np.roll(corners, 1) - 2.0 * corners + np.roll(corners, -1))
    return bool(np.median(bends) > LEAST_BEND * bends.max())


def _healed(values: Array, shares: Array) -> Array:
    bad = outliers(values, shares)
    return np.where(bad, np.interp(shares, shares[~bad], values[~bad], period=1.0), values) if bad.any() else values


def _shares(loop: MeasuredLoop, frequency_Hz: float) -> Array:
    return np.asarray((loop.time_s - loop.time_s[0]) * frequency_Hz)


def _at_corners(loop: MeasuredLoop, lines: _Lines, frequency_Hz: float) -> MeasuredLoop:
    corners = lines.hats.shape[1]
    normal = loop.normal_force_N
    return MeasuredLoop(
        loop.repeat,
        loop.cycle,
        loop.time_s[0] + np.arange(corners) / (corners * frequency_Hz),
        lines.at_corners(loop.displacement_um),
        lines.at_corners(loop.tangential_force_N),
        None if normal is None else lines.at_corners(normal),
    )


def of_own_definitions(record: AnyRecord) -> tuple[AnyRecord, tuple[str, ...]]:
    """Copy of a record with NaN in columns of the evolution that contradict its own loops, and a sentence on each."""
    if not record.evolution:
        return record, ()
    loops = {}
    for loop in analysed(record.loops):
        try:
            loops[loop.repeat, loop.cycle] = loop, loop.figures(record.tables.conditions.normal_load_N)
        except LoopError:
            continue
    other = other_definitions(loops, record.evolution)
    if not other:
        return record, ()
    left_out = {one.column for one in other}
    evolution = tuple(
        replace(
            part,
            columns={
                name: np.full_like(values, np.nan) if name in left_out else values
                for name, values in part.columns.items()
            },
        )
        for part in record.evolution
    )
    return replace(record, evolution=evolution), tuple(f"{one.text}, and left out" for one in other)
