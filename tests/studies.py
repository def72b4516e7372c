"""Studies to add to and to change: steel wires, the smallest that there is and one for effects, and a line contact."""

import tomllib
from copy import deepcopy
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from wirewear import RunResult, Study, parse_study, run_study
from wirewear.effects import Effect
from wirewear.test import LineStudy, study_from_tables

EXAMPLES = Path(__file__).parents[1] / "studies" / "steel_wires" / "example_records"

_WIRES_IN_TEST = """
format = 1
name = "{name}"
[wires]
diameter_mm = 0.45
youngs_modulus_MPa = 210000.0
poissons_ratio = 0.3
[conditions]
normal_load_N = 2.0
displacement_amplitude_um = {amplitude_um}
frequency_Hz = {frequency_Hz}
cycles = {cycles}
"""


def wires_in_test(name: str, *, amplitude_um: float = 60.0, cycles: int, frequency_Hz: float = 3.0) -> str:
    """Steel wires and their conditions, as studies and mappings of records state them."""
    return _WIRES_IN_TEST.format(name=name, amplitude_um=amplitude_um, cycles=cycles, frequency_Hz=frequency_Hz)


def steel_wires(name: str, *, amplitude_um: float, cycles: int) -> str:
    """A study without wear on a rigid rig; tables that are added come behind it."""
    head = wires_in_test(name, amplitude_um=amplitude_um, cycles=cycles)
    return f'kind = "crossed-wires"{head}[contact]\nfriction = 0.62\n'


MINIMAL = steel_wires("test", amplitude_um=60.0, cycles=700)


def minimal() -> dict[str, Any]:
    return tomllib.loads(MINIMAL)


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
#: For what is no matter of the mesh: programmes, drives, stops.
ROUGH = COARSE.replace("mesh_um = 9.0", "mesh_um = 12.0").replace("= 18.0", "= 24.0")
LONG = ROUGH.replace("cycles = 1\n", "cycles = 400\n").replace("per_cycle = 40", "per_cycle = 24") + WEARING


TABLES: dict[str, Any] = {
    "format": 1, "name": "cylinder on flat", "kind": "cylinder-on-flat",
    "pad": {"radius_mm": 6.0, "youngs_modulus_MPa": 2e5, "poissons_ratio": 0.3},
    "specimen": {"youngs_modulus_MPa": 2e5, "poissons_ratio": 0.3},
    "conditions": {"normal_load_N_per_mm": 30.0, "displacement_amplitude_um": 12.0, "cycles": 20_000},
    "contact": {"friction": 0.6}, "wear": {"pad_energy_mm3_per_J": 4e-5, "specimen_energy_mm3_per_J": 2e-5},
    "log": {"loop_cycles": [1, 5000, 20_000]}, "mesh": {"contact_mesh_um": 12.0, "jump_tolerance": 0.05},
}  # fmt: skip


def line_study(**changes: Any) -> LineStudy:
    """A cylinder on a flat; keys that are given come into its tables, and None leaves a key or a table out."""
    tables = deepcopy(TABLES)
    for name, values in changes.items():
        own = tables.get(name, {}) | values if isinstance(values, dict) else values
        tables[name] = {key: one for key, one in own.items() if one is not None} if isinstance(own, dict) else own
    found: LineStudy = study_from_tables({name: own for name, own in tables.items() if own is not None}, "study.toml")
    return found


def coarse(text: str = COARSE) -> Study:
    return parse_study(text, "coarse.toml")


@cache
def result_with(*effects: Effect[Any], text: str = COARSE) -> RunResult:
    """The complete run of a study with these effects."""
    with TemporaryDirectory() as folder:
        (result,) = run_study(coarse(text).with_effects(*effects), fidelity="quick", output=Path(folder))
    return result


def require_equal_runs(mine: RunResult, theirs: RunResult) -> None:
    """Evolution, scars, loops and quality are the same to the last digit."""
    for name, column in theirs.evolution.items():
        np.testing.assert_array_equal(mine.evolution[name], column, err_msg=name)
    for scar, other in zip(mine.scars, theirs.scars, strict=True):
        np.testing.assert_array_equal(scar.depth_um, other.depth_um)
    for loop, another in zip(mine.loops, theirs.loops, strict=True):
        np.testing.assert_array_equal(loop.tangential_force_N, another.tangential_force_N)
    assert mine.quality == theirs.quality


def block(cycles: int, *values: str) -> str:
    return "\n".join(("[[programme]]", f"cycles = {cycles}", *values, ""))
