"""MATLAB's files, of version 7.3 (HDF5) and of those before."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from wirewear.errors import RecordError
from wirewear.files.delimited import Layout
from wirewear.files.hdf5 import require_self_contained
from wirewear.records.importing.damage import DAMAGED_FILE_ERRORS, reason_of
from wirewear.records.importing.readers.reader import Reader
from wirewear.records.values import Array

Wanted = Mapping[str, str | int]


class MatlabReader(Reader):
    """Variables of a MATLAB file, named by their path: ``Loops.force``."""

    kind = "matlab"

    def columns(self, path: Path, layout: Layout, wanted: Wanted) -> dict[str, Array]:  # noqa: ARG002
        """The variables, by their paths; ``layout`` says nothing of such a file."""
        from scipy.io import loadmat
        from scipy.io.matlab import MatReadError

        try:
            contents: Any = loadmat(path, squeeze_me=True, struct_as_record=False)
        except NotImplementedError:
            return _matlab_73(path, wanted)
        except (MatReadError, *DAMAGED_FILE_ERRORS) as problem:
            raise _no_matlab_file(path, problem) from None
        return {name: _variable(path, contents, str(column)) for name, column in wanted.items()}


def _no_matlab_file(path: Path, problem: Exception) -> RecordError:
    return RecordError(f"{path} cannot be read as a MATLAB file ({reason_of(problem)}).")


def _variable(path: Path, contents: Any, name: str) -> Array:
    value = contents
    for part in name.split("."):
        value = value.get(part) if isinstance(value, dict) else getattr(value, part, None)
        if value is None:
            known = ", ".join(key for key in contents if not key.startswith("__"))
            raise RecordError(f"{path}: there is no variable {name!r}; its variables are {known}.")
    return _numeric(path, name, value)


def _matlab_73(path: Path, wanted: Wanted) -> dict[str, Array]:
    import h5py

    values = {}
    try:
        with h5py.File(path, "r") as file:
            require_self_contained(file, path, RecordError, path.stat().st_size)
            for name, column in wanted.items():
                variable = str(column)
                place = variable.replace(".", "/")
                if place not in file or not isinstance(file[place], h5py.Dataset):
                    raise RecordError(
                        f"{path}: there is no variable {variable!r}; its variables are {', '.join(file)}."
                    )
                # MATLAB stores columns first, which HDF5 shows as the transpose.
                values[name] = _numeric(path, variable, np.squeeze(file[place][()].T))
    except DAMAGED_FILE_ERRORS as problem:
        raise _no_matlab_file(path, problem) from None
    return values


def _numeric(path: Path, name: str, value: object) -> Array:
    try:
        array = np.atleast_1d(np.asarray(value, dtype=np.float64))
    except (TypeError, ValueError):
        raise RecordError(f"{path}: the variable {name!r} holds no numbers.") from None
    if array.ndim > 2:
        raise RecordError(f"{path}: the variable {name!r} has {array.ndim} dimensions, where 1 or 2 are read.")
    return array
