"""Friction laws: which tangential traction a contact transmits at most before it slides, at the pressure on it.

Newton's method asks a law for its limit and for the limit's derivative by the pressure; friction work is the limit
times the slip. A law of sliding speed or of history gives a factor on the coefficient of friction at every node.

A law is one class, named in `LIBRARY` below, or in the entry point group "wirewear.friction_laws" of an installed
package; a study chooses it by its name.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from typing import ClassVar, Protocol

import numpy as np

from geometry.arrays import Array, IntArray
from solvers.laws.local_state import LocalState
from solvers.laws.plugins import law_called, laws_by_name, require_positive

# Local coefficients have settled when they change by no more than this share of the largest.
_SETTLED = 1e-4


#: Entry point group in which a package names its subclasses of `FrictionLaw`.
ENTRY_POINT_GROUP = "wirewear.friction_laws"
_SMALLEST_PRESSURE = 1e-3  # Of the reference: below it powers of the pressure stay nearly as they are.


@dataclass(frozen=True)
class FrictionLaw(ABC):
    """A law as a study describes it: its parameters are the fields of a frozen dataclass.

    The coefficient of friction is no parameter of the law but an argument, for tests and effects change it: what the
    limit is proportional to, a number or one for each of the k nodes, (k,).
    """

    name: ClassVar[str]  #: By which studies choose it.
    #: Whether the limit is the coefficient times the pressure; it is then not computed again.
    proportional: ClassVar[bool] = False
    timed: ClassVar[bool] = False  #: Whether the factor follows the speed.
    #: Whether it follows what surfaces have been through: cycles differ without any wear.
    remembers: ClassVar[bool] = False
    ages: ClassVar[bool] = False  #: Whether the factor follows the number of cycles done.

    def factor(self, local: LocalState, /) -> float | Array:  # noqa: ARG002 - most laws ask for nothing
        """Factor on the coefficient of friction, one for all nodes or one for each, (k,); not negative."""
        return 1.0

    @abstractmethod
    def limit(self, friction: float | Array, pressure_MPa: Array, /) -> Array:
        """Largest tangential traction (k,), MPa, under pressures of at least 0."""

    @abstractmethod
    def derivative(self, friction: float | Array, pressure_MPa: Array, /) -> Array:
        """Derivative (k,) of the limit by the pressure; not negative."""


@dataclass(frozen=True)
class Coulomb(FrictionLaw):
    """Amontons' and Coulomb's law: friction in proportion to the pressure."""

    name: ClassVar[str] = "coulomb"
    proportional: ClassVar[bool] = True

    def limit(self, friction: float | Array, pressure_MPa: Array, /) -> Array:
        """Coefficient times pressure."""
        return friction * pressure_MPa

    def derivative(self, friction: float | Array, pressure_MPa: Array, /) -> Array:
        """The coefficient."""
        return np.full_like(pressure_MPa, friction)


class Within(Protocol):
    """How pressure is spread within the elements about k nodes; see `WithinElements`."""

    def among(self, chosen: slice | IntArray, /) -> "Within":
        """How pressure is spread about the chosen nodes alone."""

    def share(self, friction: "Friction", /) -> float | Array:
        """What a law's limit is over that by nodes' pressures alone, one or (k,)."""


@dataclass(frozen=True)
class Friction:
    """A law with a coefficient of friction, one or (k,), as the contact's equations see it; tractions are those on the
    surface.
    """

    coefficient: float | Array
    law: FrictionLaw = field(default_factory=Coulomb)
    #: How the pressure is spread between nodes, of whose own a law that bends with it would know too little.
    within: "Within | None" = None
    #: What is known of the k nodes, for laws of wear as well; None where nothing is.
    local: LocalState | None = field(default=None, compare=False, repr=False)

    @cached_property
    def share(self) -> float | Array:
        """Factor on the limit, one or (k,), by which it is the law's integral over elements."""
        return 1.0 if self.within is None or self.law.proportional else self.within.share(self)

    @property
    def none(self) -> bool:
        each = self.coefficient
        return not each.any() if isinstance(each, np.ndarray) else each == 0.0

    def among(self, chosen: slice | IntArray) -> "Friction":
        """The law at some of the k nodes."""
        each = self.coefficient
        within = None if self.within is None else self.within.among(chosen)
        local = None if self.local is None else self.local.among(chosen)
        coefficient = each[chosen] if isinstance(each, np.ndarray) else each
        return replace(self, coefficient=coefficient, within=within, local=local)

    def differs(self, other: "Friction") -> bool:
        """Whether coefficients are others by more than `_SETTLED` of the largest."""
        now, then = self.coefficient, other.coefficient
        if isinstance(now, float) and isinstance(then, float):
            return abs(now - then) > _SETTLED * now
        return bool(np.max(np.abs(now - then), initial=0.0) > _SETTLED * np.max(now, initial=0.0))

    def change_since(self, other: "Friction", load: Array) -> float:
        """Half the mean difference of local coefficients over their mean, weighted by (k,); 0 where one is for all."""
        now, then = self.coefficient, other.coefficient
        if isinstance(now, float) or isinstance(then, float):
            return 0.0
        return float(load @ np.abs(now - then)) / max(float(load @ (now + then)), 1e-300)

    def limit(self, pressure_MPa: Array) -> Array:
        """Largest tangential traction (k,) at pressures (k,), MPa; none under tension, which Newton may try."""
        return self.share * self.law.limit(self.coefficient, np.maximum(pressure_MPa, 0.0))

    def derivative(self, pressure_MPa: Array) -> Array:
        """Derivative (k,) of the limit by the pressure, under tension that at no pressure."""
        return self.share * self.law.derivative(self.coefficient, np.maximum(pressure_MPa, 0.0))

    def tangent(self, pressure_MPa: Array) -> tuple[Array, Array]:
        """The limit's straight tangent: its slope (k,), and its value (k,) extrapolated to no pressure."""
        if self.law.proportional:
            return np.full_like(pressure_MPa, self.coefficient), np.zeros_like(pressure_MPa)
        slope, pressure = self.derivative(pressure_MPa), np.maximum(pressure_MPa, 0.0)
        return slope, self.limit(pressure) - slope * pressure


