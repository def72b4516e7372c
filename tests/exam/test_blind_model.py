"""The independent model of the blind check: contact, loop, wear, and what each effect does to them."""

from dataclasses import replace
from functools import cache
from math import pi

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from studies.blind.generators.independent.effects import changed
from studies.blind.generators.independent.foundation import Grid, Shapes
from studies.blind.generators.independent.friction import LAWS
from studies.blind.generators.independent.loop import TrueLoop, chebyshev_step, stages_needed
from studies.blind.generators.independent.sensing import Reading, read
from studies.blind.generators.independent.wear_test import Snapshot, snapshots
from studies.blind.generators.independent.world import World
from studies.blind.generators.independent.worlds import nominal_world
from studies.blind.generators.nominal import Nominal
from studies.blind.generators.sampling import loop_figures
from studies.blind.scoring.answers import OUTSIDE as UNKNOWN
from studies.blind.scoring.judging import Truth, judged
from tests.exam.blind_batches import answer

STEEL = nominal_world(Nominal(), "dahl", held_on_sensor=True)
RIGID = nominal_world(Nominal(stiffness_N_per_mm=None), "dahl", held_on_sensor=True)


def at(world: World, *cycles: int, points: int = 24) -> list[Snapshot]:
    return list(snapshots(world, cycles, points))


def figures(world: World, cycle: int, points: int = 16) -> dict[str, float]:
    """Figures of the readings at a cycle, with the mean force and the mean load."""
    [snapshot] = at(world, cycle, points=points)
    seen = read(world, snapshot.loop, cycle)
    force = seen.tangential_force_N
    return {
        **loop_figures(1e3 * seen.displacement_mm, force),
        "mean_force_N": 0.5 * float(force.max() + force.min()),
        "load_N": float(seen.normal_force_N.mean()),
    }


@pytest.fixture(scope="module")
def steel() -> list[Snapshot]:
    return at(STEEL, 10, 100, 1000, 10000, 100000)


def test_the_first_loop_is_that_of_the_closed_forms_within_a_percent_or_two() -> None:
    for world, slip_um, energy_mJ in ((STEEL, 52.07, 0.2580), (RIGID, 59.49, 0.2949)):
        first = figures(world, 1)
        assert first["slip_amplitude_um"] == pytest.approx(slip_um, rel=0.01)
        assert first["dissipated_energy_mJ"] == pytest.approx(energy_mJ, rel=0.02)


@pytest.mark.seconds
def test_scars_and_loop_of_100_000_cycles_agree_with_finite_elements_within_five_percent(steel: list[Snapshot]) -> None:
    last = steel[-1]
    # The finite elements at standard fidelity: 19.7 and 11.3 µm, δ0 48.9 µm, 1.80 N (README).
    assert 1e3 * last.shapes.fixed.max() == pytest.approx(19.7, rel=0.05)
    assert 1e3 * last.shapes.moving.max() == pytest.approx(11.3, rel=0.05)
    loop = loop_figures(1e3 * last.loop.displacement_mm, last.loop.tangential_force_N)
    assert loop["slip_amplitude_um"] == pytest.approx(48.9, rel=0.03)
    assert loop["max_tangential_force_N"] == pytest.approx(1.80, rel=0.06)


def test_stick_is_as_stiff_as_mindlin_less_the_bulk_of_the_wires() -> None:
    [fresh] = at(RIGID, 1)
    force, displacement = fresh.loop.tangential_force_N, fresh.loop.displacement_mm
    top = int(displacement.argmax())
    slope = (force[top] - force[top + 14]) / (displacement[top] - displacement[top + 14])
    # Mindlin's 2709 N/mm in series with the gripped wires is 2330; the chord of the first 0.2 µm is softer.
    assert 1700.0 < slope < 2400.0


def test_worn_volume_is_the_wear_coefficient_times_the_loops_energy(steel: list[Snapshot]) -> None:
    cycles = np.array([0, *(snapshot.cycle for snapshot in steel)], dtype=float)
    energy = [
        loop_figures(1e3 * s.loop.displacement_mm, s.loop.tangential_force_N)["dissipated_energy_mJ"] for s in steel
    ]
    assert steel[-1].worn_mm3 == pytest.approx(3e-8 * np.trapezoid([energy[0], *energy], cycles), rel=0.02)


