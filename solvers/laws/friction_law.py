"""Friction laws: the largest tangential traction, the limit, that a contact transmits at a pressure before it slides.

Newton's method asks a law for its limit and for the limit's derivative with respect to pressure; friction work is the
limit times the slip. A law that depends on sliding speed or on history multiplies the coefficient of friction at every
node by a factor. A law is one class, named in `LIBRARY` below, or in the entry point group "wirewear.friction_laws" of
an installed package; a study chooses it by its name.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from typing import ClassVar, Protocol

import numpy as np

from geometry.arrays import Array, IntArray
from solvers.laws.local_state import LocalState
from solvers.laws.plugins import by_name, law_called, require_positive

# Local coefficients have settled when they change by no more than this share of the largest.
_SETTLED = 1e-4


#: Entry point group in which a package names its subclasses of `FrictionLaw`.
ENTRY_POINT_GROUP = "wirewear.friction_laws"
_SMALLEST_PRESSURE = 1e-3  # Of the reference: below it powers of the pressure stay nearly as they are.


@dataclass(frozen=True)
class FrictionLaw(ABC):
    """Base of friction laws; a law's parameters are the fields of a frozen dataclass.

    The coefficient of friction is not a parameter but an argument, since tests and effects change it. `friction` below
    is that coefficient, one number or one for each of k nodes, (k,); the limit is proportional to it at low pressure.
    """

    name: ClassVar[str]  #: The name by which studies choose the law.
    #: Whether the limit is the coefficient times the pressure; it is then not computed again.
    proportional: ClassVar[bool] = False
    timed: ClassVar[bool] = False  #: Whether the factor depends on the sliding speed.
    #: Whether the factor depends on the friction energy taken so far, so that cycles differ even without wear.
    remembers: ClassVar[bool] = False
    ages: ClassVar[bool] = False  #: Whether the factor depends on the number of cycles done.

    def factor(self, local: LocalState, /) -> float | Array:  # noqa: ARG002 - most laws ask for nothing
        """Factor (>= 0) on the coefficient of friction from the local state of k nodes: one for all, or (k,)."""
        return 1.0

    @abstractmethod
    def limit(self, friction: float | Array, pressure_MPa: Array, /) -> Array:
        """Largest tangential traction (k,) in MPa at pressures (k,) >= 0."""

    @abstractmethod
    def derivative(self, friction: float | Array, pressure_MPa: Array, /) -> Array:
        """Derivative (k,) of the limit with respect to pressure, >= 0."""


@dataclass(frozen=True)
class Coulomb(FrictionLaw):
    """Amontons' and Coulomb's law: tau = mu p."""

    name: ClassVar[str] = "coulomb"
    proportional: ClassVar[bool] = True

    def limit(self, friction: float | Array, pressure_MPa: Array, /) -> Array:
        return friction * pressure_MPa

    def derivative(self, friction: float | Array, pressure_MPa: Array, /) -> Array:
        return np.full_like(pressure_MPa, friction)


class Within(Protocol):
    """Pressure within the elements around k nodes, as `WithinElements` gives it."""

    def among(self, chosen: slice | IntArray, /) -> "Within":
        """The description of pressure at the nodes of these indices into the k."""

    def share(self, friction: "Friction", /) -> float | Array:
        """Integral of the law's limit over the elements around each node, over the sum by nodal pressures: one number
        or (k,).
        """


@dataclass(frozen=True)
class Friction:
    """A friction law with a coefficient of friction, one number or (k,), as the equations of contact use it at k nodes.

    Tractions and pressures are those on the surface, MPa.
    """

    coefficient: float | Array
    law: FrictionLaw = field(default_factory=Coulomb)
    #: How the pressure varies between nodes: nodal values alone do not suffice for a law that is not proportional.
    within: "Within | None" = None
    #: Local state of the k nodes, for laws of wear as well; None where nothing has slid (`ContactProblem.law`).
    local: LocalState | None = field(default=None, compare=False, repr=False)

    @cached_property
    def share(self) -> float | Array:
        """Factor on the limit, one number or (k,), that makes its nodal values add up to the integral over elements."""
        return 1.0 if self.within is None or self.law.proportional else self.within.share(self)

    @property
    def none(self) -> bool:
        each = self.coefficient
        return not each.any() if isinstance(each, np.ndarray) else each == 0.0

    def among(self, chosen: slice | IntArray) -> "Friction":
        """The friction at the nodes of these indices into the k."""
        each = self.coefficient
        within = None if self.within is None else self.within.among(chosen)
        local = None if self.local is None else self.local.among(chosen)
        coefficient = each[chosen] if isinstance(each, np.ndarray) else each
        return replace(self, coefficient=coefficient, within=within, local=local)

    def differs(self, other: "Friction") -> bool:
        """True if a coefficient differs from the other's by more than 1e-4 of the largest coefficient."""
        now, then = self.coefficient, other.coefficient
        if isinstance(now, float) and isinstance(then, float):
            return abs(now - then) > _SETTLED * now
        return bool(np.max(np.abs(now - then), initial=0.0) > _SETTLED * np.max(now, initial=0.0))

    def change_since(self, other: "Friction", load: Array) -> float:
        """Mean over nodes, weighted by `load` (k,), of the coefficients' absolute change since `other`, over their sum;
        0 where one coefficient holds for all nodes.
        """
        now, then = self.coefficient, other.coefficient
        if isinstance(now, float) or isinstance(then, float):
            return 0.0
        return float(load @ np.abs(now - then)) / max(float(load @ (now + then)), 1e-300)

    def limit(self, pressure_MPa: Array) -> Array:
        """Largest tangential traction (k,) in MPa at pressures (k,) in MPa; 0 under tension, which Newton may try."""
        return self.share * self.law.limit(self.coefficient, np.maximum(pressure_MPa, 0.0))

    def derivative(self, pressure_MPa: Array) -> Array:
        """Derivative (k,) of the limit with respect to pressure; under tension its value at zero pressure."""
        return self.share * self.law.derivative(self.coefficient, np.maximum(pressure_MPa, 0.0))

    def tangent(self, pressure_MPa: Array) -> tuple[Array, Array]:
        """Tangent of the limit at pressures (k,) in MPa: its slope (k,), and its value (k,) in MPa at zero pressure."""
        if self.law.proportional:
            return np.full_like(pressure_MPa, self.coefficient), np.zeros_like(pressure_MPa)
        slope, pressure = self.derivative(pressure_MPa), np.maximum(pressure_MPa, 0.0)
        return slope, self.limit(pressure) - slope * pressure


