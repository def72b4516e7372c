"""Slip, energy and wear of loops against a slider on a spring: loads that change, rigs that yield, free play."""

from functools import cache
from typing import Any

import numpy as np
import pytest

from geometry.arrays import Array
from solvers.contact_state import Guide, Stroke
from solvers.drive import Drive, LoadCycle
from solvers.wear_path import loop_path, traced_path, wear_path
from wirewear import RunResult
from wirewear.effects.holder import FreePlay
from wirewear.reference import SliderLoop, slider_loop
from wirewear.results.scar import remedies
from wirewear.simulation import simulate
from wirewear.test import Study, study_from_tables

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
QUICK = ("of a table", "on a rigid rig")
EACH_LOAD = [load if load in QUICK else pytest.param(load, marks=pytest.mark.slow) for load in LOADS]


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
    return simulate(study(*LOADS[load]), fidelity="quick")


@cache
def contact_um() -> tuple[float, float]:
    """By how much the contact's own compliance makes slip, and energy over that of so much slip, less: by a loop under
    a load that stays, on a rigid rig.
    """
    result = simulate(study(None, "rigid", 1), fidelity="quick")
    energy_um = 250.0 * result.evolution["dissipated_energy_mJ"][0] / (FRICTION * LOAD_N)
    return AMPLITUDE_um - result.evolution["slip_amplitude_um"][0], AMPLITUDE_um - energy_um


def slider(load: str, amplitude_um: float = AMPLITUDE_um, contact: float = 0.0) -> SliderLoop:
    """The slider's loop, with the contact's compliance under the mean load in mm/N put to the spring's."""
    cycle, stiffness, _ = LOADS[load]
    if "points" in cycle:
        times, shares = np.array(cycle["points"]).T
    else:
        times = np.linspace(0.0, 1.0, 2001)
        lag, ratio = np.radians(cycle["lag_deg"]), cycle.get("frequency_ratio", 1)
        shares = np.maximum(1.0 + cycle["amplitude_share"] * np.cos(2.0 * np.pi * ratio * times - lag), 0.0)
    rig = 0.0 if isinstance(stiffness, str) else 1.0 / stiffness

    def share(time: Array) -> Array:
        return np.asarray(np.interp(time, times, shares))

    def compliance(time: Array) -> Array:
        return np.asarray(rig + contact * np.maximum(share(time), 1e-3) ** (-1.0 / 3.0))

    return slider_loop(1e-3 * amplitude_um, lambda time: FRICTION * LOAD_N * share(time), compliance)


@pytest.mark.seconds
@pytest.mark.parametrize("load", EACH_LOAD)
def test_the_energy_that_wears_is_that_of_the_loops_whatever_the_load_and_the_rig(load: str) -> None:
    evolution = run(load).evolution
    cycles, energy_mJ = LOADS[load][2], 1e3 * evolution["accumulated_energy_J"][-1]
    assert energy_mJ == pytest.approx(cycles * evolution["dissipated_energy_mJ"][-1], rel=3e-3)
    expected = slider(load, contact=1e-3 * contact_um()[1] / (FRICTION * LOAD_N)).energy_mJ
    assert energy_mJ == pytest.approx(cycles * expected, rel=5e-3)
    assert run(load).worn_volume_mm3[-1] == pytest.approx(1e-3 * COEFFICIENT * energy_mJ, rel=1e-9)


@pytest.mark.seconds
@pytest.mark.parametrize("load", EACH_LOAD)
def test_the_slip_amplitude_is_half_the_way_of_the_contact_whatever_the_load_and_the_rig(load: str) -> None:
    assert run(load).quality.get("slip_against_loops", 0.0) < 5e-3
    found = run(load).evolution["slip_amplitude_um"][-1]
    assert found == pytest.approx(1e3 * slider(load).slip_amplitude_mm - contact_um()[0], rel=0.01)


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
        own = study(None, 400.0, 20).with_effects(FreePlay(gap_um=gap_um))
        found.append(simulate(own, fidelity="quick").evolution["slip_amplitude_um"])
    np.testing.assert_allclose(found[0] - found[1], 1.5, rtol=0.01)


@pytest.mark.parametrize("stiffness", [50.0, "rigid"])
@pytest.mark.parametrize("share", [0.6, *(pytest.param(share, marks=pytest.mark.slow) for share in (0.02, 0.99))])
def test_a_force_that_friction_bears_is_held_on_any_rig(stiffness: float | str, share: float) -> None:
    force_N = share * FRICTION * LOAD_N
    held = study(None, stiffness, 1, displacement_amplitude_um=120.0, held_tangential_force_N=force_N)
    evolution = simulate(held, fidelity="quick").evolution
    assert evolution["max_tangential_force_N"] == pytest.approx(force_N, rel=1e-3)


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
    path = traced_path(Drive(1.0, load=LoadCycle(0.5)), 1.0, 0.0, 32, guide, half=False)
    assert np.isfinite(path.drive).all()


def test_places_of_a_shorter_stroke_lie_within_it() -> None:
    places = wear_path(1.0, 0.1, 12, Stroke(np.linspace(4.5, -5.0, 20), np.append(0.1, np.full(19, -0.1))))
    assert places[-1] == -1.0
    assert np.all(np.diff(places) < 0.0)
    assert np.abs(places).max() <= 1.0


def test_a_run_says_of_what_its_energy_is_short_and_what_is_an_error_of_the_program() -> None:
    said = remedies({"energy_against_loops", "volume_against_energy", "penetration", "pressure_against_strength"})
    assert ["jump_tolerance" in one for one in said] == [True, False, False]
    assert ["report it" in one for one in said] == [False, True, False]
    assert ["finer --fidelity" in one for one in said] == [False, False, True]
