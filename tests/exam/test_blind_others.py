"""Simulators by others: each against closed forms, and records of the tier T3."""

from collections.abc import Sequence
from dataclasses import replace
from math import pi, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from studies.blind import generator_of, make_batch
from studies.blind.causes import causes_of
from studies.blind.errors import BlindError
from studies.blind.generators.cases import KINDS_OF_OTHERS, TrueEffect, planned_cases
from studies.blind.generators.generator import weaker_of
from studies.blind.generators.other_simulators.causes import SIZES, sizes
from studies.blind.generators.other_simulators.foundation import Foundation
from studies.blind.generators.other_simulators.half_space import HalfSpaces, HalfSpaceWires
from studies.blind.generators.other_simulators.joints import Sliders
from studies.blind.generators.other_simulators.layers import ElasticLayer, Plane
from studies.blind.generators.other_simulators.logger import drawn_logger, figures, logged_scars
from studies.blind.generators.other_simulators.model import (
    GROWTH,
    Contact,
    OtherSimulators,
    contact_of,
    simulated,
    sized,
    world_of,
)
from studies.blind.generators.other_simulators.pair import Layer, Touch
from studies.blind.generators.other_simulators.rig import Loop, periodic_loop, readings
from studies.blind.generators.other_simulators.tests_drawn import (
    SIMULATORS,
    Block,
    JointTest,
    LineTest,
    StickingTest,
    Test,
    WireTest,
    drawn_tests,
)
from studies.blind.generators.other_simulators.world import World
from wirewear.records import read_record
from wirewear.reference.cattaneo_mindlin import cyclic_loss

E_MPa, RADIUS_mm, LOAD_N = 115000.0, 2.0, 20.0
WIRES = WireTest(
    diameter_mm=1.0, load_N=3.0, amplitude_um=40.0, cycles=3000, stiffness_N_per_mm=None, spring_N_per_mm=0.0
)
TESTS: dict[str, Test] = {
    **{name: replace(WIRES, simulator=name) for name in ("half_space", "foundation", "strips")},
    "layers": LineTest(radius_mm=15.0, length_mm=4.0, load_N=80.0, amplitude_um=30.0, cycles=3000, friction=0.6),
}
NAMES = tuple(TESTS)
TESTS["joint"] = JointTest(load_N=40.0, amplitude_um=300.0, friction=0.4, cycles=300, own_N_per_mm=400.0, spread=0.2)


def paraboloid(count: int, half_mm: float) -> tuple[np.ndarray, float]:
    x = np.linspace(-half_mm, half_mm, count)
    return (x[:, None] ** 2 + x**2) / (2.0 * RADIUS_mm), float(x[1] - x[0])


def test_half_spaces_have_the_pressure_and_approach_of_hertz_also_if_solved_at_once() -> None:
    gap, step = paraboloid(65, 0.1)
    pressure, approach = HalfSpaces((65, 65), (step, step), E_MPa).press(gap, LOAD_N, 0.0)
    radius = (0.75 * LOAD_N * RADIUS_mm / E_MPa) ** (1.0 / 3.0)
    assert approach == pytest.approx(radius**2 / RADIUS_mm, rel=3e-3)
    assert pressure.max() == pytest.approx(1.5 * LOAD_N / (pi * radius**2), rel=1e-2)
    assert pressure.sum() * step**2 == pytest.approx(LOAD_N)
    # Four cells of a soft layer on rigid bodies carry the load evenly: nothing is left to be improved.
    gap = np.ones((24, 24))
    gap[11:13, 11:13] = 0.0
    pressure, _ = HalfSpaces((24, 24), (0.01, 0.01), np.inf).press(gap, LOAD_N, 1e-9)
    assert pressure[11:13, 11:13] == pytest.approx(0.25 * LOAD_N / 0.01**2)


def test_half_spaces_agree_with_tamaas() -> None:
    tamaas = pytest.importorskip("tamaas")
    gap, step = paraboloid(48, 0.12)
    gap[:, 24:] *= 1.4
    own, _ = HalfSpaces((48, 48), (step, step), E_MPa).press(gap, LOAD_N, 0.0)
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, [48 * step, 48 * step], [48, 48])
    model.E, model.nu = E_MPa, 0.0
    tamaas.ModelFactory.registerNonPeriodic(model, "free")
    solver = tamaas.PolonskyKeerRey(model, -gap, 1e-9)
    solver.setIntegralOperator("free")
    solver.solve(LOAD_N / (48 * step) ** 2)
    assert own == pytest.approx(model.traction, abs=0.01 * own.max())


