"""What can go wrong for a user of wirewear; every message is one sentence: what, where, and what would be right."""

import sys
import warnings
from typing import Any

from geometry.errors import WirewearError

__all__ = ["WirewearError"]


class KeptNothingWarning(UserWarning):
    """What is computed cannot be kept for the next time; nothing is wrong with it."""


class StudyError(WirewearError):
    """A study cannot be read or asks for something that makes no sense."""


class ResultError(WirewearError):
    """A result cannot be read or does not hold what was asked of it."""


class NoColumnError(ResultError, KeyError):
    """A table has no column of that name; a KeyError as well, as of any mapping."""

    __str__ = Exception.__str__


class RecordError(WirewearError):
    """An experiment record cannot be read, written, imported or compared."""


class RunError(WirewearError):
    """A run cannot be started, resumed or finished."""


class SensorError(WirewearError):
    """A sensor cannot be as described, cannot read these signals, or its reading cannot be undone."""


class EngineError(WirewearError):
    """Tasks cannot be done where they were to be done."""


class LostTaskError(EngineError):
    """A task's process was lost each time that it was begun."""


def tell_plainly() -> None:
    """Show our own warnings as one sentence; libraries' ones are for whoever asks Python for warnings, with -W."""
    otherwise = warnings.showwarning

    def shown(message: Warning | str, category: type[Warning], *where: Any, **more: Any) -> None:
        if issubclass(category, KeptNothingWarning):
            sys.stderr.write(f"wirewear: {message}\n")
        elif sys.warnoptions:
            otherwise(message, category, *where, **more)

    warnings.showwarning = shown
