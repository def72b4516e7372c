"""Slip, energy and wear of loops against a slider on a spring: loads that change, rigs that yield, free play."""

from functools import cache
from typing import Any

import numpy as np
import pytest

from geometry import Elastic
from solvers.contact_state import Guide, Stroke
from solvers.drive import Drive, LoadCycle, trapezoidal
from solvers.errors import SolverError
from solvers.wear_path import loop_path, traced_path, wear_path
from tests.simulation.slider import SliderLoop, SlidingBall, slider_loop
from tests.studies import line_study, steel_wires
from wirewear import RunResult, parse_study
from wirewear.effects.holder import FreePlay
from wirewear.reference import contact_modulus, energy_per_cycle, partial_slip_point, tangential_contact_modulus
from wirewear.results.health import remedies
from wirewear.simulation import simulate
from wirewear.test import Study, study_from_tables
from wirewear.test.gaps import hertz_of

STEEL = Elastic(210_000.0, 0.3)
LOAD_N, FRICTION, AMPLITUDE_um, COEFFICIENT = 5.0, 0.5, 42.0, 1e-9
#: Each with the stiffness of its rig and the test's length.
LOADS: dict[str, tuple[dict[str, Any], float | str, int]] = {
    "behind the drive": ({"amplitude_share": 0.6, "lag_deg": 270.0}, 100.0, 3),
    "twice a cycle": ({"amplitude_share": 0.6, "lag_deg": 60.0, "frequency_ratio": 2}, 100.0, 300),
    "of a table": ({"points": [[0.0, 0.4], [0.3, 1.6], [0.4, 0.3], [0.8, 1.2], [1.0, 0.4]]}, 400.0, 20),
    "that opens": ({"amplitude_share": 1.3, "lag_deg": 200.0}, 250.0, 1),
    "four times a cycle": ({"amplitude_share": 0.84, "lag_deg": 176.0, "frequency_ratio": 4}, 180.0, 1),
    "on a rigid rig": ({"amplitude_share": 0.6, "lag_deg": 120.0}, "rigid", 1),
}
#: For sliding as a whole and for held forces, which are no matter of the mesh.
COARSE = {"fidelity.quick.contact_mesh_um": 30.0}
EACH_LOAD = [one if one == "on a rigid rig" else pytest.param(one, marks=pytest.mark.slow) for one in LOADS]


def study(load: dict[str, Any] | None, stiffness: float | str, cycles: int, **conditions: Any) -> Study:
    """A ball on a flat that wears so little that its shape stays."""
    changing = {} if load is None else {"load_cycle": load}
    tables = {
        "format": 1,
        "name": "on a rig",
        "kind": "ball-on-flat",
        "bodies": {"ball": {"diameter_mm": 6.35, "material": "steel"}, "flat": {"material": "steel"}},
        "conditions": {"normal_load_N": LOAD_N, "displacement_amplitude_um": AMPLITUDE_um, "frequency_Hz": 10.0}
        | {"cycles": cycles, **changing, **conditions},
        "contact": {"friction": FRICTION},
        "wear": {"energy_wear_coefficient_mm3_per_J": COEFFICIENT},
        "holder": {"tangential_stiffness_N_per_mm": stiffness},
        "log": {"loop_cycles": [1, cycles], "contact_states": 0},
    }
    made: Study = study_from_tables(tables, "on a rig")
    return made


@cache
def run(load: str) -> RunResult:
    return simulate(study(*LOADS[load]).with_values(COARSE), fidelity="quick")


@cache
def slider(load: str) -> SliderLoop:
    """The loop of the ball on its rig by a sum of springs with friction."""
    cycle, stiffness, _ = LOADS[load]
    time = np.arange(1, 1001) / 1000.0
    if "points" in cycle:
        shares = np.interp(time, *np.array(cycle["points"]).T)
    else:
        lag, ratio = np.radians(cycle["lag_deg"]), cycle.get("frequency_ratio", 1)
        shares = np.maximum(1.0 + cycle["amplitude_share"] * np.cos(2.0 * np.pi * ratio * time - lag), 0.0)
    moduli = contact_modulus(STEEL, STEEL), tangential_contact_modulus(STEEL, STEEL)
    ball = SlidingBall(3.175, *moduli, FRICTION, float("inf" if stiffness == "rigid" else stiffness))
    return slider_loop(1e-3 * AMPLITUDE_um, LOAD_N * shares, ball)