def test_half_spaces_stick_as_cattaneo_and_mindlin_say() -> None:
    gap, step = paraboloid(65, 0.1)
    wires = HalfSpaceWires(gap, (step, step), 0.0, E_MPa, 1.2)
    wires.settle(LOAD_N, Layer())
    radius, friction = (0.75 * LOAD_N * RADIUS_mm / E_MPa) ** (1.0 / 3.0), 0.6
    lag = friction * 1.2 * radius**2 / RADIUS_mm
    assert wires.lag_mm(friction, LOAD_N) == pytest.approx(lag, rel=0.02)
    # A virgin curve's share at u is 1 − (1 − u/lag)^(3/2); from a reversal both are doubled.
    way = np.linspace(0.1, 2.0, 9) * lag
    expected = 2.0 * (1.0 - (1.0 - 0.5 * way / lag) ** 1.5) - 1.0
    assert wires.stroke(way, 5.0 * lag, friction, LOAD_N) == pytest.approx(expected, abs=0.03)


def test_a_foundation_is_pressed_as_johnson_says() -> None:
    gap, step = paraboloid(301, 0.2)
    springs = Foundation(step**2, E_MPa, 0.01)
    _, approach = springs.press(gap, LOAD_N, 0.0)
    stiffness = springs.stiffness_N_per_mm / springs.area
    assert approach == pytest.approx(sqrt(LOAD_N / (pi * stiffness * RADIUS_mm)), rel=5e-3)


@pytest.mark.parametrize("height_mm", [500.0, 5000.0])
def test_deep_layers_have_the_pressure_of_a_line_contact_of_half_planes(height_mm: float) -> None:
    x = np.linspace(-0.4, 0.4, 161)
    bodies = ElasticLayer(2.0 * 0.91 * E_MPa, 0.3, height_mm)
    plane = Plane(2.0 * bodies.matrix(161, 0.005, tractions=False), 0.005)
    pressure, _ = plane.press((x**2 / (2.0 * RADIUS_mm))[:, None], 300.0, 0.0)
    half = sqrt(4.0 * 300.0 * RADIUS_mm / (pi * E_MPa))
    assert pressure.max() == pytest.approx(2.0 * 300.0 / (pi * half), rel=5e-3)
    assert 0.005 * (pressure > 0.0).sum() / 2.0 == pytest.approx(half, abs=0.005)


@pytest.mark.parametrize(("tractions", "modulus"), [(True, 80000.0 / 2.6), (False, 80000.0 * 0.7 / (1.3 * 0.4))])
def test_a_shallow_layer_is_sheared_and_squeezed_as_a_sheet(tractions: bool, modulus: float) -> None:
    matrix = ElasticLayer(80000.0, 0.3, 0.1).matrix(801, 0.01, tractions=tractions)
    assert matrix[400].sum() == pytest.approx(0.1 / modulus, rel=1e-3)


def loop_of(simulator: str, **changes: Any) -> tuple[Loop, World, Contact]:
    test = TESTS[simulator]
    world, pair = replace(world_of(test), **changes), contact_of(test)
    pair.settle(test.load_N, Layer())
    touch = Touch(np.array([-1.0, 1.0]), np.zeros(2), 0.0, pair.area_mm2, 0.0)
    return periodic_loop(world, 1, test.load_N, touch, pair), world, pair


def test_a_joint_gives_way_as_many_springs_with_sliders() -> None:
    lag, way = 0.5 * 100.0 / 1000.0, np.linspace(0.0, 0.4, 101)
    limits = lag * np.linspace(0.8, 1.2, 4001)
    expected = np.clip(way[:, None] - limits, -limits, limits).mean(axis=1) / lag
    assert Sliders(1000.0, 0.2, 1.0).stroke(way, 0.2, 0.5, 100.0) == pytest.approx(expected, abs=1e-4)


