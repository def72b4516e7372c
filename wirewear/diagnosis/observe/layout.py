"""What is observed of a record: a fixed list of numbers that its loops, evolution and scars give."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Array, BoolArray, IntArray
from wirewear.diagnosis.model.forward import LoopCourse
from wirewear.diagnosis.observe.observable import AlongBranch, Observable
from wirewear.diagnosis.observe.sites import Site, Sites


@dataclass(frozen=True, eq=False)
class Features:
    """Linear combinations of observables: which `members` (f, n) belong to each, `slope` (f,) if it is one.

    `place` (n,) is where along its branch an observable lies, `cycle` (f,) the cycle of a feature.
    """

    members: BoolArray
    slope: BoolArray
    place: Array
    cycle: IntArray

    @classmethod
    def of(cls, layout: Layout, used: BoolArray) -> Features:
        """Features of the observables marked."""
        members, slope, cycles = [], [], []
        place = np.zeros(len(layout))
        numbers = np.arange(len(layout))
        for part in layout:
            own = numbers[part.rows]
            if isinstance(part.observable, AlongBranch):
                place[own] = part.observable.along(part.sites)
                groups = [(own[places], cycle) for cycle, _, places in part.sites.branches]
            else:
                groups = [(own[[i]], int(cycle)) for i, cycle in enumerate(part.sites.cycle)]
            for rows, cycle in groups:
                here = np.isin(numbers, rows[used[rows]])
                for tilt in (False, True):
                    if here.sum() > int(tilt):
                        members.append(here)
                        slope.append(tilt)
                        cycles.append(cycle)
        return cls(
            np.array(members, dtype=bool).reshape(len(members), len(layout)),
            np.array(slope, dtype=bool),
            place,
            np.array(cycles, dtype=np.int64),
        )

    def of_each(self, values: Array, seen: BoolArray) -> Array:
        """Features (f,) of observables (n,), NaN where none was seen."""
        return self._weights(seen) @ np.where(seen, values, 0.0)

    def variances(self, covariance: Array, seen: BoolArray) -> Array:
        """Variances (f,) of the features of observables of that covariance (n, n)."""
        weights = self._weights(seen)
        return np.asarray(np.einsum("fi,ij,fj->f", weights, covariance, weights, optimize=True))

    def _weights(self, seen: BoolArray) -> Array:
        """Weights (f, n): means, and least-squares slopes."""
        weights = (self.members & seen).astype(float)
        count = weights.sum(axis=1, keepdims=True)
        with np.errstate(invalid="ignore", divide="ignore"):
            mean = weights / count
            away = weights * (self.place - (mean @ self.place)[:, None])
            tilt = away / (away**2).sum(axis=1, keepdims=True)
        return np.where(self.slope[:, None], np.where(count > 1, tilt, np.nan), mean)


@dataclass(frozen=True, eq=False)
class Part:
    """One observable at several sites: the numbers from `start` on in a layout."""

    observable: Observable
    sites: Sites
    start: int

    @property
    def rows(self) -> slice:
        """Its numbers in the layout."""
        return slice(self.start, self.start + len(self.sites))


@dataclass(frozen=True, eq=False)
class Layout:
    """Numbers (n,), those of one observable together."""

    parts: tuple[Part, ...]

    @classmethod
    def of(cls, observables: Iterable[tuple[Observable, Sites]]) -> Layout:
        """From each observable and where it is read; those that are read nowhere are left out."""
        parts: list[Part] = []
        start = 0
        for observable, sites in observables:
            if len(sites):
                parts.append(Part(observable, sites, start))
                start += len(sites)
        return cls(tuple(parts))

    @classmethod
    def of_sites(cls, *observables: tuple[Observable, Sequence[Site]]) -> Layout:
        """The same, site by site."""
        return cls.of((observable, Sites.of(sites)) for observable, sites in observables)

    def __len__(self) -> int:
        return sum(len(part.sites) for part in self.parts)

    def __iter__(self) -> Iterator[Part]:
        return iter(self.parts)

    @cached_property
    def cycle(self) -> IntArray:
        """After which each number is read (n,)."""
        return np.concatenate([np.zeros(0, dtype=np.int64), *(part.sites.cycle for part in self)])

    @cached_property
    def cycles(self) -> Array:
        """Cycles at which loops are needed, increasing."""
        return np.unique(self.cycle).astype(float)

    def of_kind(self, *kinds: type) -> BoolArray:
        """Which numbers (n,) are of these observables."""
        return self.marked(part for part in self if isinstance(part.observable, kinds))

    def marked(self, parts: Iterable[Part]) -> BoolArray:
        """Which numbers (n,) are of these parts."""
        marked = np.zeros(len(self), dtype=bool)
        for part in parts:
            marked[part.rows] = True
        return marked

    def wire(self, name: str) -> BoolArray:
        """Which numbers (n,) are read from that wire's scar."""
        return np.concatenate([np.zeros(0, dtype=bool), *(part.sites.wire == name for part in self)])

    def taken(self, keep: BoolArray) -> Layout:
        """Part of the numbers."""
        return Layout.of((part.observable, part.sites.taken(keep[part.rows])) for part in self)

    def zones(self, amplitude_um: float) -> NDArray[np.str_]:
        """Zone of each number (n,): stick, knee, plateau, tip of the loop, or the channel where it has none."""
        return np.concatenate([part.observable.zone(part.sites, amplitude_um) for part in self])

    def observed(self, course: LoopCourse) -> Array:
        """The numbers (n,) of a computed course, which must hold all of `cycles`."""
        return np.concatenate([np.zeros(0), *(part.observable.predict(course, part.sites) for part in self)])
