"""Whole runs in partial slip: wires that wear, compared with their final shape, and contacts of other bodies at a
point.

They take the meshes, cycle jumps and loops of `wirewear run`. The core is the part of the contact that sticks for good.
Other bodies are a ball and barrels on flats and crossed cylinders; their bulk compliance (see `hertz`) is read from
their condensed compliance, as for wires.
"""

from collections.abc import Mapping
from math import pi, sqrt

import numpy as np

from solvers import CondensedBody, Holder
from wirewear import reference
from wirewear.simulation import discretise, simulate
from wirewear.test import Study, study_from_tables
from wirewear.test.gaps import hertz_of
from wirewear.verification import hertz
from wirewear.verification.partial_slip import FRICTION, sliding_rows
from wirewear.verification.rows import Level, Row, compared

_DIAMETER_mm = 0.45
_FRICTION = 0.62
_APPROACH_mm = 9.09e-4
_AMPLITUDE_mm = 4.5e-4
_CONTACT_RADIUS_mm = sqrt(_APPROACH_mm * 0.5 * _DIAMETER_mm)
#: Until next to nothing wears.
_CYCLES = 300_000
_INCREMENTS = 16
#: A node sticks where it slides by less than this share of the largest distance slid in the first cycle.
_STUCK = 0.02
_DEPTH_TOLERANCE = 0.15

_LOAD_N = 100.0
_SHARE = 0.7

#: Load of a ball, share of its friction at which the force is held, and cycles until next to nothing wears.
_HELD_N, _HELD_SHARE, _HELD_CYCLES = 40.0, 0.6, 20_000
_BALL_mm = 12.7

_WEAR = {"energy_wear_coefficient_mm3_per_J": 2.0e-5, "moving_share": 0.5}
_FLAT: Mapping[str, object] = {"shape": "flat"}
_BALL: Mapping[str, object] = {"shape": "ball", "diameter_mm": _BALL_mm}


