"""Patches that follow the contact's shape, meshes for a growing scar, and a study with its refinements."""

from contextlib import nullcontext
from dataclasses import replace
from itertools import pairwise
from math import hypot, pi, radians, sqrt
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from solvers import ContactState
from solvers.contact_state import WearState
from tests import synthetic_results
from tests.studies import MINIMAL
from wirewear import parse_study
from wirewear.reference import relative_curvatures
from wirewear.results import Evolution, RunResult
from wirewear.simulation import Observer, convergence, discretise
from wirewear.simulation.discretisation import unknowns
from wirewear.simulation.expected_contact import Ellipse, patch_axes, scar_ellipse
from wirewear.simulation.meshes import MeshStage, mesh_stages, spare_stages
from wirewear.simulation.point_runs import PointRun
from wirewear.test import Study
from wirewear.test.fidelity import WIRE_LEVELS

angles = st.floats(-pi, pi)


def study(
    angle_deg: float = 90.0, fixed_diameter_mm: float = 0.45, *, worn: bool = False, direction_deg: float = 0.0
) -> Study:
    text = MINIMAL.replace("[wires]", f"[wires]\ncrossing_angle_deg = {angle_deg}")
    text = text.replace("[conditions]", f"[conditions]\nmotion_angle_deg = {direction_deg}")
    text += f"[wires.fixed]\ndiameter_mm = {fixed_diameter_mm}\n"
    if worn:
        text = text.replace("cycles = 700", "cycles = 100000") + "[wear]\nenergy_wear_coefficient_mm3_per_J = 3e-5\n"
    return parse_study(text, "study")


@given(st.floats(0.01, 1.0), st.floats(0.05, 1.0), angles, angles)
def test_reach_and_chord_are_those_of_an_ellipse(major: float, flatness: float, angle: float, axis: float) -> None:
    minor = flatness * major
    ellipse = Ellipse(major, minor, angle)
    t = np.linspace(0.0, 2.0 * pi, 20_001)
    x, y = major * np.cos(t), minor * np.sin(t)
    x, y = x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle)
    assert ellipse.reach(axis) == pytest.approx((x * np.cos(axis) + y * np.sin(axis)).max(), rel=1e-6)
    end = ellipse.chord(axis) * np.array([np.cos(axis - angle), np.sin(axis - angle)])
    assert hypot(end[0] / major, end[1] / minor) == pytest.approx(1.0, rel=1e-12)
    assert minor * (1.0 - 1e-12) <= ellipse.chord(axis) <= ellipse.reach(axis) * (1.0 + 1e-12)


def test_the_scar_s_outline_holds_its_volume_under_the_gap() -> None:
    scar = scar_ellipse(1e-4, relative_curvatures(0.3, 0.2, 50.0))
    # The cap of an elliptic paraboloid has half the volume of its cylinder; its depth is that of the gap at the rim.
    gap = sqrt((0.5 / 0.3) * (0.5 / 0.2)) * np.sin(radians(50.0))
    depth = scar.major_mm * scar.minor_mm * gap
    assert 0.5 * pi * scar.major_mm * scar.minor_mm * depth == pytest.approx(1e-4)


WIRE = (0.0, 4.4)  #: Curvatures of a wire along and across [1/mm].


@given(st.floats(radians(20.0), radians(90.0)), angles, st.floats(0.001, 0.2))
def test_travel_along_both_crowns_adds_up_to_the_motion(crossing: float, direction: float, stroke: float) -> None:
    moving, fixed = patch_axes(stroke, direction, (WIRE, WIRE), crossing)
    sums = []
    for sign in (1.0, -1.0):
        x = moving.axial.travel_mm + sign * fixed.axial.travel_mm * np.cos(crossing)
        sums.append(hypot(x, fixed.axial.travel_mm * np.sin(crossing)))
    assert min(abs(total - stroke) for total in sums) < 1e-9
    assert moving.transverse.travel_mm == fixed.transverse.travel_mm == 0.0


def test_under_a_ball_the_contact_moves_on_the_flat_and_stays_on_the_ball() -> None:
    on_flat, on_ball = patch_axes(0.05, radians(30.0), ((0.0, 0.0), (0.2, 0.2)), 0.0)
    assert on_flat.axial.travel_mm == pytest.approx(0.05 * np.cos(radians(30.0)))
    assert on_flat.transverse.travel_mm == pytest.approx(0.05 * np.sin(radians(30.0)))
    assert on_ball.axial.travel_mm == on_ball.transverse.travel_mm == 0.0


