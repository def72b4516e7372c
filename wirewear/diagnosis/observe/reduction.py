"""List of all observables, of this program and of installed packages, and the numbers that a record gives for them.

A layout lists the numbers (n,) of a record, grouped by observable; a part is the group of one observable at its sites
(cycle, branch, level). A feature is a mean or slope of several numbers; a setup holds inputs of the fast model.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Array, BoolArray, IntArray
from solvers.laws.plugins import installed
from wirewear.base.errors import WirewearError, ended
from wirewear.diagnosis.observe import channels
from wirewear.diagnosis.observe.along_branches import KneePeak, PlateauForce, ShelfTravel, Stick
from wirewear.diagnosis.observe.channels import Energy, LargestForce, SlipAmplitude
from wirewear.diagnosis.observe.measured_loops import ReducedLoop, common_motion
from wirewear.diagnosis.observe.observable import AlongBranch, Observable, Sites
from wirewear.diagnosis.observe.observed_record import read
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


@dataclass(frozen=True, eq=False)
class Features:
    """Means and slopes of groups of n observed numbers, by which held-out loops are compared.

    members: (f, n) marks of the group of each of f features. slope: (f,) True for a least-squares slope, False for a
    mean. place: (n,) place of each number along its branch. cycle: (f,).
    """

    members: BoolArray
    slope: BoolArray
    place: Array
    cycle: IntArray

    @classmethod
    def of(cls, layout: Layout, used: BoolArray) -> Features:
        """Features of the numbers marked in `used` (n,): mean and slope of each branch, or each number of other
        observables.
        """
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
        """Features (f,) of values (n,), of which only those marked in `seen` (n,) are used; NaN if there are too
        few.
        """
        return self._weights(seen) @ np.where(seen, values, 0.0)

    def variances(self, covariance: Array, seen: BoolArray) -> Array:
        """Variances (f,) of the features of numbers with this covariance (n, n); NaN where too few are marked in `seen`
        (n,).
        """
        weights = self._weights(seen)
        return np.asarray(np.einsum("fi,ij,fj->f", weights, covariance, weights, optimize=True))

    def _weights(self, seen: BoolArray) -> Array:
        """Weights (f, n) of the numbers in each mean or least-squares slope."""
        weights = (self.members & seen).astype(float)
        count = weights.sum(axis=1, keepdims=True)
        with np.errstate(invalid="ignore", divide="ignore"):
            mean = weights / count
            away = weights * (self.place - (mean @ self.place)[:, None])
            tilt = away / (away**2).sum(axis=1, keepdims=True)
        return np.where(self.slope[:, None], np.where(count > 1, tilt, np.nan), mean)


@dataclass(frozen=True, eq=False)
class Part:
    """One observable at several sites: the numbers of a layout from index `start` on."""

    observable: Observable
    sites: Sites
    start: int

    @property
    def rows(self) -> slice:
        return slice(self.start, self.start + len(self.sites))


@dataclass(frozen=True, eq=False)
class Layout:
    """Numbers (n,) of a record, grouped by observable."""

    parts: tuple[Part, ...]

    @classmethod
    def of(cls, observables: Iterable[tuple[Observable, Sites]]) -> Layout:
        """Layout of observables with their sites, in this order; those without sites are left out."""
        parts: list[Part] = []
        start = 0
        for observable, sites in observables:
            if len(sites):
                parts.append(Part(observable, sites, start))
                start += len(sites)
        return cls(tuple(parts))

    def __len__(self) -> int:
        return sum(len(part.sites) for part in self.parts)

    def __iter__(self) -> Iterator[Part]:
        return iter(self.parts)

    @cached_property
    def cycle(self) -> IntArray:
        """Cycle (n,) after which each number is read."""
        return np.concatenate([np.zeros(0, dtype=np.int64), *(part.sites.cycle for part in self)])

    @cached_property
    def cycles(self) -> Array:
        return np.unique(self.cycle).astype(float)

    def of_kind(self, *kinds: type) -> BoolArray:
        """Marks (n,) of the numbers whose observables are of these classes."""
        return self.marked(part for part in self if isinstance(part.observable, kinds))

    def marked(self, parts: Iterable[Part]) -> BoolArray:
        """Marks (n,) of the numbers in the given parts."""
        marked = np.zeros(len(self), dtype=bool)
        for part in parts:
            marked[part.rows] = True
        return marked

    def of_body(self, name: str) -> BoolArray:
        """Marks (n,) of the numbers read from the scar of the body `name`."""
        return np.concatenate([np.zeros(0, dtype=bool), *(part.sites.body == name for part in self)])

    def taken(self, keep: BoolArray) -> Layout:
        """Layout of the numbers marked in `keep` (n,), in their order."""
        return Layout.of((part.observable, part.sites.taken(keep[part.rows])) for part in self)

    def zones(self, amplitude_um: float) -> NDArray[np.str_]:
        """Name (n,) of each number's zone; amplitude_um: displacement amplitude, the unit of places in a loop."""
        return np.concatenate([part.observable.zone(part.sites, amplitude_um) for part in self])

    def observed(self, predicted: PredictedLoops) -> Array:
        """Numbers (n,) of computed loops, which must hold all of `cycles`."""
        return np.asarray(self._observed([predicted])[0])

    def computed(self, states: WearStates, *setups: SurrogateInputs) -> Array:
        """Numbers (k, n) that the fast model predicts under k setups."""
        parts = [setups[start : start + _TOGETHER] for start in range(0, len(setups), _TOGETHER)]
        found = [self._observed(simulated(states, part, self.cycles)) for part in parts]
        return np.concatenate([np.zeros((0, len(self))), *found])

    def _observed(self, predictions: Sequence[PredictedLoops]) -> Array:
        """Numbers (k, n) of k predictions; their loops are joined to one with shifted cycles to be read at once."""
        count, whole = len(predictions), int(predictions[0].cycles[-1]) + 1
        each: dict[str, Any] = {
            name: np.concatenate([getattr(predicted, name) for predicted in predictions]) for name in OF_LOOPS
        }
        cycles = np.concatenate([predicted.cycles + whole * place for place, predicted in enumerate(predictions)])
        loops = replace(predictions[0], cycles=cycles, **each)
        found = [np.zeros((count, 0))]
        for part in self:
            if part.observable.of_scars:
                found.append(np.stack([part.observable.predict(predicted, part.sites) for predicted in predictions]))
            else:
                sites = part.sites.repeated(count, whole) if count > 1 else part.sites
                found.append(part.observable.predict(loops, sites).reshape(count, -1))
        return np.concatenate(found, axis=1)


