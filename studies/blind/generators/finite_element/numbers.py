"""Parameters of causes that no library holds, which nobody is asked for: only their ranges are meant."""

from typing import Any

from wirewear.effects import Quantity, parameter


def number(meaning: str, low: float, high: float) -> Any:
    """A parameter without a unit."""
    return parameter(meaning, Quantity("1", low, high), neutral=None, easy=low, hard=low, interest=(low, high))


def cycles_of(meaning: str) -> Any:
    """A parameter in cycles."""
    return parameter(meaning, Quantity("cycles", 1.0, 1e9), neutral=None, easy=1.0, hard=1.0, interest=(1.0, 1e6))


def micrometres(meaning: str, unit: str = "um") -> Any:
    """A length, or a length per force with the unit um_per_N."""
    return parameter(meaning, Quantity(unit, 0.0, 1e3), neutral=None, easy=1.0, hard=1.0, interest=(0.1, 10.0))
