"""What a case changes in a finite element run: the library's effects, some from outside it, and a repeat's specimens.

What is read of a run alone, an instrument, is not among it: see `readings`. All else enters at the seams of effects, so
that the meshes are those of the nominal test if the scar fits on them.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import log, pi, prod, sin
from typing import Any, TypeVar

from studies.blind.generators import instruments
from studies.blind.generators.ageing import Film, Jump
from studies.blind.generators.cases import TrueEffect
from studies.blind.generators.finite_element.numbers import cycles_of, number
from studies.blind.generators.finite_element.withheld_changes import RESERVED, WITHHELD
from studies.blind.generators.instruments import UNSEEN as UNSEEN_INSTRUMENTS
from studies.blind.generators.nominal import Nominal
from studies.blind.generators.nuisances import SpecimenDraw
from studies.blind.generators.reserved_instruments import RESERVED as RESERVED_INSTRUMENTS
from studies.blind.generators.withheld_instruments import WITHHELD as WITHHELD_INSTRUMENTS
from wirewear.base.course import Course
from wirewear.effects import Age, ContactLaw, Effect, Loading, Seam, effect_named
from wirewear.loops.sensor import Sensor

T = TypeVar("T")

#: The effect that every run of wires has, for specimens are never mounted at the same angle.
ANGLE = "crossing_angle_error"


@dataclass(frozen=True)
class _Scatter(Effect[T]):
    """One repeat's departure from the mean, as a factor on whatever the effects have made of it."""

    signature = "one repeat differs from the others"
    confused_with = ()

    factor: float = number("value over its mean", 0.1, 10.0)


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

    factor: float = number("friction after the jump over that before", 0.1, 10.0)
    cycle_1: float = cycles_of("cycle of the first jump")
    cycle_2: float = cycles_of("cycle of the second jump")
    recovery_cycles: float = cycles_of("cycles after which 63 % of the jump is gone")

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

    gain_change: float = number("final change of the gain", -0.5, 0.5)
    cycles: float = cycles_of("cycles after which 63 % of the change has happened")

    def changed(self, described: Sensor, age: Age) -> Sensor:
        """The sensor with the gain of that cycle."""
        gain = Course(1.0, 1.0 + self.gain_change, self.cycles)
        return replace(described, displacement_gain=gain.at(age.cycles) * described.displacement_gain)


@dataclass(frozen=True)
class BreathingFriction(Effect[ContactLaw]):
    """Friction comes and goes over the test, as debris gathers and leaves."""

    name = "breathing_friction"
    seam = Seam.CONTACT
    signature = "the loop's height waves over the logarithm of the cycles"
    confused_with = ()

    share: float = number("largest relative change of the friction", 0.0, 0.9)
    folds: float = number("e-folds of the cycles after which it comes again", 0.1, 100.0)

    def changed(self, described: ContactLaw, age: Age) -> ContactLaw:
        """The law with the friction of that cycle."""
        wave = sin(2.0 * pi * log(max(age.cycles, 1.0)) / self.folds)
        return replace(described, friction=described.friction * (1.0 + self.share * wave))


@dataclass(frozen=True)
class SevereWear(Effect[Any]):
    """For some time in the middle of the test wear is severe, or nearly stops."""

    name = "severe_wear"
    seam = Seam.WEAR
    signature = "the scar is deeper or shallower"
    confused_with = ()

    factor: float = number("wear coefficient after its jump over that before", 0.01, 100.0)
    cycle: float = cycles_of("cycle of the jump")
    recovery_cycles: float = cycles_of("cycles after which 63 % of the jump is gone")

    def changed(self, described: Any, age: Age) -> Any:
        """The rates with what is left of the jump."""
        return described.scaled(Jump(self.cycle, self.factor, self.recovery_cycles).at(age.cycles))


@dataclass(frozen=True)
class FilmBreakthrough(Effect[ContactLaw]):
    """Wires wear through a film, of oxide or grease, under which friction is another."""

    name = "film_breakthrough"
    seam = Seam.CONTACT
    signature = "the loop's height steps up or down once"
    confused_with = ()

    share: float = number("of the friction that the film takes away", -2.0, 0.95)
    cycle: float = cycles_of("cycle at which half of the film is gone")
    abruptness: float = number("power of the cycles with which the film goes", 0.5, 50.0)

    def changed(self, described: ContactLaw, age: Age) -> ContactLaw:
        """The law with the friction on what is left of the film."""
        film = Film(self.share, self.cycle, self.abruptness)
        return replace(described, friction=described.friction * film.at(age.cycles))


