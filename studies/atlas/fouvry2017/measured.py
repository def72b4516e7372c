"""The measured tests of titanium on titanium, one a row of tests.csv."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi
from pathlib import Path

import numpy as np
import polars as pl
from numpy.typing import NDArray

Array = NDArray[np.float64]

TESTS = Path(__file__).parent / "tests.csv"

#: Scars: even (U), deeper at their sides (W), between (I).
SHAPES = {"U": "U, even", "I": "I, between", "W": "W, deeper at its sides"}


@dataclass(frozen=True)
class MeasuredTest:
    """One measured test: worn volume and friction energy of both bodies, the whole contact and all cycles."""

    name: str
    scar: str
    volume_mm3: float
    energy_J: float
    half_width_mm: float
    length_mm: float
    frequency_Hz: float
    cycles: float

    @property
    def coefficient_mm3_per_J(self) -> float:
        """Its own energy wear coefficient."""
        return self.volume_mm3 / self.energy_J

    @property
    def power_density_W_per_mm2(self) -> float:
        """Mean friction power over Hertz's contact at the largest load."""
        power = self.energy_J / self.cycles * self.frequency_Hz
        return power / (2.0 * self.half_width_mm * self.length_mm)

    @property
    def oxygen_demand_W(self) -> float:
        """Power density times the square of the half-width.

        Oxygen that is used up at a rate per area in proportion to the friction power, and diffuses in from the edges,
        falls by an amount in proportion to this number towards the middle.
        """
        return self.power_density_W_per_mm2 * self.half_width_mm**2


def read_tests(path: Path = TESTS) -> tuple[MeasuredTest, ...]:
    """The tests of the table."""
    return tuple(
        MeasuredTest(
            name=str(row["test"]),
            scar=str(row["scar"]),
            volume_mm3=float(row["volume_mm3"]),
            energy_J=float(row["energy_J"]),
            # Hertz's line contact: p0 = 2P/(πa).
            half_width_mm=2.0 * row["largest_load_N_per_mm"] / (pi * row["hertz_pressure_MPa"]),
            length_mm=float(row["length_mm"]),
            frequency_Hz=float(row["frequency_Hz"]),
            cycles=float(row["cycles"]),
        )
        for row in pl.read_csv(path, comment_prefix="#").iter_rows(named=True)
    )


def shaped(tests: Sequence[MeasuredTest], scar: str) -> list[MeasuredTest]:
    """Those with scars of this shape."""
    return [test for test in tests if test.scar == scar]


def column(tests: Sequence[MeasuredTest], name: str) -> Array:
    """One of their figures, (n,)."""
    return np.array([getattr(test, name) for test in tests])