@dataclass(frozen=True)
class ShearLimited(FrictionLaw):
    """tau = k (1 - exp(-mu p / k)): Coulomb's law at low pressure, the shear strength k at high.

    Usui & Shirakashi, Mechanics of machining, from descriptive to predictive theory, ASME PED 7 (1982) 13. At high
    pressure asperities merge and the real area of contact can grow no more.

    shear_strength_MPa: k, of the softer surface or of the film on it. Raises SolverError if it is not positive.
    """

    name: ClassVar[str] = "shear-limited"

    shear_strength_MPa: float

    def __post_init__(self) -> None:
        require_positive(self, "shear_strength_MPa")

    def limit(self, friction: float | Array, pressure_MPa: Array, /) -> Array:
        return -self.shear_strength_MPa * np.expm1(-friction * pressure_MPa / self.shear_strength_MPa)

    def derivative(self, friction: float | Array, pressure_MPa: Array, /) -> Array:
        return friction * np.exp(-friction * pressure_MPa / self.shear_strength_MPa)


@dataclass(frozen=True)
class PowerOfPressure(FrictionLaw):
    """tau = mu p_0 (p / p_0)^n: n = 2/3 is a single elastic asperity (Archard, Proc. R. Soc. A 243 (1957) 190), n = 1
    Coulomb's law. Raises SolverError if either parameter is not positive.

    In the coefficient mu (p / p_0)^(n - 1), p is replaced by sqrt(p² + (p_0 / 1000)²), so that the slope stays finite
    at p = 0; at p_0 / 10 and n = 2/3 this makes friction too small by 1e-5.
    """

    name: ClassVar[str] = "power-of-pressure"

    reference_pressure_MPa: float  #: p_0, at which the coefficient of friction is that of the study.
    exponent: float  #: n.

    def __post_init__(self) -> None:
        require_positive(self, "reference_pressure_MPa", "exponent")

    def limit(self, friction: float | Array, pressure_MPa: Array, /) -> Array:
        return friction * pressure_MPa * power_of_pressure(pressure_MPa, self.reference_pressure_MPa, self.exponent - 1)

    def derivative(self, friction: float | Array, pressure_MPa: Array, /) -> Array:
        bent = bend_of_power(pressure_MPa, self.reference_pressure_MPa, self.exponent - 1)
        coefficient = power_of_pressure(pressure_MPa, self.reference_pressure_MPa, self.exponent - 1)
        return friction * coefficient * (1.0 + bent)


