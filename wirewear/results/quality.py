"""How sound a run is: what its residuals and closures are, and from where on to look at them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from geometry.arrays import Array
from wirewear.base.errors import ResultError


def float_array(name: str, values: ArrayLike, dimensions: int) -> Array:
    """`values` as a read-only float64 array with that many dimensions.
    Raises ResultError if `values` are no real numbers, or have another number of dimensions.
    """
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ResultError(f"{name} must hold real numbers") from error
    if array.ndim != dimensions:
        raise ResultError(f"{name} must have {dimensions} dimension(s), not {array.ndim}")
    array.setflags(write=False)
    return array


def require_finite(name: str, array: Array) -> None:
    """Raise ResultError unless every entry is a finite number."""
    if not np.isfinite(array).all():
        raise ResultError(f"{name} must be finite everywhere, but {np.count_nonzero(~np.isfinite(array))} are not")


def require_increasing(name: str, array: Array) -> None:
    """Raise ResultError unless the entries increase strictly."""
    # Differences of the largest numbers overflow.
    if not (array[1:] > array[:-1]).all():
        raise ResultError(f"{name} must increase strictly")


def require_equal_lengths(where: str, columns: Mapping[str, Array]) -> None:
    """Raise ResultError unless all columns are as long as the first."""
    lengths = {name: column.size for name, column in columns.items()}
    if len(set(lengths.values())) > 1:
        raise ResultError(
            f"{where}: all columns must be equally long, not {', '.join(f'{k} {n}' for k, n in lengths.items())}"
        )


ENERGIES_AGREE = 5e-3  #: Friction energies that differ by more than this share are not taken to agree.

#: What each quality of a run says, and from where on it should be looked at.
QUALITIES: Mapping[str, tuple[str, float]] = {
    "force_balance": ("forces on the holder that do not balance, relative", 1e-6),
    "penetration": ("penetration of one body into the other, relative to the approach", 1e-4),
    "complementarity": ("pressure where the bodies do not touch, relative", 1e-4),
    "slip_direction_error_rad": ("angle between friction and slip [rad]", 1e-2),
    "elastic_slip": ("slip that a penalty lets through, relative", 1e-2),
    "loop_area_against_friction_work": ("area of a loop against friction work in the contact, relative", 2e-3),
    "volume_against_energy": ("worn volume against the wear law's, relative", 1e-3),
    "energy_against_loops": ("energy that wore against energy of the recorded loops, relative", ENERGIES_AGREE),
    "mirror_error": ("pressures against their mirror image on the way back, relative", 2e-2),
}


@dataclass(frozen=True)
class Health:
    """One closure: what it is, the worst value that each run met (None: not defined), from where on to look at it."""

    meaning: str
    worst: tuple[float | None, ...]
    limit: float

    @property
    def sound(self) -> bool:
        """Whether all values are below the limit."""
        return all(value is None or value <= self.limit for value in self.worst)


class Judged(Protocol):
    """A result that says how well it closes."""

    @property
    def quality(self) -> Mapping[str, float]:
        """The worst residuals met, by name."""


def health(results: Sequence[Judged]) -> list[Health]:
    """The closures of runs, in the order of QUALITIES; others follow by their names, without a limit."""
    known = [name for name in QUALITIES if any(name in result.quality for result in results)]
    others = sorted({name for result in results for name in result.quality if name not in QUALITIES})
    meanings = {name: meaning for name, (meaning, _) in QUALITIES.items()}
    return [
        Health(
            meanings.get(name, name.replace("_", " ")),
            tuple(result.quality.get(name) for result in results),
            limit_of(name),
        )
        for name in [*known, *others]
    ]


def limit_of(name: str) -> float:
    """From where on a quality should be looked at; infinite of one without a limit."""
    return QUALITIES[name][1] if name in QUALITIES else float("inf")


def flagged(name: str, value: float) -> str:
    """A quality's value, with its limit where it is beyond that."""
    limit = limit_of(name)
    return f"{value:.1e}, more than {limit:.1e}" if value > limit else f"{value:.1e}"
