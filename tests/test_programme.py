"""A test by blocks of cycles: what a study states of them, and what a run makes of it."""

import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.studies import COARSE, WEARING, coarse, line_study
from wirewear import StudyError
from wirewear.base.errors import RecordError
from wirewear.diagnosis.model.nominal import require_foreseen
from wirewear.fitting.fit import fit_record
from wirewear.records import ExperimentRecord, read_record, record_of_result, write_record
from wirewear.records.course_checks import accumulated_energy_J
from wirewear.records.values import believed_study
from wirewear.simulation import simulate

LONG = COARSE.replace("cycles = 1\n", "cycles = 400\n") + WEARING


def block(cycles: int, *values: str) -> str:
    return "\n".join(("[[programme]]", f"cycles = {cycles}", *values, ""))


SHORTER = block(100) + block(50, "conditions.displacement_amplitude_um = 12", "conditions.normal_load_N = 1.5")


def test_blocks_come_in_turn_up_to_the_tests_end_and_equal_neighbours_are_one() -> None:
    of_three = coarse(LONG + SHORTER + block(30))
    stretches = of_three.schedule.stretches
    assert [(own.start, own.end, own.block) for own in stretches] == [
        (0, 100, 1),
        (100, 150, 2),
        (150, 280, 3),  # the third block is as the first, which follows it
        (280, 330, 2),
        (330, 400, 3),
    ]
    amplitudes = [own.study.conditions.displacement_amplitude_um for own in stretches]
    assert amplitudes == [20.0, 12.0, 20.0, 12.0, 20.0]
    assert {100, 150, 180, 330, 360, 400} <= set(of_three.log.loop_cycles)


def test_meshes_are_for_the_largest_load_and_stroke_and_the_wear_of_all_blocks_in_any_process() -> None:
    largest = coarse(LONG + SHORTER).envelope
    assert largest.conditions.displacement_amplitude_um == 20.0
    assert largest.conditions.normal_load_N == 2.0
    assert largest.conditions.cycles == 250 + 50 + int(np.ceil(100 * 12.0 * 1.5 / (20.0 * 2.0)))
    study = coarse(LONG + SHORTER)
    assert len(study.schedule.stretches) == 5
    assert len(pickle.loads(pickle.dumps(study)).schedule.stretches) == 5


def test_two_blocks_of_one_amplitude_are_one_of_both_bit_by_bit() -> None:
    alone, blocks = (simulate(coarse(text), fidelity="quick") for text in (LONG, LONG + block(150) + block(250)))
    of_series = {cycle: index for index, cycle in enumerate(blocks.evolution["cycle"])}
    assert "block" not in blocks.evolution
    for cycle in (1.0, 10.0, 100.0):
        index = of_series[cycle]
        for name, column in alone.evolution.items():
            assert column[list(alone.evolution["cycle"]).index(cycle)] == blocks.evolution[name][index], name


def test_each_block_has_its_own_stroke_and_load_and_all_energy_is_that_of_their_loops() -> None:
    result = simulate(coarse(LONG + SHORTER), fidelity="quick")
    found = {int(cycle): index for index, cycle in enumerate(result.evolution["cycle"])}
    at = {cycle: {name: float(column[i]) for name, column in result.evolution.items()} for cycle, i in found.items()}
    assert [at[cycle]["block"] for cycle in (100, 150, 400)] == [1.0, 2.0, 1.0]
    assert at[150]["displacement_amplitude_um"] == pytest.approx(12.0)
    assert at[150]["normal_force_N"] == pytest.approx(1.5)
    assert result.loop(150).normal_force_N.mean() == pytest.approx(1.5)
    assert at[400]["displacement_amplitude_um"] == pytest.approx(20.0)
    # The energy per cycle of a worn contact hardly changes within a block.
    long_mJ, short_mJ = at[100]["dissipated_energy_mJ"], at[150]["dissipated_energy_mJ"]
    assert at[400]["accumulated_energy_J"] == pytest.approx(1e-3 * (300 * long_mJ + 100 * short_mJ), rel=0.02)
    worn = sum(at[400][f"worn_volume_{body}_mm3"] for body in ("moving", "fixed"))
    assert worn == pytest.approx(3e-5 * at[400]["accumulated_energy_J"], rel=1e-9)


def test_line_contacts_go_through_blocks_too() -> None:
    second = {"cycles": 300, "conditions": {"displacement_amplitude_um": 8.0}, "contact": {"friction": 0.3}}
    blocks = [{"cycles": 300}, second]
    study = line_study(conditions={"cycles": 600}, log={"loop_cycles": [1, 300, 600]}, programme=blocks)
    result = simulate(study, fidelity="quick")
    assert result.evolution["displacement_amplitude_um"] == pytest.approx([12.0, 12.0, 8.0])
    assert result.evolution["max_tangential_force_N"][-1] < 0.55 * result.evolution["max_tangential_force_N"][0]