@pytest.mark.parametrize(("angle_deg", "fixed_diameter_mm"), [(30.0, 0.45), (60.0, 0.45), (45.0, 0.2), (90.0, 0.9)])
def test_patches_hold_the_fresh_contact_and_resolve_its_shape(angle_deg: float, fixed_diameter_mm: float) -> None:
    plan = discretise(study(angle_deg, fixed_diameter_mm), "standard")
    hertz = plan.hertz
    contact = Ellipse(hertz.major_semi_axis_mm, hertz.minor_semi_axis_mm, hertz.major_angle_rad)
    for wire, angle in ((plan.moving, 0.0), (plan.fixed, radians(angle_deg))):
        for axis, direction in ((wire.axial, angle), (wire.transverse, angle + pi / 2)):
            assert axis.half_extent_mm >= 2.4 * contact.reach(direction) * (1.0 - 1e-9)
            assert contact.chord(direction) / axis.fine_mm == pytest.approx(WIRE_LEVELS["standard"].per_contact_radius)


def test_stages_widen_and_coarsen_with_the_scar_and_the_last_holds_the_final_one() -> None:
    long_test = study(worn=True)
    plan = discretise(long_test, "standard")
    stages = mesh_stages(long_test, "standard", plan)
    assert len(stages) > 2
    assert stages[0].fixed.axial.fine_mm == plan.fixed.axial.fine_mm
    assert stages[-1].fixed.axial.half_extent_mm >= plan.fixed.axial.half_extent_mm * (1.0 - 1e-9)
    for before, after in pairwise(stages):
        assert before.to_half_width_mm == after.from_half_width_mm
        assert after.fixed.axial.half_extent_mm > before.fixed.axial.half_extent_mm
        assert after.fixed.axial.outer_mm >= before.fixed.axial.outer_mm
        assert before.fixed.axial.half_extent_mm > 1.2 * before.to_half_width_mm
        assert before.moving.axial.half_extent_mm > before.fixed.axial.half_extent_mm
    assert all(unknowns(stage.moving) < unknowns(plan.moving) for stage in stages)


@pytest.mark.parametrize("fidelity", sorted(WIRE_LEVELS))
@pytest.mark.parametrize("fixed_diameter_mm", [0.45, 0.9])
def test_elements_are_even_along_the_motion_and_coarser_across(fidelity: str, fixed_diameter_mm: float) -> None:
    level = WIRE_LEVELS[fidelity]
    for direction in (0.0, 90.0):
        along_wire = study(90.0, fixed_diameter_mm, worn=True, direction_deg=direction)
        plan = discretise(along_wire, fidelity)
        scar, stroke = plan.expected.scar, 1e-3 * along_wire.conditions.displacement_amplitude_um
        assert scar is not None
        stage = mesh_stages(along_wire, fidelity, plan)[-1]
        mover, other = (stage.moving, stage.fixed) if direction == 0.0 else (stage.fixed, stage.moving)
        half_width = scar.reach(radians(direction))
        for along, across, edge in (
            (mover.axial, mover.transverse, half_width + stroke),
            (other.transverse, other.axial, half_width),
        ):
            lines = along.lines()
            sizes = np.diff(lines)[(lines[1:] <= edge) & (lines[:-1] >= -edge)]
            assert sizes == pytest.approx(sizes[0])
            assert lines[-1] > edge
            fresh = plan.expected.fresh.chord(radians(direction)) / level.per_contact_radius
            assert along.fine_mm == pytest.approx(max(half_width / level.along_motion, fresh))
            assert 1.8 < across.fine_mm / along.fine_mm < 6.0


def test_the_first_stage_resolves_the_fresh_contact_alike_in_all_directions() -> None:
    plan = discretise(study(worn=True), "standard")
    first = mesh_stages(study(worn=True), "standard", plan)[0]
    radius = plan.hertz.contact_radius_mm
    for wire in (first.moving, first.fixed):
        for axis in (wire.axial, wire.transverse):
            assert radius / axis.fine_mm == pytest.approx(WIRE_LEVELS["standard"].per_contact_radius)
            assert np.diff(axis.lines()).max() < 1.2 * axis.fine_mm


STICKING = MINIMAL.replace("displacement_amplitude_um = 60.0", "displacement_amplitude_um = 0.45")
WORN = "[wear]\nenergy_wear_coefficient_mm3_per_J = 3e-5\n"


