"""What a record states: all from the nominal test and the nuisances, nothing from the truth."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from studies.blind.generators.cases import Case
from studies.blind.generators.nominal import Nominal
from wirewear.records import RecordTables

Array = NDArray[np.float64]

#: Scar maps reach beyond the scar that the statements lead one to expect, in steps of so many points a half-width.
MAP_MARGIN, MAP_POINTS = 1.25, 26


def wire_table(nominal: Nominal) -> dict[str, Any]:
    """Both wires, in the words of records and studies alike."""
    return {
        "diameter_mm": nominal.diameter_mm,
        "youngs_modulus_MPa": nominal.youngs_modulus_MPa,
        "poissons_ratio": nominal.poissons_ratio,
    }


def conditions_table(nominal: Nominal) -> dict[str, Any]:
    """Load, stroke and cycles, in the words of records and studies alike."""
    return {
        "normal_load_N": nominal.load_N,
        "displacement_amplitude_um": nominal.amplitude_um,
        "frequency_Hz": nominal.frequency_Hz,
        "cycles": nominal.cycles,
    }


def record_tables(case: Case) -> RecordTables:
    """The tables of experiment.toml."""
    nominal, nuisances = case.nominal, case.nuisances
    stated: dict[str, Any] = {
        "friction": nominal.friction,
        "energy_wear_coefficient_mm3_per_J": nominal.wear_mm3_per_J,
        "normal_spring_stiffness_N_per_mm": nominal.spring_N_per_mm,
    }
    if nominal.stiffness_N_per_mm is not None:
        stated["tangential_stiffness_N_per_mm"] = nominal.stiffness_N_per_mm
    return RecordTables.model_validate(
        {
            "format": 1,
            "name": case.name,
            "wires": {**wire_table(nominal), "crossing_angle_deg": 90.0},
            "conditions": {**conditions_table(nominal), "drive": nuisances.drive},
            "stated": stated,
            "noise": nuisances.stated_noise,
            "files": {"loops": "loops.csv"},
        }
    )


def scar_lines_um(nominal: Nominal, wire: str) -> tuple[Array, Array]:
    """Lines of a scar map along and across the motion: of a size that follows from the statements alone."""
    half = 1e3 * MAP_MARGIN * nominal.expected_scar_mm
    step = float(np.ceil(half / MAP_POINTS))
    along = half + (nominal.amplitude_um if wire == "moving" else 0.0)
    return _lines(along, step), _lines(half, step)


def _lines(half: float, step: float) -> Array:
    count = int(np.ceil(half / step))
    return step * np.arange(-count, count + 1.0)
