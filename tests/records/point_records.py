"""Results of contacts at a point that become records."""

import dataclasses
from copy import deepcopy
from typing import Any

import numpy as np

from tests.simulation.point_contacts import STEEL
from tests.synthetic_results import AMPLITUDE_um, bowl, result
from wirewear.results import Evolution, RunResult, Scar
from wirewear.test import study_from_tables

RADIUS_mm, NOISE_um = 1.5, 0.02


#: Both wear by so much; overlapping by the sum they touch within this radius.
DEPTH_um = 2.0


SPOT_um = float(np.sqrt(2e3 * RADIUS_mm * 2.0 * DEPTH_um))


SHAPES: dict[str, dict[str, Any]] = {
    "ball-on-flat": {"ball": {"diameter_mm": 2 * RADIUS_mm, **STEEL}, "flat": {"material": "steel"}},
    "point-contact": {
        "lower": {"shape": "cylinder", "diameter_mm": 2 * RADIUS_mm, "axis_angle_deg": 0.0, **STEEL},
        "upper": {"shape": "cylinder", "diameter_mm": 2 * RADIUS_mm, "axis_angle_deg": 90.0, **STEEL},
    },
}


def scar(body: str, driven: bool, radii_mm: tuple[float, float], axis_angle_deg: float) -> Scar:
    """Worn by the other body, along the motion by the stroke longer if it is driven."""
    length, width = SPOT_um + AMPLITUDE_um * driven, SPOT_um
    sides = (width, length) if axis_angle_deg == 90.0 else (length, width)
    plain = bowl(body, DEPTH_um, *sides, axis_angle_deg=axis_angle_deg)
    return dataclasses.replace(plain, diameter_along_mm=2 * radii_mm[0], diameter_mm=2 * radii_mm[1])


def run_of(kind: str) -> RunResult:
    """A made-up run of bodies that make the same contact: a ball on a flat, or crossed cylinders of its radius."""
    plain = result("", 2000.0)
    energy = float(plain.evolution["accumulated_energy_J"][-1])
    names = {"ball-on-flat": ("flat", "ball"), "point-contact": ("lower", "upper")}[kind]
    scars = {
        "ball-on-flat": (scar("flat", True, (np.inf, np.inf), 0.0), scar("ball", False, (RADIUS_mm, RADIUS_mm), 0.0)),
        "point-contact": (scar("lower", True, (np.inf, RADIUS_mm), 0.0), scar("upper", False, (np.inf, RADIUS_mm), 90)),
    }[kind]
    worn = sum(one.volume_mm3 for one in scars)
    tables = {
        "format": 1,
        "name": "made-up bodies",
        "kind": kind,
        "bodies": deepcopy(SHAPES[kind]),
        "conditions": {
            "normal_load_N": 2.0,
            "displacement_amplitude_um": AMPLITUDE_um,
            "frequency_Hz": 3.0,
            "cycles": 100_000,
        },
        "contact": {"friction": 0.62},
        "holder": {"tangential_stiffness_N_per_mm": 2000.0},
        "wear": {"energy_wear_coefficient_mm3_per_J": worn / energy, "moving_share": scars[0].volume_mm3 / worn},
    }
    columns = {
        name.replace("moving", names[0]).replace("fixed", names[1]): column
        for name, column in plain.evolution.columns.items()
    }
    return dataclasses.replace(
        plain, study=study_from_tables(tables, "s.toml").resolved(), contact_kind=kind, bodies=names, scars=scars,
        evolution=Evolution(columns),
    )  # fmt: skip


def run_of_wires(**wires: Any) -> RunResult:
    scars = (bowl("moving", 6.0, 110.0, 60.0), bowl("fixed", 8.0, 60.0, 60.0, axis_angle_deg=90.0))
    study = STUDY_OF_WIRES | {"wires": STUDY_OF_WIRES["wires"] | wires}
    return dataclasses.replace(result("", 167.0), scars=scars, study=study)


STUDY_OF_WIRES: dict[str, Any] = {
    "wires": {"diameter_mm": 0.45, "crossing_angle_deg": 90.0, **STEEL},
    "conditions": {"normal_load_N": 2.0, "displacement_amplitude_um": 60.0, "frequency_Hz": 3.0, "cycles": 100_000},
    "contact": {"friction": 0.62},
    "wear": {"energy_wear_coefficient_mm3_per_J": 3.0e-5},
}