@pytest.mark.parametrize("fidelity", sorted(WIRE_LEVELS))
@pytest.mark.parametrize("wear", ["", WORN])
def test_a_contact_that_sticks_in_its_middle_has_elements_that_shrink_towards_its_rim(fidelity: str, wear: str) -> None:
    level, plan = WIRE_LEVELS[fidelity], discretise(parse_study(STICKING + wear, "study"), fidelity)
    elements = round(level.to_rim_worn if wear else level.to_rim)
    rim = plan.hertz.contact_radius_mm
    for axis in (axis for wire in (plan.moving, plan.fixed) for axis in (wire.axial, wire.transverse)):
        lines = axis.half_lines()
        within = np.diff(lines[: elements + 1])
        assert lines[elements] == pytest.approx(rim)
        assert (np.diff(within) < 0.0).all()
        assert within[-1] < 0.7 * within[0] < rim / elements
        assert 1.25 * rim < lines[-1] < 1.7 * rim
    assert plan.coarsening == 1.0
    assert plan.increments_per_wear_cycle == 8


@pytest.mark.parametrize("fidelity", sorted(WIRE_LEVELS))
def test_partial_slip_under_a_changing_load_has_its_elements_and_more_increments(fidelity: str) -> None:
    """A contact that only its lowest load lets slide as a whole."""
    level = WIRE_LEVELS[fidelity]
    changing = STICKING.replace("[contact]", "load_cycle = { amplitude_share = 0.2 }\n[contact]")
    assert discretise(parse_study(changing, "study"), fidelity).increments_per_wear_cycle > 8
    hardly = STICKING.replace(
        "[contact]", "load_cycle = { amplitude_share = 0.97, frequency_ratio = 2, lag_deg = 180 }\n[contact]"
    )
    plan = discretise(parse_study(hardly, "study"), fidelity)
    assert not plan.expected.sticks
    # Of the radius to which its least load presses it, but no finer than 0.6 asks.
    radius = 0.6 * plan.hertz.contact_radius_mm
    assert plan.moving.axial.fine_mm == pytest.approx(radius / level.per_sticking_radius, rel=0.1)


def test_no_line_touches_the_rim_of_an_oblique_contact_that_sticks_in_its_middle() -> None:
    crossing = STICKING.replace("[wires]", "[wires]\ncrossing_angle_deg = 30.0")
    plan = discretise(parse_study(crossing, "study"), "quick")
    assert plan.expected.sticks
    axis = plan.moving.axial
    nearest = np.abs(axis.half_lines() - plan.expected.fresh.reach(0.0)).min()
    assert nearest > 0.1 * axis.fine_mm


@pytest.mark.parametrize(
    ("conditions", "sticks"),
    [
        ("held_tangential_force_N = 0.2", True),
        ("held_tangential_force_N = 4.0", False),
        ("held_slip_amplitude_um = 0.15", True),
        ("held_slip_amplitude_um = 10.0", False),
        ("held_energy_mJ = 1e-6", True),
        ("held_energy_mJ = 1e-2", False),
    ],
)
def test_a_held_figure_below_that_of_sliding_is_meshed_for_what_slips(conditions: str, sticks: bool) -> None:
    held = MINIMAL.replace("displacement_amplitude_um = 60.0", f"displacement_amplitude_um = 60.0\n{conditions}")
    axis = discretise(parse_study(held, "study"), "quick").fixed.axial
    assert (axis.finest_mm < 0.9 * axis.half_lines()[1]) == sticks


def test_a_drive_that_a_soft_rig_takes_up_is_meshed_for_what_slips() -> None:
    for stiffness, sticks in (("rigid", False), (50.0, True)):
        own = STICKING.replace("0.45\n", "3.0\n") + f"[holder]\ntangential_stiffness_N_per_mm = {stiffness!r}\n"
        assert discretise(parse_study(own.replace("'", '"'), "study"), "quick").expected.sticks == sticks


LOAD = "load_cycle = { amplitude_share = %s, lag_deg = %s }"


@pytest.mark.parametrize(
    ("conditions", "sticks"),
    [
        ("held_tangential_force_N = 0.8\n" + LOAD % (0.2, 0.0), True),
        ("held_tangential_force_N = 1.1\n" + LOAD % (0.2, 0.0), False),
        ("held_tangential_force_N = 1.1\n" + LOAD % (0.2, 90.0), True),
    ],
)
def test_a_load_that_changes_within_the_cycle_lets_slide_what_it_no_longer_bears(conditions: str, sticks: bool) -> None:
    varying = MINIMAL.replace("displacement_amplitude_um = 60.0", f"displacement_amplitude_um = 60.0\n{conditions}")
    assert discretise(parse_study(varying, "study"), "quick").expected.sticks == sticks