def held_force_rows(_level: Level) -> tuple[Row, ...]:
    """Rows on volume and largest depth of both bodies and pressure in the middle, once a ball on a flat has ceased to
    wear under a held load and force, at quick fidelity.
    """
    result, (exact, volume) = simulate(held_force_study(), fidelity="quick"), held_force_shape()
    deep, modulus = exact.deepest_mm[0], hertz.CONTACT_MODULUS_MPa
    moving, fixed = (result.scar(_HELD_CYCLES, body) for body in ("moving", "fixed"))
    depth, pressure = 1e-3 * float((moving.depth_um + fixed.depth_um).max()), fixed.pressure_MPa
    middle, peak = float(pressure[tuple(size // 2 for size in pressure.shape)]), float(exact.pressure(0.0, modulus))
    name, most = "Partial slip, a run under a held force", 0.08
    return (
        compared(name, "worn volume of both bodies [mm³]", float(result.worn_volume_mm3[-1]), volume, most),
        compared(name, "largest depth of both bodies [mm]", depth, deep, most),
        compared(name, "pressure in the middle [MPa]", middle, peak, most),
    )


def held_force_study(share: float = _HELD_SHARE) -> Study:
    """Study of a ball on a flat under a held load and a held tangential force, the share `share` (0 to 1) of the
    largest friction force, until next to nothing wears.
    """
    return study_of(
        _FLAT,
        _BALL,
        cycles=_HELD_CYCLES,
        conditions={"normal_load_N": _HELD_N, "held_tangential_force_N": share * FRICTION * _HELD_N},
        wear=_WEAR | {"energy_wear_coefficient_mm3_per_J": 2.0e-3},
        log={"loop_cycles": [1, _HELD_CYCLES]},
    )


def held_force_shape(share: float = _HELD_SHARE) -> tuple[reference.LimitingShape, float]:
    """The shape at which wear of the run of `held_force_study` ends, and its volume in mm³ as slip is not small."""
    radius, modulus = 0.5 * _BALL_mm, hertz.CONTACT_MODULUS_MPa
    exact = reference.worn_under_load(radius, modulus, _HELD_N, share)
    slip = exact.slip_mm(FRICTION, modulus, reference.tangential_contact_modulus(hertz.STEEL, hertz.STEEL))
    return exact, exact.volume_after_slip_mm3(slip, 0.5 / radius)


def partial_slip_run_rows(level: Level) -> tuple[Row, ...]:
    """Rows on the radius of the stuck core, worn volume and largest depth of both wires at the end of a run."""
    resolution = level.partial_slip_run_resolution
    study, exact = worn_out_study(resolution), limiting_shape(resolution)
    result = simulate(study, fidelity="quick")
    fixed, moving = (result.scar(_CYCLES, wire) for wire in ("fixed", "moving"))
    volume = sum(float(result.evolution[f"worn_volume_{wire}_mm3"][-1]) for wire in ("moving", "fixed"))
    # Equal wires crossed at right angles: what is axial on one is transverse on the other.
    depth = 1e-3 * float((fixed.depth_um + moving.depth_um.T).max())
    name, size = f"Partial slip, a run, {resolution:g} elements a radius", _CONTACT_RADIUS_mm / resolution
    # Radius of the circle with the area of the nodes that carry load and do not slide in the last cycle.
    first, last = (result.scar(cycle, "fixed") for cycle in (1, _CYCLES))
    sticks = (last.pressure_MPa > 0.0) & (last.slip_distance_um < _STUCK * first.slip_distance_um.max())
    areas = np.outer(1e-3 * np.gradient(last.axial_um), 1e-3 * np.gradient(last.transverse_um))
    return (
        compared(
            name,
            "radius that sticks [mm]; error in elements",
            sqrt(float(areas[sticks].sum()) / pi),
            exact.stick_radius_mm,
            1.0,
            scale=size,
        ),
        compared(name, "worn volume of both wires [mm³]", volume, exact.volume_mm3, level.partial_slip_run_tolerance),
        compared(name, "largest depth of both wires [mm]", depth, exact.deepest_mm[0], _DEPTH_TOLERANCE),
    )


def worn_out_study(resolution: float) -> Study:
    """Study of steel wires at constant approach and half of gross slip. resolution: elements per contact radius."""
    element_um = 1e3 * _CONTACT_RADIUS_mm / resolution
    steel = {"youngs_modulus_MPa": hertz.STEEL.youngs_modulus_MPa, "poissons_ratio": hertz.STEEL.poissons_ratio}
    tables = {
        "format": 1,
        "name": "partial slip under a held approach",
        "kind": "crossed-wires",
        "wires": {"diameter_mm": _DIAMETER_mm, "crossing_angle_deg": 90.0, **steel},
        "conditions": {
            "approach_um": 1e3 * _APPROACH_mm,
            "normal_load_N": 2.0,
            "displacement_amplitude_um": 1e3 * _AMPLITUDE_mm,
            "frequency_Hz": 1.0,
            "cycles": _CYCLES,
        },
        "contact": {"friction": _FRICTION},
        "wear": {"energy_wear_coefficient_mm3_per_J": 3.0e-5, "moving_share": 0.5},
        "holder": {"tangential_stiffness_N_per_mm": "rigid"},
        "log": {"loop_cycles": [1, _CYCLES]},
        "fidelity": {
            "quick": {"contact_mesh_um": element_um, "outer_mesh_um": element_um, "increments_per_cycle": _INCREMENTS}
        },
    }
    study: Study = study_from_tables(tables, "the reference problem")
    return study


def limiting_shape(resolution: float) -> reference.LimitingShape:
    """The shape at which wear of the run of `worn_out_study` ends, with the bulk compliance of its wires."""
    body = hertz.condensed(discretise(worn_out_study(resolution), "quick").fixed)
    bulk = [hertz.crossed_bulk_compliance(body, normal=n, contact_radius_mm=_CONTACT_RADIUS_mm) for n in (True, False)]
    shear = reference.tangential_contact_modulus(hertz.STEEL, hertz.STEEL)
    radius = 0.5 * _DIAMETER_mm
    contact = reference.WearingContact(radius, hertz.CONTACT_MODULUS_MPa, shear, _FRICTION, _AMPLITUDE_mm, *bulk)
    return contact.under_approach(_APPROACH_mm)


def _barrel(diameter_along_mm: float) -> Mapping[str, object]:
    return {"shape": "barrel", "diameter_mm": 5.4, "diameter_along_mm": diameter_along_mm}


def _cylinder(angle_deg: float) -> Mapping[str, object]:
    return {"shape": "cylinder", "diameter_mm": 12.7, "axis_angle_deg": angle_deg}


#: Contacts whose longer axis is 1, 2, 5, 10 and 4 times the shorter one.
_PAIRS = (
    ("Ball on flat", _FLAT, _BALL),
    ("Barrel on flat, axes 2 : 1", _FLAT, _barrel(15.4)),
    ("Barrel on flat, axes 5 : 1", _FLAT, _barrel(64.0)),
    ("Barrel on flat, axes 10 : 1", _FLAT, _barrel(199.0)),
    ("Cylinders crossed at 38°", _cylinder(0.0), _cylinder(38.0)),
)


def study_of(
    lower: Mapping[str, object],
    upper: Mapping[str, object],
    amplitude_um: float = 30.0,
    cycles: int = 1,
    conditions: Mapping[str, float] | None = None,
    **tables: Mapping[str, object],
) -> Study:
    """Study of two steel bodies in contact at a point. lower, upper: their tables; conditions: further keys of
    [conditions], also in place of those here; tables: any further ones.
    """
    steel = {"youngs_modulus_MPa": hertz.STEEL.youngs_modulus_MPa, "poissons_ratio": hertz.STEEL.poissons_ratio}
    stated = {
        "normal_load_N": _LOAD_N,
        "displacement_amplitude_um": amplitude_um,
        "frequency_Hz": 1.0,
        "cycles": cycles,
    } | dict(conditions or {})
    study: Study = study_from_tables(
        {
            "format": 1,
            "name": "bodies of a reference problem",
            "kind": "point-contact",
            "bodies": {"lower": {**lower, **steel}, "upper": {**upper, **steel}},
            "conditions": stated,
            "contact": {"friction": FRICTION},
            **tables,
        },
        "the reference problem",
    )
    return study


def _meshed(study: Study, level: Level) -> tuple[CondensedBody, CondensedBody]:
    meshes = discretise(study, level.fidelity)
    return hertz.condensed(meshes.moving), hertz.condensed(meshes.fixed)


def block_rows(level: Level) -> tuple[Row, ...]:
    """Rows on peak pressure, approach and semi-axes of five pairs of blocks, and partial slip of a ball on a flat."""
    rows: list[Row] = []
    for name, lower, upper in _PAIRS:
        study = study_of(lower, upper)
        exact = hertz_of(_LOAD_N, *study.bodies)
        rows += hertz.pressed_rows(name, *_meshed(study, level), exact, study.crossing_angle_deg, level)
    # Half of what slides, at which runs mesh for a centre that sticks.
    study = study_of(_FLAT, _BALL, 1.5, wear=_WEAR)
    flat, ball = _meshed(study, level)
    radius_mm = hertz_of(_LOAD_N, *study.bodies).contact_radius_mm
    bulk = sum(hertz.bulk_compliance(body, 0, radius_mm) for body in (flat, ball))
    modulus = reference.tangential_contact_modulus(hertz.STEEL, hertz.STEEL)
    slip = reference.partial_slip_point(_LOAD_N, FRICTION, radius_mm, modulus)
    problem = hertz.crossed(flat, ball, Holder(_LOAD_N), friction=FRICTION, angle_deg=0.0)
    return (*rows, *sliding_rows(problem, slip, bulk, ball, level, (_SHARE,), "Ball on flat, partial slip"))
