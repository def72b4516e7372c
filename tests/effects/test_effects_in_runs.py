"""Effects in real runs on a coarse mesh: their signatures against closed forms."""

from typing import Any

import numpy as np
import pytest

from tests.studies import COARSE, WEARING, line_study, result_with
from wirewear import Loop, RunResult
from wirewear.effects import Effect, effect_named
from wirewear.results import read_loops
from wirewear.simulation import simulate

LIMIT_N = 0.62 * 2.0


def effect(name: str, **values: float) -> Effect[Any]:
    return effect_named(name)(**values)


def largest_force_N(result: RunResult) -> float:
    return float(result.evolution["max_tangential_force_N"][0])


def loop_area_mJ(loop: Loop) -> float:
    x, q = 1e-3 * loop.displacement_um, loop.tangential_force_N
    return 0.5 * abs(float(np.sum(x * np.roll(q, -1) - np.roll(x, -1) * q)))


SENSOR_ENERGY = {
    "displacement_gain": ({"gain": 1.05}, 1.05),
    "displacement_load_coupling": ({"linear_um_per_N": 5.0, "quadratic_um_per_N2": 0.0}, 1.0),
    "force_crosstalk": ({"coefficient": 0.03}, 1.0),
}


@pytest.mark.seconds
@pytest.mark.parametrize("name", SENSOR_ENERGY)
def test_sensor_effects_leave_the_test_alone_and_the_energy_by_the_theorem(name: str) -> None:
    values, ratio = SENSOR_ENERGY[name]
    nominal, misread = result_with(), result_with(effect(name, **values))
    np.testing.assert_array_equal(misread.loops[0].tangential_force_N, nominal.loops[0].tangential_force_N)
    (read,) = read_loops(misread)
    assert loop_area_mJ(read) == pytest.approx(ratio * loop_area_mJ(nominal.loops[0]), rel=1e-3)


@pytest.mark.seconds
@pytest.mark.parametrize(
    ("name", "values", "energy_mJ"),
    [
        ("tangential_compliance", {"stiffness_N_per_mm": 1e3}, 4.0 * LIMIT_N**2 / 1e3),
        ("rotational_compliance", {"stiffness_N_mm_per_rad": 9e5, "arm_mm": 30.0}, 4.0 * LIMIT_N**2 / 1e3),
        ("free_play", {"gap_um": 1.0}, 2e-3 * LIMIT_N),
    ],
)
def test_springs_and_play_take_their_share_of_the_energy(name: str, values: Any, energy_mJ: float) -> None:
    nominal, changed = (result.loops[0] for result in (result_with(), result_with(effect(name, **values))))
    lost = nominal.friction_work_mJ[-1] - changed.friction_work_mJ[-1]
    assert lost == pytest.approx(energy_mJ, rel=0.01)


@pytest.mark.seconds
def test_a_lagging_sensor_moves_points_back_along_the_motion() -> None:
    (read,) = read_loops(result_with(effect("sensor_lag", time_s=0.002)))
    truth = result_with().loops[0]
    omega = 2.0 * np.pi * 3.0
    # Of a sine, first order: x(t) − τ x'(t); what is read trails behind on both branches.
    expected = -20.0 * omega * 0.002 * np.cos(omega * truth.time_s)
    np.testing.assert_allclose(read.displacement_um - truth.displacement_um, expected, atol=20.0 * (omega * 0.002) ** 2)


@pytest.mark.seconds
def test_friction_moves_height_and_knee_of_the_loop_together() -> None:
    nominal, lower = result_with(), result_with(effect("friction_offset", friction=0.527))
    assert largest_force_N(lower) == pytest.approx(0.85 * largest_force_N(nominal), rel=1e-3)
    # Branch heights change alike on both: the difference is odd in the direction of motion.
    forward, backward = plateau_difference(lower, nominal)
    assert forward == pytest.approx(-backward, abs=2e-3)
    assert forward == pytest.approx(-0.15 * LIMIT_N, rel=0.01)


@pytest.mark.seconds
def test_a_misaligned_load_lifts_both_plateaus() -> None:
    """Statics of the inclined plane: P tan(φ + β) out and P tan(φ − β) back."""
    lifted = plateau_difference(result_with(effect("misalignment", angle_deg=2.0)), result_with())
    phi, beta = np.arctan(0.62), np.radians(2.0)
    expected = np.tan(phi + beta) - 0.62, 0.62 - np.tan(phi - beta)
    assert lifted == pytest.approx(2.0 * np.array(expected), rel=0.03)


def plateau_difference(result: RunResult, nominal: RunResult) -> tuple[float, float]:
    """Difference of the force at mid-stroke on the forward and the backward branch."""
    differences = []
    for which in (1, -1):
        at = []
        for run in (result, nominal):
            loop = run.loops[0]
            forward = np.gradient(loop.displacement_um) * which > 0.0
            near = np.abs(loop.displacement_um) < 5.0
            at.append(float(loop.tangential_force_N[forward & near].mean()))
        differences.append(at[0] - at[1])
    return differences[0], differences[1]


