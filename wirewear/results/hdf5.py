"""The result file of one run, in HDF5.

Layout (format 3; files of format 1 end without a checksum); every name carries its unit, every array is float64:

    /                            attributes: format = 3, kind = "wirewear result"
    /header                      JSON: name, variant, fidelity, status, message, contact_kind, bodies, length_mm
    /study /settings /quality /versions /timings_s          JSON, one scalar string each
    /loops/NNNN                  one logged loop, attribute: cycle; data sets (n,): time_s, displacement_um,
                                 relative_displacement_um, tangential_force_N, normal_force_N, friction_work_mJ,
                                 tilt_deg
    /evolution                   data sets (n,): those of EVOLUTION_COLUMNS, and any other column
    /scars/NNNN                  one logged scar, attributes: cycle, body, diameter_mm, axis_angle_deg,
                                 length_mm of a line contact, diameter_along_mm where curved along; data sets
                                 axial_um (n_a,), transverse_um (n_t,), depth_um, energy_density_mJ_per_mm2,
                                 pressure_MPa, slip_distance_um, of bodies that yield print_um, of debris
                                 that flows debris_um (n_a, n_t)
    /contact_forces/NNNN         forces on a body in a logged cycle, attributes: cycle, body, axis_angle_deg,
                                 of maps geometry (JSON), youngs_modulus_MPa, poissons_ratio; data sets phase,
                                 drive_um, holder_x_um, holder_z_um, tangential_force_N (k,), nodes (m,) of integers,
                                 force_N (k, m, 3), compressed once a run has ended, bulk_stress_MPa (k, 3) of bodies
                                 that carry any; the group is missing in older files
    /plastic_strain/NNNN         of metal that flows, attribute: body; data sets along_mm (n_x,), across_mm (n_y,),
                                 depths_mm (l,), strain (l, n_x, n_y, 6), compressed

Format 2 has `wire` in place of `body`, crossed wires only, and no tilt. Earlier results of line contacts have a
separate format, see `format_1`.

Groups NNNN count from 0000 in the order of logging. A file is built in memory and put in place in one step, so that a
reader, or a run killed at any moment, never meets half a file.
"""

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, TypeVar

import h5py
import numpy as np

from geometry import Elastic
from wirewear.base.errors import ResultError
from wirewear.base.files import RESULT_FILE_NAME
from wirewear.base.hdf5 import GrowingImage, hdf5_image, opened_hdf5, write_arrays
from wirewear.base.recognising import Held, require_no_other
from wirewear.base.writing import write_bytes, writing
from wirewear.results import format_1 as earlier_lines
from wirewear.results.contact_forces import POSITION_COLUMNS, ContactForces, geometry_of
from wirewear.results.evolution import Evolution
from wirewear.results.scar import FIELD_COLUMNS, FURTHER_COLUMNS, GRID_COLUMNS, Scar
from wirewear.results.values import LOOP_COLUMNS, Loop, PlasticStrain, RunResult
from wirewear.test.lengths import whole_test

T = TypeVar("T")

FORMAT = 3
KIND = "wirewear result"
# Written without a checksum.
_UNSEALED = (1,)
_EARLIER = (1, 2)

TEXTS = ("name", "variant", "fidelity", "status", "message")
HEADER = (*TEXTS, "contact_kind", "bodies", "length_mm")
TABLES = ("study", "settings", "quality", "versions", "timings_s")
FORCES_ATTRIBUTES = ("cycle", "body", "axis_angle_deg")
SCAR_ATTRIBUTES = ("cycle", "body", "diameter_mm", "axis_angle_deg")
_GRID_OF_STRAIN = ("along_mm", "across_mm", "depths_mm")
#: Attributes of few scars, and what they are of the others.
_SELDOM = {"length_mm": None, "diameter_along_mm": float("inf")}


def write_result(path: str | Path, result: RunResult, so_far: GrowingImage | None = None) -> RunResult:
    """Write `result` to `path`, replacing the file there in one step; return it as `read_result` would.

    The folder is made if missing. so_far: a running run's file as last written, to which only newly logged cycles are
    added; None writes all. Raises ResultError if a table holds what JSON cannot, or the file cannot be written.
    """
    path, tables = Path(path), {name: _json(name, getattr(result, name)) for name in TABLES}
    image = (hdf5_image if so_far is None else so_far.filled)(lambda file: _fill(file, result, tables))
    with writing(ResultError, f"cannot write the result file {path}"):
        path.parent.mkdir(parents=True, exist_ok=True)
        write_bytes(path, image)
    as_read: dict[str, Any] = {name: json.loads(text) for name, text in tables.items()}
    return replace(result, path=path, **as_read)


