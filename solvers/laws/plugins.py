"""Classes that installed packages add through entry points, and laws made from their name and checked parameters."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import MISSING, Field, fields
from importlib.metadata import entry_points
from inspect import isabstract
from typing import Any, TypeVar

from solvers.errors import SolverError


def installed(
    group: str, base: type[Any], noun: str, home: str, needed: tuple[str, ...], problem: Callable[[str], Exception]
) -> Iterator[tuple[str, Any]]:
    """Load every entry point of a group, in the order of their names; yields its place ("package.module:Name") and its
    class.

    group: the entry points' group. base: class of which each must be a subclass; it is abstract, which mypy forbids of
    a type[Kind]. noun: what such a class is to the user ("effect"), for messages. home: package from which users import
    the base class, for messages. needed: attributes that each class must have. problem: makes the error to raise from
    one sentence without its full stop; raised if an entry point cannot be loaded, or holds no such class, or one that
    lacks an attribute.
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


Kind = TypeVar("Kind")
Law = TypeVar("Law")


def by_name(
    library: tuple[type[Kind], ...],
    group: str,
    base: type[Any],
    noun: str,
    home: str = "wirewear",
    needed: tuple[str, ...] = ("name",),
    problem: Callable[[str], Exception] = SolverError,
    *,
    key: str = "name",
) -> dict[str, type[Kind]]:
    """Every class of a library, then those that installed packages add, by the attribute `key`. The other arguments are
    those of `installed`, whose errors are raised, also if a name is taken.
    """
    found = {str(getattr(kind, key)): kind for kind in library}
    for place, kind in installed(group, base, noun, home, needed, problem):
        name = str(getattr(kind, key))
        if name in found:
            raise problem(
                f"the entry point {place} adds one more {noun} of the {key} {name!r}, but there is one of that {key} "
                f"already: uninstall that package, or give it another {key}"
            )
        found[name] = kind
    return found


def law_called(name: str, parameters: Mapping[str, float], laws: Mapping[str, type[Law]], noun: str) -> Law:
    """Make the law of a name with its parameters; those with defaults may be left out.

    laws: all laws of the kind by name. noun: what such a law is to the user ("friction law"). Raises SolverError if no
    law has this name, or if parameters are missing, unknown or out of range.
    """
    if name not in laws:
        raise SolverError(f"there is no {noun} {name!r}; the laws are {', '.join(map(repr, laws))}")
    known: tuple[Field[Any], ...] = fields(laws[name])  # type: ignore[arg-type]
    needed = {parameter.name for parameter in known if parameter.default is MISSING}
    if not needed <= set(parameters) <= {parameter.name for parameter in known}:
        given = f"but is given {', '.join(parameters)}" if parameters else "but is given none"
        wanted = ", ".join(parameter.name for parameter in known)
        raise SolverError(f"the {noun} {name!r} {f'takes {wanted}' if wanted else 'takes no parameters'}, {given}")
    return laws[name](**parameters)


def require_positive(law: object, *names: str, not_negative: tuple[str, ...] = ()) -> None:
    """Raise SolverError unless the named parameters of a law are positive, and those of `not_negative` at least 0."""
    for name in (*names, *not_negative):
        value = getattr(law, name)
        if not (value >= 0.0 if name in not_negative else value > 0.0):
            must = "must not be negative" if name in not_negative else "must be positive"
            raise SolverError(f"{name} of the law {_name(law)!r} {must}, but is {value}")


def _name(law: object) -> str:
    return str(getattr(law, "name"))  # noqa: B009 - every kind of law has one
