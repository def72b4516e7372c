"""Contacts that stick in their middle: loops of the fast model beside closed forms, and records of a ball.

Reference figures: Ø12.7 mm steel ball on a flat under 40 N, µ = 0.6, K = 22461.5 N/mm (Mindlin and Deresiewicz 1953).
"""

from copy import deepcopy
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from geometry.arrays import Array
from tests.diagnosis.diagnosis_cases import nominal, with_effect
from tests.simulation.point_contacts import STEEL
from wirewear import record_of_result
from wirewear.diagnosis import diagnose
from wirewear.diagnosis.infer.search import search
from wirewear.diagnosis.observe.reduction import reduce
from wirewear.diagnosis.surrogate.forward import PredictedLoops, simulate, simulated
from wirewear.diagnosis.surrogate.inputs import SurrogateInputs
from wirewear.diagnosis.surrogate.sticking import sticking_states, worn_as_far
from wirewear.diagnosis.surrogate.wear_states import WearStates
from wirewear.effects import all_effects
from wirewear.loops.sensor import Sensor, SensorNoise
from wirewear.records import AnyRecord, ExperimentRecord
from wirewear.records.contact_tables import RECORDS
from wirewear.records.values import MeasuredLoop
from wirewear.results import Loop
from wirewear.simulation import run_study
from wirewear.test import study_from_tables

LOAD_N, FRICTION, STIFFNESS_N_per_um = 40.0, 0.6, 22.4615
FRICTION_N = FRICTION * LOAD_N
#: Share of the friction, displacement amplitude in µm and energy in µJ.
CASES = ((0.30, 0.33918, 0.19297), (0.50, 0.59308, 1.0837), (0.70, 0.88449, 3.8421), (0.95, 1.3852, 17.375))
CYCLES = np.array([1.0, 100.0])


def ball(orders: float = 1.5) -> WearStates:
    flat, none = np.array([0.0, 1e3]), np.zeros((2, 2))
    return WearStates(
        radius_um=6350.0, friction=FRICTION, normal_load_N=LOAD_N, fresh_area_um2=43886.0, volume_um3=flat,
        slip_um=np.ones(2), similarity=flat, slope=np.zeros((2, 5)), angle=none,
        stiffness_N_per_um=np.full(2, STIFFNESS_N_per_um), load_drop_N=np.zeros(2), lift_N=none,
        scars=np.zeros((2, 2, 4)), yields=np.tile([orders, 1.0, 0.0, 0.0, 0.0], (2, 1)),
    )  # fmt: skip


def circumstances(amplitude_um: float, **changes: Any) -> SurrogateInputs:
    test = replace(
        nominal(), amplitude_um=amplitude_um, load_N=LOAD_N, friction=FRICTION, compliance_um_per_N=0.0,
        wear_um3_per_mJ=0.0, normal_spring_N_per_um=0.0, crossing_error_rad=0.0,
    )  # fmt: skip
    return replace(test, **changes)


def largest(course: PredictedLoops) -> Array:
    return np.asarray(course.tangential_force_N.max(axis=(1, 2)))


@pytest.mark.parametrize(("share", "amplitude_um", "energy_uJ"), CASES)
def test_a_loop_that_sticks_has_the_force_and_energy_of_mindlin(
    share: float, amplitude_um: float, energy_uJ: float
) -> None:
    course = simulate(ball(), circumstances(amplitude_um), CYCLES)
    assert largest(course) == pytest.approx(share * FRICTION_N, rel=1e-3)
    assert 1e3 * course.energy_mJ == pytest.approx(energy_uJ, rel=3e-3)
    x, q = course.displacement_um[0].ravel(), course.tangential_force_N[0].ravel()
    assert 0.5 * abs(float(x @ np.roll(q, -1) - q @ np.roll(x, -1))) == pytest.approx(energy_uJ, rel=0.02)


