"""The benchmarks' deck writer, readers and tables."""

import ast
import shutil
import sys
import time
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from geometry import Layering, WireGeometry
from studies.benchmarks import bench_calculix
from studies.benchmarks.bench_condensation import splu_schur_complement
from studies.benchmarks.bench_half_space import periodic_correction
from studies.benchmarks.bench_scaling import PARTS, Increments, SizeClass, fitted_exponent, size_classes
from studies.benchmarks.bench_scaling import table as scaling_table
from studies.benchmarks.calculix_deck import CalculixTest, deck, element_sides, holder_node
from studies.benchmarks.calculix_results import increment_near, read_completed, read_forces, read_peak_pressures
from studies.benchmarks.calculix_run import Completed, Completions, SlidingCost, run_calculix, sliding_cost
from studies.benchmarks.comparison_tables import PRESSED, SLIDING, StudyCost, WirewearSide, agreement, costs
from studies.benchmarks.crossed_wires import discretised, study
from studies.benchmarks.measured_process import ProcessCost, Usage, run_measured
from studies.benchmarks.sampled_time import SampledTime
from tests.bodies import STEEL, brick, patch_on
from wirewear import Study
from wirewear.contact_problem import (
    Discretisation,
    WireMesh,
    advance,
    build_wire,
    contact_problem,
    press,
    schur_complement,
    stiffness_matrix,
    unloaded_state,
)

DAT = """
 displacements (vx,vy,vz) for set HOLDER and time  0.2000000E+01

      4256  1.000000E-03  0.000000E+00 -9.200000E-04

 total force (fx,fy,fz) for set LOWERGRIP and time  0.2000000E+01

        1.240000E+00  0.000000E+00  2.000000E+00
"""
STA = """SUMMARY OF JOB INFORMATION
  STEP      INC     ATT  ITRS     TOT TIME     STEP TIME      INC TIME
     1          1     1     6  0.100000E+01  0.100000E+01  0.100000E+01
     2          1     1     4  0.200000E+01  0.100000E+01  0.100000E+01
     3          1     1U    9  0.225000E+01  0.250000E+00  0.250000E+00
     3          1     2     5  0.206250E+01  0.625000E-01  0.625000E-01
"""
OWN = WirewearSide(8.0, 0.1, [0.1] * 10, [0.2] * 10, 4700.0, 0.9, [1.0] * 10, [0.01] * 10)


def sliding(rig: float | str = 167.0) -> CalculixTest:
    return CalculixTest(2.0, 9e-4, 0.02, 4, 6, 0.62, "rigid" if rig == "rigid" else float(rig), 210_000.0, 0.3)


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


def test_without_calculix_the_benchmark_says_how_to_get_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.argv", ["bench_calculix"])
    monkeypatch.setattr(shutil, "which", lambda _name: None)
    assert bench_calculix.main() == 0
    assert "apt-get install calculix-ccx" in capsys.readouterr().out


FAKE_CALCULIX = """#!/bin/sh
test -s wires.inp || exit 1
cat > wires.sta <<END
{sta}END
cat > wires.dat <<END
{dat}END
sleep 60
"""


@pytest.mark.slow
def test_a_bounded_comparison_ends_with_tables_in_a_folder_given_by_a_relative_path(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    program = tmp_path / "ccx"
    program.write_text(FAKE_CALCULIX.format(sta=STA, dat=DAT))
    program.chmod(0o755)
    monkeypatch.setattr(shutil, "which", lambda _name: str(program))
    monkeypatch.chdir(tmp_path)
    options = ["--contact-mesh-um", "12", "--with-study", "none", "--most-minutes", "0.02", "--output", "here"]
    monkeypatch.setattr("sys.argv", ["bench_calculix", *options])
    assert bench_calculix.main() == 0
    table = (tmp_path / "here" / "table.txt").read_text()
    assert table in capsys.readouterr().out
    assert "not reached" in table
    assert "no sliding increment was finished" in table
    assert {path.name for path in tmp_path.iterdir()} == {"ccx", "here"}


def test_a_process_is_measured(tmp_path: Path) -> None:
    cost = run_measured(["sh", "-c", "exit 3"], tmp_path, tmp_path / "log")
    assert cost.status == 3
    assert not cost.stopped
    assert cost.peak_memory_MB > 0.0


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="memory of a running process is read from /proc")
def test_memory_is_that_of_the_program_itself_and_not_of_its_parent(tmp_path: Path) -> None:
    ballast = np.ones(2**25)
    small = run_measured(["sleep", "0.3"], tmp_path, tmp_path / "log")
    assert small.peak_memory_MB < 20.0 < ballast.nbytes / 2**20
    program = "import time; b = bytearray(b'x') * 10**8; time.sleep(0.3); del b; time.sleep(0.3)"
    large = run_measured([sys.executable, "-S", "-c", program], tmp_path, tmp_path / "log")
    assert 95.0 < large.peak_memory_MB < 140.0


