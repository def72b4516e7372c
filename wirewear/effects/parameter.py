"""Parameters of effects: unit, range, the neutral value that changes nothing, and the sizes expected before a record is
seen.

A form is a number by which a law may differ from the law of its source. A coordinate is a parameter's value expressed
as a standard normal deviate under what is expected: 0 in the middle of `interest`, ±1.96 at its ends. A parameter's
sizes are its values `easy`, `hard` and `interest`.
"""

import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from wirewear.base.errors import StudyError
from wirewear.base.units import Quantity

RIGID = "rigid"  #: Stands for an infinite stiffness in files.
Stated = Mapping[str, float]  #: Numbers that a study states, by their keys, such as "contact.friction".

# Ranges of forms: exponents over those of the source, what is added to exponents and orders, shares that stay, parts,
# limits.
_EXPONENT = Quantity("1", 0.05, 20.0)
_ORDER = Quantity("1", -5.0, 5.0)
_SHARE = Quantity("1", 0.0, 0.6)
_PART = Quantity("1", 0.0, 1.5)
_THICKNESS = Quantity("um", 0.0, math.inf)

_ENDS = 1.96  # Standard deviations from the middle to either end of a range that holds 95 %.

# Of the largest number there is: a range without an end has one here.
_LARGEST_LOGARITHM = math.log(sys.float_info.max)


@dataclass(frozen=True)
class Parameter:
    """A numerical parameter of an effect: meaning, quantity, neutral value and ranges."""

    meaning: str
    quantity: Quantity  #: Unit and range.
    #: The value at which the effect changes nothing; None if another parameter's neutral value switches it off.
    neutral: float | None
    easy: float  #: Size that the steel-wire test shows plainly.
    hard: float  #: Size that the steel-wire test barely shows.
    interest: tuple[float, float]  #: Range with 95 % of what is expected before a record is seen.
    logarithmic: bool = False  #: True if coordinates go with the logarithm of the value.
    #: Key of a study, such as "contact.friction", of whose value neutral, easy, hard and interest are multiples; empty
    #: for plain values.
    share_of: str = ""

    #: Another parameter ("" for any), and the power p if only its ratio to this parameter to the power p shows in a
    #: record of wires; a diagnosis then leaves this parameter in the middle of its range.
    held_by: tuple[str, float] | None = None
    default: float | None = None  #: Value where a study does not state it; None: it must.
    instead: bool = False  #: Whether a diagnosis infers it in place of the others; it has a default, as they have.

    def beside(self, stated: Stated) -> "Parameter":
        """The parameter with its sizes and neutral value in its own unit, in a study that states the numbers `stated`
        by key; unchanged if they are no multiples.

        Raises StudyError if the number is missing of which they are multiples.
        """
        if not self.share_of:
            return self
        if self.share_of not in stated:
            raise StudyError(f"a parameter's sizes are multiples of {self.share_of}, which the study does not state.")
        one = stated[self.share_of]
        neutral = None if self.neutral is None else one * self.neutral
        interest = one * self.interest[0], one * self.interest[1]
        return replace(
            self, neutral=neutral, easy=one * self.easy, hard=one * self.hard, interest=interest, share_of=""
        )

    def value(self, coordinate: float) -> float:
        """The value at a coordinate, limited to the parameter's range."""
        low, high = self._ends()
        at = 0.5 * (low + high) + coordinate * (high - low) / (2.0 * _ENDS)
        if self.logarithmic:
            at = math.exp(min(at, _LARGEST_LOGARITHM))
        return min(max(at, self.quantity.low), self.quantity.high)

    def coordinate(self, value: float) -> float:
        """The coordinate of a value, which must be positive for a logarithmic parameter; inverse of `value`."""
        low, high = self._ends()
        at = math.log(value) if self.logarithmic else value
        return (at - 0.5 * (low + high)) / (high - low) * 2.0 * _ENDS

    @property
    def near_neutral(self) -> float:
        """The neutral value (0 if there is none) or, where that is 0 or infinite on a logarithmic scale, the value one
        standard deviation from the middle of what is expected, on the neutral side, which hardly differs from it in
        effect.
        """
        if not self.logarithmic or self.neutral is None or 0.0 < self.neutral < math.inf:
            return self.neutral or 0.0
        return self.value(1.0 if self.neutral else -1.0)

    def scaled(self, factor: float) -> "Parameter":
        """This parameter with its sizes multiplied by a factor, limited to its range."""
        if factor == 1.0:
            return self
        low, high = self.quantity.low, self.quantity.high

        def within(value: float) -> float:
            return value if math.isinf(value) else min(max(factor * value, low), high)

        interest = within(self.interest[0]), within(self.interest[1])
        return replace(self, easy=within(self.easy), hard=within(self.hard), interest=interest)

    def bounds(self) -> tuple[float, float]:
        """Coordinates of the lower and the upper end of its range; infinite where the range has no end on its scale."""
        low, high = self.quantity.low, self.quantity.high
        return (-math.inf if self.logarithmic and low <= 0.0 else self.coordinate(low)), self.coordinate(high)

    def _ends(self) -> tuple[float, float]:
        low, high = self.interest
        return (math.log(low), math.log(high)) if self.logarithmic else (low, high)

    def checked(self, value: object) -> float:
        """The value of a file as a number; an infinite one may be written as the quantity's word, such as "rigid".

        Raises ValueError if it is out of range or not a number; the message continues a sentence that begins with the
        name.
        """
        if self.quantity.words and value in (*self.quantity.words, math.inf):
            return math.inf
        return float(self.quantity(value))

    def plain(self, value: float) -> float | str:
        """A value as files hold it: the quantity's word, such as "rigid", if infinite."""
        return self.quantity.words[0] if math.isinf(value) else value


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
    held_by: tuple[str, float] | None = None,
    default: float | None = None,
    instead: bool = False,
) -> float:
    """A dataclass field of an effect that is a parameter; its arguments, also None, are the fields of `Parameter`."""
    sizes = neutral, easy, hard, interest, logarithmic
    described = Parameter(meaning, quantity, *sizes, share_of, held_by, default, instead)
    metadata = {"parameter": described}
    made: float = field(metadata=metadata) if default is None else field(default=default, metadata=metadata)
    return made