@pytest.mark.parametrize(("share", "amplitude_um"), [case[:2] for case in CASES])
def test_a_lean_raises_the_force_of_what_sticks_as_a_larger_load_does(share: float, amplitude_um: float) -> None:
    def mindlin_N(load: float) -> float:
        softer = STIFFNESS_N_per_um * load ** (1.0 / 3.0) / (1.5 * load * FRICTION_N)
        return load * FRICTION_N * float(1.0 - (1.0 - softer * amplitude_um) ** 1.5)

    lean = simulate(ball(), with_effect(circumstances(amplitude_um), "misalignment", {"angle_deg": 1.0}), CYCLES)
    force = lean.tangential_force_N[0]
    # The force along the motion, by the slope, presses the bodies together, which moves it on.
    follows = share * FRICTION_N / LOAD_N * (mindlin_N(1.0005) - mindlin_N(0.9995)) / 0.001
    assert 0.5 * (force.max() + force.min()) == pytest.approx(np.tan(np.radians(1.0)) * (LOAD_N + follows), rel=2e-3)


def test_friction_and_load_change_a_sticking_loop_by_the_law_of_jaeger() -> None:
    """Force over friction is a function of the travel's share of that of full slip, which a load raises by P^(2/3)."""
    _, amplitude_um, energy_uJ = CASES[1]
    slippery = with_effect(circumstances(1.2 * amplitude_um), "friction_offset", {"friction": 1.2 * FRICTION})
    course = simulate(ball(), slippery, CYCLES)
    assert largest(course) == pytest.approx(1.2 * 0.5 * FRICTION_N, rel=1e-3)
    assert 1e3 * course.energy_mJ == pytest.approx(1.2**2 * energy_uJ, rel=3e-3)
    heavier = simulate(ball(), circumstances(1.1 ** (2 / 3) * amplitude_um, load_factor=1.1), CYCLES)
    assert largest(heavier) == pytest.approx(1.1 * 0.5 * FRICTION_N, rel=1e-3)


def test_springs_and_play_take_their_part_of_a_stroke_and_a_held_force_needs_it() -> None:
    _, amplitude_um, energy_uJ = CASES[1]
    springs_um_per_N, play_um = 0.05, 0.4
    stroke = amplitude_um + springs_um_per_N * 0.5 * FRICTION_N + 0.5 * play_um
    played = circumstances(stroke, compliance_um_per_N=springs_um_per_N)
    played = with_effect(played, "free_play", {"gap_um": play_um})
    held = replace(played, held="tangential", held_share=0.5 * FRICTION_N / stroke)
    for one in (simulate(ball(), played, CYCLES), simulate(ball(), held, CYCLES)):
        assert largest(one) == pytest.approx(0.5 * FRICTION_N, rel=1e-3)
        assert 1e3 * one.energy_mJ == pytest.approx(energy_uJ, rel=3e-3)
        assert 0.5 * np.ptp(one.displacement_um, axis=(1, 2)) == pytest.approx(stroke, rel=1e-3)


def test_a_held_force_stays_so_beside_drives_that_hold_their_stroke() -> None:
    _, amplitude_um, _ = CASES[2]
    held = circumstances(amplitude_um, held="tangential", held_share=0.5 * FRICTION_N / amplitude_um)
    stroke = with_effect(held, "held_displacement", {"displacement_amplitude_um": amplitude_um})
    forces = [largest(one) for one in simulated(ball(), (stroke, held, stroke), CYCLES)]
    assert forces[1] == pytest.approx(0.5 * FRICTION_N, rel=1e-6)
    assert forces[0] == pytest.approx(CASES[2][0] * FRICTION_N, rel=1e-3)
    assert forces[2] == pytest.approx(forces[0], rel=1e-9)


def test_a_contact_that_sticks_slides_where_its_stroke_is_beyond_full_slip() -> None:
    course = simulate(ball(), circumstances(1.5 * FRICTION_N / STIFFNESS_N_per_um + 2.0), CYCLES)
    assert course.slip_um == pytest.approx(2.0, rel=1e-3)
    assert largest(course) == pytest.approx(FRICTION_N, rel=1e-6)