@pytest.mark.parametrize("simulator", TESTS)
def test_the_work_of_friction_is_the_area_of_the_loop_and_that_of_sliding(simulator: str) -> None:
    loop, world, pair = loop_of(simulator, compliance_mm_per_N=2e-4, pressure_exponent=0.0, speed_exponent=0.0)
    area = figures(readings(world, 1, loop))["dissipated_energy_mJ"]
    friction = world.friction * world.load_N
    assert loop.work_mJ == pytest.approx(4.0 * friction * loop.half_slip_mm, rel=0.02)
    assert area == pytest.approx(loop.work_mJ, rel=0.02)
    lost = 2e-4 * friction + pair.lag_mm(world.friction, world.load_N)
    assert loop.half_slip_mm == pytest.approx(world.amplitude_mm - lost, rel=1e-3)


@pytest.mark.parametrize(("reached", "stiffness"), [(0.35, None), (0.35, 4000.0), (0.7, 4000.0), (0.95, 1500.0)])
def test_a_ball_in_partial_slip_loses_what_mindlin_and_deresiewicz_say(reached: float, stiffness: float | None) -> None:
    ball = StickingTest(
        diameter_mm=12.7, load_N=40.0, friction=0.6, cycles=300, stiffness_N_per_mm=stiffness, spring_N_per_mm=0.0
    )
    limit, rest = ball.friction * ball.load_N, 1.0 - reached
    given_mm = ball.gives_mm * (1.0 - rest ** (2.0 / 3.0)) + (reached * limit / stiffness if stiffness else 0.0)
    lost = limit * ball.gives_mm / 1.5 * float(cyclic_loss(reached))
    holding = ("held_tangential_force_N", reached * limit), ("held_energy_mJ", lost)
    free = replace(ball, amplitude_um=1e3 * given_mm)
    for test in (free, *(replace(ball, amplitude_um=1.5e3 * given_mm, held=held) for held in holding)):
        found = figures(simulated(test, world_of(test), (300,)).channels[300])
        assert found["max_tangential_force_N"] == pytest.approx(reached * limit, rel=8e-3)
        assert found["dissipated_energy_mJ"] == pytest.approx(lost, rel=0.02)
        assert found["displacement_amplitude_um"] == pytest.approx(1e3 * given_mm, rel=0.01)


@pytest.mark.parametrize(("swing", "work", "ends"), [((0.4, 1), 1.0, (1.4, 0.6)), ((0.3, 2), 0.9, (1.3, 1.3))])
@pytest.mark.parametrize("stiffness", [None, 2000.0])
def test_a_joint_under_a_swinging_load_rubs_by_the_load_of_each_place(
    swing: tuple[float, int], work: float, ends: tuple[float, float], stiffness: float | None
) -> None:
    joint = JointTest(load_N=40.0, amplitude_um=300.0, friction=0.4, cycles=30, own_N_per_mm=4e4, spread=0.2)
    test = replace(joint, swing=swing, stiffness_N_per_mm=stiffness)
    x, q, p = simulated(test, world_of(test), (30,)).channels[30]
    # Springs are turned over by the load at either end.
    given_um = 0.0 if stiffness is None else 0.5 * (ends[0] ** 2 + ends[1] ** 2) * 1e3 * 16.0 / stiffness
    energy = figures((x, q, p))["dissipated_energy_mJ"]
    assert energy == pytest.approx(4e-3 * 16.0 * (300.0 * work - given_um), rel=0.01)
    assert (q.max() / 16.0, -q.min() / 16.0) == pytest.approx([ends[0], ends[0]], rel=0.03)
    drive = (x - 0.5 * (x.max() + x.min())) / 300.0
    assert p == pytest.approx(
        40.0 * (1.0 + swing[0] * np.cos(swing[1] * np.arccos(np.clip(drive, -1.0, 1.0)))), abs=0.3
    )


@pytest.mark.seconds
@pytest.mark.parametrize("simulator", NAMES)
def test_bodies_lose_what_their_energy_asks_for(simulator: str) -> None:
    test = TESTS[simulator]
    world, snapshots = world_of(test), (10, 30, 100, 300, 1000, 1700, 3000)
    course = simulated(test, world, snapshots)
    energy = np.array([figures(one)["dissipated_energy_mJ"] for one in course.channels.values()])
    total_J = 1e-3 * float(np.trapezoid(np.r_[energy[0], energy], (0, *snapshots)))
    volumes = [
        float(depth.sum()) * (x[1] - x[0]) * (y[1] - y[0] if y.size > 1 else test.length_mm)  # type: ignore[union-attr]
        for x, y, depth in course.scars
    ]
    assert sum(volumes) == pytest.approx(world.wear_mm3_per_J * total_J, rel=0.01)
    assert volumes[1] / sum(volumes) == pytest.approx(world.moving_share, rel=1e-3)
    for _, _, depth in course.scars:
        assert depth == pytest.approx(depth[::-1, ::-1])


