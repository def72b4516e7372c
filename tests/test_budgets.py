"""Work that no machine holds or that never ends is refused before it begins, with the number and what would fit."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from tests.blind_batches import PlainModel
from tests.synthetic_results import result
from wirewear import RecordError, StudyError, load_study, record_of_result, run_study
from wirewear.blind import make_batch
from wirewear.cli import cli
from wirewear.errors import BlindError
from wirewear.files import budget
from wirewear.files.budget import free_disk, free_memory, size_text
from wirewear.simulation import write_meshes
from wirewear.simulation.budget import affordable_jobs, needed_memory, require_affordable
from wirewear.simulation.plan import RunPlan

STUDY = load_study(Path(__file__).parent.parent / "studies" / "steel_wires" / "study.toml").variant("rigid")

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
    monkeypatch.setattr("wirewear.blind.make.free_disk", lambda _: 1e12)
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