@dataclass(frozen=True)
class ShearLimited(FrictionLaw):
    """tau = k (1 - exp(-mu p / k)): Coulomb's law at low pressure, the shear strength k at high.

    Usui & Shirakashi, Mechanics of machining, from descriptive to predictive theory, ASME PED 7 (1982) 13. At high
    pressure asperities merge and the real area of contact can grow no more.

    shear_strength_MPa: k, of the softer surface or of the film on it.
    Raises SolverError if the strength is not positive.
    """

    name: ClassVar[str] = "shear-limited"

    shear_strength_MPa: float

    def __post_init__(self) -> None:
        require_positive(self, "shear_strength_MPa")

    def limit(self, friction: float | Array, pressure_MPa: Array, /) -> Array:
        """Coefficient times pressure, bent towards the shear strength."""
        return -self.shear_strength_MPa * np.expm1(-friction * pressure_MPa / self.shear_strength_MPa)

    def derivative(self, friction: float | Array, pressure_MPa: Array, /) -> Array:
        """The coefficient, which dies away with the pressure."""
        return friction * np.exp(-friction * pressure_MPa / self.shear_strength_MPa)


@dataclass(frozen=True)
class PowerOfPressure(FrictionLaw):
    """tau = mu p_0 (p / p_0)^n: n = 2/3 is a single elastic asperity (Archard, Proc. R. Soc. A 243 (1957) 190), n = 1
    Coulomb's law. Raises SolverError if either parameter is not positive.

    p + epsilon, with epsilon a thousandth of p_0 and both added as squares, stands for p in the coefficient, so that
    the limit's slope is finite where p vanishes: 1e-5 too little friction at a tenth of p_0 and n = 2/3.
    """

    name: ClassVar[str] = "power-of-pressure"

    reference_pressure_MPa: float  #: p_0, at which the coefficient of friction is that of the study.
    exponent: float  #: n.

    def __post_init__(self) -> None:
        require_positive(self, "reference_pressure_MPa", "exponent")

    def limit(self, friction: float | Array, pressure_MPa: Array, /) -> Array:
        """Coefficient times pressure, both the coefficient at p_0 times a power."""
        return friction * pressure_MPa * power_of_pressure(pressure_MPa, self.reference_pressure_MPa, self.exponent - 1)

    def derivative(self, friction: float | Array, pressure_MPa: Array, /) -> Array:
        """N times the coefficient but for the smallest pressures."""
        bent = bend_of_power(pressure_MPa, self.reference_pressure_MPa, self.exponent - 1)
        coefficient = power_of_pressure(pressure_MPa, self.reference_pressure_MPa, self.exponent - 1)
        return friction * coefficient * (1.0 + bent)


