"""What the head of a line contact's blind record says: all from the nominal test and the nuisances."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, cast

from studies.blind.generators.cases import Case
from studies.blind.generators.line_nominal import LineNominal
from wirewear.records.line_tables import LineRecordTables


def nominal_of(case: Case) -> LineNominal:
    """The nominal test of a case of line contacts."""
    return cast("LineNominal", case.nominal)


def record_tables(case: Case) -> LineRecordTables:
    """The tables of experiment.toml: all from the nominal test and the nuisances."""
    return tables_of(nominal_of(case), case.name, case.nuisances.stated_noise)


def tables_of(nominal: LineNominal, name: str, noise: Mapping[str, float]) -> LineRecordTables:
    """The tables of a nominal test's record with this name and noise."""
    stated: dict[str, Any] = {
        "friction": nominal.friction,
        "pad_energy_wear_coefficient_mm3_per_J": nominal.pad_wear_mm3_per_J,
        "specimen_energy_wear_coefficient_mm3_per_J": nominal.specimen_wear_mm3_per_J,
    }
    if nominal.stiffness_N_per_mm is not None:
        stated["tangential_stiffness_N_per_mm"] = nominal.stiffness_N_per_mm
    return LineRecordTables.model_validate(
        {
            "format": 1,
            "name": name,
            "contact": {"kind": "cylinder-on-flat", "length_mm": nominal.length_mm},
            "pad": {"radius_mm": nominal.radius_mm, **_elastic(nominal.pad_MPa)},
            "specimen": _elastic(nominal.specimen_MPa),
            "conditions": {
                "normal_load_N": nominal.load_N,
                "displacement_amplitude_um": nominal.amplitude_um,
                "frequency_Hz": nominal.frequency_Hz,
                "cycles": nominal.cycles,
                "drive": "stroke",
            },
            "stated": stated,
            "noise": dict(noise),
            "files": {},
        }
    )


def _elastic(constants: tuple[float, float]) -> dict[str, float]:
    return {"youngs_modulus_MPa": constants[0], "poissons_ratio": constants[1]}
