"""Wear during contact: book-keeping of energy and volume, and what a state remembers."""

import pickle
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from solvers import Archard, ContactProblem, ContactState, Drive, IncrementReport, OxygenSupply, SolverError, run_cycle
from tests.bodies import FRICTION, AMPLITUDE_mm, RIG_N_per_mm, crossed_wires, driven, pressed
from tests.solvers.wear_jumps import INCREMENTS, STROKE_mm, at_the_end, jumped, wires, worn
from tests.studies import MINIMAL, line_study
from wirewear import parse_study
from wirewear.results import RunResult
from wirewear.simulation import simulate
from wirewear.simulation.problem import worn_depths

MESH_mm = 0.010
RATES = (1.5e-8, 0.5e-8)
CYCLES = 20.0
HALF_CYCLE = AMPLITUDE_mm * np.sin(np.pi * np.arange(1, 21) / 20)
Run = tuple[list[ContactState], list[list[IncrementReport]]]


def wearing(primary_is_upper: bool = True) -> ContactProblem:
    return crossed_wires(
        MESH_mm, long_patch=True, rig_N_per_mm=RIG_N_per_mm, wear=RATES, primary_is_upper=primary_is_upper
    )


@pytest.fixture(scope="module", params=[True, False], ids=["upper primary", "lower primary"])
def problem(request: pytest.FixtureRequest) -> ContactProblem:
    return wearing(request.param)


@pytest.fixture(scope="module")
def run(problem: ContactProblem) -> Run:
    return driven(problem, pressed(problem)[0], HALF_CYCLE, CYCLES)


def volumes(problem: ContactProblem, state: ContactState) -> tuple[float, float]:
    """Worn volumes of the upper and the lower body, mm3."""
    lower, upper = worn_depths(problem, state)
    areas = problem.upper.patch.node_areas(), problem.lower.patch.node_areas()
    return float(areas[0] @ upper.ravel()), float(areas[1] @ lower.ravel())


@pytest.mark.seconds
def test_worn_volume_is_wear_coefficient_times_energy_on_both_bodies(problem: ContactProblem, run: Run) -> None:
    states, reports = run
    work = states[-1].wear.energy_mJ
    assert work > 0.1
    # The pressure's work on what moves along small-strain normals belongs to the drive's, and wears nothing.
    assert work == pytest.approx(CYCLES * sum(piece.friction_work for pieces in reports for piece in pieces), rel=5e-3)
    for volume, rate in zip(volumes(problem, states[-1]), RATES, strict=True):
        assert volume == pytest.approx(rate * work, rel=1e-12)


def test_energy_per_area_adds_up_to_the_energy_on_both_bodies(problem: ContactProblem, run: Run) -> None:
    wear = run[0][-1].wear
    assert problem.primary.patch.node_areas() @ wear.primary_energy.ravel() == pytest.approx(wear.energy_mJ, rel=1e-12)
    secondary = problem.secondary.patch.node_areas() @ wear.secondary_energy.ravel()
    assert secondary == pytest.approx(wear.energy_mJ, rel=1e-12)


def test_only_loaded_points_wear_and_none_grows_back(problem: ContactProblem, run: Run) -> None:
    states, reports = run
    for before, after, pieces in zip(states[:-1], states[1:], reports[1:], strict=True):
        grown = (after.wear.primary_depth - before.wear.primary_depth).ravel()
        assert grown.min() >= 0.0
        if len(pieces) == 1:
            assert not grown[(before.traction[:, 2] <= 0.0) & (after.traction[:, 2] <= 0.0)].any()
            opposite = (after.wear.secondary_depth - before.wear.secondary_depth).ravel()
            assert opposite.min() >= 0.0
            assert not opposite[~(before.secondary_force.any(axis=1) | after.secondary_force.any(axis=1))].any()


def test_wear_relieves_the_pressure(run: Run) -> None:
    peaks = [pieces[-1].max_pressure for pieces in run[1]]
    assert peaks[-1] < 0.97 * peaks[0]


def test_a_run_cut_in_two_equals_the_unbroken_run(problem: ContactProblem, run: Run) -> None:
    # A fresh problem chooses its windows again, which changes the order of sums and nothing else.
    saved = pickle.loads(pickle.dumps(run[0][9]))
    resumed = driven(wearing(problem.primary_is_upper), saved, HALF_CYCLE[10:], CYCLES)[0]
    for one, other in zip(run[0][10:], resumed, strict=True):
        assert other.holder_x == pytest.approx(one.holder_x, abs=1e-12)
        assert other.holder_z == pytest.approx(one.holder_z, abs=1e-12)
        assert other.traction == pytest.approx(one.traction, abs=1e-9 * one.traction.max())
        deepest = one.wear.primary_depth.max()
        assert other.wear.primary_depth == pytest.approx(one.wear.primary_depth, abs=1e-10 * deepest)


RATES_OF_LAWS = (1.5e-8, 1.5e-8)
WORN = MINIMAL + "[wear]\n"


@pytest.fixture(scope="module")
def energy_law() -> ContactProblem:
    return crossed_wires(MESH_mm, long_patch=True, wear=RATES_OF_LAWS)


def depth_error(one: ContactState, other: ContactState) -> float:
    return max(
        float(np.abs(a - b).max() / b.max())
        for a, b in (
            (one.wear.primary_depth, other.wear.primary_depth),
            (one.wear.secondary_depth, other.wear.secondary_depth),
        )
    )


