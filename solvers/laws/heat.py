"""Temperatures at which surfaces rub, and how friction, wear and the supply of oxygen follow them.

A rate of reaction goes with exp(-E / (R T)) (Arrhenius), with an activation energy E, the gas constant R and the
temperature T of the surface: that of the surroundings and the rise by friction. Rises are means over the cycle,
weighted with the friction power at a place: see `solvers.wear_step.warming`.
"""

from dataclasses import dataclass

import numpy as np

from geometry.arrays import Array
from solvers.conduction import Conductor
from solvers.errors import SolverError

GAS_CONSTANT = 8.314462618  # J/(mol K), CODATA.


@dataclass(frozen=True)
class FrictionHeat:
    """Conduction of both bodies, and laws of the temperature. Raises SolverError for a conductor without conductivity
    or heat capacity, a negative resistance, or no length.
    """

    upper: Conductor
    lower: Conductor
    wear_J_per_mol: float = 0.0  #: Activation energy of the wear coefficient; negative: warm surfaces wear less.
    oxidation_J_per_mol: float = 0.0  #: Of the reaction that consumes oxygen, see `OxygenSupply`.
    friction_per_K: float = 0.0  #: Change of the coefficient of friction per kelvin, over the coefficient.
    surroundings_K: float = 293.15
    length_mm: float = 1.0  #: Of a line contact.

    def __post_init__(self) -> None:
        both = self.upper, self.lower
        if not all(one.conductivity_W_per_m_K > 0.0 and one.heat_capacity_J_per_cm3_K > 0.0 for one in both):
            raise SolverError("bodies that are heated need a positive conductivity and heat capacity")
        if min(one.resistance_K_per_W for one in both) < 0.0 or not self.length_mm > 0.0:
            raise SolverError("resistances to heat must not be negative, and a heated contact must have a length")

    def wearing(self, rise_K: Array) -> Array:
        """Factors on the wear coefficient at rises of the temperature, of their shape."""
        return self._rate(self.wear_J_per_mol, rise_K)

    def oxidising(self, rise_K: Array) -> Array:
        """Factors on the consumption of oxygen at rises of the temperature, of their shape."""
        return self._rate(self.oxidation_J_per_mol, rise_K)

    def friction_factor(self, rise_K: Array) -> Array:
        """Factors on the coefficient of friction at rises of the temperature, at least 0."""
        return np.maximum(1.0 + self.friction_per_K * rise_K, 0.0)

    def _rate(self, energy_J_per_mol: float, rise_K: Array) -> Array:
        cold = self.surroundings_K
        return np.asarray(np.exp(energy_J_per_mol / GAS_CONSTANT * (1.0 / cold - 1.0 / (cold + rise_K))))
