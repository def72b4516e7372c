"""All observables there are: those of the library and those that installed packages add."""

from __future__ import annotations

from functools import cache
from importlib.metadata import EntryPoint, entry_points
from inspect import isabstract

from wirewear.diagnosis.observe.amplitude import Amplitude
from wirewear.diagnosis.observe.evolution import Energy, LargestForce, SlipAmplitude
from wirewear.diagnosis.observe.knee_peak import KneePeak
from wirewear.diagnosis.observe.normal_force import NormalForce, NormalForceByDirection
from wirewear.diagnosis.observe.observable import Observable
from wirewear.diagnosis.observe.plateau import Plateau
from wirewear.diagnosis.observe.scars import ScarFigures, ScarSkew
from wirewear.diagnosis.observe.stick import Stick
from wirewear.errors import WirewearError

#: Entry point group in which a package names its subclasses of `Observable`.
ENTRY_POINT_GROUP = "wirewear.observables"

#: From the reversal on along a branch, then the channels; maps of where the gap lies have this order.
LIBRARY: tuple[type[Observable], ...] = (
    Stick,
    KneePeak,
    Plateau,
    Amplitude,
    NormalForce,
    NormalForceByDirection,
    Energy,
    SlipAmplitude,
    LargestForce,
    ScarFigures,
    ScarSkew,
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
    for point in sorted(entry_points(group=ENTRY_POINT_GROUP), key=lambda point: point.name):
        one = _loaded(point)
        if not _names(*found).isdisjoint(_names(one)):
            raise WirewearError(
                f"the entry point {point.value} adds an observable {one.name!r}, but its name or one of its zones is "
                "taken: uninstall that package, or give it other names."
            )
        found.append(one)
    return tuple(found)


def _names(*observables: Observable) -> set[str]:
    return {name for one in observables for name in (one.name, *(zone.name for zone in one.zones))}


def _loaded(point: EntryPoint) -> Observable:
    try:
        kind = point.load()
    except (ImportError, AttributeError) as problem:
        raise WirewearError(
            f"the observable {point.name!r} of an installed package cannot be loaded from {point.value}: {problem}."
        ) from problem
    if not (isinstance(kind, type) and issubclass(kind, Observable)) or isabstract(kind):
        raise WirewearError(
            f"the entry point {point.value} in the group {ENTRY_POINT_GROUP} must be a subclass of "
            "wirewear.diagnosis.observe.observable.Observable that can be made."
        )
    missing = [key for key in ("name", "words", "unit", "zones") if not hasattr(kind, key)]
    if missing:
        raise WirewearError(f"the observable at the entry point {point.value} lacks {', '.join(missing)}.")
    return kind()
