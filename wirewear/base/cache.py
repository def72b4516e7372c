"""Cache of computed results: the identity by which equal results are found, and the folder, kept within a size.

Cached files are used without being recomputed, so nobody else may write to the folder. Where no such folder is
available, nothing is kept, and a warning says so once.
"""

import hashlib
import json
import os
import shutil
import sys
import warnings
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path
from time import time

from solvers.jit_cache import chosen_cache, private_folder
from wirewear.base.errors import KeptNothingWarning, WirewearError
from wirewear.base.writing import why_not_written

DEFAULT_GB = 10.0  #: Gigabytes that are kept, unless WIREWEAR_CACHE_GB says otherwise.
_KEPT = ("body-*.npz", "wire-*.npz", "nominal-*.h5")  #: What is kept, by the names of the files.
WARNED: set[str] = set()  #: What was warned of, in this process or in the one that started it.

_ROOT = Path(__file__).resolve().parents[2]
_ENDINGS = (".py", ".toml", ".csv", ".json")  #: Files beside Python's that hold what is computed with.
_BENEATH = ("gmsh", "numpy", "scikit-fem", "scipy")  #: Packages whose versions change numbers.

#: What makes meshes and condenses bodies, relative to the folder that holds the packages.
CONDENSATION_CODE = (
    "geometry", "solvers/errors.py", "solvers/jit_cache.py", "solvers/elasticity/condensation.py",
    "solvers/elasticity/elimination.py",
    "solvers/elasticity/embedding.py",
    "solvers/elasticity/patch_compliance.py", "solvers/elasticity/linear_elasticity.py",
)  # fmt: skip

#: What a run comes from.
RUN_CODE = (
    "geometry", "solvers", "wirewear/base/course.py", "wirewear/effects", "wirewear/loops", "wirewear/base/errors.py",
    "wirewear/base/units.py", "wirewear/base/words.py",
    "wirewear/reference", "wirewear/results", "wirewear/simulation", "wirewear/test",
)  # fmt: skip
ALL_CODE = ("geometry", "solvers", "wirewear")  #: The whole program.


def cache_directory() -> Path | None:
    """Cache folder, created if missing: WIREWEAR_CACHE, else the user's cache folder; None if neither can be used.

    If others can write to that folder, or it belongs to another user, a private folder inside it is used.
    """
    try:
        return private_folder(chosen_cache())
    except (OSError, RuntimeError, ValueError) as problem:
        reason = why_not_written(problem) if isinstance(problem, OSError) else str(problem)
        _warn_once(f"{os.environ.get('WIREWEAR_CACHE') or 'the cache folder'} cannot be used ({reason})")
        return None


def kept_file(name: str) -> Path | None:
    """Path of the cached file of this name, whether it exists or not; None if nothing can be cached."""
    folder = cache_directory()
    return None if folder is None else folder / name


def allowed_bytes() -> float:
    """Size limit of the cache in bytes, from WIREWEAR_CACHE_GB; 10 GB unless that is a number of at least 0."""
    with suppress(ValueError):
        chosen = float(os.environ.get("WIREWEAR_CACHE_GB", DEFAULT_GB))
        if chosen >= 0.0:
            return 1e9 * chosen
    return 1e9 * DEFAULT_GB


def mark_used(path: Path) -> None:
    """Set the time of a cached file's last use to now, if possible."""
    with suppress(OSError):
        os.utime(path)


def not_kept(path: Path, problem: OSError) -> None:
    """Warn, once a process, that a file could not be cached, for the reason of `problem`."""
    _warn_once(f"nothing can be written to the cache folder {path.parent} ({why_not_written(problem)})")


def remove_abandoned(directory: Path, pattern: str) -> None:
    """Delete files and folders in `directory` that match the pattern and are older than a day: what killed processes
    left unfinished.
    """
    for left in directory.glob(pattern):
        with suppress(OSError):
            # Nothing that is kept takes a day to be made: what is unfinished after one belongs to nobody.
            if time() - left.stat().st_mtime > 86_400.0:
                if left.is_dir():
                    shutil.rmtree(left)
                else:
                    left.unlink()


