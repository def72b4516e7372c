"""Normal contact of crossed wires against Hertz."""

import contextlib
import dataclasses
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.optimize import brentq, nnls

from geometry import Barrel, ContactPatch, Flat, GradedAxis, Profile, WireGeometry, build_body
from solvers.contact import ContactProblem, press, unloaded_state
from solvers.contact_conditions import ContactGuess, ContactOutcome, Linearisation
from solvers.contact_state import Holder, IncrementReport
from solvers.elasticity.condensation import CondensedBody, condense
from solvers.elasticity.placement import PlacedBody, place
from solvers.errors import SolverError
from solvers.wear import WearRates
from tests import bodies
from tests.solvers.wear_jumps import line_contact
from tests.studies import minimal
from tests.synthetic_loops import Recipe, SyntheticLoop
from tests.synthetic_results import result
from wirewear import RunResult
from wirewear.app.cli import cli
from wirewear.loops import LoopError, analyse_loop
from wirewear.loops.cleaning import OPENS
from wirewear.reference import Elastic, PointContact, contact_modulus, hertz_point
from wirewear.results import write_result
from wirewear.views.run_page import write_page

COARSE_mm, FINE_mm = 0.010, 0.007


def opening(count: int) -> np.ndarray:
    """A normal force that is zero about mid-stroke and presses towards both ends."""
    phase = 2.0 * np.pi * np.arange(count) / count
    return np.asarray(np.maximum(2.0 * np.abs(np.sin(phase)) - 0.5, 0.0))


def test_a_loop_that_opens_has_all_figures_but_coefficients_of_friction() -> None:
    _, displacement, force = SyntheticLoop(Recipe()).sampled(200)
    without = analyse_loop(displacement, force)
    opened = analyse_loop(displacement, force, opening(200))
    assert opened.friction_max is opened.friction_energy is opened.friction_geometry_independent is None
    for name in ("displacement_amplitude_um", "slip_amplitude_um", "dissipated_energy_mJ"):
        assert getattr(opened, name).value == getattr(without, name).value
    assert OPENS in opened.notes
    assert OPENS not in without.notes
    assert not any("no normal force was given" in note for note in opened.notes)
    assert any("no normal force was given" in note for note in without.notes)


@pytest.mark.first_case
@pytest.mark.seconds
@pytest.mark.parametrize("samples", [40, 16, 24, 64, 96])
def test_loops_of_contacts_that_part_within_the_stroke_are_analysed_or_refused(samples: int) -> None:
    phase = 2.0 * np.pi * np.arange(samples) / samples
    displacement = 60.0 * np.sin(phase)
    for beyond in range(0, 60, 10):
        for size in (1e-9, 1e-3, 1.0):
            touching = np.abs(displacement) > beyond
            for force in (displacement, np.sign(displacement), displacement + np.sign(np.cos(phase))):
                for one in (touching, touching & (displacement > 0.0)):
                    with contextlib.suppress(LoopError):
                        analyse_loop(displacement, np.where(one, size * force, 0.0), 1.0)


def test_bodies_that_are_apart_for_most_of_the_cycle_are_said_to_be() -> None:
    displacement = 60.0 * np.sin(2.0 * np.pi * np.arange(64) / 64)
    with pytest.raises(LoopError, match="the bodies are apart"):
        analyse_loop(displacement, 1e-3 * displacement, np.maximum(np.abs(displacement) - 50.0, 0.0))


@pytest.fixture
def run() -> RunResult:
    """The last loop has opened, and pressed for less than half of it."""
    made = dataclasses.replace(result(), study=minimal())
    *early, last = made.loops
    shut = opening(last.time_s.size)
    apart = np.where(shut > np.quantile(shut, 0.6), shut, 0.0)
    barely = np.where(apart > 0.0, 1e-5 * last.displacement_um, 0.0)
    changed = dataclasses.replace(last, normal_force_N=apart, tangential_force_N=barely)
    return dataclasses.replace(made, loops=(*early, changed))


@pytest.mark.seconds
def test_commands_on_a_run_whose_wires_part_leave_out_what_is_unknown(run: RunResult, tmp_path: Path) -> None:
    write_result(tmp_path / "run" / "result.h5", run)
    assert write_page([run], tmp_path).is_file()
    for command in (
        ["loops", "run", "--output", "loops.png"],
        ["maps", "run", "--output", "maps"],
        ["export", "run", "--as-record", "record"],
        ["check", "record"],
        ["maps", "record", "--output", "maps"],
    ):
        words = [str(tmp_path / word) if word in ("run", "record", "maps", "loops.png") and at else word
                 for at, word in enumerate(command)]  # fmt: skip
        ended = CliRunner().invoke(cli, words, catch_exceptions=False)
        # A record of such loops has problems to be reported.
        assert ended.exit_code == (1 if command[0] == "check" else 0), ended.output


@pytest.fixture(scope="module")
def hertz() -> PointContact:
    steel = Elastic(bodies.STEEL.youngs_modulus_MPa, bodies.STEEL.poissons_ratio)
    return hertz_point(bodies.LOAD_N, bodies.RADIUS_mm, contact_modulus(steel, steel))


