"""The article's steel-wire test, its first loops, its wear, its findings, and the chapter on its rig."""

import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from studies.benchmarks.accuracy import rows
from studies.steel_wires.diagnose import Chapter, chapter_of, findings
from tests.diagnosis.diagnosis_cases import diagnosed, record
from wirewear import RunResult, load_study, reference, run_study

STUDY = Path(__file__).parents[2] / "studies" / "steel_wires" / "study.toml"
COMPARE = ("-m", "studies.steel_wires.compare")
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("steel_wires")


@pytest.fixture(scope="module")
def runs(folder: Path) -> dict[str, RunResult]:
    return {run.variant: run for run in run_study(load_study(STUDY), fidelity="quick", output=folder)}


def test_first_loops_enclose_the_closed_form_s_energy_and_slip(runs: dict[str, RunResult]) -> None:
    steel = reference.Elastic(210000.0, 0.3)
    hertz = reference.hertz_point(2.0, 0.225, reference.contact_modulus(steel, steel))
    contact = reference.partial_slip_point(
        2.0, 0.62, hertz.contact_radius_mm, reference.tangential_contact_modulus(steel, steel)
    )
    for variant, rig in (("compliant", 167.0), ("rigid", np.inf)):
        first = runs[variant].evolution.at(1)
        energy = reference.dissipated_energy(contact, 0.06, rig)
        slip = 1e3 * reference.slip_amplitude(contact, 0.06, rig)
        assert first["dissipated_energy_mJ"] == pytest.approx(energy, rel=0.02)
        assert first["slip_amplitude_um"] == pytest.approx(slip, rel=0.01)


def readme_quick() -> dict[str, list[str]]:
    """Numbers of the column `quick` of the README's table of accuracy, by the first words of their rows."""
    text = (STUDY.parents[2] / "README.md").read_text(encoding="utf-8")
    table = text[text.index("| | expected | quick |") :].split("\n\n")[0].splitlines()[2:]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in table]
    return {row[0]: re.findall(r"-?\d+\.?\d*", row[2].replace("−", "-")) for row in rows}


def test_the_table_of_the_readme_is_what_a_fresh_run_comes_to(runs: dict[str, RunResult]) -> None:
    run, steel = runs["compliant"], reference.Elastic(210000.0, 0.3)
    first, last = run.evolution.at(1), run.evolution.at(100_000)
    stated, settings, quality = readme_quick(), run.settings, run.quality
    assert len(stated) == 8
    hertz = reference.hertz_point(2.0, 0.225, reference.contact_modulus(steel, steel))
    contact = reference.partial_slip_point(
        2.0, 0.62, hertz.contact_radius_mm, reference.tangential_contact_modulus(steel, steel)
    )
    expected = {
        "largest pressure before wear": [
            100.0 * (float(settings["fresh_max_pressure_MPa"]) / hertz.peak_pressure_MPa - 1.0)
        ],
        "slip amplitude δ0, first loop": [
            100.0 * (first["slip_amplitude_um"] / (1e3 * reference.slip_amplitude(contact, 0.06, 167.0)) - 1.0)
        ],
        "friction energy of the first loop": [
            100.0 * (first["dissipated_energy_mJ"] / reference.dissipated_energy(contact, 0.06, 167.0) - 1.0)
        ],
        "largest difference of loop area and friction work": [100.0 * quality["loop_area_against_friction_work"]],
        "largest difference of pressures and their mirror image": [100.0 * quality["mirror_error"]],
        "after 100 000 cycles: depth of fixed, moving wire": [last["max_depth_fixed_um"], last["max_depth_moving_um"]],
        "δ0, largest tangential force": [last["slip_amplitude_um"], last["max_tangential_force_N"]],
    }
    # The approach is of bodies pressed alone, as `wirewear verify` has it.
    assert stated.keys() - expected.keys() == {"approach before wear"}
    for row, values in expected.items():
        shown = stated[row]
        decimals = [len(text.partition(".")[2]) for text in shown]
        assert [f"{value:.{n}f}" for value, n in zip(values, decimals, strict=True)] == shown, row


def test_the_page_on_accuracy_has_a_fresh_runs_errors_and_rigid_rigs_slip_too_much(runs: dict[str, RunResult]) -> None:
    page = (STUDY.parents[2] / "docs" / "accuracy.md").read_text(encoding="utf-8").splitlines()
    fresh = rows({"quick": runs["compliant"]})
    assert [row for row in fresh if not any(line.startswith(row) for line in page)] == []
    for cycle in (1, 100, 1000, 10_000, 100_000):
        rigid, compliant = (runs[name].evolution.at(cycle)["slip_amplitude_um"] for name in ("rigid", "compliant"))
        assert rigid > compliant + 7.0


def test_the_fixed_wire_s_scar_is_shorter_and_deeper_and_below_40_um(runs: dict[str, RunResult]) -> None:
    for run in runs.values():
        lengths, depths = {}, {}
        for wire in ("moving", "fixed"):
            x, depth = run.scar(100_000, wire).section_along_motion()
            lengths[wire], depths[wire] = np.ptp(x[depth > 0.05 * depth.max()]), depth.max()
        assert lengths["fixed"] < lengths["moving"]
        assert depths["moving"] < depths["fixed"] < 40.0


def test_energies_and_volumes_close(runs: dict[str, RunResult]) -> None:
    for run in runs.values():
        assert run.quality["volume_against_energy"] < 1e-6
        # What node-wise slip on the quick mesh loses of the loop's area, and what the sampled loop's corners cost.
        assert run.quality["loop_area_against_friction_work"] < 0.02


def test_the_comparison_comes_out_of_the_run(runs: dict[str, RunResult], folder: Path) -> None:
    assert runs
    done = subprocess.run(
        [sys.executable, *COMPARE, folder], cwd=STUDY.parents[2], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "A rigid rig over-predicts slip throughout" in done.stdout


@cache
def chapter(stiffness_N_per_mm: float = 167.0) -> Chapter:
    effect = {"tangential_compliance": {"stiffness_N_per_mm": stiffness_N_per_mm}}
    return chapter_of(diagnosed(record(effect, stiffness_N_per_mm="rigid")))


def test_the_spring_of_the_article_is_found_from_the_record_alone() -> None:
    assert [finding.statement for finding in findings(chapter()) if not finding.holds] == []


def test_first_loops_give_the_spring_within_its_interval_and_the_model_predicts_the_last() -> None:
    early = chapter().early_stiffness
    assert early.value == pytest.approx(167.0, rel=0.06)
    assert early.interval95[0] < 167.0 < early.interval95[1]
    slip = chapter().differences(chapter().cycles[1])["slip_amplitude_um"]
    assert slip[0] > 5.0
    assert slip[1] < 0.7
