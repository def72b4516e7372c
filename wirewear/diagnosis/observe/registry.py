"""All observables there are: those of the library and those that installed packages add."""

from __future__ import annotations

from functools import cache

from solvers.plugins import installed
from wirewear.base.errors import WirewearError
from wirewear.diagnosis.observe.amplitude import Amplitude
from wirewear.diagnosis.observe.evolution import Energy, LargestForce, SlipAmplitude
from wirewear.diagnosis.observe.knee_peak import KneePeak
from wirewear.diagnosis.observe.normal_along import (
    NormalForce,
    NormalForceAtEnds,
    NormalForceByDirection,
    NormalForceBySides,
)
from wirewear.diagnosis.observe.observable import Observable
from wirewear.diagnosis.observe.plateau import PlateauForce
from wirewear.diagnosis.observe.profiles import ProfileDepths
from wirewear.diagnosis.observe.scars import ScarFigures, ScarSkew
from wirewear.diagnosis.observe.shelf import ShelfTravel
from wirewear.diagnosis.observe.stick import Stick

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
