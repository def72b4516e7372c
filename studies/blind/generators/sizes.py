"""How large an effect is drawn: from what hardly shows to what nobody overlooks, relative to the nominal test."""

from collections.abc import Callable, Mapping
from math import pi
from typing import cast

import numpy as np

from studies.blind.generators.draw import SEVERITY, Draw
from studies.blind.generators.line_nominal import LineNominal
from studies.blind.generators.nominal import Nominal
from studies.blind.generators.others.causes import sizes as other_sizes
from studies.blind.generators.others.tests_drawn import LineTest, WireTest
from studies.blind.generators.withheld_sizes import RESERVED, WITHHELD


def drawn_parameters(effect: str, ease: str, nominal: Nominal, random: np.random.Generator) -> dict[str, float]:
    """Parameters of an effect, five significant digits each; tests by others have sizes of their own."""
    if isinstance(nominal, WireTest | LineTest):
        return other_sizes(effect, ease, nominal, random)
    draw = Draw(random.uniform(*SEVERITY[ease]), nominal, random)
    return {name: float(f"{value:.5g}") for name, value in DRAWS[effect](draw).items()}


def _tangential(d: Draw) -> dict[str, float]:
    return {"stiffness_N_per_mm": 1e3 * d.plateau_N / d.length_um(0.6, 8.0)}


def _rotational(d: Draw) -> dict[str, float]:
    arm = d.random.uniform(8.0, 50.0)
    return {"stiffness_N_mm_per_rad": 1e3 * arm**2 * d.plateau_N / d.length_um(0.6, 8.0), "arm_mm": arm}