def test_the_unworn_world_wears_in_proportion_to_the_shares() -> None:
    [snapshot] = at(replace(STEEL, wear=replace(STEEL.wear, moving_share=0.2)), 2000, points=16)
    assert snapshot.shapes.moving.sum() / snapshot.shapes.fixed.sum() == pytest.approx(0.25, rel=1e-9)


@pytest.mark.seconds
def test_jumps_are_converged() -> None:
    coarse, fine = (next(snapshots(STEEL, [30000], 16, growth)) for growth in (1.3, 1.1))
    assert coarse.shapes.fixed.max() == pytest.approx(fine.shapes.fixed.max(), rel=0.01)
    assert coarse.loop.tangential_force_N.max() == pytest.approx(fine.loop.tangential_force_N.max(), rel=0.03)


def test_a_stabilised_step_is_of_second_order_and_stable() -> None:
    def decay(state: Shapes) -> Shapes:
        return Shapes(-state.fixed, -500.0 * (state.moving - np.cos(1.0)))

    start = Shapes(np.ones((1, 1)), np.ones((1, 1)))
    errors = []
    for count in (8, 16):
        state = start
        for _ in range(count):
            state = chebyshev_step(state, decay, 1.0 / count, stages_needed(1.0 / count, 500.0))
        errors.append(abs(float(state.fixed[0, 0]) - np.exp(-1.0)))
        assert float(state.moving[0, 0]) == pytest.approx(np.cos(1.0), abs=1e-2)
    assert 3.0 < errors[0] / errors[1] < 5.5


def test_windows_and_gathering_are_transposes() -> None:
    grid = Grid.around(0.1, 0.05, 5)
    random = np.random.default_rng(0)
    moving = random.random((grid.y_mm.size, grid.moving_x_mm.size))
    field = random.random((grid.y_mm.size, grid.positions_mm.size, grid.x_mm.size))
    assert np.sum(grid.windows(moving) * field) == pytest.approx(np.sum(moving * grid.gathered(field)))


@pytest.mark.parametrize("law", LAWS)
def test_every_friction_law_starts_with_the_contacts_stiffness_and_ends_mobilised(law: str) -> None:
    share = LAWS[law].share
    assert share(np.array([1e-6]))[0] == pytest.approx(1e-6, rel=1e-3)
    assert share(np.array([50.0]))[0] == pytest.approx(1.0)


def test_boucs_law_solves_its_differential_equation_and_none_is_coulombs_behind_half_spaces() -> None:
    """dz/dx = 1 below no force, 1 - z² above, from z = -1: integrated by Runge and Kutta, x the travel times K/(µP)."""
    travel = np.linspace(0.0, 4.0, 41)
    solved = solve_ivp(lambda _, z: 1.0 - np.maximum(z, 0.0) ** 2, (0.0, 4.0), [-1.0], t_eval=travel, rtol=1e-8)
    np.testing.assert_allclose(2.0 * LAWS["bouc"].share(0.5 * travel) - 1.0, solved.y[0], atol=1e-5)
    reduced = np.linspace(0.0, 1.5, 50)
    mindlin = 1.0 - (1.0 - reduced / 1.5) ** 1.5
    for law in LAWS.values():
        assert np.abs(law.share(reduced) - mindlin).max() > 0.02


