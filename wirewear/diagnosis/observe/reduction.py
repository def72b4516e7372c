"""All observables there are, of the library and of installed packages, and the numbers that a record gives of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Array, BoolArray, IntArray
from solvers.laws.plugins import installed
from wirewear.base.errors import WirewearError
from wirewear.diagnosis.observe import channels
from wirewear.diagnosis.observe.along_branches import KneePeak, PlateauForce, ShelfTravel, Stick
from wirewear.diagnosis.observe.channels import Energy, LargestForce, SlipAmplitude
from wirewear.diagnosis.observe.measured_loops import ReducedLoop, common_motion
from wirewear.diagnosis.observe.observable import AlongBranch, Observable, Site, Sites
from wirewear.diagnosis.observe.observed_record import Reading, read
from wirewear.diagnosis.observe.scars import ProfileDepths, ScarFigures, ScarSkew
from wirewear.diagnosis.surrogate.forward import OF_LOOPS, PredictedLoops, simulated
from wirewear.diagnosis.surrogate.inputs import SurrogateInputs
from wirewear.diagnosis.surrogate.loop_states import SINE, FastMotion
from wirewear.diagnosis.surrogate.wear_states import WearStates
from wirewear.records import AnyRecord

#: So many setups are computed together: their arrays are large enough to be worth a call, and stay in a cache.
_TOGETHER = 24


#: Entry point group in which a package names its subclasses of `Observable`.
ENTRY_POINT_GROUP = "wirewear.observables"

#: From the reversal on along a branch, then the channels; maps of where the gap lies have this order.
LIBRARY: tuple[type[Observable], ...] = (
    Stick,
    ShelfTravel,
    KneePeak,
    PlateauForce,
    channels.Amplitude,
    channels.NormalForce,
    channels.NormalForceByDirection,
    channels.NormalForceAtEnds,
    channels.NormalForceBySides,
    Energy,
    SlipAmplitude,
    LargestForce,
    ScarFigures,
    ScarSkew,
    ProfileDepths,
)

#: Of a number's noise variance, what no other number shares: far below what any is known by, it keeps sums of shared
#: noise regular.
OWN_NOISE = 1e-6


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
        """The layout of observables, each with its sites one by one."""
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

    def observed(self, course: PredictedLoops) -> Array:
        """The numbers (n,) of a computed course, which must hold all of `cycles`."""
        return np.asarray(self._observed([course])[0])

    def computed(self, states: WearStates, *setups: SurrogateInputs) -> Array:
        """The numbers (k, n) under several setups."""
        parts = [setups[start : start + _TOGETHER] for start in range(0, len(setups), _TOGETHER)]
        found = [self._observed(simulated(states, part, self.cycles)) for part in parts]
        return np.concatenate([np.zeros((0, len(self))), *found])

    def _observed(self, courses: Sequence[PredictedLoops]) -> Array:
        """The numbers (k, n) of courses: those of loops are read as if of one course with later and later cycles."""
        count, whole = len(courses), int(courses[0].cycles[-1]) + 1
        each: dict[str, Any] = {
            name: np.concatenate([getattr(course, name) for course in courses]) for name in OF_LOOPS
        }
        cycles = np.concatenate([course.cycles + whole * place for place, course in enumerate(courses)])
        loops = replace(courses[0], cycles=cycles, **each)
        found = [np.zeros((count, 0))]
        for part in self:
            if part.observable.of_scars:
                found.append(np.stack([part.observable.predict(course, part.sites) for course in courses]))
            else:
                sites = part.sites.repeated(count, whole) if count > 1 else part.sites
                found.append(part.observable.predict(loops, sites).reshape(count, -1))
        return np.concatenate(found, axis=1)


@dataclass(frozen=True, eq=False)
class Observations:
    """Observables of every repeat: values and standard deviations of their noise (r, n); NaN where missing.

    `alike` (r, n, n) is the correlation of each repeat's noise, where it is known of which samples a number comes.
    `common` (n, k) are unknowns that move all repeats alike, one for each observable that has one. `loops` are those
    used, for pictures; `notes` say what was left out. `stated_scatter` is what the owner knows of the scatter between
    tests, by the model's names; `tolerance` is what counts as equal, relative. `motion` is that of the drive.
    """

    layout: Layout
    repeats: tuple[int, ...]
    values: Array
    noise: Array
    common: Array
    loops: tuple[ReducedLoop, ...]
    notes: tuple[str, ...]
    stated_scatter: Mapping[str, float] = field(default_factory=dict)
    tolerance: Mapping[str, float] = field(default_factory=dict)
    motion: FastMotion = SINE
    alike: Array | None = None

    def noise_covariance(self, repeat: int, seen: NDArray[np.intp], factors: Array | float = 1.0) -> Array:
        """Covariance (k, k) of the noise of one repeat's numbers (k,), by factors (n,) on its variances.

        Numbers that lie between the same few samples share their noise, but none follows from others exactly.
        """
        deviations = (np.sqrt(factors) * self.noise[repeat])[seen]
        if self.alike is None:
            return np.diag(deviations**2)
        shared = np.outer(deviations, deviations) * self.alike[repeat][np.ix_(seen, seen)]
        return np.asarray(shared + np.diag(OWN_NOISE * deviations**2))


def reduce(record: AnyRecord, observables: Sequence[Observable] | None = None) -> Observations:
    """All that is observed of a record, by all observables there are unless some are named.
    Raises RecordError if no loop of the record slides as a whole, or none can be read.
    """
    reading = read(record)
    known = all_observables() if observables is None else observables
    layout = Layout.of((one, Sites.of(one.sites(reading))) for one in known)
    values, noise = np.full((2, len(reading.repeats), len(layout)), np.nan)
    alike = np.zeros((len(reading.repeats), len(layout), len(layout)))
    for row, repeat in enumerate(reading.repeats):
        for part in layout:
            values[row, part.rows], noise[row, part.rows] = part.observable.measure(reading, repeat, part.sites)
            alike[row, part.rows, part.rows] = part.observable.alike(reading, repeat, part.sites)
    common = _common(reading, layout)
    missing = ~(np.isfinite(values) & np.isfinite(noise) & (noise > 0.0))
    values[missing], noise[missing] = np.nan, np.nan
    seen = ~missing.all(axis=0)
    return Observations(
        layout.taken(seen),
        reading.repeats,
        values[:, seen],
        noise[:, seen],
        common[seen],
        reading.loops,
        reading.notes,
        _stated_scatter(record),
        record.tables.tolerance.model_dump(),
        common_motion(reading.loops),
        alike[:, seen][:, :, seen],
    )


def _common(reading: Reading, layout: Layout) -> Array:
    """What moves all repeats alike (n, k), a column for each observable that has such an unknown."""
    columns = np.zeros((len(layout), len(layout.parts)))
    for place, part in enumerate(layout):
        columns[part.rows, place] = part.observable.common_error(reading, part.sites)
    return columns[:, np.abs(columns).max(axis=0, initial=0.0) > 0.0]


def _stated_scatter(record: AnyRecord) -> dict[str, float]:
    stated, load = record.tables.scatter, record.tables.conditions.normal_load_N
    known = {
        "friction": stated.friction,
        "load": stated.normal_load,
        "wear": stated.wear,
        "displacement_offset_um": stated.displacement_zero_um,
        "force_offset": None if stated.force_zero_N is None else stated.force_zero_N / load,
    }
    return {name: value for name, value in known.items() if value is not None}


def all_observables() -> tuple[Observable, ...]:
    """One of each.
    Raises WirewearError if a package's entry point holds no observable, or one whose name or zone is taken.
    """
    return _all_observables()


def row_labels() -> dict[str, str]:
    """Labels of all zones, in the order of a map's rows."""
    return {zone.name: zone.picture for observable in all_observables() for zone in observable.zones}


@cache
def _all_observables() -> tuple[Observable, ...]:
    found = [kind() for kind in LIBRARY]
    home, needed = "wirewear.diagnosis.observe", ("name", "words", "unit", "zones")
    for place, kind in installed(ENTRY_POINT_GROUP, Observable, "observable", home, needed, _problem):
        one = kind()
        if not _names(*found).isdisjoint(_names(one)):
            raise WirewearError(
                f"the entry point {place} adds an observable {one.name!r}, but its name or one of its zones is "
                "taken: uninstall that package, or give it other names."
            )
        found.append(one)
    return tuple(found)


def _names(*observables: Observable) -> set[str]:
    return {name for one in observables for name in (one.name, *(zone.name for zone in one.zones))}


def _problem(sentence: str) -> WirewearError:
    return WirewearError(f"{sentence}.")
