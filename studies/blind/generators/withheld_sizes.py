"""How large causes of the withheld set are drawn, as `sizes` does for all others."""

from collections.abc import Callable, Mapping
from math import acos, pi

from studies.blind.generators.draw import Draw

OWN_FLANK = 0.5  #: Share of the spring's way that counts: the force turns faster than on average towards the end of it.


def _plug(d: Draw) -> dict[str, float]:
    """Two bad spells, early and late, between them a good one."""
    moments = (d.spread(0.004, 0.02), d.spread(0.03, 0.1), d.spread(0.15, 0.3), d.spread(0.45, 0.9))
    zero = d.between(0.004, 0.035) * d.plateau_N * d.sign()
    return {"zero_N": zero, **{f"cycle_{i}": d.nominal.cycles * part for i, part in enumerate(moments, start=1)}}


def turning_phase(d: Draw, low: float, high: float) -> float:
    """Phase after a reversal within which a part of the way is passed that the rig's spring takes, and so many µm more.

    A cosine moves by d within the phase arccos(1 − d/A) after its reversal.
    """
    stiffness = d.nominal.stiffness_N_per_mm
    spring_um = 0.0 if stiffness is None else 2e3 * d.plateau_N / stiffness
    return acos(1.0 - (OWN_FLANK * spring_um + d.length_um(low, high)) / d.nominal.amplitude_um)


def _air(d: Draw) -> dict[str, float]:
    """Three changes of the weather in some hours or days; the middle one is back beyond the first state."""
    size, sign = d.between(0.025, 0.2), d.sign()
    factors = (1.0 + size * sign, 1.0 - size * sign * d.random.uniform(0.2, 0.8), 1.0 + size * sign)
    moments = (d.spread(0.02, 0.08), d.spread(0.12, 0.25), d.spread(0.4, 0.8))
    cycles = d.nominal.cycles
    return {
        **{f"factor_{i}": factor for i, factor in enumerate(factors, start=1)},
        **{f"cycle_{i}": cycles * part for i, part in enumerate(moments, start=1)},
    }


def scar_depth_um(d: Draw) -> float:
    """Depth of both expected scars together, h²/2R of crossed wires."""
    return 1e3 * d.nominal.expected_scar_mm**2 / d.nominal.diameter_mm


def _opening(d: Draw) -> dict[str, float]:
    preload = d.random.uniform(0.35, 0.75) * d.plateau_N
    return {"preload_N": preload, "um_per_N": d.length_um(0.4, 3.5) / (d.plateau_N - preload)}


#: Parameters of each cause as drawn.
WITHHELD: Mapping[str, Callable[[Draw], dict[str, float]]] = {
    "overloaded_cell": lambda d: {
        "loss": d.between(0.02, 0.2),
        "zero_N": d.between(0.003, 0.03) * d.plateau_N * d.sign(),
        "cycle": d.nominal.cycles * d.spread(0.02, 0.25),
    },
    "loose_plug": _plug,
    # The force turns by 2 µP within that phase.
    "slew_limited_amplifier": lambda d: {
        "N_per_s": 4.0 * pi * d.nominal.frequency_Hz * d.plateau_N / turning_phase(d, 2.0, 8.0)
    },
    "crossover_distortion": lambda d: {"band_N": d.between(0.02, 0.2) * d.plateau_N},
    "averaging_logger": lambda d: {"time_s": d.between(0.03, 0.16) / d.nominal.frequency_Hz},
    "cracking_flexure": lambda d: {
        "um_per_N": d.length_um(0.45, 3.5) / d.plateau_N,
        "cycles": float(d.nominal.cycles),
        "power": d.random.uniform(2.0, 5.0),
    },
    "wearing_pivot": lambda d: {"gap_um": d.length_um(1.0, 9.0), "cycles": float(d.nominal.cycles)},
    "opening_joint": _opening,
    "microslipping_joint": lambda d: {"um_per_N2": d.length_um(0.7, 6.0) / d.plateau_N**2},
    "shedding_film": lambda d: {
        "share": d.between(0.04, 0.3) * d.sign(0.7),
        "cycles": d.nominal.cycles * d.spread(0.17, 0.45),
    },
    "changing_air": _air,
    "hard_spot": lambda d: {
        "rise": d.between(0.04, 0.35) * d.sign(0.8),
        "place": d.random.uniform(-0.5, 0.5),
        "width": d.random.uniform(0.08, 0.2),
    },
    "debris_ridge": lambda d: {
        "force_N": d.between(0.01, 0.1) * d.plateau_N * d.sign(),
        "begins": d.random.uniform(0.3, 0.7),
        "cycles": d.nominal.cycles * d.spread(0.2, 1.0),
    },
    "thinning_grease": lambda d: {
        "force_N": d.between(0.03, 0.3) * d.plateau_N,
        "cycles": d.nominal.cycles * d.spread(0.05, 0.5),
    },
    "rattling_weight": lambda d: {
        "share": d.between(0.08, 0.6) * d.sign(),
        "frequency_Hz": d.nominal.frequency_Hz * d.spread(4.0, 9.0),
        "time_s": d.random.uniform(0.06, 0.14) / d.nominal.frequency_Hz,
    },
    "swinging_load": lambda d: {
        "share": d.between(0.02, 0.18),
        "cycles": d.nominal.cycles * d.spread(0.2, 0.7),
        "phase_rad": d.random.uniform(-pi, pi),
    },
    "incubated_wear": lambda d: {
        "share": d.random.uniform(0.85, 0.98),
        "cycle": d.nominal.cycles * d.between(0.06, 0.5),
        "abruptness": d.random.uniform(4.0, 10.0),
    },
    "hard_skin": lambda d: {
        "factor": d.between(0.75, 0.2) if d.random.random() < 0.7 else d.between(1.3, 3.0),
        "depth_um": scar_depth_um(d) * d.spread(0.1, 0.3),
    },
    "used_wire": lambda d: {
        "depth_um": scar_depth_um(d) * d.between(0.12, 0.55),
        "aside_um": 1e3 * d.nominal.expected_scar_mm * d.random.uniform(0.1, 0.5) * d.sign(),
    },
    "rolled_wire": lambda d: {"crown_factor": d.between(1.2, 2.2) ** d.sign(0.7)},
}


def _encoder(d: Draw) -> dict[str, float]:
    """Scales of some ten micrometres; errors beyond a sixth of a line, 1/2π, would make the reading run backwards."""
    pitch = d.spread(16.0, 40.0)
    return {"error_um": pitch * d.between(0.02, 0.13), "pitch_um": pitch, "phase_rad": d.random.uniform(-pi, pi)}


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
