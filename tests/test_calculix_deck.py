"""The deck that CalculiX is given."""

import shutil
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from geometry import Layering, WireGeometry
from studies.benchmarks import bench_calculix
from studies.benchmarks.calculix_deck import deck, element_sides, holder_node
from studies.benchmarks.calculix_results import increment_near, read_completed, read_forces, read_peak_pressures
from studies.benchmarks.calculix_run import Completed, Completions, SlidingCost, run_calculix, sliding_cost
from studies.benchmarks.comparison_tables import PRESSED, SLIDING, StudyCost, WirewearSide, agreement, costs
from studies.benchmarks.crossed_wires import discretised, study
from studies.benchmarks.measured_process import ProcessCost, Usage
from tests.calculix_cases import DAT, STA, sliding
from wirewear import Study
from wirewear.simulation.workbench import (
    Discretisation,
    WireMesh,
    advance,
    build_wire,
    contact_problem,
    press,
    unloaded_state,
)

OWN = WirewearSide(8.0, 0.1, [0.1] * 10, [0.2] * 10, 4700.0, 0.9, [1.0] * 10, [0.01] * 10)

FAKE_CALCULIX = """#!/bin/sh
test -s wires.inp || exit 1
cat > wires.sta <<END
{sta}END
cat > wires.dat <<END
{dat}END
touch written
exec sleep 3600
"""


def test_the_table_says_what_calculix_did_not_reach() -> None:
    rows = agreement(OWN, read_forces(DAT), {2.0: 4600.0})
    assert "2.17%" in rows[1]
    assert "not reached" in rows[-1]


def test_the_table_has_calculix_forces_and_rise_where_it_came() -> None:
    later = DAT.replace("0.2000000E+01", "0.2250000E+01").replace("-9.200000E-04", "-9.100000E-04")
    rows = agreement(OWN, read_forces(DAT + later), {})
    assert rows[5].split() == ["5.00", "1.0000", "1.2400", "-19.35%", "0.0100", "0.0100", "2.0000"]
    assert "not reached" in rows[1]
    assert "not reached" in rows[6]


def test_ratios_are_those_of_cpu_time_and_memory() -> None:
    peer = ProcessCost(-9, 999.0, 700.0, 2000.0, stopped=True)
    rows = costs(OWN, 500.0, peer, SlidingCost(7, 30.0, 50.0), StudyCost("quick", 120.0, 200.0))
    table = {row.split("  ")[0]: row for row in rows}
    assert "stopped after 700 s" in rows[0]
    assert "7 of 10 sliding increments" in rows[0]
    assert " 300   reached" in table["CPU s / sliding increment"]
    assert " 250" in table["wall s / sliding increment"]
    assert " 4.00   reached" in table["peak memory [MB]"]
    assert rows[-1].endswith("study / cycle = 0.100   reached: less than 0.2")


def test_an_aim_that_was_missed_is_said_to_be() -> None:
    peer = ProcessCost(0, 99.0, 70.0, 400.0)
    rows = costs(OWN, 500.0, peer, SlidingCost(10, 3.0, 5.0), StudyCost("quick", 120.0, 200.0))
    assert sum("NOT reached" in row for row in rows) == 3


def test_costs_without_a_finished_increment_claim_no_ratio() -> None:
    (row,) = costs(OWN, 500.0, ProcessCost(-9, 9.0, 9.0, 2000.0, stopped=True), None, StudyCost("quick", 1.0, 1.0))
    assert "no sliding increment" in row


def test_without_calculix_the_benchmark_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shutil, "which", lambda _name: None)
    ended = CliRunner().invoke(bench_calculix.main, [])
    assert ended.exit_code == 0, ended.output
    assert "apt-get install calculix-ccx" in ended.stdout


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


def test_forces_are_read_with_their_times() -> None:
    (increment,) = read_forces(DAT)
    assert increment.time == 2.0
    assert increment.grip_force_N == pytest.approx([1.24, 0.0, 2.0])
    assert increment_near((increment,), 2.25) is None


