"""Metal that flows beneath a pressed sphere, by plasticity in a half-space, compared with finite elements.

The pairs of `wirewear.verification.yielding` as a body that yields under a rigid one: its E/(1 - nu²) is that of the
pair, and its print that of both.
"""

from math import pi, sqrt

import numpy as np

from geometry import Elastic
from geometry.arrays import Array
from solvers.laws.plasticity import Metal
from solvers.stress.half_space import HalfSpace
from solvers.stress.plastic_zone import PlasticZone
from solvers.stress.pressing import indented
from wirewear.test.bodies import hertz_of
from wirewear.verification.rows import Level, Row, compared
from wirewear.verification.yielding import CASES, Pressed, study_of

#: Width of the grid and thickness of its layers over the contact's radius.
_WIDE, _LAYERS = 8.0, np.asarray(0.1 * 1.1 ** np.arange(15), dtype=np.float64)
_STEPS = 16  #: Of the load, which goes with their square.


def under_sphere(
    radius_mm: float, material: Elastic, metal: Metal, contact_mm: float, resolution: int
) -> tuple[PlasticZone, Array]:
    """A half-space and its gap in mm to a sphere, on a grid with so many points to a contact radius in mm."""
    step, count = contact_mm / resolution, int(_WIDE * resolution) // 2 * 2 + 1
    space = HalfSpace(material, (count, count), (step, step), contact_mm * _LAYERS)
    along, across = space.axes_mm()
    return PlasticZone(space, metal), (along[:, None] ** 2 + across**2) / (2.0 * radius_mm)


def near_zone_rows(level: Level) -> tuple[Row, ...]:
    """Rows of all pressed bodies."""
    return tuple(row for case in CASES for row in rows_of(case, level.near_zone_resolution, level.near_zone_tolerance))


def rows_of(case: Pressed, resolution: int, tolerance: float) -> tuple[Row, ...]:
    """Largest pressure, contact radius and print of one pair of bodies."""
    study = study_of(case)
    contact, (held, _) = hertz_of(case.load_N, *study.bodies), study.bodies[::-1]
    size, radius = contact.contact_radius_mm, contact.contact_radius_mm**2 / contact.approach_mm
    nu = held.material.poissons_ratio
    material = Elastic(0.75 * case.load_N * radius / size**3 * (1.0 - nu**2), nu)
    zone, gap = under_sphere(
        radius, material, Metal(case.yield_stress_MPa), max(1e-3 * case.radius_um, size), resolution
    )
    *_, last = indented(zone, gap, case.load_N * (np.arange(1, _STEPS + 1) / _STEPS) ** 2)
    found = sqrt((last.pressure_MPa > 0.0).sum() * np.prod(zone.space.step_mm) / pi)
    name = f"{case.name}, metal that flows"
    return (
        compared(name, "largest pressure [MPa]", last.largest_MPa, case.pressure_MPa, tolerance),
        # Areas come in steps of eight cells.
        compared(name, "contact radius [µm]", 1e3 * found, case.radius_um, tolerance),
        compared(name, "print of both bodies [µm]", 1e3 * last.print_mm, case.print_um, 0.1),
    )
