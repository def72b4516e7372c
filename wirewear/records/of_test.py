"""What files about a test are asked, of whatever kind of contact: mappings, and the tables of an experiment.toml."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

from pydantic import Field, PlainValidator

from wirewear.base.errors import RecordError
from wirewear.records.surfaces import WornSurfaces
from wirewear.study.keys import FORMAT, Table, checked_format, checked_text


class OfTest(Table):
    """What any file that describes a test is asked, of whatever kind of contact.

    Attributes:
        contact_kind: its name.
        body_names: of the one that is driven and the other.
        worn: how the worn surfaces stand in the record.
        needs_loops: whether there is no record without loops.
    """

    contact_kind: ClassVar[str]
    body_names: ClassVar[tuple[str, str]]
    worn: ClassVar[WornSurfaces]
    needs_loops: ClassVar[bool]

    format: Annotated[int, PlainValidator(checked_format)] = Field(
        description="version of the file's format", examples=[FORMAT]
    )
    name: Annotated[str, PlainValidator(checked_text)] = Field(
        description="title of the experiment", examples=["steel on steel, test 3"]
    )

    @property
    def length_mm(self) -> float | None:
        """Length of the contact, where it has one."""
        return None

    @property
    def depth_noise_um(self) -> float:
        """Stated error of one depth of a worn surface."""
        return 0.0

    @classmethod
    def require_length(cls, length_mm: float | None, label: str) -> None:
        """See that a length is given of a contact that has one alone; RecordError otherwise."""
        if length_mm:
            raise RecordError(f"--length does not apply to {label}, which is a run of {cls.contact_kind}.")

    def require_whole(self, where: str) -> None:
        """See that the tables of a file say all that they must; RecordError where they do not."""

    def placed(self, surface: Any) -> Any:
        """A surface of a file with x along the motion."""
        return surface


class OfRecord(OfTest, ABC):
    """What the tables of an experiment.toml are asked besides: how a study and a result of the kind say the same."""

    @property
    @abstractmethod
    def wear(self) -> Mapping[str, tuple[str, ...]]:
        """Coefficients of wear per friction energy by their keys in `[stated]`, with the bodies that wear by each."""

    @property
    @abstractmethod
    def shares(self) -> Mapping[str, float]:
        """Parts of the worn volume that either body loses, as is stated."""

    @classmethod
    @abstractmethod
    def bodies_of(cls, study: Mapping[str, Any], label: str, length_mm: float | None) -> dict[str, Any]:
        """Tables of the bodies and what touches, of a resolved study as results hold it; `label` names it in messages.
        Raises RecordError if a record cannot describe them.
        """

    @classmethod
    def stated_by(cls, study: Mapping[str, Any], length_mm: float | None) -> dict[str, Any]:
        """What such a study says of conditions, friction, wear and rig, of the whole contact, by keys of a record."""
        del length_mm  # of a line contact alone
        parts = ("conditions", "contact", "wear", "holder")
        return {key: value for part in parts for key, value in (study.get(part) or {}).items()}

    @classmethod
    @abstractmethod
    def study_of(cls, data: Mapping[str, Any], where: str) -> Any:
        """A study of the kind from nested tables; StudyError in one sentence that names `where`."""

    @property
    @abstractmethod
    def of_study(self) -> dict[str, float | None]:
        """What tells this test from others, by the keys of a study's tables."""

    def for_study(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Values by keys of a record as studies of the kind have them."""
        return dict(values)

    @abstractmethod
    def with_bodies(self, data: dict[str, Any]) -> dict[str, Any]:
        """Tables of a study with those of the bodies.
        Raises RecordError if what is stated of bodies and rig does not fit together.
        """

    @property
    def contact_stiffness_N_per_um(self) -> float | None:
        """Stiffness of the unworn contact; None where the bodies give way as well, by what no closed form tells."""
        return None

    @property
    def doubts_bodies(self) -> bool:
        """Whether the compliance between rig and contact is unsure."""
        return False
