# ruff: noqa: F403, F405
"""Closed-form solutions for plots and for tests of the solver, in N, mm, MPa and mJ."""

from geometry import Elastic
from wirewear.reference.cattaneo_mindlin import *
from wirewear.reference.conforming import *
from wirewear.reference.half_space import *
from wirewear.reference.hertz import *
from wirewear.reference.hertz import first_yield_ratio, kept_approach
from wirewear.reference.wear import *

#: What this package offers of what its modules define.
__all__ = [
    "CrossedWireScar", "Elastic", "HysteresisLoop", "LimitingShape", "LineContact", "LineScar", "PartialSlipPoint",
    "PinContact", "PointContact", "WearingContact", "branch_force", "closed_loop",
    "contact_modulus", "crossed_wire_scar", "displacement_after_reversal", "dissipated_energy",
    "elliptic_stiffness", "energy_per_cycle", "even_line_contact", "even_line_load", "even_line_scar",
    "explicit_stability_limit", "first_loading_force", "first_yield_ratio", "force_amplitude", "gap_curvatures",
    "half_plane_line_stiffness", "hertz_bodies", "hertz_crossed_cylinders", "hertz_elliptic", "hertz_line",
    "hertz_point", "hertz_stress", "kept_approach", "line_contact_scar", "line_energy_per_cycle",
    "line_loading_traction",
    "line_partial_slip_stress", "line_stick_ratio", "line_stick_ratio_after_reversal", "line_stick_shift",
    "line_stress", "line_traction_after_reversal", "loading_displacement", "loading_force", "loading_traction",
    "mindlin_stiffness", "partial_slip_point", "partial_slip_stress", "pin_in_bore", "pin_scar",
    "relative_curvatures", "semi_axis_ratio", "sliding_stress", "sliding_threshold",
    "slip_amplitude", "stick_radius", "stick_radius_after_reversal", "tangential_contact_modulus",
    "traction_after_reversal", "turned_contact", "turned_load", "turned_scar", "unloading_stiffness",
    "worn_pressure", "worn_under_load", "worn_volume",
]  # fmt: skip