def test_friction_that_falls_within_the_test_lets_slide_what_stuck_before() -> None:
    for low, sticks in ((0.6, True), (0.25, False)):
        falls = f'[[effects]]\nname = "friction_evolution"\ninitial = {low}\nfinal = 0.7\ncycles = 100\n'
        assert discretise(parse_study(STICKING + falls, "study"), "quick").expected.sticks == sticks


BLOCKS = "".join(
    f"[[programme]]\ncycles = 10\nconditions.displacement_amplitude_um = {amplitude}\n" for amplitude in (0.45, 9.0)
)


def test_each_block_has_meshes_for_what_slips_in_it_while_the_contact_is_fresh() -> None:
    meshes = PointRun.of(parse_study(MINIMAL + BLOCKS, "study"), "quick").meshes
    assert meshes.sticking is not None
    first = meshes.first()
    assert meshes.every[first.stage] == meshes.sticking
    rim = meshes.expected.fresh.major_mm
    assert meshes.sticking.fixed.axial.half_lines()[-1] < 1.7 * rim < meshes.stages[0].moving.axial.half_extent_mm
    wear = _slid_to(meshes.stages[0], 0)
    unworn, worn, wide = (
        cast("ContactState", SimpleNamespace(wear=one))
        for one in (wear, replace(wear, primary_volume_mm3=1e-4), _slid_to(meshes.stages[0], 99))
    )
    assert meshes.fitting(first, unworn, (0.0, 10.0), True) is None
    slides = meshes.fitting(first, unworn, (10.0, 20.0), False)
    assert slides is not None
    assert meshes.every[slides.stage] == meshes.stages[0]
    sticks = meshes.fitting(slides, unworn, (20.0, 30.0), True)
    assert sticks is not None
    assert meshes.every[sticks.stage] == meshes.sticking
    assert meshes.fitting(slides, unworn, (10.0, 20.0), True) is None  # not to and fro in one block
    assert meshes.fitting(slides, worn, (20.0, 30.0), True) is None
    assert meshes.fitting(slides, wide, (20.0, 30.0), True) is None  # a scar beyond their patches, however little


