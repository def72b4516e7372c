"""An evolution of other definitions is found out by the record's own loops, and left out of a diagnosis."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from wirewear import ExperimentRecord, read_record
from wirewear.diagnosis.observe.definitions import of_own_definitions
from wirewear.records import check_record

Array = NDArray[np.float64]
EXAMPLE = Path(__file__).parents[1] / "studies/steel_wires/example_records/no_gap"


@pytest.fixture(scope="module")
def record() -> ExperimentRecord:
    return read_record(EXAMPLE)


def with_column(record: ExperimentRecord, name: str, change: Callable[[dict[str, Array]], Array]) -> ExperimentRecord:
    evolution = tuple(
        replace(part, columns={**part.columns, name: change(dict(part.columns))}) for part in record.evolution
    )
    return replace(record, evolution=evolution)


def test_figures_of_the_loops_own_definition_stay(record: ExperimentRecord) -> None:
    assert of_own_definitions(record) == (record, ())


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("slip_amplitude_um", lambda c: c["dissipated_energy_mJ"] / (4e-3 * c["max_tangential_force_N"])),
        ("slip_amplitude_um", lambda c: 2.0 * c["slip_amplitude_um"]),
        ("max_tangential_force_N", lambda c: c["dissipated_energy_mJ"] / (4e-3 * c["slip_amplitude_um"])),
        ("dissipated_energy_mJ", lambda c: 4e-3 * c["slip_amplitude_um"] * c["max_tangential_force_N"]),
    ],
)
def test_a_column_of_another_definition_is_left_out_alone_with_a_note(
    record: ExperimentRecord, name: str, change: Callable[[dict[str, Array]], Array]
) -> None:
    odd = with_column(record, name, change)
    read, notes = of_own_definitions(odd)
    assert [note.split()[2] for note in notes] == [name]
    for part, before in zip(read.evolution, odd.evolution, strict=True):
        assert np.isnan(part.columns[name]).all()
        for other in set(part.columns) - {name}:
            np.testing.assert_array_equal(part.columns[other], before.columns[other])
    assert any(name in remark.text and "defined otherwise" in remark.text for remark in check_record(odd).remarks)


@pytest.mark.parametrize("is_half_range", [True, False])
def test_the_largest_force_may_be_either_of_two_under_an_offset(record: ExperimentRecord, is_half_range: bool) -> None:
    offset = 0.1
    loops = tuple(replace(one, tangential_force_N=one.tangential_force_N + offset) for one in record.loops)
    shifted = replace(record, loops=loops)
    if not is_half_range:
        shifted = with_column(shifted, "max_tangential_force_N", lambda c: c["max_tangential_force_N"] + offset)
    assert of_own_definitions(shifted)[1] == ()


def test_one_misread_figure_condemns_no_column(record: ExperimentRecord) -> None:
    def misread(columns: dict[str, Array]) -> Array:
        force = columns["max_tangential_force_N"].copy()
        force[0] *= 3.0
        return force

    assert of_own_definitions(with_column(record, "max_tangential_force_N", misread))[1] == ()
