"""Contacts that conform: a pin in a bore, at rest (Persson's contact) and sliding up its wall, and a taper in a hub.

A half-angle is that of the contact, seen from the pin's centre.
"""

from dataclasses import replace

import numpy as np

from geometry import EdgeGradedAxis, Elastic, Flat, PlanarGeometry, RoundedFlat, build_planar
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
#: Tapers: radius and thickness of the hub, overlap before the push, and how far the hub's edges are rounded.
_RADIUS_mm, _WALL_mm, _SEATED_mm, _EDGE_mm = 10.0, 10.0, 0.0005, 0.3


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


def taper_rows(level: Level) -> tuple[Row, ...]:
    """Rows on the force that pushes a pin into a hub, by length, taper, friction and push."""
    del level  # A finer mesh changes it by less than 0.01 %.
    found = []
    for length, rise, friction, push in ((20.0, 0.05, 0.1, 0.1), (40.0, 0.05, 0.1, 0.1), (40.0, 0.02, 0.4, 0.25)):
        closed = reference.Taper(_RADIUS_mm, _RADIUS_mm + _WALL_mm, length, rise, Elastic(**_STEEL))
        exact = closed.assembly_force_N(push, _SEATED_mm, friction)
        name = f"Taper of {length:g} mm, rise {rise:g}, µ {friction:g}"
        found.append(compared(name, "F [N]", pushed_taper_N(closed, friction, push), exact, _TOLERANCE))
    return tuple(found)


def pushed_taper_N(taper: reference.Taper, friction: float, push_mm: float) -> float:
    """Force in N that pushes a pin into its hub; both are rings of finite elements."""
    half, fine = 0.5 * taper.length_mm, 0.05
    along = EdgeGradedAxis(fine, 16.0 * fine, half - 0.5, half + 0.1)
    ring = PlanarGeometry(
        RoundedFlat(half, _EDGE_mm), half + 0.15, taper.hub_radius_mm - taper.radius_mm, along, growth=1.2,
        axis_mm=taper.radius_mm, rise=-taper.rise, held_end=-1,
    )  # fmt: skip
    further = replace(along, half_extent_mm=half + 0.1 + push_mm)
    pin = PlanarGeometry(
        Flat(), half + 0.15 + push_mm, taper.radius_mm, further, growth=1.2, axis_mm=-taper.radius_mm, rise=taper.rise
    )
    hub, shaft = (
        replace(place(condense(body.mesh, body.patch, taper.elastic), upper=up, axis_angle_rad=0.0), incline=taper.rise)
        for up, body in ((True, build_planar(ring)), (False, build_planar(pin)))
    )
    holder = Holder(1.0, approach_mm=_SEATED_mm)
    problem = ContactProblem(hub, shaft, holder=holder, friction=friction, wear=WearRates())
    state, _ = press(problem, unloaded_state(problem))
    for step in np.linspace(0.0, push_mm, 5)[1:]:
        state, _ = advance(problem, state, -step, 0.0)
    return float(2.0 * np.pi * taper.radius_mm * abs(state.primary_force[:, 0].sum()))


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
