"""The fast forward model against closed forms."""

from dataclasses import replace

import numpy as np
import pytest

from studies.blind.generators.independent.friction import LAWS
from tests.diagnosis_cases import nominal, record, states, with_effect
from wirewear.diagnosis.model.branches import KNEE, MIDDLE
from wirewear.diagnosis.model.candidates import effect_of, library
from wirewear.diagnosis.model.forward import simulate
from wirewear.diagnosis.model.loop_states import FULL_SLIP, fitted_load
from wirewear.diagnosis.model.setup import Array, Setup
from wirewear.diagnosis.observe.branch import ObservedBranch
from wirewear.diagnosis.observe.evolution import loop_area
from wirewear.diagnosis.observe.local_lines import force_at
from wirewear.diagnosis.observe.reduction import reduce
from wirewear.effects import all_effects
from wirewear.views.diagnosis_values import estimates

#: µP of the first loops, before the scar lends them slopes.
FORCE_N = 1.24

FIRST = np.array([2.0])


def areas(setup: Setup, cycles: Array = FIRST) -> Array:
    course = simulate(states(), setup, cycles)
    return loop_area(course.displacement_um, course.tangential_force_N)


def test_a_spring_takes_its_share_of_the_energy() -> None:
    one, other = nominal(), replace(nominal(), compliance_um_per_N=nominal().compliance_um_per_N + 5.0)
    assert areas(one)[0] - areas(other)[0] == pytest.approx(4e-3 * 5.0 * FORCE_N**2, rel=0.02)


@pytest.mark.parametrize("softer", [0.0, 0.5, 1.0])
def test_a_softer_knee_encloses_what_the_books_say(softer: float) -> None:
    setup = replace(nominal(), compliance_um_per_N=0.0, micro_slip=softer)
    course = simulate(states(), setup, FIRST)
    assert areas(setup)[0] == pytest.approx(course.energy_mJ[0], rel=2e-3)


def test_micro_slip_of_another_order_is_that_of_iwans_spread_thresholds() -> None:
    setup = replace(nominal(), compliance_um_per_N=0.0, micro_slip=float(np.log(2.5 / FULL_SLIP)))
    course = simulate(states(), setup, FIRST)
    x, q = course.displacement_um[0, 0, : KNEE + 1], course.tangential_force_N[0, 0, : KNEE + 1]
    share, travel = (q - q[0]) / (q[-1] - q[0]), (x - x[0]) / (x[-1] - x[0])
    assert share == pytest.approx(LAWS["iwan"].share(2.5 * travel), abs=1e-6)


def test_walls_lift_the_wires_against_the_spring_that_presses_them() -> None:
    """The load at a place is that in mid-stroke and the spring's; forces follow it, both branches alike."""
    lifted = replace(states(), lift_N=np.outer(states().load_drop_N, [0.3, 0.1]))
    flat, raised = (simulate(one, nominal(), np.array([1e5])) for one in (states(), lifted))
    end = float(raised.normal_force_N[0, 0, -1] - raised.normal_force_N[0, 0, MIDDLE])
    drop = nominal().load_N - float(raised.normal_force_N[0, 0, MIDDLE])
    assert end == pytest.approx(0.4 * drop, rel=0.01)
    assert raised.normal_force_N[0, 0] == pytest.approx(raised.normal_force_N[0, 1])
    ratio = raised.normal_force_N[0, 0, KNEE:] / flat.normal_force_N[0, 0, KNEE:]
    forces = raised.tangential_force_N[0, 0, KNEE:] / flat.tangential_force_N[0, 0, KNEE:]
    assert forces == pytest.approx(ratio, rel=1e-3)


def test_a_load_along_the_stroke_is_parted_into_mid_stroke_and_lift() -> None:
    place = np.sin(np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False))
    middle, lift = fitted_load(place, 1.8 + 0.03 * place**2 - 0.01 * place**4 + 0.02 * place)
    assert middle == pytest.approx(1.8)
    assert lift == pytest.approx([0.03, -0.01])


def test_play_takes_twice_its_width_times_the_force() -> None:
    one, other = nominal(), with_effect(nominal(), "free_play", {"gap_um": 4.0})
    assert areas(one)[0] - areas(other)[0] == pytest.approx(2e-3 * 4.0 * FORCE_N, rel=0.03)