@dataclass(frozen=True, eq=False)
class Observations:
    """Observed numbers of r repeats.

    values, noise: (r, n) and standard deviations of their noise; NaN where missing. common: (n, k) standard deviations
    of k errors that all repeats share. loops: those used. notes: sentences on what was left out. stated_scatter: the
    owner's scatter between tests, by the fast model's names. tolerance: relative differences that count as equal, by
    name. motion: displacement of the drive over time. alike: (r, n, n) correlation of each repeat's noise; None if
    independent.
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
        """Covariance (k, k) of the noise of one repeat's numbers with indices `seen` (k,). repeat: index from 0.
        factors: on the noise variances, (n,) or one number. A millionth of each variance is added, uncorrelated.
        """
        deviations = (np.sqrt(factors) * self.noise[repeat])[seen]
        if self.alike is None:
            return np.diag(deviations**2)
        shared = np.outer(deviations, deviations) * self.alike[repeat][np.ix_(seen, seen)]
        # A share that no other number has, far below what any is known by, keeps sums of shared noise regular.
        return np.asarray(shared + np.diag(1e-6 * deviations**2))


def reduce(record: AnyRecord, observables: Sequence[Observable] | None = None) -> Observations:
    """Read all observables, or the given ones, from a record; numbers that no repeat gives are left out. Raises
    RecordError if no loop can be read and the record has no profiles in place of loops.
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
    common = np.zeros((len(layout), len(layout.parts)))
    for column, part in enumerate(layout):
        common[part.rows, column] = part.observable.common_error(reading, part.sites)
    common = common[:, np.abs(common).max(axis=0, initial=0.0) > 0.0]
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
    """One instance of each observable, of this program and of installed packages. Raises WirewearError if a package's
    entry point is not an observable, or its name or zone is already used.
    """
    return _all_observables()


def row_labels() -> dict[str, str]:
    """Labels by zone name for the rows of a picture of gaps, from top to bottom."""
    return {zone.name: zone.picture for observable in all_observables() for zone in observable.zones}


@cache
def _all_observables() -> tuple[Observable, ...]:
    found = [kind() for kind in LIBRARY]
    home, needed = "wirewear.diagnosis.observe", ("name", "words", "unit", "zones")
    for place, kind in installed(ENTRY_POINT_GROUP, Observable, "observable", home, needed, ended(WirewearError)):
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
