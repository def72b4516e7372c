"""Results for other programs: flat tables (CSV, Parquet), labelled arrays with units (netCDF), scars over time (VTK).

Users see columns of a line contact per mm of its length, with `_per_mm` in their names. Scars of a line contact are
profiles.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree as ET

import numpy as np

from geometry.arrays import Array
from wirewear.base.errors import ResultError
from wirewear.base.units import unit_of, words_of
from wirewear.base.writing import all_or_none, in_one_step, require_absent, write_bytes, write_csv, writing
from wirewear.results.scar import FIELD_COLUMNS, Scar, noun_of
from wirewear.results.values import LOOP_COLUMNS, Loop, RunResult, extensive, scaled

if TYPE_CHECKING:
    import polars as pl
    import pyvista
    import xarray

FOLDER_NAME = "vtk"
#: Patterns of the files, relative to the run's folder.
TIME_SERIES_FILES = tuple(f"{FOLDER_NAME}/scar_*{ending}" for ending in (".vtu", ".pvd"))


#: A body's column, the body last; per mm it stands first.
OF_A_BODY = re.compile(r"(worn_volume|max_depth|left_edge|right_edge)_(pad|specimen)_(mm3|um)$")
_PER_MM = re.compile(r"(pad|specimen)_(worn_area|max_depth|left_edge|right_edge)_(um2|um)$")


def write_time_series(result: RunResult, folder: Path) -> list[Path]:
    """Write the scars of a run as `scar_<body>_<cycle>.vtu`, with a series `scar_<body>.pvd` for each body; return the
    PVD files.

    Points are the worn surface in micrometres, x along the motion and z from the driven to the held body, with the
    scar's fields; the time in a PVD file is the cycle. VTU files of an earlier run in the folder are removed. Raises
    ResultError if the folder cannot be written.
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
    scars = result.scars_of(body)
    for scar in scars:
        _write_surface(folder / _surface_file(scar), scar, upper=result.is_upper(body))
    return write_collection(
        folder / f"scar_{body}.pvd", [(str(scar.cycle), "0", _surface_file(scar)) for scar in scars]
    )


def write_collection(path: Path, files: Iterable[tuple[str, str, str]]) -> Path:
    """Write a PVD file over files beside it, each with its time, part and name; return its path."""
    root = ET.Element("VTKFile", type="Collection", version="0.1", byte_order="LittleEndian")
    collection = ET.SubElement(root, "Collection")
    for time, part, name in files:
        ET.SubElement(collection, "DataSet", timestep=time, group="", part=part, file=name)
    ET.indent(root)
    return write_bytes(path, ET.tostring(root, xml_declaration=True, encoding="utf-8"))


def _surface_file(scar: Scar) -> str:
    return f"scar_{scar.body}_{scar.cycle:07d}.vtu"


def worn_points(scar: Scar, *, upper: bool) -> Array:
    """Points (n_a, n_t, 3) of the worn surface in µm: x along the motion, y across, z from the driven body up to the
    held one. upper: True for the scar of the held body.
    """
    axial, transverse = np.meshgrid(scar.axial_um, scar.transverse_um, indexing="ij")
    x, y = scar.sliding_coordinates(axial, transverse)
    upward = -1.0 if upper else 1.0
    z = upward * (scar.unworn_height_um(axial, transverse) - scar.measured_depth_um)
    return np.stack([x, y, z], axis=-1)


def surface_mesh(scar: Scar, *, upper: bool) -> pyvista.StructuredGrid:
    """The worn surface as a pyvista mesh with the scar's fields by their names; points as of `worn_points`, in µm.
    upper: True for the held body's scar, whose z is turned over.
    """
    import pyvista

    points = worn_points(scar, upper=upper)
    mesh = pyvista.StructuredGrid(*np.moveaxis(points, -1, 0))
    for name in scar.field_columns:
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
        point_data={name: getattr(scar, name).ravel() for name in scar.field_columns},
    )
    with in_one_step(path) as partial:
        meshio.write(partial, mesh)