SIZES: dict[str, dict[str, float]] = {
    "tangential_compliance": {"stiffness_N_per_mm": 300.0},
    "rotational_compliance": {"stiffness_N_mm_per_rad": 300.0 * 400.0, "arm_mm": 20.0}, "free_play": {"gap_um": 4.0},
    "friction_offset": {"friction": 0.56}, "friction_evolution": {"initial": 0.5, "final": 0.62, "cycles": 3000.0},
    "roughness_compliance": {"layer_um": 5.0, "cycles": 3000.0},
    "third_body": {"retained_fraction": 0.3, "modulus_MPa": 1000.0}, "plasticity": {"flattening_um": 2.0},
    "crossing_angle_error": {"angle_deg": 5.0}, "misalignment": {"angle_deg": 1.0},
    "normal_load_drift": {"fraction_per_100k_cycles": -0.2}, "wear_rate_offset": {"factor": 1.5},
    "wear_rate_evolution": {"initial_factor": 3.0, "final_factor": 1.0, "cycles": 3000.0},
    "displacement_gain": {"gain": 1.05},
    "displacement_load_coupling": {"linear_um_per_N": 3.0, "quadratic_um_per_N2": 0.0},
    "force_crosstalk": {"coefficient": 0.02}, "sensor_lag": {"time_s": 0.002},
    "thermal_gain_drift": {"gain_change": 0.05, "cycles": 1000.0},
    "reversal_adhesion": {"overshoot": 0.3, "length_um": 4.0}, "velocity_dependent_friction": {"per_e_fold": 0.05},
    "clamp_slip": {"holds_N": 0.6, "slip_um_per_N": 5.0},
    "debris_ejection": {"factor": 0.8, "cycle_1": 500.0, "cycle_2": 50000.0, "recovery_cycles": 5000.0},
    "bent_guide": {"load_rise": 0.2}, "saturating_force_cell": {"loss_at_plateau": 0.1},
}  # fmt: skip


def with_effect(effect: str, world: World = STEEL) -> World:
    return changed(world, effect, SIZES[effect])


@pytest.fixture(scope="module")
def nominal() -> dict[str, float]:
    return figures(STEEL, 1000)


@pytest.mark.seconds
def test_a_compliance_takes_its_share_of_the_stroke_and_rotation_is_the_same(nominal: dict[str, float]) -> None:
    sprung, turned = (
        figures(with_effect("tangential_compliance"), 1000),
        figures(with_effect("rotational_compliance"), 1000),
    )
    assert nominal["slip_amplitude_um"] - sprung["slip_amplitude_um"] == pytest.approx(1e3 * 1.24 / 300.0, rel=0.05)
    assert sprung == pytest.approx(turned, rel=1e-6)


def test_play_costs_twice_its_width_times_the_force_and_friction_the_loops_height(nominal: dict[str, float]) -> None:
    loose = figures(with_effect("free_play"), 1000)
    # The reversals of a worn contact are below the plateau's 1.24 N.
    assert nominal["dissipated_energy_mJ"] - loose["dissipated_energy_mJ"] == pytest.approx(2e-3 * 4.0 * 1.24, rel=0.06)
    lower = figures(with_effect("friction_offset"), 1000)
    assert lower["max_tangential_force_N"] / nominal["max_tangential_force_N"] == pytest.approx(0.56 / 0.62, rel=0.02)


def test_misalignment_and_crosstalk_shift_the_force_and_not_the_area(nominal: dict[str, float]) -> None:
    tilted, crossed = figures(with_effect("misalignment"), 1), figures(with_effect("force_crosstalk"), 1000)
    # A tilt of β turns both plateaus: P (1 + µ²) tan β.
    assert tilted["mean_force_N"] == pytest.approx(2.0 * (1.0 + 0.62**2) * np.tan(pi / 180.0), rel=0.05)
    assert crossed["mean_force_N"] == pytest.approx(0.04, rel=0.02)
    assert crossed["dissipated_energy_mJ"] == pytest.approx(nominal["dissipated_energy_mJ"], rel=1e-3)


def test_load_coupling_keeps_the_area_and_the_drive_holds_what_is_read() -> None:
    world = replace(STEEL, drive=replace(STEEL.drive, held_on_sensor=False))
    true, false = figures(world, 100), figures(with_effect("displacement_load_coupling", world), 100)
    assert false["dissipated_energy_mJ"] == pytest.approx(true["dissipated_energy_mJ"], rel=2e-3)
    assert false["slip_amplitude_um"] == pytest.approx(true["slip_amplitude_um"], rel=2e-3)
    assert false["displacement_amplitude_um"] == pytest.approx(60.0 + 3.0 * 1.245, abs=0.1)
    stretched = figures(with_effect("displacement_gain"), 100)
    assert stretched["displacement_amplitude_um"] == pytest.approx(60.0, rel=1e-3)


