"""The benchmark against CalculiX as a whole: without it, with a stand-in, and with it."""

import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from geometry import Layering, WireGeometry
from studies.benchmarks import bench_calculix
from studies.benchmarks.calculix_results import read_forces
from studies.benchmarks.calculix_run import run_calculix
from studies.benchmarks.crossed_wires import discretised, study
from tests.calculix_cases import DAT, STA
from wirewear import Study
from wirewear.simulation.workbench import (
    Discretisation,
    advance,
    contact_problem,
    press,
    unloaded_state,
)


def test_without_calculix_the_benchmark_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shutil, "which", lambda _name: None)
    ended = CliRunner().invoke(bench_calculix.main, [])
    assert ended.exit_code == 0, ended.output
    assert "apt-get install calculix-ccx" in ended.stdout


FAKE_CALCULIX = """#!/bin/sh
test -s wires.inp || exit 1
cat > wires.sta <<END
{sta}END
cat > wires.dat <<END
{dat}END
touch written
exec sleep 3600
"""


@pytest.mark.slow
def test_a_bounded_comparison_ends_with_tables_in_a_folder_given_by_a_relative_path(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = tmp_path / "ccx"
    program.write_text(FAKE_CALCULIX.format(sta=STA, dat=DAT))
    program.chmod(0o755)
    monkeypatch.setattr(shutil, "which", lambda _name: str(program))
    monkeypatch.chdir(tmp_path)
    # The minute is over as soon as everything is written, however busy the machine is.
    monkeypatch.setattr(
        "studies.benchmarks.measured_process.time.perf_counter",
        lambda: 1e3 * (tmp_path / "here" / "written").exists(),
    )
    options = ["--contact-mesh-um", "12", "--with-study", "none", "--most-minutes", "1", "--output", "here"]
    ended = CliRunner().invoke(bench_calculix.main, options)
    assert ended.exit_code == 0, ended.output
    table = (tmp_path / "here" / "table.txt").read_text()
    assert table in ended.stdout
    assert "not reached" in table
    assert "no sliding increment was finished" in table
    assert {path.name for path in tmp_path.iterdir()} == {"ccx", "here"}


def tiny_test() -> tuple[Study, Discretisation]:
    """Few elements: a contact of 42 um on 20 um facets of short wires."""
    of = study(20.0, "rigid", normal_load_N=50.0, amplitude_um=10.0)
    meshes = discretised(of)

    def short(wire: WireGeometry) -> WireGeometry:
        return replace(wire, coarse_mm=0.4, length_mm=0.35, layering=Layering(count=2, growth=2.0, first=1.0))

    return of, replace(meshes, moving=short(meshes.moving), fixed=short(meshes.fixed))


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX is not installed")
def test_calculix_runs_the_deck_and_agrees(tmp_path: Path) -> None:
    of, meshes = tiny_test()
    bench_calculix.write_deck(tmp_path, of, meshes, "linmortar", (1, 0))
    run = run_calculix(str(shutil.which("ccx")), tmp_path, most_s=3600.0)
    assert run.cost.status == 0
    assert [one.time for one in run.completed] == [1.0, 2.0, 3.0]
    _, pressed, slid = read_forces((tmp_path / "wires.dat").read_text())
    problem = contact_problem(of, meshes, lambda _stage: None)
    state, report = press(problem, unloaded_state(problem))
    _, reports = advance(problem, state, 0.01, 0.0)
    assert pressed.grip_force_N[2] == pytest.approx(50.0, rel=1e-4)
    assert -pressed.holder_mm[2] == pytest.approx(-state.holder_z, rel=0.04)
    assert report.normal_force == pytest.approx(50.0, rel=1e-6)
    assert slid.grip_force_N[2] == pytest.approx(50.0, rel=1e-4)
    assert slid.grip_force_N[0] == pytest.approx(reports[-1].tangential_force, rel=0.02)