def test_blocks_that_take_turns_have_their_own_loads_and_strokes_and_wear_one_scar() -> None:
    blocks = Block(400, 3.0, 40.0), Block(1100, 2.0, 24.0)
    test = replace(WIRES, simulator="foundation", blocks=blocks)
    assert test.ends == (400, 1500, 1900, 3000)
    world, cycles = world_of(test), (1, 400, 401, 1500, 1501, 1900, 1901, 3000)
    course = simulated(test, world, cycles)
    found = [figures(one) for one in course.channels.values()]
    strokes = [one["displacement_amplitude_um"] for one in found]
    assert strokes == pytest.approx([40.0, 40.0, 24.0, 24.0, 40.0, 40.0, 24.0, 24.0], rel=1e-3)
    normal = [float(one[2].mean()) for one in course.channels.values()]
    assert normal == pytest.approx([3.0, 3.0, 2.0, 2.0, 3.0, 3.0, 2.0, 2.0], rel=0.02)
    energy = np.array([one["dissipated_energy_mJ"] for one in found]).reshape(4, 2).mean(axis=1)
    worked_J = 1e-3 * float(energy @ [400, 1100, 400, 1100])
    worn = sum(float(depth.sum()) * (x[1] - x[0]) * (y[1] - y[0]) for x, y, depth in course.scars)
    assert worn == pytest.approx(world.wear_mm3_per_J * worked_J, rel=0.02)


@pytest.mark.seconds
def test_wires_by_half_spaces_and_on_a_foundation_wear_alike() -> None:
    snapshots = (30, 300, 3000)
    depths = [
        [float(depth.max()) for _, _, depth in simulated(TESTS[name], world_of(TESTS[name]), snapshots).scars]
        for name in ("half_space", "foundation")
    ]
    assert depths[0] == pytest.approx(depths[1], rel=0.06)


def test_a_play_leaves_a_shelf_and_a_lean_shifts_the_force() -> None:
    loop, world, *_ = loop_of("foundation", play_mm=2e-3)
    shelf = np.abs(loop.tangential_N) < 1e-3 * world.friction * world.load_N
    plain, *_ = loop_of("foundation")
    lost = plain.work_mJ - loop.work_mJ
    assert lost == pytest.approx(2.0 * 2e-3 * world.friction * world.load_N, rel=0.02)
    assert np.ptp(loop.place_mm[shelf]) == pytest.approx(2.0 * (world.amplitude_mm - 1e-3), abs=3e-3)
    lean, world, *_ = loop_of("foundation", lean_rad=0.02)
    assert lean.tangential_N.mean() == pytest.approx(0.02 * world.load_N * (1.0 + world.friction**2), rel=0.05)