def test_a_lagging_sensor_opens_the_loop_in_proportion_to_the_frequency() -> None:
    slow = with_effect("sensor_lag", replace(STEEL, drive=replace(STEEL.drive, held_on_sensor=False)))
    fast = replace(slow, drive=replace(slow.drive, frequency_Hz=6.0))
    true = figures(replace(slow, sensors=STEEL.sensors), 100)["dissipated_energy_mJ"]
    gains = [figures(world, 100)["dissipated_energy_mJ"] - true for world in (slow, fast)]
    assert gains[1] / gains[0] == pytest.approx(2.0, rel=0.1)


@pytest.mark.seconds
def test_roughness_softens_the_early_loop_and_wears_in() -> None:
    rough = with_effect("roughness_compliance")
    early, late = (
        figures(STEEL, cycle)["slip_amplitude_um"] - figures(rough, cycle)["slip_amplitude_um"]
        for cycle in (100, 30000)
    )
    # δ0 loses C Q* with C = layer/(0.82 P).
    assert early == pytest.approx(5.0 / (0.82 * 2.0) * 1.24 * np.exp(-100 / 3000), rel=0.05)
    assert abs(late) < 0.05


FREE_STROKE = nominal_world(Nominal(), "dahl", held_on_sensor=False)
PHASE = 2.0 * np.pi * np.arange(1440) / 1440
#: A loop in closed form: a sine of 60 µm, forces of ±1.2 N that turn within some degrees of each reversal.
LOOP = TrueLoop(0.06 * np.sin(PHASE), 1.2 * np.tanh(8.0 * np.cos(PHASE - 0.3)), np.full(1440, 2.0), (-0.055, 0.055))


def seen(effect: str, cycle: float = 1.0, **parameters: float) -> Reading:
    return read(changed(FREE_STROKE, effect, parameters), LOOP, cycle)


@cache
def loop_of(effect: str = "", **parameters: float) -> Reading:
    """Readings of the tenth cycle, on a coarse grid."""
    world: World = changed(FREE_STROKE, effect, parameters) if effect else FREE_STROKE
    [snapshot] = snapshots(world, [10], 10)
    return read(world, snapshot.loop, 10)


def area_mJ(reading: Reading) -> float:
    x, q = reading.displacement_mm, reading.tangential_force_N
    return abs(float(np.sum(0.5 * (q + np.roll(q, -1)) * (np.roll(x, -1) - x))))


def test_an_asymmetric_cell_stretches_one_sign_and_one_with_hysteresis_loses_its_play() -> None:
    force = seen("asymmetric_force_cell", asymmetry=0.1).tangential_force_N
    assert force.max() == pytest.approx(1.1 * LOOP.tangential_force_N.max())
    assert force.min() == pytest.approx(0.9 * LOOP.tangential_force_N.min())
    force = seen("force_cell_hysteresis", play_N=0.2).tangential_force_N
    assert np.ptp(force) == pytest.approx(np.ptp(LOOP.tangential_force_N) - 0.2, rel=1e-6)


def test_a_creeping_zero_moves_the_whole_loop_and_a_bent_sensor_is_right_at_ends_and_middle() -> None:
    late = seen("creeping_force_zero", cycle=1e6, zero_N=0.1, cycles=1000.0).tangential_force_N
    early = seen("creeping_force_zero", cycle=1.0, zero_N=0.1, cycles=1000.0).tangential_force_N
    assert late - LOOP.tangential_force_N == pytest.approx(0.1, abs=1e-6)
    assert np.abs(early - LOOP.tangential_force_N).max() < 1e-3
    moved = 1e3 * (seen("bent_displacement_sensor", bend=0.1).displacement_mm - LOOP.displacement_mm)
    for place in (0.0, 0.06, -0.06):
        assert moved[np.argmin(np.abs(LOOP.displacement_mm - place))] == pytest.approx(0.0, abs=0.02)
    assert np.abs(moved).max() == pytest.approx(0.1 * 60.0 * 2.0 / 3.0**1.5, rel=0.01)


def test_backlash_parts_the_branches_by_its_width() -> None:
    read_mm = seen("displacement_backlash", play_um=4.0).displacement_mm
    rising = np.cos(PHASE) > 0.5
    falling = np.cos(PHASE) < -0.5
    assert 1e3 * (LOOP.displacement_mm - read_mm)[rising] == pytest.approx(2.0)
    assert 1e3 * (read_mm - LOOP.displacement_mm)[falling] == pytest.approx(2.0)


