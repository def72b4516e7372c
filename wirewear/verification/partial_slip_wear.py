"""Wear under partial slip and constant approach, against the shape at which it ends.

The shape depends steeply on the radius of the stuck core: a hundredth of it is a tenth of the worn volume. The core's
edge is resolved by whole nodes, so what is left of the volume's error is that of a small part of an element.
"""

from math import pi, sqrt
from typing import Any

from solvers import (
    ContactProblem,
    ContactState,
    Holder,
    WearRates,
    closed_trace,
    first_quarter,
    jump_cycles,
    kept_by,
    press,
    symmetry_of,
    unloaded_state,
)
from wirewear import reference
from wirewear.planar import PlanarStudy, planar_study_from_tables, run_planar_study
from wirewear.results import RunResult
from wirewear.simulation import last_of
from wirewear.verification.hertz import (
    LOAD_N,
    STEEL,
    CONTACT_MODULUS_MPa,
    CONTACT_RADIUS_mm,
    RADIUS_mm,
    condensed,
    crossed,
    crossed_bulk_compliance,
    element_mm,
    wire_geometry,
)
from wirewear.verification.rows import Level, Row, compared

_MIRROR_TOLERANCE = 0.02
_PRESSURE_TOLERANCE = 0.05
_JUMP_TOLERANCE = 0.005
#: Columns of the evolution.
_PRESSURES = {"mid_stroke_pressure_MPa": "pressure at mid-stroke", "max_mean_pressure_MPa": "largest mean pressure"}
#: What is made finer. The tolerance of jumps goes with the square of their change.
_FINER = {
    "half the elements' size": {"mesh_refinement": 2.0},
    "twice the positions": {"increments_refinement": 2.0},
    "half the jumps": {"jump_tolerance": 0.25 * _JUMP_TOLERANCE},
}

_FRICTION = 0.6
_APPROACH_mm = CONTACT_RADIUS_mm**2 / RADIUS_mm
#: About two thirds of the fresh contact stick.
_AMPLITUDE_mm = 2.0e-4
_RATE_mm3_per_mJ = 1.5e-7
_INCREMENTS = 16
#: Jumps of growing size until next to nothing wears.
_JUMPS = tuple(9.0 * 2.5**k for k in range(11))
_DEPTH_TOLERANCE = 0.5


def worn_pressure_rows(level: Level) -> tuple[Row, ...]:
    """The worst mirror error, and beside finer runs the pressure at a node about mid-stroke and the largest mean."""
    cycles = level.worn_line_cycles
    name, own = f"Worn line contact, {cycles} cycles", _worn(cycles, {})
    mirror = compared(
        name, "mirror error of the pressures", own.quality["mirror_error"], 0.0, _MIRROR_TOLERANCE, scale=1.0
    )
    finer = {what: _worn(cycles, mesh) for what, mesh in _FINER.items()}
    pressures = (
        compared(
            name, f"{quantity} [MPa], exact: {what}", last_of(column)(own), last_of(column)(other), _PRESSURE_TOLERANCE
        )
        for what, other in finer.items()
        for column, quantity in _PRESSURES.items()
    )
    return (mirror, *pressures)


def _worn(cycles: int, mesh: dict[str, float]) -> RunResult:
    return run_planar_study(_study(cycles, {"jump_tolerance": _JUMP_TOLERANCE} | mesh), fidelity="quick")


def _study(cycles: int, mesh: dict[str, float]) -> PlanarStudy:
    """A steel cylinder in gross slip on a rigid rig."""
    steel = {"youngs_modulus_MPa": 2e5, "poissons_ratio": 0.3}
    tables: dict[str, Any] = {
        "format": 1,
        "name": "worn line contact",
        "kind": "cylinder-on-flat",
        "pad": {"radius_mm": 6.0, **steel},
        "specimen": steel,
        "conditions": {"normal_load_N_per_mm": 20.0, "displacement_amplitude_um": 30.0, "cycles": cycles},
        "contact": {"friction": 0.6},
        "wear": {"pad_energy_mm3_per_J": 2e-5, "specimen_energy_mm3_per_J": 4e-5},
        "log": {"loop_cycles": [1, cycles]},
        "mesh": mesh,
    }
    return planar_study_from_tables(tables, "the reference problem")


def partial_slip_wear_rows(level: Level) -> tuple[Row, ...]:
    """Radius of the stuck core, worn volume and largest depth of both wires after wear has ended."""
    body = condensed(wire_geometry(level.partial_slip_wear_resolution))
    bulk = [crossed_bulk_compliance(body, normal=n, contact_radius_mm=CONTACT_RADIUS_mm) for n in (True, False)]
    shear = reference.tangential_contact_modulus(STEEL, STEEL)
    contact = reference.WearingContact(RADIUS_mm, CONTACT_MODULUS_MPa, shear, _FRICTION, _AMPLITUDE_mm, *bulk)
    exact = contact.under_approach(_APPROACH_mm)
    rates = WearRates(_RATE_mm3_per_mJ, _RATE_mm3_per_mJ)
    holder = Holder(LOAD_N, approach_mm=_APPROACH_mm)
    problem = crossed(body, body, holder, friction=_FRICTION, wear=rates)
    worn = _worn_out(problem)
    wear, name = worn.wear, f"Partial slip, worn out, {CONTACT_RADIUS_mm / element_mm(body):.1f} elements a radius"
    radius = sqrt(float(problem.surface.areas[worn.core].sum()) / pi)
    volume = wear.primary_volume_mm3 + wear.secondary_volume_mm3
    # Equal wires crossed at right angles: what is axial on one is transverse on the other.
    depth = float((wear.primary_depth + wear.secondary_depth.T).max())
    size = element_mm(body)
    return (
        compared(name, "radius that sticks [mm]; error in elements", radius, exact.stick_radius_mm, 1.0, scale=size),
        compared(name, "worn volume of both wires [mm³]", volume, exact.volume_mm3, level.partial_slip_wear_tolerance),
        compared(name, "largest depth of both wires [mm]", depth, exact.deepest_mm[0], _DEPTH_TOLERANCE),
    )


def _worn_out(problem: ContactProblem) -> ContactState:
    """The state at the end of the stroke after all jumps."""
    pressed, _ = press(problem, unloaded_state(problem))
    state, done, guide = first_quarter(problem, pressed, _AMPLITUDE_mm, _INCREMENTS), 1.0, None
    symmetry = symmetry_of(problem)
    for cycles in _JUMPS:
        kept = kept_by(symmetry, state)
        start, trace = closed_trace(problem, state, _AMPLITUDE_mm, _INCREMENTS, kept, guide=guide)
        jump = jump_cycles(lambda *_: problem, start, trace, kept, done, cycles)
        state, guide, done = jump.state, jump.guide, done + cycles
    return closed_trace(problem, state, _AMPLITUDE_mm, _INCREMENTS, kept_by(symmetry, state), guide=guide)[0]