@pytest.mark.seconds
@pytest.mark.parametrize("load", EACH_LOAD)
def test_the_energy_that_wears_is_that_of_the_loops_whatever_the_load_and_the_rig(load: str) -> None:
    evolution = run(load).evolution
    cycles, energy_mJ = LOADS[load][2], 1e3 * evolution["accumulated_energy_J"][-1]
    assert energy_mJ == pytest.approx(cycles * evolution["dissipated_energy_mJ"][-1], rel=3e-3)
    assert energy_mJ == pytest.approx(cycles * slider(load).energy_mJ, rel=5e-3)
    assert run(load).worn_volume_mm3[-1] == pytest.approx(1e-3 * COEFFICIENT * energy_mJ, rel=1e-9)


@pytest.mark.seconds
@pytest.mark.parametrize("load", EACH_LOAD)
def test_the_slip_amplitude_is_half_the_way_of_the_contact_whatever_the_load_and_the_rig(load: str) -> None:
    assert run(load).quality.get("slip_against_loops", 0.0) < 5e-3
    found = run(load).evolution["slip_amplitude_um"][-1]
    assert found == pytest.approx(1e3 * slider(load).slip_amplitude_mm, rel=0.02)


@pytest.mark.slow
def test_a_place_where_bodies_only_begin_to_slide_wears_by_what_its_loops_do() -> None:
    """From the place before it on they have stuck: friction there is not against what moved in between."""
    points = [[0.0, 0.67], [0.13, 1.05], [0.248, 0.473], [0.346, 0.875], [0.612, 1.265], [1.0, 0.67]]
    sliding = {"normal_load_N": 9.55, "displacement_amplitude_um": 94.06}
    own = study({"points": points}, 52.5, 10, **sliding).with_values({"contact.friction": 0.438})
    evolution = simulate(own, fidelity="quick").evolution
    energy_mJ = 1e3 * evolution["accumulated_energy_J"][-1]
    assert energy_mJ == pytest.approx(10.0 * evolution["dissipated_energy_mJ"][-1], rel=3e-3)


@pytest.mark.slow
def test_a_held_force_that_a_load_lets_slide_for_a_moment_has_the_energy_of_its_annulus() -> None:
    cycle, stiffness, friction, load_N = {"amplitude_share": 0.56, "lag_deg": 126.1}, 796.2, 0.353, 2.2
    conditions = {"normal_load_N": load_N, "displacement_amplitude_um": 15.0, "held_tangential_force_N": 0.9692}
    held = study(cycle, stiffness, 1, **conditions).with_values({"contact.friction": friction})
    evolution = simulate(held, fidelity="quick").evolution
    moduli, time = (
        (contact_modulus(STEEL, STEEL), tangential_contact_modulus(STEEL, STEEL)),
        np.arange(1, 1001) / 1000.0,
    )
    shares = 1.0 + cycle["amplitude_share"] * np.cos(2.0 * np.pi * time - np.radians(cycle["lag_deg"]))
    ball = SlidingBall(3.175, *moduli, friction, stiffness)
    loop = slider_loop(1e-3 * float(evolution["displacement_amplitude_um"][-1]), load_N * shares, ball)
    assert 1e3 * evolution["accumulated_energy_J"][-1] == pytest.approx(loop.energy_mJ, rel=0.02)


@pytest.mark.slow
def test_a_contact_that_sticks_under_a_changing_load_has_the_energy_of_its_annulus() -> None:
    """What comes into contact during a step has the shear of what is left of the step: few steps lack no energy."""
    cycle, stiffness = {"amplitude_share": 0.6, "lag_deg": 20.0}, 300.0
    conditions = {"displacement_amplitude_um": 40.0, "held_tangential_force_N": 0.38 * FRICTION * LOAD_N}
    evolution = simulate(study(cycle, stiffness, 1, **conditions), fidelity="quick").evolution
    moduli, time = (
        (contact_modulus(STEEL, STEEL), tangential_contact_modulus(STEEL, STEEL)),
        np.arange(1, 2001) / 2000.0,
    )
    load_N = LOAD_N * (1.0 + cycle["amplitude_share"] * np.cos(2.0 * np.pi * time - np.radians(cycle["lag_deg"])))
    ball = SlidingBall(3.175, *moduli, FRICTION, stiffness)
    loop = slider_loop(1e-3 * float(evolution["displacement_amplitude_um"][-1]), load_N, ball, LOAD_N)
    assert evolution["dissipated_energy_mJ"][-1] == pytest.approx(loop.energy_mJ, rel=0.005)


