"""The seam at which each cause of no library enters: where a diagnosis should look that calls a gap unexplained."""

from __future__ import annotations

from collections.abc import Mapping

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
    ),
    "holder": ("clamp_slip", "stiffening_holder", "loosening_holder", "one_sided_holder"),
    "loading": ("bent_guide", "slanted_load", "sticking_lever", "bouncing_weight", "relaxing_load"),
    "wear": ("severe_wear", "unequal_wear", "pressure_dependent_wear"),
    "specimens": ("other_gauge",),
}

#: The seam of every cause of no library, by its name.
OUTSIDE_SEAMS: Mapping[str, str] = {name: seam for seam, names in _AT.items() for name in names}