def test_a_core_that_sticks_beside_a_slider_keeps_its_bilinear_loop() -> None:
    """The annulus of a worn contact gives way a quarter of the stroke after a reversal and halves the stiffness."""
    phase = 0.5 * np.pi + 2.0 * np.pi * np.arange(400) / 400
    x, back = np.cos(phase), np.sign(np.sin(phase))
    q = back * (20.0 - 16.0 * (1.0 - back * x + np.minimum(1.0 - back * x, 0.5)))
    loop = Loop(1, phase, x, x, q, np.full(400, LOAD_N), np.linspace(3e-5, 12e-3, 400), 0.0 * x)
    run: Any = Mock(
        loops=(loop,), study={"conditions": {}}, worn_volume_mm3=np.ones(1), evolution={"cycle": np.ones(1)}
    )
    course = simulate(replace(ball(), **sticking_states(run, FRICTION, has_maps=False)), circumstances(1.0), CYCLES)
    passed, force = course.displacement_um[0, 0, :48] + 1.0, course.tangential_force_N[0, 0, :48]
    assert force == pytest.approx(16.0 * (passed + np.minimum(passed, 0.5)) - 20.0, abs=1.0)
    assert course.energy_mJ == pytest.approx(12e-3, rel=1e-2)


@pytest.mark.parametrize("order", [1.02, 1.1, 1.3])
def test_the_work_of_micro_slip_is_known_as_well_of_contacts_that_are_almost_straight(order: float) -> None:
    held = circumstances(1.0, held="tangential", held_share=0.5 * FRICTION_N)

    def gained(states: WearStates) -> float:
        less, more = (simulate(states, replace(held, micro_slip=own), CYCLES).energy_mJ[0] for own in (-0.03, 0.03))
        return float(np.log(more / less))

    assert gained(ball(order)) == pytest.approx(gained(ball()), rel=0.5)


def test_a_wider_annulus_is_worn_as_far_when_as_much_of_all_that_wears_is_gone() -> None:
    """All that wears by Ciavarella and Hills under a held approach and stroke, the sphere's radius and approach 1."""

    def worn_in_all(share: float) -> float:
        core = (1.0 - share) ** (1 / 3)

        def depth(r: float) -> float:
            angle = np.arcsin(core / r)
            return float(
                (r**2 * angle - core * np.sqrt(r**2 - core**2)) / np.pi + 1.0 - 2.0 / np.pi * angle - 0.5 * r**2
            )

        edge = brentq(depth, 1.02 * core, 3.0)
        return float(quad(lambda r: 2.0 * np.pi * r * depth(r), core, edge)[0])

    shares = np.array([0.1, 0.3, 0.5, 0.7, 0.9, 0.95])
    exact = np.array([worn_in_all(0.5) / worn_in_all(share) for share in shares])
    assert worn_as_far(shares, np.full(6, 0.5)) == pytest.approx(exact, rel=0.05)


def read_loops(course: PredictedLoops, amplitude_um: float) -> AnyRecord:
    """Two noisy readings of predicted loops, as a record of the ball."""
    asked = {"normal_load_N": LOAD_N, "displacement_amplitude_um": amplitude_um, "frequency_Hz": 10.0, "cycles": 100}
    tables = RECORDS["ball-on-flat"].model_validate({
        "format": 1, "name": "ball", "contact": {"kind": "ball-on-flat"}, "conditions": asked | {"drive": "stroke"},
        "bodies": {"ball": {"diameter_mm": 12.7, **STEEL}, "flat": STEEL}, "files": {"loops": "loops.csv"},
        "stated": {"friction": FRICTION, "tangential_stiffness_N_per_mm": 20000.0},
    })  # fmt: skip
    random, phase = np.random.default_rng(1), 2.0 * np.pi * np.arange(300) / 300
    place, rises = amplitude_um * np.sin(phase), np.cos(phase) > 0.0
    loops = []
    channels = zip(CYCLES, course.displacement_um, course.tangential_force_N, course.normal_force_N, strict=True)
    for repeat, (cycle, x, *forces) in product((1, 2), channels):
        force, load = (
            np.where(rises, np.interp(place, x[0], own[0]), np.interp(-place, -x[1], own[1])) for own in forces
        )
        noise = random.standard_normal((2, 300))
        loops.append(
            MeasuredLoop(repeat, int(cycle), phase / 62.83, place + 0.01 * noise[0], force + 0.1 * noise[1], load)
        )
    return ExperimentRecord(tables, tuple(loops))


