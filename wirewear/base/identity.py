"""What an answer was asked and made by: two answers of one identity are equal, so that one may stand for the other."""

import hashlib
import json
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from wirewear.base.errors import WirewearError

_ROOT = Path(__file__).resolve().parents[2]

_ENDINGS = (".py", ".toml", ".csv", ".json")  #: Files beside Python's that hold what is computed with.
_BENEATH = ("gmsh", "numpy", "scikit-fem", "scipy")  #: Packages whose versions change numbers.

#: What makes meshes and condenses bodies, relative to the folder that holds the packages.
CONDENSATION_CODE = (
    "geometry", "solvers/condensation.py", "solvers/errors.py", "solvers/kept_code.py", "solvers/patch_compliance.py",
    "solvers/strain.py",
)  # fmt: skip

#: What a run comes from.
RUN_CODE = (
    "geometry", "solvers", "wirewear/base/course.py", "wirewear/effects", "wirewear/loops", "wirewear/base/errors.py",
    "wirewear/reference", "wirewear/results", "wirewear/simulation", "wirewear/study",
)  # fmt: skip

ALL_CODE = ("geometry", "solvers", "wirewear")  #: The whole program.


@dataclass(frozen=True)
class Identity:
    """Of an answer: `asked` is a digest of the question, `made` one of the code and of all that it adds."""

    asked: str
    made: str

    def __str__(self) -> str:
        """Both, as they stand in files."""
        return f"{self.asked}.{self.made}"

    @property
    def name(self) -> str:
        """A name for a file that holds the answer."""
        return digest({"asked": self.asked, "made": self.made})[:24]

    @classmethod
    def of_text(cls, text: object) -> "Identity":
        """The identity that stands in a file; of an earlier version it is one that nothing equals."""
        asked, _, made = str(text).partition(".")
        return cls(asked, made)


def identity_of(asked: Mapping[str, Any], code: Iterable[str], plan: Mapping[str, Any]) -> Identity:
    """The identity of what is asked, made by code (files and folders) by a plan that follows from both."""
    beneath = {name: version(name) for name in _BENEATH}
    return Identity(digest(asked), digest({"code": code_hash(tuple(code)), "beneath": beneath, "plan": plan}))


def digest(parts: Mapping[str, Any]) -> str:
    """Digest of nested tables, 32 hexadecimal digits, whatever their order."""
    return hashlib.sha256(json.dumps(parts, sort_keys=True, default=str).encode()).hexdigest()[:32]


@cache
def code_hash(code: tuple[str, ...] = ALL_CODE) -> str:
    """SHA-256 over the program's own files in these files and folders, so that no two states of it pass for one.
    Raises WirewearError if one of them does not exist.
    """
    hashed = hashlib.sha256()
    for name in sorted(code):
        found = [_ROOT / name] if (_ROOT / name).is_file() else sorted((_ROOT / name).rglob("*"))
        files = [path for path in found if path.suffix in _ENDINGS]
        if not files:
            raise WirewearError(f"the program is incomplete: {_ROOT / name} holds none of its files.")
        for path in files:
            hashed.update(path.relative_to(_ROOT).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return hashed.hexdigest()


def added_code(objects: Iterable[object]) -> dict[str, str]:
    """SHA-256 of the files of other packages in which these classes, or those of these objects, stand, by module."""
    modules = {(item if isinstance(item, type) else type(item)).__module__ for item in objects}
    foreign = sorted(name for name in modules if name.partition(".")[0] not in (*ALL_CODE, "builtins"))
    files = {name: getattr(sys.modules.get(name), "__file__", None) for name in foreign}
    return {name: hashlib.sha256(Path(file).read_bytes()).hexdigest() for name, file in files.items() if file}
