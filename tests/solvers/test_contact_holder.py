"""What holds the upper wire: rotation, prescribed approach; and the penalty formulation beside the exact one."""

from dataclasses import dataclass, replace
from math import atan, radians, tan

import numpy as np
import pytest

from solvers.contact import ContactProblem
from solvers.contact.problem import misaligned
from solvers.contact_state import ContactState, Holder, IncrementReport
from solvers.drive import Drive
from solvers.errors import NotConvergedError, SolverError
from solvers.fretting import first_quarter, measured_holder, run_cycle
from solvers.wear import WearRates
from tests.bodies import FRICTION, LOAD_N, AMPLITUDE_mm, RADIUS_mm, RIG_N_per_mm, crossed_wires, driven, pressed

COARSE_mm = 0.010
ANGLE = radians(2.0)
#: To one end of the stroke, to the other, and back to the first.
WAY = AMPLITUDE_mm * np.array([0.3, 0.6, 0.9, 0.6, 0.3, 0.0, -0.3, -0.6, -0.9, -0.6, -0.3, 0.0, 0.3, 0.6, 0.9])
STROKE = AMPLITUDE_mm * np.sin(2.0 * np.pi * np.arange(1, 21, 2) / 40)


@pytest.fixture(scope="module")
def straight() -> ContactProblem:
    return crossed_wires(COARSE_mm, long_patch=True)


def run(problem: ContactProblem) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Tangential force, normal force and height of the holder above its place when just pressed."""
    start, _ = pressed(problem)
    states, reports = driven(problem, start, WAY)
    last = [pieces[-1] for pieces in reports]
    return (
        np.array([report.tangential_force for report in last]),
        np.array([report.normal_force for report in last]),
        np.array([state.holder_z - start.holder_z for state in states]),
    )


def test_without_friction_the_force_is_the_load_times_the_slope(straight: ContactProblem) -> None:
    force, load, height = run(misaligned(replace(straight, friction=0.0), ANGLE))
    assert force == pytest.approx(np.full(len(WAY), LOAD_N * tan(ANGLE)), rel=0.01)
    assert load == pytest.approx(np.full(len(WAY), LOAD_N), rel=1e-9)
    assert height == pytest.approx(WAY * tan(ANGLE), abs=1e-3 * AMPLITUDE_mm)


def test_sliding_takes_the_force_of_a_body_on_an_inclined_plane(straight: ContactProblem) -> None:
    force, _, _ = run(misaligned(straight, ANGLE))
    level, _, _ = run(straight)
    out, back = 0.3 * AMPLITUDE_mm == WAY, -0.6 * AMPLITUDE_mm == WAY
    rising, falling = float(force[out][-1]), float(force[back][0])
    # Curvature takes a little off the level force, too; the inclined plane shows how much the slope adds.
    phi = atan(float(level[out][-1]) / LOAD_N)
    assert rising == pytest.approx(LOAD_N * tan(phi + ANGLE), rel=2e-3)
    assert falling == pytest.approx(-LOAD_N * tan(phi - ANGLE), rel=2e-3)
    mean = 0.5 * (rising + falling)
    assert mean == pytest.approx(LOAD_N * tan(ANGLE) * (1.0 + FRICTION**2), rel=0.02)


def test_a_loading_spring_turns_the_rise_into_a_ripple_in_phase_with_the_motion(straight: ContactProblem) -> None:
    stiffness = 20.0
    _, load, height = run(misaligned(replace(straight, holder=Holder(LOAD_N, 0.0, stiffness)), ANGLE))
    assert load - LOAD_N == pytest.approx(stiffness * height, abs=1e-9)
    assert load - LOAD_N == pytest.approx(
        stiffness * WAY * tan(ANGLE), abs=0.02 * stiffness * AMPLITUDE_mm * tan(ANGLE)
    )


@pytest.fixture(scope="module")
def spring() -> ContactProblem:
    return crossed_wires(COARSE_mm, long_patch=True, rig_N_per_mm=RIG_N_per_mm)


def forces(problem: ContactProblem) -> list[float]:
    _, reports = driven(problem, pressed(problem)[0], STROKE)
    return [pieces[-1].tangential_force for pieces in reports]


@pytest.mark.parametrize("arm", [9.0, RADIUS_mm])
def test_a_rotating_holder_is_a_spring_of_stiffness_over_the_arm_squared(spring: ContactProblem, arm: float) -> None:
    """Also where it rolls about the wire's own axis: the load leans as far as the contact rolls."""
    rotating = Holder(
        normal_load_N=LOAD_N, rotational_compliance_rad_per_N_mm=1.0 / (RIG_N_per_mm * arm**2), pivot_height_mm=arm
    )
    assert forces(replace(spring, holder=rotating)) == pytest.approx(forces(spring), abs=0.01 * FRICTION * LOAD_N)


