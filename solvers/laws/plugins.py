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


Law = TypeVar("Law")


def laws_by_name(group: str, kind: type[Any], noun: str, library: tuple[type[Law], ...]) -> Mapping[str, type[Law]]:
    """Every law of a kind by its name: the classes of `library`, then those that installed packages name in an entry
    point group.

    group, kind, noun: the entry point group, base class and name for messages of such laws, as for `installed`. Raises
    SolverError if a package's entry point holds no such law, or one whose name is taken.
    """
    found: dict[str, Any] = {_name(law): law for law in library}
    for place, law in installed(group, kind, noun, "solvers", ("name",), SolverError):
        if _name(law) in found:
            raise SolverError(
                f"the entry point {place} adds a {noun} named {_name(law)!r}, but there is one of that name "
                "already: uninstall that package, or give its law another name"
            )
        found[_name(law)] = law
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