def power_of_pressure(pressure_MPa: Array, reference_MPa: float, exponent: float) -> Array:
    """(p / p_0) to the power, finite where p vanishes."""
    return np.asarray(np.hypot(pressure_MPa / reference_MPa, _SMALLEST_PRESSURE) ** exponent)


def bend_of_power(pressure_MPa: Array, reference_MPa: float, exponent: float) -> Array:
    """P times the logarithmic derivative of `power_of_pressure`: the exponent but for the smallest pressures."""
    ratio = pressure_MPa / reference_MPa
    return np.asarray(exponent * (ratio / np.hypot(ratio, _SMALLEST_PRESSURE)) ** 2)


@dataclass(frozen=True)
class Rate(Coulomb):
    """mu = mu_k + (mu_s - mu_k) exp(-|v| / v_s): Stribeck's fall from static to kinetic friction.

    Bo & Pavelescu, Wear 82 (1982) 277. The study's coefficient is the static one. Newton's method takes the speed of
    the increment's own slip, repeated until friction has settled, at most six times. Behind a spring K it sticks and
    slips in steps shorter than P |dmu/dv| / K; longer ones damp that.
    Raises SolverError if the ratio is negative or the speed not positive.
    """

    name: ClassVar[str] = "rate"
    timed: ClassVar[bool] = True

    kinetic_ratio: float  #: mu_k / mu_s.
    speed_mm_per_s: float  #: v_s.

    def __post_init__(self) -> None:
        require_positive(self, "speed_mm_per_s", not_negative=("kinetic_ratio",))

    def factor(self, local: LocalState, /) -> Array:
        """1 at rest, the ratio at high speed."""
        faded = np.exp(-local.speed_mm_per_s / self.speed_mm_per_s)
        return np.asarray(self.kinetic_ratio + (1.0 - self.kinetic_ratio) * faded)


@dataclass(frozen=True)
class LogarithmicRate(Coulomb):
    """mu = mu_s (1 + c ln(1 + |v| / v_0)): friction that grows, or with a negative c falls, with the speed's logarithm.

    Dieterich, J. Geophys. Res. 84 (1979) 2161, in steady sliding; the 1 keeps it finite at rest. The coefficient never
    falls below 0. Raises SolverError if the speed is not positive.
    """

    name: ClassVar[str] = "logarithmic-rate"
    timed: ClassVar[bool] = True

    slope: float  #: c.
    speed_mm_per_s: float  #: v_0.

    def __post_init__(self) -> None:
        require_positive(self, "speed_mm_per_s")

    def factor(self, local: LocalState, /) -> Array:
        """1 at rest."""
        return np.maximum(1.0 + self.slope * np.log1p(local.speed_mm_per_s / self.speed_mm_per_s), 0.0)


@dataclass(frozen=True)
class RunningIn(Coulomb):
    """mu = mu_end + (mu - mu_end) exp(-e / e_0): every place runs in with the friction energy that it has taken.

    An exponential, for want of a law; e is the mean of both surfaces at a place. Within a cycle jump it is that of
    each stage, which keeps the jump's second order; single increments take that at their start.
    Raises SolverError if the ratio is negative or the energy not positive.
    """

    name: ClassVar[str] = "running-in"
    remembers: ClassVar[bool] = True

    final_ratio: float  #: mu_end over the study's coefficient.
    energy_mJ_per_mm2: float  #: e_0.

    def __post_init__(self) -> None:
        require_positive(self, "energy_mJ_per_mm2", not_negative=("final_ratio",))

    def factor(self, local: LocalState, /) -> Array:
        """1 on fresh surfaces, the ratio on those run in."""
        fresh = np.exp(-local.energy_mJ_per_mm2 / self.energy_mJ_per_mm2)
        return np.asarray(self.final_ratio + (1.0 - self.final_ratio) * fresh)


LIBRARY: tuple[type[FrictionLaw], ...] = (Coulomb, ShearLimited, PowerOfPressure, Rate, LogarithmicRate, RunningIn)


@cache
def friction_laws() -> Mapping[str, type[FrictionLaw]]:
    """Every law by its name: the library's, then those of installed packages.
    Raises SolverError if a package's entry point holds no law, or one whose name is taken.
    """
    return laws_by_name(ENTRY_POINT_GROUP, FrictionLaw, "friction law", LIBRARY)


def friction_law(name: str, parameters: Mapping[str, float]) -> FrictionLaw:
    """The law of that name with these parameters.
    Raises SolverError if there is none, or it has other parameters, or they cannot be.
    """
    return law_called(name, parameters, friction_laws(), "friction law")
