"""Mesh lines that fit a core which sticks, so that its nodes are as stiff as it."""

import pickle
from math import acosh, pi

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from geometry import RimGradedAxis
from tests.simulation.point_contacts import STEEL
from tests.studies import WEARING, steel_wires
from wirewear import reference
from wirewear.simulation import simulate
from wirewear.simulation.cells import punch_stiffness
from wirewear.simulation.control import core_of_held_force, core_once_worn
from wirewear.simulation.core_lines import fitted_to_core, loop_error, up_to_core, wear_error
from wirewear.simulation.discretisation import discretise
from wirewear.simulation.expected_contact import Ellipse
from wirewear.simulation.meshes import core_stages
from wirewear.test import parse_study, study_from_tables
from wirewear.verification import hertz
from wirewear.verification.partial_slip import FRICTION
from wirewear.verification.partial_slip_run import held_force_shape, held_force_study, study_of


@pytest.mark.first_case
@pytest.mark.parametrize(("elements", "q", "longer"), [(8, 0.15, 1.0), (8, 0.3, 3.0), (8, 0.8, 1.5), (12, 0.2, 1.0)])
def test_as_much_wears_on_lines_fitted_to_a_core_as_closed_forms_say(elements: int, q: float, longer: float) -> None:
    """Lines that are not fitted lose up to a third of it, or wear a sixth more."""
    stuck, contact = (1.0 - q) ** (1.0 / 3.0), Ellipse(longer, 1.0, 0.0)
    lines = RimGradedAxis(longer, elements, 1.6 * longer), RimGradedAxis(1.0, elements, 1.6)
    axial, transverse = fitted_to_core(lines, contact, stuck, 0.0)
    assert wear_error((axial, transverse), contact, stuck, 0.0) == pytest.approx(0.0, abs=0.03)
    assert axial.half_extent_mm == lines[0].half_extent_mm
    assert axial.rim_mm / lines[0].rim_mm == pytest.approx(transverse.rim_mm, abs=1e-12)


@pytest.mark.parametrize(("longer", "turn"), [(1.0, 0.0), (2.5, 0.0), (2.5, 0.5)])
def test_many_nodes_wear_as_closed_forms_say(longer: float, turn: float) -> None:
    wide = longer * np.cos(turn) ** 2 + np.sin(turn) ** 2
    lines = RimGradedAxis(wide, 20, 2.2 * wide, 0.2), RimGradedAxis(1.0, 20, 2.2, 0.2)
    assert wear_error(lines, Ellipse(longer, 1.0, turn), 0.4 ** (1.0 / 3.0), 0.0) == pytest.approx(0.0, abs=0.05)


@pytest.mark.parametrize(("q", "longer", "turn"), [(0.3, 1.0, 0.0), (0.6, 3.0, 0.0), (0.8, 2.0, 0.4)])
def test_many_nodes_give_a_loop_mindlin_and_deresiewiczs_energy(q: float, longer: float, turn: float) -> None:
    contact, stuck = Ellipse(longer, 1.0, turn), (1.0 - q) ** (1.0 / 3.0)
    lines = RimGradedAxis(longer, 16, 1.3 * longer, 0.55), RimGradedAxis(1.0, 16, 1.3, 0.55)
    assert loop_error(lines, contact, stuck, 0.0) == pytest.approx(0.0, abs=0.03)


@pytest.mark.first_case
@pytest.mark.parametrize(("elements", "q"), [(12, 0.15), (8, 0.25), (8, 0.4), (10, 0.3), (12, 0.2)])
def test_loops_have_their_energy_on_lines_fitted_to_a_core(elements: int, q: float) -> None:
    """Some lines that are chosen for the core's stiffness alone lose twice the energy."""
    contact, stuck = Ellipse(1.0, 1.0, 0.0), (1.0 - q) ** (1.0 / 3.0)
    lines = fitted_to_core((RimGradedAxis(1.0, elements, 1.3, 0.6),) * 2, contact, stuck, 0.0)
    assert loop_error(lines, contact, stuck, 0.0) == pytest.approx(0.0, abs=0.1)


def test_a_punch_of_ever_smaller_cells_has_a_discs_stiffness() -> None:
    lines = np.linspace(-1.0, 1.0, 24)
    x, y = np.meshgrid(lines, lines)
    within = np.hypot(x, y) < 1.0
    sizes = np.full(within.sum(), lines[1] - lines[0])
    radius = (sizes @ sizes / pi) ** 0.5
    assert punch_stiffness(x[within], y[within], sizes, sizes) == pytest.approx(2.0 * radius / pi, rel=0.02)


@pytest.mark.slow
def test_meshes_for_a_core_go_with_the_plan_of_a_run_to_other_processes() -> None:
    study = parse_study(steel_wires("wires", amplitude_um=1.0, cycles=10) + WEARING, "study.toml")
    cores = core_stages(study, "quick", discretise(study, "quick"))
    assert cores is not None
    assert pickle.loads(pickle.dumps(cores))(0.5) == cores(0.5)


