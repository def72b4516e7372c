"""Causes of gaps that no library of effects holds: a file each, with its law, its size, and what it changes of models.

A file's name is the cause's, its class's fields are the parameters that are drawn, and its class says to which sets it
belongs and where it stands in them. Whoever writes one more adds a file.
"""

from collections.abc import Iterator, Mapping
from functools import cache
from importlib import import_module
from inspect import isabstract
from pkgutil import iter_modules
from typing import TYPE_CHECKING

from studies.blind.causes.cause import Cause

if TYPE_CHECKING:
    from studies.blind.generators.other_simulators.causes import OtherCause

#: Sets that a batch may draw from: that of the first batches; a half to develop a diagnosis on, and one that was sealed
#: until its code was frozen; three that were written without a look at any diagnosis.
SETS = ("first", "development", "sealed", "unseen", "withheld", "reserved")


@cache
def all_causes() -> Mapping[str, type[Cause]]:
    """Every cause by its name."""
    return {name: own for name, own in _classes() if issubclass(own, Cause)}


@cache
def other_causes() -> Mapping[str, "type[OtherCause]"]:
    """Every cause of tests by others by its name."""
    from studies.blind.generators.other_simulators.causes import OtherCause

    return {name: own for name, own in _classes() if issubclass(own, OtherCause)}


def _classes() -> Iterator[tuple[str, type]]:
    for module in iter_modules(__path__):
        for own in vars(import_module(f"{__name__}.{module.name}")).values():
            if isinstance(own, type) and hasattr(own, "sets") and not isabstract(own):
                yield module.name, own


def causes_of(name: str) -> tuple[str, ...]:
    """The names of a set's causes, in the order in which they are drawn; "others" is that of tests by others."""
    known = other_causes() if name == "others" else all_causes()
    places = [(dict(own.sets)[name], cause) for cause, own in known.items() if name in dict(own.sets)]
    return tuple(cause for _, cause in sorted(places))


def seam_of(cause: str) -> str | None:
    """Where a cause enters, and a diagnosis should look that calls its gap unexplained; None for what is none."""
    if cause in all_causes():
        return all_causes()[cause].seam
    return other_causes()[cause].seam if cause in other_causes() else None
