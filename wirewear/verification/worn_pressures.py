"""Pressures of a worn line contact: their own mirror image, and the same with mesh, positions and jumps refined.

Depths and energies hide an error of the pressures, for wear evens it out.
"""

from __future__ import annotations

from typing import Any

from wirewear.planar import PlanarStudy, planar_study_from_tables, run_planar_study
from wirewear.planar.results import PlanarResult
from wirewear.simulation import last_of
from wirewear.verification.level import Level
from wirewear.verification.rows import Row, compared

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


def _worn(cycles: int, mesh: dict[str, float]) -> PlanarResult:
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
