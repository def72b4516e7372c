"""Results as labelled arrays with units (xarray), and as a netCDF file of them."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from wirewear.base.errors import ResultError
from wirewear.base.quantity import unit_of, words_of
from wirewear.base.writing import write_bytes, writing
from wirewear.results.scar import FIELD_COLUMNS, WIRES, Scar
from wirewear.results.values import LOOP_COLUMNS, Loop, RunResult

if TYPE_CHECKING:
    import xarray


def labelled(result: RunResult) -> xarray.DataTree:
    """A run as a tree of data sets: `evolution`, `loops` and `scars/<wire>_<cycle>`; every array states its unit.

    Loops are told apart by `cycle` and filled up with NaN to the length of the longest.

    Raises:
        ResultError: xarray is not installed.
    """
    made = _xarray()
    nodes: dict[str, Any] = {"/": made.Dataset(attrs=_described(result))}
    nodes["/evolution"] = _evolution(result)
    if result.loops:
        nodes["/loops"] = _loops(result.loops)
    for scar in result.scars:
        nodes[f"/scars/{scar.body}_{scar.cycle}"] = _scar(scar)
    tree: xarray.DataTree = made.DataTree.from_dict(nodes)
    return tree


def write_netcdf(result: RunResult, path: Path) -> Path:
    """Write that tree as one netCDF 4 file.

    Raises:
        ResultError: xarray or h5netcdf is not installed, or the file cannot be written.
    """
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


def _described(result: RunResult) -> dict[str, str]:
    texts = {name: getattr(result, name) for name in ("name", "variant", "fidelity", "status")}
    return texts | {name: json.dumps(dict(getattr(result, name)), default=str) for name in ("study", "versions")}


def _evolution(result: RunResult) -> Any:
    columns = {name: ("cycle", np.array(values), _attributes(name)) for name, values in result.evolution.items()}
    return _xarray().Dataset(_without(columns, "cycle"), coords={"cycle": columns["cycle"]})


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
    fields = {name: (grid, np.array(getattr(scar, name)), _attributes(name)) for name in FIELD_COLUMNS}
    coordinates = {name: (name, np.array(getattr(scar, name)), _attributes(name)) for name in grid}
    places = {
        name: (grid, np.array(np.broadcast_to(values, scar.depth_um.shape)), _attributes(name))
        for name, values in (("x_um", x), ("y_um", y))
    }
    attributes = {
        "wire" if scar.body in WIRES else "body": scar.body,
        "cycle": scar.cycle,
        "diameter_mm": scar.diameter_mm,
    }
    return _xarray().Dataset(fields, coords=coordinates | places, attrs=attributes)


def _attributes(name: str) -> dict[str, str]:
    return {"units": unit_of(name), "long_name": words_of(name)}


def _without(columns: Mapping[str, Any], name: str) -> dict[str, Any]:
    return {key: value for key, value in columns.items() if key != name}