@dataclass(frozen=True)
class RelaxingLoad(Effect[Loading]):
    """The spring of the load sets soon after it was tightened, and the load with it."""

    name = "relaxing_load"
    seam = Seam.LOADING
    signature = "forces fall at the start and stay"
    confused_with = ()

    loss: float = number("share of the load that is lost", 0.0, 0.95)
    cycles: float = cycles_of("cycles after which 63 % of the loss has happened")

    def changed(self, described: Loading, age: Age) -> Loading:
        """The loading with the load of that cycle."""
        left = Course(1.0, 1.0 - self.loss, self.cycles).at(age.cycles)
        return replace(described, normal_load_N=left * described.normal_load_N)


@dataclass(frozen=True)
class UnequalWear(Effect[Any]):
    """One wire is harder than the other, so that the other one wears more; both together wear as stated."""

    name = "unequal_wear"
    seam = Seam.WEAR
    signature = "one scar is deeper, the other one shallower"
    confused_with = ()

    moving_share: float = number("of the worn volume that the moving wire loses", 0.0, 1.0)

    def changed(self, described: Any, _age: Age) -> Any:
        """The rates, shared anew; the moving wire is the lower body."""
        both = described.upper_mm3_per_mJ + described.lower_mm3_per_mJ
        lower = self.moving_share * both
        return replace(described, upper_mm3_per_mJ=both - lower, lower_mm3_per_mJ=lower)


#: Effects of no library that finite element runs can have, and the one that is added to their readings.
SATURATION = "saturating_force_cell"
OUTSIDE: dict[str, type[Effect[Any]]] = {effect.name: effect for effect in (DebrisEjection, ThermalGainDrift)}


#: Instruments of the sealed half, from their parameters and the nominal test.
_SEALED_INSTRUMENTS: Mapping[str, Callable[[Mapping[str, float], Nominal], instruments.Instrument]] = {
    "force_cell_hysteresis": lambda p, _: instruments.ForceCellHysteresis(p["play_N"]),
    "creeping_force_zero": lambda p, _: instruments.CreepingForceZero(Course(0.0, p["zero_N"], p["cycles"])),
    "bent_displacement_sensor": lambda p, nominal: instruments.BentDisplacementSensor(p["bend"], nominal.amplitude_um),
}
#: Effects of the later sets at the seams of a run.
_LATER: dict[str, type[Effect[Any]]] = {
    **{effect.name: effect for effect in (BreathingFriction, SevereWear, FilmBreakthrough, RelaxingLoad, UnequalWear)},
    **WITHHELD,
    **RESERVED,
}
#: Instruments of the sets that were written without a look at any diagnosis.
_WRITTEN_BLIND: Mapping[str, Callable[[Mapping[str, float]], instruments.Instrument]] = {
    **UNSEEN_INSTRUMENTS,
    **WITHHELD_INSTRUMENTS,
    **RESERVED_INSTRUMENTS,
}

#: Causes of no library by the name of their set, in the order in which they are drawn.
OUTSIDE_SETS: Mapping[str, tuple[str, ...]] = {
    "first": (*OUTSIDE, SATURATION),
    "sealed": (*_SEALED_INSTRUMENTS, BreathingFriction.name, SevereWear.name),
    "unseen": (*UNSEEN_INSTRUMENTS, FilmBreakthrough.name, RelaxingLoad.name, UnequalWear.name),
    "withheld": (*WITHHELD_INSTRUMENTS, *WITHHELD),
    "reserved": (*RESERVED_INSTRUMENTS, *RESERVED),
}


def instruments_of(effects: Sequence[TrueEffect], nominal: Nominal) -> tuple[instruments.Instrument, ...]:
    """The instruments among a case's effects, but for a force cell that saturates."""
    sealed = [
        _SEALED_INSTRUMENTS[true.effect](true.parameters, nominal)
        for true in effects
        if true.effect in _SEALED_INSTRUMENTS
    ]
    blind = [_WRITTEN_BLIND[true.effect](true.parameters) for true in effects if true.effect in _WRITTEN_BLIND]
    return (*sealed, *blind)


def is_read_alone(effect: str) -> bool:
    """Whether an effect changes what is read of a run, and not the run."""
    return effect == SATURATION or effect in _SEALED_INSTRUMENTS or effect in _WRITTEN_BLIND


def changes_of(effects: Sequence[TrueEffect], draw: SpecimenDraw) -> tuple[Effect[Any], ...]:
    """A case's effects and one repeat's specimens, but for what is read alone: see `readings`."""
    found = [_effect(true) for true in effects if not is_read_alone(true.effect)]
    turned = draw.angle_deg + sum(true.parameters["angle_deg"] for true in effects if true.effect == ANGLE)
    return (
        *(effect for effect in found if effect.name != ANGLE),
        _effect(TrueEffect(ANGLE, {"angle_deg": turned})),
        FrictionScatter(factor=draw.friction),
        LoadScatter(factor=draw.load),
        WearScatter(factor=draw.wear),
    )


def _effect(true: TrueEffect) -> Effect[Any]:
    kind = OUTSIDE.get(true.effect) or _LATER.get(true.effect) or effect_named(true.effect)
    return kind(**true.parameters)
