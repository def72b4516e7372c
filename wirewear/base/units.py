"""Units: how they are written, those that laboratories write, and which numbers a key in a unit may take."""

import math
import sys
from dataclasses import dataclass

from wirewear.base.words import shown

#: How a unit is written behind a number, and what it is called in a sentence; nothing for a plain number.
_UNITS = {
    "mm": (" mm", "millimetres"),
    "um": (" µm", "micrometres"),
    "MPa": (" MPa", "megapascals"),
    "MPa_sqrt_m": (" MPa√m", "megapascals times square roots of metres"),
    "N": (" N", "newtons"),
    "Hz": (" Hz", "hertz"),
    "deg": ("°", "degrees"),
    "N_per_mm": (" N/mm", "newtons per millimetre"),
    "N_mm_per_rad": (" N·mm/rad", "newton millimetres per radian"),
    "N_per_rad": (" N/rad", "newton millimetres per radian and millimetre of thickness"),
    "N_per_mm2": (" N/mm²", "newtons per millimetre and millimetre of thickness"),
    "N_per_mm3": (" N/mm³", "newtons per cubic millimetre"),
    "mm3": (" mm³", "cubic millimetres"),
    "mm3_per_J": (" mm³/J", "cubic millimetres per joule"),
    "mm3_per_N_m": (" mm³/(N·m)", "cubic millimetres per newton metre"),
    "um_per_N": (" µm/N", "micrometres per newton"),
    "um_per_N2": (" µm/N²", "micrometres per newton squared"),
    "kg": (" kg", "kilograms"),
    "s": (" s", "seconds"),
    "J": (" J", "joules"),
    "mJ": (" mJ", "millijoules"),
    "W": (" W", "watts"),
    "W_per_m_K": (" W/(m·K)", "watts per metre and kelvin"),
    "J_per_cm3_K": (" J/(cm³·K)", "joules per cubic centimetre and kelvin"),
    "K_per_W": (" K/W", "kelvins per watt"),
    "kJ_per_mol": (" kJ/mol", "kilojoules per mole"),
    "per_K": ("/K", "per kelvin"),
    "cycles": (" cycles", "cycles"),
    "per_100k_cycles": (" per 100\u2009000 cycles", "per 100\u2009000 cycles"),
    "1": ("", ""),
}
UNIT_SYMBOLS = {unit: symbol for unit, (symbol, _) in _UNITS.items()}
UNIT_NAMES = {unit: name for unit, (_, name) in _UNITS.items()}

#: Units in which results are given beside those of studies; the units of a whole line or area come before their parts.
RESULT_UNITS = {"mJ_per_mm2": "mJ/mm²", "mm3": "mm³", "um2": "µm²", "N_per_mm": "N/mm", "kHz": "kHz", "K": "K"}

#: Names of columns without a unit at their end, and their unit.
_OF_ITSELF = {"cycle": "cycles", "jump_cycles": "cycles", "mirror_error": "1"}

#: Units in which a value is given by mistake: their name, and the factor that turns the value into the right unit.
MISTAKEN_UNITS = {
    "mm": (("micrometres", 1e-3), ("metres", 1e3)),
    "um": (("millimetres", 1e3), ("metres", 1e6)),
    "MPa": (("gigapascals", 1e3), ("kilopascals", 1e-3), ("pascals", 1e-6)),
    "N": (("millinewtons", 1e-3), ("kilonewtons", 1e3)),
    "deg": (("radians", 180.0 / math.pi),),
    "N_per_mm": (("newtons per micrometre", 1e3), ("newtons per metre", 1e-3)),
    "mm3_per_J": (("cubic micrometres per joule", 1e-9), ("cubic millimetres per millijoule", 1e3)),
    "1": (("per cent", 0.01),),
}