@pytest.mark.parametrize(
    ("programme", "told"),
    [
        (block(100, "conditions.cycles = 3"), r"conditions in \[\[programme\]\] number 1 .*same for the whole test"),
        (block(100, "contact = 3"), r"contact in \[\[programme\]\] number 1 .*must be a table"),
        (block(100, "conditions.normal_load_N = -1"), r"normal_load_N in \[conditions\] of block 1 of the programme"),
        (block(1).replace("cycles", "cycle"), "did you mean 'cycles'"),
        ("[programme]\ncycles = 3\n", "programme .*must be a list of tables"),
    ],
)
def test_a_programme_that_cannot_be_is_told_with_its_block(programme: str, told: str) -> None:
    with pytest.raises(StudyError, match=told):
        coarse(LONG + programme)


def test_a_programme_of_more_blocks_than_a_run_goes_through_is_refused() -> None:
    with pytest.raises(StudyError, match=r"programme .*comes to 100.000 blocks"):
        coarse(LONG.replace("cycles = 400", "cycles = 100000") + block(1) + block(1, "contact.friction = 0.3"))


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> ExperimentRecord:
    """A test by blocks as its logger leaves it, read back from its files."""
    result = simulate(coarse(LONG + SHORTER + block(60, "contact.friction = 0.5")), fidelity="quick")
    folder = tmp_path_factory.mktemp("record")
    write_record(folder, record_of_result(result, repeats=2))
    return read_record(folder)


def test_a_record_states_the_programme_that_its_simulation_had(measured: ExperimentRecord) -> None:
    believed = believed_study(measured.tables)
    assert [(own.end, own.block) for own in believed.schedule.stretches] == [
        (100, 1), (150, 2), (210, 3), (310, 1), (360, 2), (400, 3),
    ]  # fmt: skip
    assert [own.study.contact.friction for own in believed.schedule.stretches[:3]] == [0.62, 0.62, 0.5]
    assert [own.study.conditions.normal_load_N for own in believed.schedule.stretches[:3]] == [2.0, 1.5, 2.0]


def test_a_block_of_a_record_is_a_test_of_its_conditions_in_which_all_wear(measured: ExperimentRecord) -> None:
    third = measured.of_block(3)
    assert third.tables.stated.friction == 0.5
    assert {loop.cycle for loop in third.loops} <= set(range(151, 211)) | set(range(361, 401))
    assert {tuple(part.columns["block"]) for part in third.evolution if "block" in part.columns} <= {(3.0,)}
    # All energy of the test, from the loops of one block: that of the run.
    whole = accumulated_energy_J(measured.of_block(1), 1)
    assert whole == pytest.approx(accumulated_energy_J(third, 1), rel=0.02)
    assert third.of_block() is third
    believed = believed_study(third.tables)
    assert [own.study.contact.friction for own in believed.schedule.stretches[:3]] == [0.62, 0.62, 0.5]


def test_by_default_the_block_with_the_longest_stroke_and_most_loops_is_looked_at(measured: ExperimentRecord) -> None:
    assert measured.of_block().block == 1
    assert measured.of_block(2).scars == ()
    with pytest.raises(RecordError, match=r"block 2 .* slides in scars of longer strokes"):
        require_foreseen(measured.of_block(2))
    with pytest.raises(RecordError, match=r"has no loop of block 7 .*: it has loops of 1, 2, 3"):
        measured.of_block(7)


def test_a_record_states_a_load_that_varies_and_what_the_drive_holds_which_is_not_fitted(tmp_path: Path) -> None:
    held = LONG.replace("cycles = 400", "cycles = 3\nheld_energy_mJ = 0.05\nload_cycle = { amplitude_share = 0.2 }")
    record = record_of_result(simulate(coarse(held), fidelity="quick"))
    write_record(tmp_path, record)
    believed = believed_study(read_record(tmp_path).tables)
    assert believed.conditions.held_energy_mJ == 0.05
    assert believed.conditions.load_cycle.amplitude == 0.2
    with pytest.raises(
        RecordError, match="has a load that varies within the cycle, which the fast model does not foresee"
    ):
        fit_record(record)
    steady = record.tables.conditions.model_copy(update={"load_cycle": None})
    steady = steady.model_copy(update={"held_energy_mJ": None, "held_tangential_force_N": 1.0})
    with pytest.raises(
        RecordError, match=r"holds its tangential force, which says nothing of how far the bodies slide"
    ):
        fit_record(replace(record, tables=record.tables.model_copy(update={"conditions": steady})))


def test_an_unknown_key_of_a_block_is_passed_over_with_its_line(measured: ExperimentRecord, tmp_path: Path) -> None:
    write_record(tmp_path, measured)
    file = tmp_path / "experiment.toml"
    text = file.read_text(encoding="utf-8").partition("# The files as wirewear wrote them")[0]
    file.write_text(text.replace("cycles = 50,", 'cycles = 50, lubricant = "oil",', 1), encoding="utf-8")
    assert any("lubricant" in note for note in read_record(tmp_path).notes)
