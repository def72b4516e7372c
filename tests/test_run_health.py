"""How sound a run is: what closes exactly, what must be mirrored, and what a faulty cycle shows."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable
from dataclasses import replace
from math import exp, isnan, log, pi
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.typing import NDArray

from solvers import (
    ContactProblem,
    ContactState,
    CycleTrace,
    Symmetry,
    closed_cycle,
    first_quarter,
    mirror_error,
    symmetry_of,
)
from studies.benchmarks.measured_process import ProcessCost, Usage, run_measured
from tests.bodies import AMPLITUDE_mm, RIG_N_per_mm, crossed_wires, pressed
from wirewear import ExperimentRecord, read_record
from wirewear.diagnosis.observe.definitions import of_own_definitions
from wirewear.records import check_record
from wirewear.simulation.contact_forces import at_mid_stroke, mean_pressures, nodal_pressures, pressure_figures
from wirewear.simulation.tally import Counters, area_mismatch, bends, energy_mismatch, mirrored_mismatch

Array = NDArray[np.float64]
EXAMPLE = Path(__file__).parents[1] / "studies/steel_wires/example_records/no_gap"

MESH_mm = 0.010
INCREMENTS = 24

WAITING = """
import os, time
{work}
open("worked", "w").close()
while not os.path.exists("looked at"):
    time.sleep(0.01)
