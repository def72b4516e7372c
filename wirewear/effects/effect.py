"""What an effect is: a small immutable object that changes exactly one seam of the model."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, fields
from inspect import getdoc
from typing import Any, ClassVar, Generic, Literal, Self, TypeVar

from wirewear.effects.parameter import Parameter, plain
from wirewear.effects.seams import Age, Seam
from wirewear.errors import StudyError

T = TypeVar("T")
Size = Literal["easy", "hard"]

#: Numbers that a study states, by their keys, such as "contact.friction".
Stated = Mapping[str, float]


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
    #: The measurement that tells them apart.
    split_by: ClassVar[str]
    #: Whether it needs a test under load, not one held at a fixed approach.
    needs_load: ClassVar[bool] = False

    def __post_init__(self) -> None:
        for name, described in self.parameters().items():
            try:
                object.__setattr__(self, name, described.checked(getattr(self, name)))
            except ValueError as problem:
                raise StudyError(f"{name} of {self.name} {problem}") from None

    @abstractmethod
    def changed(self, described: T, age: Age) -> T:
        """The seam's description with the effect in it, when the test has come that far."""

    @classmethod
    def parameters(cls) -> dict[str, Parameter]:
        """Its parameters by name."""
        return {field.name: field.metadata["parameter"] for field in fields(cls)}

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
        return cls(
            **{
                name: _value(item.easy if item.neutral is None else item.neutral, item, stated)
                for name, item in cls.parameters().items()
            }
        )

    @classmethod
    def sized(cls, size: Size, stated: Stated) -> Self:
        """The effect at a size that is easy or hard to see in a study that states these numbers."""
        return cls(**{name: _value(getattr(item, size), item, stated) for name, item in cls.parameters().items()})

    def table(self) -> dict[str, Any]:
        """The `[[effects]]` table that gives this effect."""
        return {"name": self.name, **{name: plain(value) for name, value in self.values.items()}}


def _value(value: float, described: Parameter, stated: Stated) -> float:
    """The value, or that multiple of what a study says."""
    return value * stated[described.share_of] if described.share_of else value
