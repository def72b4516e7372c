"""How well laws of pressure and of distance from the edge are integrated over a contact that few elements span."""

from dataclasses import dataclass, replace
from math import nan, pi, sqrt

import numpy as np

from geometry.arrays import Array
from solvers.between_nodes import SpreadPressure
from solvers.contact.problem import ContactProblem
from solvers.contact_state import ContactState
from solvers.friction_law import Coulomb
from solvers.wear_law import Archard, EnergyLaw


@dataclass(frozen=True)
class _SlidingCycle:
    """A cycle in which a contact slides with the drive, for laws of wear; see `WornCycle`."""

    edge_distance_mm: Array
    pressure_MPa: float
    power_density_W_per_mm2: float
    slip_amplitude_mm: float
    frequency_Hz: float


def law_error(problem: ContactProblem, pressed: ContactState) -> float:
    """Estimate of the relative error of friction and wear by the resolution of a pressed contact, from how well its
    edge is known; NaN by Coulomb's law with a wear coefficient that is one for all places.
    """
    wear, friction = problem.wear, problem.law
    alike = type(wear.law) in (EnergyLaw, Archard) and wear.oxygen is None
    if type(problem.friction_law) is Coulomb and (wear.none or alike):
        return nan
    spread = SpreadPressure.of(problem.primary.patch, pressed.traction[:, 2])
    laws = [friction] if wear.none else [friction, wear.law.work_per_slip(friction)]
    found = max(spread.law_error(law) for law in laws)
    return found if wear.none or not len(spread.pressure_MPa) else max(found, _factor_error(problem, spread))


def _factor_error(problem: ContactProblem, spread: SpreadPressure) -> float:
    """The same of the mean factor on wear, with the edge farther out and farther in."""
    weights = spread.pressure_MPa * spread.parts_mm2
    load, timing = float(weights.sum()), problem.timing
    amplitude, power = timing.drive.amplitude_mm, 4e-3 * problem.friction * load * timing.frequency_Hz
    cycle = _SlidingCycle(
        spread.edge_distance_mm, load / spread.area_mm2, power * timing.drive.amplitude_mm / spread.area_mm2,
        amplitude, timing.frequency_Hz,
    )  # fmt: skip
    off = spread.edge_error * sqrt(spread.area_mm2 / pi)
    less, more = (
        float(weights @ (np.zeros(len(weights)) + problem.wear.factor(replace(cycle, edge_distance_mm=distance))))
        for distance in (np.maximum(spread.edge_distance_mm - off, 0.0), spread.edge_distance_mm + off)
    )
    return abs(less - more) / max(less + more, 1e-300)
