"""What CalculiX computed: forces and displacements from .dat, contact pressure from .frd, progress from .sta."""

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_HEADING = re.compile(
    r"^\s*(?P<what>displacements|total force).*set\s+(?P<set>\w+)\s+and time\s+(?P<time>\S+)", re.IGNORECASE
)
_LONG_EXPONENT = re.compile(r"(?<=\d)([+-]\d{3})$")


@dataclass(frozen=True)
class CalculixIncrement:
    """One increment: total time, motion of the upper wire's holder (3,), force on the lower wire's grip (3,) in N."""

    time: float
    holder_mm: Array
    grip_force_N: Array


def read_forces(dat: str) -> tuple[CalculixIncrement, ...]:
    """The increments in a .dat file that are complete, in the order of their times.

    ValueError naming the line that is no row of numbers.
    """
    found: dict[float, dict[str, Array]] = {}
    waiting: tuple[str, float] | None = None
    for number, line in enumerate(dat.splitlines(), 1):
        if heading := _HEADING.match(line):
            waiting = heading["what"].lower(), float(heading["time"])
        elif waiting and line.strip():
            what, time = waiting
            found.setdefault(time, {})[what] = _vector(line, number)
            waiting = None
    return tuple(
        CalculixIncrement(time, values["displacements"], values["total force"])
        for time, values in sorted(found.items())
        if len(values) == 2
    )


def _number(word: str) -> float:
    """A Fortran real: an exponent of three digits drives out its E."""
    return float(_LONG_EXPONENT.sub(r"E\1", word.strip()))


def _vector(line: str, number: int) -> Array:
    try:
        values = np.array([_number(word) for word in line.split()[-3:]])
    except ValueError:
        values = np.empty(0)
    if values.shape != (3,):
        raise ValueError(f"line {number} of the .dat file should hold three numbers, but reads '{line.strip()}'")
    return values


def read_peak_pressures(frd: str) -> dict[float, float]:
    """Largest contact pressure in MPa at each total time of an .frd file (datasets CONTACT, component PRESS)."""
    peaks: dict[float, float] = {}
    time, component, components, in_contact = 0.0, -1, list[str](), False
    for line in frd.splitlines():
        match line[:5]:
            case "  100":
                time = float(line[12:24])
            case " -4  ":
                components, component = [], -1
                in_contact = line.split()[1] == "CONTACT"
            case " -5  " if in_contact:
                components.append(line.split()[1])
                component = next((i for i, name in enumerate(components) if name.endswith("PRESS")), -1)
            case _ if line.startswith(" -1") and component >= 0:
                start = 13 + 12 * component
                peaks[time] = max(peaks.get(time, 0.0), _number(line[start : start + 12]))
            case _ if line.startswith(" -3"):
                component = -1
    return peaks


def read_completed(sta: str) -> tuple[float, ...]:
    """Total times of the converged increments in an .sta file, in order.

    Attempts that CalculiX gave up (U behind the attempt's number) and a line that is still being written are left out.
    """
    rows = [line.split() for line in sta.splitlines(keepends=True) if line.endswith("\n")]
    return tuple(float(row[4]) for row in rows if len(row) == 7 and all(word.isdigit() for word in row[:4]))


def increment_near(increments: tuple[CalculixIncrement, ...], time: float) -> CalculixIncrement | None:
    """The increment at a total time, None when there is none within a thousandth."""
    near = [increment for increment in increments if abs(increment.time - time) < 1e-3]
    return near[0] if near else None