@pytest.mark.slow
def test_bodies_that_slide_only_while_they_part_hold_their_slip() -> None:
    held = study({"amplitude_share": 1.3, "lag_deg": 200.0}, 50.0, 1, held_slip_amplitude_um=4.0)
    evolution = simulate(held, fidelity="quick").evolution
    assert evolution["slip_amplitude_um"][-1] == pytest.approx(4.0, rel=2e-3)
    assert evolution["accumulated_energy_J"][-1] > 0.0


@pytest.mark.slow
def test_a_held_slip_is_that_of_the_cycles_that_wear_on_a_soft_rig() -> None:
    """A friction force that is nearly closed leaves the holder of a soft rig far from its place."""
    conditions = {"displacement_amplitude_um": 160.0, "held_slip_amplitude_um": 12.6}
    held = study({"amplitude_share": 0.35, "lag_deg": 15.0}, 33.0, 1, **conditions)
    evolution = simulate(held, fidelity="quick").evolution
    energy_mJ = 1e3 * evolution["accumulated_energy_J"][-1]
    assert energy_mJ == pytest.approx(evolution["dissipated_energy_mJ"][-1], rel=3e-3)


@pytest.mark.seconds
def test_free_play_takes_half_of_its_width_from_the_slip_at_every_loop() -> None:
    """The loop's width at its mean force lies anywhere on the shelf of the play."""
    found = []
    for gap_um in (0.0, 3.0):
        own = study(None, 400.0, 2).with_effects(FreePlay(gap_um=gap_um))
        found.append(simulate(own.with_values(COARSE), fidelity="quick").evolution["slip_amplitude_um"])
    np.testing.assert_allclose(found[0] - found[1], 1.5, rtol=0.01)


@pytest.mark.parametrize("stiffness", [50.0, "rigid"])
@pytest.mark.parametrize("share", [0.6, *(pytest.param(share, marks=pytest.mark.slow) for share in (0.02, 0.99))])
def test_a_force_that_friction_bears_is_held_on_any_rig(stiffness: float | str, share: float) -> None:
    force_N = share * FRICTION * LOAD_N
    held = study(None, stiffness, 1, displacement_amplitude_um=120.0, held_tangential_force_N=force_N)
    evolution = simulate(held.with_values(COARSE), fidelity="quick").evolution
    assert evolution["max_tangential_force_N"] == pytest.approx(force_N, rel=1e-3)


LARGE_AT_ONE_END = {"amplitude_share": 0.63, "lag_deg": 177.4}


@pytest.mark.slow
@pytest.mark.parametrize("share", [1.16, 1.4])
def test_a_force_is_held_that_only_the_load_at_one_end_of_the_stroke_bears(share: float) -> None:
    """Less than a load of 0.63 more bears at that end, more than the test's load bears."""
    conditions = {"displacement_amplitude_um": 40.0, "held_tangential_force_N": share * FRICTION * LOAD_N}
    held = study(LARGE_AT_ONE_END, 561.6, 10, **conditions).with_values(COARSE)
    evolution = simulate(held, fidelity="quick").evolution
    np.testing.assert_allclose(evolution["max_tangential_force_N"], share * FRICTION * LOAD_N, rtol=1e-3)


@pytest.mark.slow
def test_a_force_that_no_load_of_the_cycle_bears_is_refused_in_a_sentence() -> None:
    conditions = {"displacement_amplitude_um": 40.0, "held_tangential_force_N": 1.7 * FRICTION * LOAD_N}
    with pytest.raises(SolverError, match=r"cannot hold held_tangential_force_N = 4\.25.* 4\.07\d* N"):
        simulate(study(LARGE_AT_ONE_END, 561.6, 1, **conditions).with_values(COARSE), fidelity="quick")


@pytest.mark.parametrize("offset", [0.1, 0.5, 0.9])
def test_a_place_lies_where_bodies_that_stuck_begin_to_slide_by_a_load_that_falls(offset: float) -> None:
    phase = np.arange(1, 65) / 64.0
    drive, begins = np.cos(2.0 * np.pi * phase), (40.0 + offset) / 64.0
    holder = drive - 0.5 * np.clip(phase - begins, 0.0, 10.0 / 64.0)
    guide = Guide(phase, drive, holder, np.zeros(64), np.zeros((64, 1, 3)))
    changing = Drive(1.0, load=LoadCycle(0.5))
    for path in (traced_path(changing, 1.0, 0.0, 32, guide, half=False), loop_path(changing, 1.0, 32, guide)):
        assert np.abs(path.phase - begins).min() < 1e-3
    np.testing.assert_array_equal(
        loop_path(Drive(1.0), 1.0, 32, guide).drive, loop_path(Drive(1.0), 1.0, 32, None).drive
    )


