"""The tuned constants of the diagnosis, read once from calibration.toml, where each says what set it.

SIZES = constants("observe.along_branches.plateau")
SLOPE_SHARE = SIZES.number("slope_share")
"""

import json
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from importlib.resources import files
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from wirewear.base.cache import added_code
from wirewear.effects import all_effects

FILE_NAME = "calibration.toml"

#: Where the file stands, for commands that learn constants.
FILE = Path(__file__).with_name(FILE_NAME)

#: Sources of what is not tuned: steps and ranges, where observables are read, least data, statistics, what is reported.
UNTUNED = {"resolution", "definition", "least_data", "convention", "as_likely_as_not", "wording"}

#: Units of numbers that cannot exceed one.
_UP_TO_ONE = {"correlation", "probability", "share of the variance"}


@dataclass(frozen=True)
class Constant:
    """One entry of the file: one or several numbers, their unit, the source that set them (a key of `sources`, or of
    `UNTUNED`), and the commit that introduced them; name: with its table, such as "wording.doubted".
    """

    name: str
    value: float | tuple[float, ...]
    unit: str
    source: str
    commit: str

    @property
    def tuned(self) -> bool:
        """True if the constant was chosen so that diagnoses come out right; see `UNTUNED` for other sources."""
        return self.source not in UNTUNED


@dataclass(frozen=True)
class Constants:
    """The constants of one table of the file, by name.

    Methods raise KeyError for a name that is not there, and TypeError if its value is not of the kind asked for.
    """

    table: str
    known: Mapping[str, Constant]

    def number(self, name: str) -> float:
        """The single number `name`."""
        value = self.known[name].value
        if isinstance(value, tuple):
            raise TypeError(f"{self.table}.{name} in {FILE_NAME} must be one number")
        return float(value)

    def count(self, name: str) -> int:
        """The whole number `name`."""
        value = self.number(name)
        if not value.is_integer():
            raise TypeError(f"{self.table}.{name} in {FILE_NAME} must be a whole number")
        return int(value)

    def numbers(self, name: str) -> tuple[float, ...]:
        """The list of numbers `name`."""
        value = self.known[name].value
        if not isinstance(value, tuple):
            raise TypeError(f"{self.table}.{name} in {FILE_NAME} must be a list of numbers")
        return value

    def each(self, *names: str) -> tuple[float, ...]:
        """Values of the constants of these names, each a single number, in their order."""
        return tuple(self.number(name) for name in names)

    def pair(self, name: str) -> tuple[float, float]:
        """The two numbers of the list `name`, in its order."""
        first, second = self.numbers(name)
        return first, second

    def all(self) -> dict[str, float]:
        """Values of the table's constants by name, all of which must be single numbers."""
        return {name: self.number(name) for name in self.known}


def constants(table: str) -> Constants:
    """The constants of a table, such as "observe.channels", without those of the tables in it."""
    known = {name: _constant(f"{table}.{name}", item) for name, item in _at(table).items() if _is_one(item)}
    return Constants(table, known)


def all_constants() -> Iterator[Constant]:
    """Every constant of the file, in its order."""
    yield from _walk("", {name: item for name, item in _tables().items() if name != "sources"})


def sources() -> Mapping[str, Mapping[str, str]]:
    """Origins of the constants by name: `what` in words, and the `command` that fits them."""
    found: Mapping[str, Mapping[str, str]] = _tables()["sources"]
    return found


def digest() -> str:
    """SHA-256 of all numbers that decide an answer: the file, and what is assumed of each effect before looking.

    Effects of installed packages count as those of the library; their code counts, too.

    Raises StudyError if an effect of an installed package cannot be loaded.
    """
    effects = all_effects()
    expected = {name: effect.expected() for name, effect in effects.items()}
    added = added_code(effects.values())
    spelled = json.dumps({"effects": expected, "added": added}, sort_keys=True)
    return sha256(_content() + spelled.encode()).hexdigest()


def scale(name: str, factor: float) -> None:
    """Multiply the constant `name`, with its table, in this process for modules that are imported from now on. Counts
    stay whole; correlations and probabilities stay at most 1.
    """
    item = _at(name)
    most = 1.0 - 1e-6 if item["unit"] in _UP_TO_ONE else inf
    values = np.minimum(np.multiply(item["value"], factor), most).tolist()
    # Counts stay whole.
    item["value"] = round(values) if isinstance(item["value"], int) else values


@cache
def _content() -> bytes:
    return files(__package__).joinpath(FILE_NAME).read_bytes()


@cache
def _tables() -> dict[str, Any]:
    return tomllib.loads(_content().decode("utf-8"))


def _at(name: str) -> dict[str, Any]:
    found = _tables()
    for part in name.split("."):
        found = found[part]
    return found


def _walk(prefix: str, table: Mapping[str, Any]) -> Iterator[Constant]:
    for name, item in table.items():
        if _is_one(item):
            yield _constant(prefix + name, item)
        elif isinstance(item, Mapping):
            yield from _walk(f"{prefix}{name}.", item)


def _is_one(item: object) -> bool:
    return isinstance(item, Mapping) and "value" in item


def _constant(name: str, item: Mapping[str, Any]) -> Constant:
    value = item["value"]
    return Constant(
        name, tuple(value) if isinstance(value, list) else value, item["unit"], item["source"], item["commit"]
    )
