"""What a case changes in a finite element run: the library's effects, causes of no library, and a repeat's specimens.

What is read of a run alone is not among it: see `readings`. All else enters at the seams of effects, so that the meshes
are those of the nominal test if the scar fits on them.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from solvers import Holder
from studies.blind.causes import SETS, all_causes, causes_of
from studies.blind.causes.cause import AgeingHolder, Cause, FrictionFactor, LoadFactor, ReadingOfTest, WearChange
from studies.blind.generators.ageing import Constant, Factor
from studies.blind.generators.cases import TrueEffect
from studies.blind.generators.nominal import Nominal
from studies.blind.generators.nuisances import SpecimenDraw
from studies.blind.generators.signals import Instrument
from wirewear.effects import Age, ContactLaw, Effect, Loading, Seam, effect_named

#: The effect that every run of wires has, for specimens are never mounted at the same angle.
ANGLE = "crossing_angle_error"

#: The parts that a run has; causes of other parts are the independent model's alone.
_PARTS = (ReadingOfTest, FrictionFactor, LoadFactor, WearChange, AgeingHolder)

#: Sets that may be drawn: the half for development is drawn of the independent model alone.
DRAWN_SETS = tuple(name for name in SETS if name != "development")


@dataclass(frozen=True)
class FrictionTimes(Effect[ContactLaw]):
    """Friction times a factor that follows the cycles."""

    name = "friction_times"
    seam = Seam.CONTACT
    signature = "the loop's height changes over the cycles"
    confused_with = ()

    factor: Factor

    def changed(self, described: ContactLaw, age: Age) -> ContactLaw:
        """The law with the friction of that cycle."""
        return replace(described, friction=self.factor.at(age.cycles) * described.friction)


@dataclass(frozen=True)
class LoadTimes(Effect[Loading]):
    """The load times a factor that follows the cycles."""

    name = "load_times"
    seam = Seam.LOADING
    signature = "both forces change over the cycles"
    confused_with = ()

    factor: Factor

    def changed(self, described: Loading, age: Age) -> Loading:
        """The loading with the load of that cycle."""
        return replace(described, normal_load_N=self.factor.at(age.cycles) * described.normal_load_N)


@dataclass(frozen=True)
class WearChanged(Effect[Any]):
    """Other wear coefficients over the cycles."""

    name = "wear_changed"
    seam = Seam.WEAR
    signature = "scars are deeper or shallower"
    confused_with = ()

    cause: WearChange

    def changed(self, described: Any, age: Age) -> Any:
        """The coefficients of that cycle; the moving body is the lower one."""
        upper, lower = self.cause.rates(described.upper_mm3_per_mJ, described.lower_mm3_per_mJ, age.cycles)
        return replace(described, upper_mm3_per_mJ=upper, lower_mm3_per_mJ=lower)


@dataclass(frozen=True)
class HolderAged(Effect[Holder]):
    """A holder that gives way more, and has more play, over the cycles."""

    name = "holder_aged"
    seam = Seam.HOLDER
    signature = "loops lean, or have a shelf at no force, more and more"
    confused_with = ()

    cause: AgeingHolder

    def changed(self, described: Holder, age: Age) -> Holder:
        """The holder as it is by that cycle."""
        return replace(
            described,
            tangential_compliance_mm_per_N=described.tangential_compliance_mm_per_N + self.cause.mm_per_N(age.cycles),
            play_mm=described.play_mm + self.cause.play_mm(age.cycles),
        )


@dataclass(frozen=True)
class FrictionScatter(FrictionTimes):
    """One repeat's coefficient of friction over the mean, beside what effects have made of it."""

    name = "friction_scatter"


@dataclass(frozen=True)
class LoadScatter(LoadTimes):
    """One repeat's load over the mean."""

    name = "load_scatter"


@dataclass(frozen=True)
class WearScatter(Effect[Any]):
    """One repeat's wear coefficients over their mean."""

    name = "wear_scatter"
    seam = Seam.WEAR
    signature = "one repeat's scars are deeper or shallower"
    confused_with = ()

    factor: float

    def changed(self, described: Any, _age: Age) -> Any:
        """The rates times the factor."""
        return described.scaled(self.factor)


def outside_of(name: str) -> tuple[str, ...]:
    """The causes of a set that runs can have, in the order in which they are drawn."""
    own = tuple(cause for cause in causes_of(name) if issubclass(all_causes()[cause], _PARTS))
    # From the first batches on these two have stood the other way round than in the independent model.
    first = {"thermal_gain_drift": "debris_ejection", "debris_ejection": "thermal_gain_drift"}
    return tuple(first.get(cause, cause) for cause in own) if name == "first" else own


def causes_among(effects: Sequence[TrueEffect]) -> tuple[Cause, ...]:
    """Causes outside the diagnosis' library among a case's effects, made with their parameters."""
    return tuple(all_causes()[true.effect](**true.parameters) for true in effects if true.effect in all_causes())


def instruments_of(effects: Sequence[TrueEffect], nominal: Nominal) -> tuple[Instrument, ...]:
    """What reads a run otherwise than it is."""
    return tuple(cause.instrument(nominal) for cause in causes_among(effects) if isinstance(cause, ReadingOfTest))


def changes_of(effects: Sequence[TrueEffect], draw: SpecimenDraw) -> tuple[Effect[Any], ...]:
    """A case's effects and one repeat's specimens, but for what is read alone: see `readings`."""
    turned = draw.angle_deg + sum(true.parameters["angle_deg"] for true in effects if true.effect == ANGLE)
    return (
        *at_seams([true for true in effects if true.effect != ANGLE]),
        *at_seams([TrueEffect(ANGLE, {"angle_deg": turned})]),
        FrictionScatter(Constant(draw.friction)),
        LoadScatter(Constant(draw.load)),
        WearScatter(draw.wear),
    )


def at_seams(effects: Sequence[TrueEffect]) -> tuple[Effect[Any], ...]:
    """A case's effects as a run takes them, but for what is read alone."""
    known = [true for true in effects if true.effect not in all_causes()]
    found: list[Effect[Any]] = [effect_named(true.effect)(**true.parameters) for true in known]
    for cause in causes_among(effects):
        match cause:
            case FrictionFactor():
                found.append(FrictionTimes(cause))
            case LoadFactor():
                found.append(LoadTimes(cause))
            case WearChange():
                found.append(WearChanged(cause))
            case AgeingHolder():
                found.append(HolderAged(cause))
    return tuple(found)
