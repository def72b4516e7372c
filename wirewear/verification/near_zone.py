"""Metal that flows beneath pressed spheres and rolling lines, by plasticity in a half-space, beside other results.

Rows compare a computed quantity with that of a reference, on the meshes and with the tolerance of a level. The pairs of
bodies of `wirewear.verification.yielding` are taken as a body that yields under a rigid one: its E/(1 - nu²) is that of
the pair, and its print (permanent depth) that of both. Three of them harden: tamaas 2.9 (volume integrals) has their
largest pressures. A rolling line shakes down or flows on (Melan's limits), and leaves the residual
stress of finite elements, which is Merwin & Johnson's (Proc. Inst. Mech. Eng. 177 (1963) 676) where it shakes down.
"""

from collections.abc import Iterator
from dataclasses import replace
from math import exp, pi, sqrt

import numpy as np

from geometry import Elastic
from geometry.arrays import Array
from solvers.laws.plasticity import Metal
from solvers.stress.half_space import HalfSpace
from solvers.stress.plastic_zone import PlasticZone
from solvers.stress.pressing import Indentation, indented
from wirewear.test.gaps import hertz_of
from wirewear.verification.rows import Level, Row, compared
from wirewear.verification.yielding import CASES, Pressed, study_of, wires

#: Width of the grid and thickness of its layers over the contact's radius.
_WIDE, _LAYERS = 8.0, np.asarray(0.1 * 1.1 ** np.arange(15), dtype=np.float64)
_ROLLED = np.asarray(0.08 * 1.1 ** np.arange(17), dtype=np.float64)  #: Layers in mm beneath a line.
_STEPS = 16  #: Of the load, which goes with their square.
#: Largest pressure of finer finite elements, off the axis by 0.3 radii; on it they have 2 894 MPa.
_SOFT = replace(CASES[0], pressure_MPa=2952.0)
_HARDER = tuple(
    replace(CASES[0], bodies=wires(0.45, 208_700.0, 0.3, stress), name=f"Steel wires of 0.45 mm, {stress:g} MPa",
            yield_stress_MPa=stress, pressure_MPa=pressure, radius_um=radius, print_um=print_um)
    for stress, pressure, radius, print_um in ((1800.0, 3556.0, 15.1, 0.126), (2400.0, 4273.0, 14.6, 0.028))
)  # fmt: skip
#: Yield stress of wires that harden by a fiftieth of their modulus, and their largest pressure by tamaas on six cells
#: to a radius, MPa; of load in one step, by which it is up to 6 % larger than by many.
_BY_TAMAAS = ((1400.0, 3181.0), (1800.0, 3623.0), (2400.0, 4241.0))
#: Friction of a rolling line, and the largest pressure over the yield stress in shear at which it still shakes down.
SHAKEDOWN = ((0.0, 4.0), (0.3, 2.886))
#: Largest pressure of a rolling line without friction, and residual stress after its first pass of 8 half-widths, over
#: the yield stress in shear: by plane finite elements (quadrilaterals of a tenth of the half-width, period 16).
RESIDUAL = ((3.9, -0.492), (4.2, -0.767))
#: Loads over that of first yield of a sphere for which published curves are compared, and largest pressure over yield
#: stress at first yield, for a Poisson's ratio of 0.3.
_BEYOND, RATIO = (1.05, 4.1, 27.0, 110.0, 458.0), 1.613
_SHEAR_MPa, _MODULUS_MPa, _PASSES = 100.0, 200_000.0, 8


def under_sphere(
    radius_mm: float, material: Elastic, metal: Metal, contact_mm: float, resolution: int
) -> tuple[PlasticZone, Array]:
    """(half-space that yields, gap (n, n) in mm to an unloaded sphere of radius_mm), on a grid of `resolution` points
    per contact radius `contact_mm`.
    """
    step, count = contact_mm / resolution, int(_WIDE * resolution) // 2 * 2 + 1
    space = HalfSpace(material, (count, count), (step, step), contact_mm * _LAYERS)
    along, across = space.axes_mm()
    return PlasticZone(space, metal), (along[:, None] ** 2 + across**2) / (2.0 * radius_mm)


