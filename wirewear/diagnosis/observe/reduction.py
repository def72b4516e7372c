"""All observables there are, of the library and of installed packages, and what a record gives of them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Array
from solvers.plugins import installed
from wirewear.base.errors import WirewearError
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.model.motion import SINE, FastMotion
from wirewear.diagnosis.observe.channels import (
    Amplitude,
    NormalForce,
    NormalForceAtEnds,
    NormalForceByDirection,
    NormalForceBySides,
)
from wirewear.diagnosis.observe.evolution import Energy, LargestForce, SlipAmplitude
from wirewear.diagnosis.observe.layout import Layout
from wirewear.diagnosis.observe.measured_loops import ReducedLoop, common_motion
from wirewear.diagnosis.observe.observable import Observable
from wirewear.diagnosis.observe.plateau import KneePeak, PlateauForce
from wirewear.diagnosis.observe.profiles import ProfileDepths
from wirewear.diagnosis.observe.reading import Reading, read
from wirewear.diagnosis.observe.scars import ScarFigures, ScarSkew
from wirewear.diagnosis.observe.sites import Sites
from wirewear.diagnosis.observe.stick import ShelfTravel, Stick
from wirewear.records import AnyRecord

#: Variance by which repeats of an observable differ over that of the noise they are read with, where it is not one.
READ_WITHIN: Mapping[str, float] = constants("observe.read_within").all()

#: Entry point group in which a package names its subclasses of `Observable`.
ENTRY_POINT_GROUP = "wirewear.observables"

#: From the reversal on along a branch, then the channels; maps of where the gap lies have this order.
LIBRARY: tuple[type[Observable], ...] = (
    Stick,
    ShelfTravel,
    KneePeak,
    PlateauForce,
    Amplitude,
    NormalForce,
    NormalForceByDirection,
    NormalForceAtEnds,
    NormalForceBySides,
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
class Observations:
    """Observables of every repeat: values and standard deviations of their noise (r, n); NaN where missing.

    `alike` (r, n, n) is the correlation of each repeat's noise, where it is known of which samples a number comes.
    `common` (n, k) are unknowns that move all repeats alike, one for each observable that has one. `loops` are those
    used, for pictures; `notes` say what was left out. `stated_scatter` is what the owner knows of the scatter between
    tests, by the model's names; `tolerance` is what counts as equal, relative. `motion` is that of the drive,
    `centre_error_um` how well the middle of a loop is known.
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
    centre_error_um: float = 0.0
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

    Raises:
        RecordError: no loop of the record slides as a whole, or none can be read.
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
            noise[row, part.rows] *= READ_WITHIN.get(part.observable.name, 1.0) ** 0.5
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
        float(np.median([loop.centre_error_um for loop in reading.loops])) if reading.loops else 0.0,
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

    Raises:
        WirewearError: a package's entry point holds no observable, or one whose name or zone is taken.
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