def power_of_pressure(pressure_MPa: Array, reference_MPa: float, exponent: float) -> Array:
    """(p / p_0)^exponent, of the pressures' shape, with p / p_0 replaced by sqrt((p / p_0)² + 1e-6), so that it is
    finite at p = 0.
    """
    return np.asarray(np.hypot(pressure_MPa / reference_MPa, _SMALLEST_PRESSURE) ** exponent)


def bend_of_power(pressure_MPa: Array, reference_MPa: float, exponent: float) -> Array:
    """Logarithmic derivative p / w dw/dp of w = `power_of_pressure`, (k,): the exponent, but 0 close to p = 0."""
    ratio = pressure_MPa / reference_MPa
    return np.asarray(exponent * (ratio / np.hypot(ratio, _SMALLEST_PRESSURE)) ** 2)


@dataclass(frozen=True)
class Rate(Coulomb):
    """mu = mu_k + (mu_s - mu_k) exp(-|v| / v_s): Stribeck's fall from static to kinetic friction.

    Bo & Pavelescu, Wear 82 (1982) 277. The study's coefficient is the static one. The speed is that of the increment's
    own slip; increments are repeated until friction has settled, at most six times. Behind a spring of stiffness K the
    contact sticks and slips if time steps are shorter than P |dmu/dv| / K; longer steps damp this.

    Raises SolverError if the ratio is negative or the speed not positive.
    """

    name: ClassVar[str] = "rate"
    timed: ClassVar[bool] = True

    kinetic_ratio: float  #: mu_k / mu_s.
    speed_mm_per_s: float  #: v_s.

    def __post_init__(self) -> None:
        require_positive(self, "speed_mm_per_s", not_negative=("kinetic_ratio",))

    def factor(self, local: LocalState, /) -> Array:
        faded = np.exp(-local.speed_mm_per_s / self.speed_mm_per_s)
        return np.asarray(self.kinetic_ratio + (1.0 - self.kinetic_ratio) * faded)


@dataclass(frozen=True)
class LogarithmicRate(Coulomb):
    """mu = mu_s (1 + c ln(1 + |v| / v_0)): friction that grows, or with a negative c falls, with the logarithm of
    speed.

    Dieterich, J. Geophys. Res. 84 (1979) 2161, for steady sliding; 1 + |v| / v_0 in place of |v| / v_0 keeps it finite
    at rest. The coefficient never falls below 0. Raises SolverError if the speed is not positive.
    """

    name: ClassVar[str] = "logarithmic-rate"
    timed: ClassVar[bool] = True

    slope: float  #: c.
    speed_mm_per_s: float  #: v_0.

    def __post_init__(self) -> None:
        require_positive(self, "speed_mm_per_s")

    def factor(self, local: LocalState, /) -> Array:
        return np.maximum(1.0 + self.slope * np.log1p(local.speed_mm_per_s / self.speed_mm_per_s), 0.0)


@dataclass(frozen=True)
class RunningIn(Coulomb):
    """mu = mu_end + (mu - mu_end) exp(-e / e_0): every place runs in with the friction energy e that it has taken.

    The exponential is assumed, not measured; e is the mean of both surfaces at a place. Within a cycle jump it is taken
    at each stage, which keeps the jump accurate to second order; single increments take it at their start.

    Raises SolverError if the ratio is negative or the energy not positive.
    """

    name: ClassVar[str] = "running-in"
    remembers: ClassVar[bool] = True

    final_ratio: float  #: mu_end over the study's coefficient.
    energy_mJ_per_mm2: float  #: e_0.

    def __post_init__(self) -> None:
        require_positive(self, "energy_mJ_per_mm2", not_negative=("final_ratio",))

    def factor(self, local: LocalState, /) -> Array:
        fresh = np.exp(-local.energy_mJ_per_mm2 / self.energy_mJ_per_mm2)
        return np.asarray(self.final_ratio + (1.0 - self.final_ratio) * fresh)


LIBRARY: tuple[type[FrictionLaw], ...] = (Coulomb, ShearLimited, PowerOfPressure, Rate, LogarithmicRate, RunningIn)


@cache
def friction_laws() -> Mapping[str, type[FrictionLaw]]:
    """Every friction law by its name: the library's, then those of installed packages.

    Raises SolverError if a package's entry point holds no friction law, or one whose name is taken.
    """
    return by_name(LIBRARY, ENTRY_POINT_GROUP, FrictionLaw, "friction law")


def friction_law(name: str, parameters: Mapping[str, float]) -> FrictionLaw:
    """Make the friction law of a name with its parameters.

    Raises SolverError if no law has this name, or if parameters are missing, unknown or out of range.
    """
    return law_called(name, parameters, friction_laws(), "friction law")