def test_a_parallel_spring_adds_a_force_that_follows_the_place_and_no_area() -> None:
    sprung = seen("parallel_spring", stiffness_N_per_mm=2.0)
    assert sprung.tangential_force_N - LOOP.tangential_force_N == pytest.approx(2.0 * LOOP.displacement_mm)
    plain = Reading(LOOP.displacement_mm, LOOP.tangential_force_N, LOOP.normal_force_N)
    assert area_mJ(sprung) == pytest.approx(area_mJ(plain), rel=1e-9)


def test_a_stiffening_holder_costs_area_and_one_comes_loose_by_the_end_of_the_test_alone() -> None:
    assert area_mJ(loop_of("stiffening_holder", hardening_um_per_N3=4.0)) < 0.99 * area_mJ(loop_of())
    rig = changed(FREE_STROKE, "loosening_holder", {"loosening_um_per_N": 3.0, "cycles": 1e4}).rig
    assert rig.loose_mm_per_N(10.0) < 1e-5
    assert rig.loose_mm_per_N(1e5) == pytest.approx(3e-3, rel=1e-3)


def test_friction_and_load_that_slant_raise_one_end_of_the_stroke() -> None:
    for effect, parameters in (("slanted_friction", {"rise": 0.2}), ("slanted_load", {"load_rise": 0.2})):
        slanted, plain = loop_of(effect, **parameters), loop_of()
        # Late on either branch, where the contact slides for certain.
        width = np.abs(slanted.tangential_force_N) - np.abs(plain.tangential_force_N)
        right, left = plain.displacement_mm > 0.035, plain.displacement_mm < -0.035
        slides = np.abs(plain.tangential_force_N) > 1.1
        assert width[right & slides].mean() > 0.08, effect
        assert width[left & slides].mean() < -0.08, effect


def test_friction_ripples_along_the_stroke_at_its_length() -> None:
    rippled, plain = loop_of("rippled_friction", share=0.05, length_um=10.0), loop_of()
    slides = (np.abs(plain.displacement_mm) < 0.03) & (plain.tangential_force_N > 1.1)
    place = 1e3 * plain.displacement_mm[slides]
    rest = rippled.tangential_force_N[slides] - plain.tangential_force_N[slides]
    waves = [abs(np.mean(rest * np.exp(2j * np.pi * place / length))) for length in (7.0, 10.0, 14.0)]
    assert np.argmax(waves) == 1
    assert 2.0 * waves[1] == pytest.approx(0.05 * 1.24, rel=0.3)


def test_friction_breathes_and_wear_is_severe_for_a_while() -> None:
    friction = changed(FREE_STROKE, "breathing_friction", {"share": 0.1, "folds": 2.0}).friction
    values = [friction.at(cycle) for cycle in np.geomspace(1.0, 1e5, 200)]
    assert max(values) == pytest.approx(1.1 * 0.62, rel=1e-2)
    assert min(values) == pytest.approx(0.9 * 0.62, rel=1e-2)
    wear = changed(FREE_STROKE, "severe_wear", {"factor": 4.0, "cycle": 1e4, "recovery_cycles": 5e3}).wear
    assert [wear.factor_at(cycle) for cycle in (9999.0, 1e4)] == [1.0, 4.0]
    assert wear.factor_at(1e5) == pytest.approx(1.0, abs=1e-6)


def test_an_effect_that_another_one_contains_cannot_be_unexplained() -> None:
    """A wear rate that is left out of the library is a course of the wear rate that stays."""
    truth = Truth("case_1", "left_out", "easy", ("wear_rate_offset",), {"wear_rate_offset": {"factor": 1.5}}, 9.0)
    assert not truth.is_open
    assert judged(truth, answer("explained", {"wear_rate_evolution": 0.9})).first_right
    assert not judged(truth, answer("unexplained", {UNKNOWN: 0.9})).first_right
    open_ = Truth("case_2", "left_out", "easy", ("free_play",), {"free_play": {"gap_um": 3.0}}, 9.0)
    assert open_.is_open
    assert judged(open_, answer("unexplained", {UNKNOWN: 0.9})).first_right