def _friction_evolution(d: Draw) -> dict[str, float]:
    friction = d.nominal.friction
    return {
        "initial": friction * (1.0 + d.between(0.04, 0.3) * d.sign(0.3)),
        "final": friction * d.random.uniform(0.98, 1.02),
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


def _pressure_wear(d: Draw) -> dict[str, float]:
    """The reference is the mean pressure on the expected scar, so that the end of the test is as stated."""
    pressure_MPa = d.nominal.load_N / (pi * d.nominal.expected_scar_mm**2)
    return {"exponent": d.between(0.06, 0.5) * d.sign(), "pressure_MPa": pressure_MPa}


def _load_drift(d: Draw) -> dict[str, float]:
    return {"fraction_per_100k_cycles": d.between(0.03, 0.3) * d.sign(0.3) * 1e5 / max(d.nominal.cycles, 1e5)}


def _ejection(d: Draw) -> dict[str, float]:
    cycles = d.nominal.cycles
    return {
        "factor": 1.0 + d.between(0.04, 0.25) * d.sign(0.3),
        "cycle_1": cycles * d.random.uniform(0.02, 0.1),
        "cycle_2": cycles * d.random.uniform(0.3, 0.8),
        "recovery_cycles": cycles * d.random.uniform(0.05, 0.2),
    }


def _lag(d: Draw) -> dict[str, float]:
    return {"time_s": d.between(0.004, 0.06) / (2.0 * np.pi * d.nominal.frequency_Hz)}


def _clamp(d: Draw) -> dict[str, float]:
    holds = d.random.uniform(0.3, 0.7) * d.plateau_N
    return {"holds_N": holds, "slip_um_per_N": d.length_um(0.8, 6.0) / (d.plateau_N - holds)}


#: Parameters of each effect as drawn; those of the library's have the contract's names and units.
DRAWS: Mapping[str, Callable[[Draw], dict[str, float]]] = {
    "tangential_compliance": _tangential,
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
    "normal_load_drift": _load_drift,
    "wear_rate_offset": lambda d: {"factor": d.between(1.1, 2.2) ** d.sign()},
    "wear_rate_evolution": _wear_evolution,
    "displacement_gain": lambda d: {"gain": 1.0 + d.between(0.01, 0.12) * d.sign()},
    "displacement_load_coupling": _coupling,
    "force_crosstalk": lambda d: {"coefficient": d.between(0.003, 0.04) * d.sign()},
    "sensor_lag": _lag,
    "thermal_gain_drift": lambda d: {"gain_change": d.between(0.015, 0.15) * d.sign(), "cycles": d.cycles},
    "reversal_adhesion": lambda d: {"overshoot": d.between(0.06, 0.4), "length_um": d.random.uniform(2.0, 6.0)},
    "velocity_dependent_friction": lambda d: {"per_e_fold": d.between(0.015, 0.12) * d.sign()},
    "clamp_slip": _clamp,
    "debris_ejection": _ejection,
    "bent_guide": lambda d: {"load_rise": d.between(0.03, 0.3) * d.sign()},
    "saturating_force_cell": lambda d: {"loss_at_plateau": d.between(0.02, 0.15)},
    "asymmetric_force_cell": lambda d: {"asymmetry": d.between(0.01, 0.1) * d.sign()},
    "force_cell_hysteresis": lambda d: {"play_N": d.between(0.02, 0.2) * d.plateau_N},
    "creeping_force_zero": lambda d: {"zero_N": d.between(0.02, 0.2) * d.plateau_N * d.sign(), "cycles": d.cycles},
    "bent_displacement_sensor": lambda d: {"bend": d.between(0.02, 0.2) * d.sign()},
    "displacement_backlash": lambda d: {"play_um": d.length_um(0.6, 6.0)},
    "parallel_spring": lambda d: {
        "stiffness_N_per_mm": 1e3 * d.between(0.02, 0.2) * d.plateau_N / d.nominal.amplitude_um
    },
    "stiffening_holder": lambda d: {"hardening_um_per_N3": d.length_um(1.0, 9.0) / d.plateau_N**3},
    "loosening_holder": lambda d: {"loosening_um_per_N": d.length_um(0.8, 8.0) / d.plateau_N, "cycles": d.cycles},
    "slanted_load": lambda d: {"load_rise": d.between(0.03, 0.25) * d.sign()},
    "slanted_friction": lambda d: {"rise": d.between(0.03, 0.25) * d.sign()},
    "rippled_friction": lambda d: {
        "share": d.between(0.01, 0.1),
        "length_um": d.nominal.amplitude_um * d.spread(0.08, 0.3),
    },
    "breathing_friction": lambda d: {"share": d.between(0.02, 0.15), "folds": d.random.uniform(1.2, 3.5)},
    "severe_wear": lambda d: {
        "factor": d.between(2.0, 8.0) ** d.sign(0.7),
        "cycle": d.nominal.cycles * d.random.uniform(0.05, 0.3),
        "recovery_cycles": d.nominal.cycles * d.random.uniform(0.05, 0.3),
    },
    "leaking_charge": lambda d: {"time_s": 0.5 / (d.nominal.frequency_Hz * d.between(0.07, 0.6))},
    "ringing_force_cell": lambda d: {
        "natural_frequency_Hz": d.nominal.frequency_Hz / d.between(0.03, 0.12),
        "damping": d.spread(0.03, 0.15),
    },
    "hysteretic_displacement": lambda d: {"share": d.between(0.03, 0.25)},
    "fading_supply": lambda d: {"change": d.between(0.02, 0.2) * d.sign(0.3), "cycles": d.cycles},
    "creeping_joint": lambda d: {
        "um_per_N": d.length_um(0.6, 6.0) / d.plateau_N,
        "time_s": d.spread(0.06, 0.4) / d.nominal.frequency_Hz,
    },
    "dragging_guide": lambda d: {
        "force_N": d.between(0.02, 0.2) * d.plateau_N,
        "over_um": d.nominal.amplitude_um * d.spread(0.02, 0.1),
    },
    "sticking_lever": lambda d: {
        "share": d.between(0.006, 0.08) * d.sign(),
        "over_um": d.nominal.amplitude_um * d.spread(0.05, 0.3),
    },
    "bouncing_weight": lambda d: {
        "share": d.between(0.04, 0.35),
        "phase_rad": d.random.uniform(0.25 * pi, 0.75 * pi) * d.sign(),
    },
    "hooked_friction": lambda d: {"rise": d.between(0.04, 0.4) * d.sign(0.8)},
    "film_breakthrough": lambda d: {
        "share": d.between(0.05, 0.35) * d.sign(0.8),
        "cycle": d.nominal.cycles * d.spread(0.02, 0.3),
        "abruptness": d.random.uniform(3.0, 8.0),
    },
    "relaxing_load": lambda d: {"loss": d.between(0.025, 0.25), "cycles": d.nominal.cycles * d.spread(0.003, 0.03)},
    "unequal_wear": lambda d: {"moving_share": 0.5 + d.between(0.05, 0.4) * d.sign()},
    "pressure_dependent_wear": _pressure_wear,
    "one_sided_holder": lambda d: {"um_per_N": d.length_um(0.8, 8.0) / d.plateau_N * d.sign()},
    "other_gauge": lambda d: {"diameter_factor": d.between(1.12, 1.5) ** d.sign()},
    **WITHHELD,
    **RESERVED,
}
