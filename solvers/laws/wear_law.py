"""Wear laws: how much a surface recedes where a contact slides under pressure.

Energy law, V = alpha E locally (Fouvry et al., Wear 255 (2003) 287): a point that dissipates the friction energy e per
area recedes by alpha e. Archard's law, V = k P s locally (Archard, J. Appl. Phys. 24 (1953) 981): a point that slides s
under the pressure p recedes by k p s. Either way a point recedes by a wear coefficient times the wear work per area,
which is e or p s. Other laws weight wear work by pressure, by averages over the cycle, or by what the surface has been
through. A law is named in `LIBRARY`, or in the entry point group "wirewear.wear_laws" of an installed package; a study
chooses it by its name.
"""

from abc import ABC
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import ClassVar, Literal, Protocol

import numpy as np

from geometry.arrays import Array
from solvers.errors import SolverError
from solvers.laws.friction_law import Friction, FrictionLaw, bend_of_power, power_of_pressure
from solvers.laws.plugins import by_name, law_called, require_positive

#: Entry point group in which a package names its subclasses of `WearLaw`.
ENTRY_POINT_GROUP = "wirewear.wear_laws"


class WornCycle(Protocol):
    """The traced cycle that wears, as far as wear laws may depend on it. N counts places: samples within the pressed
    elements at all its positions, and as the last one what comes into contact only as it wears.
    """

    @property
    def edge_distance_mm(self) -> Array:
        """Distance (N,) of each place from the edge of the contact at its position of the cycle; 0 for the last one."""

    @property
    def pressure_MPa(self) -> float:
        """Mean pressure: mean load over the cycle divided by mean contact area."""

    @property
    def power_density_W_per_mm2(self) -> float:
        """Mean friction power over the cycle divided by mean contact area."""

    @property
    def slip_amplitude_mm(self) -> float:
        """Half of the slip in a stroke, averaged over the contact with the pressure as weight and over the strokes."""

    @property
    def frequency_Hz(self) -> float: ...

    @property
    def rise_K(self) -> float:
        """Mean rise of the temperature where friction heats the surfaces; 0 if that is not computed."""


@dataclass(frozen=True)
class WearLaw(ABC):
    """Base of wear laws; a law's parameters are the fields of a frozen dataclass."""

    name: ClassVar[str]  #: The name by which studies choose the law.
    #: Whether the bodies' wear coefficients are per friction energy or, by Archard, per load times sliding.
    coefficient: ClassVar[Literal["energy", "archard"]] = "energy"
    #: Whether `factor` depends on averages over the cycle, which single increments do not know.
    timed: ClassVar[bool] = False
    remembers: ClassVar[bool] = False  #: Whether `counted` depends on the friction energy so far.
    ages: ClassVar[bool] = False  #: Whether wear work is weighted by the number of cycles done.

    def work_per_slip(self, friction: Friction, /) -> Friction:
        """Wear work per area and length of slip, in MPa, as the limit of a friction law; by default the friction
        itself.

        `friction.local` is the local state of the nodes; a law that depends on it changes the coefficient.
        """
        return friction

    def factor(self, cycle: WornCycle, /) -> float | Array:  # noqa: ARG002 - most laws ask for nothing
        """Factor on the wear work of a cycle: one for all, or (N,) for the N places of `cycle.edge_distance_mm`."""
        return 1.0

    def counted(self, energy: Array, work: Array, /) -> Array:  # noqa: ARG002 - most laws ask for nothing
        """The part of `work` that wears a surface which has taken the friction energy `energy` so far; by default all.

        Both in mJ/mm², of the same shape.
        """
        return work


@dataclass(frozen=True)
class EnergyLaw(WearLaw):
    """The energy law: wear work is friction work."""

    name: ClassVar[str] = "energy"


@dataclass(frozen=True)
class Archard(WearLaw):
    """Archard's law: wear work is pressure times slip, independent of friction."""

    name: ClassVar[str] = "archard"
    coefficient: ClassVar[Literal["energy", "archard"]] = "archard"

    def work_per_slip(self, _friction: Friction, /) -> Friction:
        return Friction(1.0)


@dataclass(frozen=True)
class EnergyThreshold(WearLaw):
    """h = alpha (e - e_th): a place wears by the friction energy e that it takes beyond a threshold, its activation.

    Fouvry et al., Wear 255 (2003) 287. Exact in the energy, whatever the size of a cycle jump.

    threshold_mJ_per_mm2: e_th.  Raises SolverError if it is negative.
    """

    name: ClassVar[str] = "energy-threshold"
    remembers: ClassVar[bool] = True

    threshold_mJ_per_mm2: float

    def __post_init__(self) -> None:
        require_positive(self, not_negative=("threshold_mJ_per_mm2",))

    def counted(self, energy: Array, work: Array, /) -> Array:
        return np.asarray(np.clip(energy + work - self.threshold_mJ_per_mm2, 0.0, work))


