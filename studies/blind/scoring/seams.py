"""The seam at which each cause of no library enters: where a diagnosis should look that calls a gap unexplained."""

from __future__ import annotations

from collections.abc import Mapping

from studies.blind.generators.others.causes import SEAMS as OF_OTHERS

#: Causes by the names of their seams; what a force cell bears beside the contact counts as the sensor's.
_AT: Mapping[str, tuple[str, ...]] = {
    "sensor": (
        "thermal_gain_drift",
        "saturating_force_cell",
        "asymmetric_force_cell",
        "force_cell_hysteresis",
        "creeping_force_zero",
        "bent_displacement_sensor",
        "displacement_backlash",
        "parallel_spring",
        "leaking_charge",
        "ringing_force_cell",
        "hysteretic_displacement",
        "fading_supply",
        "creeping_joint",
        "dragging_guide",
        "overloaded_cell",
        "loose_plug",
        "slew_limited_amplifier",
        "crossover_distortion",
        "averaging_logger",
        "cyclic_encoder",
        "coarse_converter",
        "laser_out_of_range",
        "halting_logger",
    ),
    "contact": (
        "reversal_adhesion",
        "velocity_dependent_friction",
        "debris_ejection",
        "slanted_friction",
        "rippled_friction",
        "breathing_friction",
        "hooked_friction",
        "film_breakthrough",
        "shedding_film",
        "changing_air",
        "hard_spot",
        "debris_ridge",
        "thinning_grease",
        "stick_slip",
        "rolling_debris",
        "spreading_glaze",
    ),
    "holder": (
        "clamp_slip",
        "stiffening_holder",
        "loosening_holder",
        "one_sided_holder",
        "cracking_flexure",
        "wearing_pivot",
        "opening_joint",
        "microslipping_joint",
        "snapping_leaf",
        "telescoping_slide",
        "orbiting_holder",
    ),
    "loading": (
        "bent_guide",
        "slanted_load",
        "sticking_lever",
        "bouncing_weight",
        "relaxing_load",
        "rattling_weight",
        "swinging_load",
        "hunting_servo",
        "touching_stop",
        "sticking_slide",
    ),
    "wear": (
        "severe_wear",
        "unequal_wear",
        "pressure_dependent_wear",
        "incubated_wear",
        "hard_skin",
        "lopsided_wear",
        "spalled_flake",
    ),
    "specimens": ("other_gauge", "used_wire", "rolled_wire", "remounted_wire", "grooved_wire"),
}

#: The seam of every cause of no library, by its name.
OUTSIDE_SEAMS: Mapping[str, str] = {name: seam for seam, names in _AT.items() for name in names} | OF_OTHERS
