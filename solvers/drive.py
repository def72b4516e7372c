"""How a fretting cycle is driven: displacement, normal load and bulk stress over time as shares of the cycle passed.

A quasi-static contact does not depend on how fast it is moved, only on the displacements of a stroke and the load at
each of them. Time determines which load meets which displacement, and how fast the bodies slide. A cycle begins at
+amplitude; the stroke to -amplitude is called falling. A place is a displacement of the drive, in mm or over the
amplitude as stated.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from math import acos, ceil, pi, sqrt
from typing import Any, NamedTuple

import numpy as np

from geometry.arrays import Array, BoolArray
from solvers.bulk_stress import BulkStress
from solvers.errors import SolverError

_SAME = 1e-9  # Shares that differ by less count as equal.
_LEAST_STEP = 1e-3  # Of the amplitude: places nearer than that to a kink of the load are replaced by it.
#: Share of the test's load below which nothing is pressed: a fresh contact of so little is less than an element.
LEAST_LOAD = 0.01
_SAMPLES = 720  # Places of a stroke at which loads are compared.
_NO_STROKES = (
    "a displacement over time must go from 1 to -1 and back once in a cycle, without turning or resting on its way: it "
    "is that from mid-stroke, where the bodies are pressed together, over its amplitude"
)
_FINER = 4  # Increments of a cycle whose load changes, over those of one whose load does not.


Points = tuple[tuple[float, float], ...]


def _curve(points: Sequence[tuple[float, float]], what: str) -> tuple[Array, Array]:
    """Times and values of the points of a closed cycle; `what` names it in messages.

    Raises SolverError, in one sentence, unless times grow from 0 to 1 and the last value equals the first.
    """
    times, values = np.array(points, dtype=float).T
    if times[0] != 0.0 or times[-1] != 1.0 or not (np.diff(times) > 0.0).all() or abs(values[-1] - values[0]) > _SAME:
        raise SolverError(f"the points of {what} must begin at a time of 0, grow to 1, and end with their first value")
    return times, values


def _along(points: Points, times: Array) -> Array:
    """Values (m,) on straight lines between a cycle's points at times (m,), in any cycle."""
    known, values = np.array(points).T
    return np.asarray(np.interp(times % 1.0, known, values))


@dataclass(frozen=True)
class Waveform:
    """Displacement over its amplitude during a cycle: a cosine, or straight lines between points.

    points: (share of the cycle passed, displacement over amplitude); empty for a cosine.

    Raises SolverError unless the displacement goes from 1 to -1 and back once, and rests at these ends only; bodies are
    pressed together in the middle of the stroke.
    """

    points: Points = ()

    def __post_init__(self) -> None:
        if self.points:
            for sign, stroke in zip((1.0, -1.0), self._strokes, strict=True):
                if len(stroke.places) < 2 or not (np.diff(sign * stroke.places) < 0.0).all():
                    raise SolverError(_NO_STROKES)

    @cached_property
    def _strokes(self) -> "tuple[_Stroke, _Stroke]":
        """The stroke from 1 to -1, and the stroke back."""
        times, places = _curve(self.points, "a displacement over time")
        times, places = times[:-1], places[:-1]
        top, count = places >= 1.0 - _SAME, len(places)
        if not top.any() or top.all() or np.abs(places).max() > 1.0 + _SAME:
            raise SolverError(_NO_STROKES)
        order = int(np.flatnonzero(top & ~np.roll(top, -1))[0]) + np.arange(count + 1)
        times, places = times[order % count] + order // count, places[order % count]
        bottom, back = np.flatnonzero(places <= _SAME - 1.0), int(np.flatnonzero(places[1:] >= 1.0 - _SAME)[0]) + 1
        if not len(bottom) or np.ptp(bottom) != len(bottom) - 1 or (places[back:] < 1.0 - _SAME).any():
            raise SolverError(_NO_STROKES)
        leaves = int(bottom[-1])
        falls = _Stroke(times[: bottom[0] + 1], places[: bottom[0] + 1], float(times[leaves]))
        return falls, _Stroke(times[leaves : back + 1], places[leaves : back + 1], float(times[-1]))

    def times(self, places: Array, phases: Array) -> Array:
        """Shares of the cycle (m,) at which the displacement over its amplitude is `places` (m,).

        phases: (m,) shares at which a cosine would be there; only the stroke counts: to -1 up to 0.5, back beyond.
        """
        if not self.points:
            return phases
        falls, rises = self._strokes
        return np.where(
            phases <= 0.5, np.interp(-places, -falls.places, falls.times), np.interp(places, rises.places, rises.times)
        )

    def places(self, times: Array) -> Array:
        """Displacement over amplitude (m,), from -1 to 1, at shares of the cycle (m,)."""
        return _along(self.points, times) if self.points else np.cos(2.0 * np.pi * times)

    def speed(self, place: float, *, falling: bool) -> float:
        """Speed at a displacement over amplitude `place`, in amplitudes per cycle, never negative; falling: True on the
        stroke to -1.
        """
        if not self.points:
            return 2.0 * pi * sqrt(max(1.0 - place**2, 0.0))
        own = self._strokes[0 if falling else 1]
        segment = np.searchsorted(np.abs(own.places[1:-1] - own.places[0]), abs(place - own.places[0]))
        return float(abs(np.diff(own.places)[segment] / np.diff(own.times)[segment]))

    def stroke(self, *, falling: bool) -> tuple[float, float, float]:
        """Shares of the cycle at which a stroke begins, at which it reaches its other end, and at which the next one
        begins, later by a rest there. falling: True for the stroke from 1 to -1.
        """
        if not self.points:
            return (0.0, 0.5, 0.5) if falling else (0.5, 1.0, 1.0)
        own = self._strokes[0 if falling else 1]
        return float(own.times[0]), float(own.times[-1]), own.leaves


