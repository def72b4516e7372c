"""What is odd about a rig changes its readings, but neither its friction energy nor what its loops enclose."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from studies.diagnosis.oddities import ODDITIES, SCATTERED
from wirewear import ExperimentRecord, read_record

EXAMPLE = Path(__file__).parents[1] / "studies/steel_wires/example_records/no_gap"


@pytest.fixture(scope="module")
def record() -> ExperimentRecord:
    return read_record(EXAMPLE)


def areas_mJ(record: ExperimentRecord) -> np.ndarray:
    return np.array([loop.figures(2.0).dissipated_energy_mJ.value for loop in record.loops])


@pytest.mark.parametrize("name", sorted(set(ODDITIES) - {SCATTERED}))
def test_an_odd_rig_reads_the_same_friction_energy_otherwise(record: ExperimentRecord, name: str) -> None:
    odd = ODDITIES[name](record, np.random.default_rng(1))
    np.testing.assert_allclose(areas_mJ(odd), areas_mJ(record), rtol=0.02)
    unlike = [
        before.tangential_force_N.shape != after.tangential_force_N.shape
        or not np.array_equal(before.tangential_force_N, after.tangential_force_N, equal_nan=True)
        for before, after in zip(record.loops, odd.loops, strict=True)
    ]
    assert (
        all(unlike)
        or odd.evolution[0].columns["slip_amplitude_um"][0] != (record.evolution[0].columns["slip_amplitude_um"][0])
    )


def test_a_triangular_drive_passes_the_stroke_evenly(record: ExperimentRecord) -> None:
    odd = ODDITIES["triangular drive"](record, np.random.default_rng(1)).loops[0]
    steps = np.abs(np.diff(odd.displacement_um))
    away_from_reversals = steps > 0.5 * np.median(steps)
    assert np.std(steps[away_from_reversals]) < 0.25 * np.mean(steps)
    sine = np.abs(np.diff(record.loops[0].displacement_um))
    assert np.std(sine) > 0.4 * np.mean(sine)