def test_the_largest_contact_pressure_is_read_at_each_time() -> None:
    names = ("COPEN", "CSLIP1", "CSLIP2", "CPRESS", "CSHEAR1", "CSHEAR2")
    values = [0.0, 0.0, 0.0, 4600.0, 1.0, 9999.0]
    lines = [f"  100CL  101{2.0:12.5E}         625", " -4  CONTACT     6    1"]
    lines += [f" -5  {name:8}    1    4    1    0" for name in names]
    lines += [f" -1{7:10d}" + "".join(f"{v:12.5E}" for v in values), f" -1{8:10d}" + f"{1.0:12.5E}" * 6, " -3"]
    other = [" -4  DISP        1    1", " -5  D1          1    2    1    0", f" -1{7:10d}{9e9:12.5E}", " -3"]
    assert read_peak_pressures("\n".join(lines + other)) == {2.0: 4600.0}


def test_an_increment_cut_off_in_writing_is_left_out() -> None:
    assert read_forces(DAT.split(" total force", maxsplit=1)[0]) == ()


def test_exponents_of_three_digits_are_read() -> None:
    (increment,) = read_forces(DAT.replace(" 0.000000E+00  2.000000E+00", "-1.234567-101  2.000000E+00"))
    assert increment.grip_force_N[1] == -1.234567e-101


def test_negative_numbers_without_a_blank_between_are_read_from_frd() -> None:
    lines = ["  100CL  101" + f"{1.0:12.5E}", " -4  CONTACT     6    1", " -5  COPEN", " -5  CPRESS"]
    lines += [f" -1{7:10d}{-1.25e-2:12.5E}{-3.5:12.5E}", f" -1{8:10d}{-1.25e-2:12.5E}{4.5:12.5E}", " -3"]
    assert read_peak_pressures("\n".join(lines)) == {1.0: 4.5}


def test_empty_files_hold_nothing() -> None:
    assert (read_forces(""), read_completed(""), read_peak_pressures("")) == ((), (), {})


def test_a_broken_row_is_named() -> None:
    with pytest.raises(ValueError, match="line 4"):
        read_forces(DAT.replace("-9.200000E-04", "oops"))


def test_only_converged_increments_count_as_completed() -> None:
    assert read_completed(STA) == (1.0, 2.0, 2.0625)
    assert read_completed(STA + "     3          2     1     3  0.2250") == (1.0, 2.0, 2.0625)


def test_each_increment_is_given_what_was_used_when_it_was_reported(tmp_path: Path) -> None:
    announced = list[Completed]()
    watch = Completions(tmp_path / "wires.sta", announced.append)
    watch(Usage(1.0, 0.5, 10.0))
    lines = STA.splitlines(keepends=True)
    (tmp_path / "wires.sta").write_text("".join(lines[:3]))
    watch(Usage(9.0, 8.0, 10.0))
    (tmp_path / "wires.sta").write_text(STA)
    watch(Usage(20.0, 15.0, 10.0))
    assert watch.completed == (Completed(1.0, 9.0, 8.0), Completed(2.0, 20.0, 15.0), Completed(2.0625, 20.0, 15.0))
    assert announced == list(watch.completed)


def test_the_approach_the_load_and_the_unfinished_increment_are_not_counted() -> None:
    completed = (
        Completed(1.0, 80.0, 60.0),
        Completed(2.0, 130.0, 100.0),
        Completed(2.0625, 150.0, 120.0),
        Completed(2.25, 170.0, 140.0),
        Completed(2.5, 230.0, 160.0),
        Completed(2.6, 999.0, 900.0),
    )
    assert sliding_cost(completed, PRESSED, SLIDING) == SlidingCost(2, 30.0, 50.0)
    assert sliding_cost(completed[:3], PRESSED, SLIDING) is None


@cache
def wires() -> tuple[WireMesh, WireMesh]:
    meshes = discretised(study(25.0))
    return build_wire(meshes.moving), build_wire(meshes.fixed)


