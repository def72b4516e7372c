"""A whole run of wires that wear under partial slip, as `wirewear run` goes through it, against the shape at its end.

Its meshes, cycle jumps and loops are those of a run; it shares the closed form alone with `partial_slip_wear_rows`.
"""

from math import pi, sqrt

import numpy as np

from geometry.arrays import Array
from wirewear import reference
from wirewear.results import RunResult
from wirewear.simulation import discretise, simulate
from wirewear.study import Study, study_from_tables
from wirewear.verification.hertz import STEEL, CONTACT_MODULUS_MPa, condensed, crossed_bulk_compliance
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


def partial_slip_run_rows(level: Level) -> tuple[Row, ...]:
    """Radius of the stuck core, worn volume and largest depth of both wires at a run's end."""
    resolution = level.partial_slip_run_resolution
    study, exact = _study(resolution), _exact(resolution)
    result = simulate(study, fidelity="quick")
    fixed, moving = (result.scar(_CYCLES, wire) for wire in ("fixed", "moving"))
    volume = sum(float(result.evolution[f"worn_volume_{wire}_mm3"][-1]) for wire in ("moving", "fixed"))
    # Equal wires crossed at right angles: what is axial on one is transverse on the other.
    depth = 1e-3 * float((fixed.depth_um + moving.depth_um.T).max())
    name, size = f"Partial slip, a run, {resolution:g} elements a radius", _CONTACT_RADIUS_mm / resolution
    return (
        compared(
            name,
            "radius that sticks [mm]; error in elements",
            _stick_radius_mm(result),
            exact.stick_radius_mm,
            1.0,
            scale=size,
        ),
        compared(name, "worn volume of both wires [mm³]", volume, exact.volume_mm3, level.partial_slip_run_tolerance),
        compared(name, "largest depth of both wires [mm]", depth, exact.deepest_mm[0], _DEPTH_TOLERANCE),
    )


def _study(resolution: float) -> Study:
    """Steel wires held at an approach that move by half of what they need to slide."""
    element_um = 1e3 * _CONTACT_RADIUS_mm / resolution
    steel = {"youngs_modulus_MPa": STEEL.youngs_modulus_MPa, "poissons_ratio": STEEL.poissons_ratio}
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
    return study_from_tables(tables, "the reference problem")


def _exact(resolution: float) -> reference.LimitingShape:
    """The shape at which the wear of such a run ends, the bulk of its wires counted."""
    body = condensed(discretise(_study(resolution), "quick").fixed)
    bulk = [crossed_bulk_compliance(body, normal=n, contact_radius_mm=_CONTACT_RADIUS_mm) for n in (True, False)]
    shear = reference.tangential_contact_modulus(STEEL, STEEL)
    radius = 0.5 * _DIAMETER_mm
    contact = reference.WearingContact(radius, CONTACT_MODULUS_MPa, shear, _FRICTION, _AMPLITUDE_mm, *bulk)
    return contact.under_approach(_APPROACH_mm)


def _stick_radius_mm(result: RunResult) -> float:
    """Radius of the circle with the area of the nodes that carry load and do not slide in the last cycle."""
    first, last = (result.scar(cycle, "fixed") for cycle in (1, _CYCLES))
    sticks = (last.pressure_MPa > 0.0) & (last.slip_distance_um < _STUCK * first.slip_distance_um.max())
    areas = np.outer(_widths_mm(last.axial_um), _widths_mm(last.transverse_um))
    return sqrt(float(areas[sticks].sum()) / pi)


def _widths_mm(lines_um: Array) -> Array:
    """What belongs to each of some mesh lines (n,)."""
    return 1e-3 * np.gradient(lines_um)
