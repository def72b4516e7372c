"""Wear during contact: book-keeping of energy and volume, and what a state remembers."""

import pickle

import numpy as np
import pytest

from solvers.contact import ContactProblem
from solvers.contact_state import ContactState, IncrementReport
from tests.bodies import AMPLITUDE_mm, RIG_N_per_mm, crossed_wires, driven, pressed

MESH_mm = 0.010
RATES = (1.5e-8, 0.5e-8)
CYCLES = 20.0
HALF_CYCLE = AMPLITUDE_mm * np.sin(np.pi * np.arange(1, 21) / 20)

Run = tuple[list[ContactState], list[list[IncrementReport]]]


def wearing(primary_is_upper: bool = True) -> ContactProblem:
    return crossed_wires(
        MESH_mm, long_patch=True, rig_N_per_mm=RIG_N_per_mm, wear=RATES, primary_is_upper=primary_is_upper
    )


@pytest.fixture(scope="module", params=[True, False], ids=["upper primary", "lower primary"])
def problem(request: pytest.FixtureRequest) -> ContactProblem:
    return wearing(request.param)


@pytest.fixture(scope="module")
def run(problem: ContactProblem) -> Run:
    return driven(problem, pressed(problem)[0], HALF_CYCLE, CYCLES)


def volumes(problem: ContactProblem, state: ContactState) -> tuple[float, float]:
    """Worn volumes of the upper and the lower body, mm3."""
    primary = float(problem.primary.patch.node_areas() @ state.wear.primary_depth.ravel())
    secondary = float(problem.secondary.patch.node_areas() @ state.wear.secondary_depth.ravel())
    return (primary, secondary) if problem.primary_is_upper else (secondary, primary)


@pytest.mark.seconds
def test_worn_volume_is_wear_coefficient_times_energy_on_both_bodies(problem: ContactProblem, run: Run) -> None:
    states, reports = run
    work = states[-1].wear.energy_mJ
    assert work > 0.1
    # The pressure's work on what moves along small-strain normals belongs to the drive's, and wears nothing.
    assert work == pytest.approx(CYCLES * sum(piece.friction_work for pieces in reports for piece in pieces), rel=5e-3)
    for volume, rate in zip(volumes(problem, states[-1]), RATES, strict=True):
        assert volume == pytest.approx(rate * work, rel=1e-12)


def test_energy_per_area_adds_up_to_the_energy_on_both_bodies(problem: ContactProblem, run: Run) -> None:
    wear = run[0][-1].wear
    assert problem.primary.patch.node_areas() @ wear.primary_energy.ravel() == pytest.approx(wear.energy_mJ, rel=1e-12)
    secondary = problem.secondary.patch.node_areas() @ wear.secondary_energy.ravel()
    assert secondary == pytest.approx(wear.energy_mJ, rel=1e-12)


def test_only_loaded_points_wear_and_none_grows_back(problem: ContactProblem, run: Run) -> None:
    states, reports = run
    for before, after, pieces in zip(states[:-1], states[1:], reports[1:], strict=True):
        grown = (after.wear.primary_depth - before.wear.primary_depth).ravel()
        assert grown.min() >= 0.0
        if len(pieces) == 1:
            assert not grown[(before.traction[:, 2] <= 0.0) & (after.traction[:, 2] <= 0.0)].any()
            opposite = (after.wear.secondary_depth - before.wear.secondary_depth).ravel()
            assert opposite.min() >= 0.0
            touched = before.secondary_force.any(axis=1) | after.secondary_force.any(axis=1)
            assert not opposite[~touched].any()


def test_wear_relieves_the_pressure(run: Run) -> None:
    peaks = [pieces[-1].max_pressure for pieces in run[1]]
    assert peaks[-1] < 0.97 * peaks[0]


def test_mirrored_motion_wears_the_mirror_image() -> None:
    problem = wearing()
    forth, back = (driven(problem, pressed(problem)[0], sign * HALF_CYCLE[:10], CYCLES)[0][-1] for sign in (1.0, -1.0))
    deepest = forth.wear.secondary_depth.max()
    assert back.wear.secondary_depth[::-1] == pytest.approx(forth.wear.secondary_depth, abs=1e-4 * deepest)
    assert back.wear.primary_depth[:, ::-1] == pytest.approx(forth.wear.primary_depth, abs=1e-4 * deepest)


def test_a_run_cut_in_two_equals_the_unbroken_run(problem: ContactProblem, run: Run) -> None:
    # A fresh problem chooses its windows anew, which changes the order of sums and nothing else.
    saved = pickle.loads(pickle.dumps(run[0][9]))
    resumed = driven(wearing(problem.primary_is_upper), saved, HALF_CYCLE[10:], CYCLES)[0]
    for one, other in zip(run[0][10:], resumed, strict=True):
        assert other.holder_x == pytest.approx(one.holder_x, abs=1e-12)
        assert other.holder_z == pytest.approx(one.holder_z, abs=1e-12)
        assert other.traction == pytest.approx(one.traction, abs=1e-9 * one.traction.max())
        deepest = one.wear.primary_depth.max()
        assert other.wear.primary_depth == pytest.approx(one.wear.primary_depth, abs=1e-10 * deepest)