def test_flattened_wires_touch_on_a_larger_area_under_less_pressure() -> None:
    nominal, flat = result_with(), result_with(effect("plasticity", flattening_um=1.0))
    radius = float(flat.settings["fresh_contact_radius_um"])
    overlap = 1e3 * np.sqrt(2.0 * 0.225 * 1e-3)
    assert float(nominal.settings["fresh_contact_radius_um"]) < 0.8 * radius
    assert radius == pytest.approx(overlap, rel=0.2)
    assert flat.scar(1, "fixed").max_depth_um == pytest.approx(0.5, rel=1e-6)
    assert flat.settings["fresh_max_pressure_MPa"] < 0.7 * nominal.settings["fresh_max_pressure_MPa"]
    # No wear is needed for the depth, and its volume closes.
    assert flat.quality["volume_against_energy"] < 1e-12


CYCLES = (
    COARSE.replace("cycles = 1", "cycles = 20").replace("increments_per_cycle = 40", "increments_per_cycle = 16")
    + WEARING
)


def volume_mm3(result: RunResult) -> float:
    return float(result.evolution["worn_volume_fixed_mm3"][-1])


@pytest.mark.slow
def test_with_ten_times_the_wear_rate_a_cycle_wears_as_ten_and_leaves_their_loop() -> None:
    nominal, faster = result_with(text=CYCLES), result_with(effect("wear_rate_offset", factor=10.0), text=CYCLES)
    ratio = faster.evolution["accumulated_energy_J"][-1] / nominal.evolution["accumulated_energy_J"][-1]
    assert volume_mm3(faster) == pytest.approx(10.0 * ratio * volume_mm3(nominal), rel=1e-9)
    force, force_faster = (
        dict(zip(result.evolution["cycle"], result.evolution["max_tangential_force_N"], strict=True))
        for result in (nominal, faster)
    )
    for cycle in (1.0, 2.0):
        assert force_faster[cycle] == pytest.approx(force[10.0 * cycle], rel=1e-5)
    # What has not worn that much has another loop.
    assert force[1.0] != pytest.approx(force_faster[1.0], rel=1e-3)


@pytest.mark.slow
def test_a_wear_rate_evolution_wears_by_its_factor_integrated_from_the_test_s_start() -> None:
    changing = effect("wear_rate_evolution", initial_factor=2.0, final_factor=1.0, cycles=10.0)
    nominal, evolving = result_with(text=CYCLES).evolution, result_with(changing, text=CYCLES).evolution
    cycles = nominal["cycle"]
    mean = 1.0 + 10.0 * (1.0 - np.exp(-cycles / 10.0)) / cycles
    np.testing.assert_allclose(evolving["worn_volume_fixed_mm3"] / nominal["worn_volume_fixed_mm3"], mean, rtol=2e-3)


def of_line(**tables: Any) -> RunResult:
    """Ten cycles of a cylinder on a flat."""
    asked = {"normal_load_N_per_mm": 100.0, "displacement_amplitude_um": 40.0, "cycles": 10}
    mesh = {"contact_mesh_um": 40.0, "increments_per_cycle": 24}
    study = line_study(pad={"radius_mm": 40.0}, conditions=asked, mesh=mesh, log=None, **tables)
    return simulate(study, fidelity="quick")


@pytest.mark.slow
def test_line_contacts_take_effects_of_holder_contact_wear_and_loading() -> None:
    effects = {
        "friction_offset": {"friction": 0.3},
        "tangential_compliance": {"stiffness_N_per_mm": 10000.0},
        "wear_rate_offset": {"factor": 2.0},
        "normal_load_drift": {"fraction_per_100k_cycles": 1.0},
    }
    nominal, changed = of_line(), of_line(effects=[{"name": name, **values} for name, values in effects.items()])
    force, energy = ("max_tangential_force_N", "dissipated_energy_mJ")
    assert changed.evolution[force][-1] == pytest.approx(0.5 * nominal.evolution[force][-1], rel=1e-3)
    lost = 0.5 * nominal.evolution[energy][0] - changed.evolution[energy][0]
    # The elastic motion that is won back grows as half the force's square.
    assert lost < 4.0 * 30.0**2 / 1e4
    worn = [result.evolution["worn_volume_pad_mm3"][-1] for result in (nominal, changed)]
    gathered = [result.evolution["accumulated_energy_J"][-1] for result in (nominal, changed)]
    assert worn[1] / gathered[1] == pytest.approx(2.0 * worn[0] / gathered[0], rel=1e-9)
    assert changed.quality["volume_against_energy"] < 1e-9
