"""How large causes of the reserved set are drawn, as `sizes` does for all others."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import pi

from studies.blind.generators.draw import Draw
from studies.blind.generators.withheld_sizes import scar_depth_um, turning_phase


def _encoder(d: Draw) -> dict[str, float]:
    """Scales of some ten micrometres; errors beyond a sixth of a line, 1/2π, would make the reading run backwards."""
    pitch = d.spread(16.0, 40.0)
    return {
        "error_um": pitch * d.between(0.02, 0.13),
        "pitch_um": pitch,
        "phase_rad": d.random.uniform(-pi, pi),
    }


def _spall(d: Draw) -> dict[str, float]:
    """Late, as cracks take their time, and within the scar."""
    half_um = 1e3 * d.nominal.expected_scar_mm
    return {
        "cycle": d.nominal.cycles * d.random.uniform(0.5, 0.95),
        "depth_um": scar_depth_um(d) * d.between(0.08, 0.5),
        "radius_um": half_um * d.random.uniform(0.2, 0.45),
        "x_um": half_um * d.random.uniform(-0.3, 0.3),
        "y_um": half_um * d.random.uniform(-0.3, 0.3),
    }


#: Parameters of each cause as drawn.
RESERVED: Mapping[str, Callable[[Draw], dict[str, float]]] = {
    "cyclic_encoder": _encoder,
    "coarse_converter": lambda d: {"step_N": d.between(0.06, 0.5) * d.plateau_N},
    "laser_out_of_range": lambda d: {"limit_um": d.nominal.amplitude_um * (1.0 - d.between(0.012, 0.12)) * d.sign()},
    "halting_logger": lambda d: {"time_s": turning_phase(d, 0.5, 8.0) / (2.0 * pi * d.nominal.frequency_Hz)},
    "stick_slip": lambda d: {"share": d.between(0.06, 0.5), "per_stroke": float(d.random.integers(4, 9))},
    "rolling_debris": lambda d: {"loss": d.between(0.05, 0.4), "over": d.random.uniform(0.25, 0.55)},
    "spreading_glaze": lambda d: {
        "share": d.between(0.008, 0.1) * d.sign(0.7),
        "end": d.sign(),
        "cycles": d.nominal.cycles * d.spread(0.4, 2.0),
    },
    "snapping_leaf": lambda d: {
        "jump_um": d.length_um(1.0, 9.0),
        "force_N": d.random.uniform(0.35, 0.75) * d.plateau_N,
    },
    "telescoping_slide": lambda d: {"um_per_N": d.length_um(0.8, 8.0) / d.plateau_N * d.sign()},
    "orbiting_holder": lambda d: {"across": d.between(0.05, 0.3)},
    "hunting_servo": lambda d: {
        "share": d.between(0.008, 0.1),
        "frequency_Hz": d.nominal.frequency_Hz * (d.random.integers(2, 7) + d.random.uniform(0.2, 0.8)),
    },
    "touching_stop": lambda d: {"share": d.between(0.01, 0.1) * d.sign(), "begins": d.random.uniform(0.2, 0.6)},
    "sticking_slide": lambda d: {
        "loss": d.between(0.02, 0.22),
        "cycles": d.nominal.cycles / d.random.uniform(3.3, 6.5) ** 2,
    },
    "lopsided_wear": lambda d: {"slant": d.between(0.08, 0.8) * d.sign()},
    "spalled_flake": _spall,
    "remounted_wire": lambda d: {
        "cycle": d.nominal.cycles * d.spread(0.1, 0.6),
        "aside_um": 1e3 * d.nominal.expected_scar_mm * d.between(0.01, 0.14) * d.sign(),
    },
    "grooved_wire": lambda d: {
        "depth_um": scar_depth_um(d) * d.between(0.012, 0.14),
        "half_width_um": 1e3 * d.nominal.expected_scar_mm * d.random.uniform(0.15, 0.4),
        "aside_um": 1e3 * d.nominal.expected_scar_mm * d.random.uniform(-0.4, 0.4),
    },
}