def test_at_constant_friction_archard_is_the_energy_law_times_friction(energy_law: ContactProblem) -> None:
    archard = replace(energy_law, wear=replace(energy_law.wear.scaled(FRICTION), law=Archard()))
    one, other = worn(archard, 20.0), worn(energy_law, 20.0)
    assert depth_error(one, other) < 1e-3
    assert one.wear.energy_mJ == pytest.approx(other.wear.energy_mJ, rel=1e-4)
    assert one.wear.primary_volume_mm3 == pytest.approx(other.wear.primary_volume_mm3, rel=1e-4)


def test_without_friction_archard_wears_and_the_energy_law_does_not(energy_law: ContactProblem) -> None:
    slippery = replace(energy_law, friction=0.0)
    archard = replace(slippery, wear=replace(energy_law.wear, law=Archard()))
    assert not worn(slippery, 20.0).wear.primary_depth.any()
    state = worn(archard, 20.0)
    areas = archard.primary.patch.node_areas()
    assert state.wear.energy_mJ == 0.0
    assert float(areas @ state.wear.primary_depth.ravel()) == pytest.approx(state.wear.primary_volume_mm3, rel=1e-12)
    travelled = archard.holder.normal_load_N * 4.0 * STROKE_mm * 20.0
    assert state.wear.primary_volume_mm3 == pytest.approx(RATES_OF_LAWS[0] * travelled, rel=5e-3)


def test_surfaces_that_recede_after_each_increment_and_a_cycle_jump_agree_where_the_former_is_stable() -> None:
    problem = wires()
    start = at_the_end(problem)
    explicit = start
    for _ in range(3):
        explicit, _ = run_cycle(problem, explicit, Drive(STROKE_mm), 2 * INCREMENTS, 10.0)
    jump = jumped(problem, start, 30.0).state
    assert depth_error(explicit, jump) < 0.03
    assert explicit.wear.energy_mJ == pytest.approx(jump.wear.energy_mJ, rel=0.01)


def test_a_varying_coefficient_is_joined_by_straight_lines_and_constant_beyond() -> None:
    text = WORN + 'archard_wear_coefficient_mm3_per_N_m = 2e-5\nvariation = "cycles"\n'
    wear = parse_study(text + "variation_points = [[0, 2.0], [100, 1.0], [300, 0.5]]", "s.toml").wear
    assert wear is not None
    assert [wear.factor(cycles, 0.0) for cycles in (0, 50, 100, 200, 1e4)] == pytest.approx([2.0, 1.5, 1.0, 0.75, 0.5])


STARVED = {"name": "contact_oxygenation", "supply_W": 0.01, "starved_factor": 0.2}


def run_of_oxygenation(*effects: dict[str, Any], frequency_Hz: float = 20.0) -> RunResult:
    asked = {"frequency_Hz": frequency_Hz, "cycles": 5000}
    study = line_study(effects=list(effects), conditions=asked, log={"loop_cycles": [1, 5000]})
    return simulate(study, fidelity="quick")


def test_oxygen_gets_as_far_as_the_root_of_its_supply_over_the_power_density() -> None:
    supply = OxygenSupply(0.3, 0.2)
    assert supply.reach_mm(0.3) == pytest.approx(1.0)
    assert supply.reach_mm(1.2) == pytest.approx(0.5)
    assert supply.factors(np.array([0.0, 0.6, 0.85, 1.0, 3.0]), 0.3) == pytest.approx([1.0, 1.0, 0.6, 0.2, 0.2])
    for bad in ((0.0, 0.2), (1.0, -0.1)):
        with pytest.raises(SolverError, match="oxygen needs"):
            OxygenSupply(*bad)


@pytest.fixture(scope="module")
def nominal() -> RunResult:
    return run_of_oxygenation()


@pytest.mark.slow
def test_plenty_of_oxygen_changes_nothing_and_its_lack_takes_wear_by_the_factor(nominal: RunResult) -> None:
    plenty = run_of_oxygenation(STARVED | {"supply_W": 1e5})
    none = run_of_oxygenation(STARVED | {"supply_W": 1e-8})
    area = {r: r.worn_volume_mm3[-1] for r in (nominal, plenty, none)}
    energy = {r: r.evolution["accumulated_energy_J"][-1] for r in (nominal, plenty, none)}
    assert area[plenty] == pytest.approx(area[nominal], rel=1e-9)
    # Nodes that a jump brings into contact breathe.
    assert area[none] / energy[none] == pytest.approx(0.2 * area[nominal] / energy[nominal], rel=0.1)


@pytest.mark.slow
def test_a_faster_test_wears_less_per_energy_and_books_close(nominal: RunResult) -> None:
    rates = []
    for frequency in (2.0, 200.0):
        result = run_of_oxygenation(STARVED, frequency_Hz=frequency)
        assert result.quality["volume_against_energy"] < 1e-9
        assert result.quality["mirror_error"] < 1e-6
        rates.append(result.evolution["worn_volume_pad_mm3"][-1] / result.evolution["accumulated_energy_J"][-1])
    whole = nominal.evolution["worn_volume_pad_mm3"][-1] / nominal.evolution["accumulated_energy_J"][-1]
    assert rates[1] < rates[0] <= whole * (1.0 + 1e-9)
