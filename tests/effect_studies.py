"""A coarse study of one cycle, and its results with effects; runs are shared within a test session."""

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from tests.studies import steel_wires
from wirewear import RunResult, Study, parse_study, run_study
from wirewear.effects import Effect

COARSE = f"""{steel_wires("coarse wires", amplitude_um=20.0, cycles=1)}[fidelity.quick]
contact_mesh_um = 9.0
outer_mesh_um = 18.0
increments_per_cycle = 40
jump_tolerance = 0.3
"""

WEARING = """
[wear]
energy_wear_coefficient_mm3_per_J = 3.0e-5
"""


def coarse(text: str = COARSE) -> Study:
    return parse_study(text, "coarse.toml")


@cache
def result_with(*effects: Effect[Any], text: str = COARSE) -> RunResult:
    """The complete run of a study with these effects."""
    with TemporaryDirectory() as folder:
        (result,) = run_study(coarse(text).with_effects(*effects), fidelity="quick", output=Path(folder))
    return result
