"""Parameters of effects: unit, range, the value that changes nothing, and which sizes are of interest."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from wirewear.quantity import Quantity

#: Stands for an infinite stiffness in files.
RIGID = "rigid"


@dataclass(frozen=True)
class Parameter:
    """One number of an effect.

    quantity: unit and range. neutral: the value with which the effect changes nothing; None if another parameter's
    neutral value switches it off already. easy, hard: sizes that the steel-wire test shows plainly and barely.
    interest: range that holds 95 % of what one expects before looking. logarithmic: whether sizes there are compared
    by their ratios. share_of: key of a study, such as "contact.friction", of whose value neutral, easy, hard and
    interest are multiples; empty for plain values.
    """

    meaning: str
    quantity: Quantity
    neutral: float | None
    easy: float
    hard: float
    interest: tuple[float, float]
    logarithmic: bool = False
    share_of: str = ""

    def checked(self, value: object) -> float:
        """The value as a number; an infinite stiffness may be written as "rigid".

        Raises:
            ValueError: it is out of range or no number; the message goes on from the parameter's name.
        """
        if RIGID in self.quantity.words and value in (RIGID, math.inf):
            return math.inf
        return float(self.quantity(value))


def parameter(
    meaning: str,
    quantity: Quantity,
    *,
    neutral: float | None,
    easy: float,
    hard: float,
    interest: tuple[float, float],
    logarithmic: bool = False,
    share_of: str = "",
) -> Any:
    """A field of an effect's data class that is a `Parameter`."""
    described = Parameter(meaning, quantity, neutral, easy, hard, interest, logarithmic, share_of)
    return field(metadata={"parameter": described})


def plain(value: float) -> float | str:
    """A parameter's value as files hold it."""
    return RIGID if math.isinf(value) else value
