"""A number in a study: its unit, its sensible range, and what to say when it is something else."""

import math
import sys
from dataclasses import dataclass
from datetime import date, time

#: What a unit is called in a sentence; nothing for a plain number.
UNIT_NAMES = {
    "mm": "millimetres",
    "um": "micrometres",
    "MPa": "megapascals",
    "N": "newtons",
    "Hz": "hertz",
    "deg": "degrees",
    "N_per_mm": "newtons per millimetre",
    "N_mm_per_rad": "newton millimetres per radian",
    "N_per_rad": "newton millimetres per radian and millimetre of thickness",
    "N_per_mm2": "newtons per millimetre and millimetre of thickness",
    "mm3_per_J": "cubic millimetres per joule",
    "mm3_per_N_m": "cubic millimetres per newton metre",
    "um_per_N": "micrometres per newton",
    "um_per_N2": "micrometres per newton squared",
    "s": "seconds",
    "J": "joules",
    "cycles": "cycles",
    "1": "",
}

#: How a unit is written behind a number.
UNIT_SYMBOLS = {
    "mm": " mm",
    "um": " µm",
    "MPa": " MPa",
    "N": " N",
    "Hz": " Hz",
    "deg": "°",
    "N_per_mm": " N/mm",
    "N_mm_per_rad": " N·mm/rad",
    "N_per_rad": " N/rad",
    "N_per_mm2": " N/mm²",
    "mm3_per_J": " mm³/J",
    "mm3_per_N_m": " mm³/(N·m)",
    "um_per_N": " µm/N",
    "um_per_N2": " µm/N²",
    "s": " s",
    "J": " J",
    "cycles": " cycles",
    "1": "",
}

#: Units in which a value is given by mistake: their name, and the factor that turns the value into the right unit.
MISTAKEN_UNITS = {
    "mm": (("micrometres", 1e-3), ("metres", 1e3)),
    "um": (("millimetres", 1e3), ("metres", 1e6)),
    "MPa": (("gigapascals", 1e3), ("pascals", 1e-6)),
    "N": (("millinewtons", 1e-3), ("kilonewtons", 1e3)),
    "deg": (("radians", 180.0 / math.pi),),
    "N_per_mm": (("newtons per micrometre", 1e3), ("newtons per metre", 1e-3)),
    "mm3_per_J": (("cubic micrometres per joule", 1e-9), ("cubic millimetres per millijoule", 1e3)),
    "1": (("per cent", 0.01),),
}

# An integer beyond cannot be compared with what it is out of.
_LARGEST_FLOAT = int(sys.float_info.max)


@dataclass(frozen=True)
class Quantity:
    """Which values a key may take: a number from `low` to `high` in `unit` (a key of UNIT_NAMES), or one of `words`.

    Calling it returns the value, as a float or, with `whole`, as an int that `multiple_of` divides.
    """

    unit: str
    low: float
    high: float
    whole: bool = False
    multiple_of: int = 1
    words: tuple[str, ...] = ()

    def __call__(self, value: object) -> float | int | str:
        """Check a value read from a study.

        Raises:
            ValueError: the value is none of the allowed ones; the message goes on from the key's name.
        """
        if isinstance(value, str) and value in self.words:
            return value
        number = self._number(value)
        if not self.low <= number <= self.high:
            raise ValueError(f"is {shown(value)}, but must lie {self.range_text}{self._unit_hint(number)}")
        if not self.whole:
            return float(number)
        if number != int(number) or int(number) % self.multiple_of:
            raise ValueError(f"is {shown(value)}, but must be {self._kind_text}")
        return int(number)

    def _number(self, value: object) -> float | int:
        if isinstance(value, bool) or not isinstance(value, int | float):
            what = "the text " if isinstance(value, str) else ""
            hint = ": write it without quotes" if isinstance(value, str) and _is_number(value) else ""
            raise ValueError(f"is {what}{shown(value)}, but must be {self._kind_text}{hint}")
        if isinstance(value, float) and not math.isfinite(value):
            raise ValueError(f"is {value}, but must be a finite number {self.range_text}")
        if abs(value) > _LARGEST_FLOAT:
            raise ValueError(f"is {shown(value)}, but must lie {self.range_text}")
        return value

    @property
    def range_text(self) -> str:
        """What is allowed, in words: ``between 0.02 and 20 millimetres``."""
        words = "".join(f', or "{word}"' for word in self.words)
        return f"between {self.low:.12g} and {self.high:.12g} {UNIT_NAMES[self.unit]}".rstrip() + words

    @property
    def _kind_text(self) -> str:
        multiple = f" that is a multiple of {self.multiple_of}" if self.multiple_of > 1 else ""
        return f"a {'whole ' if self.whole else ''}number{multiple} {self.range_text}"

    def _unit_hint(self, number: float) -> str:
        for name, factor in MISTAKEN_UNITS.get(self.unit, ()):
            if number > 0 and self.low <= number * factor <= self.high:
                return f": it looks like {name}, which would be {number * factor:.6g} here"
        return ""


def shown(value: object) -> str:
    """A value as it may stand in a message: short, whatever it is."""
    try:
        text = value.isoformat() if isinstance(value, date | time) else repr(value)
    except ValueError:  # an integer of thousands of digits
        return "a number of thousands of digits"
    if isinstance(value, int) and len(text) > 60:
        return f"a number of {len(text.lstrip('-'))} digits"
    return text if len(text) <= 60 else f"{text[:57]}..."


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
