"""Tables and properties common to all files about a test, of whatever kind of contact."""

import sys
from abc import ABC, abstractmethod
from collections.abc import Mapping
from datetime import date
from typing import Annotated, Any, ClassVar, Literal, TypeVar, get_args

from pydantic import Field, PlainValidator

from wirewear.base.errors import RecordError
from wirewear.base.files import table_of
from wirewear.base.units import Quantity
from wirewear.base.words import shown
from wirewear.records.surfaces import WornSurfaces
from wirewear.test.bodies import StatedBodies
from wirewear.test.keys import FORMAT, Table, checked_format, checked_text, one_of
from wirewear.test.kinds import KINDS
from wirewear.test.lengths import Extent, extent_of
from wirewear.test.programme import CycleBlock

FRICTION_FORCE = "friction_force_N"  #: Key in `[stated]` of a joint's friction force.


class OfTest(Table):
    """Tables of a file that describes a test of any kind of contact: a record's or a mapping's."""

    of: ClassVar[type[StatedBodies]]  #: Class of the tables of its bodies.
    contact_kind: ClassVar[str]  #: Name of its kind of contact.
    body_names: ClassVar[tuple[str, ...]]
    worn: ClassVar[WornSurfaces]  #: Kind of worn surfaces in its records.
    needs_loops: ClassVar[bool]  #: True if a record must have loops.

    format: Annotated[int, PlainValidator(checked_format)] = Field(
        description="version of the file's format", examples=[FORMAT]
    )
    name: Annotated[str, PlainValidator(checked_text)] = Field(
        description="title of the experiment", examples=["steel on steel, test 3"]
    )

    @classmethod
    def known(cls, data: dict[str, object], where: str) -> dict[str, object]:
        """A file's tables with other spellings replaced by the keys of this class; `where` names the file in messages.
        Raises RecordError if something is stated twice.
        """
        del where
        return data

    @property
    def length_mm(self) -> float | None:
        return None

    @property
    def extent(self) -> Extent:
        """Extent of the contact across its motion: the length of a line contact, or the whole of a contact at a point;
        it converts figures that are computed per millimetre.
        """
        return extent_of(self.length_mm)

    @property
    def depth_noise_um(self) -> float:
        """Stated error in µm of one depth of a worn surface; 0 if unstated."""
        return 0.0

    @classmethod
    def length_of(cls, study: Mapping[str, object], asked_mm: float | None, label: str) -> float | None:
        """Length in mm of the contact for a record of a study's result: None for a contact at a point.

        asked_mm: length that the user gives, None or 0 for none. label: names the result in messages. Raises
        RecordError if a length is given for a contact at a point, or is missing for a line contact.
        """
        del study
        if asked_mm:
            raise RecordError(f"--length does not apply to {label}, which is a run of {cls.contact_kind}.")
        return None

    def require_whole(self, where: str) -> None:
        """Raise RecordError if the tables lack or contradict something; where: names the file in the message."""

    def placed(self, surface: Any) -> Any:
        """A worn surface of a record's file with x along the motion: here as it is; overridden where a file may state
        it in a body's own axes.
        """
        return surface


Model = TypeVar("Model", bound=OfTest)


def of_kinds(*models: type[Model]) -> dict[str, type[Model]]:
    """The class of tables for each kind of contact by its name: the first of `models` that states bodies as this kind
    does.
    """
    found: dict[str, type[Model]] = {}
    for kind in KINDS.values():
        model: Any = next(own for own in models if issubclass(kind.bodies, own.of))
        if model.__pydantic_generic_metadata__["parameters"]:
            model = model[kind.bodies]
            setattr(sys.modules[model.__module__], model.__name__, model)  # where it is found when it is sent
        model.contact_kind, model.body_names = kind.name, kind.body_names
        found[kind.name] = model
    return found


