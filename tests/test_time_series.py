"""Scars as VTU and PVD files."""

from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from tests.synthetic_results import result
from wirewear.results.vtk import write_time_series


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


def test_paraview_s_reader_opens_the_series(tmp_path: Path) -> None:
    pyvista = pytest.importorskip("pyvista")
    path = write_time_series(result(milestones=(10, 100)), tmp_path)[1]
    reader = pyvista.get_reader(path)
    assert list(reader.time_values) == [10.0, 100.0]
    reader.set_active_time_value(100.0)
    assert "pressure_MPa" in reader.read()[0].point_data