def errors(report: IncrementReport, height_mm: float, hertz: PointContact) -> tuple[float, float]:
    return (abs(report.max_pressure / hertz.peak_pressure_MPa - 1.0), abs(-height_mm / hertz.approach_mm - 1.0))


@pytest.mark.seconds
def test_peak_pressure_and_approach_tend_to_hertz_as_the_mesh_is_refined(hertz: PointContact) -> None:
    found = []
    for fine in (COARSE_mm, FINE_mm):
        state, report = bodies.pressed(bodies.crossed_wires(fine))
        found.append(errors(report, state.holder_z, hertz))
    assert found[0][0] < 0.20
    assert found[1][0] < min(0.13, found[0][0])
    assert found[0][1] < 0.04
    assert found[1][1] < min(0.02, found[0][1])


def test_the_contact_carries_the_load_and_nothing_sideways() -> None:
    state, report = bodies.pressed(bodies.crossed_wires(FINE_mm))
    assert report.normal_force == pytest.approx(bodies.LOAD_N, rel=1e-12)
    assert abs(report.tangential_force) < 1e-9 * bodies.LOAD_N
    for force in (state.primary_force, state.secondary_force):
        assert force.sum(axis=0) == pytest.approx([0.0, 0.0, bodies.LOAD_N], abs=1e-9)
    assert report.force_error < 1e-9
    assert report.penetration < 1e-6
    assert report.complementarity < 1e-6


def test_bodies_are_pressed_from_wherever_the_holder_last_was() -> None:
    """In a cycle that opens it may have been where the bodies are apart."""
    problem = bodies.crossed_wires(FINE_mm)
    blank = unloaded_state(problem)
    heights = [press(problem, dataclasses.replace(blank, holder_z=height))[0].holder_z for height in (0.0, 0.5, -0.002)]
    assert heights == pytest.approx([heights[0]] * 3, rel=1e-6)


@pytest.mark.seconds
def test_the_contact_of_equal_crossed_wires_is_as_long_as_it_is_wide(hertz: PointContact) -> None:
    _, report = bodies.pressed(bodies.crossed_wires(FINE_mm))
    assert report.half_width_x == pytest.approx(report.half_width_y, rel=1e-4)
    # With two elements a radius.
    assert report.half_width_x == pytest.approx(hertz.major_semi_axis_mm, abs=0.1 * FINE_mm)
    assert report.contact_area == pytest.approx(np.pi * hertz.major_semi_axis_mm**2, rel=0.1)


def test_frictionless_sliding_needs_no_force_and_does_no_work() -> None:
    problem = bodies.crossed_wires(COARSE_mm, long_patch=True, friction=0.0, wear=(1e-8, 1e-8))
    state, _ = bodies.pressed(problem)
    states, reports = bodies.driven(problem, state, np.linspace(0.0, 0.05, 11), cycles=100.0)
    for piece in (piece for pieces in reports for piece in pieces):
        assert piece.friction_work == 0.0
        assert abs(piece.tangential_force) < 5e-3 * bodies.LOAD_N
        assert piece.normal_force == pytest.approx(bodies.LOAD_N, rel=1e-9)
    assert not states[-1].wear.primary_depth.any()
    assert not states[-1].wear.secondary_depth.any()


def test_a_loading_spring_unloads_by_its_stiffness_as_the_holder_descends() -> None:
    problem = bodies.crossed_wires(COARSE_mm, long_patch=True, spring_N_per_mm=50.0, wear=(1.5e-8, 1.5e-8))
    state, _ = bodies.pressed(problem)
    states, reports = bodies.driven(problem, state, np.linspace(0.005, 0.03, 6), cycles=100.0)
    descent = state.holder_z - states[-1].holder_z
    assert descent > 5e-6
    assert reports[-1][-1].normal_force == pytest.approx(bodies.LOAD_N - 50.0 * descent, rel=1e-9)
    assert problem.holder.load_N(states[-1].holder_z, states[-1].pressed_z) == pytest.approx(
        reports[-1][-1].normal_force, rel=1e-9
    )


def test_a_contact_that_reaches_the_edge_of_its_patch_is_an_error_with_the_place() -> None:
    problem = bodies.crossed_wires(COARSE_mm, rig_N_per_mm=167.0)
    state, _ = bodies.pressed(problem)
    with pytest.raises(SolverError, match=r"patch of the lower body at a displacement of \d+\.\d+ um; give a larger"):
        bodies.driven(problem, state, np.linspace(0.005, 0.06, 12))


