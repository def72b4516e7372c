"""Where numbers are read (cycle, branch, level or wire), and how far solvers differ there."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Array, BoolArray, IntArray
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.model.forward import LoopCourse
from wirewear.diagnosis.model.readings import MIDDLE, SLIDING
from wirewear.diagnosis.model.setup import Setup

_OF_DIFFERENCES = constants("observe.differences")

#: Share of a solver difference that is not smooth from one level to the next.
ROUGH = _OF_DIFFERENCES.number("rough")


@dataclass(frozen=True)
class Site:
    """Where one number is read: after which cycle, on which branch and at which level of it, of which wire's scar.

    `branch` is +1, −1, or 0 for the whole loop; `level` is what the observable says (a displacement, a force), 0 where
    it has none; `wire` and `figure` are empty but for scars.
    """

    cycle: int
    branch: int = 0
    level: float = 0.0
    wire: str = ""
    figure: str = ""


@dataclass(frozen=True, eq=False)
class Sites:
    """The same of several numbers, (n,) each."""

    cycle: IntArray
    branch: IntArray
    level: Array
    wire: NDArray[np.str_]
    figure: NDArray[np.str_]

    @classmethod
    def of(cls, sites: Sequence[Site]) -> Sites:
        """From one object a number."""
        return cls(
            np.array([site.cycle for site in sites], dtype=np.int64),
            np.array([site.branch for site in sites], dtype=np.int64),
            np.array([site.level for site in sites], dtype=float),
            np.array([site.wire for site in sites], dtype=np.str_),
            np.array([site.figure for site in sites], dtype=np.str_),
        )

    def __len__(self) -> int:
        return self.cycle.size

    def __iter__(self) -> Iterator[Site]:
        columns = (self.cycle, self.branch, self.level, self.wire, self.figure)
        for cycle, branch, level, wire, figure in zip(*(column.tolist() for column in columns), strict=True):
            yield Site(cycle, branch, level, wire, figure)

    def taken(self, keep: BoolArray) -> Sites:
        """Part of them."""
        return Sites(self.cycle[keep], self.branch[keep], self.level[keep], self.wire[keep], self.figure[keep])

    @cached_property
    def branches(self) -> list[tuple[int, int, NDArray[np.intp]]]:
        """Cycle, sign and places of the numbers that lie on one branch of one cycle together."""
        pairs = sorted({(int(cycle), int(sign)) for cycle, sign in zip(self.cycle, self.branch, strict=True)})
        return [(*pair, np.flatnonzero((self.cycle == pair[0]) & (self.branch == pair[1]))) for pair in pairs]


def rows_of(course: LoopCourse, sites: Sites) -> NDArray[np.intp]:
    """Row (n,) of a course in which each site's cycle stands."""
    return np.searchsorted(course.cycles, sites.cycle)


@dataclass(frozen=True)
class Scale:
    """Amplitude and plateau force of a test, by which places along its loops are measured."""

    amplitude_um: float
    force_N: float


@dataclass(frozen=True, eq=False)
class Smoothness:
    """How differences at several numbers (n,) hang together.

    Attributes:
        along: (n,) place along a branch, in lengths over which differences are alike.
        turned: by how much differences at both branches are alike where they would be, 0 to 1.
        rough: (n,) share of a difference's standard deviation that is each number's own.
        family: (n,) numbers of different families have nothing in common.
    """

    along: Array
    turned: float
    rough: Array
    family: NDArray[np.intp]

    @classmethod
    def of_whole_loops(cls, count: int) -> Smoothness:
        """That of one number a loop: differences hang together over the cycles alone."""
        return cls(np.zeros(count), 1.0, np.full(count, ROUGH), np.zeros(count, dtype=np.intp))


@dataclass(frozen=True, eq=False)
class SolverSize:
    """How far solvers differ in several numbers (n,) on the same test, in the observable's unit, standard deviations.

    Attributes:
        size: (n,) what is smooth over cycles and along branches (`Observable.smoothness`).
        own: (n,) each number's own; none if left out.
        common: (n,) by which one unknown moves all of them together; none if left out.
        wall: (n,) at which end of the stroke ripples of the scar move the number: +1, −1, or 0 for both alike.
        hooked: whether hooks that solvers compute larger or smaller move the number.
    """

    size: Array
    own: Array | None = None
    common: Array | None = None
    wall: Array | None = None
    hooked: bool = True


@dataclass(frozen=True, eq=False)
class ModelLoops:
    """A course under a setup."""

    setup: Setup
    course: LoopCourse

    @cached_property
    def scale(self) -> Scale:
        """The amplitude, and the least of the loops' largest forces."""
        force = np.abs(self.course.tangential_force_N).max(axis=(1, 2))
        return Scale(self.setup.amplitude_um, float(force.min()))

    def rise_N(self, sites: Sites) -> Array:
        """Force (n,) that the scar's slopes add towards the end of the branch towards +x."""
        return self._rise_N[rows_of(self.course, sites)]

    def stick_compliance_um_per_N(self, sites: Sites) -> Array:
        """Travel over rise (n,) of the branch towards +x until it slides."""
        x, q = self.course.displacement_um, self.course.tangential_force_N
        travel, rise = (values[:, 0, SLIDING] - values[:, 0, 0] for values in (x, q))
        return np.asarray(travel / np.maximum(rise, 1e-9))[rows_of(self.course, sites)]

    def travel_um(self, sites: Sites, force_N: float) -> Array:
        """Travel (n,) of the model's branches over forces within ±`force_N` of each site's level."""
        return travel_um(self.course, sites, sites.level - force_N, sites.level + force_N)

    @cached_property
    def _rise_N(self) -> Array:
        force = self.course.tangential_force_N
        return np.asarray(force[:, 0, -1] - force[:, 0, MIDDLE])


def along_branches(course: LoopCourse, sites: Sites, value: Callable[[Array, Array, NDArray[np.intp]], Array]) -> Array:
    """Values (n,) that a function gives of the branch of each site, and its places; of whole loops that towards +x.

    It takes displacements and forces (m,) in the direction of travel, so that both rise.
    """
    values = np.empty(len(sites))
    for cycle, sign, places in sites.branches:
        row, side = int(np.searchsorted(course.cycles, cycle)), int(sign < 0)
        x, q = ((1, -1)[side] * channel[row, side] for channel in (course.displacement_um, course.tangential_force_N))
        values[places] = value(x, q, places)
    return values


def travel_um(course: LoopCourse, sites: Sites, low_N: Array, high_N: Array) -> Array:
    """Travel (n,) of a course's branches from one force (n,) in their direction to the other at each site."""

    def travelled(x: Array, q: Array, at: NDArray[np.intp]) -> Array:
        rising = np.maximum.accumulate(q)
        return np.asarray(np.interp(high_N[at], rising, x) - np.interp(low_N[at], rising, x))

    return along_branches(course, sites, travelled)