def near_zone_rows(level: Level) -> tuple[Row, ...]:
    """Rows on all pressed bodies and rolling lines."""
    fine, tolerance = level.near_zone_resolution, level.near_zone_tolerance
    pressed = tuple(row for case in (_SOFT, *CASES[1:], *_HARDER) for row in rows_of(case, fine, tolerance))
    hardened = tuple(
        compared(
            f"Steel wires that harden, {stress:g} MPa, beside tamaas",
            "largest pressure [MPa]",
            pressed_by(replace(CASES[0], yield_stress_MPa=stress), fine, 0.02, steps=1).largest_MPa,
            pressure,
            tolerance,
        )
        for stress, pressure in _BY_TAMAAS
    )
    return pressed + hardened + curve_rows(fine) + rolling_rows()


def rows_of(case: Pressed, resolution: int, tolerance: float) -> tuple[Row, ...]:
    """Rows on largest pressure, contact radius (both to a relative tolerance) and print of one pair of bodies."""
    last, name = pressed_by(case, resolution), f"{case.name}, metal that flows"
    return (
        compared(name, "largest pressure [MPa]", last.largest_MPa, case.pressure_MPa, tolerance),
        # Areas come in steps of eight cells.
        compared(name, "contact radius [µm]", 1e3 * sqrt(last.area_mm2 / pi), case.radius_um, tolerance),
        compared(name, "print of both bodies [µm]", 1e3 * last.print_mm, case.print_um, 0.1),
    )


def pressed_by(case: Pressed, resolution: int, hardening: float = 0.0, steps: int = _STEPS) -> Indentation:
    """The indentation of a case's bodies under their load, in so many steps, on a grid of `resolution` points per
    contact radius; the yield stress rises by `hardening` × modulus per plastic strain.
    """
    bodies = study_of(case).bodies
    contact, nu = hertz_of(case.load_N, *bodies), bodies[1].material.poissons_ratio
    size, radius = contact.contact_radius_mm, contact.contact_radius_mm**2 / contact.approach_mm
    modulus = 0.75 * case.load_N * radius / size**3 * (1.0 - nu**2)
    metal = Metal(case.yield_stress_MPa, hardening * modulus)
    width = max(1e-3 * case.radius_um, size)
    zone, gap = under_sphere(radius, Elastic(modulus, nu), metal, width, resolution)
    *_, last = indented(zone, gap, case.load_N * (np.arange(1, steps + 1) / steps) ** 2)
    return last


def curve_rows(resolution: int) -> tuple[Row, ...]:
    """Rows on the load of a sphere of 1 mm at its penetration, on a grid of `resolution` points per contact radius."""
    rows = []
    for beyond in _BEYOND:
        load, last = pressed_beyond(beyond, 1.0, 200_000.0, 1000.0, resolution)
        at, name = (last.approach_mm, 1.0, 200_000.0, 1000.0), f"Sphere under {beyond:g} times first yield's load"
        rows += [
            compared(name, "load by Jackson and Green [N]", load, jackson_green(*at), 0.05),
            compared(name, "load by Kogut and Etsion [N]", load, kogut_etsion(*at), 0.05),
        ]
    return tuple(rows)


def pressed_beyond(
    beyond: float, radius_mm: float, modulus_MPa: float, stress_MPa: float, resolution: int
) -> tuple[float, Indentation]:
    """(load in N, `beyond` times that of first yield; indentation) of a perfectly plastic body under a hard sphere, by
    the half-space solver.

    modulus_MPa: contact modulus E*. stress_MPa: yield stress. resolution: points per contact radius.
    """
    load = beyond * pi**3 * radius_mm**2 * (RATIO * stress_MPa) ** 3 / (6.0 * modulus_MPa**2)
    contact = (0.75 * load * radius_mm / modulus_MPa) ** (1.0 / 3.0) * beyond**0.08
    material = Elastic(modulus_MPa * (1.0 - 0.3**2), 0.3)
    zone, gap = under_sphere(radius_mm, material, Metal(stress_MPa), contact, resolution)
    *_, last = indented(zone, gap, load * np.linspace(0.1, 1.0, 10) ** 2)
    return load, last


