"""Effects as immutable objects that change one seam of the model, and the chain in which fast models apply them.

A seam is a place in the model where effects enter, and its description an object that says what the model has there
(see `wirewear.effects.seams`). To a fast model a test is a chain in series: drive, free play and springs, contact,
sensors, at n moments of the test. A subclass of `Effect` changes the description of its seam by `changed`, and the
chain by `predicted`, by default by applying `changed` at every moment.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, fields, replace
from inspect import getdoc
from math import degrees, isnan, nan, pi, radians
from operator import attrgetter
from typing import Any, ClassVar, Generic, Literal, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Array
from solvers import Holder, WearRates
from wirewear.base.errors import StudyError, renamed
from wirewear.base.words import shown
from wirewear.effects.measurements import Answer, Measurement
from wirewear.effects.parameter import Parameter, Stated
from wirewear.effects.seams import Age, Ageing, ContactLaw, Control, Loading, Seam, Specimens
from wirewear.loops.sensor import Sensor

T = TypeVar("T")
Size = Literal["easy", "hard"]

_OF_SENSORS = (
    "displacement_gain", "linear_um_per_N", "quadratic_um_per_N2", "force_crosstalk", "lag_s", "force_lag_s",
)  # fmt: skip


class UnforeseenError(StudyError):
    """An effect changes a field of its seam's description that a chain does not hold: it needs its own `predicted`."""


@dataclass(frozen=True, eq=False)
class Chain:
    """A test of a contact at a point (crossed wires, a ball on a flat) at n moments, for fast models; arrays (n,)."""

    radius_um: float  #: Radius of the sphere (or the cylinder, of a line contact) that has the bodies' gap to a flat.
    fresh_area_um2: float  #: Area of the contact before any wear.
    cycles: Array  #: Cycles done.
    energy_J: Array  #: Friction energy dissipated.
    worn_um3: Array  #: Volume that both bodies together have lost.
    amplitude_um: Array  #: Displacement amplitude that the drive holds, NaN where it holds another figure.
    load_N: Array  #: Normal load before any wear.
    misalignment_rad: Array  #: Angle by which the motion rises out of the contact plane.
    friction: Array  #: Coefficient of friction.
    wear_um3_per_mJ: Array  #: Worn volume of both bodies together per friction energy.
    retained_fraction: Array  #: Share of the worn volume that stays in the scars as debris, 0 to 1.
    bed_MPa: Array  #: Modulus of the debris; zero for a rigid bed.
    oxygen_W: Array  #: Supply of oxygen, see `solvers.OxygenSupply`; 0 for enough everywhere.
    starved_factor: Array  #: Factor on wear where there is no oxygen.
    compliance_um_per_N: Array  #: Compliance in series with the contact along the motion.
    free_play_um: Array  #: Free play in series with it.
    mass_kg: Array  #: Mass that moves with the holder.
    flattening_um: Array  #: Approach of the wires by flattening before any wear.
    print_um: Array  #: Approach that pressing keeps where bodies yield; sliding prints on.
    rough_um: Array  #: Height of a layer of asperities that spreads the contact's pressures.
    bed_um: Array  #: Height of a layer of asperities that closes like a bed of debris.
    crossing_error_rad: Array  #: Deviation of the angle between the wires' axes from 90°.
    gain: Array  #: Errors of the sensors, as the next six: see `wirewear.loops.sensor.Sensor`.
    linear_um_per_N: Array
    quadratic_um_per_N2: Array
    crosstalk: Array
    lag_s: Array
    force_lag_s: Array
    force_zero_N: Array
    length_um: float = 0.0  #: Length of a line contact; zero for contacts at a point.
    frequency_Hz: float = 1.0

    @property
    def worn_area2_um4(self) -> Array:
        """(n,) square of the worn contact's area: π R V, with the worn volume V."""
        return pi * self.radius_um * self.worn_um3

    @property
    def area_um2(self) -> Array:
        """(n,) area of the contact, fresh and worn."""
        return np.sqrt(self.worn_area2_um4) + self.fresh_area_um2

    @property
    def edge_um(self) -> Array:
        """(n,) mean distance of places in the contact from its nearest edge: a third of a round contact's radius."""
        return np.asarray(np.sqrt(self.area_um2 / pi) / 3.0)

    @property
    def warming_per_um(self) -> Array:
        """(n,) mean rise of the temperature of an evenly heated contact at rest on a half-space, times the conductivity
        and over the power, in 1/µm: of a disc of area A, 8 / (3 π^(3/2) √A) (Carslaw & Jaeger, Conduction of Heat in
        Solids, 1959, § 10.5).
        """
        return np.asarray(8.0 / (3.0 * pi**1.5 * np.sqrt(self.area_um2)))

    def with_oxygen(self, supply_W: float, starved_factor: float) -> "Chain":
        """The chain with a supply of oxygen (see `solvers.OxygenSupply`): unchanged, since oxygen reaches every place
        in the scars of contacts at a point.
        """
        del supply_W, starved_factor
        return self

    @property
    def ages(self) -> list[Age]:
        """Age of the test at each of the n moments."""
        return [Age(n, energy) for n, energy in zip(self.cycles.tolist(), self.energy_J.tolist(), strict=True)]

    @classmethod
    def joined(cls, chains: Sequence["Chain"]) -> "Chain":
        """One chain with the moments of all chains (at least one), one after the other; radius, fresh area and length
        are those of the first.
        """
        columns: dict[str, Any] = {name: np.concatenate([getattr(chain, name) for chain in chains]) for name in COLUMNS}
        return replace(chains[0], **columns)

    def taken(self, moments: NDArray[np.intp]) -> "Chain":
        """The chain with the moments of these indices only."""
        return replace(self, **{name: getattr(self, name)[moments] for name in COLUMNS})


