"""Programmes of blocks, drives that hold a figure of the loop by their amplitude, tests that stop at a stated wear."""

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from solvers import SolverError
from tests.diagnosis.diagnosis_cases import record
from tests.exam.frozen_states import frozen_states
from tests.studies import LONG, ROUGH, WEARING, block, coarse, line_study
from wirewear import RunResult, StudyError, load_study
from wirewear.base.errors import RecordError
from wirewear.diagnosis import diagnose
from wirewear.diagnosis.fit.without_plateau import friction_of_forces, needs_search
from wirewear.diagnosis.observe.channels import half_width, loop_area
from wirewear.diagnosis.surrogate.candidates import library
from wirewear.diagnosis.surrogate.forward import PredictedLoops
from wirewear.diagnosis.surrogate.forward import simulate as simulate_fast
from wirewear.diagnosis.surrogate.nominal import nominal_study
from wirewear.diagnosis.surrogate.nominal_model import nominal_inputs
from wirewear.effects.holder import HeldDisplacement
from wirewear.effects.sensors import DisplacementGain
from wirewear.loops.sensor import Sensor, SensorNoise
from wirewear.records import ExperimentRecord, read_record, record_of_result, write_record
from wirewear.records.evolution_checks import accumulated_energy_J
from wirewear.records.values import stated_study
from wirewear.reference import first_loading_force, partial_slip_point, sliding_threshold
from wirewear.simulation import simulate
from wirewear.simulation.control import HELD_FIGURES, HeldFigure, amplitude_from
from wirewear.simulation.cycling import FIGURES, Ending
from wirewear.simulation.runs import run_study
from wirewear.test.conditions import Asked, Stop, held_keys

STEEL_WIRES = Path(__file__).parents[2] / "studies" / "steel_wires" / "study.toml"
ON_A_RIG = (
    ROUGH.replace("cycles = 1\n", "cycles = 200\n{held}\n")
    + WEARING
    + "[holder]\n"
    + ("tangential_stiffness_N_per_mm = 167.0\n")
)


def held(text: str, base: str = ON_A_RIG) -> str:
    return base.replace("{held}", text)


@pytest.mark.first_case
@pytest.mark.parametrize(
    ("key", "target", "column"),
    [
        ("held_slip_amplitude_um", 8.0, "slip_amplitude_um"),
        ("held_tangential_force_N", 0.9, "max_tangential_force_N"),
        ("held_energy_mJ", 0.03, "dissipated_energy_mJ"),
    ],
)
@pytest.mark.seconds
def test_what_a_drive_holds_is_held_at_every_loop_by_its_amplitude(key: str, target: float, column: str) -> None:
    evolution = simulate(coarse(held(f"{key} = {target}")), fidelity="quick").evolution
    assert evolution[column] == pytest.approx(target, rel=2.5e-3)
    assert np.abs(evolution["held_error"]).max() <= 2e-3
    assert evolution["displacement_amplitude_um"].max() < 20.0


@pytest.mark.seconds
def test_a_held_motion_is_that_of_the_bodies_and_a_held_reading_is_wrong_by_its_gain() -> None:
    result = simulate(coarse(held("held_motion_um = 9.0")), fidelity="quick")
    for loop in result.loops:
        assert 0.5 * np.ptp(loop.relative_displacement_um) == pytest.approx(9.0, rel=2e-3)
    study = coarse(held("held_reading_um = 12.0")).with_effects(DisplacementGain(gain=1.2))
    evolution = simulate(study, fidelity="quick").evolution
    assert evolution["displacement_amplitude_um"] == pytest.approx(10.0, rel=1e-3)


def test_line_contacts_hold_too_and_a_force_above_friction_cannot_be_held() -> None:
    study = line_study(conditions={"cycles": 200, "held_energy_mJ_per_mm": 0.3}, log={"loop_cycles": [1, 200]})
    assert simulate(study, fidelity="quick").evolution["dissipated_energy_mJ"] == pytest.approx(0.3, rel=3e-3)
    with pytest.raises(
        SolverError, match=r"cannot hold held_tangential_force_N = 1.5: at its largest amplitude, 20 um"
    ):
        simulate(coarse(held("held_tangential_force_N = 1.5")), fidelity="quick")