def _slid_to(meshes: MeshStage, lines: int) -> WearState:
    """Wear of (held, driven) on meshes, of no volume, with energy as many lines from the middle as there are or so."""
    shapes = [(len(body.axial.lines()), len(body.transverse.lines())) for body in (meshes.fixed, meshes.moving)]
    depths = [np.zeros(shape) for shape in shapes]
    energies = [np.zeros(shape) for shape in shapes]
    for energy in energies:
        energy[min(len(energy) // 2 + lines, len(energy) - 2), energy.shape[1] // 2] = 1e-9
    return WearState(depths[0], depths[1], energies[0], energies[1])


@pytest.mark.parametrize("worn", [False, True])
def test_spare_meshes_go_on_widening_from_the_planned_ones_as_far_as_wires_hold_them(worn: bool) -> None:
    of = study(worn=worn)
    plan = discretise(of, "quick")
    last = mesh_stages(of, "quick", plan)[-1]
    spare = spare_stages(of, "quick", plan, last)
    assert spare
    for before, after in pairwise((last, *spare)):
        assert after.from_half_width_mm == pytest.approx(before.to_half_width_mm)
        assert after.fixed.axial.half_extent_mm > before.fixed.axial.half_extent_mm
        assert after.fixed.transverse.half_extent_mm <= 0.42 * 0.45


WORN = MINIMAL + "[wear]\nenergy_wear_coefficient_mm3_per_J = 3e-5\n"
RUNS = (*convergence.MESH.runs, *convergence.POSITIONS.runs, *convergence.JUMPS.runs)


def _nobody(_label: str) -> nullcontext[Observer]:
    return nullcontext(Observer())


class FakeRunner:
    """Gives every variant figures that err by known powers of its resolutions, and keeps what it was asked."""

    def __init__(self, mesh: float, positions: float, jumps: float, order: float) -> None:
        self.shares, self.order = (mesh, positions, jumps), order
        self.asked: list[tuple[str, Path, bool]] = []

    def __call__(
        self, study: Study, *, fidelity: str, output: Path, resume: bool, observer_of: object, jobs: int, engine: object
    ) -> list[RunResult]:
        assert (observer_of, jobs, engine) == (_nobody, 3, None)
        base = discretise(study.variant(convergence.BASE), fidelity)
        results = []
        for name in study.variant_names:
            plan = discretise(study.variant(name), fidelity)
            self.asked.append((name, output / name, resume))
            spacings = (
                plan.fixed.transverse.outer_mm / base.fixed.transverse.outer_mm,
                base.increments_per_wear_cycle / plan.increments_per_wear_cycle,
                (plan.jump_tolerance / base.jump_tolerance) ** 0.5,
            )
            factor = 1.0 + sum(a * h**self.order for a, h in zip(self.shares, spacings, strict=True))
            exact = synthetic_results.result(variant=name)
            columns = {key: column * (1.0 if key == "cycle" else factor) for key, column in exact.evolution.items()}
            results.append(replace(exact, evolution=Evolution(columns)))
        return results


def test_each_refinement_refines_one_resolution_and_leaves_the_others() -> None:
    study = convergence.POINTS.refined(parse_study(WORN, "s.toml"), "quick")
    plans = {name: discretise(study.variant(name), "quick") for name in study.variant_names}
    base = plans.pop(convergence.BASE)
    assert tuple(plans) == RUNS
    for factor, name in zip(convergence.MESH.factors, convergence.MESH.runs, strict=True):
        assert plans[name].fixed.transverse.fine_mm == pytest.approx(base.fixed.transverse.fine_mm / factor)
        assert plans[name].fixed.transverse.outer_mm == pytest.approx(base.fixed.transverse.outer_mm / factor)
    for factor, name in zip(convergence.POSITIONS.factors, convergence.POSITIONS.runs, strict=True):
        assert plans[name].increments_per_wear_cycle == factor * base.increments_per_wear_cycle
    for factor, name in zip(convergence.JUMPS.factors, convergence.JUMPS.runs, strict=True):
        assert plans[name].jump_tolerance == pytest.approx(base.jump_tolerance / factor**2)
    for name, plan in plans.items():
        assert plan.increments_per_cycle == base.increments_per_cycle
        assert (plan.fixed == base.fixed) == (name not in convergence.MESH.runs)
        assert (plan.increments_per_wear_cycle == base.increments_per_wear_cycle) == (
            name not in convergence.POSITIONS.runs
        )
        assert (plan.jump_tolerance == base.jump_tolerance) == (name not in convergence.JUMPS.runs)


def rows_of(runner: FakeRunner, output: Path) -> list[convergence.Converged]:
    study, subject = parse_study(WORN, "s.toml"), convergence.POINTS
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(convergence, "run_study", runner)
        return convergence.converge(study, subject, fidelity="quick", output=output, observer_of=_nobody, jobs=3)


def converged(runner: FakeRunner, output: Path) -> list[tuple[float, float, float]]:
    """Value, limit and error of every figure, over its exact value."""
    exact = synthetic_results.result()
    found = []
    for row, figure in zip(rows_of(runner, output), convergence.figures_of(("moving", "fixed")), strict=True):
        truth = figure.of(exact)
        found.append((row.value / truth, row.limit / truth, row.error / truth))
    return found


def test_figures_tend_to_what_they_would_be_without_any_error(tmp_path: Path) -> None:
    for value, limit, error in converged(FakeRunner(0.03, -0.01, 0.02, order=1.4), tmp_path):
        assert value == pytest.approx(1.04, rel=1e-9)
        assert limit == pytest.approx(1.0, rel=1e-6)
        assert 0.0 < error < 0.06


def test_an_error_that_falls_implausibly_fast_leaves_the_limit_within_its_error(tmp_path: Path) -> None:
    for value, limit, error in converged(FakeRunner(0.03, 0.01, 0.02, order=3.0), tmp_path):
        assert value == pytest.approx(1.06)
        assert abs(limit - 1.0) <= error


@given(st.floats(0.5, 2.0), st.floats(-0.5, 0.5), st.floats(1.1, 3.0), st.floats(1.1, 3.0), st.floats(0.1, 1e6))
def test_a_power_law_is_extrapolated_exactly_whatever_the_spacings(
    order: float, share: float, first: float, second: float, limit: float
) -> None:
    assume(abs(share) > 1e-3)
    spacings = [1.0, 1.0 / first, 1.0 / (first * second)]
    found = convergence.richardson(spacings, [limit * (1.0 + share * h**order) for h in spacings])
    assert found.value == pytest.approx(limit, rel=1e-6)
    assert found.order == pytest.approx(order, abs=1e-4)
    assert found.error == pytest.approx(abs(share) * limit * spacings[-1] ** order, rel=1e-3)


@pytest.mark.seconds
@given(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
def test_values_without_a_trend_are_not_extrapolated(one: float, two: float, three: float) -> None:
    assume((two - one) * (three - two) < 0.0 and max(abs(two - one), abs(three - two)) > 1e-3)
    found = convergence.richardson([1.0, 0.5, 0.25], [one, two, three])
    assert found.value == three
    assert found.order is None
    assert found.error == max(one, two, three) - min(one, two, three)
