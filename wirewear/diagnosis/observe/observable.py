"""Observables: kinds of numbers that a record gives and a model predicts, and how far solvers differ in them.

Each number is read at a site: a cycle, a branch and a level on it, or a scar. A branch is one direction of a loop, +1
towards +x and −1 back. Zones are parts of a loop, or channels, by which gaps are located. Loops computed under a setup
(inputs of the fast model) give loops over the cycles. A new observable is a subclass of `Observable` and an entry in
`reduction.py`, or an installed package's entry point.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Array, BoolArray, IntArray
from wirewear.base.errors import renamed
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.observe.local_lines import LocalLine
from wirewear.diagnosis.observe.measured_loops import ReducedLoop
from wirewear.diagnosis.observe.observed_record import Reading
from wirewear.diagnosis.surrogate.forward import PredictedLoops
from wirewear.diagnosis.surrogate.inputs import SurrogateInputs
from wirewear.diagnosis.surrogate.sensed_loops import MIDDLE, SLIDING, read_along
from wirewear.records.tables import Tolerance

_OF_DIFFERENCES = constants("observe.observable")

#: Share of a solver difference that is not smooth from one level to the next; over which share of the amplitude, of the
#: force or of a scar's half-width it is alike; and how large it is, a share of the force that slopes add.
ROUGH, REACH, SLOPE_SHARE = _OF_DIFFERENCES.each("rough", "reach", "slope_share")

#: Forces are known within what laboratories calibrate to: a displacement read on a shelf may lie anywhere on it.
FORCE_ERROR = Tolerance().force


@dataclass(frozen=True)
class Site:
    """Place where one number is read.

    cycle: after which. branch: +1, −1, or 0 for the whole loop. level: a displacement or force as the observable
    defines it, else 0. body, figure: body and quantity of a scar; "" for loops.
    """

    cycle: int
    branch: int = 0
    level: float = 0.0
    body: str = ""
    figure: str = ""


@dataclass(frozen=True, eq=False)
class Sites:
    """Several sites as arrays (n,)."""

    cycle: IntArray
    branch: IntArray
    level: Array
    body: NDArray[np.str_]
    figure: NDArray[np.str_]

    @classmethod
    def of(cls, sites: Sequence[Site]) -> Sites:
        """Arrays (n,) of the fields of n sites."""
        return cls(
            np.array([site.cycle for site in sites], dtype=np.int64),
            np.array([site.branch for site in sites], dtype=np.int64),
            np.array([site.level for site in sites], dtype=float),
            np.array([site.body for site in sites], dtype=np.str_),
            np.array([site.figure for site in sites], dtype=np.str_),
        )

    def __len__(self) -> int:
        return self.cycle.size

    def __iter__(self) -> Iterator[Site]:
        columns = (self.cycle, self.branch, self.level, self.body, self.figure)
        for cycle, branch, level, body, figure in zip(*(column.tolist() for column in columns), strict=True):
            yield Site(cycle, branch, level, body, figure)

    def repeated(self, times: int, cycles: int) -> Sites:
        """These sites `times` times over, `cycles` being added to the cycles of the second copy, twice that to the
        third's, and so on.
        """
        rows = np.tile(np.arange(len(self)), times)
        return replace(self.taken(rows), cycle=self.cycle[rows] + cycles * np.repeat(np.arange(times), len(self)))

    def taken(self, keep: BoolArray | NDArray[np.intp]) -> Sites:
        """The sites that a mask (n,) or an array of indices chooses."""
        return Sites(self.cycle[keep], self.branch[keep], self.level[keep], self.body[keep], self.figure[keep])

    @cached_property
    def branches(self) -> list[tuple[int, int, NDArray[np.intp]]]:
        """For each branch with sites: its cycle, its sign, and the indices of these sites."""
        pairs = sorted({(int(cycle), int(sign)) for cycle, sign in zip(self.cycle, self.branch, strict=True)})
        return [(*pair, np.flatnonzero((self.cycle == pair[0]) & (self.branch == pair[1]))) for pair in pairs]


def rows_of(predicted: PredictedLoops, sites: Sites) -> NDArray[np.intp]:
    """Row (n,) of the predicted loops that holds each site's cycle."""
    return np.searchsorted(predicted.cycles, sites.cycle)


@dataclass(frozen=True)
class Scale:
    """Displacement amplitude and plateau force of a test, as units for places along its loops."""

    amplitude_um: float
    force_N: float