def jackson_green(approach_mm: float, radius_mm: float, modulus_MPa: float, stress_MPa: float) -> float:
    """Load in N of a sphere on a flat of contact modulus E* and yield stress in MPa at an approach."""
    slope = pi * RATIO * stress_MPa / (2.0 * modulus_MPa)
    load, s = 4.0 / 3.0 * radius_mm**2 * modulus_MPa * slope**3, approach_mm / (slope**2 * radius_mm)
    contact = slope * sqrt(s * (s / 1.9) ** (0.14 * exp(23.0 * stress_MPa / modulus_MPa)))
    hardness = 2.84 * (1.0 - exp(-0.82 * contact**-0.7)) / RATIO
    plastic = 4.0 * hardness * (1.0 - exp(-(s ** (5 / 9)) / 25.0)) * s
    return float(load * (s**1.5 if s < 1.9 else exp(-(s ** (5 / 12)) / 4.0) * s**1.5 + plastic))


def kogut_etsion(approach_mm: float, radius_mm: float, modulus_MPa: float, stress_MPa: float) -> float:
    """Load in N that presses a sphere in by `approach_mm`, from first yield to 110 times its approach (Kogut & Etsion,
    J. Appl. Mech. 69 (2002) 657).
    """
    slope = pi * RATIO * stress_MPa / (2.0 * modulus_MPa)
    load, s = 4.0 / 3.0 * radius_mm**2 * modulus_MPa * slope**3, approach_mm / (slope**2 * radius_mm)
    return float(load * (1.03 * s**1.425 if s < 6.0 else 1.40 * s**1.263))


def rolling_rows() -> tuple[Row, ...]:
    """Rows on residual stress after a line's first pass, and on whether metal flows on 5 % below and above
    shakedown.
    """
    rows = [
        compared(f"Line rolling at {pressure:g} k", "residual stress [k]", next(rolled(pressure, 0.0))[0], stress, 0.05)
        for pressure, stress in RESIDUAL
    ]
    for friction, limit in SHAKEDOWN:
        for share, flows in ((0.95, 0.0), (1.05, 1.0)):
            passes = [flow for _, flow in rolled(share * limit, friction)]
            name = f"Line rolling at {share:g} of shakedown, friction {friction:g}"
            # Strain that dies away is no flow.
            # Part of the first pass's strain above which metal flows on.
            rows.append(compared(name, "flows on", float(passes[-1] > 0.2 * passes[0]), flows, 0.5, scale=1.0))
    return tuple(rows)


def rolled(
    pressure: float, friction: float, passes: int = _PASSES, resolution: int = 5
) -> Iterator[tuple[float, float]]:
    """Yields after each of `passes` passes of a Hertz line of half-width 1 mm over perfectly plastic metal: (lowest
    residual stress along the path over k, the yield stress in shear; largest plastic strain that the pass has gone
    through).

    pressure: the largest one, over k. friction: traction along the motion over pressure. resolution: points per mm.
    """
    material, count = Elastic(_MODULUS_MPa, 0.3), 16 * resolution + 1
    space = HalfSpace(material, (count, 1), (1.0 / resolution, 1.0), _ROLLED)
    zone, middle = PlasticZone(space, Metal(sqrt(3.0) * _SHEAR_MPa)), count // 2
    x, state = space.axes_mm()[0][:, None], zone.fresh
    for _ in range(passes):
        before = state.flow.accumulated
        for place in np.arange(-4.0, 4.0, 1.0 / resolution):
            borne = pressure * _SHEAR_MPa * np.sqrt(np.maximum(1.0 - (x - place) ** 2, 0.0))
            state = zone.under(np.stack([friction * borne, 0.0 * borne, -borne], axis=-1), state)
        state = zone.under(np.zeros((count, 1, 3)), state)
        flow = (state.flow.accumulated - before).reshape(state.stress.shape[:-1])
        yield float(state.stress[:, middle, 0, 0].min()) / _SHEAR_MPa, float(flow[:, middle].max())
