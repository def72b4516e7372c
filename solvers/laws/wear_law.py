"""Wear laws: what wears, where a contact slides under pressure.

Energy law, V = alpha E locally (Fouvry et al., Wear 255 (2003) 287): a point that dissipates the friction energy e
per area recedes by alpha e. Archard's law, V = k P s locally (Archard, J. Appl. Phys. 24 (1953) 981): a point that
slides s under the pressure p recedes by k p s. Either way a point recedes by a coefficient times the wear work per
area. Other laws give wear work another weight, by the pressure, by what a cycle is like, or by what a surface has been
through.

A law is named in `LIBRARY`, or in the entry point group "wirewear.wear_laws" of an installed package; a study chooses
it by its name.
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
from solvers.laws.plugins import law_called, laws_by_name, require_positive

#: Entry point group in which a package names its subclasses of `WearLaw`.
ENTRY_POINT_GROUP = "wirewear.wear_laws"


class WornCycle(Protocol):
    """What a law may know of the cycle that wears, at N places within the elements of its positions."""

    @property
    def edge_distance_mm(self) -> Array:
        """Distance (N,) from the contact's edge of the same position."""

    @property
    def pressure_MPa(self) -> float:
        """Mean pressure: load over area, both as means over the cycle."""

    @property
    def power_density_W_per_mm2(self) -> float:
        """Friction power over the mean area."""

    @property
    def slip_amplitude_mm(self) -> float:
        """Half of what a stroke slides, as a mean over the load."""

    @property
    def frequency_Hz(self) -> float:
        """Cycles per second."""


@dataclass(frozen=True)
class WearLaw(ABC):
    """A law as a study describes it: its parameters are the fields of a frozen dataclass."""

    name: ClassVar[str]  #: By which studies choose it.
    #: Whether the bodies' wear coefficients are per friction energy or, by Archard, per load times sliding.
    coefficient: ClassVar[Literal["energy", "archard"]] = "energy"
    #: Whether it weighs work by what a cycle is like, which single increments do not know.
    timed: ClassVar[bool] = False
    remembers: ClassVar[bool] = False  #: Whether what counts of wear work depends on the friction energy so far.
    ages: ClassVar[bool] = False  #: Whether wear work counts by the number of cycles done.

    def work_per_slip(self, friction: Friction, /) -> Friction:
        """Wear work per area and length of slip, as the limit of a friction law: that of the friction.

        `friction.local` is what is known of the places; a law of a local field changes the coefficient by it.
        """
        return friction

    def factor(self, cycle: WornCycle, /) -> float | Array:  # noqa: ARG002 - most laws ask for nothing
        """Factor on the wear work of a cycle, one for all places or one for each, (N,)."""
        return 1.0

    def counted(self, energy: Array, work: Array, /) -> Array:  # noqa: ARG002 - most laws ask for nothing
        """What counts of wear work on a surface that has taken friction energy so far, both mJ/mm² of any shape."""
        return work


@dataclass(frozen=True)
class EnergyLaw(WearLaw):
    """The energy law: wear work is friction work."""

    name: ClassVar[str] = "energy"


@dataclass(frozen=True)
class Archard(WearLaw):
    """Archard's law: wear work is pressure times slip, whatever the friction."""

    name: ClassVar[str] = "archard"
    coefficient: ClassVar[Literal["energy", "archard"]] = "archard"

    def work_per_slip(self, _friction: Friction, /) -> Friction:
        """The pressure."""
        return Friction(1.0)


@dataclass(frozen=True)
class EnergyThreshold(WearLaw):
    """h = alpha (e - e_th): a place wears by what friction energy it takes beyond a threshold, its activation.

    Fouvry et al., Wear 255 (2003) 287. Exact in the energy, whatever the size of a cycle jump.

    threshold_mJ_per_mm2: e_th.  Raises SolverError if it is negative.
    """

    name: ClassVar[str] = "energy-threshold"
    remembers: ClassVar[bool] = True

    threshold_mJ_per_mm2: float

    def __post_init__(self) -> None:
        require_positive(self, not_negative=("threshold_mJ_per_mm2",))

    def counted(self, energy: Array, work: Array, /) -> Array:
        """The part of it beyond the threshold."""
        return np.asarray(np.clip(energy + work - self.threshold_mJ_per_mm2, 0.0, work))