@dataclass(frozen=True, eq=False)
class Smoothness:
    """Correlation of solver differences between n sites: Gaussian in `along`, 0 between families."""

    along: Array  #: (n,) place along a branch over the length of correlation.
    turned: float  #: Correlation between a place on one branch and its mirror image on the other, 0 to 1.
    rough: Array  #: (n,) share of the standard deviation that is uncorrelated.
    family: NDArray[np.intp]  #: (n,) index of a family; different families are uncorrelated.

    @classmethod
    def of_whole_loops(cls, count: int) -> Smoothness:
        """Smoothness of `count` numbers of whole loops: differences are alike over the cycles only."""
        return cls(np.zeros(count), 1.0, np.full(count, ROUGH), np.zeros(count, dtype=np.intp))


@dataclass(frozen=True, eq=False)
class SolverSize:
    """Standard deviations by which solvers differ on the same test at n sites, in the observable's unit.

    size: (n,) part that is smooth over cycles and along branches (`Observable.smoothness`). own: (n,) part of each
    number alone. common: (n,) part by which one unknown moves all numbers together. None stands for 0. hooked: True if
    the number is affected by hooks, which solvers compute differently.
    """

    size: Array
    own: Array | None = None
    common: Array | None = None
    hooked: bool = True


@dataclass(frozen=True, eq=False)
class ModelLoops:
    """Computed loops, and the inputs of the fast model that gave them."""

    setup: SurrogateInputs
    predicted: PredictedLoops

    @property
    def course(self) -> PredictedLoops:
        """Former name of `predicted`; warns with DeprecationWarning."""
        renamed("ModelLoops.course", "ModelLoops.predicted")
        return self.predicted

    @cached_property
    def scale(self) -> Scale:
        """Displacement amplitude of the setup in µm, and the smallest of the loops' largest forces in N."""
        force = np.abs(self.predicted.tangential_force_N).max(axis=(1, 2))
        return Scale(self.setup.amplitude_um, float(force.min()))

    def rise_N(self, sites: Sites) -> Array:
        """Force (n,) in N, at each site's cycle, that the scar's slopes add between mid-stroke and the end of the
        branch towards +x.
        """
        return self._rise_N[rows_of(self.predicted, sites)]

    def stick_compliance_um_per_N(self, sites: Sites) -> Array:
        """Travel over rise in force (n,) in µm/N, at each site's cycle, of the branch towards +x until it slides."""
        x, q = self.predicted.displacement_um, self.predicted.tangential_force_N
        travel, rise = (values[:, 0, SLIDING] - values[:, 0, 0] for values in (x, q))
        return np.asarray(travel / np.maximum(rise, 1e-9))[rows_of(self.predicted, sites)]

    def travel_um(self, sites: Sites, force_N: float) -> Array:
        """Displacement (n,) in µm that each site's branch covers while the force in its direction of travel rises from
        `level` − `force_N` to `level` + `force_N`; forces beyond its ends count as those.
        """
        return travel_um(self.predicted, sites, sites.level - force_N, sites.level + force_N)

    @cached_property
    def _rise_N(self) -> Array:
        force = self.predicted.tangential_force_N
        return np.asarray(force[:, 0, -1] - force[:, 0, MIDDLE])


def branches_of(predicted: PredictedLoops, sites: Sites) -> tuple[Array, Array, NDArray[np.intp]]:
    """Displacements in µm and forces in N (r, m) of all branches in their direction of travel, and the row (n,) of each
    site's branch; sites of whole loops get the branch towards +x.
    """
    sign, points = np.array([1.0, -1.0])[:, None], predicted.displacement_um.shape[-1]
    x, q = (
        (sign * channel).reshape(-1, points) for channel in (predicted.displacement_um, predicted.tangential_force_N)
    )
    return x, q, 2 * rows_of(predicted, sites) + (sites.branch < 0)


def travel_um(predicted: PredictedLoops, sites: Sites, low_N: Array, high_N: Array) -> Array:
    """Displacement (n,) in µm that each site's branch covers between two forces (n,) in N, given in the direction of
    travel.
    """
    x, q, row = branches_of(predicted, sites)
    rising = np.maximum.accumulate(q, axis=1)
    return read_along(rising, x, row, high_N) - read_along(rising, x, row, low_N)


@dataclass(frozen=True)
class Zone:
    """Part of a loop, or a channel, by which gaps are located.

    Attributes:
        name: short and unique, in answers.
        picture: label of its row in the map of gaps.
        words: where it is, following the observable's words in a sentence; empty if these suffice.
    """

    name: str
    picture: str
    words: str = ""