def test_a_motion_held_under_a_load_that_comes_twice_a_cycle_is_as_wide_where_it_wears_as_in_the_loop() -> None:
    twice = {"amplitude_share": 0.6, "lag_deg": 273.0, "frequency_ratio": 2}
    study = line_study(
        conditions={"cycles": 1, "held_motion_um": 20.0, "displacement_amplitude_um": 60.0, "load_cycle": twice},
        holder={"tangential_stiffness_N_per_mm": 1500.0},
    )
    first = simulate(study, fidelity="quick").evolution
    assert 1e3 * first["accumulated_energy_J"] == pytest.approx(first["dissipated_energy_mJ"], rel=2e-3)


def test_a_drive_holds_one_figure() -> None:
    with pytest.raises(StudyError, match="held_energy_mJ are both given, but a drive holds one"):
        coarse(held("held_slip_amplitude_um = 5\nheld_energy_mJ = 1"))


@pytest.mark.seconds
def test_a_test_stops_where_a_scar_is_as_deep_as_stated(tmp_path: Path) -> None:
    study = line_study(stop={"depth_um": 1.0, "accumulated_energy_J": 5.0})
    (result,) = run_study(study, fidelity="quick", output=tmp_path)
    end = result.evolution["cycle"][-1]
    deepest = max(float(result.evolution[f"max_depth_{body}_um"][-1]) for body in ("pad", "specimen"))
    assert deepest == pytest.approx(1.0, rel=max(2e-3, 1.0 / end))
    assert result.status == "complete"
    assert result.message.endswith("cycles simulated: depth_um has reached its stop")
    assert result.loops[-1].cycle == end
    (again,) = run_study(study, fidelity="quick", output=tmp_path, resume=True)
    assert again.evolution["cycle"][-1] == end


def grown(figures: dict[float, float], target: float) -> Ending:
    ending = Ending({"depth_um": target})
    ending.figures_so_far["depth_um"] = list(figures.items())
    return ending


def test_the_interval_of_an_end_predicted_by_a_power_holds_changing_powers() -> None:
    ending = grown({float(n): 0.1 * n**0.5 for n in (1, 10, 100, 400, 1000, 2000, 4000)}, 20.0)
    assert ending.expected_end() == "; depth_um = 20 is expected after 40\u2009000 cycles (40\u2009000 to 40\u2009000)"

    def depth(n: float) -> float:
        return float(0.1 * n**0.5 / (1.0 + n / 2e4))

    ending = grown({float(n): depth(n) for n in (1, 10, 100, 400, 1000, 2000, 4000)}, depth(8000.0))
    ends: Any = ending._ends("depth_um")
    assert ends[1] < 8000.0 < ends[2]


@pytest.mark.parametrize("figures", [{}, {1.0: 0.1}, {1.0: 0.1, 2.0: 0.1, 8.0: 0.1, 16.0: 0.1}])
def test_no_end_is_predicted_of_a_figure_that_is_young_or_does_not_grow(figures: dict[float, float]) -> None:
    assert grown(figures, 20.0).expected_end() == ""


def test_every_figure_that_a_study_may_state_is_known() -> None:
    assert set(FIGURES) == set(Stop.model_fields)


CYCLES = np.geomspace(1.0, 1e5, 11)


def driven(held: str, **effect: float) -> PredictedLoops:
    """Fast loops of the steel wires under a drive that holds 45 um of slip or 0.2 mJ a cycle."""
    conditions = nominal_study(record(repeats=1)).conditions
    setup = nominal_inputs(
        nominal_study(record(repeats=1)).changed({"conditions": {held: 45.0 if "um" in held else 0.2}}), "sensor"
    )
    assert setup.amplitude_um < conditions.displacement_amplitude_um
    return simulate_fast(frozen_states(), setup.with_effect(HeldDisplacement(**effect)) if effect else setup, CYCLES)


@pytest.mark.parametrize(("held", "target"), [("held_slip_amplitude_um", 45.0), ("held_energy_mJ", 0.2)])
def test_the_fast_model_holds_what_the_drive_does_by_an_amplitude_that_grows(held: str, target: float) -> None:
    course = driven(held)
    x, q = course.displacement_um, course.tangential_force_N
    assert (half_width(x, q) if "um" in held else loop_area(x, q)) == pytest.approx(target, rel=2e-3)
    assert np.all(np.diff(0.5 * np.ptp(x, axis=(1, 2))[6:]) > 0.0)