@pytest.mark.parametrize(
    "changed",
    [
        with_effect(nominal(), "displacement_load_coupling", {"linear_um_per_N": 4.0, "quadratic_um_per_N2": 0.0}),
        with_effect(nominal(), "displacement_load_coupling", {"linear_um_per_N": 0.0, "quadratic_um_per_N2": 1.0}),
        replace(nominal(), force_offset_N=0.05),
    ],
)
def test_a_reading_that_depends_on_the_force_leaves_the_area(changed: Setup) -> None:
    cycles = np.array([100.0, 1e4])
    assert areas(changed, cycles) == pytest.approx(areas(nominal(), cycles), rel=2e-3)


def test_the_worn_volume_is_the_coefficient_times_the_energy() -> None:
    cycles = np.geomspace(1.0, 1e5, 60)
    course = simulate(states(), nominal(), cycles)
    energy = np.trapezoid(np.append(course.energy_mJ[0], course.energy_mJ), np.append(0.0, cycles))
    assert course.volume_um3[-1] == pytest.approx(30.0 * energy, rel=0.01)


def test_computed_loops_are_centred_between_their_tips_as_measured_ones_are() -> None:
    leaning = {"linear_um_per_N": 0.0, "quadratic_um_per_N2": 1.0}
    misread = with_effect(nominal(), "displacement_load_coupling", leaning)
    course = simulate(states(), misread, np.array([100.0, 1e4]))
    tips = course.displacement_um.max(axis=(1, 2)), course.displacement_um.min(axis=(1, 2))
    assert tips[0] == pytest.approx(-tips[1])


def test_few_samples_are_read_beyond_the_knee_only() -> None:
    at = np.array([-60.0, -52.0, -44.0, -33.0, -22.0, -11.0, 0.0, 11.0, 22.0, 33.0])
    force = np.array([-1.2, -0.2, 1.0, 1.25, 1.25, 1.25, 1.25, 1.25, 1.25, 1.25])
    branch = ObservedBranch(1, at, force, 2)
    line = force_at(branch, -30.0, 4.0)
    assert line is not None
    assert line.value == pytest.approx(1.25)
    assert force_at(branch, -40.0, 4.0) is None


def test_the_drive_holds_the_reading_or_the_true_stroke() -> None:
    gained = with_effect(nominal("sensor"), "displacement_gain", {"gain": 1.05})
    read = simulate(states(), gained, FIRST).displacement_um
    assert 0.5 * np.ptp(read) == pytest.approx(60.0, rel=1e-3)
    read = simulate(states(), replace(gained, drive="stroke"), FIRST).displacement_um
    assert 0.5 * np.ptp(read) == pytest.approx(63.0, rel=1e-3)


def test_every_effect_of_the_library_is_known_to_the_fast_model() -> None:
    assert {effect_of(candidate.name) for candidate in library(nominal())} == {
        name for name, kind in all_effects().items() if kind.considered_for("crossed-wires")
    }


@pytest.mark.parametrize("name", ["friction_evolution", "wear_rate_evolution"])
def test_a_search_for_a_change_in_time_begins_at_small_ones_early_and_late_too(name: str) -> None:
    (candidate,) = (one for one in library(nominal()) if one.name == name)
    starts = [candidate.values(start) for start in candidate.starts()]
    first = next(iter(candidate.parameters))
    neutral = candidate.parameters[first].neutral
    assert neutral is not None
    small = [values["cycles"] for values in starts if abs(values[first] / neutral - 1.0) < 0.15]
    assert min(small) < 100.0
    assert max(small) > 10_000.0


def test_every_effect_that_loops_show_moves_an_observable() -> None:
    layout = reduce(record()).layout
    before = layout.observed(simulate(states(), nominal(), layout.cycles))
    for candidate in library(nominal()):
        changed = candidate.applied(nominal(), np.full(len(candidate.unknowns), 1.0))
        after = layout.observed(simulate(states(), changed, layout.cycles))
        moved = float(np.nanmax(np.abs(after - before)))
        assert (moved > 1e-4) == (candidate.name != "crossing_angle_error"), candidate.name


def test_the_moment_stiffness_is_as_unknown_as_the_arm_of_a_rotation() -> None:
    (rotation,) = (one for one in library(nominal()) if one.name == "rotational_compliance")
    found = estimates(rotation, np.zeros(1), np.array([0.01]), 1.0)
    stiffness, arm = (found[name].interval95 for name in ("stiffness_N_mm_per_rad", "arm_mm"))
    assert stiffness[1] / stiffness[0] == pytest.approx((arm[1] / arm[0]) ** 2, rel=0.01)
