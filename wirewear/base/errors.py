"""What can go wrong for a user: errors whose message is one sentence, and warnings that are shown as one."""

import sys
import warnings
from collections.abc import Callable
from typing import Any, TypeVar

from geometry.errors import WirewearError

__all__ = ["WirewearError"]

Error = TypeVar("Error", bound=WirewearError)


class KeptNothingWarning(UserWarning):
    """A result cannot be cached; the result itself is correct."""


class AssumedWarning(UserWarning):
    """An unstated value was assumed from elsewhere."""


class StudyError(WirewearError):
    """A study cannot be read or asks for something impossible."""


class ResultError(WirewearError):
    """A result cannot be read or does not hold what was asked of it."""


class NoColumnError(ResultError, KeyError):
    """A table has no column of this name; also a KeyError, as for any mapping."""

    __str__ = Exception.__str__


class RecordError(WirewearError):
    """An experiment record cannot be read, written, imported or compared."""


class RunError(WirewearError):
    """A run cannot be started, resumed or finished."""


class SensorError(WirewearError):
    """A sensor's parameters are invalid, it cannot read these signals, or its readings cannot be inverted."""


class EngineError(WirewearError):
    """An engine cannot compute its tasks."""


class LostTaskError(EngineError):
    """The process of a task was lost each time the task was started."""


def ended(kind: type[Error]) -> Callable[[str], Error]:
    """A function that makes an error of a kind from a sentence without its full stop."""
    return lambda sentence: kind(f"{sentence}.")


def show_warnings_plainly() -> None:
    """Print this program's warnings as one sentence each; libraries' warnings appear only if Python ran with -W."""
    otherwise = warnings.showwarning

    def shown(message: Warning | str, category: type[Warning], *where: Any, **more: Any) -> None:
        if issubclass(category, KeptNothingWarning | AssumedWarning):
            sys.stderr.write(f"wirewear: {message}\n")
        elif sys.warnoptions:
            otherwise(message, category, *where, **more)

    warnings.showwarning = shown


def renamed(former: str, present: str) -> None:
    """Warn of a deprecated name: whoever uses the public name `former` of an earlier version, which goes on working
    (docs/promises.md), is given the `present` one.
    """
    warnings.warn(f"{former} is now {present}", DeprecationWarning, stacklevel=3)