@pytest.mark.parametrize(("share", "once_worn"), [(0.3, 0.890), (0.6, 0.745), (0.8, 0.609)])
def test_a_core_under_a_held_load_and_stroke_grows_as_far_as_rings_that_wear_leave_it(
    share: float, once_worn: float
) -> None:
    """Reference: c/a within 0.001, a = 0.11819 mm, by rings worn by Archard's law that slip by Jäger's."""
    asked = {"normal_load_N": 40.0, "displacement_amplitude_um": 1.0, "frequency_Hz": 1.0, "cycles": 10}

    def grown(springs_mm_per_N: float, **conditions: float) -> float:
        tables = {
            "format": 1, "name": "ball", "kind": "ball-on-flat", "conditions": asked | conditions,
            "bodies": {"ball": {"diameter_mm": 12.7, **STEEL}, "flat": STEEL}, "contact": {"friction": 0.6},
        }  # fmt: skip
        stuck = (1.0 - share) ** (1.0 / 3.0)
        own = 1.5 * (1.0 - stuck**2) / share / 22461.5
        return core_once_worn(study_from_tables(tables, "s"), stuck, own + springs_mm_per_N)

    fresh = (1.0 - share) ** (1.0 / 3.0)
    assert grown(0.0) == pytest.approx(once_worn, abs=0.0011)
    assert grown(2.0 / 22461.5) == pytest.approx(0.5 * (grown(0.0) + fresh), abs=1e-4)
    assert grown(0.0, held_tangential_force_N=24.0 * share) == grown(0.0, approach_um=2.2) == fresh


@pytest.mark.parametrize("share", [0.05, 0.3, 0.57])
def test_under_a_held_approach_a_core_shrinks_until_the_load_that_is_left_just_bears_the_force(share: float) -> None:
    def core(**further: float) -> float:
        held = {"normal_load_N": 40.0, "held_tangential_force_N": share * FRICTION * 40.0}
        found = core_of_held_force(
            study_of({"shape": "flat"}, {"shape": "ball", "diameter_mm": 12.7}, 30.0, 1, held | further)
        )
        assert found is not None
        return found

    shrunk = core(approach_um=2.2)
    # Popov 2014: a core of radius c bears µ times 1.5 c (1 - c²) of the fresh load at its edge before it slips.
    assert 1.5 * shrunk * (1.0 - shrunk**2) == pytest.approx(share)
    assert 3.0**-0.5 < shrunk < core() == pytest.approx((1.0 - share) ** (1.0 / 3.0))


@pytest.mark.parametrize("core", [0.02, 0.3, 0.947])
def test_two_lines_lie_as_far_within_a_line_contacts_core_as_beyond_it(core: float) -> None:
    size, half = up_to_core(0.025, 2.0, core)
    lines = np.arange(round(half / size) + 1) * size
    assert size <= 0.025
    assert half >= 2.0
    assert np.diff(sorted(np.abs(lines - core))[:2])[0] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.15, 0.5, 0.9, 0.95])
def test_what_wears_of_a_line_contact_under_a_held_force_is_what_its_core_leaves_of_the_load(share: float) -> None:
    """Outside the core no pressure is left: a punch's share µP of the load, Q, and Hertz's of the core's half-width."""
    radius, load, friction, cycles = 25.0, 150.0, 0.6, 20_000
    steel = reference.Elastic(*STEEL.values())
    modulus = reference.contact_modulus(steel, steel)
    half = reference.hertz_line(load, radius, modulus).half_width_mm
    core, punch = half * (1.0 - share) ** 0.5, 2.0 * share * load / (pi * modulus)

    def depth(x: float) -> float:
        angle = acosh(x / core)
        return float(punch * angle - (x * (x**2 - core**2) ** 0.5 - core**2 * angle) / (2.0 * radius))

    area = 2.0 * quad(depth, core, brentq(depth, 1.001 * core, 20.0 * core))[0]
    tables = {
        "format": 1,
        "name": "line",
        "kind": "cylinder-on-flat",
        "pad": {"radius_mm": radius, **STEEL},
        "specimen": STEEL,
        "conditions": {
            "normal_load_N_per_mm": load,
            "displacement_amplitude_um": 30.0,
            "held_tangential_force_N_per_mm": share * friction * load,
            "cycles": cycles,
        },
        "contact": {"friction": friction},
        "wear": {"pad_energy_mm3_per_J": 1e-3, "specimen_energy_mm3_per_J": 1e-3},
        "log": {"loop_cycles": [1, cycles]},
    }
    worn = simulate(study_from_tables(tables, "s"), fidelity="quick").worn_volume_mm3
    assert float(worn[-1]) / area == pytest.approx(1.0, abs=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.2, 0.3, 0.9, 0.95])
def test_what_wears_of_a_ball_under_a_held_force_is_what_its_core_leaves_of_the_load(share: float) -> None:
    """At 0.95 the worn annulus ends at 1.8 times the fresh contact's radius, which meshes must reach. At 0.2 what slips
    at first is an element wide.
    """
    run = simulate(held_force_study(share), fidelity="quick")
    assert float(run.worn_volume_mm3[-1]) / held_force_shape(share)[1] == pytest.approx(1.0, abs=0.05)
    first, load = run.evolution, 40.0
    radius = reference.hertz_point(load, 6.35, hertz.CONTACT_MODULUS_MPa).contact_radius_mm
    slip = reference.partial_slip_point(
        load, FRICTION, radius, reference.tangential_contact_modulus(hertz.STEEL, hertz.STEEL)
    )
    exact = reference.energy_per_cycle(slip, float(first["max_tangential_force_N"][0]))
    assert float(first["dissipated_energy_mJ"][0]) == pytest.approx(exact, rel=0.05)