def test_at_a_held_approach_the_load_falls_as_the_wires_wear(spring: ContactProblem) -> None:
    state, _ = pressed(spring)
    held = Holder(normal_load_N=LOAD_N, tangential_compliance_mm_per_N=1.0 / RIG_N_per_mm, approach_mm=-state.holder_z)
    problem = replace(spring, holder=held, wear=WearRates(1.5e-8, 1.5e-8))
    start, _ = pressed(problem)
    states, reports = driven(problem, start, STROKE, cycles=20.0)
    assert [state.holder_z for state in states] == pytest.approx([start.holder_z] * len(states), rel=1e-12)
    loads = [pieces[-1].normal_force for pieces in reports]
    assert loads[-1] < 0.98 * loads[0]


def test_at_a_held_approach_wires_part_over_a_hollow_and_meet_behind_it(spring: ContactProblem) -> None:
    state, _ = pressed(spring)
    problem = replace(spring, holder=Holder(LOAD_N, 1.0 / RIG_N_per_mm, approach_mm=-state.holder_z))
    ends = np.linspace(0.0, AMPLITUDE_mm, 6)
    start = driven(problem, pressed(problem)[0], ends)[0][-1]
    along = np.abs(problem.secondary.node_positions[:, 0]).reshape(start.wear.secondary_depth.shape)
    hollow = np.where(along < 0.6 * AMPLITUDE_mm, -2.0 * state.holder_z, 0.0)
    states, reports = driven(
        problem, replace(start, wear=replace(start.wear, secondary_depth=hollow)), np.linspace(1.0, -1.0, 13) * ends[-1]
    )
    last = [pieces[-1] for pieces in reports]
    loads = np.array([report.normal_force for report in last])
    assert loads[4:9].tolist() == [0.0] * 5
    assert states[6].holder_x == last[6].tangential_force == last[6].friction_work == 0.0
    assert loads[0] > 0.5 * LOAD_N
    assert loads[-1] == pytest.approx(loads[0], rel=0.02)


def test_penalty_and_augmented_lagrangian_agree_and_the_elastic_slip_is_reported(spring: ContactProblem) -> None:
    soft = replace(spring, formulation="penalty")
    exact_state, exact = pressed(spring)
    soft_state, found = pressed(soft)
    assert 1e-3 < found.penetration < 0.03
    assert found.max_pressure == pytest.approx(exact.max_pressure, rel=0.03)
    assert soft_state.holder_z == pytest.approx(exact_state.holder_z, rel=0.02)
    _, reports = driven(soft, soft_state, STROKE)
    last = [pieces[-1] for pieces in reports]
    assert [piece.tangential_force for piece in last] == pytest.approx(forces(spring), abs=0.01 * FRICTION * LOAD_N)
    assert 0.0 < last[0].elastic_slip < 0.03
    assert exact.elastic_slip == 0.0


def test_a_guide_from_before_load_and_friction_changed_leads_to_the_same_cycle(spring: ContactProblem) -> None:
    quarter = first_quarter(spring, pressed(spring)[0], Drive(AMPLITUDE_mm), 16)
    before, trace = run_cycle(spring, quarter, Drive(AMPLITUDE_mm), 16, 0.0)
    changed = replace(spring, friction=0.7 * FRICTION, holder=replace(spring.holder, normal_load_N=0.8 * LOAD_N))
    _, guided = run_cycle(changed, before, Drive(AMPLITUDE_mm), 16, 0.0, None, trace.guide)
    _, unguided = run_cycle(changed, before, Drive(AMPLITUDE_mm), 16, 0.0)
    assert guided.tangential_force == pytest.approx(unguided.tangential_force, abs=1e-4 * LOAD_N)
    assert guided.normal_force == pytest.approx(np.full(16, 0.8 * LOAD_N), rel=1e-9)
    assert np.abs(guided.tangential_force).max() == pytest.approx(0.56 * FRICTION * LOAD_N, rel=0.02)


