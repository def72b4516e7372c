"""The rig's stiffness without the contact's: what a loop gives way, less what the contact takes of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq

from wirewear.loops.branches import remaining_force
from wirewear.reference import Elastic, hertz_crossed_cylinders, mindlin_stiffness, tangential_contact_modulus

if TYPE_CHECKING:
    from wirewear.records import ExperimentRecord

#: Displacement to full slip is this multiple of force over initial stiffness (Mindlin).
FULL_SLIP = 1.5


def contact_stiffness_N_per_um(record: ExperimentRecord) -> float:
    """Mindlin's 2G*a of the unworn wires under the record's load."""
    wires = record.tables.wires
    radius = 0.5 * wires.diameter_mm
    body = Elastic(wires.youngs_modulus_MPa, wires.poissons_ratio)
    load, angle = record.tables.conditions.normal_load_N, wires.crossing_angle_deg
    hertz = hertz_crossed_cylinders(load, radius, radius, angle, first=body, second=body)
    return 1e-3 * mindlin_stiffness(tangential_contact_modulus(body, body), hertz.contact_radius_mm)


def loop_stiffness(contact_N_per_um: float, rig_um_per_N: float) -> float:
    """K_t,m of a contact and a rig in series, by the definition of the loops' analysis: a line over half the region."""
    contact = FULL_SLIP / contact_N_per_um
    travel = np.linspace(0.0, 0.5, 101)
    slope = np.polyfit(travel, remaining_force(travel, contact / (contact + rig_um_per_N)), 1)[0]
    return float(-slope / (contact + rig_um_per_N))


def rig_compliance(measured_N_per_um: float, contact_N_per_um: float) -> float:
    """Compliance of the rig in µm/N, 1/K_rig = 1/K_t,m − 1/K_c; 0 where the contact takes all of it."""
    if loop_stiffness(contact_N_per_um, 0.0) <= measured_N_per_um:
        return 0.0
    most = 2.0 / measured_N_per_um
    return float(brentq(lambda c: loop_stiffness(contact_N_per_um, c) - measured_N_per_um, 0.0, most))