class _Stroke(NamedTuple):
    """Times (m,) and places (m,) of a displacement from one end to the other, and the time at which it leaves
    that end.
    """

    times: Array
    places: Array
    leaves: float


def triangular() -> Waveform:
    """The waveform at constant speed from end to end, beginning at 1."""
    return Waveform(((0.0, 1.0), (0.5, -1.0), (1.0, 1.0)))


def trapezoidal(dwell: float) -> Waveform:
    """The waveform at constant speed from end to end, with a rest of `dwell` of the cycle at either end.

    It begins in the middle of the rest at 1. Raises SolverError unless `dwell` is between 0 and 0.5.
    """
    if not 0.0 < dwell < 0.5:
        raise SolverError(f"a drive rests at each end for a share of the cycle between 0 and 0.5, not for {dwell:g}")
    half = 0.5 * dwell
    return Waveform(((0.0, 1.0), (half, 1.0), (0.5 - half, -1.0), (0.5 + half, -1.0), (1.0 - half, 1.0), (1.0, 1.0)))


@dataclass(frozen=True)
class LoadCycle:
    """Normal load over the test's load during a cycle: 1 + amplitude cos(2 pi ratio t - lag), with t the share of the
    cycle passed, or straight lines between points.

    points: (share of the cycle passed, share of the load); empty for the cosine. Negative values count as 0. Raises
    SolverError for a ratio below 1, points that do not form a cycle, or a load that is never positive.
    """

    amplitude: float = 0.0
    lag_rad: float = 0.0
    ratio: int = 1
    points: Points = ()

    def __post_init__(self) -> None:
        if self.points:
            _curve(self.points, "a load over time")
        if self.ratio < 1 or not self.largest > 0.0:
            raise SolverError("a load must press at some time of its cycle, and repeat a whole number of times in it")

    @property
    def steady(self) -> bool:
        return self.amplitude == 0.0 and not self.points

    def shares(self, times: Array) -> Array:
        """Load over the test's load (m,), never below 0, at shares of the cycle (m,)."""
        if self.points:
            return np.maximum(_along(self.points, times), 0.0)
        return np.maximum(1.0 + self.amplitude * np.cos(2.0 * np.pi * self.ratio * times - self.lag_rad), 0.0)

    def bends(self, start: float, end: float) -> Array:
        """Shares (k,) of the cycle between `start` and `end` at which the load has a kink or becomes 0, increasing."""
        if self.points:
            (times, loads), within = np.array(self.points).T, list[float]()
            for (t0, p0), (t1, p1) in pairwise(zip(times, loads, strict=True)):
                within += [t0] if p0 * p1 >= 0.0 else [t0, t0 + (t1 - t0) * p0 / (p0 - p1)]
        elif abs(self.amplitude) > 1.0:
            opens = np.arccos(-1.0 / self.amplitude)
            turns = np.arange(self.ratio)[:, None] + (np.array([opens, -opens]) + self.lag_rad) / (2.0 * np.pi)
            within = list(turns.ravel() / self.ratio)
        else:
            within = []
        every = np.add.outer([-1.0, 0.0, 1.0, 2.0], np.array(within) % 1.0).ravel()
        return np.sort(every[(every > start + _SAME) & (every < end - _SAME)])

    @property
    def largest(self) -> float:
        return max((share for _, share in self.points), default=1.0 + abs(self.amplitude))

    @property
    def least(self) -> float:
        return max(min((share for _, share in self.points), default=1.0 - abs(self.amplitude)), 0.0)