def keep_within(directory: Path, allowed: float, newest: Path | None = None) -> None:
    """Delete cached files, least recently used first and never `newest` (None: any), until the rest takes at most
    `allowed` bytes.

    Files that vanish or cannot be deleted meanwhile are skipped.
    """
    kept = []
    for pattern in _KEPT:
        remove_abandoned(directory, f".{pattern.partition('*')[0]}*.partial*")
        for path in directory.glob(pattern):
            with suppress(OSError):
                status = path.stat()
                kept.append((status.st_mtime, status.st_size, path))
    total = sum(size for _, size, _ in kept)
    for _, size, path in sorted(kept):
        if total <= allowed:
            break
        if path != newest:
            with suppress(OSError):
                path.unlink()
                total -= size


def _warn_once(what: str) -> None:
    if what not in WARNED:
        WARNED.add(what)
        said = f"{what}: what is computed is not kept for the next time; WIREWEAR_CACHE names a folder."
        warnings.warn(KeptNothingWarning(said), stacklevel=3)


installed = cache(version)  #: The version of a package; each is read from a file of its own.


@dataclass(frozen=True)
class Identity:
    """Identity of a result: `asked`, a digest of the question, and `made`, one of the code and plan that answer it."""

    asked: str
    made: str

    def __str__(self) -> str:
        """Both digests in one text, as files hold it."""
        return f"{self.asked}.{self.made}"

    @property
    def name(self) -> str:
        return digest({"asked": self.asked, "made": self.made})[:24]

    @classmethod
    def of_text(cls, text: object) -> "Identity":
        """Identity from its text in a file, see `__str__`; a text in an earlier format gives one unlike all others."""
        asked, _, made = str(text).partition(".")
        return cls(asked, made)


def identity_of(asked: Mapping[str, object], code: Iterable[str], plan: Mapping[str, object]) -> Identity:
    """Identity of a result; asked: the question. code: the program's files and folders that answer it, relative to the
    folder that holds the packages. plan: further settings that follow from both, and whose change makes another result.
    """
    beneath = {name: installed(name) for name in _BENEATH}
    return Identity(digest(asked), digest({"code": code_hash(tuple(code)), "beneath": beneath, "plan": plan}))


def digest(parts: Mapping[str, object]) -> str:
    """Digest of nested tables as 32 hexadecimal digits, independent of the order of their keys."""
    return hashlib.sha256(json.dumps(parts, sort_keys=True, default=str).encode()).hexdigest()[:32]


@cache
def code_hash(code: tuple[str, ...] = ALL_CODE) -> str:
    """SHA-256, as hexadecimal digits, over the program's files in these files and folders, relative to the folder that
    holds the packages; it changes with any of them.

    Raises WirewearError if one of them does not exist.
    """
    hashed = hashlib.sha256()
    for name in sorted(code):
        within = _ROOT / "wirewear" / name  # where an installed package holds its parts
        place = within if within.exists() else _ROOT / name
        files = [path for path in ([place] if place.is_file() else sorted(place.rglob("*"))) if path.suffix in _ENDINGS]
        if not files:
            raise WirewearError(f"the program is incomplete: {place} holds none of its files.")
        for path in files:
            hashed.update(path.relative_to(_ROOT).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return hashed.hexdigest()


def added_code(objects: Iterable[object]) -> dict[str, str]:
    """SHA-256 of the source files of those objects' classes (or of the objects, if they are classes) that are not part
    of this program, by the name of their module.
    """
    modules = {(item if isinstance(item, type) else type(item)).__module__ for item in objects}
    foreign = sorted(name for name in modules if name.partition(".")[0] not in (*ALL_CODE, "builtins"))
    files = {name: getattr(sys.modules.get(name), "__file__", None) for name in foreign}
    return {name: hashlib.sha256(Path(file).read_bytes()).hexdigest() for name, file in files.items() if file}