def read_result(path: str | Path) -> RunResult:
    """Read the run stored at `path`, a result file or a run's folder.

    Raises ResultError if there is no such file, it is not a result file of a known format, or its contents are damaged.
    """
    path = Path(path) / RESULT_FILE_NAME if Path(path).is_dir() else Path(path)
    with opened_hdf5(path, ResultError, "result file", unsealed=_UNSEALED) as file:
        kind, version = file.attrs.get("kind"), file.attrs.get("format")
        if kind not in (KIND, earlier_lines.KIND):
            raise ResultError(f"{path} is no wirewear result file.")
        if version not in ((FORMAT, *_EARLIER) if kind == KIND else _EARLIER):
            raise ResultError(f"{path} has result format {version}; this program reads format {FORMAT}.")
        try:
            return _run_result(file, path) if kind == KIND else earlier_lines.line_result(file, path)
        except ResultError as error:
            raise ResultError(f"{path} is damaged: {error}") from error


def read_results(path: str | Path) -> tuple[RunResult, ...]:
    """Read all runs at `path`: a result file, a run's folder, or a folder of variants' folders; sorted by name of
    variant.
    Raises ResultError if there are none, or a file found cannot be read.
    """
    path = Path(path)
    require_no_other(path, ResultError, Held.RUN)
    if not path.is_dir():
        return (read_result(path),)
    found = [path / RESULT_FILE_NAME, *sorted(path.glob(f"*/{RESULT_FILE_NAME}"))]
    results = [read_result(file) for file in found if file.is_file()]
    if not results:
        raise ResultError(f"there is no {RESULT_FILE_NAME} in {path} or in a folder directly below it.")
    return tuple(sorted(results, key=lambda result: result.variant))


def _fill(file: h5py.File, result: RunResult, tables: Mapping[str, str]) -> None:
    file.attrs["format"] = FORMAT
    file.attrs["kind"] = KIND
    for name in ("header", *TABLES, "evolution"):
        file.pop(name, None)
    file["header"] = _json("header", {name: getattr(result, name) for name in HEADER})
    for name, text in tables.items():
        file[name] = text
    for group, loop in _added(file, "loops", result.loops):
        group.attrs["cycle"] = loop.cycle
        write_arrays(group, {name: getattr(loop, name) for name in LOOP_COLUMNS})
    write_arrays(file.create_group("evolution", track_order=True), result.evolution)
    for group, scar in _added(file, "scars", result.scars):
        for name in SCAR_ATTRIBUTES:
            group.attrs[name] = getattr(scar, name)
        for name, usual in _SELDOM.items():
            if (value := getattr(scar, name)) != usual:
                group.attrs[name] = value
        write_arrays(group, {name: getattr(scar, name) for name in GRID_COLUMNS + scar.field_columns})

    # While a run goes on, its file is written again after every loop, and compressing takes longer than the rest.
    compression = {} if result.status == "running" else {"compression": "gzip", "shuffle": True}
    for group, one in _added(file, "contact_forces", result.contact_forces):
        _write_forces(group, one, compression)
    for group, flowed in _added(file, "plastic_strain", result.plastic_strain):
        group.attrs["body"] = flowed.body
        write_arrays(group, {name: getattr(flowed, name) for name in _GRID_OF_STRAIN})
        group.create_dataset("strain", data=flowed.strain, track_times=False, compression="gzip", shuffle=True)


def _added(file: h5py.File, name: str, members: Sequence[T]) -> Iterator[tuple[h5py.Group, T]]:
    """New groups, each with its member, for the members that the file does not hold yet."""
    parent = file.require_group(name)
    for index in range(len(parent), len(members)):
        yield parent.create_group(f"{index:04d}"), members[index]


def _write_forces(group: h5py.Group, forces: ContactForces, compression: Mapping[str, Any]) -> None:
    for name in FORCES_ATTRIBUTES:
        group.attrs[name] = getattr(forces, name)
    if forces.geometry is not None and forces.material is not None:
        group.attrs["geometry"] = json.dumps(forces.geometry.as_table())
        group.attrs.update(asdict(forces.material))
    write_arrays(group, {name: getattr(forces, name) for name in (*POSITION_COLUMNS, "nodes")})
    if forces.bulk_stress_MPa is not None:
        write_arrays(group, {"bulk_stress_MPa": forces.bulk_stress_MPa})
    group.create_dataset("force_N", data=forces.force_N, track_times=False, **compression)


