"""Results of planar studies on disk: one HDF5 file that holds everything, and CSV tables of the same."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol

import h5py
import numpy as np
from numpy.typing import NDArray

from wirewear.errors import ResultError
from wirewear.files import write_bytes, writing
from wirewear.files.hdf5 import hdf5_image, opened_hdf5
from wirewear.results import RESULT_FILE_NAME

Array = NDArray[np.float64]
#: Columns by name, all of one length.
Columns = Mapping[str, Any]

_FORMAT = 2
# Written without a checksum.
_UNSEALED = (1,)


class PlanarOutcome(Protocol):
    """What every planar result has."""

    @property
    def name(self) -> str:
        """Title of the study."""

    @property
    def fidelity(self) -> str:
        """Level at which it ran."""

    @property
    def study(self) -> Mapping[str, Any]:
        """The study, ready for JSON."""

    @property
    def settings(self) -> Mapping[str, Any]:
        """How it was made."""


def write_files(
    folder: Path, kind: str, result: PlanarOutcome, tables: Mapping[str, Columns], fill: Callable[[h5py.File], None]
) -> list[Path]:
    """Write result.h5, into which `fill` puts what is not common to all kinds, and the CSV tables, each in one step.

    Raises:
        ResultError: a file cannot be written.
    """
    import polars as pl

    def fill_all(file: h5py.File) -> None:
        file.attrs["kind"], file.attrs["format"] = kind, _FORMAT
        file.attrs["name"], file.attrs["fidelity"] = result.name, result.fidelity
        put_json(file, study=result.study, settings=result.settings)
        fill(file)

    files = {name: pl.DataFrame(dict(columns)).write_csv().encode() for name, columns in tables.items()}
    files[RESULT_FILE_NAME] = hdf5_image(fill_all, track_order=True)
    with writing(ResultError, f"cannot write the results to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        return [write_bytes(folder / name, content) for name, content in files.items()]


@contextmanager
def opened_result(path: Path, kind: str, study_kind: str) -> Iterator[tuple[h5py.File, dict[str, Any]]]:
    """The open result.h5 at a path, or in the folder there, and what it has in common with other kinds, by name.

    Raises:
        ResultError: there is none, or it is no result of that kind, or something in it is missing.
    """
    file_path = path / RESULT_FILE_NAME if path.is_dir() else path
    with opened_hdf5(file_path, ResultError, "result file", unsealed=_UNSEALED) as file:
        if file.attrs.get("kind") != kind:
            raise ResultError(f"{file_path} is no result of a {study_kind} study.")
        common = {"name": str(file.attrs["name"]), "fidelity": str(file.attrs["fidelity"])}
        yield file, common | {name: json_in(file, name) for name in ("study", "settings")}


def put_json(group: h5py.Group, **values: Mapping[str, Any]) -> None:
    """Keep mappings as JSON texts."""
    for name, value in values.items():
        group[name] = json.dumps(value, ensure_ascii=False)


def json_in(group: h5py.Group, name: str) -> Any:
    """What a JSON text holds."""
    return json.loads(group[name][()])


def put_arrays(group: h5py.Group, item: object, names: Iterable[str]) -> None:
    """Keep attributes of an object that are arrays."""
    for name in names:
        group[name] = getattr(item, name)


def arrays_in(group: h5py.Group) -> dict[str, Array]:
    """The arrays of a group, by name."""
    return {name: np.asarray(column[()], dtype=np.float64) for name, column in group.items()}


def long_table(items: Sequence[object], keys: Sequence[str], columns: Sequence[str]) -> Columns:
    """Arrays of several objects one below the other, with the keys of each repeated beside them."""
    lengths = [len(getattr(item, columns[0])) for item in items]
    repeated = {
        key: [value for item, n in zip(items, lengths, strict=True) for value in [getattr(item, key)] * n]
        for key in keys
    }
    return repeated | {
        name: np.concatenate([np.zeros(0), *(getattr(item, name) for item in items)]) for name in columns
    }


def table_of_rows(rows: Sequence[Mapping[str, Any]]) -> Columns:
    """Rows with the same names as columns."""
    return {name: [row[name] for row in rows] for name in (rows[0] if rows else ())}
