"""What an effect is: a small immutable object that changes exactly one seam of the model."""

from abc import ABC, abstractmethod
from dataclasses import asdict, dataclass, fields
from inspect import getdoc
from typing import Any, ClassVar, Generic, Literal, Self, TypeVar

from wirewear.base.errors import StudyError
from wirewear.base.quantity import shown
from wirewear.effects.chain import Chain, through_its_seam
from wirewear.effects.measurements import Answer, Measurement
from wirewear.effects.parameter import Parameter, Stated, plain
from wirewear.effects.seams import Age, Ageing, Seam

T = TypeVar("T")
Size = Literal["easy", "hard"]


@dataclass(frozen=True)
class Effect(ABC, Generic[T]):
    """An effect that the nominal model lacks; its fields are its parameters, each made by `parameter`.

    A subclass's docstring gives the physics and its source; the first line is its title.

    Raises:
        StudyError: a parameter is out of its range.
    """

    #: Name in files; unique.
    name: ClassVar[str]
    seam: ClassVar[Seam]
    #: What it does to loops, evolution and scars.
    signature: ClassVar[str]
    #: Names of effects with which one record can confuse it.
    confused_with: ClassVar[tuple[str, ...]]
    #: What further measurements would show if it were at work.
    answers: ClassVar[tuple[Answer, ...]] = ()
    #: Belief before looking beside that in other effects which a record cannot tell from it.
    prior_weight: ClassVar[float] = 1.0
    #: How far the fast model is off the full simulation with it, relative to the change that it makes.
    model_error: ClassVar[float] = 0.0
    #: What it follows over a test.
    ages: ClassVar[Ageing] = Ageing.BY_WEAR
    #: Whether it needs a test under load, not one held at a fixed approach.
    needs_load: ClassVar[bool] = False
    #: Whether it needs cycle jumps that know whole cycles: not the explicit update.
    needs_whole_cycles: ClassVar[bool] = False
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
        """The seam's description with the effect in it, when the test has come that far."""

    def foreseen(self, chain: Chain) -> Chain:
        """A test as fast models take it, with the effect in it: what it changes of its seam, unless it says otherwise.

        Raises:
            UnforeseenError: it changes something there that a chain does not hold.
        """
        return through_its_seam(self, chain)

    def recognised_between(self, first_cycle: float, last_cycle: float) -> bool:  # noqa: ARG002
        """Whether it does, between two cycles, what tells it from another effect; it does unless it says otherwise."""
        return True

    @classmethod
    def parameters(cls) -> dict[str, Parameter]:
        """Its parameters by name."""
        return {field.name: field.metadata["parameter"] for field in fields(cls) if "parameter" in field.metadata}

    @classmethod
    def choices(cls) -> dict[str, tuple[str, ...]]:
        """What is one of a few words, by name, each with its words."""
        return {field.name: field.metadata["choice"] for field in fields(cls) if "choice" in field.metadata}

    @classmethod
    def expected(cls) -> dict[str, Any]:
        """All that is believed of it before looking, as plain numbers: what it changes of an answer."""
        return {
            "prior_weight": cls.prior_weight,
            "model_error": cls.model_error,
            "forms": {name: asdict(described) for name, described in cls.forms().items()},
            "parameters": {name: asdict(described) for name, described in cls.parameters().items()},
        }

    @classmethod
    def considered_for(cls, contact: str) -> bool:
        """Whether a diagnosis of this kind of contact considers it."""
        return _meant(cls.contacts, contact)

    @classmethod
    def forms(cls, contact: str | None = None) -> dict[str, Parameter]:
        """Numbers in which its law may differ from its source's, of one kind of contact or of all."""
        known = [field for field in fields(cls) if "form" in field.metadata]
        return {one.name: one.metadata["form"] for one in known if _meant(one.metadata["contacts"], contact)}

    @classmethod
    def found_forms(cls, contact: str | None = None) -> dict[str, Parameter]:
        """Those of its forms that a fit looks for."""
        found = {field.name for field in fields(cls) if field.metadata.get("found", False)}
        return {name: described for name, described in cls.forms(contact).items() if name in found}

    @classmethod
    def answer_to(cls, measurement: Measurement) -> str:
        """What a measurement would show if this effect were at work; empty if that is not known."""
        return next((answer.text for answer in cls.answers if answer.measurement == measurement), "")

    @classmethod
    def title(cls) -> str:
        """What it is, in one line."""
        return (getdoc(cls) or cls.name).splitlines()[0].rstrip(".")

    @property
    def values(self) -> dict[str, float]:
        """Its parameters' values by name; infinite for rigid."""
        return {name: getattr(self, name) for name in self.parameters()}

    @classmethod
    def neutral(cls, stated: Stated) -> Self:
        """The effect at such values that it changes nothing in a study that states these numbers."""
        known = {name: item.beside(stated) for name, item in cls.parameters().items()}
        return cls(**{name: item.easy if item.neutral is None else item.neutral for name, item in known.items()})

    @classmethod
    def sized(cls, size: Size, stated: Stated) -> Self:
        """The effect at a size that is easy or hard to see in a study that states these numbers."""
        return cls(**{name: getattr(item.beside(stated), size) for name, item in cls.parameters().items()})

    def table(self) -> dict[str, Any]:
        """The `[[effects]]` table that gives this effect."""
        numbers = {name: plain(value) for name, value in self.values.items()}
        words = {name: getattr(self, name) for name, known in self.choices().items() if getattr(self, name) != known[0]}
        return {"name": self.name, **numbers, **words}


def _meant(contacts: tuple[str, ...], contact: str | None) -> bool:
    """Whether one kind of contact is among those named, of which none are all; None stands for any."""
    return contact is None or not contacts or contact in contacts
