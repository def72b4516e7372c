"""Work that no machine holds or that never ends is refused before it begins, with the number and what would fit."""

import re
import shutil
from collections.abc import Callable
from copy import deepcopy
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from studies.blind import make_batch
from studies.blind.errors import BlindError
from tests.blind_batches import PlainModel
from tests.synthetic_results import result
from tests.test_planar_study import TABLES
from wirewear import RecordError, StudyError, load_study, record_of_result, run_study
from wirewear.base import budget
from wirewear.base.budget import free_disk, free_memory, size_text
from wirewear.faces import cli
from wirewear.fitting.sensor_loading import loaded_motions
from wirewear.planar import run_planar_study
from wirewear.planar.model import plan as plan_line
from wirewear.planar.model import require_affordable_meshes
from wirewear.planar.reading import planar_study_from_tables
from wirewear.planar.supports import write_planar_meshes
from wirewear.simulation import write_meshes
from wirewear.simulation.budget import affordable_jobs, needed_memory, require_affordable
from wirewear.simulation.plan import RunPlan
from wirewear.sweeps import load_sweep

STUDIES = Path(__file__).parent.parent / "studies"
STUDY = load_study(STUDIES / "steel_wires" / "study.toml").variant("rigid")

GB = 1e9


@pytest.fixture(autouse=True)
def memory(monkeypatch: pytest.MonkeyPatch) -> Callable[[float], None]:
    """Sets what is free; 16 GB until it is called."""
    monkeypatch.delenv(budget.MOST_MEMORY_GB, raising=False)

    def set_to(free: float) -> None:
        monkeypatch.setattr(budget, "_of_machine", lambda: free)
        monkeypatch.setattr(budget, "_of_container", lambda: free)

    set_to(16 * GB)
    return set_to


def plan(fidelity: str = "standard", **settings: float) -> RunPlan:
    return RunPlan.of(STUDY.changed({"fidelity": {fidelity: settings}}), fidelity)


def meshed(tmp_path: Path, element_um: float) -> None:
    run_study(plan(contact_mesh_um=element_um).study, output=tmp_path)


@pytest.mark.parametrize("fidelity", ["quick", "standard", "fine"])
def test_every_level_of_fidelity_fits_on_a_small_machine(memory: Callable[[float], None], fidelity: str) -> None:
    memory(4 * GB)
    require_affordable(plan(fidelity))


@pytest.mark.parametrize(("element_um", "size"), [(0.1, "15 TB"), (0.6, "43 GB")])
def test_a_mesh_that_no_memory_holds_is_refused_with_one_that_fits(
    tmp_path: Path, element_um: float, size: str
) -> None:
    """On version 8318817 the first began to fill a matrix of 46 TB, the second grew until gmsh asked for more RAM."""
    with pytest.raises(StudyError) as refused:
        meshed(tmp_path / "out", element_um)
    sentence = str(refused.value)
    assert f"nodes in a contact and {size} of memory, of which 16 GB are free: give contact_mesh_um = " in sentence
    fits = float(sentence.partition("contact_mesh_um = ")[2].split()[0])
    assert element_um < fits < 5.0
    require_affordable(plan(contact_mesh_um=1.01 * fits))
    assert not (tmp_path / "out" / "result.h5").exists()
    with pytest.raises(StudyError, match="of memory, of which 16 GB are free"):
        write_meshes(plan(contact_mesh_um=element_um).study, "standard", tmp_path)


def test_more_memory_can_be_allowed(memory: Callable[[float], None], monkeypatch: pytest.MonkeyPatch) -> None:
    memory(1e6)
    with pytest.raises(StudyError):
        require_affordable(plan())
    monkeypatch.setenv(budget.MOST_MEMORY_GB, "16")
    require_affordable(plan())
    assert free_memory() == 16 * GB


