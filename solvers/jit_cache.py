"""Machine code of compiled functions, kept on disk for later processes, and the folder for whatever is kept there.

Code lies beside the source where its owner runs the program; others read it there, since they trust the source, too.
Otherwise it lies in the user's own cache folder, apart for each copy of the program. A damaged file is replaced, and
without a folder nothing is kept; numba's own cache fails in both cases.
"""

import hashlib
import inspect
import os
import pickle
import platform
import re
import stat
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
import numpy as np
from numba import njit
from numba.core.caching import NullCache
from numba.core.compiler import CompileResult
from numba.core.dispatcher import Dispatcher
from numba.core.event import Event, Listener, register
from numba.core.runtime.nrt import rtsys
from numba.core.serialize import dumps

F = TypeVar("F", bound=Callable[..., object])

_IMPORT = re.compile(r"^from ([\w.]+) import (\([^)]*\)|.*)$", re.MULTILINE)

_CHECK_BYTES = hashlib.sha256().digest_size


def compiled(function: F) -> F:
    """The function, compiled by numba when it is first called; the code is kept on disk for later processes.

    It is kept beside the source, in the user's cache folder if that cannot be written, or in NUMBA_CACHE_DIR, and not
    used once a file from which it was compiled has changed. In such functions write loops in place of sorting, `max` of
    an array and assigning arrays to arrays, which cost seconds of compilation each.
    """
    made: Any = njit(error_model="numpy")(function)
    source = Path(inspect.getfile(function))
    if source.is_file() and hasattr(made, "_cache"):
        made._cache = KeptCode(source, function.__qualname__, _stamp(function.__module__))  # noqa: SLF001 - no other way
    return cast(F, made)


def inlined(function: F) -> F:
    """The function as part of compiled functions: its code is compiled into each of them, never by itself."""
    return cast(F, njit(error_model="numpy", inline="always")(function))


@cache
def _stamp(module: str) -> str:
    """SHA-256 of a module's file and of those files in its package from which it imports what is compiled in."""
    source = Path(str(sys.modules[module].__file__)).read_bytes()
    hashed = hashlib.sha256(source)
    for origin, names in _IMPORT.findall(source.decode()):
        if origin.partition(".")[0] == module.partition(".")[0] and origin in sys.modules:
            taken = (getattr(sys.modules[origin], name, None) for name in re.findall(r"\w+", names))
            if any(_is_compiled_in(item) for item in taken):
                hashed.update(_stamp(origin).encode())
    return hashed.hexdigest()


def _is_compiled_in(item: object) -> bool:
    """True if a global object of this kind becomes part of the functions that use it."""
    if isinstance(item, type):
        return issubclass(item, tuple)
    return isinstance(item, (Dispatcher, tuple, bool, int, float, np.generic, np.ndarray))


class _CompilingClock(Listener):
    """Sums the CPU time of compilations in seconds; one within another is counted once."""

    def __init__(self) -> None:
        self.spent_s, self._since_s, self._within = 0.0, 0.0, 0

    def on_start(self, event: Event) -> None:  # noqa: ARG002
        """Start the clock, unless a compilation is already running."""
        if not self._within:
            self._since_s = time.process_time()
        self._within += 1

    def on_end(self, event: Event) -> None:  # noqa: ARG002
        """Add the time of the compilation if it is the outermost one."""
        self._within -= 1
        if not self._within:
            self.spent_s += time.process_time() - self._since_s


_CLOCK = _CompilingClock()
register("numba:compile", _CLOCK)


def working_cpu_s() -> float:
    """CPU time of this process so far, without compiling, which later processes need not repeat."""
    return time.process_time() - _CLOCK.spent_s


def chosen_cache() -> Path:
    """The folder for kept files: that of the environment variable WIREWEAR_CACHE, or one in the user's cache folder.
    Raises RuntimeError without a home folder.
    """
    chosen = os.environ.get("WIREWEAR_CACHE")
    return Path(chosen) if chosen else _users_cache() / "wirewear"