def _forces(group: h5py.Group) -> ContactForces:
    attributes = group.attrs
    made_of: dict[str, Any] = {}
    if "geometry" in attributes:
        made_of = {
            "geometry": geometry_of(json.loads(attributes["geometry"])),
            "material": Elastic(float(attributes["youngs_modulus_MPa"]), float(attributes["poissons_ratio"])),
        }
    return ContactForces(
        cycle=int(attributes["cycle"]),
        body=_body(attributes),
        axis_angle_deg=float(attributes["axis_angle_deg"]),
        **made_of,
        **{
            name: group[name][()]
            for name in (*POSITION_COLUMNS, "nodes", "force_N", "bulk_stress_MPa")
            if name in group
        },
    )


def _run_result(file: h5py.File, path: Path) -> RunResult:
    tables = {name: _json_object(file, name) for name in ("header", *TABLES)}
    header = tables.pop("header")
    stated: dict[str, Any] = {name: str(header[name]) for name in TEXTS}
    if "contact_kind" in header:
        driven, other = header["bodies"]
        stated |= {"contact_kind": str(header["contact_kind"]), "bodies": (driven, other)}
        stated["length_mm"] = header["length_mm"]
    if stated.get("length_mm"):
        tables["study"] = whole_test(tables["study"], str(path), ResultError)
    return RunResult(
        **stated,
        study=tables["study"],
        settings=tables["settings"],
        quality={name: float(value) for name, value in tables["quality"].items()},
        versions={name: str(value) for name, value in tables["versions"].items()},
        timings_s={name: float(value) for name, value in tables["timings_s"].items()},
        loops=tuple(
            Loop(cycle=int(group.attrs["cycle"]), **{name: group[name][()] for name in LOOP_COLUMNS if name in group})
            for group in _in_order(file["loops"])
        ),
        evolution=Evolution({name: data[()] for name, data in file["evolution"].items()}),
        scars=tuple(_scar(group) for group in _in_order(file["scars"])),
        contact_forces=tuple(_forces(group) for group in _in_order(file.get("contact_forces", {}))),
        plastic_strain=tuple(_plastic_strain(group) for group in _in_order(file.get("plastic_strain", {}))),
        path=path,
    )


def _plastic_strain(group: h5py.Group) -> PlasticStrain:
    arrays = {name: group[name][()] for name in (*_GRID_OF_STRAIN, "strain")}
    return PlasticStrain(body=str(group.attrs["body"]), **arrays)


def _in_order(group: h5py.Group) -> Iterable[h5py.Group]:
    return (group[name] for name in sorted(group, key=int))


def _body(attributes: Mapping[str, Any]) -> str:
    return str(attributes["body" if "body" in attributes else "wire"])


def _scar(group: h5py.Group) -> Scar:
    attributes = group.attrs
    seldom: dict[str, Any] = {name: float(attributes[name]) for name in _SELDOM if name in attributes}
    fields: dict[str, Any] = {name: group[name][()] for name in GRID_COLUMNS}
    # Files of older versions lack a field; it is then unknown, which is shown as nothing.
    missing = np.zeros(group["depth_um"].shape)
    fields |= {name: group[name][()] if name in group else missing for name in FIELD_COLUMNS}
    fields |= {name: group[name][()] for name in FURTHER_COLUMNS if name in group}
    return Scar(
        cycle=int(attributes["cycle"]),
        body=_body(attributes),
        diameter_mm=float(attributes["diameter_mm"]),
        axis_angle_deg=float(attributes["axis_angle_deg"]),
        **seldom,
        **fields,
    )


def _json(name: str, table: Mapping[str, Any]) -> str:
    try:
        return json.dumps(table, default=_plain)
    except (TypeError, ValueError) as error:
        raise ResultError(f"{name} holds a value that JSON cannot: {error}") from error


def _plain(value: object) -> object:
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    if isinstance(value, Mapping):
        return dict(value)
    raise TypeError(f"{type(value).__name__} {value!r}")


def _json_object(file: h5py.File, name: str) -> dict[str, Any]:
    table = json.loads(file[name].asstr()[()])
    if not isinstance(table, dict):
        raise ResultError(f"{name} must be a JSON object, not {type(table).__name__}")
    return table
