"""Runs whose meshes change: they follow the growing scar, and take the worn surface into their nodes."""

from contextlib import nullcontext
from pathlib import Path

import pytest

from tests.simulation.coarse_runs import Killer, Recorder
from tests.studies import steel_wires
from wirewear import parse_study
from wirewear.results import RESULT_FILE_NAME, RunResult, read_result
from wirewear.simulation import run_study

ENERGY_WEAR = 1.0e-4
STUDY = f"""{steel_wires("growing scar", amplitude_um=15.0, cycles=600)}[wear]
energy_wear_coefficient_mm3_per_J = {ENERGY_WEAR}
[log]
loop_cycles = [600]
[fidelity.quick]
increments_per_cycle = 16
jump_tolerance = 0.3
mesh_refinement = 0.6
[mesh]
"""
pytestmark = pytest.mark.slow


def run(output: Path, mesh: str, observer: Recorder | None = None, *, resume: bool = False) -> RunResult:
    def observer_of(_label: str) -> nullcontext[Recorder]:
        return nullcontext(observer or Recorder())

    study = parse_study(STUDY + mesh, "growing.toml")
    (result,) = run_study(study, fidelity="quick", output=output, resume=resume, observer_of=observer_of)
    return result


@pytest.fixture(scope="module")
def following(tmp_path_factory: pytest.TempPathFactory) -> RunResult:
    return run(tmp_path_factory.mktemp("following"), "follow_scar = true")


@pytest.fixture(scope="module")
def one_mesh(tmp_path_factory: pytest.TempPathFactory) -> RunResult:
    return run(tmp_path_factory.mktemp("one"), "follow_scar = false")


def assert_agree(found: RunResult, expected: RunResult, within: float) -> None:
    names = ("max_depth_moving_um", "max_depth_fixed_um", "slip_amplitude_um", "max_tangential_force_N")
    for name in (*names, "worn_volume_moving_mm3", "worn_volume_fixed_mm3"):
        assert found.evolution[name][-1] == pytest.approx(expected.evolution[name][-1], rel=within), name


def test_meshes_that_follow_the_scar_give_the_results_of_one_mesh(following: RunResult, one_mesh: RunResult) -> None:
    assert len(following.settings["mesh_changes"]) >= 1
    assert one_mesh.settings["mesh_changes"] == []
    assert_agree(following, one_mesh, 0.02)


@pytest.mark.seconds
def test_volume_stays_alpha_times_energy_through_changes_of_the_mesh(following: RunResult) -> None:
    energy = following.evolution["accumulated_energy_J"][-1]
    for wire in ("moving", "fixed"):
        assert following.scar(600, wire).volume_mm3 == pytest.approx(0.5 * ENERGY_WEAR * energy, rel=1e-9)
    assert following.quality["volume_against_energy"] < 1e-9


def test_a_run_killed_after_a_change_of_mesh_ends_with_the_same_result(following: RunResult, tmp_path: Path) -> None:
    killer = Killer(1)
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path, "follow_scar = true", killer)
    resumed = run(tmp_path, "follow_scar = true", resume=True)
    assert resumed.settings["mesh_changes"] == following.settings["mesh_changes"]
    for name, values in following.evolution.items():
        assert (resumed.evolution[name] == values).all(), name


def test_a_soft_layer_that_spreads_the_contact_gets_meshes_that_hold_it(following: RunResult, tmp_path: Path) -> None:
    rough = '\n[[effects]]\nname = "roughness_compliance"\nlayer_um = 1.0\ncycles = 3000.0\n'
    with pytest.raises(KeyboardInterrupt):
        run(tmp_path, "follow_scar = true" + rough, Killer(1))
    settings = read_result(tmp_path / RESULT_FILE_NAME).settings
    assert settings["fresh_contact_radius_um"] > 2.0 * following.settings["fresh_contact_radius_um"]


def test_nodes_moved_at_every_mesh_stage_give_the_results_of_an_offset_while_wear_is_shallow(
    following: RunResult, tmp_path: Path
) -> None:
    moved = run(tmp_path, "follow_scar = true\nmove_nodes_at_stages = true")
    changes = moved.settings["mesh_changes"]
    stages = [change for change in changes if "half_width_um" in change]
    motions = [change for change in changes if "moved_to_um" in change]
    assert len(stages) == len(following.settings["mesh_changes"])
    # Each stage but the first moves its nodes once, when it begins.
    assert [change["cycle"] for change in motions] == [change["cycle"] for change in stages]
    assert min(change["smallest_scaled_jacobian"] for change in motions) >= 0.2
    assert_agree(moved, following, 0.02)