def test_a_rig_softer_than_friction_falls_along_the_stroke_is_said_to_snap(spring: ContactProblem) -> None:
    soft_N_per_mm = 20.0

    def held(rig_N_per_mm: float) -> ContactProblem:
        return misaligned(replace(spring, holder=Holder(LOAD_N, 1.0 / rig_N_per_mm, approach_mm=2e-3)), -0.05)

    stiff = held(2000.0)
    states = driven(stiff, pressed(stiff)[0], np.array([0.01, 0.015, 0.02]))[0]
    force = np.array([state.primary_force[:, 0].sum() for state in states[1:]])
    apart = np.array([state.drive - state.holder_x for state in states[1:]])
    assert (force[0] - force[1]) / (apart[1] - apart[0]) > soft_N_per_mm
    soft = held(soft_N_per_mm)
    with pytest.raises(NotConvergedError, match="rig would snap"):
        driven(soft, pressed(soft)[0], np.linspace(0.02, 0.16, 8))


PLAY_mm = 0.006
SLIDING_N = FRICTION * LOAD_N
INCREMENTS = 40
LOOP = AMPLITUDE_mm * np.cos(2.0 * np.pi * np.arange(1, INCREMENTS + 1) / INCREMENTS)


@dataclass
class Run:
    states: list[ContactState]
    reports: list[list[IncrementReport]]

    @property
    def force(self) -> np.ndarray:
        return np.array([pieces[-1].tangential_force for pieces in self.reports])

    @property
    def holder_x(self) -> np.ndarray:
        return np.array([state.holder_x for state in self.states])

    @property
    def energy(self) -> float:
        return sum(piece.friction_work for pieces in self.reports for piece in pieces)


def loop(problem: ContactProblem) -> Run:
    """A closed loop from +amplitude and back, after the way there."""
    started, _ = driven(problem, pressed(problem)[0], AMPLITUDE_mm * np.sin(0.5 * np.pi * np.arange(1, 6) / 5))
    return Run(*driven(problem, started[-1], LOOP))


def with_play(problem: ContactProblem, **changes: float) -> ContactProblem:
    return replace(problem, holder=replace(problem.holder, play_mm=PLAY_mm, **changes))


@pytest.fixture(scope="module")
def without(spring: ContactProblem) -> Run:
    return loop(spring)


@pytest.fixture(scope="module")
def loose(spring: ContactProblem) -> Run:
    return loop(with_play(spring))


def test_play_takes_twice_its_width_times_the_sliding_force_from_the_energy(without: Run, loose: Run) -> None:
    assert without.energy - loose.energy == pytest.approx(2.0 * PLAY_mm * SLIDING_N, rel=0.03)
    assert np.abs(loose.force).max() == pytest.approx(np.abs(without.force).max(), rel=1e-3)


def test_the_holder_moves_by_spring_and_half_the_play_and_floats_without_force(loose: Run) -> None:
    floating = np.abs(loose.force) < 1e-6 * SLIDING_N
    place = loose.holder_x - loose.force / RIG_N_per_mm
    assert np.abs(place).max() <= 0.5 * PLAY_mm * (1.0 + 1e-9)
    assert place[~floating] == pytest.approx(0.5 * PLAY_mm * np.sign(loose.force[~floating]), abs=1e-9)
    assert max(piece.force_error for pieces in loose.reports for piece in pieces) < 1e-9


def test_the_loop_gives_back_every_element_of_the_holder(spring: ContactProblem) -> None:
    arm = 9.0
    problem = with_play(spring, rotational_compliance_rad_per_N_mm=1.0 / (400.0 * arm**2), pivot_height_mm=arm)
    found = measured_holder(problem, loop(problem).states)
    assert found.tangential_stiffness_N_per_mm == pytest.approx(RIG_N_per_mm, rel=1e-6)
    assert found.rotational_stiffness_N_mm_per_rad == pytest.approx(400.0 * arm**2, rel=1e-6)
    assert found.play_mm == pytest.approx(PLAY_mm, rel=1e-6)
    assert found.contact_stiffness_N_per_mm == pytest.approx(1.0 / (1.0 / RIG_N_per_mm + 1.0 / 400.0), rel=0.02)


def test_play_within_which_the_whole_stroke_fits_carries_no_force(spring: ContactProblem) -> None:
    problem = replace(spring, holder=replace(spring.holder, play_mm=3.0 * AMPLITUDE_mm))
    run = loop(problem)
    assert np.abs(run.force).max() < 1e-6 * SLIDING_N
    assert run.energy == pytest.approx(0.0, abs=1e-9)
    with pytest.raises(SolverError, match="forces in both directions"):
        measured_holder(problem, run.states)