def test_places_of_a_cycle_whose_drive_rests_are_numbers() -> None:
    phase = np.sort(np.append(np.arange(1, 65) / 64.0, [0.5, 0.5, 1.0]))
    drive = np.cos(2.0 * np.pi * phase)
    guide = Guide(phase, drive, 0.3 * drive, np.zeros(67), np.zeros((67, 1, 3)))
    resting = LoadCycle(points=((0.0, 1.0), (0.01, 0.0), (0.99, 0.0), (1.0, 1.0)))
    for drive_of in (Drive(1.0, load=LoadCycle(0.5)), Drive(1.0, trapezoidal(0.1), resting)):
        assert np.isfinite(traced_path(drive_of, 1.0, 0.0, 32, guide, half=False).drive).all()


def test_places_of_a_shorter_stroke_lie_within_it() -> None:
    places = wear_path(1.0, 0.1, 12, Stroke(np.linspace(4.5, -5.0, 20), np.append(0.1, np.full(19, -0.1))))
    assert places[-1] == -1.0
    assert np.all(np.diff(places) < 0.0)
    assert np.abs(places).max() <= 1.0


def test_a_run_says_what_its_energy_lacks_and_what_the_program_errs() -> None:
    said = remedies({"energy_against_loops", "volume_against_energy", "penetration", "pressure_against_strength"})
    assert ["jump_tolerance" in one for one in said] == [True, False, False]
    assert ["report it" in one for one in said] == [False, True, False]
    assert ["finer --fidelity" in one for one in said] == [False, False, True]
    (increments,) = remedies({"energy_against_loops", "first_cycle_against_loop"})
    assert "increments_per_wear_cycle" in increments
    assert "jump_tolerance" not in increments


def test_a_test_without_wear_has_the_energy_of_all_its_loops() -> None:
    blocks = [{"cycles": 30}, {"cycles": 10, "conditions": {"displacement_amplitude_um": 9.0}}]
    study = line_study(wear=None, conditions={"cycles": 100}, log={"loop_cycles": [1, 100]}, programme=blocks)
    evolution = simulate(study, fidelity="quick").evolution
    energies = dict(zip(evolution["cycle"], evolution["dissipated_energy_mJ"], strict=True))
    accumulated_mJ = 1e3 * evolution["accumulated_energy_J"]
    assert accumulated_mJ[0] == pytest.approx(energies[1], rel=1e-3)
    assert accumulated_mJ[-1] == pytest.approx(80 * energies[1] + 20 * energies[40], rel=1e-3)


@pytest.mark.slow
def test_a_block_that_sticks_has_the_energy_of_partial_slip_before_and_after_one_that_slides() -> None:
    """Of Cattaneo and Mindlin; the drive of one block holds a force, that of the other its amplitude."""
    alone = parse_study(steel_wires("blocks", amplitude_um=20.0, cycles=15), "blocks.toml")
    load_N, friction = alone.conditions.normal_load_N, alone.contact.friction
    force_N = 0.6 * friction * load_N
    sticks = f"[[programme]]\ncycles = 5\nconditions.held_tangential_force_N = {force_N}\n"
    slides = "[[programme]]\ncycles = 5\nconditions.displacement_amplitude_um = 5.0\n"
    text = steel_wires("blocks", amplitude_um=20.0, cycles=15) + "[log]\nloop_cycles = [1, 5, 10, 15]\n"
    study = parse_study(text + sticks + slides, "blocks.toml")
    result = simulate(study, fidelity="quick")
    assert len(result.settings["mesh_changes"]) == 2
    (driven, held), energy = study.bodies, [float(loop.friction_work_mJ[-1]) for loop in result.loops]
    radius = hertz_of(load_N, driven, held).contact_radius_mm
    modulus = tangential_contact_modulus(driven.material, held.material)
    exact = energy_per_cycle(partial_slip_point(load_N, friction, radius, modulus), force_N)
    assert [energy[k] for k in (0, 1, 3)] == pytest.approx([exact] * 3, rel=0.05)
    assert energy[2] > 20.0 * exact