@cache
def text(rig: float | str = 167.0) -> list[str]:
    return deck(*wires(), sliding(rig)).splitlines()


def following(lines: list[str], keyword: str) -> list[str]:
    start = lines.index(keyword) + 1
    end = next(i for i in range(start, len(lines)) if lines[i].startswith("*"))
    return lines[start:end]


def test_the_deck_holds_every_node_and_hexahedron_once() -> None:
    lower, upper = wires()
    assert len(following(text(), "*NODE, NSET=ALL")) == len(lower.mesh.points) + len(upper.mesh.points)
    assert len(following(text(), "*ELEMENT, TYPE=C3D8, ELSET=WIRES")) == len(lower.mesh.cells) + len(upper.mesh.cells)


def test_upper_hexahedra_keep_their_orientation() -> None:
    rows = np.array([[float(x) for x in line.split(",")] for line in following(text(), "*NODE, NSET=ALL")])
    cells = np.array(
        [[int(x) for x in line.split(",")[1:]] for line in following(text(), "*ELEMENT, TYPE=C3D8, ELSET=WIRES")]
    )
    corner = rows[cells - 1, 1:]
    edges = corner[:, [1, 3, 4]] - corner[:, [0]]
    assert np.linalg.det(edges).min() > 0.0


def test_the_upper_grip_follows_the_holder_along_x_and_z() -> None:
    lower, upper = wires()
    holder = holder_node(lower, upper)
    grip = set((upper.mesh.surface_nodes("grip") + len(lower.mesh.points) + 1).tolist()) - {holder}
    equations = [text()[i + 2].split(",") for i, line in enumerate(text()) if line == "*EQUATION"]
    assert {(int(e[0]), int(e[1])) for e in equations} == {(node, axis) for node in grip for axis in (1, 3)}
    assert {int(e[3]) for e in equations} == {holder}


def test_a_compliant_rig_is_a_spring_and_a_rigid_one_a_support() -> None:
    assert following(text(), "*SPRING, ELSET=RIG") == ["1", "167.,0."]
    assert not any(line.startswith("*SPRING") for line in text("rigid"))
    assert text("rigid").count("HOLDER,1,1,0.") == 2


def test_contact_faces_are_those_of_the_patch() -> None:
    lower, _ = wires()
    assert len(following(text(), "*SURFACE, NAME=LOWERFACE, TYPE=ELEMENT")) == len(lower.mesh.surfaces["contact"])


def test_the_contact_pair_and_friction_are_those_asked_for() -> None:
    assert following(text(), "*CONTACT PAIR, INTERACTION=STEELONSTEEL, TYPE=LINMORTAR") == ["UPPERFACE,LOWERFACE"]
    assert following(text(), "*FRICTION") == ["0.62,1e+08"]
    penalty = deck(*wires(), replace(sliding(), method="penalty")).splitlines()
    kind = "*CONTACT PAIR, INTERACTION=STEELONSTEEL, TYPE=SURFACE TO SURFACE"
    assert following(penalty, kind) == ["UPPERFACE,LOWERFACE"]


def test_a_whole_number_of_stiffness_keeps_its_decimal_point() -> None:
    assert following(text(1e4), "*SPRING, ELSET=RIG") == ["1", "10000.,0."]
    assert following(text(2.5e12), "*SPRING, ELSET=RIG") == ["1", "2.5e+12,0."]


def test_a_step_without_increments_is_left_out() -> None:
    both, out_only = (deck(*wires(), replace(sliding(), back=back)) for back in (6, 0))
    assert both.count("*STEP") == 4
    assert out_only.count("*STEP") == 3
    assert "LOWERGRIP,1,1,-0.02" not in out_only


def test_a_facet_of_no_element_is_refused() -> None:
    with pytest.raises(ValueError, match="side of no element"):
        element_sides(np.arange(8)[None], np.array([[0, 1, 2, 6]]))
