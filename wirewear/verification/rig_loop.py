"""Gross-slip loop behind the rig's spring, without wear: `wirewear.reference.rig_loop`.

The bulk compliance of the wires is in series with the rig's spring, so the closed form is evaluated with both.
"""

from __future__ import annotations

from wirewear import reference
from wirewear.loops.area import enclosed_area
from wirewear.verification.level import Level
from wirewear.verification.rows import Row, compared
from wirewear.verification.sliding import (
    FRICTION,
    AMPLITUDE_mm,
    RIG_STIFFNESS_N_per_mm,
    half_width_at_zero_force,
    sliding_wires,
    whole_loop,
)
from wirewear.verification.wires import (
    LOAD_N,
    STEEL,
    CONTACT_RADIUS_mm,
    condensed,
    crossed_bulk_compliance,
    wire_geometry,
)

_TOLERANCE = 0.01


def rig_loop_rows(level: Level) -> tuple[Row, ...]:
    """Friction work, loop area, width at zero force and largest force of a loop."""
    body = condensed(wire_geometry(level.loop_resolution, long_patch=True))
    bulk = crossed_bulk_compliance(body, normal=False, contact_radius_mm=CONTACT_RADIUS_mm)
    contact = reference.partial_slip_point(
        LOAD_N, FRICTION, CONTACT_RADIUS_mm, reference.tangential_contact_modulus(STEEL, STEEL)
    )
    rig = 1.0 / (1.0 / RIG_STIFFNESS_N_per_mm + bulk)
    energy = reference.dissipated_energy(contact, AMPLITUDE_mm, rig)
    width = reference.slip_amplitude(contact, AMPLITUDE_mm, rig)
    raw_energy = energy - reference.dissipated_energy(contact, AMPLITUDE_mm, RIG_STIFFNESS_N_per_mm)
    raw_width = width - reference.slip_amplitude(contact, AMPLITUDE_mm, RIG_STIFFNESS_N_per_mm)
    trace = whole_loop(sliding_wires(level.loop_resolution))
    name = f"Rig loop, mesh a/{level.loop_resolution:g}"
    work, half_width = trace.friction_work, half_width_at_zero_force(trace.drive, trace.tangential_force)
    force = float(trace.tangential_force.max())
    area = abs(enclosed_area(trace.drive, trace.tangential_force))
    return (
        compared(name, "E_d as friction work [mJ]", work, energy, _TOLERANCE, raw=work + raw_energy),
        compared(name, "E_d as loop area [mJ]", area, energy, _TOLERANCE, raw=area + raw_energy),
        compared(name, "δ0 [mm]", half_width, width, _TOLERANCE, raw=half_width + raw_width),
        compared(name, "largest force [N]", force, contact.limit_N, 1e-3),
    )
