"""What is odd about a rig changes its readings, but neither its friction energy nor what its loops enclose."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from studies.diagnosis.odd_rigs import planned
from studies.diagnosis.oddities import DWELL, FURTHER, ODDITIES, RIGS, Ramps
from wirewear import ExperimentRecord, read_record

EXAMPLE = Path(__file__).parents[1] / "studies/steel_wires/example_records/no_gap"


@pytest.fixture(scope="module")
def record() -> ExperimentRecord:
    return read_record(EXAMPLE)


def areas_mJ(record: ExperimentRecord) -> np.ndarray:
    return np.array([loop.figures(2.0).dissipated_energy_mJ.value for loop in record.loops])


@pytest.mark.parametrize("name", sorted({*ODDITIES, *FURTHER} - {*RIGS}))
def test_an_odd_rig_reads_the_same_friction_energy_otherwise(record: ExperimentRecord, name: str) -> None:
    odd = {**ODDITIES, **FURTHER}[name](record, np.random.default_rng(1))
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


def test_a_triangular_drive_passes_the_stroke_evenly_and_turns_at_once() -> None:
    steps = np.abs(np.diff(Ramps().shape()))
    assert np.ptp(steps) < 1e-12


def test_a_trapezoidal_drive_stays_at_each_end() -> None:
    shape = Ramps(dwell=DWELL).shape()
    for end in (-1.0, 1.0):
        assert np.mean(shape == end) == pytest.approx(DWELL, abs=0.003)


@pytest.mark.parametrize("seed", [9, 31])
def test_every_rig_has_loops_of_all_its_specimens(seed: int) -> None:
    cases = [case for _, case in planned(1, seed)]
    assert len(cases) == 2 * len({**ODDITIES, **FURTHER})
    assert all(len(case.nuisances.loop_cycles) == case.nuisances.repeats for case in cases)
