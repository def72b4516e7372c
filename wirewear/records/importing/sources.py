"""Columns of numbers in a laboratory's files: delimited text and MATLAB."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from wirewear.errors import RecordError
from wirewear.files.delimited import DelimitedText, Layout, read_delimited
from wirewear.files.hdf5 import require_self_contained
from wirewear.files.reading import require_within
from wirewear.processes import within
from wirewear.quantity import shown
from wirewear.records.importing.damage import DAMAGED_FILE_ERRORS, reason_of
from wirewear.records.importing.mapping import DELIMITERS, ColumnMapping, Source, unit_factor
from wirewear.records.values import Array

#: A pattern that needs longer for a file's name would need for ever.
PATTERN_s = 2.0

Wanted = Mapping[str, ColumnMapping]


def files_of(source: Source, home: Path) -> list[Path]:
    """The files that a source names, patterns in natural order (2 before 10).

    Raises:
        RecordError: there is none.
    """
    found: list[Path] = []
    for name in source.files:
        try:
            matches = [home / name] if (home / name).is_file() else [p for p in home.glob(name) if p.is_file()]
        except (ValueError, NotImplementedError, OSError):
            matches = []
        for path in matches:
            require_within(path, home, RecordError, "the file")
        if not matches:
            raise RecordError(f"there is no file {home / name}.")
        found += sorted(matches, key=_natural)
    return found


def _natural(path: Path) -> list[tuple[int, str]]:
    return [(int(digits or 0), text) for text, digits in re.findall(r"(\D+)(\d*)|$", path.name)]


def numbers_in_name(path: Path, source: Source) -> dict[str, int]:
    """Cycle and repeat as the file's name tells them.

    Raises:
        RecordError: the name does not fit the pattern.
    """
    if source.name_pattern is None:
        return {}
    try:
        with within(PATTERN_s):
            found = re.search(source.name_pattern, path.name)
    except TimeoutError:
        raise RecordError(
            f"{path}: name_pattern = {source.name_pattern!r} takes too long on the file's name: repeat nothing that "
            "is repeated already."
        ) from None
    if found is None:
        raise RecordError(f"{path}: the file's name does not fit name_pattern = {source.name_pattern!r}.")
    try:
        return {key: int(value) for key, value in found.groupdict().items() if value is not None}
    except ValueError:
        raise RecordError(f"{path}: name_pattern finds {found.groupdict()}, which are no whole numbers.") from None


def read_source(path: Path, source: Source, wanted: Wanted) -> dict[str, Array]:
    """The wanted columns of one file in the record's units: (n,), or from MATLAB (samples, cycles).

    Raises:
        RecordError: the file cannot be read, lacks a column or holds text for a number.
    """
    factors = {}
    for name, mapping in wanted.items():
        try:
            factors[name] = unit_factor(name, mapping)
        except ValueError as problem:
            raise RecordError(f"{path}: {problem}.") from None
    raw = _matlab(path, wanted) if source.kind == "matlab" else _text(path, source, wanted)
    return {name: factors[name] * values + wanted[name].offset for name, values in raw.items()}


def _text(path: Path, source: Source, wanted: Wanted) -> dict[str, Array]:
    text = read_delimited(path, _layout(source))
    start = text.layout.lines_before_rows
    if next(text.rows(), None) is None:
        raise RecordError(f"{path}, line {start + 1}: there are no numbers below the header.")
    places = {name: _place(text, mapping.column) for name, mapping in wanted.items()}
    return text.numbers(places, ragged=True).columns


def _layout(source: Source) -> Layout:
    return Layout(
        delimiter=DELIMITERS[source.delimiter],
        decimal=source.decimal,
        encoding=source.encoding,
        header_lines=source.header_lines,
        names_line=source.names_line,
        lines_after_names=source.lines_after_names,
    )


def _place(text: DelimitedText, column: str | int) -> int:
    if isinstance(column, int):
        return column - 1
    names, line = text.names, text.layout.header_lines + 1
    if not text.layout.names_line:
        raise RecordError(f"{text.path}: with names_line = false, columns are given by number, not as {column!r}.")
    if column not in names:
        raise RecordError(f"{text.path}, line {line}: there is no column {column!r} among {shown(', '.join(names))}.")
    return names.index(column)


def _matlab(path: Path, wanted: Wanted) -> dict[str, Array]:
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    try:
        contents: Any = loadmat(path, squeeze_me=True, struct_as_record=False)
    except NotImplementedError:
        return _matlab_73(path, wanted)
    except (MatReadError, *DAMAGED_FILE_ERRORS) as problem:
        raise _no_matlab_file(path, problem) from None
    return {name: _variable(path, contents, str(mapping.column)) for name, mapping in wanted.items()}


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
            for name, mapping in wanted.items():
                variable = str(mapping.column)
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
