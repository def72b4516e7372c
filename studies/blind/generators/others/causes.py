"""How large effects of the contract and causes of no library are drawn for tests by others.

Sizes are relative to the test: from one that hardly shows to one that nobody overlooks, evenly in their logarithm.
"""

from collections.abc import Callable, Mapping

import numpy as np

from studies.blind.generators.others.tests_drawn import Test

#: Part of the range, between 0 (small) and 1 (large), of hard and of easy cases.
PART = {"hard": (0.0, 0.5), "easy": (0.5, 1.0)}

#: Causes of no library by the seam at which each enters.
SEAMS = {
    "switched_range": "sensor",
    "yielding_cell": "sensor",
    "loose_gauge": "sensor",
    "stribeck_friction": "contact",
    "jammed_end": "contact",
    "slipping_grip": "holder",
    "hardening_holder": "holder",
    "late_load": "loading",
    "bowed_guide": "loading",
    "swinging_load": "loading",
    "mild_wear": "wear",
    "uneven_bodies": "wear",
}


class _Size:
    """What a size is drawn from."""

    def __init__(self, ease: str, test: Test, random: np.random.Generator) -> None:
        self.part, self.test, self.random = random.uniform(*PART[ease]), test, random
        self.force_N = test.friction * test.load_N

    def between(self, low: float, high: float) -> float:
        return float(low * (high / low) ** self.part)

    def either(self, low: float, high: float) -> float:
        """A size of either sign."""
        return self.between(low, high) * float(self.random.choice([-1.0, 1.0]))

    def any(self, low: float, high: float) -> float:
        """A value that does not follow the size."""
        return float(np.exp(self.random.uniform(np.log(low), np.log(high))))

    def way_um(self, low: float, high: float) -> float:
        """A share of the stroke [µm]."""
        return self.between(low, high) * self.test.amplitude_um

    @property
    def cycles(self) -> float:
        """Within which something settles."""
        return self.any(0.01, 0.4) * self.test.cycles


def _friction_evolution(d: _Size) -> dict[str, float]:
    friction = d.test.friction
    return {"initial": friction * (1.0 + d.either(0.03, 0.35)), "final": friction, "cycles": d.cycles}


def _wear_evolution(d: _Size) -> dict[str, float]:
    return {"initial_factor": 1.0 + d.between(0.3, 5.0), "final_factor": 1.0, "cycles": d.cycles}


def _rotational(d: _Size) -> dict[str, float]:
    arm = d.any(5.0, 80.0)
    return {"stiffness_N_mm_per_rad": 1e3 * arm**2 * d.force_N / d.way_um(0.01, 0.15), "arm_mm": arm}


def _coupling(d: _Size) -> dict[str, float]:
    linear = d.way_um(0.01, 0.12) / d.force_N * float(d.random.choice([-1.0, 1.0]))
    return {"linear_um_per_N": linear, "quadratic_um_per_N2": d.random.uniform(-0.4, 0.4) * linear / d.force_N}


def _grip(d: _Size) -> dict[str, float]:
    holds = d.random.uniform(0.4, 0.75)
    return {"holds": holds, "mm": 1e-3 * d.way_um(0.02, 0.15) / (1.0 - holds)}


SIZES: Mapping[str, Callable[[_Size], dict[str, float]]] = {
    "tangential_compliance": lambda d: {"stiffness_N_per_mm": 1e3 * d.force_N / d.way_um(0.01, 0.15)},
    "rotational_compliance": _rotational,
    "free_play": lambda d: {"gap_um": d.way_um(0.01, 0.15)},
    "friction_offset": lambda d: {"friction": d.test.friction * (1.0 + d.either(0.02, 0.25))},
    "friction_evolution": _friction_evolution,
    "roughness_compliance": lambda d: {"layer_um": d.between(0.5, 6.0), "cycles": d.cycles},
    "third_body": lambda d: {"retained_fraction": d.between(0.08, 0.6), "modulus_MPa": d.any(300.0, 5000.0)},
    "plasticity": lambda d: {"flattening_um": d.between(0.3, 4.0)},
    "crossing_angle_error": lambda d: {"angle_deg": d.either(1.0, 8.0)},
    "misalignment": lambda d: {"angle_deg": d.either(0.15, 3.0)},
    "normal_load_drift": lambda d: {"fraction_per_100k_cycles": 1e5 * d.either(0.02, 0.25) / d.test.cycles},
    "wear_rate_offset": lambda d: {"factor": float(d.between(1.1, 2.5) ** d.random.choice([-1.0, 1.0]))},
    "wear_rate_evolution": _wear_evolution,
    "displacement_gain": lambda d: {"gain": 1.0 + d.either(0.01, 0.15)},
    "displacement_load_coupling": _coupling,
    "force_crosstalk": lambda d: {"coefficient": d.either(0.003, 0.05)},
    "sensor_lag": lambda d: {"time_s": d.between(0.004, 0.08) / (2.0 * np.pi * d.test.frequency_Hz)},
    "switched_range": lambda d: {"factor": 1.0 + d.either(0.02, 0.2), "cycle": d.any(0.02, 0.6) * d.test.cycles},
    "yielding_cell": lambda d: {"loss": d.between(0.02, 0.2)},
    "loose_gauge": lambda d: {"loss": d.between(0.015, 0.15)},
    "stribeck_friction": lambda d: {"rise": d.between(0.04, 0.4)},
    "jammed_end": lambda d: {"rise": d.between(0.05, 0.5)},
    "slipping_grip": _grip,
    "hardening_holder": lambda d: {"mm": 1e-3 * d.way_um(0.015, 0.12)},
    "late_load": lambda d: {"share": d.either(0.02, 0.2)},
    "bowed_guide": lambda d: {"share": d.either(0.04, 0.35)},
    "swinging_load": lambda d: {"share": d.between(0.02, 0.15), "turns": d.random.uniform(1.5, 5.0) / d.test.cycles},
    "mild_wear": lambda d: {"factor": 1.0 / d.between(1.5, 8.0), "cycle": d.any(0.03, 0.4) * d.test.cycles},
    "uneven_bodies": lambda d: {"moving_share": 0.5 + d.either(0.08, 0.42)},
}


def sizes(effect: str, ease: str, test: Test, random: np.random.Generator) -> dict[str, float]:
    """Parameters of an effect, five digits each."""
    return {name: float(f"{value:.5g}") for name, value in SIZES[effect](_Size(ease, test, random)).items()}