def labelled(result: RunResult) -> xarray.DataTree:
    """A run as a tree of xarray data sets: `evolution`, `loops` (if any) and `scars/<body>_<cycle>`; each array states
    its unit. Loops are rows (cycle, sample), padded with NaN to the length of the longest. Raises ResultError if xarray
    is not installed.
    """
    made = _xarray()
    texts = {name: getattr(result, name) for name in ("name", "variant", "fidelity", "status")}
    texts |= {name: json.dumps(dict(getattr(result, name)), default=str) for name in ("study", "versions")}
    nodes: dict[str, Any] = {"/": made.Dataset(attrs=texts)}
    columns = {name: ("cycle", np.array(values), _attributes(name)) for name, values in result.evolution.items()}
    cycles = columns.pop("cycle")
    nodes["/evolution"] = made.Dataset(columns, coords={"cycle": cycles})
    if result.loops:
        nodes["/loops"] = _loops(result.loops)
    for scar in result.scars:
        nodes[f"/scars/{scar.body}_{scar.cycle}"] = _scar(scar)
    tree: xarray.DataTree = made.DataTree.from_dict(nodes)
    return tree


def write_netcdf(result: RunResult, path: Path, *, overwrite: bool = True) -> Path:
    """Write the tree from `labelled` as one netCDF 4 file; return its path. Raises ResultError if xarray or h5netcdf is
    not installed, or the file cannot be written, or exists and `overwrite` is False.
    """
    require_absent(() if overwrite else [path], ResultError)
    tree = labelled(result)
    try:
        import h5netcdf  # noqa: F401
    except ImportError as error:
        raise _missing("h5netcdf") from error
    with writing(ResultError, f"cannot write {path}"):
        path.parent.mkdir(parents=True, exist_ok=True)
        return write_bytes(path, bytes(tree.to_netcdf(engine="h5netcdf")))


def _xarray() -> Any:
    try:
        import xarray
    except ImportError as error:
        raise _missing("xarray") from error
    return xarray


def _missing(package: str) -> ResultError:
    return ResultError(f"this needs {package}, which is not installed: pip install 'wirewear[xarray]'.")


def _loops(loops: Iterable[Loop]) -> Any:
    loops = sorted(loops, key=lambda loop: loop.cycle)
    longest = max(loop.time_s.size for loop in loops)

    def stacked(name: str) -> np.ndarray:
        rows = [np.pad(getattr(one, name), (0, longest - one.time_s.size), constant_values=np.nan) for one in loops]
        return np.stack(rows)

    columns = {name: (("cycle", "sample"), stacked(name), _attributes(name)) for name in LOOP_COLUMNS}
    cycles = ("cycle", [loop.cycle for loop in loops], _attributes("cycle"))
    return _xarray().Dataset(columns, coords={"cycle": cycles, "sample": np.arange(longest)})


def _scar(scar: Scar) -> Any:
    x, y = scar.sliding_coordinates(scar.axial_um[:, None], scar.transverse_um[None, :])
    grid = ("axial_um", "transverse_um")
    fields = {name: (grid, np.array(getattr(scar, name)), _attributes(name)) for name in scar.field_columns}
    coordinates = {name: (name, np.array(getattr(scar, name)), _attributes(name)) for name in grid}
    places = {
        name: (grid, np.array(np.broadcast_to(values, scar.depth_um.shape)), _attributes(name))
        for name, values in (("x_um", x), ("y_um", y))
    }
    attributes = {noun_of(scar.body): scar.body, "cycle": scar.cycle, "diameter_mm": scar.diameter_mm}
    return _xarray().Dataset(fields, coords=coordinates | places, attrs=attributes)


def _attributes(name: str) -> dict[str, str]:
    return {"units": unit_of(name), "long_name": words_of(name)}


_um2_PER_mm2 = 1e6


def per_mm(columns: Mapping[str, Array], share: float) -> dict[str, Array]:
    """Columns of a line contact per mm of its length, as users see them: volumes as areas. share: 1 mm over the
    length.
    """
    found = {}
    for name, column in scaled(columns, share).items():
        if own := OF_A_BODY.match(name):
            what, body, unit = own.groups()
            area = unit == "mm3"
            found[f"{body}_worn_area_um2" if area else f"{body}_{what}_um"] = column * _um2_PER_mm2 if area else column
        else:
            found[f"{name}_per_mm" if extensive(name) else name] = column
    return found


def whole(columns: Mapping[str, Array]) -> dict[str, Array]:
    """Columns per mm of length, named as for users, renamed as those of a contact of 1 mm: undoes `per_mm`."""
    found = {}
    for name, column in columns.items():
        if own := _PER_MM.match(name):
            body, what, unit = own.groups()
            area = unit == "um2"
            new = f"worn_volume_{body}_mm3" if area else f"{what}_{body}_um"
            found[new] = np.asarray(column / _um2_PER_mm2 if area else column)
        else:
            found[name.removesuffix("_per_mm")] = column
    return found


