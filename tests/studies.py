"""Texts of studies for tests to add to and to change: the article's steel wires, and the smallest study there is."""

import tomllib
from typing import Any

_STEEL_WIRES = """
format = 1
name = "{name}"
kind = "crossed-wires"
[wires]
diameter_mm = 0.45
youngs_modulus_MPa = 210000
poissons_ratio = 0.3
[conditions]
normal_load_N = 2.0
displacement_amplitude_um = {amplitude_um}
frequency_Hz = 3.0
cycles = {cycles}
[contact]
friction = 0.62
"""


def steel_wires(name: str, *, amplitude_um: float, cycles: int) -> str:
    """A study without wear on a rigid rig; tables that are added come behind it."""
    return _STEEL_WIRES.format(name=name, amplitude_um=amplitude_um, cycles=cycles)


MINIMAL = steel_wires("test", amplitude_um=60.0, cycles=700)


def minimal() -> dict[str, Any]:
    return tomllib.loads(MINIMAL)
