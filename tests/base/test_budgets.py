"""Work that no machine holds or that never ends is refused before it begins, with the number and what would fit."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from tests.studies import line_study
from tests.synthetic_results import result
from wirewear import RecordError, StudyError, load_study, record_of_result, run_study
from wirewear.base import memory as budget
from wirewear.simulation import simulate, write_meshes
from wirewear.simulation.point_runs import PointRun
from wirewear.simulation.workbench import write_line_meshes

STUDIES = Path(__file__).parents[2] / "studies"
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


def plan(fidelity: str = "standard", **settings: float) -> PointRun:
    return PointRun.of(STUDY.changed({"fidelity": {fidelity: settings}}), fidelity)


def meshed(tmp_path: Path, element_um: float) -> None:
    run_study(plan(contact_mesh_um=element_um).study, output=tmp_path)


@pytest.mark.parametrize("fidelity", ["quick", "standard", "fine"])
def test_every_level_of_fidelity_fits_on_a_small_machine(memory: Callable[[float], None], fidelity: str) -> None:
    memory(4 * GB)
    plan(fidelity).require_affordable()


@pytest.mark.parametrize(("element_um", "size"), [(0.1, "15 TB"), (0.6, "43 GB")])
def test_a_mesh_that_no_memory_holds_is_refused_with_one_that_is(tmp_path: Path, element_um: float, size: str) -> None:
    """On version 8318817 the first began to fill a matrix of 46 TB, the second grew until gmsh asked for more RAM."""
    with pytest.raises(StudyError) as refused:
        meshed(tmp_path / "out", element_um)
    sentence = str(refused.value)
    assert f"nodes in a contact and {size} of memory, of which 16 GB are free: give contact_mesh_um = " in sentence
    fits = float(sentence.partition("contact_mesh_um = ")[2].split()[0])
    assert element_um < fits < 5.0
    plan(contact_mesh_um=1.01 * fits).require_affordable()
    assert not (tmp_path / "out" / "result.h5").exists()
    with pytest.raises(StudyError, match="of memory, of which 16 GB are free"):
        write_meshes(plan(contact_mesh_um=element_um).study, "standard", tmp_path)


def test_jumps_without_end_are_refused() -> None:
    endless = STUDY.changed(
        {
            "conditions": {"cycles": 1_000_000_000},
            "wear": {"explicit_jump_cycles": 0.01, "energy_wear_coefficient_mm3_per_J": 1e-10},
        }
    )
    with pytest.raises(StudyError) as refused:
        PointRun.of(endless, "quick").require_affordable()
    assert "asks for 100\u2009000\u2009000\u2009000 cycle jumps" in str(refused.value)


def test_an_export_that_no_memory_holds_is_refused() -> None:
    made = replace(result(), study=STUDY.resolved())
    with pytest.raises(RecordError, match=r"1000 repeats of \d loops are [\d\u2009]+ samples, which take .* of memory"):
        record_of_result(made, repeats=1000, samples=100_000)


LINE = line_study(conditions={"held_energy_mJ_per_mm": 0.3}, mesh={"contact_mesh_um": 0.2})


@pytest.mark.parametrize(
    "begin",
    [
        lambda output: run_study(LINE, output=output),
        lambda _: simulate(LINE),
        lambda output: write_line_meshes(LINE, "standard", output),
    ],
)
def test_a_line_contact_that_no_memory_holds_is_refused_with_what_would_fit(
    tmp_path: Path, memory: Callable[[float], None], begin: Callable[[Path], object]
) -> None:
    memory(0.02 * GB)
    with pytest.raises(StudyError, match=r"nodes in a contact and .* of memory.*: give contact_mesh_um = "):
        begin(tmp_path / "out")
    assert not list(tmp_path.rglob("*.h5")) + list(tmp_path.rglob("*.vtu"))