def test_a_drive_that_holds_its_displacement_loses_slip_where_it_was_to_hold_that() -> None:
    course = driven("held_slip_amplitude_um", displacement_amplitude_um=53.0)
    assert 0.5 * np.ptp(course.displacement_um, axis=(1, 2)) == pytest.approx(53.0, rel=1e-3)
    # As by the full simulation, 44.99 at first and 41.55 at last; these wear states are those of a stroke of 60 um.
    slip = half_width(course.displacement_um, course.tangential_force_N)
    assert slip[[0, -1]] == pytest.approx([44.99, 41.55], rel=0.015)


def test_a_drive_is_suspected_to_hold_its_displacement_only_where_it_is_stated_to_hold_something_else() -> None:
    study = nominal_study(record(repeats=1))
    slipping = study.changed({"conditions": {"held_slip_amplitude_um": 45.0}})
    names = [{one.name for one in library(nominal_inputs(own, "sensor"))} for own in (study, slipping)]
    assert names[1] - names[0] == {"held_displacement"}


@pytest.mark.parametrize(
    ("stated", "key"), [("held_slip_amplitude_um = 8.0", "held_slip_amplitude_um"), ("", "held_energy_mJ")]
)
def test_an_effect_has_all_blocks_hold_its_displacement(stated: str, key: str) -> None:
    study = coarse(held(stated) + f"[[programme]]\ncycles = 1\nconditions.{key} = 4.0\n")
    moved = study.with_effects(HeldDisplacement(displacement_amplitude_um=20.0)).driven
    assert [held_keys(own.study.conditions) for own in moved.schedule.stretches] == [[]]
    assert moved.envelope.conditions.displacement_amplitude_um == 20.0


@pytest.mark.slow
@pytest.mark.parametrize("truly", [(), (HeldDisplacement(displacement_amplitude_um=53.0),)])
def test_a_rig_that_held_its_displacement_is_distinguished_from_one_that_held_the_slip(truly: Any) -> None:
    study = load_study(STEEL_WIRES).variant("compliant").changed({"conditions": {"held_slip_amplitude_um": 45.0}})
    result = simulate(study.with_effects(*truly), fidelity="quick")
    sensor = Sensor(noise=SensorNoise(displacement_um=0.15, tangential_force_N=0.008))
    found = diagnose(record_of_result(result, sensor=sensor, repeats=3)).diagnosis
    assert found.verdict == ("explained" if truly else "no_gap")
    if truly:
        assert found.causes[0].effect == "held_displacement"
        assert found.causes[0].parameters["displacement_amplitude_um"].value == pytest.approx(53.0, rel=0.01)


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


def test_meshes_suit_the_largest_load_stroke_and_wear_of_all_blocks() -> None:
    largest = coarse(LONG + SHORTER).envelope
    assert largest.conditions.displacement_amplitude_um == 20.0
    assert largest.conditions.normal_load_N == 2.0
    assert largest.conditions.cycles == 250 + 50 + int(np.ceil(100 * 12.0 * 1.5 / (20.0 * 2.0)))
    study = coarse(LONG + SHORTER)
    assert len(study.schedule.stretches) == 5
    assert len(pickle.loads(pickle.dumps(study)).schedule.stretches) == 5


@pytest.mark.seconds
def test_two_blocks_of_one_amplitude_are_one_of_both_bit_by_bit() -> None:
    log = {"loop_cycles": [1, 10, 100, 400]}
    alone, blocks = (
        simulate(line_study(conditions={"cycles": 400}, log=log, programme=programme), fidelity="quick")
        for programme in (None, [{"cycles": 150}, {"cycles": 250}])
    )
    of_series = {cycle: index for index, cycle in enumerate(blocks.evolution["cycle"])}
    assert "block" not in blocks.evolution
    for cycle in (1.0, 10.0, 100.0):
        index = of_series[cycle]
        for name, column in alone.evolution.items():
            assert column[list(alone.evolution["cycle"]).index(cycle)] == blocks.evolution[name][index], name


@pytest.fixture(scope="module")
def of_blocks() -> RunResult:
    return simulate(coarse(LONG + SHORTER + block(60, "contact.friction = 0.5")), fidelity="quick")


