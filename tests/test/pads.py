"""Studies of pads and balls of any profile."""

from copy import deepcopy
from typing import Any

from wirewear import reference
from wirewear.test import Study, study_from_tables

STEEL = {"youngs_modulus_MPa": 2e5, "poissons_ratio": 0.3}


LINE = """
format = 1
name = "line"
kind = "line-contact"
[pad]
{pad}
youngs_modulus_MPa = 200000
poissons_ratio = 0.3
height_mm = 2.0
half_width_mm = 1.0
[specimen]
youngs_modulus_MPa = 200000
poissons_ratio = 0.3
height_mm = 2.0
half_width_mm = 2.0
[conditions]
normal_load_N_per_mm = 50.0
displacement_amplitude_um = 20.0
cycles = 2000
[contact]
friction = 0.6
[wear]
pad_energy_mm3_per_J = 3e-5
specimen_energy_mm3_per_J = 2e-5
[log]
loop_cycles = [2000]
[mesh]
contact_mesh_um = 16.0
scar_half_width_um = 250.0
increments_per_cycle = 16
"""


BALL_RADIUS_mm = 6.35


def study(contact: dict[str, Any], **tables: Any) -> Study:
    found: Study = study_from_tables(deepcopy(POINTS) | contact | tables, "s.toml")
    return found


POINTS: dict[str, Any] = {
    "format": 1, "name": "test",
    "conditions": {"normal_load_N": 50.0, "displacement_amplitude_um": 40.0, "frequency_Hz": 5.0, "cycles": 20},
    "contact": {"friction": 0.6}, "wear": {"energy_wear_coefficient_mm3_per_J": 2.0e-5, "moving_share": 0.3},
    "log": {"loop_cycles": [20]}, "fidelity": {"quick": {"increments_per_cycle": 16, "contact_mesh_um": 40.0}},
}  # fmt: skip


BALL = {"kind": "ball-on-flat", "bodies": {"ball": {"diameter_mm": 2.0 * BALL_RADIUS_mm, **STEEL}, "flat": STEEL}}


STEEL_MODULUS = reference.contact_modulus(*(reference.Elastic(*STEEL.values()),) * 2)