@dataclass(frozen=True, eq=False)
class LineChain(Chain):
    """A test of a line contact at n moments, for fast models."""

    @property
    def worn_area2_um4(self) -> Array:
        """(n,) square of the worn contact's area, (2 L w)², with w³ = 3 R V/(2 L)."""
        half_width = np.cbrt(1.5 * self.radius_um * self.worn_um3 / self.length_um)
        return np.asarray((2.0 * self.length_um * half_width) ** 2)

    @property
    def edge_um(self) -> Array:
        """(n,) as of any chain: half the half-width."""
        return np.asarray(0.25 * self.area_um2 / self.length_um)

    @property
    def warming_per_um(self) -> Array:
        """(n,) as of any chain: the mean over a rectangle."""
        long, wide = self.length_um, self.area_um2 / self.length_um
        ends = (long**3 + wide**3 - np.hypot(long, wide) ** 3) / (3.0 * long * wide)
        return np.asarray((long * np.arcsinh(wide / long) + wide * np.arcsinh(long / wide) + ends) / (pi * long * wide))

    def with_oxygen(self, supply_W: float, starved_factor: float) -> Chain:
        supply, factor = (np.full_like(self.cycles, one) for one in (supply_W, starved_factor))
        return replace(self, oxygen_W=supply, starved_factor=factor)


#: Names of a chain's arrays.
COLUMNS = tuple(field.name for field in fields(Chain) if field.type not in (float, "float"))


@dataclass(frozen=True)
class _SeamView:
    """How columns of a chain correspond to a seam's description.

    described: makes a description from one row of the columns. row: makes a row from a description. unread: fields of
    the description that the columns do not hold.
    """

    columns: tuple[str, ...]
    unread: tuple[str, ...]
    described: Callable[..., Any]
    row: Callable[[Any], tuple[float, ...]]


def _other(description: type[Any], *read: str) -> tuple[str, ...]:
    """Names of all fields of a description except `read`."""
    return tuple(field.name for field in fields(description) if field.name not in read)


_VIEWS: dict[Seam, _SeamView] = {
    Seam.HOLDER: _SeamView(
        ("load_N", "compliance_um_per_N", "free_play_um", "mass_kg"),
        _other(
            Holder,
            "normal_load_N",
            "tangential_compliance_mm_per_N",
            "rotational_compliance_rad_per_N_mm",
            "pivot_height_mm",
            "play_mm",
            "mass_kg",
        ),
        lambda load, compliance, play, mass: Holder(
            load, tangential_compliance_mm_per_N=1e-3 * compliance, play_mm=1e-3 * play, mass_kg=mass
        ),
        lambda holder: (
            holder.normal_load_N,
            1e3 * holder.compliance_at_contact_mm_per_N,
            1e3 * holder.play_mm,
            holder.mass_kg,
        ),
    ),
    Seam.CONTACT: _SeamView(("friction",), _other(ContactLaw, "friction"), ContactLaw, lambda law: (law.friction,)),
    Seam.WEAR: _SeamView(
        ("wear_um3_per_mJ",),
        _other(WearRates, "upper_mm3_per_mJ", "lower_mm3_per_mJ"),
        lambda both: WearRates(0.5e-9 * both, 0.5e-9 * both),
        lambda rates: (1e9 * (rates.upper_mm3_per_mJ + rates.lower_mm3_per_mJ),),
    ),
    Seam.SPECIMENS: _SeamView(
        ("crossing_error_rad", "flattening_um"),
        _other(Specimens, "crossing_angle_deg", "flattening_mm"),
        lambda error, flattening: Specimens(90.0 + degrees(error), 1e-3 * flattening),
        lambda wires: (radians(wires.crossing_angle_deg - 90.0), 1e3 * wires.flattening_mm),
    ),
    Seam.DRIVE: _SeamView(
        ("amplitude_um",),
        (),
        lambda amplitude: Control(None if isnan(amplitude) else amplitude),
        lambda control: (nan if control.displacement_amplitude_um is None else control.displacement_amplitude_um,),
    ),
    Seam.LOADING: _SeamView(
        ("load_N", "misalignment_rad"),
        _other(Loading, "normal_load_N", "misalignment_rad"),
        Loading,
        lambda loading: (loading.normal_load_N, loading.misalignment_rad),
    ),
    Seam.SENSOR: _SeamView(
        ("gain", "linear_um_per_N", "quadratic_um_per_N2", "crosstalk", "lag_s", "force_lag_s"),
        _other(Sensor, *_OF_SENSORS),
        lambda *row: Sensor(**dict(zip(_OF_SENSORS, row, strict=True))),
        attrgetter(*_OF_SENSORS),
    ),
}