@pytest.mark.seconds
def test_each_block_has_its_own_stroke_and_load_and_all_energy_is_that_of_their_loops(of_blocks: RunResult) -> None:
    result = of_blocks
    found = {int(cycle): index for index, cycle in enumerate(result.evolution["cycle"])}
    at = {cycle: {name: float(column[i]) for name, column in result.evolution.items()} for cycle, i in found.items()}
    assert [at[cycle]["block"] for cycle in (100, 150, 210, 310, 400)] == [1.0, 2.0, 3.0, 1.0, 3.0]
    assert at[150]["displacement_amplitude_um"] == pytest.approx(12.0)
    assert at[150]["normal_force_N"] == pytest.approx(1.5)
    assert result.loop(150).normal_force_N.mean() == pytest.approx(1.5)
    assert at[400]["displacement_amplitude_um"] == pytest.approx(20.0)
    # The energy per cycle of a worn contact hardly changes within a block.
    energy_mJ = [at[cycle]["dissipated_energy_mJ"] for cycle in (100, 150, 210)]
    assert at[400]["accumulated_energy_J"] == pytest.approx(1e-3 * np.dot([200, 100, 100], energy_mJ), rel=0.02)
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
    ("programme", "message"),
    [
        (block(100, "conditions.cycles = 3"), r"conditions in \[\[programme\]\] number 1 .*same for the whole test"),
        (block(100, "contact = 3"), r"contact in \[\[programme\]\] number 1 .*must be a table"),
        (block(100, "conditions.normal_load_N = -1"), r"normal_load_N in \[conditions\] of block 1 of the programme"),
        (block(1).replace("cycles", "cycle"), "did you mean 'cycles'"),
        ("[programme]\ncycles = 3\n", "programme .*must be a list of tables"),
    ],
)
def test_a_programme_that_cannot_be_is_stated_with_its_block(programme: str, message: str) -> None:
    with pytest.raises(StudyError, match=message):
        coarse(LONG + programme)


def test_a_programme_of_more_blocks_than_a_run_goes_through_is_refused() -> None:
    with pytest.raises(StudyError, match=r"programme .*comes to 100.000 blocks"):
        coarse(LONG.replace("cycles = 400", "cycles = 100000") + block(1) + block(1, "contact.friction = 0.3"))


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory, of_blocks: RunResult) -> ExperimentRecord:
    """A test by blocks as its logger leaves it, read back from its files."""
    folder = tmp_path_factory.mktemp("record")
    write_record(folder, record_of_result(of_blocks, repeats=2))
    return read_record(folder)


@pytest.mark.seconds
def test_a_record_states_the_programme_that_its_simulation_had(measured: ExperimentRecord) -> None:
    stated = stated_study(measured.tables)
    assert [(own.end, own.block) for own in stated.schedule.stretches] == [
        (100, 1), (150, 2), (210, 3), (310, 1), (360, 2), (400, 3),
    ]  # fmt: skip
    assert [own.study.contact.friction for own in stated.schedule.stretches[:3]] == [0.62, 0.62, 0.5]
    assert [own.study.conditions.normal_load_N for own in stated.schedule.stretches[:3]] == [2.0, 1.5, 2.0]


def test_a_block_of_a_record_is_a_test_of_its_conditions_in_which_all_wear(measured: ExperimentRecord) -> None:
    third = measured.of_block(3)
    assert third.tables.stated.friction == 0.5
    assert {loop.cycle for loop in third.loops} <= set(range(151, 211)) | set(range(361, 401))
    assert {tuple(part.columns["block"]) for part in third.evolution if "block" in part.columns} <= {(3.0,)}
    # All energy of the test, from the loops of one block: that of the run.
    whole = accumulated_energy_J(measured.of_block(1), 1)
    assert whole == pytest.approx(accumulated_energy_J(third, 1), rel=0.02)
    assert third.of_block() is third
    stated = stated_study(third.tables)
    assert [own.study.contact.friction for own in stated.schedule.stretches[:3]] == [0.62, 0.62, 0.5]


def test_by_default_the_block_with_the_longest_stroke_and_most_loops_is_looked_at(measured: ExperimentRecord) -> None:
    assert [(part.block, bool(part.scars)) for part in measured.blocks()] == [(1, True), (2, False), (3, False)]
    assert measured.of_block(2).scars == ()
    assert needs_search(measured.of_block(2))
    assert not needs_search(measured.of_block())
    with pytest.raises(RecordError, match=r"has no loop of block 7 .*: it has loops of 1, 2, 3"):
        measured.of_block(7)