def test_a_process_is_stopped_when_its_time_is_over(tmp_path: Path) -> None:
    seen = list[Usage]()
    cost = run_measured(["sleep", "60"], tmp_path, tmp_path / "log", most_s=0.3, watch=seen.append)
    assert cost.stopped
    assert cost.wall_s < 10.0
    assert len(seen) > 1


def test_the_environment_of_a_process_can_be_set(tmp_path: Path) -> None:
    run_measured(["sh", "-c", "echo $BALLAST"], tmp_path, tmp_path / "log", environment={"BALLAST": "lead"})
    assert (tmp_path / "log").read_text() == "lead\n"


def test_the_exponent_of_a_power_law_is_found() -> None:
    assert fitted_exponent([10.0, 20.0, 40.0], [1.0, 4.0, 16.0]) == pytest.approx(2.0)
    with pytest.raises(ValueError, match="two sizes"):
        fitted_exponent([10.0], [1.0])


def test_images_matter_less_on_a_larger_domain() -> None:
    assert periodic_correction(2.0, 1e5) == pytest.approx(0.5 * periodic_correction(1.0, 1e5))


def test_time_goes_to_the_innermost_named_function() -> None:
    sampled = SampledTime({"outer": ((__file__, "outer_work"),), "inner": ((__file__, "inner_work"),)})
    with sampled:
        outer_work(0.2)
    seconds = sampled.seconds
    assert seconds["inner"] == pytest.approx(0.4, abs=0.1)
    assert seconds["outer"] == pytest.approx(0.2, abs=0.1)
    assert seconds["rest"] < 0.05


def outer_work(cpu_s: float) -> None:
    spin(cpu_s)
    inner_work(2.0 * cpu_s)


def inner_work(cpu_s: float) -> None:
    spin(cpu_s)


def spin(cpu_s: float) -> None:
    end = time.process_time() + cpu_s
    while time.process_time() < end:
        pass


def test_the_parts_of_a_run_are_functions_that_exist() -> None:
    for functions in PARTS.values():
        for file, name in functions:
            tree = ast.parse((bench_calculix.REPOSITORY / file).read_text(encoding="utf-8"))
            assert name in {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}


def test_increments_are_averaged_over_classes_of_doubled_size() -> None:
    increments = Increments(
        np.array([8.0] * 10 + [12.0] * 10 + [40.0] * 3), np.array([1.0] * 10 + [2.0] * 10 + [9.0] * 3)
    )
    assert size_classes(increments) == [SizeClass(20, 10.0, 1.5)]


def test_the_table_of_scaling_ends_with_the_exponent() -> None:
    rows = scaling_table([SizeClass(20, 10.0, 0.001), SizeClass(20, 20.0, 0.002), SizeClass(20, 40.0, 0.008)])
    assert rows[-2].endswith("power 1.50 (all)")
    assert rows[-1].endswith("power 2.00 (the larger half)")


def test_splu_and_nested_substructures_give_the_same_schur_complement() -> None:
    mesh = brick((6, 5, 4), (1.0, 0.9, 0.7), distortion=0.2)
    kept = patch_on(mesh).nodes.ravel()
    eliminated = np.setdiff1d(np.arange(len(mesh.points)), np.union1d(kept, mesh.surface_nodes("grip")))
    matrix = stiffness_matrix(mesh, STEEL)
    direct = splu_schur_complement(matrix, kept, eliminated, 3)
    assert direct == pytest.approx(schur_complement(matrix, kept, eliminated, 3), abs=1e-12 * np.abs(direct).max())


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
