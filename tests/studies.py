"""The smallest study there is, for tests to change."""

import tomllib
from typing import Any

MINIMAL = """
format = 1
name = "test"
kind = "crossed-wires"
[wires]
diameter_mm = 0.45
youngs_modulus_MPa = 210000
poissons_ratio = 0.3
[conditions]
normal_load_N = 2.0
displacement_amplitude_um = 60.0
frequency_Hz = 3.0
cycles = 700
[contact]
friction = 0.62
"""


def minimal() -> dict[str, Any]:
    return tomllib.loads(MINIMAL)