def private_folder(chosen: Path) -> Path:
    """The folder `chosen`, created if missing, if only this user can write to it; else a subfolder for this user alone.

    Raises OSError if that cannot be read and written.
    """
    chosen.mkdir(mode=0o700, parents=True, exist_ok=True)
    own = chosen if is_own(chosen) else chosen / f"user-{os.geteuid()}"
    own.mkdir(mode=0o700, exist_ok=True)
    if not is_own(own):
        raise PermissionError(f"{own} can be written to by others")
    if not os.access(own, os.R_OK | os.W_OK | os.X_OK):
        raise PermissionError(f"{own} can be neither read nor written")
    return own


def is_own(folder: Path, owner: int | None = None) -> bool:
    """True if a path is a folder (not a link) of this user or, unless it is None, of the user number `owner`, and
    nobody else can write to it. Raises OSError if nothing is there.
    """
    status = folder.lstat()
    belongs = status.st_uid in (os.geteuid(), owner)
    return stat.S_ISDIR(status.st_mode) and belongs and not status.st_mode & 0o022


def _users_cache() -> Path:
    stated = os.environ.get("XDG_CACHE_HOME", "")
    # The XDG specification has relative paths ignored.
    return Path(stated) if Path(stated).is_absolute() else Path.home() / ".cache"


class KeptCode(NullCache):
    """numba's interface to the machine code of one function on disk."""

    def __init__(self, source: Path, function: str, stamp: str) -> None:
        """source: the function's file.  function: its qualified name.  stamp: hash of everything that is
        compiled in.
        """
        self._source, self._function, self._stamp = source, function, stamp

    @property
    def cache_path(self) -> str:
        """The folder where code would be kept, or an empty string."""
        return str(next((folder for folder, writable in self._folders() if writable), ""))

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The code for the argument types `sig`; None if none is kept that is undamaged and of these sources."""
        # All else that numba loads for a compilation, it loads when one is due.
        rtsys.initialize(target_context)
        name = self._name(sig, target_context.codegen())
        for folder, _ in self._folders():
            # Of what can be wrong with a pickle there is no list.
            with suppress(Exception):
                kept = (folder / name).read_bytes()
                check, code = kept[:_CHECK_BYTES], kept[_CHECK_BYTES:]
                if check == self._check(code):
                    return CompileResult._rebuild(target_context, *pickle.loads(code))  # noqa: SLF001 - numba's only way
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep code in the first writable folder, unless it holds addresses of this process. Failures are silent."""
        if data.library.has_dynamic_globals or any(not one.can_cache for one in data.lifted):
            return
        code = dumps(data._reduce())  # noqa: SLF001
        name = self._name(sig, data.codegen)
        for folder, writable in self._folders():
            if writable and _written(folder / name, self._check(code) + code):
                return

    def _name(self, sig: Any, codegen: Any) -> str:
        asked = (str(self._source), str(sig), codegen.magic_tuple(), numba.__version__, platform.python_version())
        digest = hashlib.sha256(repr(asked).encode()).hexdigest()[:16]
        return f"{self._source.stem}.{self._function}-{digest}.code"

    def _check(self, code: bytes) -> bytes:
        return hashlib.sha256(self._stamp.encode() + code).digest()

    def _folders(self) -> Iterator[tuple[Path, bool]]:
        """Folders whose code can be trusted, each with True if this user may write to it."""
        stated = os.environ.get("NUMBA_CACHE_DIR")
        if not stated:
            with suppress(OSError):
                beside = self._source.parent / "__pycache__"
                if is_own(beside, self._source.stat().st_uid):
                    yield beside, os.access(beside, os.W_OK)
        private = _private(stated)
        if private is not None:
            yield private, True


@cache
def _private(stated: str | None) -> Path | None:
    with suppress(OSError, RuntimeError, ValueError):
        return private_folder(Path(stated) if stated else chosen_cache())
    return None


def _written(path: Path, kept: bytes) -> bool:
    """Write a file in one step, so that processes that compile the same do not disturb each other; True on success."""
    partial = path.with_suffix(f".{os.getpid()}.partial")
    try:
        partial.write_bytes(kept)
        partial.replace(path)
    except OSError:
        with suppress(OSError):
            partial.unlink(missing_ok=True)
        return False
    return True
