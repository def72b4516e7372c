"""Numbers and times of day as loggers write them: with thousands parted by signs, with either decimal sign."""

import math
import re

#: A number whose thousands are parted by a sign: sign between, whether there are several, and what follows of it.
_GROUPED = re.compile(r"[-+]?[1-9]\d{0,2}([,.'’ \xa0\u202f])\d{3}((?:\1\d{3})*)(?:([.,])\d*)?")

#: Hours, minutes and seconds, perhaps after a date.
_CLOCK = re.compile(
    r"(?:\d{1,4}[-./]\d{1,2}[-./]\d{1,4}[T, ]\s*)?(?:(\d{1,3}):)?(\d{1,2}):(\d\d(?:[.,]\d+)?)(?:\s*([AP])\.?M\.?)?",
    re.IGNORECASE,
)


def is_clock(field: str) -> bool:
    """True if a field is a time such as 12:30:05.2, with or without a date before it."""
    return _CLOCK.fullmatch(field) is not None


def ungrouped(field: str, decimal: str) -> str:
    """Number without the signs between its thousands: ``1,234.5`` gives ``1234.5``; other fields are unchanged."""
    found = _GROUPED.fullmatch(field)
    alike = found is None or found[1] == decimal or found[3] not in (None, decimal)
    return field if found is None or alike else field.replace(found[1], "")


def in_doubt(field: str) -> bool:
    """True if a field such as ``1,234`` may be read as thousands or as a fraction of three digits."""
    found = _GROUPED.fullmatch(field)
    return found is not None and found[1] in ".," and not found[2] and found[3] is None


def seconds_of(field: str) -> float | None:
    """Seconds since midnight, or since a clock's start; None if the field is no time of day."""
    found = _CLOCK.fullmatch(field)
    if found is None:
        return None
    hours, minutes, seconds, half = found.groups()
    hour = int(hours or 0)
    if half:
        hour = hour % 12 + (12 if half.upper() == "P" else 0)
    return 3600.0 * hour + 60.0 * int(minutes) + float(seconds.replace(",", "."))


def number_of(field: str, decimal: str) -> float:
    """Number or time of day of a field; NaN for anything else."""
    try:
        return float(ungrouped(field, decimal).replace(decimal, "."))
    except ValueError:
        seconds = seconds_of(field)
        return math.nan if seconds is None else seconds
