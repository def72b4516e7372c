"""Causes of gaps that no library of effects holds: a file each, with its law, its size, and what it changes of models.

A file's name is the cause's, its class's fields are the parameters that are drawn, and its class says to which sets it
belongs and where it stands in them. Whoever writes one more adds a file.
"""

from collections.abc import Mapping
from functools import cache
from importlib import import_module
from inspect import isabstract
from pkgutil import iter_modules

from studies.blind.causes.cause import Cause

#: Sets that a batch may draw from: that of the first batches; a half to develop a diagnosis on, and one that was sealed
#: until its code was frozen; three that were written without a look at any diagnosis.
SETS = ("first", "development", "sealed", "unseen", "withheld", "reserved")


@cache
def all_causes() -> Mapping[str, type[Cause]]:
    """Every cause by its name."""
    found = {}
    for module in iter_modules(__path__):
        for one in vars(import_module(f"{__name__}.{module.name}")).values():
            if isinstance(one, type) and issubclass(one, Cause) and not isabstract(one):
                found[module.name] = one
    return found


def causes_of(name: str) -> tuple[str, ...]:
    """The names of a set's causes, in the order in which they are drawn."""
    places = [(dict(known.sets)[name], cause) for cause, known in all_causes().items() if name in dict(known.sets)]
    return tuple(cause for _, cause in sorted(places))


def seam_of(cause: str) -> str | None:
    """Where a cause enters, and a diagnosis should look that calls its gap unexplained; None for what is none."""
    from studies.blind.generators.others.causes import SEAMS

    return all_causes()[cause].seam if cause in all_causes() else SEAMS.get(cause)
