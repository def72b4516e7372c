"""Values of results: what they accept, and what scars and runs answer."""

import math
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from click.testing import CliRunner, Result

from tests import synthetic_results
from tests.studies import MINIMAL
from tests.synthetic_results import bowl, result
from wirewear.base.errors import ResultError
from wirewear.faces import cli
from wirewear.results import LATER_COLUMNS, Evolution, Scar
from wirewear.results.flat import write_time_series

EXAMPLE = Path("studies/steel_wires/example_records/no_gap")
VARIANTS = '[variants.rigid.holder]\ntangential_stiffness_N_per_mm = "rigid"\n'


def test_every_logged_scar_is_a_surface_that_its_pvd_file_lists_by_cycle(tmp_path: Path) -> None:
    pyvista = pytest.importorskip("pyvista")
    run = result(milestones=(100, 1_000, 100_000))
    paths = write_time_series(run, tmp_path / "vtk")
    assert [path.name for path in paths] == ["scar_moving.pvd", "scar_fixed.pvd"]
    for path, upward in zip(paths, (1.0, -1.0), strict=True):
        scars = [scar for scar in run.scars if f"scar_{scar.body}.pvd" == path.name]
        sets = ET.parse(path).getroot().findall("./Collection/DataSet")
        assert [float(item.attrib["timestep"]) for item in sets] == [scar.cycle for scar in scars]
        for item, scar in zip(sets, scars, strict=True):
            surface = pyvista.read(path.parent / item.attrib["file"])
            assert surface.n_points == scar.depth_um.size
            assert surface.point_data["depth_um"] == pytest.approx(scar.depth_um.ravel())
            assert upward * surface.points[:, 2].max() <= 1e-6 or upward < 0.0
            # The crown is where the surface is least worn or unworn: worn points lie below it.
            deepest = int(np.argmax(surface.point_data["depth_um"]))
            assert upward * surface.points[deepest, 2] <= -0.99 * scar.max_depth_um
    assert not list((tmp_path / "vtk").glob(".*"))


VARIANTS += "[variants.compliant.holder]\ntangential_stiffness_N_per_mm = 167.0\n"


def wirewear(*arguments: str | Path) -> Result:
    return CliRunner().invoke(cli, [str(argument) for argument in arguments])


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    asked: dict[str, Any] = {}

    def run_study(study: Any, **options: Any) -> list[Any]:
        asked.update(options, study=study)
        return [synthetic_results.result(variant="compliant", stiffness_N_per_mm=167.0)]

    monkeypatch.setattr("wirewear.simulation.run_study", run_study)
    return asked


@pytest.fixture
def study_file(tmp_path: Path) -> Path:
    path = tmp_path / "wires.toml"
    path.write_text(MINIMAL, encoding="utf-8")
    return path


def test_worn_volume_is_the_integral_of_the_depth() -> None:
    """A paraboloid bowl of half-axes L, B and depth h holds πLBh/2, here to 0.1 % on 241 × 201 lines."""
    scar = bowl("moving", depth_um=12.0, half_length_um=110.0, half_width_um=70.0, lines=(241, 201))
    assert scar.volume_mm3 == pytest.approx(1e-9 * math.pi * 110.0 * 70.0 * 12.0 / 2.0, rel=1e-3)


@pytest.mark.parametrize("angle", [0.0, 30.0, 60.0, 90.0, 180.0, -90.0])
def test_sampling_turns_the_wire_into_the_sliding_frame(angle: float) -> None:
    """A plane of depths, tilted along and across the wire, is tilted along the turned directions."""
    axial, transverse = np.linspace(-50.0, 50.0, 11), np.linspace(-50.0, 50.0, 11)
    depth = 300.0 + axial[:, None] + 3.0 * transverse[None, :]
    zero = np.zeros_like(depth)
    scar = Scar(1, "fixed", 0.45, angle, axial, transverse, depth, zero, zero, zero)
    x, y = np.array([-20.0, 0.0, 10.0]), np.array([-7.0, 25.0])
    a = math.radians(angle)
    along = x[:, None] * math.cos(a) + y[None, :] * math.sin(a)
    across = y[None, :] * math.cos(a) - x[:, None] * math.sin(a)
    np.testing.assert_allclose(scar.sampled(x, y), 300.0 + along + 3.0 * across, rtol=1e-12)


@pytest.mark.parametrize(("angle", "half_um"), [(0.0, 80.0), (90.0, 30.0)])
def test_section_along_motion_crosses_the_scar_at_its_middle(angle: float, half_um: float) -> None:
    """Along the motion it is the axial section, across it the transverse one: depth·(1 − (x/half)²)."""
    scar = bowl("fixed", depth_um=9.0, half_length_um=80.0, half_width_um=30.0, axis_angle_deg=angle)
    x, depth = scar.section_along_motion()
    np.testing.assert_allclose(depth, 9.0 * np.maximum(1.0 - (x / half_um) ** 2, 0.0), atol=1e-9)
    assert x[0] == pytest.approx(-1.5 * half_um)
    assert x[-1] == pytest.approx(1.5 * half_um)


def test_section_of_a_skew_wire_agrees_with_its_samples() -> None:
    """At 60° the section lies on sampled(x, 0) and stays within the grid."""
    scar = bowl("fixed", 9.0, 80.0, 30.0, axis_angle_deg=60.0)
    x, depth = scar.section_along_motion()
    np.testing.assert_allclose(depth, scar.sampled(x, np.array([0.0]))[:, 0], atol=1e-12)
    assert np.all(np.diff(x) > 0.0)
    assert abs(x).max() == pytest.approx(1.5 * 30.0 / math.sin(math.radians(60.0)))


def test_an_evolution_has_all_columns_equally_long_and_increasing_cycles() -> None:
    """Missing, unequal or unordered columns are refused."""
    columns = dict(result().evolution)
    with pytest.raises(ResultError, match=r"column\(s\) missing: cycle"):
        Evolution({name: column for name, column in columns.items() if name != "cycle"})
    with pytest.raises(ResultError, match="equally long"):
        Evolution({**columns, "jump_cycles": np.zeros(2)})
    with pytest.raises(ResultError, match="cycle must increase"):
        Evolution({**columns, "cycle": columns["cycle"][::-1]})


def test_columns_that_older_results_lack_are_unknown() -> None:
    """Files of earlier versions stay readable."""
    columns = {name: column for name, column in result().evolution.items() if name not in LATER_COLUMNS}
    evolution = Evolution(columns)
    for name in LATER_COLUMNS:
        assert np.isnan(evolution[name]).all()
        assert evolution[name].shape == evolution["cycle"].shape
