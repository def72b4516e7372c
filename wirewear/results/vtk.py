"""Scars as a time series for ParaView: one VTU file a body and logged cycle, one PVD file a body that lists them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree as ET

import numpy as np
from numpy.typing import NDArray

from wirewear.base.errors import ResultError
from wirewear.base.writing import in_one_step, write_bytes, writing
from wirewear.results.scar import FIELD_COLUMNS, Scar
from wirewear.results.values import RunResult

if TYPE_CHECKING:
    import pyvista

FOLDER_NAME = "vtk"
#: Patterns of the files, relative to the run's folder.
TIME_SERIES_FILES = tuple(f"{FOLDER_NAME}/scar_*{ending}" for ending in (".vtu", ".pvd"))


def write_time_series(result: RunResult, folder: Path) -> list[Path]:
    """Write the scars of a run as `scar_<body>_<cycle>.vtu` and `scar_<body>.pvd`; returns the PVD files.

    Points are the worn surface in micrometres, x along the motion and z from the driven to the held body; the fields
    at points are depth, friction energy per area, pressure and slip distance. The time of a PVD file is the cycle.
    What an earlier run has left there goes.

    Raises:
        ResultError: the folder cannot be written.
    """
    with writing(ResultError, f"cannot write the time series to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        written = [_series(folder, result, body) for body in result.bodies]
        of_this_run = {_surface_file(scar) for scar in result.scars}
        for path in folder.glob("scar_*.vtu"):
            if path.name not in of_this_run:
                path.unlink()
        return written


def _series(folder: Path, result: RunResult, body: str) -> Path:
    root = ET.Element("VTKFile", type="Collection", version="0.1", byte_order="LittleEndian")
    collection = ET.SubElement(root, "Collection")
    for scar in result.scars_of(body):
        name = _surface_file(scar)
        _write_surface(folder / name, scar, upper=result.is_upper(body))
        ET.SubElement(collection, "DataSet", timestep=str(scar.cycle), group="", part="0", file=name)
    ET.indent(root)
    return write_bytes(folder / f"scar_{body}.pvd", ET.tostring(root, xml_declaration=True, encoding="utf-8"))


def _surface_file(scar: Scar) -> str:
    return f"scar_{scar.body}_{scar.cycle:07d}.vtu"


def worn_points(scar: Scar, *, upper: bool) -> NDArray[np.float64]:
    """Points of the worn surface (n_a, n_t, 3) [µm]: x along the motion, z from the driven to the held, upper body."""
    axial, transverse = np.meshgrid(scar.axial_um, scar.transverse_um, indexing="ij")
    x, y = scar.sliding_coordinates(axial, transverse)
    upward = -1.0 if upper else 1.0
    z = upward * (scar.unworn_height_um(axial, transverse) - scar.depth_um)
    return np.stack([x, y, z], axis=-1)


def surface_mesh(scar: Scar, *, upper: bool) -> pyvista.StructuredGrid:
    """The worn surface as a mesh in micrometres, with the scar's fields at its points."""
    import pyvista

    points = worn_points(scar, upper=upper)
    mesh = pyvista.StructuredGrid(*np.moveaxis(points, -1, 0))
    for name in FIELD_COLUMNS:
        mesh.point_data[name] = getattr(scar, name).ravel(order="F")
    return mesh


def _write_surface(path: Path, scar: Scar, *, upper: bool) -> None:
    import meshio

    n_a, n_t = scar.depth_um.shape
    index = np.arange(n_a * n_t).reshape(n_a, n_t)
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(-1, 4)
    mesh = meshio.Mesh(
        worn_points(scar, upper=upper).reshape(-1, 3),
        [("quad", quads)],
        point_data={name: getattr(scar, name).ravel() for name in FIELD_COLUMNS},
    )
    with in_one_step(path) as partial:
        meshio.write(partial, mesh)
