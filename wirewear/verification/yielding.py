"""Bodies that yield, pressed as in runs, compared with results of other finite-element programs.

Rows compare a computed quantity with that of a reference, on the meshes and with the tolerance of a level. The
references are axisymmetric, for a perfectly plastic metal with von Mises' criterion and small strain, and within 1 % of
Hertz in the elastic range. Two wires crossed at right angles that both yield are taken as two such halves. A print is
the permanent depth that pressing leaves.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import cast

from wirewear.simulation import simulate
from wirewear.test import Study, study_from_tables
from wirewear.verification.rows import Level, Row, compared

_BALL = {"shape": "ball", "diameter_mm": 6.35, "youngs_modulus_MPa": 208_000.0, "poissons_ratio": 0.3}
_FLAT = _BALL | {"shape": "flat", "yield_stress_MPa": 800.0}
del _FLAT["diameter_mm"]
_ON_FLAT = {"kind": "point-contact", "bodies": {"upper": _BALL, "lower": _FLAT}}


@dataclass(frozen=True)
class Pressed:
    """Bodies under a load, and reference values of largest pressure, contact radius and print of both together."""

    name: str
    bodies: Mapping[str, object]
    load_N: float
    yield_stress_MPa: float
    pressure_MPa: float
    radius_um: float
    print_um: float


def wires(diameter_mm: float, modulus_MPa: float, poissons_ratio: float, yield_MPa: float) -> dict[str, object]:
    wire = {"diameter_mm": diameter_mm, "youngs_modulus_MPa": modulus_MPa, "poissons_ratio": poissons_ratio}
    return {"kind": "crossed-wires", "wires": wire | {"yield_stress_MPa": yield_MPa}}


CASES = (
    Pressed("Steel wires of 0.45 mm, 1 400 MPa", wires(0.45, 208_700.0, 0.3, 1400.0), 2.0, 1400.0, 2889.0, 16.2, 0.24),
    Pressed("Rope wires of 1 mm, 1 600 MPa", wires(1.0, 200_000.0, 0.3, 1600.0), 50.0, 1600.0, 3687.0, 69.3, 2.88),
    Pressed("Aluminium wires of 3.5 mm, 170 MPa", wires(3.5, 69_000.0, 0.33, 170.0), 300.0, 170.0, 501.0, 443.0, 44.0),
    Pressed("Ball of 6.35 mm on a flat, 800 MPa, 100 N", _ON_FLAT, 100.0, 800.0, 1710.0, 146.0, 1.54),
    Pressed("Ball of 6.35 mm on a flat, 800 MPa, 500 N", _ON_FLAT, 500.0, 800.0, 1981.0, 293.0, 9.56),
)


def yielding_rows(level: Level) -> tuple[Row, ...]:
    """Rows on all pressed bodies of CASES."""
    return tuple(row for case in CASES for row in rows_of(case, level))


def rows_of(case: Pressed, level: Level) -> tuple[Row, ...]:
    """Rows on largest pressure, contact radius and print of one pair of bodies."""
    run = simulate(study_of(case), fidelity=level.yielding_fidelity)
    pressure = float(run.settings["fresh_max_pressure_MPa"])
    radius = float(run.settings["fresh_contact_radius_um"])
    printed = sum(
        float(run.evolution[key][-1]) for key in run.evolution if key.startswith("print_") and key.endswith("_um")
    )
    return (
        compared(case.name, "largest pressure [MPa]", pressure, case.pressure_MPa, 0.03),
        compared(case.name, "contact radius [µm]", radius, case.radius_um, level.yielding_radius_tolerance),
        compared(case.name, "print of both bodies [µm]", printed, case.print_um, level.yielding_print_tolerance),
    )


def study_of(case: Pressed) -> Study:
    """Study of the bodies of a case, pressed, unworn and all but unmoved."""
    # A run must move; this is next to nothing.
    conditions = {"normal_load_N": case.load_N, "displacement_amplitude_um": 0.1, "frequency_Hz": 1.0, "cycles": 1}
    tables = {
        "format": 1,
        "name": case.name,
        **case.bodies,
        "conditions": conditions,
        "contact": {"friction": 0.0},
        "wear": {"energy_wear_coefficient_mm3_per_J": 0.0},
    }
    return cast(Study, study_from_tables(tables, "the reference problem"))
