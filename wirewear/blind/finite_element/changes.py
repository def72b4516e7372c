"""What a case changes in a finite element run: the library's effects, one from outside it, and a repeat's specimens.

All of it enters at the seams of effects, so that the meshes are those of the nominal test if the scar fits on them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import prod
from typing import Any, TypeVar

from wirewear.blind.cases import TrueEffect
from wirewear.blind.jump import Jump
from wirewear.blind.nuisances import SpecimenDraw
from wirewear.course import Course
from wirewear.effects import Age, ContactLaw, Effect, Loading, Quantity, Seam, effect_named, parameter
from wirewear.sensor import Sensor

T = TypeVar("T")

_ANGLE = "crossing_angle_error"


def _number(meaning: str, low: float, high: float) -> Any:
    return parameter(meaning, Quantity("1", low, high), neutral=None, easy=low, hard=low, interest=(low, high))


def _cycles(meaning: str) -> Any:
    return parameter(meaning, Quantity("cycles", 1.0, 1e9), neutral=None, easy=1.0, hard=1.0, interest=(1.0, 1e6))


@dataclass(frozen=True)
class _Scatter(Effect[T]):
    """One repeat's departure from the mean, as a factor on whatever the effects have made of it."""

    signature = "one repeat differs from the others"
    confused_with = ()

    factor: float = _number("value over its mean", 0.1, 10.0)


@dataclass(frozen=True)
class FrictionScatter(_Scatter[ContactLaw]):
    """One repeat's coefficient of friction."""

    name = "friction_scatter"
    seam = Seam.CONTACT

    def changed(self, described: ContactLaw, _age: Age) -> ContactLaw:
        """The law with its friction times the factor."""
        return replace(described, friction=self.factor * described.friction)


@dataclass(frozen=True)
class LoadScatter(_Scatter[Loading]):
    """One repeat's load."""

    name = "load_scatter"
    seam = Seam.LOADING

    def changed(self, described: Loading, _age: Age) -> Loading:
        """The loading with its load times the factor."""
        return replace(described, normal_load_N=self.factor * described.normal_load_N)


@dataclass(frozen=True)
class WearScatter(_Scatter[Any]):
    """One repeat's wear coefficient."""

    name = "wear_scatter"
    seam = Seam.WEAR

    def changed(self, described: Any, _age: Age) -> Any:
        """The rates times the factor."""
        return described.scaled(self.factor)


@dataclass(frozen=True)
class DebrisEjection(Effect[ContactLaw]):
    """Debris leaves the scar at once: friction jumps to a multiple and comes back over further cycles, twice."""

    name = "debris_ejection"
    seam = Seam.CONTACT
    signature = "jumps of the loop's height"
    confused_with = ()

    factor: float = _number("friction after the jump over that before", 0.1, 10.0)
    cycle_1: float = _cycles("cycle of the first jump")
    cycle_2: float = _cycles("cycle of the second jump")
    recovery_cycles: float = _cycles("cycles after which 63 % of the jump is gone")

    def changed(self, described: ContactLaw, age: Age) -> ContactLaw:
        """The law with what is left of both jumps."""
        jumps = (Jump(begun, self.factor, self.recovery_cycles) for begun in (self.cycle_1, self.cycle_2))
        return replace(described, friction=described.friction * prod(jump.at(age.cycles) for jump in jumps))


@dataclass(frozen=True)
class ThermalGainDrift(Effect[Sensor]):
    """The displacement sensor warms up, and its gain creeps to another value."""

    name = "thermal_gain_drift"
    seam = Seam.SENSOR
    signature = "loops are stretched ever more"
    confused_with = ("displacement_gain",)

    gain_change: float = _number("final change of the gain", -0.5, 0.5)
    cycles: float = _cycles("cycles after which 63 % of the change has happened")

    def changed(self, described: Sensor, age: Age) -> Sensor:
        """The sensor with the gain of that cycle."""
        gain = Course(1.0, 1.0 + self.gain_change, self.cycles)
        return replace(described, displacement_gain=gain.at(age.cycles) * described.displacement_gain)


#: Effects of no library that finite element runs can have, and the one that is added to their readings.
SATURATION = "saturating_force_cell"
OUTSIDE: dict[str, type[Effect[Any]]] = {effect.name: effect for effect in (DebrisEjection, ThermalGainDrift)}


def changes_of(effects: Sequence[TrueEffect], draw: SpecimenDraw) -> tuple[Effect[Any], ...]:
    """A case's effects and one repeat's specimens, but for a force cell that saturates: see `readings`."""
    found = [_effect(true) for true in effects if true.effect != SATURATION]
    turned = draw.angle_deg + sum(true.parameters["angle_deg"] for true in effects if true.effect == _ANGLE)
    return (
        *(effect for effect in found if effect.name != _ANGLE),
        _effect(TrueEffect(_ANGLE, {"angle_deg": turned})),
        FrictionScatter(factor=draw.friction),
        LoadScatter(factor=draw.load),
        WearScatter(factor=draw.wear),
    )


def _effect(true: TrueEffect) -> Effect[Any]:
    kind = OUTSIDE.get(true.effect) or effect_named(true.effect)
    return kind(**true.parameters)