@dataclass(frozen=True)
class Path:
    """Displacement, load and bulk strain at the ends of m increments of a cycle, (m,) each."""

    drive: Array  #: Displacement, mm.
    phase: Array  #: Share of its cycle that a cosine from +amplitude has passed there, in (0, 1].
    time: Array  #: Share of the cycle passed by the drive's own waveform.
    load: Array  #: Normal load over the test's.
    #: (m, 2, 2, 2) displacement gradients of the lower and the upper body's surface by their bulk stress, see
    #: `BulkStress.gradient`.
    bulk: Array

    def __add__(self, other: "Path") -> "Path":
        return Path(*(np.concatenate(both) for both in zip(self._arrays, other._arrays, strict=True)))

    def __iter__(self) -> Iterator[tuple[Any, ...]]:
        return zip(*self._arrays, strict=True)

    @property
    def from_middle(self) -> "Path":
        """The part of a stroke after it has passed a drive of 0."""
        middle = int(np.flatnonzero(self.drive == 0.0)[0])
        return Path(*(values[middle + 1 :] for values in self._arrays))

    def without(self, left_out: BoolArray) -> "Path":
        """The path without those ends of increments that `left_out` (m,) marks."""
        return Path(*(values[~left_out] for values in self._arrays))

    @property
    def _arrays(self) -> tuple[Array, Array, Array, Array, Array]:
        return self.drive, self.phase, self.time, self.load, self.bulk


