"""How sound a run is: what closes exactly, what must be mirrored, and what a faulty cycle shows."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from geometry import ContactPatch, Flat
from geometry.arrays import Array
from solvers import (
    ContactProblem,
    ContactState,
    CycleTrace,
    Drive,
    closed_cycle,
    first_quarter,
    mirror_error,
    press,
    symmetry_of,
    unloaded_state,
)
from tests.bodies import AMPLITUDE_mm, RIG_N_per_mm, crossed_wires, pressed
from tests.studies import coarse
from tests.synthetic_results import result
from wirewear import ExperimentRecord, read_record
from wirewear.diagnosis.observe.observed_record import of_own_definitions
from wirewear.records import check_record
from wirewear.simulation import recorded, simulate
from wirewear.simulation.measures import unresolved_slip
from wirewear.simulation.point_runs import PointRun
from wirewear.simulation.statistics import Counters, bends, energy_mismatch, judge
from wirewear.simulation.traced_bodies import (
    at_mid_stroke,
    depth_spread,
    forces_on,
    mean_pressures,
    nodal_pressures,
    pressure_figures,
    worn_bodies,
)
from wirewear.test import study_from_tables
from wirewear.views.run_page import run_page
from wirewear.views.run_words import runs_json, sentence

EXAMPLE = Path(__file__).parents[2] / "studies/steel_wires/example_records/no_gap"
MESH_mm = 0.010
INCREMENTS = 24


@pytest.fixture(scope="module")
def record() -> ExperimentRecord:
    return read_record(EXAMPLE)


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
    parts = (replace(one, columns={**one.columns, name: change(dict(one.columns))}) for one in record.evolution)
    odd = replace(record, evolution=tuple(parts))
    read, notes = of_own_definitions(odd)
    assert [note.split()[2] for note in notes] == [name]
    for part, before in zip(read.evolution, odd.evolution, strict=True):
        assert np.isnan(part.columns[name]).all()
        for other in set(part.columns) - {name}:
            np.testing.assert_array_equal(part.columns[other], before.columns[other])
    assert any(name in remark.text and "defined otherwise" in remark.text for remark in check_record(odd).remarks)


@pytest.fixture(scope="module")
def problem() -> ContactProblem:
    return crossed_wires(MESH_mm, long_patch=True, rig_N_per_mm=RIG_N_per_mm)


@pytest.fixture(scope="module")
def cycle(problem: ContactProblem) -> CycleTrace:
    start = first_quarter(problem, pressed(problem)[0], Drive(AMPLITUDE_mm), INCREMENTS)
    return closed_cycle(problem, start, Drive(AMPLITUDE_mm), INCREMENTS)[1]


def test_recorded_forces_stretch_the_rig_as_far_as_its_holder_is(problem: ContactProblem, cycle: CycleTrace) -> None:
    for forces in forces_on(problem, cycle, 1, 8, ("moving", "fixed")):
        assert RIG_N_per_mm * forces.holder_x_um == pytest.approx(1e3 * forces.tangential_force_N, abs=1e-4)
        approach_um = 1e3 * pressed(problem)[0].holder_z
        assert forces.holder_z_um == pytest.approx(np.full(len(forces.phase), approach_um), rel=0.05)


def test_mirror_error_is_the_share_of_load_that_stands_elsewhere(problem: ContactProblem, cycle: CycleTrace) -> None:
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


def test_pressure_at_mid_stroke_is_the_median_over_the_way_not_over_increments() -> None:
    # Five increments crowd where the pressure is 9; most of the way it is 1, and beyond 35 of 60 µm it is 100.
    drives = np.array([60.0, 36.0, 34.0, 10.0, 9.0, 8.0, 7.0, 6.0, 5.0, -34.0, -36.0, -60.0])
    pressures = [100.0, 100.0, 1.0, 1.0, 9.0, 9.0, 9.0, 9.0, 1.0, 1.0, 100.0, 100.0]
    there_and_back = np.append(drives, drives[::-1]), np.append(pressures, pressures[::-1])
    assert at_mid_stroke(*there_and_back) == 1.0


@pytest.mark.parametrize("increments", [16, 32, 48])
def test_pressure_at_mid_stroke_is_the_loops_own_and_not_that_of_its_increments(increments: int) -> None:
    # A pressure that grows evenly from mid-stroke on has its median where half of the way to either side is passed.
    drive = np.cos(2.0 * np.pi * np.arange(increments) / increments)
    assert at_mid_stroke(drive, np.abs(drive)) == pytest.approx(0.5 * 35.0 / 60.0, rel=0.01)


def test_a_traction_along_the_normal_of_a_slope_is_all_pressure(problem: ContactProblem, cycle: CycleTrace) -> None:
    state = cycle.states[0]
    slope = problem.surface.mean_slope(np.arange(problem.primary.patch.size), state.wear.primary_depth)
    pressed = replace(state, traction=70.0 * np.column_stack([-slope, np.ones(len(slope))]))
    assert np.abs(slope).max() > 0.1
    assert nodal_pressures(problem, [pressed]) == pytest.approx(np.full((1, len(slope)), 70.0))


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


@pytest.mark.parametrize(("worn_mJ", "mismatch"), [(1e-15, 0.0), (1e-8, 1.0)])
def test_round_off_of_nodes_that_stick_is_no_energy_lost(cycle: CycleTrace, worn_mJ: float, mismatch: float) -> None:
    loop = {"cycle": 1.0, "displacement_amplitude_um": 0.4, "max_tangential_force_N": 0.05}
    loop |= {"dissipated_energy_mJ": 0.0, "accumulated_energy_J": 1e-3 * worn_mJ, "mirror_error": 0.0}
    judge(counters := Counters(), cycle, [loop])
    assert counters.energy_against_loops == mismatch


@given(st.floats(-0.9, 2.0), st.floats(1.5, 10.0), st.floats(0.0, 5.0))
def test_energy_bends_when_less_or_more_has_worn_than_a_power_predicts(
    power: float, ratio: float, before: float
) -> None:
    worn = (ratio ** (power + 1.0) - 1.0) / (power + 1.0)
    now = (ratio, ratio**power, before + worn)
    assert not bends((1.0, 1.0, before), now)
    assert bends((1.0, 1.0, before), (ratio, 1.1 * now[1] + 0.1 * (before / worn + 1.0) * now[1], now[2]))


def test_no_loop_is_added_because_one_cycle_differs_where_friction_differs_from_node_to_node(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(recorded, "worn_depths", lambda *_: (np.zeros(1), np.zeros(1)))
    worn = cast("ContactState", SimpleNamespace(wear=SimpleNamespace(energy_mJ=100.0), core=np.zeros(1, dtype=bool)))
    problem = cast("ContactProblem", SimpleNamespace(unchanging=False))
    row = {"cycle": 1.0, "dissipated_energy_mJ": 1.0, "accumulated_energy_J": 1e-3}
    row |= {"max_depth_moving_um": 0.0, "max_depth_fixed_um": 0.0}
    layer = {"thickness_um": 1.0, "wear_factor": 1.0}
    for further, follows in (({}, False), ({"friction": 0.1}, True)):
        study = coarse().with_values({"wires.fixed.layers": [layer | further]})
        record = PointRun.of(study, "quick").recorder()
        record._rows = [row]
        assert record.follows(problem, worn, 100.0, 1.5) is follows


@pytest.mark.seconds
@pytest.mark.parametrize(
    ("load_N_per_mm", "life", "borne_MPa"),
    [
        (1000.0, {}, 10_000.0),
        (2000.0, {}, 10_000.0),
        (20.0, {"yield_strength_MPa": 400.0}, 1120.0),
        (20.0, {"tensile_strength_MPa": 600.0}, 1680.0),
    ],
)
def test_a_pressure_that_no_such_body_bears_is_said_by_run_and_page(
    load_N_per_mm: float, life: dict[str, float], borne_MPa: float
) -> None:
    steel = {"youngs_modulus_MPa": 2e5, "poissons_ratio": 0.3}
    study = study_from_tables(
        {
            "format": 1, "name": "hard pressed", "kind": "cylinder-on-flat", "pad": {"radius_mm": 0.5, **steel},
            "specimen": steel | {"youngs_modulus_MPa": 4e5}, "contact": {"friction": 0.5}, "life": life,
            "conditions": {"normal_load_N_per_mm": load_N_per_mm, "displacement_amplitude_um": 5.0, "cycles": 1},
        },
        "s.toml",
    )  # fmt: skip
    run = simulate(study, fidelity="quick")
    # A line contact of two half-planes: p0² = P E*/(π R).
    largest = np.sqrt(load_N_per_mm / (np.pi * 0.5) / (0.91 / 2e5 + 0.91 / 4e5))
    assert run.quality["pressure_against_strength"] == pytest.approx(largest / borne_MPa, rel=0.03)
    said = f"{1e-3 * borne_MPa:.3g} GPa that they bear"
    impossible = largest > borne_MPa
    assert (said in sentence(run)) == (said in run_page([run])) == impossible
    (summary,) = json.loads(runs_json([run]))
    assert (said in summary["sentence"]) == (not summary["quality"]["pressure_against_strength"]["sound"]) == impossible


def test_both_bodies_maps_show_one_pressure(problem: ContactProblem) -> None:
    """What a body is handed on must not fall short of the pressure by how it is meshed."""
    state = pressed(problem)[0]
    other = replace(problem, primary_is_upper=not problem.primary_is_upper)
    swapped, _ = press(other, unloaded_state(other))
    for one, at in ((problem, state), (other, swapped)):
        nothing = np.zeros((2, *one.primary.patch.shape)), np.zeros((2, *one.secondary.patch.shape))
        trace = SimpleNamespace(middle=at, slid=(nothing[0][0], nothing[1][0]))
        largest = [
            float((force[:, 2] / body.node_areas).max())
            for body, _, _, force, *_ in worn_bodies(one, cast("CycleTrace", trace))
        ]
        assert largest[0] == pytest.approx(largest[1], rel=0.01)


@pytest.mark.parametrize("elements", [3.0, 8.0])
@pytest.mark.parametrize("worn_body", ["primary", "secondary"])
def test_the_error_of_depth_that_either_body_wears_to_is_estimated_as_of_a_paraboloid(
    problem: ContactProblem, elements: float, worn_body: str
) -> None:
    lines = 1e-3 * np.arange(-30.0, 31.0)
    patch = ContactPatch(lines, lines, np.arange(61 * 61).reshape(61, 61), Flat())
    body, state = replace(getattr(problem, worn_body), patch=patch), pressed(problem)[0]
    radius = 1e-3 * elements
    x, y = np.meshgrid(lines, lines, indexing="ij")
    depth, wear = np.maximum(1.0 - (x**2 + y**2) / radius**2, 0.0), state.wear
    worn = replace(wear, primary_depth=depth) if worn_body == "primary" else replace(wear, secondary_depth=depth)
    is_upper = problem.primary_is_upper == (worn_body == "primary")
    shown = replace(problem, upper=body) if is_upper else replace(problem, lower=body)
    # The mean over a hat of a parabola 1 - (x/b)² is less at its middle by h²/(3 b²), here in both directions.
    assert depth_spread(shown, replace(state, wear=worn)) == pytest.approx(2.0 / (3.0 * elements**2), rel=0.01)
    assert np.isnan(depth_spread(problem, state))


@pytest.mark.parametrize("elements", [8, 16])
def test_the_error_of_a_loops_energy_falls_with_the_square_of_the_rings_that_slip(elements: int) -> None:
    lines = np.arange(-elements - 2.0, elements + 3.0) / elements
    patch = ContactPatch(lines, lines, np.arange(lines.size**2).reshape(lines.size, -1), Flat())
    radius = np.hypot(*patch.grid().T)
    pressure = np.zeros((patch.size, 3))
    pressure[:, 2] = radius <= 1.0

    def error(core: float, force: float = 1.0, after: float = 0.0) -> float:
        """after: slip of all in a second increment, over that of the annulus in the first."""
        slid = np.where((radius > core) & (radius <= 1.0), 1e-6, 0.0)
        start, *states = (
            SimpleNamespace(traction=pressure, primary_slid=own) for own in (0.0 * slid, slid, slid + after)
        )
        trace = SimpleNamespace(
            start=start, states=states, slid=(slid + after, slid), tangential_force=np.array([-force, force]),
            normal_force=np.ones(2), slips=np.array([1.0, after]),
        )  # fmt: skip
        return unresolved_slip(patch, cast("CycleTrace", trace))

    assert error(1.0) == 1.0  # a finite force and nothing that slips
    assert np.isnan(error(-1.0))  # nothing that sticks
    assert np.isnan(error(0.5, after=1.5))  # most energy is that of sliding as a whole
    assert 0.0 < error(0.5, after=0.5) < error(0.5)  # all nodes slip, but mostly one after another
    assert np.isnan(error(1.0, force=0.0))
    # The area of such an annulus is 0.42 times as many edges of one node as elements lead to the rim.
    assert error(0.5) == pytest.approx(0.13 / (0.42 * elements) ** 2, rel=0.15)
    assert error(0.8) > 3.0 * error(0.5)


def test_a_loop_of_which_too_few_nodes_slip_says_so_in_run_page_and_json(problem: ContactProblem) -> None:
    state = pressed(problem)[0]
    drive = Drive(1e-5)
    trace = closed_cycle(problem, first_quarter(problem, state, drive, 8), drive, 8)[1]
    assert np.ptp(trace.tangential_force) > 0.0
    error = unresolved_slip(problem.primary.patch, trace)
    assert error > 0.9
    (summary,) = json.loads(runs_json([replace(run := result(), quality={"slip_between_nodes": error})]))
    assert not summary["quality"]["slip_between_nodes"]["sound"]
    assert "number of nodes that slip" in run_page([replace(run, quality={"slip_between_nodes": error})])