@dataclass(frozen=True)
class PowerReduced(WearLaw):
    """h = alpha (p / p_0)^a (delta / delta_0)^b (f / 1 Hz)^c e: energy, weighed by powers of pressure, slip and
    frequency. Raises SolverError if a reference is not positive, or a is not above -1.

    Form: Baydoun, Fouvry, Descartes and Arnaud, Wear 426-427 (2019) 676, of flat contacts; here p is the local
    pressure, and delta the slip amplitude as a mean over the load.
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
        """The friction, weighed by the pressure."""
        weighed = _Weighed(friction.law, self.reference_pressure_MPa, self.pressure_exponent)
        return replace(friction, law=weighed)

    def factor(self, cycle: WornCycle, /) -> float:
        """By slip amplitude and frequency."""
        amplitude = max(1e3 * cycle.slip_amplitude_mm / self.reference_amplitude_um, 1e-300)
        return float(amplitude**self.amplitude_exponent * cycle.frequency_Hz**self.frequency_exponent)


@dataclass(frozen=True)
class _Weighed(FrictionLaw):
    """Another law's limit times a power of the pressure."""

    name: ClassVar[str] = ""

    of: FrictionLaw
    reference_MPa: float
    exponent: float

    def limit(self, friction: float | Array, pressure_MPa: Array, /) -> Array:
        weight = power_of_pressure(pressure_MPa, self.reference_MPa, self.exponent)
        return self.of.limit(friction, pressure_MPa) * weight

    def derivative(self, friction: float | Array, pressure_MPa: Array, /) -> Array:
        """By the product rule."""
        weight = power_of_pressure(pressure_MPa, self.reference_MPa, self.exponent)
        bent = bend_of_power(pressure_MPa, self.reference_MPa, self.exponent)
        secant = self.of.limit(friction, pressure_MPa) / np.maximum(pressure_MPa, 1e-300)
        return weight * (self.of.derivative(friction, pressure_MPa) + bent * secant)


@dataclass(frozen=True)
class OxygenDistance(WearLaw):
    """Energy, but less where oxygen does not get: it gets d_O = d (f / 1 Hz)^m (p / 100 MPa)^n from the contact's edge.

    p is the mean pressure. The numbers unless others are given are those of flats by Baydoun, Arnaud and
    Fouvry, Wear 458-459 (2020) 203397. Raises SolverError if the distance is not positive or the factor negative.
    """

    name: ClassVar[str] = "oxygen-distance"
    timed: ClassVar[bool] = True

    starved_factor: float  #: Wear coefficient beyond that distance over that within.
    distance_mm: float = 1.51  #: d.
    frequency_exponent: float = -0.22  #: m.
    pressure_exponent: float = -0.32  #: n.

    def __post_init__(self) -> None:
        require_positive(self, "distance_mm", not_negative=("starved_factor",))

    def reach_mm(self, frequency_Hz: float, pressure_MPa: float) -> float:
        """Distance from the contact's edge that oxygen gets."""
        pressure = max(0.01 * pressure_MPa, 1e-300)
        return float(self.distance_mm * frequency_Hz**self.frequency_exponent * pressure**self.pressure_exponent)

    def factor(self, cycle: WornCycle, /) -> Array:
        """1 where oxygen gets."""
        reach = self.reach_mm(cycle.frequency_Hz, cycle.pressure_MPa)
        return np.where(cycle.edge_distance_mm <= reach, 1.0, self.starved_factor)


LIBRARY: tuple[type[WearLaw], ...] = (EnergyLaw, Archard, EnergyThreshold, PowerReduced, OxygenDistance)


@cache
def wear_laws() -> Mapping[str, type[WearLaw]]:
    """Every law by its name: the library's, then those of installed packages.
    Raises SolverError if a package's entry point holds no law, or one whose name is taken.
    """
    return laws_by_name(ENTRY_POINT_GROUP, WearLaw, "wear law", LIBRARY)


def wear_law(name: str, parameters: Mapping[str, float]) -> WearLaw:
    """The law of that name with these parameters.
    Raises SolverError if there is none, or it has other parameters, or they cannot be.
    """
    return law_called(name, parameters, wear_laws(), "wear law")