@pytest.mark.seconds
def test_loops_that_stick_show_another_friction_at_the_ends_of_their_stroke() -> None:
    stated = circumstances(2.0, compliance_um_per_N=0.05)
    course = simulate(ball(), with_effect(stated, "friction_offset", {"friction": 0.5}), CYCLES)
    observed = reduce(read_loops(course, 2.0))
    others = all_effects().keys() - {"friction_offset", "sensor_lag", "tangential_compliance"}
    found = search(ball(), replace(stated, motion=observed.motion), observed, tuple(others))
    assert found.best.names == ("friction_offset",)
    assert found.best.log_evidence > found.none.log_evidence + 8.0
    (candidate,) = found.best.candidates
    assert candidate.values(found.best.coordinates)["friction"] == pytest.approx(0.5, rel=0.04)


@pytest.mark.parametrize("share", [0.08, 0.3])
def test_normal_forces_of_loops_that_stick_are_computed_where_they_are_measured(share: float) -> None:
    crossed = with_effect(circumstances(2.0, compliance_um_per_N=0.05), "force_crosstalk", {"coefficient": share})
    observed = reduce(read_loops(simulate(ball(), crossed, CYCLES), 2.0))
    of_load = observed.layout.marked(part for part in observed.layout if part.observable.name == "normal_direction")
    measured, computed = observed.values[:, of_load], observed.layout.computed(ball(), crossed)[0][of_load]
    assert computed.min() > 1.0
    assert measured == pytest.approx(np.broadcast_to(computed, measured.shape), abs=0.05)


def ball_record(folder: Path, conditions: dict[str, Any], *effects: dict[str, Any]) -> AnyRecord:
    """A simulated test of a ball that sticks in its middle, on another mesh than diagnoses have, read by a rig."""
    asked = {"normal_load_N": LOAD_N, "displacement_amplitude_um": 2.0, "frequency_Hz": 10.0, "cycles": 2000}
    tables = {
        "format": 1, "name": "ball", "kind": "ball-on-flat", "conditions": asked | conditions,
        "bodies": {"ball": {"diameter_mm": 12.7, **STEEL}, "flat": STEEL},
        "contact": {"friction": FRICTION}, "wear": {"energy_wear_coefficient_mm3_per_J": 2e-5},
        "holder": {"tangential_stiffness_N_per_mm": 20000.0}, "log": {"loop_cycles": [1, 30, 300, 1000, 2000]},
        "fidelity": {"quick": {"increments_per_cycle": 72, "mesh_refinement": 1.1}}, "effects": list(effects),
    }  # fmt: skip
    (run,) = run_study(study_from_tables(deepcopy(tables), "s"), fidelity="quick", output=folder)
    noise = SensorNoise(displacement_um=0.01, tangential_force_N=0.1, normal_force_N=0.1)
    return record_of_result(run, sensor=Sensor(noise=noise), repeats=2, seed=5, samples=300)


@pytest.mark.slow
def test_a_test_in_partial_slip_has_no_gap_or_its_cause(tmp_path: Path) -> None:
    assert diagnose(ball_record(tmp_path / "sound", {})).diagnosis.verdict == "no_gap"
    stiffness, key = 40000.0, "stiffness_N_per_mm"
    found = diagnose(ball_record(tmp_path / "soft", {}, {"name": "tangential_compliance", key: stiffness})).diagnosis
    assert found.verdict == "explained"
    low, high = next(one for one in found.causes if one.effect == "tangential_compliance").parameters[key].interval95
    assert low < stiffness < high


@pytest.mark.slow
def test_a_drive_that_holds_its_force_is_diagnosed(tmp_path: Path) -> None:
    held = {"held_tangential_force_N": 14.0, "displacement_amplitude_um": 6.0}
    assert diagnose(ball_record(tmp_path, held)).diagnosis.verdict == "no_gap"