def cycles_of_change(meaning: str, typical: float) -> float:
    """A parameter: the number of cycles over which a change happens, expected from 30 to 1e5; typical: its size for
    "easy" and "hard".
    """
    quantity, ends = Quantity("cycles", 1.0, 1e9), (30.0, 1e5)
    return parameter(meaning, quantity, neutral=None, easy=typical, hard=typical, interest=ends, logarithmic=True)


def choice(*words: str) -> str:
    """A dataclass field of an effect that takes one of these words; the first is the default."""
    made: str = field(default=words[0], metadata={"choice": words})
    return made


def form(described: Parameter, *, contacts: tuple[str, ...] = ()) -> float:
    """A dataclass field of an effect that is a form: by default the law is that of its source.

    Studies cannot state it. A fit varies it, within the uncertainty that `described` gives. contacts: the kinds of
    contact that have it; empty: all.
    """
    neutral = math.nan if described.neutral is None else described.neutral
    made: float = field(default=neutral, metadata={"form": described, "contacts": contacts})
    return made


def exponent(deviation: float) -> Parameter:
    """A form (see `form`) that multiplies the exponent of a law; 1 for the law of the source. deviation: standard
    deviation of the factor's logarithm.
    """
    ends = math.exp(-_ENDS * deviation), math.exp(_ENDS * deviation)
    meaning = "exponent of its law over that of its source's"
    return Parameter(meaning, _EXPONENT, neutral=1.0, easy=1.0, hard=1.0, interest=ends, logarithmic=True)


def added(meaning: str, low: float, high: float) -> Parameter:
    """How far an effect's law may be open (a form, see `form`): a number that is added to an exponent of the law. It is
    0 for the law as its source states it, and between `low` and `high` for 95 % of the laws that a test may follow.
    meaning: its description.
    """
    return Parameter(meaning, _ORDER, neutral=0.0, easy=0.0, hard=0.0, interest=(low, high))


def order(deviation: float) -> Parameter:
    """A form (see `form`) that is added to the order of a change's kinetics, 1 by the source (see `Course.order`);
    deviation: its standard deviation.
    """
    return added("order of its kinetics beyond the first", -_ENDS * deviation, _ENDS * deviation)


def limit_um(low: float, high: float) -> Parameter:
    """A form (see `form`) that limits a thickness: the largest in µm, infinite for the law of the source, and from
    `low` to `high` for 95 % of laws with a limit.
    """
    never = math.inf
    meaning = "thickness that is not exceeded"
    return Parameter(meaning, _THICKNESS, neutral=never, easy=never, hard=never, interest=(low, high), logarithmic=True)


def share(low: float, high: float) -> Parameter:
    """A form (see `form`): the share of a change that never happens, 0 for the law of the source, and from `low` to
    `high` for 95 % of the laws that a test may follow.
    """
    meaning = "share of it that stays for good"
    return Parameter(meaning, _SHARE, neutral=0.0, easy=0.0, hard=0.0, interest=(low, high), logarithmic=True)


def part(meaning: str, low: float, high: float) -> Parameter:
    """A form (see `form`) that multiplies a part of an effect; 1 for the law of the source, and from `low` to `high`
    for 95 % of the laws that a test may follow. meaning: the part, such as "of its give".
    """
    return Parameter(f"share {meaning}", _PART, neutral=1.0, easy=1.0, hard=1.0, interest=(low, high))
