"""Predicates on arrays that results are made of; each failure is one sentence."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from wirewear.base.errors import ResultError

FloatArray = NDArray[np.float64]


def float_array(name: str, values: ArrayLike, dimensions: int) -> FloatArray:
    """`values` as a read-only float64 array with that many dimensions.

    Raises:
        ResultError: `values` are no real numbers, or have another number of dimensions.
    """
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ResultError(f"{name} must hold real numbers") from error
    if array.ndim != dimensions:
        raise ResultError(f"{name} must have {dimensions} dimension(s), not {array.ndim}")
    array.setflags(write=False)
    return array


def require_finite(name: str, array: FloatArray) -> None:
    """Raise ResultError unless every entry is a finite number."""
    if not np.isfinite(array).all():
        raise ResultError(f"{name} must be finite everywhere, but {np.count_nonzero(~np.isfinite(array))} are not")


def require_increasing(name: str, array: FloatArray) -> None:
    """Raise ResultError unless the entries increase strictly."""
    # Differences of the largest numbers overflow.
    if not (array[1:] > array[:-1]).all():
        raise ResultError(f"{name} must increase strictly")


def require_equal_lengths(where: str, columns: Mapping[str, FloatArray]) -> None:
    """Raise ResultError unless all columns are as long as the first."""
    lengths = {name: column.size for name, column in columns.items()}
    if len(set(lengths.values())) > 1:
        raise ResultError(
            f"{where}: all columns must be equally long, not {', '.join(f'{k} {n}' for k, n in lengths.items())}"
        )
