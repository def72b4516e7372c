"""A pin in a bore, meshed as in runs: against Persson's contact, and as it slides up the bore's wall.

Rows compare a computed quantity with a closed form, on the meshes and with the tolerance of a level. A half-angle is
that of the contact, seen from the pin's centre.
"""

import numpy as np

from geometry import Elastic, build_planar
from solvers import ContactProblem, ContactState, Holder, WearRates, advance, condense, place, press, unloaded_state
from wirewear import reference
from wirewear.simulation import line_plan
from wirewear.test import LineStudy, study_from_tables
from wirewear.verification.rows import Level, Row, compared

PIN_mm, CLEARANCE_mm = 10.0, 0.005
_STEEL = {"youngs_modulus_MPa": 210_000.0, "poissons_ratio": 0.3}
_HALF_ANGLES_deg = (10.0, 40.0, 80.0)
_TOLERANCE = 0.03
# A light pin touches the bore nearly at a point, where statics alone give the force.
_LIGHT_N, _FRICTION, _WIDE_mm, _SHARE = 1.0, 0.3, 0.1, 0.3


def pin_rows(level: Level) -> tuple[Row, ...]:
    """Rows on contact angle and peak pressure, and on the force that moves a light pin up and down its bore."""
    rows: list[Row] = []
    for degrees in _HALF_ANGLES_deg:
        exact = pin_of_half_angle(np.radians(degrees))
        problem = pressed_pin(exact.normal_load_N_per_mm, CLEARANCE_mm, level.fidelity)
        state, report = press(problem, unloaded_state(problem))
        name = f"Pin in a bore, contact over ±{degrees:g}°"
        angle, peak = np.degrees(half_angle(problem, state)), float(exact.pressure(0.0))
        rows += [
            compared(name, "half-angle [°]", angle, degrees, _TOLERANCE),
            compared(name, "peak pressure [MPa]", report.max_pressure, peak, _TOLERANCE),
        ]
    return (*rows, *climbing_rows())


def climbing_rows() -> tuple[Row, ...]:
    """Rows on force over load of a pin beside the middle of its bore: tan(ψ + atan µ) on its way up, tan(ψ − atan µ)
    down.

    It has moved by sin ψ clearances.
    """
    problem = pressed_pin(_LIGHT_N, _WIDE_mm, "quick", _FRICTION, _SHARE * _WIDE_mm)
    state, _ = press(problem, unloaded_state(problem))
    slope, friction = np.arcsin(_SHARE), np.arctan(_FRICTION)
    up = advance(problem, state, _SHARE * _WIDE_mm, 0.0)[0]
    # A little of the way back all slips downwards.
    down = advance(problem, up, (_SHARE - 0.01) * _WIDE_mm, 0.0)[0]
    back = np.arcsin(_SHARE - 0.01)
    return tuple(
        compared(
            "Light pin in a bore", f"Q/P, {way}", float(of.primary_force[:, 0].sum()) / _LIGHT_N, exact, _TOLERANCE
        )
        for way, of, exact in (("up", up, np.tan(slope + friction)), ("down", down, np.tan(back - friction)))
    )


def pin_of_half_angle(half_angle_rad: float) -> reference.PinContact:
    """The closed form of the steel pin in its bore, under the load per mm at which its contact has this half-angle."""
    modulus = 0.5 * _STEEL["youngs_modulus_MPa"] / (1.0 - _STEEL["poissons_ratio"] ** 2)
    unit = reference.PinContact(1.0, PIN_mm, half_angle_rad)
    load = 2.0 * modulus * CLEARANCE_mm / unit.clearance_share
    return reference.pin_in_bore(load, PIN_mm, PIN_mm + CLEARANCE_mm, modulus)


def pressed_pin(
    load_N: float, clearance_mm: float, fidelity: str, friction: float = 1e-6, stroke_mm: float = 1e-4
) -> ContactProblem:
    """Contact problem of a millimetre of a steel pin in a large plate, meshed as a run of that fidelity and stroke."""
    study: LineStudy = study_from_tables(
        {
            "format": 1,
            "name": "pin",
            "kind": "line-contact",
            "pad": {"radius_mm": PIN_mm, **_STEEL},
            "specimen": {"bore_radius_mm": PIN_mm + clearance_mm, "height_mm": 20.0 * PIN_mm, **_STEEL},
            "conditions": {"normal_load_N": load_N, "displacement_amplitude_um": 1e3 * stroke_mm, "cycles": 1},
            "contact": {"friction": friction, "length_mm": 1.0},
        },
        "the verification",
    )
    meshes, elastic = line_plan(study, fidelity), Elastic(**_STEEL)
    pin, plate = (
        place(condense(body.mesh, body.patch, elastic), upper=upper, axis_angle_rad=0.0)
        for upper, body in ((True, build_planar(meshes.pad)), (False, build_planar(meshes.specimen)))
    )
    return ContactProblem(pin, plate, holder=Holder(load_N), friction=friction, wear=WearRates())


def half_angle(problem: ContactProblem, state: ContactState) -> float:
    """Half-angle of the contact in rad: where the square of the pressure, which falls linearly there, would vanish."""
    angle = np.arcsin(problem.primary.node_positions[:, 0] / PIN_mm)  # The bore's radius is all but the pin's.
    squared = state.traction[:, 2] ** 2
    last = np.flatnonzero((angle > 0.0) & (squared > 0.0))[-3:]
    slope, constant = np.polyfit(angle[last], squared[last], 1)
    return float(-constant / slope)
