"""The deck that CalculiX is given."""

import shutil
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

from geometry import Layering, WireGeometry
from studies.benchmarks import bench_calculix
from studies.benchmarks.calculix_deck import deck
from studies.benchmarks.calculix_results import read_forces, read_peak_pressures
from studies.benchmarks.calculix_run import run_calculix
from studies.benchmarks.crossed_wires import discretised, study
from tests.calculix_cases import sliding
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


def test_the_largest_contact_pressure_is_read_at_each_time() -> None:
    names = ("COPEN", "CSLIP1", "CSLIP2", "CPRESS", "CSHEAR1", "CSHEAR2")
    values = [0.0, 0.0, 0.0, 4600.0, 1.0, 9999.0]
    lines = [f"  100CL  101{2.0:12.5E}         625", " -4  CONTACT     6    1"]
    lines += [f" -5  {name:8}    1    4    1    0" for name in names]
    lines += [f" -1{7:10d}" + "".join(f"{v:12.5E}" for v in values), f" -1{8:10d}" + f"{1.0:12.5E}" * 6, " -3"]
    other = [" -4  DISP        1    1", " -5  D1          1    2    1    0", f" -1{7:10d}{9e9:12.5E}", " -3"]
    assert read_peak_pressures("\n".join(lines + other)) == {2.0: 4600.0}


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


def test_contact_faces_are_those_of_the_patch() -> None:
    lower, _ = wires()
    assert len(following(text(), "*SURFACE, NAME=LOWERFACE, TYPE=ELEMENT")) == len(lower.mesh.surfaces["contact"])


def test_the_contact_pair_and_friction_are_those_asked_for() -> None:
    assert following(text(), "*CONTACT PAIR, INTERACTION=STEELONSTEEL, TYPE=LINMORTAR") == ["UPPERFACE,LOWERFACE"]
    assert following(text(), "*FRICTION") == ["0.62,1e+08"]
    penalty = deck(*wires(), replace(sliding(), method="penalty")).splitlines()
    kind = "*CONTACT PAIR, INTERACTION=STEELONSTEEL, TYPE=SURFACE TO SURFACE"
    assert following(penalty, kind) == ["UPPERFACE,LOWERFACE"]
