"""How large an effect is drawn: from what hardly shows to what nobody overlooks, relative to the nominal test."""

from collections.abc import Callable, Mapping
from typing import cast

import numpy as np

from studies.blind.causes import all_causes
from studies.blind.generators.draw import SEVERITY, Draw
from studies.blind.generators.line_nominal import LineNominal
from studies.blind.generators.nominal import Nominal
from studies.blind.generators.other_simulators.causes import sizes as other_sizes
from studies.blind.generators.other_simulators.tests_drawn import LineTest, WireTest


def drawn_parameters(effect: str, ease: str, nominal: Nominal, random: np.random.Generator) -> dict[str, float]:
    """Parameters of an effect, five significant digits each; tests by others have sizes of their own."""
    if isinstance(nominal, WireTest | LineTest):
        return other_sizes(effect, ease, nominal, random)
    size = DRAWS[effect] if effect in DRAWS else all_causes()[effect].size
    draw = Draw(random.uniform(*SEVERITY[ease]), nominal, random)
    return {name: float(f"{value:.5g}") for name, value in size(draw).items()}


def _rotational(d: Draw) -> dict[str, float]:
    arm = d.random.uniform(8.0, 50.0)
    return {"stiffness_N_mm_per_rad": 1e3 * arm**2 * d.plateau_N / d.length_um(0.6, 8.0), "arm_mm": arm}


def _friction_evolution(d: Draw) -> dict[str, float]:
    return {
        "initial": d.nominal.friction * (1.0 + d.between(0.04, 0.3) * d.sign(0.3)),
        "final": d.nominal.friction * d.random.uniform(0.98, 1.02),
        "cycles": d.cycles,
    }


def _coupling(d: Draw) -> dict[str, float]:
    linear = d.length_um(0.5, 6.0) / d.plateau_N * d.sign(0.75)
    return {"linear_um_per_N": linear, "quadratic_um_per_N2": d.random.choice([0.0, -0.3, 0.3]) * linear / d.plateau_N}


def _wear_evolution(d: Draw) -> dict[str, float]:
    initial = d.between(1.3, 5.0) ** d.sign(0.7)
    final = d.random.uniform(0.75, 1.1) if initial > 1.0 else d.random.uniform(0.95, 1.3)
    return {"initial_factor": initial, "final_factor": final, "cycles": d.cycles}


def _oxygenation(d: Draw) -> dict[str, float]:
    """Oxygen gets so far from the edge of the expected scar, at the mean power density of the test."""
    own = cast("LineNominal", d.nominal)
    power_W = 4e-6 * d.plateau_N * own.amplitude_um * own.frequency_Hz
    density = power_W / (2.0 * own.expected_scar_mm * own.length_mm)
    reach = own.expected_scar_mm * d.between(0.75, 0.35)
    return {"supply_W": density * reach**2, "starved_factor": d.between(0.7, 0.2)}


#: Parameters of each effect of the library as drawn, with the contract's names and units.
DRAWS: Mapping[str, Callable[[Draw], dict[str, float]]] = {
    "tangential_compliance": lambda d: {"stiffness_N_per_mm": 1e3 * d.plateau_N / d.length_um(0.6, 8.0)},
    "rotational_compliance": _rotational,
    "free_play": lambda d: {"gap_um": d.length_um(0.6, 6.0)},
    "friction_offset": lambda d: {"friction": d.nominal.friction * (1.0 + d.between(0.02, 0.18) * d.sign())},
    "friction_evolution": _friction_evolution,
    "roughness_compliance": lambda d: {"layer_um": d.between(0.6, 8.0), "cycles": d.cycles},
    "contact_oxygenation": _oxygenation,
    "third_body": lambda d: {"retained_fraction": d.between(0.06, 0.4), "modulus_MPa": d.spread(300.0, 5000.0)},
    "plasticity": lambda d: {"flattening_um": d.between(0.3, 4.0)},
    "crossing_angle_error": lambda d: {"angle_deg": d.between(1.0, 8.0) * d.sign()},
    "misalignment": lambda d: {"angle_deg": d.between(0.15, 2.5) * d.sign()},
    "normal_load_drift": lambda d: {
        "fraction_per_100k_cycles": d.between(0.03, 0.3) * d.sign(0.3) * 1e5 / max(d.nominal.cycles, 1e5)
    },
    "wear_rate_offset": lambda d: {"factor": d.between(1.1, 2.2) ** d.sign()},
    "wear_rate_evolution": _wear_evolution,
    "displacement_gain": lambda d: {"gain": 1.0 + d.between(0.01, 0.12) * d.sign()},
    "displacement_load_coupling": _coupling,
    "force_crosstalk": lambda d: {"coefficient": d.between(0.003, 0.04) * d.sign()},
    "sensor_lag": lambda d: {"time_s": d.between(0.004, 0.06) / (2.0 * np.pi * d.nominal.frequency_Hz)},
}