def test_the_option_allows_memory_for_its_command_alone(
    memory: Callable[[float], None], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    memory(1e6)
    seen: list[float] = []

    def written(*_: object) -> list[Path]:
        seen.append(free_memory())
        return []

    monkeypatch.setattr("wirewear.simulation.write_meshes", written)
    (tmp_path / "s.toml").write_text((Path(__file__).parent.parent / "studies/steel_wires/study.toml").read_text())
    ended = CliRunner().invoke(cli, ["mesh", str(tmp_path / "s.toml"), "--most-memory", "7", "--output", str(tmp_path)])
    assert ended.exit_code == 0, ended.output
    assert seen == [7 * GB]
    assert free_memory() == 1e6


def test_as_many_runs_side_by_side_as_fit(memory: Callable[[float], None]) -> None:
    one = plan()
    memory(2.5 * needed_memory(one))
    assert affordable_jobs([one, one, one], 8) == 2
    memory(0.1 * needed_memory(one))
    assert affordable_jobs([one], 8) == 1


def test_jumps_without_end_are_refused() -> None:
    endless = STUDY.changed(
        {
            "conditions": {"cycles": 1_000_000_000},
            "wear": {"explicit_jump_cycles": 0.01, "energy_wear_coefficient_mm3_per_J": 1e-10},
        }
    )
    with pytest.raises(StudyError) as refused:
        require_affordable(RunPlan.of(endless, "quick"))
    assert "asks for 100\u2009000\u2009000\u2009000 cycle jumps" in str(refused.value)


def test_an_export_that_no_memory_holds_is_refused() -> None:
    made = replace(result(), study=STUDY.resolved())
    with pytest.raises(RecordError, match=r"1000 repeats of \d loops are [\d\u2009]+ samples, which take .* of memory"):
        record_of_result(made, repeats=1000, samples=100_000)


def test_a_batch_that_no_disk_holds_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("studies.blind.make.free_disk", lambda _: 1e12)
    told = r"1\u2009000\u2009000\u2009000 records take 8 TB of disk .*: make at most 125\u2009000\u2009000\.$"
    with pytest.raises(BlindError, match=told):
        make_batch(tmp_path / "batch", cases=1_000_000_000, seed=1, generator=PlainModel())
    assert not (tmp_path / "batch").exists()


def test_what_is_free_is_what_the_system_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.undo()
    assert 0.0 < free_memory() < 1e15
    assert 0.0 < free_disk(tmp_path / "not" / "made" / "yet") < 1e18


@pytest.mark.parametrize(
    ("size", "text"),
    [(0.0, "0 bytes"), (999.4, "1000 bytes"), (46e12, "46 TB"), (7.377e15, "7400 TB"), (1.5e9, "1.5 GB")],
)
def test_sizes_are_told_to_two_digits(size: float, text: str) -> None:
    assert size_text(size) == text


LINE = planar_study_from_tables(deepcopy(TABLES) | {"mesh": {"contact_mesh_um": 0.2}}, "study.toml")


def run_line(output: Path) -> object:
    return run_planar_study(LINE, output=output)


def run_line_in_memory(_: Path) -> object:
    return run_planar_study(LINE)


def mesh_line(output: Path) -> object:
    return write_planar_meshes(LINE, "standard", output)


@pytest.mark.parametrize("begin", [run_line, run_line_in_memory, mesh_line])
def test_a_line_contact_that_no_memory_holds_is_refused_with_what_would_fit(
    tmp_path: Path, memory: Callable[[float], None], begin: Callable[[Path], object]
) -> None:
    memory(0.02 * GB)
    with pytest.raises(StudyError, match=r"nodes in a contact and .* of memory.*: give contact_mesh_um = "):
        begin(tmp_path / "out")
    assert not list(tmp_path.rglob("*.h5")) + list(tmp_path.rglob("*.vtu"))


def test_a_line_contact_meshed_as_coarsely_as_a_refusal_says_fits(memory: Callable[[float], None]) -> None:
    memory(0.02 * GB)
    with pytest.raises(StudyError) as refused:
        require_affordable_meshes("s", plan_line(LINE, "standard"))
    fits = float(re.findall(r"contact_mesh_um = (\S+) or more", str(refused.value))[0])
    coarse = LINE.model_copy(update={"mesh": LINE.mesh.model_copy(update={"contact_mesh_um": 1.05 * fits})})
    require_affordable_meshes("s", plan_line(coarse, "standard"))


def test_a_calibration_that_no_memory_holds_is_refused(memory: Callable[[float], None]) -> None:
    memory(16 * GB)
    with pytest.raises(StudyError, match=r"nodes in a contact and .* of memory"):
        loaded_motions(plan(contact_mesh_um=0.1).study)


@pytest.mark.parametrize(
    ("design", "runs"),
    [
        ('design = "sobol"\nsamples = 8388608\n', "33 554 432"),
        ('design = "latin-hypercube"\nsamples = 9000000\n', "9 000 000"),
        ('design = "grid"\n', "100 000 000"),
    ],
)
def test_a_sweep_of_more_runs_than_can_be_counted_is_refused(tmp_path: Path, design: str, runs: str) -> None:
    values = f"values = {list(range(1, 10_001))}\n" if "grid" in design else "low = 1.0\nhigh = 2.0\n"
    factors = "".join(f'[[vary]]\nkey = "{key}"\n{values}' for key in ("contact.friction", "conditions.normal_load_N"))
    shutil.copy(STUDIES / "rig_sensitivity" / "study.toml", tmp_path)
    path = tmp_path / "sweep.toml"
    path.write_text(f'format = 1\nname = "many"\nstudy = "study.toml"\n{design}{factors}')
    with pytest.raises(StudyError) as refused:
        load_sweep(path)
    assert f"asks for {runs} runs, where a sweep takes at most 1 000 000".replace(" ", "\u2009") in str(
        refused.value
    ).replace(" ", "\u2009")