@pytest.mark.seconds
def test_a_record_states_a_load_that_varies_and_what_the_drive_holds_and_shows_friction(tmp_path: Path) -> None:
    held = LONG.replace("cycles = 400", "cycles = 1\nheld_energy_mJ = 0.05\nload_cycle = { amplitude_share = 0.2 }")
    record = record_of_result(simulate(coarse(held), fidelity="quick"))
    write_record(tmp_path, record)
    stated = stated_study(read_record(tmp_path).tables)
    assert stated.conditions.held_energy_mJ == 0.05
    assert stated.conditions.load_cycle.amplitude == 0.2
    assert needs_search(record)
    # Walls and noise are in it, too: a search begins there.
    assert friction_of_forces(record) == pytest.approx(record.tables.stated.friction, rel=0.05)


def test_an_unknown_key_of_a_block_is_passed_over_with_its_line(measured: ExperimentRecord, tmp_path: Path) -> None:
    write_record(tmp_path, measured)
    file = tmp_path / "experiment.toml"
    text = file.read_text(encoding="utf-8").partition("# The files as wirewear wrote them")[0]
    file.write_text(text.replace("cycles = 50,", 'cycles = 50, lubricant = "oil",', 1), encoding="utf-8")
    assert any("lubricant" in note for note in read_record(tmp_path).notes)


@pytest.mark.parametrize("largest_mm", [1e-3, 20e-3, 1.0])
@pytest.mark.parametrize("share", [0.15, 0.7, 0.98])
@pytest.mark.parametrize("rig_N_per_mm", [1e9, 167.0])
def test_a_held_force_finds_its_amplitude_whatever_the_drive_has_at_most(
    largest_mm: float, share: float, rig_N_per_mm: float
) -> None:
    contact = partial_slip_point(40.0, 0.6, 0.118, 9.5e4)
    largest_mm += sliding_threshold(contact, rig_N_per_mm)

    def force(place_mm: Any) -> float:
        return float(first_loading_force(contact, place_mm, rig_N_per_mm))

    held = HeldFigure("held_tangential_force_N", share * contact.limit_N, "N", largest_mm, lambda *_: 0.0, None, 0.0)
    tried: list[float] = []

    def moved_to(place_mm: float) -> Any:
        tried.append(place_mm)
        return place_mm

    found = amplitude_from(held, force, moved_to)
    assert force(found) == pytest.approx(held.target, rel=2e-4)
    assert len(tried) < 40


def test_a_held_force_that_friction_just_bears_is_met_before_everything_slides() -> None:
    """On a mesh friction comes to its limit slowly, as nodes that slide turn into the motion."""
    contact = partial_slip_point(40.0, 0.6, 0.118, 9.5e4)
    slides = sliding_threshold(contact, 1e9)

    def force(place_mm: Any) -> float:
        return float(first_loading_force(contact, place_mm, 1e9) * (1.0 - 4e-4 / (1.0 + (place_mm / slides) ** 2)))

    held = HeldFigure("held_tangential_force_N", contact.limit_N, "N", 0.1, lambda *_: 0.0, None, 0.0)

    def moved_to(place_mm: Any) -> Any:
        return place_mm

    assert amplitude_from(held, force, moved_to) == pytest.approx(slides, rel=0.02)


@pytest.mark.parametrize("offset_N", [0.0, 0.6])
def test_a_held_force_is_found_where_force_goes_with_the_way_or_is_there_before_it(offset_N: float) -> None:
    def force(place_mm: Any) -> float:
        return offset_N + 3.0 * float(place_mm)

    def moved_to(place_mm: Any) -> Any:
        return place_mm

    held = HeldFigure("held_tangential_force_N", 1.0, "N", 1e6, lambda *_: 0.0, None, 0.0)
    assert force(amplitude_from(held, force, moved_to)) == pytest.approx(1.0, rel=1e-3)


def test_every_figure_that_a_drive_can_hold_is_measured() -> None:
    assert [key.split("_")[1] for key in Asked.model_fields if key.startswith("held_")] == list(HELD_FIGURES)