@pytest.mark.parametrize("name", [*OtherSimulators("development").library, *causes_of("others")])
def test_a_large_effect_or_cause_stands_out_and_a_small_one_less(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(GROWTH, "foundation", 1.8)
    test = replace(WIRES, stiffness_N_per_mm=400.0, spring_N_per_mm=0.4)
    logger = drawn_logger(test, np.random.default_rng(3))
    logger = replace(logger, has_scars=True, has_normal_force=True, evolution_cycles=(30, 300, 3000))
    true, found = world_of(test), []
    for ease in ("hard", "easy"):
        effect = TrueEffect(name, sizes(name, ease, test, np.random.default_rng(5)))
        found.append(max(sized(test, true, logger, (effect,))[0].values()))
    assert 0.0 < found[0] < found[1]
    assert found[1] > 2.0


def test_the_weaker_of_two_effects_has_the_size_that_the_other_one_cannot_imitate() -> None:
    directions = {"a": np.array([8.0, 0.0, 1.0]), "b": np.array([8.0, 2.0, 1.0]), "c": np.array([-4.0, 0.0, -0.5])}

    def over_scatter(acting: Sequence[TrueEffect]) -> np.ndarray:
        return np.array(sum(one.parameters["size"] * directions[one.effect] for one in acting))

    # Of the first, 2 · 65/69 lies across the second.
    for second, left in (("b", 130.0 / 69.0), ("c", 0.0)):
        effects = tuple(TrueEffect(name, {"size": 1.0}) for name in ("a", second))
        assert weaker_of(effects, over_scatter, over_scatter(effects)) == pytest.approx(left, abs=1e-3)
    assert weaker_of(effects[:1], over_scatter, directions["a"]) == 0.0


def test_noise_and_an_unsure_contact_hide_what_little_slip_shows() -> None:
    ball = StickingTest(
        diameter_mm=12.7, load_N=40.0, friction=0.6, cycles=300, stiffness_N_per_mm=None, spring_N_per_mm=0.0
    )
    test = replace(ball, amplitude_um=200.0 * ball.gives_mm)
    logger = replace(drawn_logger(test, np.random.default_rng(3)), evolution_cycles=(100, 200, 300))
    contact_N_per_mm = 1.5 * test.friction * test.load_N / test.gives_mm
    lag = TrueEffect("sensor_lag", {"time_s": 1e-3})
    spring = TrueEffect("tangential_compliance", {"stiffness_N_per_mm": 30.0 * contact_N_per_mm})
    found = []
    for times in (1.0, 50.0):
        loud = replace(logger, displacement_noise_um=times * logger.displacement_noise_um)
        found.append([sized(test, world_of(test), loud, (one,))[0]["energy last"] for one in (lag, spring)])
    assert found[1][0] < 0.3 * found[0][0]
    # A spring that takes as much as the contact's compliance is unsure by is one scatter.
    assert found[0][1] == pytest.approx(1.0, abs=0.2)


def test_tests_by_others_are_of_many_kinds_and_never_shared_between_sets() -> None:
    drawn = drawn_tests(12, SIMULATORS["scoring"], np.random.default_rng(1))
    assert len({(test.load_N, test.amplitude_um) for test in drawn}) == 12
    wires = [test for test in drawn if isinstance(test, WireTest)]
    assert max(test.diameter_mm for test in wires) > 2.0 * min(test.diameter_mm for test in wires)
    assert {test.crossing_angle_deg for test in wires} > {90.0}
    assert {test.simulator for test in drawn} == {"half_space", "layers"}
    assert not set(SIMULATORS["development"]) & set(SIMULATORS["scoring"])


@pytest.mark.seconds
def test_a_batch_of_others_can_be_read_and_says_nothing_of_its_effects(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for simulator in SIMULATORS["development"]:
        monkeypatch.setitem(GROWTH, simulator, 1.8)
    make_batch(tmp_path / "records", cases=3, seed=4, generator=generator_of("T3"), tests=2)
    for case in sorted((tmp_path / "records").glob("case_*")):
        assert read_record(case).loops
        assert not any(name in (case / "experiment.toml").read_text() for name in (*SIZES, *causes_of("others")))


def test_simulators_that_nobody_knows_are_refused() -> None:
    with pytest.raises(BlindError, match="no simulators 'dahl'"):
        generator_of("T3", law="dahl")


def test_the_kinds_of_a_large_batch_are_as_promised() -> None:
    generator = generator_of("T3", law="scoring")
    planned = planned_cases(
        200, 1, generator.library, generator.outside, 12, generator.nominals, shares=KINDS_OF_OTHERS
    )
    for kind, share in KINDS_OF_OTHERS.items():
        assert sum(case.kind == kind for case in planned) == pytest.approx(200 * share, abs=1)


@pytest.mark.parametrize("angle_deg", [60.0, 90.0])
def test_maps_hold_whole_scars_at_any_angle(angle_deg: float, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(GROWTH, "foundation", 1.8)
    test = replace(WIRES, crossing_angle_deg=angle_deg, wear_mm3_per_J=3e-4)
    course = simulated(test, world_of(test), (30, 3000))
    logger = replace(drawn_logger(test, np.random.default_rng(1)), scar_noise_um=0.0, tilt_um=0.0)
    for scar in logged_scars(logger, test, 1, course.scars, np.random.default_rng(1)):
        edges = [scar.depth_um[[0, -1]], scar.depth_um[:, [0, -1]]]
        assert max(float(edge.max()) for edge in edges) < 0.02 * scar.depth_um.max()
