"""A test of a ball on a flat."""

from typing import Any

STEEL = {"youngs_modulus_MPa": 210000.0, "poissons_ratio": 0.3}


RADIUS_mm, LOAD_N, FRICTION = 6.35, 50.0, 0.6


TEST: dict[str, Any] = {
    "format": 1, "name": "test",
    "conditions": {"normal_load_N": LOAD_N, "displacement_amplitude_um": 40.0, "frequency_Hz": 5.0, "cycles": 20},
    "contact": {"friction": FRICTION}, "wear": {"energy_wear_coefficient_mm3_per_J": 2.0e-5, "moving_share": 0.3},
    "log": {"loop_cycles": [1, 20]}, "fidelity": {"quick": {"increments_per_cycle": 16}},
}  # fmt: skip