class Observable(ABC):
    """One kind of number, read at several sites of a record.

    name: short and unique, in answers. words, unit: for readers; numbers of the unit "relative" are logarithms, shown
    as ratios. zones: parts of a loop, or the channel, that it covers. sides: words for a measured value that is larger
    than the model's, and for one that is smaller. simulated: True if a full simulation with few increments shows it as
    a rig does. of_scars: True if it is read from scars and not from loops. of_branches: True if it is read along the
    branches of loops, which laws of one cause shape differently.
    """

    name: ClassVar[str]
    words: ClassVar[str]
    unit: ClassVar[str]
    zones: ClassVar[tuple[Zone, ...]]
    sides: ClassVar[tuple[str, str]] = ("above", "below")
    simulated: ClassVar[bool] = False
    of_scars: ClassVar[bool] = False
    of_branches: ClassVar[bool] = False

    @abstractmethod
    def sites(self, reading: Reading) -> list[Site]:
        """Sites at which a record may give this number; empty if it cannot."""

    @abstractmethod
    def measure(self, reading: Reading, repeat: int, sites: Sites) -> tuple[Array, Array]:
        """Measured values and standard deviations of their noise, each (n,) in the observable's unit, of the repeat
        with the number `repeat`; NaN where there are none.
        """

    @abstractmethod
    def predict(self, predicted: PredictedLoops, sites: Sites) -> Array:
        """Values (n,) from computed loops, which must hold all of the sites' cycles. Loops of several setups come as
        one set of loops with further cycles; scars and profiles (`of_scars`) one setup at a time.
        """

    def solver_error(self, loops: ModelLoops, sites: Sites) -> SolverSize:  # noqa: ARG002
        """Standard deviations of the solvers' differences at the sites, on a test with these loops; by default 0."""
        return SolverSize(np.zeros(len(sites)))

    def zone(self, sites: Sites, amplitude_um: float) -> NDArray[np.str_]:  # noqa: ARG002
        """Name (n,) of each site's zone; by default that of the only one."""
        (only,) = self.zones
        return np.full(len(sites), only.name)

    def whole(self, setup: SurrogateInputs, predicted: Array) -> Array:
        """Size (n,) of the whole quantity, in the observable's unit, to which differences are relative. By unit: the
        plateau force, the amplitude, the root mean square of `predicted` (n,) for scars, its size for energies; else 1.
        """
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

    @property
    def tolerance(self) -> str:
        """Key of the record's table `[tolerance]` by which differences are judged: force, displacement, energy or
        volume. The angle of a skew scar counts as a displacement: the scar's ends are off by that share of half its
        length.
        """
        of_loops = {"N": "force", "um": "displacement", "mJ": "energy"}
        return ({"rad": "displacement"} if self.of_scars else of_loops).get(self.unit, "volume")

    def smoothness(self, sites: Sites, scale: Scale) -> Smoothness:  # noqa: ARG002
        """Correlation of solver differences between sites; by default over the cycles only."""
        return Smoothness.of_whole_loops(len(sites))

    def alike(self, reading: Reading, repeat: int, sites: Sites) -> Array:  # noqa: ARG002
        """Correlation (n, n) of the noise of numbers at n sites in one repeat; by default 0 between different ones."""
        return np.eye(len(sites))

    def common_error(self, reading: Reading, sites: Sites) -> Array:  # noqa: ARG002
        """Standard deviation (n,) of an error that all repeats share, in the observable's unit; by default 0."""
        return np.zeros(len(sites))


class OfLoops(Observable):
    """Observable that is read from each logged loop's samples."""

    @abstractmethod
    def read(self, loop: ReducedLoop, site: Site) -> tuple[float, float]:
        """Value in one loop and the standard deviation of its noise, in the observable's unit; NaN if there is none."""

    def measure(self, reading: Reading, repeat: int, sites: Sites) -> tuple[Array, Array]:
        values, noise = np.full((2, len(sites)), np.nan)
        loops = {loop.cycle: loop for loop in reading.loops if loop.repeat == repeat}
        for place, site in enumerate(sites):
            if site.cycle in loops:
                values[place], noise[place] = self.read(loops[site.cycle], site)
        return values, noise


class AlongBranch(OfLoops):
    """Observable read at several places of each branch; loops are also compared by its mean and slope along a
    branch.
    """

    @abstractmethod
    def along(self, sites: Sites) -> Array:
        """Place (n,) of each site along its branch, in the direction of travel and the level's unit."""


class ByLocalLines(AlongBranch):
    """Observable read by lines through samples near each place; lines at neighbouring places share samples, and so
    noise.
    """

    @abstractmethod
    def line(self, loop: ReducedLoop, site: Site) -> LocalLine | None:
        """Line at one site, in the branch's direction; None if too few samples are near."""

    def read(self, loop: ReducedLoop, site: Site) -> tuple[float, float]:
        found = self.line(loop, site)
        return (np.nan, np.nan) if found is None else (site.branch * found.value, found.error)

    def alike(self, reading: Reading, repeat: int, sites: Sites) -> Array:
        """Correlation (n, n) of the noise in one repeat, by the samples that lines of one branch share."""
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
