"""Worn volume by friction energy: the line through the origin, and laws of the energy wear coefficient."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import log

import numpy as np
from scipy import stats

from .measured import Array, MeasuredTest, column

CONFIDENCE = 0.95


@dataclass(frozen=True)
class EnergyLine:
    """V = αE by least squares through the origin, with a scatter of the volumes that is the same for all tests."""

    coefficient_mm3_per_J: float
    scatter_mm3: float
    energies_squared_J2: float
    count: int

    @property
    def _quantile(self) -> float:
        return float(stats.t.ppf(0.5 * (1.0 + CONFIDENCE), self.count - 1))

    @property
    def interval_mm3_per_J(self) -> tuple[float, float]:
        """Of the coefficient, 95 %."""
        half = self._quantile * self.scatter_mm3 / self.energies_squared_J2**0.5
        return self.coefficient_mm3_per_J - half, self.coefficient_mm3_per_J + half

    def predicted_mm3(self, energy_J: float) -> tuple[float, float]:
        """Volume of a further test, and half of its 95 % prediction interval."""
        spread = (1.0 + energy_J**2 / self.energies_squared_J2) ** 0.5
        return self.coefficient_mm3_per_J * energy_J, self._quantile * self.scatter_mm3 * spread


def energy_line(tests: Sequence[MeasuredTest]) -> EnergyLine:
    """The line through the origin of at least two tests."""
    energy, volume = column(tests, "energy_J"), column(tests, "volume_mm3")
    squared = float(energy @ energy)
    coefficient = float(energy @ volume) / squared
    rest = volume - coefficient * energy
    return EnergyLine(coefficient, float(rest @ rest / (len(tests) - 1)) ** 0.5, squared, len(tests))


def off_the_line(tests: Sequence[MeasuredTest]) -> list[MeasuredTest]:
    """Tests outside the prediction interval of the U-shaped ones, each judged by a line that does not know it."""
    found = []
    for test in tests:
        line = energy_line([other for other in tests if other.scar == "U" and other is not test])
        predicted, half = line.predicted_mm3(test.energy_J)
        if abs(test.volume_mm3 - predicted) > half:
            found.append(test)
    return found


#: Predicts the logarithm of a test's energy wear coefficient from others.
Law = Callable[[Sequence[MeasuredTest], MeasuredTest], float]


def one_coefficient(known: Sequence[MeasuredTest], _test: MeasuredTest) -> float:
    """The same for all: their geometric mean."""
    return float(np.log(column(known, "coefficient_mm3_per_J")).mean())


def falls_with_power(known: Sequence[MeasuredTest], test: MeasuredTest) -> float:
    """A power of the friction power density."""
    slope, base = power_law(known)
    return base + slope * log(test.power_density_W_per_mm2)


def power_law(tests: Sequence[MeasuredTest]) -> tuple[float, float]:
    """Exponent and log of the coefficient at 1 W/mm², least squares of logarithms."""
    density = np.log(column(tests, "power_density_W_per_mm2"))
    slope, base = np.polyfit(density, np.log(column(tests, "coefficient_mm3_per_J")), 1)
    return float(slope), float(base)


LAWS: dict[str, Law] = {"one energy wear coefficient": one_coefficient, "falling with power density": falls_with_power}


def left_out(tests: Sequence[MeasuredTest], law: Law) -> Array:
    """Predicted over measured volume of each test, from all others."""
    ratios = []
    for test in tests:
        coefficient = np.exp(law([other for other in tests if other is not test], test))
        ratios.append(coefficient / test.coefficient_mm3_per_J)
    return np.array(ratios)


def typical_factor(ratios: Array) -> float:
    """The factor by which predictions are off: exp of the root mean square logarithm."""
    return float(np.exp(np.sqrt(np.mean(np.log(ratios) ** 2))))
