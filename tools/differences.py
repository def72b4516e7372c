"""Differences of two folders of answers: HDF5, JSON, TOML and CSV files, number by number.

Numbers agree where they differ by at most the tolerance times the largest number of their array.
"""

import csv
import json
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

#: Names under which nothing is compared: times, versions, and hashes that hold versions or salt.
IGNORED = {"timings_s", "versions", "wirewear", "identity", "salt", "source"}

TOLERANCE = 1e-12

#: Numbers below this are round-off in every unit in use (N, µm, mJ, MPa, s).
ROUND_OFF = 1e-13

Values = dict[str, Any]


@dataclass(frozen=True)
class Difference:
    """Where two folders differ, how in words, and by how much of the largest number; infinite if not in numbers."""

    where: str
    how: str
    size: float = np.inf

    def __str__(self) -> str:
        return f"{self.where} {self.how}"


def values_of(path: Path) -> Values:
    """What a file holds: arrays, numbers and texts by their place in it."""
    if path.suffix == ".h5":
        return dict(_hdf5_values(path))
    if path.suffix == ".csv":
        with path.open(encoding="utf-8", newline="") as file:
            names, *rows = csv.reader(file)
        columns = zip(*rows, strict=True) if rows else ((),) * len(names)
        return {name: np.array(column, dtype=float) for name, column in zip(names, columns, strict=True)}
    text = path.read_text(encoding="utf-8")
    return dict(_tree_values("", tomllib.loads(text) if path.suffix == ".toml" else json.loads(text)))


def _hdf5_values(path: Path) -> Iterator[tuple[str, Any]]:
    with h5py.File(path, "r") as file:
        places: dict[str, Any] = {"": file}
        file.visititems(places.__setitem__)
        for place, item in places.items():
            for name, value in item.attrs.items():
                yield from _stored_values(f"{place}@{name}", value)
            if isinstance(item, h5py.Dataset):
                yield from _stored_values(place, item.asstr()[()] if item.dtype.kind == "O" else item[()])


def _stored_values(place: str, value: Any) -> Iterator[tuple[str, Any]]:
    if isinstance(value, str) and value.startswith(("{", "[")):
        yield from _tree_values(place, json.loads(value))
    else:
        yield place, value if isinstance(value, str) else np.asarray(value)


def _tree_values(place: str, value: Any) -> Iterator[tuple[str, Any]]:
    if isinstance(value, Mapping):
        for key, part in value.items():
            yield from _tree_values(f"{place}/{key}".lstrip("/"), part)
    elif isinstance(value, list) and not all(_is_number(part) for part in value):
        for number, part in enumerate(value):
            yield from _tree_values(f"{place}/{number}", part)
    elif _is_number(value) or isinstance(value, list):
        yield place, np.asarray(value, dtype=float)
    else:
        yield place, value


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def file_differences(frozen: Path, present: Path, tolerance: float) -> list[Difference]:
    """Differences of two files of one kind."""
    old, new = (_compared(values_of(path)) for path in (frozen, present))
    found = [Difference(key, "is missing") for key in old.keys() - new.keys()]
    found += [Difference(key, "is new") for key in new.keys() - old.keys()]
    for key in old.keys() & new.keys():
        found += _differences(key, old[key], new[key], tolerance)
    return found


def _compared(values: Values) -> Values:
    def ignored(key: str) -> bool:
        return not IGNORED.isdisjoint(key.replace("@", "/").split("/"))

    return {key: value for key, value in values.items() if not ignored(key)}


def _differences(key: str, old: Any, new: Any, tolerance: float) -> list[Difference]:
    """How a value differs: nothing where it agrees."""
    if not (isinstance(old, np.ndarray) and isinstance(new, np.ndarray) and old.dtype.kind in "iufb"):
        same = type(old) is type(new) and np.array_equal(old, new)
        return [] if same else [Difference(key, f"was {old!r} and is {new!r}")]
    if old.shape != new.shape:
        return [Difference(key, f"had the shape {old.shape} and has {new.shape}")]
    known = np.isfinite(old)
    if not np.array_equal(old[~known], new[~known], equal_nan=True) or not np.isfinite(new[known]).all():
        return [Difference(key, "is not finite in other places")]
    was, now = old[known].astype(float), new[known].astype(float)
    gap, size = np.abs(was - now), np.abs(was).max(initial=0.0)
    largest = float(gap.max(initial=0.0))
    if largest <= max(tolerance * size, ROUND_OFF):
        return []
    place = int(gap.argmax())
    entry = f" at entry {place} of {gap.size}" if gap.size > 1 else ""
    relative = largest / max(size, ROUND_OFF)
    return [Difference(key, f"was {was[place]:.15g} and is {now[place]:.15g}{entry}: {relative:.1e}", relative)]


def tree_differences(frozen: Path, present: Path, tolerance: float) -> list[Difference]:
    """Differences of two folders, each with its file; the largest first."""
    old, new = ({path.relative_to(top) for path in top.rglob("*") if path.is_file()} for top in (frozen, present))
    found = [Difference(str(path), "is missing") for path in old - new]
    found += [Difference(str(path), "is new") for path in new - old]
    for path in old & new:
        own = file_differences(frozen / path, present / path, tolerance)
        found += [Difference(f"{path}: {one.where}", one.how, one.size) for one in own]
    return sorted(found, key=lambda one: (-one.size, one.where))