def evolution_table(result: RunResult) -> pl.DataFrame:
    """A polars table with one row per measured cycle, a line contact's per mm of its length."""
    import polars as pl

    return pl.DataFrame({name: np.array(column) for name, column in named_for_users(result, result.evolution).items()})


def loops_table(result: RunResult) -> pl.DataFrame:
    """A table with one row per sample of each recorded loop; a line contact's per mm of its length."""
    import polars as pl

    cycles = [np.full(loop.time_s.size, loop.cycle) for loop in result.loops]
    columns = {name: _joined([getattr(loop, name) for loop in result.loops]) for name in LOOP_COLUMNS}
    return pl.DataFrame({"cycle": _joined(cycles, np.int64)} | dict(named_for_users(result, columns)))


def scars_table(result: RunResult) -> pl.DataFrame:
    """A table with one row per point of each recorded scar; x along the motion, y across, from first contact."""
    import polars as pl

    places = [scar.sliding_coordinates(scar.axial_um[:, None], scar.transverse_um[None, :]) for scar in result.scars]
    bodies = [np.full(scar.depth_um.size, scar.body) for scar in result.scars]
    columns = {
        "cycle": _joined([np.full(scar.depth_um.size, scar.cycle) for scar in result.scars], np.int64),
        noun_of(result.bodies[0]): np.concatenate(bodies) if bodies else np.empty(0, dtype=str),
        "x_um": _joined([np.broadcast_to(x, s.depth_um.shape) for s, (x, _) in zip(result.scars, places, strict=True)]),
        "y_um": _joined([np.broadcast_to(y, s.depth_um.shape) for s, (_, y) in zip(result.scars, places, strict=True)]),
    }
    fields = result.scars[0].field_columns if result.scars else FIELD_COLUMNS
    return pl.DataFrame(columns | {name: _joined([getattr(s, name) for s in result.scars]) for name in fields})


def profiles_table(result: RunResult) -> pl.DataFrame:
    """A table with one row per point of each recorded profile; slip amplitude is a quarter of the path slid."""
    import polars as pl

    renamed = scars_table(result).rename({"slip_distance_um": "slip_amplitude_um"})
    return renamed.drop("y_um").with_columns(pl.col("slip_amplitude_um") / 4.0)


def named_for_users(result: RunResult, columns: Mapping[str, Array]) -> Mapping[str, Array]:
    """Columns as tables and reports show them: for a line contact those of `per_mm`, otherwise unchanged."""
    return _NAMED[result.extent.suffix](columns, result.extent.share)


#: Columns as users are shown them, by what is behind the names of those that grow with the contact.
_NAMED: dict[str, Callable[[Mapping[str, Array], float], Mapping[str, Array]]] = {
    "": lambda columns, _: columns,
    "_per_mm": per_mm,
}
#: Tables of worn surfaces.
_WORN: dict[str, Callable[[RunResult], pl.DataFrame]] = {"scars": scars_table, "profiles": profiles_table}


def tables_of(result: RunResult) -> dict[str, Callable[[RunResult], pl.DataFrame]]:
    """Functions that make the tables of a result by name: "evolution", "loops", and "scars" or "profiles"."""
    worn = result.extent.worn
    return {"evolution": evolution_table, "loops": loops_table, worn: _WORN[worn]}


def write_flat_tables(result: RunResult, folder: Path, ending: str, *, overwrite: bool = True) -> list[Path]:
    """Write the tables of a result to `folder` as files with this `ending`, "csv" or "parquet"; return their paths.
    Raises ResultError if the folder cannot be written, or a file exists and `overwrite` is False.
    """
    tables = {folder / f"{name}.{ending}": table for name, table in tables_of(result).items()}
    require_absent(() if overwrite else tables, ResultError)
    with writing(ResultError, f"cannot write tables to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        with all_or_none(tables) as partials:
            for partial, table in zip(partials, tables.values(), strict=True):
                if ending == "csv":
                    write_csv(partial, table(result))
                else:
                    # Polars takes no name that is not in UTF-8, but takes any open file.
                    with partial.open("wb") as file:
                        table(result).write_parquet(file)
    return list(tables)


def _joined(arrays: list[np.ndarray], dtype: type = np.float64) -> np.ndarray:
    return np.concatenate([array.ravel() for array in arrays]) if arrays else np.empty(0, dtype=dtype)