@pytest.mark.slow
def test_a_mesh_of_4_um_meets_hertz_within_2_percent(hertz: PointContact) -> None:
    """A gripped wire is no half-space; 2 % is what its finite size and the mesh may cost."""
    fine = bodies.ELEMENTS_THAT_MEET_HERTZ_mm
    axis = GradedAxis(fine, 0.0164, 0.012, 0.04)
    meshed = build_body(WireGeometry(bodies.DIAMETER_mm, 1.0, axis, axis, 0.07))
    body = condense(meshed.mesh, meshed.patch, bodies.STEEL)
    upper, lower = place(body, upper=True, axis_angle_rad=np.pi / 2), place(body, upper=False, axis_angle_rad=0.0)
    problem = ContactProblem(upper, lower, Holder(bodies.LOAD_N), 0.62, WearRates())
    state, report = press(problem, unloaded_state(problem))
    assert report.max_pressure == pytest.approx(hertz.peak_pressure_MPa, rel=0.02)
    assert -state.holder_z == pytest.approx(hertz.approach_mm, rel=0.02)
    assert np.sqrt(report.contact_area / np.pi) == pytest.approx(hertz.major_semi_axis_mm, rel=0.02)
    assert report.half_width_x == pytest.approx(hertz.major_semi_axis_mm, abs=0.3 * fine)


class LeastSquares:
    """Contact without friction as a quadratic programme: non-negative least squares, the height by bisection."""

    def __init__(self) -> None:
        self.solved = 0

    def solve_contact(self, system: Linearisation, guess: ContactGuess, /) -> ContactOutcome:
        self.solved += 1
        count, pairing, compliance = len(guess.active), system.pairing, system.compliance
        compliance.know(np.arange(count))
        normals = pairing.frames[:, 0]
        moved = compliance.matrix.reshape(count, 3, count, 3)[:, :, compliance.place]
        stiff = pairing.areas[:, None] * np.einsum("ia,iajb,jb->ij", normals, moved, normals)
        factor = np.linalg.cholesky(0.5 * (stiff + stiff.T))

        def pressures(height: float) -> np.ndarray:
            gap = pairing.areas * normals[:, 2] * (pairing.gap + height)
            return np.asarray(nnls(factor.T, -np.linalg.solve(factor, gap))[0])

        def lacking(height: float) -> float:
            return float((pairing.areas * normals[:, 2]) @ pressures(height)) - system.holder.normal_load_N

        height = system.prescribed_height
        if height is None:
            height = float(brentq(lacking, -0.1, -float(pairing.gap.min()), xtol=1e-15))
        outcome = ContactOutcome.nothing_pressed(count, guess.holder_x, height, system.old_tilt)
        pressure = pressures(height)
        return dataclasses.replace(outcome, traction=pressure[:, None] * normals, sliding=pressure > 0.0)


def test_another_contact_algorithm_takes_the_place_of_newtons_method() -> None:
    usual = dataclasses.replace(line_contact(), friction=0.0)
    own = LeastSquares()
    answers = []
    for problem in (usual, dataclasses.replace(usual, algorithm=own)):
        state, _ = bodies.pressed(problem)
        answers.append(bodies.driven(problem, state, np.array([0.01]))[0][-1])
    newton, other = answers
    assert own.solved > 2
    assert other.holder_z == pytest.approx(newton.holder_z, rel=1e-9)
    assert np.abs(other.traction - newton.traction).max() < 1e-7 * newton.traction.max()


def test_a_loop_without_a_plateau_whose_contact_opens_is_not_said_to_be_in_partial_slip() -> None:
    phase = 2.0 * np.pi * np.arange(200) / 200
    load = np.maximum(np.cos(phase) + 0.2, 0.0)
    found = analyse_loop(50.0 * np.cos(phase), 0.5 * load * np.tanh(-20.0 * np.sin(phase)), load)
    steady = analyse_loop(50.0 * np.cos(phase), 0.5 * load * np.tanh(-20.0 * np.sin(phase)), 1.0)
    assert (found.regime, steady.regime) == ("contact opened", "partial slip")


def test_bodies_are_pressed_on_a_patch_that_is_fine_and_holds_little_beside_the_contact() -> None:
    """A first guess by a node's own compliance would press them beyond the patch."""
    radius_mm, foundation_N_per_mm3, contact_mm = 10.0, 1e5, 0.1
    lines = np.linspace(-1.4 * contact_mm, 1.4 * contact_mm, 23)

    def on_springs(profile: Profile, *, upper: bool) -> PlacedBody:
        patch = ContactPatch(lines, lines, np.arange(lines.size**2).reshape(lines.size, -1), profile)
        springs = CondensedBody.whole(patch, np.diag(0.5 / (foundation_N_per_mm3 * np.repeat(patch.node_areas(), 3))))
        return place(springs, upper=upper, axis_angle_rad=0.0)

    load = foundation_N_per_mm3 * np.pi * contact_mm**4 / (4.0 * radius_mm)
    upper, lower = on_springs(Barrel(1.0 / radius_mm, 1.0 / radius_mm), upper=True), on_springs(Flat(), upper=False)
    problem = ContactProblem(upper, lower, Holder(load), friction=0.5, wear=WearRates(0.0, 0.0))
    _, report = bodies.pressed(problem)
    # On springs pressures fall to the edge along a line, not as its root.
    assert report.contact_area == pytest.approx(np.pi * contact_mm**2, rel=0.06)
    assert report.half_width_x == pytest.approx(contact_mm, rel=0.03)
