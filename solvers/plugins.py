"""Classes that installed packages add by entry points: friction laws here; effects, observables and readers above."""

from collections.abc import Callable, Iterator
from importlib.metadata import entry_points
from inspect import isabstract
from typing import Any


def installed(
    group: str, base: type[Any], noun: str, home: str, needed: tuple[str, ...], problem: Callable[[str], Exception]
) -> Iterator[tuple[str, Any]]:
    """Place ("package.module:Name") and class of each entry point of a group, by the entry points' names.
    Raises what ``problem`` makes if an entry point cannot be loaded, or holds no such class, or one that lacks an
    attribute.

    group: the entry points' group.  needed: attributes that each class must have.
    base: what each class must be a subclass of; it is abstract, which mypy forbids of a type[Kind].
    noun: what such a class is to the user ("effect"), for messages.
    home: package from which users import the base class, for messages.
    problem: makes the error that is raised from one clear sentence without its full stop.
    """
    for point in sorted(entry_points(group=group), key=lambda point: point.name):
        try:
            kind = point.load()
        except Exception as failure:
            # Code of others may raise anything.
            reason = f"{type(failure).__name__}: {failure}".splitlines()[0]
            raise problem(
                f"the {noun} {point.name!r} of an installed package cannot be loaded from {point.value} ({reason}): "
                "mend or uninstall that package"
            ) from failure
        if not (isinstance(kind, type) and issubclass(kind, base)) or isabstract(kind):
            raise problem(
                f"the entry point {point.value} in the group {group} must be a subclass of "
                f"{home}.{base.__name__} that can be made"
            )
        missing = [name for name in needed if not hasattr(kind, name)]
        if missing:
            raise problem(f"the {noun} at the entry point {point.value} lacks {', '.join(missing)}")
        yield point.value, kind