#: Units that laboratories write, and their factors to the unit used inside (the one that ends a column's name).
FIELD_UNITS: dict[str, dict[str, float]] = {
    "um": {"um": 1.0, "µm": 1.0, "μm": 1.0, "nm": 1e-3, "mm": 1e3, "cm": 1e4, "m": 1e6}
    | {"micron": 1.0, "microns": 1.0, "Å": 1e-4, "\u212b": 1e-4, "inch": 25400.0, "in": 25400.0, "mil": 25.4},
    "N": {"N": 1.0, "mN": 1e-3, "kN": 1e3, "uN": 1e-6, "µN": 1e-6, "μN": 1e-6, "cN": 1e-2, "daN": 10.0}
    | {"g": 9.80665e-3, "gf": 9.80665e-3, "kg": 9.80665, "kgf": 9.80665, "kp": 9.80665}
    | {"lb": 4.4482216152605, "lbf": 4.4482216152605, "kip": 4448.2216152605},
    "s": {"s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "μs": 1e-6, "min": 60.0, "h": 3600.0},
    "mJ": {"mJ": 1.0, "J": 1e3, "N·m": 1e3, "Nm": 1e3, "uJ": 1e-3, "µJ": 1e-3, "μJ": 1e-3},
}

#: Units of what is given per length of a line contact, and their factors to the unit inside per millimetre.
UNITS_PER_LENGTH: dict[str, dict[str, float]] = {
    "N": {"N/mm": 1.0, "kN/m": 1.0, "N/m": 1e-3},
    "mJ": {"mJ/mm": 1.0, "J/m": 1.0, "mJ/m": 1e-3},
}
_LARGEST_FLOAT = int(sys.float_info.max)  # An integer beyond cannot be compared with what it is out of.


@dataclass(frozen=True)
class Quantity:
    """Allowed values of a key: numbers from `low` to `high` in `unit` (a key of UNIT_NAMES), or one of `words`.

    Called with a value, it checks and returns it: as a float, with `whole` as an int divisible by `multiple_of`, or as
    the word.
    """

    unit: str
    low: float
    high: float
    whole: bool = False
    multiple_of: int = 1
    words: tuple[str, ...] = ()

    def __call__(self, value: object) -> float | int | str:
        """A stated value as the number or word that it is, in the unit of its key.

        Raises ValueError if the quantity does not allow it, with a message that continues after the key's name.
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
            point = value.replace(",", ".") if isinstance(value, str) else ""
            hint = f": write it without quotes, {point}" if _is_number(point) else ""
            raise ValueError(f"is {what}{shown(value)}, but must be {self._kind_text}{hint}")
        if isinstance(value, float) and not math.isfinite(value):
            raise ValueError(f"is {value}, but must be a finite number {self.range_text}")
        if abs(value) > _LARGEST_FLOAT:
            raise ValueError(f"is {shown(value)}, but must lie {self.range_text}")
        return value

    @property
    def range_text(self) -> str:
        """The allowed range in words, such as ``between 0.02 and 20 millimetres``."""
        words = "".join(f', or "{word}"' for word in self.words)
        return f"between {self.low:.12g} and {self.high:.12g} {UNIT_NAMES[self.unit]}".rstrip() + words

    @property
    def _kind_text(self) -> str:
        multiple = f" that is a multiple of {self.multiple_of}" if self.multiple_of > 1 else ""
        return f"a {'whole ' if self.whole else ''}number{multiple} {self.range_text}"

    def _unit_hint(self, number: float) -> str:
        for name, factor in MISTAKEN_UNITS.get(self.unit, ()):
            # A share below 1 is none of per cent; angles are set to multiples of 5°, which few numbers of degrees are.
            looks = {"1": number >= 1.0, "deg": abs(number * factor - 5.0 * round(0.2 * number * factor)) < 0.2}
            if number > 0 and self.low <= number * factor <= self.high and looks.get(self.unit, True):
                return f": it looks like {name}, which would be {number * factor:.6g} here"
        return ""


def finite_number(value: object) -> float:
    """Value as a float; raises ValueError, with a message that continues after a name, if it is not a finite number."""
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if not number or not -_LARGEST_FLOAT <= value <= _LARGEST_FLOAT:  # type: ignore[operator]
        raise ValueError(f"is {shown(value)}, but must be a finite number")
    return float(value)  # type: ignore[arg-type]


def unit_of(name: str) -> str:
    """Symbol of the unit that ends a column's name: "µm" for `depth_um`; "1" if there is none."""
    if name in _OF_ITSELF:
        return _OF_ITSELF[name]
    units = {unit: symbol.strip() for unit, symbol in UNIT_SYMBOLS.items() if unit != "1"} | RESULT_UNITS
    found = (unit for unit in sorted(units, key=len, reverse=True) if name.endswith(f"_{unit}"))
    return units.get(next(found, ""), "1")


def words_of(name: str) -> str:
    """Name of a column in words, without its unit: "slip amplitude" for `slip_amplitude_um`."""
    units = sorted({*UNIT_SYMBOLS, *RESULT_UNITS} - {"1", "cycles"}, key=len, reverse=True)
    ending = next((f"_{unit}" for unit in units if name.endswith(f"_{unit}")), "")
    return name.removesuffix(ending).replace("_", " ")


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
