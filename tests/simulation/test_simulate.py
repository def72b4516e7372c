"""Whole runs on a coarse mesh: what they leave, how they are interrupted and resumed, what they refuse."""

from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests import synthetic_results
from tests.simulation.coarse_runs import COARSE, VARIANTS, Recorder, coarse
from wirewear import Study, parse_study
from wirewear.results import RESULT_FILE_NAME, RunResult, write_result
from wirewear.simulation import run_study
from wirewear.simulation.point_runs import PointRun
from wirewear.simulation.store import CHECKPOINT_FILE_NAME

pytestmark = pytest.mark.seconds


def run(
    output: Path, observer: Recorder | None = None, *, resume: bool = False, study: Study | None = None
) -> RunResult:
    def observer_of(label: str) -> AbstractContextManager[Recorder]:
        assert label == "coarse wires"
        return nullcontext(observer or Recorder())

    (result,) = run_study(study or coarse(), fidelity="quick", output=output, resume=resume, observer_of=observer_of)
    return result


@pytest.fixture(scope="module")
def unbroken(tmp_path_factory: pytest.TempPathFactory) -> RunResult:
    return run(tmp_path_factory.mktemp("unbroken"))


def test_a_run_logs_the_asked_cycles_and_leaves_no_checkpoint(unbroken: RunResult) -> None:
    assert unbroken.status == "complete"
    assert [loop.cycle for loop in unbroken.loops] == [1, 100, 300]
    assert unbroken.scar_cycles() == (1, 100, 300)
    # Wires are straight along their axes.
    assert {scar.diameter_along_mm for scar in unbroken.scars} == {np.inf}
    assert unbroken.path is not None
    assert not (unbroken.path.parent / CHECKPOINT_FILE_NAME).exists()


def test_wires_wear_by_their_shares_of_the_energy_and_their_descent_relaxes_the_spring(unbroken: RunResult) -> None:
    energy = unbroken.evolution["accumulated_energy_J"][-1]
    assert unbroken.scar(300, "moving").volume_mm3 == pytest.approx(0.3 * 3.0e-5 * energy, rel=1e-6)
    assert unbroken.scar(300, "fixed").volume_mm3 == pytest.approx(0.7 * 3.0e-5 * energy, rel=1e-6)
    assert unbroken.quality["volume_against_energy"] < 1e-6
    last = unbroken.loops[-1].normal_force_N
    descent_mm = 1e-3 * (unbroken.evolution["max_depth_moving_um"][-1] + unbroken.evolution["max_depth_fixed_um"][-1])
    assert 2.0 - 2.0 * descent_mm < last.mean() < 2.0


def test_every_increment_is_solved_within_tolerance(unbroken: RunResult) -> None:
    assert unbroken.quality["force_balance"] < 1e-9
    assert unbroken.quality["penetration"] < 1e-5
    # Friction's direction is settled to 1e-4; that of a slip next to nothing, at nodes about to stick, is less certain.
    assert unbroken.quality["slip_direction_error_rad"] < 1e-2


@pytest.mark.slow
def test_variants_run_side_by_side_give_the_same_results_as_one_after_the_other(tmp_path: Path) -> None:
    study = parse_study(
        COARSE.replace("cycles = 300", "cycles = 20").replace("[1, 100, 300]", "[1, 20]") + VARIANTS, "x"
    )
    recorders = {"compliant": Recorder(), "rigid": Recorder()}
    alone = run_study(study, fidelity="quick", output=tmp_path / "alone")
    together = run_study(
        study, fidelity="quick", output=tmp_path / "together", observer_of=lambda label: nullcontext(recorders[label]),
        jobs=2,
    )  # fmt: skip
    for mine, theirs in zip(together, alone, strict=True):
        assert mine.variant == theirs.variant
        for name, column in theirs.evolution.items():
            np.testing.assert_array_equal(mine.evolution[name], column, err_msg=name)
    assert all(recorder.moments and recorder.logged_runs for recorder in recorders.values())


def leave_complete_runs(study: Study, output: Path, *names: str) -> None:
    """Result files as the complete runs of these variants leave them, with figures of their own."""
    for name in names:
        result = synthetic_results.result(variant=name)
        identity = PointRun.of(study.variant(name), "quick").identity
        write_result(
            output / name / RESULT_FILE_NAME, replace(result, settings={**result.settings, "identity": str(identity)})
        )


@pytest.fixture
def without_wires(monkeypatch: pytest.MonkeyPatch) -> None:
    def forbidden(*_: object) -> None:
        raise AssertionError("a wire was condensed or loaded")

    monkeypatch.setattr("wirewear.simulation.problem.condensed_body", forbidden)


@pytest.mark.parametrize("jobs", [1, 2])
def test_complete_runs_are_read_from_files_without_wires(tmp_path: Path, without_wires: None, jobs: int) -> None:
    study = coarse(COARSE + VARIANTS)
    leave_complete_runs(study, tmp_path, "compliant", "rigid")
    results = run_study(study, fidelity="quick", output=tmp_path, resume=True, jobs=jobs)
    assert [result.variant for result in results] == ["compliant", "rigid"]
    assert all(result.status == "complete" for result in results)


def test_a_run_keeps_the_contact_forces_of_its_logged_cycles(unbroken: RunResult) -> None:
    assert [(forces.cycle, forces.body) for forces in unbroken.contact_forces] == [
        (cycle, wire) for cycle in (1, 100, 300) for wire in ("moving", "fixed")
    ]
    for moving, fixed in zip(unbroken.contact_forces[::2], unbroken.contact_forces[1::2], strict=True):
        assert 16 <= len(fixed.phase) <= 24
        named = {name: fixed.drive_um[k] for name, k in fixed.named().items()}
        assert named["end-forward"] == -named["end-back"] == fixed.drive_um.max()
        assert named["mid-forward"] == named["mid-back"] == 0.0
        assert 0.0 < named["end-forward"] - named["after-end-forward"] < 0.1 * named["end-forward"]
        # The wires cross at right angles: the fixed one's own transverse axis is the direction of motion.
        # Tractions are turned back by the bodies' own slopes, up to a/2R.
        np.testing.assert_allclose(fixed.force_N[..., 1].sum(axis=1), fixed.tangential_force_N, rtol=0.0, atol=6e-3)
        np.testing.assert_allclose(moving.force_N[..., 0].sum(axis=1), -fixed.tangential_force_N, rtol=0.0, atol=6e-3)
        np.testing.assert_allclose(
            moving.force_N[..., 2].sum(axis=1), fixed.force_N[..., 2].sum(axis=1), rtol=0.0, atol=6e-3
        )