@dataclass(frozen=True)
class PowerReduced(WearLaw):
    """h = alpha (p / p_0)^a (delta / delta_0)^b (f / 1 Hz)^c e: energy, weighted by powers of pressure, slip and
    frequency. Raises SolverError if a reference is not positive, or a is not above -1.

    Form: Baydoun, Fouvry, Descartes and Arnaud, Wear 426-427 (2019) 676, for flat contacts; here p is the local
    pressure, and delta the slip amplitude, averaged over the contact with the pressure as weight.
    """

    name: ClassVar[str] = "power-reduced"
    timed: ClassVar[bool] = True

    reference_pressure_MPa: float  #: p_0.
    reference_amplitude_um: float  #: delta_0.
    pressure_exponent: float = 0.0  #: a.
    amplitude_exponent: float = 0.0  #: b.
    frequency_exponent: float = 0.0  #: c.

    def __post_init__(self) -> None:
        require_positive(self, "reference_pressure_MPa", "reference_amplitude_um")
        if not self.pressure_exponent > -1.0:
            raise SolverError(f"pressure_exponent of the law {self.name!r} must be above -1: wear must not fall")

    def work_per_slip(self, friction: Friction, /) -> Friction:
        weighed = _Weighed(friction.law, self.reference_pressure_MPa, self.pressure_exponent)
        return replace(friction, law=weighed)

    def factor(self, cycle: WornCycle, /) -> float:
        amplitude = max(1e3 * cycle.slip_amplitude_mm / self.reference_amplitude_um, 1e-300)
        return float(amplitude**self.amplitude_exponent * cycle.frequency_Hz**self.frequency_exponent)


@dataclass(frozen=True)
class _Weighed(FrictionLaw):
    """Another friction law's limit times a power of the pressure."""

    name: ClassVar[str] = ""

    of: FrictionLaw
    reference_MPa: float
    exponent: float

    def limit(self, friction: float | Array, pressure_MPa: Array, /) -> Array:
        weight = power_of_pressure(pressure_MPa, self.reference_MPa, self.exponent)
        return self.of.limit(friction, pressure_MPa) * weight

    def derivative(self, friction: float | Array, pressure_MPa: Array, /) -> Array:
        weight = power_of_pressure(pressure_MPa, self.reference_MPa, self.exponent)
        bent = bend_of_power(pressure_MPa, self.reference_MPa, self.exponent)
        secant = self.of.limit(friction, pressure_MPa) / np.maximum(pressure_MPa, 1e-300)
        return weight * (self.of.derivative(friction, pressure_MPa) + bent * secant)


@dataclass(frozen=True)
class OxygenDistance(WearLaw):
    """Energy law with less wear beyond the distance d_O = d (f / 1 Hz)^m (p / 100 MPa)^n from the edge that oxygen
    reaches.

    p is the mean pressure. The default numbers are those of flats by Baydoun, Arnaud and Fouvry, Wear 458-459 (2020)
    203397. Raises SolverError if the distance is not positive or the factor negative.
    """

    name: ClassVar[str] = "oxygen-distance"
    timed: ClassVar[bool] = True

    starved_factor: float  #: Wear coefficient farther from the edge than d_O, over that nearer to it.
    distance_mm: float = 1.51  #: d.
    frequency_exponent: float = -0.22  #: m.
    pressure_exponent: float = -0.32  #: n.

    def __post_init__(self) -> None:
        require_positive(self, "distance_mm", not_negative=("starved_factor",))

    def reach_mm(self, frequency_Hz: float, pressure_MPa: float) -> float:
        """Distance d_O in mm from the contact's edge that oxygen reaches, at a frequency and a mean pressure."""
        pressure = max(0.01 * pressure_MPa, 1e-300)
        return float(self.distance_mm * frequency_Hz**self.frequency_exponent * pressure**self.pressure_exponent)

    def factor(self, cycle: WornCycle, /) -> Array:
        reach = self.reach_mm(cycle.frequency_Hz, cycle.pressure_MPa)
        return np.where(cycle.edge_distance_mm <= reach, 1.0, self.starved_factor)


LIBRARY: tuple[type[WearLaw], ...] = (EnergyLaw, Archard, EnergyThreshold, PowerReduced, OxygenDistance)


@cache
def wear_laws() -> Mapping[str, type[WearLaw]]:
    """Every wear law by its name: the library's, then those of installed packages.

    Raises SolverError if a package's entry point holds no wear law, or one whose name is taken.
    """
    return by_name(LIBRARY, ENTRY_POINT_GROUP, WearLaw, "wear law")


def wear_law(name: str, parameters: Mapping[str, float]) -> WearLaw:
    """Make the wear law of a name with its parameters.

    Raises SolverError if no law has this name, or if parameters are missing, unknown or out of range.
    """
    return law_called(name, parameters, wear_laws(), "wear law")
