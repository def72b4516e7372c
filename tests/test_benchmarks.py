"""The benchmarks' deck writer, readers and tables."""

import shutil
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from studies.benchmarks import bench_calculix
from studies.benchmarks.bench_calculix import WirewearSide, agreement, costs
from studies.benchmarks.bench_half_space import periodic_correction
from studies.benchmarks.bench_scaling import fitted_exponent
from studies.benchmarks.calculix_deck import CalculixTest, deck, element_sides, holder_node
from studies.benchmarks.calculix_results import increment_near, read_forces, read_peak_pressures
from studies.benchmarks.crossed_wires import discretised, study
from studies.benchmarks.measured_process import ProcessCost, run_measured
from wirewear.contact_problem import WireMesh, build_wire

DAT = """
 displacements (vx,vy,vz) for set HOLDER and time  0.2000000E+01

      4256  1.000000E-03  0.000000E+00 -9.200000E-04

 total force (fx,fy,fz) for set LOWERGRIP and time  0.2000000E+01

        1.240000E+00  0.000000E+00  2.000000E+00
"""
OWN = WirewearSide(8.0, 0.1, [0.1] * 10, 4700.0, 0.9, [1.0] * 10)


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


def test_a_broken_row_is_named() -> None:
    with pytest.raises(ValueError, match="line 4"):
        read_forces(DAT.replace("-9.200000E-04", "oops"))


def test_the_table_says_what_calculix_did_not_reach() -> None:
    rows = agreement(OWN, read_forces(DAT), {2.0: 4600.0})
    assert "2.17%" in rows[1]
    assert "not reached" in rows[-1]


def test_ratios_are_those_of_cpu_time_and_memory() -> None:
    rows = costs(OWN, 500.0, ProcessCost(0, 999.0, 330.0, 2000.0), 11, study_s=120.0)
    assert "300 in time an increment, 4.00 in peak memory" in rows[2]
    assert rows[3].endswith("= 0.100")


def test_costs_without_a_finished_increment_claim_no_ratio() -> None:
    rows = costs(OWN, 500.0, ProcessCost(124, 9.0, 9.0, 2000.0), 0, study_s=120.0)
    assert "no increment finished" in rows[-1]


def test_without_calculix_the_benchmark_says_how_to_get_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.argv", ["bench_calculix"])
    monkeypatch.setattr(shutil, "which", lambda _name: None)
    assert bench_calculix.main() == 0
    assert "apt-get install calculix-ccx" in capsys.readouterr().out


def test_a_process_is_measured(tmp_path: Path) -> None:
    cost = run_measured(["sh", "-c", "exit 3"], tmp_path, tmp_path / "log")
    assert cost.status == 3
    assert cost.peak_memory_MB > 0.0


def test_the_exponent_of_a_power_law_is_found() -> None:
    assert fitted_exponent([10.0, 20.0, 40.0], [1.0, 4.0, 16.0]) == pytest.approx(2.0)
    with pytest.raises(ValueError, match="two sizes"):
        fitted_exponent([10.0], [1.0])


def test_images_matter_less_on_a_larger_domain() -> None:
    assert periodic_correction(2.0, 1e5) == pytest.approx(0.5 * periodic_correction(1.0, 1e5))
