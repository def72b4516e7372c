"""Compilation of the inner loops to machine code."""

import hashlib
import inspect
import re
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np
from numba import njit
from numba.core.dispatcher import Dispatcher

from solvers.kept_code import KeptCode

F = TypeVar("F", bound=Callable[..., object])

_IMPORT = re.compile(r"^from ([\w.]+) import (\([^)]*\)|.*)$", re.MULTILINE)


def compiled(function: F) -> F:
    """The function compiled by numba when it is first called; the code is kept on disk for later processes.

    Kept beside the source, in the user's cache where that cannot be written, or in NUMBA_CACHE_DIR; never used once
    one of the files has changed from which it was compiled. Sorting, `max` of an array and assigning one to another
    cost seconds of compiling each (numba compiles its unicode functions for their messages): loops do not.
    """
    made: Any = njit(error_model="numpy")(function)
    source = Path(inspect.getfile(function))
    if source.is_file() and hasattr(made, "_cache"):
        made._cache = KeptCode(source, function.__qualname__, _stamp(function.__module__))  # noqa: SLF001 - no other way
    return cast(F, made)


def inlined(function: F) -> F:
    """A part of compiled functions, which becomes a part of their code: compiled with each of them, never by itself."""
    return cast(F, njit(error_model="numpy", inline="always")(function))


@cache
def _stamp(module: str) -> str:
    """SHA-256 of a module's file and of those in its package from which it takes what is compiled in."""
    source = Path(str(sys.modules[module].__file__)).read_bytes()
    hashed = hashlib.sha256(source)
    for origin, names in _IMPORT.findall(source.decode()):
        if origin.partition(".")[0] == module.partition(".")[0] and origin in sys.modules:
            taken = (getattr(sys.modules[origin], name, None) for name in re.findall(r"\w+", names))
            if any(_is_compiled_in(item) for item in taken):
                hashed.update(_stamp(origin).encode())
    return hashed.hexdigest()


def _is_compiled_in(item: object) -> bool:
    """Whether a global of this kind becomes part of the functions that use it."""
    if isinstance(item, type):
        return issubclass(item, tuple)
    return isinstance(item, (Dispatcher, tuple, bool, int, float, np.generic, np.ndarray))