class OfRecord(OfTest, ABC):
    """Tables of an experiment.toml, with their conversion from and to a study of the same kind."""

    fitted_by_loops: ClassVar[bool] = False  #: True if loops alone give friction and rig.
    contact_slips: ClassVar[bool] = True  #: True if it has micro-slip as Mindlin's contact.

    programme: tuple[CycleBlock, ...] = Field((), description="blocks of cycles, repeated in turn up to the test's end")

    @property
    def predicted(self) -> str:
        """Beginning of a sentence on the prediction of the test by a study, such as "A simulation"."""
        return "A simulation"

    @property
    @abstractmethod
    def wear(self) -> Mapping[str, tuple[str, ...]]:
        """Keys in `[stated]` of wear coefficients per friction energy, each with the names of the bodies that wear by
        it.
        """

    @property
    @abstractmethod
    def shares(self) -> Mapping[str, float]:
        """Share of the worn volume that each body loses, by body."""

    @classmethod
    @abstractmethod
    def bodies_of(cls, study: Mapping[str, object], label: str) -> dict[str, object]:
        """Tables of bodies and contact from a resolved study; label: names it in messages. Raises RecordError if a
        record cannot describe them.
        """

    @classmethod
    def stated_by(cls, study: Mapping[str, object]) -> dict[str, object]:
        """Values by key of a study's conditions, friction, wear and rig."""
        parts = ("conditions", "contact", "wear", "holder")
        return {key: value for part in parts for key, value in table_of(study, part).items()}

    @property
    @abstractmethod
    def of_study(self) -> dict[str, float | None]:
        """The record's values by those keys of a study that identify a test; None for a value that is not stated."""

    @abstractmethod
    def with_bodies(self, data: dict[str, object]) -> dict[str, object]:
        """Tables `data` of a study with those of the bodies added. Raises RecordError if the statements on bodies and
        rig are not consistent.
        """

    @property
    def assumed(self) -> str:
        """Assumptions about the bodies as the end of a sentence, after a semicolon; "" if there are none."""
        return ""

    @property
    def contact_stiffness_N_per_um(self) -> float | None:
        """Tangential stiffness of the unworn contact in N/µm; None without a closed form."""
        return None

    @property
    def doubts_bodies(self) -> bool:
        """True if the compliance of the bodies between rig and contact is uncertain."""
        return False


def _checked_date(value: object) -> str:
    text = value.isoformat() if isinstance(value, date) else value
    try:
        return date.fromisoformat(text).isoformat() if isinstance(text, str) else str(date.fromisoformat(""))
    except ValueError:
        raise ValueError(f"is {shown(value)}, but must be a date such as 2026-11-22") from None


#: Where a record may come from: a rig, or a simulation that was read as a rig's sensors would.
Source = Literal["measured", "simulated"]

Text = Annotated[str, PlainValidator(checked_text)]
DateOfTest = Annotated[str, PlainValidator(_checked_date)]
Temperature = Annotated[float, PlainValidator(Quantity("1", -273.15, 2000.0))]
Humidity = Annotated[float, PlainValidator(Quantity("1", 0.0, 100.0))]
Hardness = Annotated[float, PlainValidator(Quantity("1", 1.0, 10_000.0))]
Roughness = Annotated[float, PlainValidator(Quantity("um", 0.0, 1000.0))]


class Metadata(Table):
    """Optional information on a test that no computation uses."""

    source: Annotated[Source, PlainValidator(one_of(*get_args(Source)))] | None = Field(
        None, description='whether the test was "measured" or "simulated"; unknown where nothing is said'
    )
    laboratory: Text | None = Field(None, description="who made the test")
    date: DateOfTest | None = Field(None, description="day of the test")
    licence: Text | None = Field(None, description="what others may do with the data")
    temperature_C: Temperature | None = Field(None, description="temperature of the surroundings in degrees Celsius")
    relative_humidity_percent: Humidity | None = Field(None, description="relative humidity of the air")
    atmosphere: Text | None = Field(None, description="gas about the contact")
    lubricant: Text | None = Field(None, description="lubricant; none where it is dry")
    hardness_HV: Hardness | None = Field(None, description="Vickers hardness of the specimens")
    roughness_Ra_um: Roughness | None = Field(None, description="arithmetic mean roughness of the specimens")
    cracks: Annotated[str, PlainValidator(one_of("found", "none"))] | None = Field(
        None, description='whether cracks were looked for and "found", or "none" were', examples=["none"]
    )
    comment: Text | None = Field(None, description="anything else")

    @property
    def lines(self) -> tuple[str, ...]:
        """Known metadata as lines "key: value"."""
        return tuple(f"{key}: {value}" for key, value in self.model_dump(exclude_none=True).items())
