"""An observable: one kind of number that a record gives and a model predicts, in one file with all that is known of it.

A new one is a subclass of `Observable` and an entry in `reduction.py`, or an installed package's entry point.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from itertools import combinations
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Array
from wirewear.diagnosis.model.forward import LoopCourse
from wirewear.diagnosis.model.setup import Setup
from wirewear.diagnosis.observe.local_lines import LocalLine
from wirewear.diagnosis.observe.measured_loops import ReducedLoop
from wirewear.diagnosis.observe.reading import Reading
from wirewear.diagnosis.observe.sites import ModelLoops, Scale, Site, Sites, Smoothness, SolverSize


@dataclass(frozen=True)
class Zone:
    """Part of a loop, or a channel.

    Attributes:
        name: short and unique, in answers.
        picture: label of its row in the map of where the gap lies.
        words: where it is, after the observable's words in a sentence; empty if these say it.
    """

    name: str
    picture: str
    words: str = ""


class Observable(ABC):
    """One kind of number, read at several sites of a record. Subclasses say all of it; nothing stands in for an error.

    Attributes:
        name: short and unique, in answers.
        words, unit: for people; numbers of the unit "relative" are logarithms, shown as ratios.
        zones: its parts of a loop, or the channel that it is.
        sides: what the measurement is of the model if their difference is positive, and if it is negative.
        simulated: whether loops of a full simulation with few increments show it as a rig's do.
        of_scars: whether it is read from scars, not loops.
        free_share: of `whole`, a standard deviation of a difference of free shape as large as the loop.
    """

    name: ClassVar[str]
    words: ClassVar[str]
    unit: ClassVar[str]
    zones: ClassVar[tuple[Zone, ...]]
    sides: ClassVar[tuple[str, str]] = ("above", "below")
    simulated: ClassVar[bool] = False
    of_scars: ClassVar[bool] = False
    free_share: ClassVar[float] = 1.0

    @abstractmethod
    def sites(self, reading: Reading) -> list[Site]:
        """Where a record may give it."""

    @abstractmethod
    def measure(self, reading: Reading, repeat: int, sites: Sites) -> tuple[Array, Array]:
        """Values and standard deviations of their noise (n,) in one repeat, NaN where there are none."""

    @abstractmethod
    def predict(self, course: LoopCourse, sites: Sites) -> Array:
        """Values (n,) of a computed course that holds all of the sites' cycles."""

    def solver_error(self, loops: ModelLoops, sites: Sites) -> SolverSize:  # noqa: ARG002
        """How far solvers differ in it, beyond what is tolerated, on a test whose computed loops are these."""
        return SolverSize(np.zeros(len(sites)))

    def zone(self, sites: Sites, amplitude_um: float) -> NDArray[np.str_]:  # noqa: ARG002
        """Name (n,) of one of `zones` each: the only one unless a subclass says more."""
        (only,) = self.zones
        return np.full(len(sites), only.name)

    def whole(self, setup: Setup, predicted: Array) -> Array:
        """What a difference (n,) is relative to, in the observable's unit, at predicted values (n,)."""
        match self.unit:
            case "N":
                return np.full(predicted.size, setup.plateau_force_N)
            case "um" if not self.of_scars:
                return np.full(predicted.size, setup.amplitude_um)
            case "um":
                return np.full(predicted.size, np.sqrt(np.mean(predicted**2)))
            case "mJ":
                return np.abs(predicted)
            case _:
                return np.ones(predicted.size)

    def free_size(self, setup: Setup, predicted: Array) -> Array:
        """Standard deviation (n,) of a difference of free shape as large as the loop, at predicted values (n,)."""
        return self.free_share * self.whole(setup, predicted)

    @property
    def tolerance(self) -> str:
        """By which entry of a record's `[tolerance]` it is judged.

        A scar that is askew by an angle has its ends off by that share of half its length.
        """
        of_loops = {"N": "force", "um": "displacement", "mJ": "energy"}
        return ({"rad": "displacement"} if self.of_scars else of_loops).get(self.unit, "volume")

    def smoothness(self, sites: Sites, scale: Scale) -> Smoothness:  # noqa: ARG002
        """How differences at several sites hang together: over the cycles alone unless a subclass says more."""
        return Smoothness.of_whole_loops(len(sites))

    def alike(self, reading: Reading, repeat: int, sites: Sites) -> Array:  # noqa: ARG002
        """Correlation (n, n) of the noise in one repeat; none unless a subclass says so."""
        return np.eye(len(sites))

    def common_error(self, reading: Reading, sites: Sites) -> Array:  # noqa: ARG002
        """Unknown (n,) that all repeats share by the way that they were read; none unless a subclass says so."""
        return np.zeros(len(sites))


class OfLoops(Observable):
    """Read from the samples of the logged loops, one by one."""

    @abstractmethod
    def read(self, loop: ReducedLoop, site: Site) -> tuple[float, float]:
        """Value in one loop and its noise, NaN where there is none."""

    def measure(self, reading: Reading, repeat: int, sites: Sites) -> tuple[Array, Array]:
        """Each site in the loop of its cycle."""
        values, noise = np.full((2, len(sites)), np.nan)
        loops = {loop.cycle: loop for loop in reading.loops if loop.repeat == repeat}
        for place, site in enumerate(sites):
            if site.cycle in loops:
                values[place], noise[place] = self.read(loops[site.cycle], site)
        return values, noise


class AlongBranch(OfLoops):
    """Read at several places of each branch of a loop; loops are scored by its height and slope."""

    @abstractmethod
    def along(self, sites: Sites) -> Array:
        """Place (n,) along the branch, in its direction, from which a slope follows."""


class ByLocalLines(AlongBranch):
    """Read by lines through the samples near each place; neighbouring places share samples."""

    @abstractmethod
    def line(self, loop: ReducedLoop, site: Site) -> LocalLine | None:
        """The line at one place, in the branch's direction; None where too few samples are near."""

    def read(self, loop: ReducedLoop, site: Site) -> tuple[float, float]:
        """The line's value there."""
        found = self.line(loop, site)
        return (np.nan, np.nan) if found is None else (site.branch * found.value, found.error)

    def alike(self, reading: Reading, repeat: int, sites: Sites) -> Array:
        """By the samples that lines of one branch share."""
        correlation, each = np.eye(len(sites)), list(sites)
        for loop in reading.loops:
            if loop.repeat != repeat:
                continue
            for sign in (1, -1):
                places = np.flatnonzero((sites.cycle == loop.cycle) & (sites.branch == sign)).tolist()
                lines = [(place, self.line(loop, each[place])) for place in places]
                for (one, first), (other, second) in combinations(lines, 2):
                    if first is not None and second is not None:
                        shared = first.correlation(second, loop.correlation)
                        correlation[one, other] = correlation[other, one] = shared
        return correlation