"""


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


def test_a_process_is_measured(tmp_path: Path) -> None:
    cost = run_measured(["sh", "-c", "exit 3"], tmp_path, tmp_path / "log")
    assert cost.status == 3
    assert not cost.stopped
    assert cost.peak_memory_MB > 0.0


def looked_at(folder: Path, work: str) -> ProcessCost:
    """What a program takes that does some work and ends when it has been looked at since."""
    folder.mkdir()
    worked = False

    def watch(_: Usage) -> None:
        nonlocal worked
        if worked:
            (folder / "looked at").touch()
        worked = (folder / "worked").exists()

    return run_measured([sys.executable, "-S", "-c", WAITING.format(work=work)], folder, folder / "log", watch=watch)


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="memory of a running process is read from /proc")
def test_memory_is_that_of_the_program_itself_and_not_of_its_parent(tmp_path: Path) -> None:
    ballast = np.ones(2**25)
    small = looked_at(tmp_path / "small", "pass")
    assert small.peak_memory_MB < 20.0 < ballast.nbytes / 2**20
    large = looked_at(tmp_path / "large", "b = bytearray(b'x') * 10**8; del b")
    assert 95.0 < large.peak_memory_MB < 140.0


def test_a_process_is_stopped_when_its_time_is_over(tmp_path: Path) -> None:
    seen = list[Usage]()
    cost = run_measured(["sleep", "3600"], tmp_path, tmp_path / "log", most_s=0.3, watch=seen.append)
    assert cost.stopped
    assert cost.status == -signal.SIGKILL
    assert 0.3 < cost.wall_s < 3600.0
    assert seen


def test_the_environment_of_a_process_can_be_set(tmp_path: Path) -> None:
    run_measured(["sh", "-c", "echo $BALLAST"], tmp_path, tmp_path / "log", environment={"BALLAST": "lead"})
    assert (tmp_path / "log").read_text() == "lead\n"


@pytest.fixture(scope="module")
def problem() -> ContactProblem:
    return crossed_wires(MESH_mm, long_patch=True, rig_N_per_mm=RIG_N_per_mm)


@pytest.fixture(scope="module")
def cycle(problem: ContactProblem) -> CycleTrace:
    start = first_quarter(problem, pressed(problem)[0], AMPLITUDE_mm, INCREMENTS)
    return closed_cycle(problem, start, AMPLITUDE_mm, INCREMENTS)[1]


def test_a_closed_cycle_of_symmetric_bodies_is_its_own_mirror_image(problem: ContactProblem, cycle: CycleTrace) -> None:
    assert mirrored_mismatch(problem, cycle) < 1e-6


def test_mirror_error_is_the_share_of_the_load_that_stands_elsewhere(
    problem: ContactProblem, cycle: CycleTrace
) -> None:
    symmetry, place = symmetry_of(problem), INCREMENTS // 4
    moved = cycle.states[place].traction.copy()
    pressed_nodes = np.flatnonzero(moved[:, 2] > 0.0)
    taken, given_to = pressed_nodes[0], int(np.flatnonzero(moved[:, 2] == 0.0)[0])
    areas = problem.surface.areas
    load = float(areas @ moved[:, 2])
    share = float(areas[taken] * moved[taken, 2]) / load
    moved[given_to, 2] = moved[taken, 2] * areas[taken] / areas[given_to]
    moved[taken, 2] = 0.0
    states = list(cycle.states)
    states[place] = replace(states[place], traction=moved)
    assert mirror_error(problem, tuple(states), symmetry) == pytest.approx(share, rel=1e-3)


def test_states_that_only_one_way_has_are_left_out(problem: ContactProblem, cycle: CycleTrace) -> None:
    symmetry, place = symmetry_of(problem), INCREMENTS // 4
    wrong = replace(cycle.states[place], traction=np.zeros_like(cycle.states[place].traction), drive=0.01234)
    states = (*cycle.states[:place], wrong, *cycle.states[place + 1 :])
    assert mirror_error(problem, states, symmetry) == pytest.approx(mirrored_mismatch(problem, cycle), abs=1e-6)


def test_mirror_error_is_undefined_where_nothing_takes_the_way_out_into_the_way_back(
    problem: ContactProblem, cycle: CycleTrace
) -> None:
    assert mirror_error(problem, cycle.states, Symmetry()) is None
    leaning = replace(problem, upper=replace(problem.upper, incline=1e-3))
    assert isnan(mirrored_mismatch(leaning, cycle))


def test_what_a_run_does_not_define_is_not_among_its_figures() -> None:
    counters = Counters()
    counters.worst("mirror_error", float("nan"))
    assert "mirror_error" not in counters.quality()
    for value in (0.1, float("nan"), 0.3, 0.2):
        counters.worst("mirror_error", value)
    assert counters.quality()["mirror_error"] == 0.3


def test_loop_area_is_the_friction_work(cycle: CycleTrace) -> None:
    assert area_mismatch(cycle) < 0.01
    assert area_mismatch(replace(cycle, work=1.1 * cycle.work)) == pytest.approx(1.0 - 1.0 / 1.1, abs=0.01)


def test_a_loop_without_area_has_none_to_compare(cycle: CycleTrace) -> None:
    line = replace(cycle, tangential_force=20.0 * cycle.drive)
    assert area_mismatch(line) == 0.0


def test_pressure_at_mid_stroke_is_the_median_over_the_way_not_over_increments() -> None:
    # Five increments crowd where the pressure is 9; most of the way it is 1, and beyond 35 of 60 µm it is 100.
    drives = [0.06, 0.03, 0.01, 0.009, 0.008, 0.007, 0.006, -0.02, -0.03, -0.06]
    pressures = [100.0, 1.0, 9.0, 9.0, 9.0, 9.0, 9.0, 1.0, 1.0, 100.0]
    assert at_mid_stroke(drives, pressures) == 1.0


def test_nodal_pressures_are_those_of_the_increments(problem: ContactProblem, cycle: CycleTrace) -> None:
    pressures = nodal_pressures(problem, cycle.states)
    assert pressures.max(axis=1) == pytest.approx([report.max_pressure for report in cycle.reports], rel=0.01)


def test_a_mean_over_less_than_a_cell_is_the_nodes_pressure(problem: ContactProblem, cycle: CycleTrace) -> None:
    tiny = 1e-3 * problem.primary.patch.smallest_element
    nodes = nodal_pressures(problem, cycle.states).max(axis=1)
    assert mean_pressures(problem, cycle.states, tiny) == pytest.approx(nodes)


def test_a_mean_over_all_of_the_contact_is_the_load_over_that_disc(problem: ContactProblem, cycle: CycleTrace) -> None:
    diameter = 0.1
    means = mean_pressures(problem, cycle.states, diameter)
    assert means == pytest.approx(cycle.normal_force / (0.25 * pi * diameter**2), rel=0.01)


def test_the_largest_mean_is_that_of_any_increment(problem: ContactProblem, cycle: CycleTrace) -> None:
    """A peak between the positions that are recorded counts."""
    place, length = INCREMENTS // 3, 0.01
    states = list(cycle.states)
    states[place] = replace(states[place], traction=3.0 * states[place].traction)
    found = pressure_figures(problem, replace(cycle, states=tuple(states)), length)
    calm = mean_pressures(problem, cycle.states, length)
    assert found["max_mean_pressure_MPa"] == pytest.approx(3.0 * calm[place])
    assert found["mid_stroke_mean_pressure_MPa"] == pytest.approx(at_mid_stroke(cycle.drive, calm), rel=0.02)
    assert found["max_pressure_MPa"] == max(report.max_pressure for report in cycle.reports)


@given(st.floats(-2.5, 2.5), st.lists(st.floats(1.1, 20.0), min_size=1, max_size=6))
def test_energy_that_changes_as_a_power_of_the_cycles_is_summed_exactly(power: float, ratios: list[float]) -> None:
    cycles = [float(cycle) for cycle in np.cumprod([1.0, *ratios])]
    assume(abs(power + 1.0) > 1e-6)
    # The first cycle has the energy of its loop.
    whole = 1.0 + (cycles[-1] ** (power + 1.0) - 1.0) / (power + 1.0)
    per_cycle = [cycle**power for cycle in cycles]
    assert energy_mismatch(cycles, per_cycle, whole) < 1e-8
    more = 1.25 * max(whole, 1.0 + float(np.trapezoid(per_cycle, cycles)))
    assert energy_mismatch(cycles, per_cycle, more) == pytest.approx(1.0 - whole / more)


def test_energy_that_falls_as_the_reciprocal_of_the_cycles_sums_to_the_logarithm() -> None:
    assert energy_mismatch([1.0, 7.0, 50.0], [3.0, 3.0 / 7.0, 3.0 / 50.0], 3.0 + 3.0 * log(50.0)) < 1e-12


def test_loops_too_few_to_follow_an_energy_that_fades_say_nothing_of_what_has_worn() -> None:
    def fading(cycles: list[float]) -> list[float]:
        return [exp(-cycle / 300.0) for cycle in cycles]

    few, many = [1.0, 300.0, 1000.0, 3000.0], [float(cycle) for cycle in np.linspace(1.0, 3000.0, 200)]
    worn = exp(-1.0 / 300.0) + 300.0 * (exp(-1.0 / 300.0) - exp(-10.0))
    assert np.isnan(energy_mismatch(few, fading(few), worn))
    assert energy_mismatch(many, fading(many), worn) < 2e-3
    # What lies beyond any course between the loops is wrong, however few they are.
    assert energy_mismatch(few, fading(few), 0.3 * worn) > 1.0


def test_loops_that_dissipate_nothing_enclose_nothing() -> None:
    assert energy_mismatch([1.0, 11.0], [0.0, 0.2], 1.0) == pytest.approx(0.0)


def test_nothing_worn_is_nothing_to_compare(problem: ContactProblem) -> None:
    state: ContactState = pressed(problem)[0]
    assert energy_mismatch([1.0], [0.2], state.wear.energy_mJ) == 0.0


@given(st.floats(-0.9, 2.0), st.floats(1.5, 10.0), st.floats(0.0, 5.0))
def test_energy_bends_when_less_or_more_has_worn_than_a_power_of_the_cycles_tells(
    power: float, ratio: float, before: float
) -> None:
    worn = (ratio ** (power + 1.0) - 1.0) / (power + 1.0)
    now = (ratio, ratio**power, before + worn)
    assert not bends((1.0, 1.0, before), now)
    assert bends((1.0, 1.0, before), (ratio, 1.1 * now[1] + 0.1 * (before / worn + 1.0) * now[1], now[2]))