@dataclass(frozen=True)
class Effect(ABC, Generic[T]):
    """An effect that the nominal model lacks; its fields are its parameters, each made by `parameter`. T is the
    description that it changes.

    A subclass's docstring gives the physics and its source; the first line is its title. Raises StudyError if a
    parameter is out of its range.
    """

    #: Name in files; unique.
    name: ClassVar[str]
    seam: ClassVar[Seam]
    #: Changes of loops, evolution and scars by the effect, as a text for reports.
    signature: ClassVar[str]
    #: Names of effects with which one record can confuse it.
    confused_with: ClassVar[tuple[str, ...]]
    #: Answers of further measurements if the effect were the cause.
    answers: ClassVar[tuple[Answer, ...]] = ()
    #: Advice for the rig, or for the record, if the effect is the cause.
    remedy: ClassVar[str] = ""
    #: Prior probability relative to other effects that a record cannot distinguish from this one.
    prior_weight: ClassVar[float] = 1.0
    #: Error of the fast model against the full simulation with this effect, relative to the change that it makes.
    model_error: ClassVar[float] = 0.0
    #: By how much laws of the effect differ in any place of the loops, relative to its largest change of them.
    law_error: ClassVar[float] = 0.0
    #: Whether the effect's strength depends on the cycles or on wear.
    ages: ClassVar[Ageing] = Ageing.BY_WEAR
    #: Whether it needs a test under load, and is refused at a fixed approach.
    needs_load: ClassVar[bool] = False
    #: Whether it needs the implicit wear update, which knows averages over a cycle.
    needs_whole_cycles: ClassVar[bool] = False
    #: Whether a diagnosis considers it only of records whose scars were measured.
    needs_scars: ClassVar[bool] = False
    #: Whether a diagnosis considers it only where the drive is stated to hold another figure than its amplitude.
    of_held_drives: ClassVar[bool] = False
    #: The kinds of contact of which a diagnosis considers it; all where there are none.
    contacts: ClassVar[tuple[str, ...]] = ()

    def __post_init__(self) -> None:
        for name, described in self.parameters().items():
            try:
                object.__setattr__(self, name, described.checked(getattr(self, name)))
            except ValueError as problem:
                raise StudyError(f"{name} of {self.name} {problem}") from None
        for name, words in self.choices().items():
            if (word := getattr(self, name)) not in words:
                known = " or ".join(f'"{one}"' for one in words)
                raise StudyError(f"{name} of {self.name} is {shown(word)}, but must be {known}")

    @abstractmethod
    def changed(self, described: T, age: Age) -> T:
        """A description of the effect's seam as `described`, but with this effect in it, at an age of the test."""

    def predicted(self, chain: Chain) -> Chain:
        """The chain with this effect in it, for fast models; by default by `changed` at every moment.

        Raises UnforeseenError if it changes a field of its seam's description that a chain does not hold.
        """
        view = _VIEWS[self.seam]
        columns = np.stack([getattr(chain, name) for name in view.columns], axis=1)
        once = self.ages is Ageing.NEVER and bool((columns == columns[0]).all())
        rows, ages = (columns[:1], chain.ages[:1]) if once else (columns, chain.ages)
        changed = []
        for row, age in zip(rows.tolist(), ages, strict=True):
            before = view.described(*row)
            after = self.changed(before, age)
            if any(getattr(after, name) != getattr(before, name) for name in view.unread):
                raise UnforeseenError(
                    f"{self.name} changes something of the {self.seam} that fast models do not know: let its method "
                    "`predicted` say what it does to a chain."
                )
            changed.append(view.row(after))
        values = np.broadcast_to(np.array(changed), columns.shape)
        return replace(chain, **dict(zip(view.columns, values.T, strict=True)))

    def may_show(self, chain: Chain) -> bool:  # noqa: ARG002
        """False if an effect of this size does nothing in a test whose chain, with the effect in it, is `chain`."""
        return True

    def foreseen(self, chain: Chain) -> Chain:
        """The former name of `predicted`."""
        renamed("Effect.foreseen", "Effect.predicted")
        return self.predicted(chain)

    def __init_subclass__(cls) -> None:
        # Effects written for 1.0.0 say what they do to a chain by the method's former name.
        if "foreseen" in vars(cls):
            renamed(f"{cls.__name__}.foreseen", f"{cls.__name__}.predicted")
            cls.predicted = vars(cls)["foreseen"]  # type: ignore[method-assign]

    @classmethod
    def parameters(cls) -> dict[str, Parameter]:
        """The effect's parameters by name."""
        return {field.name: field.metadata["parameter"] for field in fields(cls) if "parameter" in field.metadata}

    @classmethod
    def choices(cls) -> dict[str, tuple[str, ...]]:
        """Fields that take one of several words, by name: for each its words, the first of which is the default."""
        return {field.name: field.metadata["choice"] for field in fields(cls) if "choice" in field.metadata}

    @classmethod
    def expected(cls) -> dict[str, object]:
        """Everything assumed about this effect before a record is seen, from which a diagnosis starts, as plain values
        for JSON: prior_weight, model_error, law_error, forms and parameters.
        """
        return {
            "prior_weight": cls.prior_weight,
            "model_error": cls.model_error,
            "law_error": cls.law_error,
            "forms": {name: asdict(described) for name, described in cls.forms().items()},
            "parameters": {name: asdict(described) for name, described in cls.parameters().items()},
        }

    @classmethod
    def considered_for(cls, contact: str, held: str) -> bool:
        """True if a diagnosis considers this effect for a kind of contact, one of `wirewear.base.kinds`.

        held: what the drive holds in place of its displacement, such as "slip"; empty if it holds that.
        """
        return _meant(cls.contacts, contact) and (bool(held) or not cls.of_held_drives)

    @classmethod
    def forms(cls, contact: str | None = None) -> dict[str, Parameter]:
        """Forms by name: numbers by which the effect's law may differ from its source's (see
        `wirewear.effects.parameter`), for one kind of contact, or with None for all.
        """
        known = [field for field in fields(cls) if "form" in field.metadata]
        return {one.name: one.metadata["form"] for one in known if _meant(one.metadata["contacts"], contact)}

    @classmethod
    def answer_to(cls, measurement: Measurement) -> str:
        """What a measurement would show if this effect were the cause, as part of a sentence; "" if not known."""
        return next((answer.text for answer in cls.answers if answer.measurement == measurement), "")

    @classmethod
    def title(cls) -> str:
        """The effect in one line: the first line of its docstring."""
        return (getdoc(cls) or cls.name).splitlines()[0].rstrip(".")

    @property
    def values(self) -> dict[str, float]:
        """The parameters' values by name; infinite where a file says "rigid"."""
        return {name: getattr(self, name) for name in self.parameters()}

    @classmethod
    def neutral(cls, stated: Stated) -> Self:
        """The effect with values at which it changes nothing.

        stated: numbers of a study by key, such as "contact.friction", of which some values are multiples.
        """
        known = {name: item.beside(stated) for name, item in cls.parameters().items()}
        return cls(**{name: item.easy if item.neutral is None else item.neutral for name, item in known.items()})

    @classmethod
    def sized(cls, size: Size, stated: Stated) -> Self:
        """The effect at a size that is "easy" or "hard" to see in a record.

        stated: numbers of a study by key, such as "contact.friction", of which some values are multiples.
        """
        every = cls.parameters().items()
        return cls(**{name: getattr(item.beside(stated), size) for name, item in every if not item.instead})

    def table(self) -> dict[str, object]:
        """The `[[effects]]` table that gives this effect: name, numbers, and chosen words that are not the default."""
        numbers = {name: known.plain(getattr(self, name)) for name, known in self.parameters().items()}
        words = {name: getattr(self, name) for name, known in self.choices().items() if getattr(self, name) != known[0]}
        return {"name": self.name, **numbers, **words}


#: An effect at any seam: `seam` says which description it changes.
AnyEffect = Effect[Any]


def _meant(contacts: tuple[str, ...], contact: str | None) -> bool:
    """True if `contact` is None or among `contacts`, of which an empty tuple means all."""
    return contact is None or not contacts or contact in contacts