@dataclass(frozen=True)
class Drive:
    """A cycle's displacement, of an amplitude and a waveform, its normal load, and bulk stresses.

    bulk: of (lower body, upper body), or empty for none.
    """

    amplitude_mm: float
    waveform: Waveform = Waveform()
    load: LoadCycle = LoadCycle()
    bulk: tuple[BulkStress, ...] = ()

    @property
    def steady(self) -> bool:
        return self.load.steady and not any(any(own.amplitude) for own in self.bulk)

    def followed_by(self, increments: int) -> int:
        """Number of increments per cycle that this drive needs, given the number that suffices under constant load and
        bulk stress: that number, or 4 times as many where they change.

        Changes make the contact slide and stick anywhere in a stroke, on a soft rig even against the drive.
        """
        return increments if self.steady else _FINER * increments

    @property
    def shears(self) -> bool:
        """True if a bulk stress shears a surface, which breaks the mirror symmetry within a position."""
        return any(own.mean[2] or own.amplitude[2] for own in self.bulk)

    @property
    def mean_bulk(self) -> Array:
        """Displacement gradients (2, 2, 2) of the (lower, upper) body's surface by their mean bulk stress, 0 without;
        see `BulkStress.gradient`.
        """
        found = np.zeros((2, 2, 2))
        for body, own in enumerate(self.bulk):
            found[body] = own.gradient(np.array(own.mean))
        return found

    def bulk_at(self, times: Array) -> Array:
        """Displacement gradients (m, 2, 2, 2) of the (lower, upper) body's surface at shares (m,) of the cycle, 0
        without bulk stress.
        """
        found = np.zeros((len(times), 2, 2, 2))
        for body, own in enumerate(self.bulk):
            found[:, body] = own.gradient(own.nominal(times))
        return found

    def stroke(self, side: float, places: Array) -> Path:
        """The path from `side` (1 or -1) times the amplitude through places (m,) in mm, the last of which is the other
        end.

        It also stops at every kink of the load, and goes on at the end while the drive rests and the load changes.
        Kinks within 0.1 % of the amplitude from an end, where the drive all but rests, are passed at that end. There is
        no stop where the load is below 1 % of the test's beside a load of 0.
        """
        falling = side > 0.0
        ends = np.array([self.waveform.stroke(falling=falling)[1]])
        if not self.steady:
            places, ends = self._stops(side, places)
        phase = phases(places / self.amplitude_mm, falling=falling)
        time = np.append(self.waveform.times(places / self.amplitude_mm, phase)[:-1], ends)
        drive, phase = (np.append(own[:-1], np.full(len(ends), own[-1])) for own in (places, phase))
        load = np.ones(len(time)) if self.load.steady else self.load.shares(time)
        path = Path(drive, phase, time, load, self.bulk_at(time))
        return path if self.load.steady else path.without(_hardly_pressed(load) & (np.abs(drive) > 0.0))

    def _stops(self, side: float, places: Array) -> tuple[Array, Array]:
        """The places of a stroke with those of the load's kinks, and the times of increments that end at its end."""
        falling, amplitude = side > 0.0, self.amplitude_mm
        start, reached, leaves = self.waveform.stroke(falling=falling)
        # Kinks of the load that come later after a stroke's end are the next one's.
        times = self.load.bends(start, leaves + 0.1)
        ahead = side * self.waveform.places(times)
        turned = times[(ahead < _LEAST_STEP - 1.0) & (np.abs(times - reached) > _SAME)]
        before = times[(ahead > 1.0 - _LEAST_STEP) & (times < reached)]
        bends = side * amplitude * ahead[(np.abs(ahead) <= 1.0 - _LEAST_STEP) & (times < reached)]
        near = np.abs(np.subtract.outer(places, bends)).min(axis=1, initial=np.inf)
        fixed = (places == 0.0) | (np.arange(len(places)) == len(places) - 1)
        bends = bends[np.abs(np.subtract.outer(bends, places[fixed])).min(axis=1) > _LEAST_STEP * amplitude]
        passed = self.waveform.times(places / amplitude, phases(places / amplitude, falling=falling))
        moves = (passed > before.max(initial=start)) & (passed < turned.min(initial=reached))
        kept = places[fixed | (moves & (near > _LEAST_STEP * amplitude))]
        places = -side * np.sort(-side * np.concatenate([kept, bends]))
        return places, self._ends(reached, leaves, turned, len(places) / (reached - start))

    def end(self, side: float) -> Path:
        """The path from mid-stroke to `side` (1 or -1) times the amplitude in one increment, and on while the drive
        rests there and the load changes.
        """
        return self.stroke(-side, np.array([0.0, side * self.amplitude_mm])).from_middle

    def _ends(self, reached: float, leaves: float, kinks: Array, per_time: float) -> Array:
        """Times at which increments end at the end of a stroke: `reached`, and more if load or bulk stress change while
        the drive rests up to `leaves`, or between `kinks` of the load about then.

        per_time: number of increments in a whole cycle.
        """
        count = ceil(per_time * (leaves - reached) - _SAME * per_time)
        times = np.union1d(np.linspace(reached, leaves, max(count, 0) + 1), np.append(kinks, reached))
        changes = max(np.ptp(self.load.shares(times)), np.ptp(self.bulk_at(times), axis=0).max()) > 0.0
        return times if changes else np.array([reached])

    @cached_property
    def symmetric(self) -> bool:
        """True if both strokes, load included, are mirror images of each other, and bulk stresses are constant: one
        that varies stretches a surface at one end of the stroke and shortens it at the other.
        """
        there, back = (path.load for path in self._sampled)
        return (
            not any(any(own.amplitude) for own in self.bulk)
            and there.shape == back.shape
            and bool(np.abs(there - back).max() <= _SAME)
        )

    @property
    def mean_load(self) -> float:
        """Normal load over the test's, averaged over the drive's motion, not over time."""
        if self.load.steady:
            return 1.0
        paths = (np.column_stack([path.drive, path.load]) for path in self._sampled)
        means = (np.abs(np.diff(way[:, 0])) @ (way[1:, 1] + way[:-1, 1]) for way in paths)
        return float(sum(means)) / (8.0 * self.amplitude_mm)

    @cached_property
    def least_load_per_place(self) -> float:
        """Smallest ratio in a cycle of load over the test's load to |displacement| over amplitude; 1 under a constant
        load.

        A tangential force in proportion to the displacement is nearest to sliding there.
        """
        if self.load.steady:
            return 1.0
        places = np.concatenate([np.abs(path.drive) / self.amplitude_mm for path in self._sampled])
        loads = np.concatenate([path.load for path in self._sampled])
        return float((loads / np.maximum(places, _LEAST_STEP)).min())

    @cached_property
    def _sampled(self) -> tuple[Path, Path]:
        places = self.amplitude_mm * np.cos(np.pi * np.arange(_SAMPLES + 1) / _SAMPLES)
        return self.stroke(1.0, places), self.stroke(-1.0, -places)


def _hardly_pressed(load: Array) -> BoolArray:
    """Which ends (m,) of increments but the last have a load of less than LEAST_LOAD, next to one of none."""
    light, found = load < LEAST_LOAD, np.zeros(len(load), dtype=bool)
    for run in np.split(np.arange(len(load)), np.flatnonzero(np.diff(light)) + 1):
        found[run] = light[run[0]] and load[run].min() <= _SAME
    found[-1] = False
    return found & (load > _SAME)


def phases(places: Array, *, falling: bool) -> Array:
    """Shares (m,) of its cycle that a cosine from 1 has passed at `places` (m,), from -1 to 1; falling: True for the
    stroke to -1 (shares up to 0.5), False for the way back.
    """
    angle = np.array([acos(max(-1.0, min(1.0, place))) for place in places]) / (2.0 * np.pi)
    return angle if falling else 1.0 - angle
