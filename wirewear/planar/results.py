"""What the run of a line contact leaves: depth profiles of both bodies, loops, evolution; written as HDF5 and CSV.

Everything is per mm of thickness. Files: result.h5 (all of it), profiles.csv, loops.csv, evolution.csv.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import h5py
import numpy as np
from numpy.typing import NDArray

from wirewear.base.errors import ResultError
from wirewear.base.hdf5 import hdf5_image, opened_hdf5
from wirewear.base.writing import write_bytes, write_csv, writing
from wirewear.results import RESULT_FILE_NAME

Array = NDArray[np.float64]

FORCES_COLUMNS = ("phase", "drive_um", "holder_x_um", "holder_z_um", "nodes", "force_N_per_mm")
BODIES = ("pad", "specimen")
KIND = "wirewear planar result"
PROFILE_COLUMNS = ("x_um", "depth_um", "energy_density_mJ_per_mm2", "pressure_MPa", "slip_amplitude_um")
LOOP_COLUMNS = (
    "time_s",
    "displacement_um",
    "relative_displacement_um",
    "tangential_force_N_per_mm",
    "normal_force_N_per_mm",
    "tilt_deg",
)
_FORMAT = 2
# Written without a checksum.
_UNSEALED = (1,)

# Depth, relative to the deepest point, that bounds the scar.
_EDGE = 0.01


@dataclass(frozen=True, eq=False)
class PlanarProfile:
    """A body's worn profile after `cycle` cycles; arrays (n,) over x in the body's own frame, depth along z.

    The pressure is that at mid-stroke.  slip_amplitude_um: a quarter of the path that a point slides under pressure in
    the cycle.  Results of earlier versions lack it (NaN).
    """

    cycle: int
    body: str
    x_um: Array
    depth_um: Array
    energy_density_mJ_per_mm2: Array
    pressure_MPa: Array
    slip_amplitude_um: Array

    def edges_um(self) -> tuple[float, float]:
        """Left and right end of the scar, where the depth falls to 1 % of its largest; NaN where nothing is worn."""
        level = _EDGE * float(self.depth_um.max())
        worn = np.flatnonzero(self.depth_um > level)
        if not len(worn):
            return float("nan"), float("nan")

        def crossing(inside: int, outside: int) -> float:
            if not 0 <= outside < len(self.x_um):
                return float(self.x_um[inside])
            deep, shallow = self.depth_um[inside], self.depth_um[outside]
            share = (deep - level) / (deep - shallow)
            return float(self.x_um[inside] + share * (self.x_um[outside] - self.x_um[inside]))

        return crossing(worn[0], worn[0] - 1), crossing(worn[-1], worn[-1] + 1)

    @property
    def area_um2(self) -> float:
        """Worn cross-section, the exact integral of the piecewise linear depth."""
        return float(np.trapezoid(self.depth_um, self.x_um))


@dataclass(frozen=True, eq=False)
class PlanarLoop:
    """A closed loop at `cycle`, arrays (n,); it starts at mid-stroke moving towards +x.

    tilt_deg: of the pad.  Results of earlier versions lack it and the normal force (NaN).
    """

    cycle: int
    time_s: Array
    displacement_um: Array
    relative_displacement_um: Array
    tangential_force_N_per_mm: Array
    normal_force_N_per_mm: Array
    tilt_deg: Array


@dataclass(frozen=True, eq=False)
class PlanarForces:
    """Contact forces on a body at k positions of a cycle, in the order in which they are passed.

    phase: (k,) share of the cycle passed since its end at +x.  nodes: (m,) of the patch, whole numbers.
    force_N_per_mm: (k, m, 3) on the body in its own axes: along its surface, across, out of it.
    """

    cycle: int
    body: str
    phase: Array
    drive_um: Array
    holder_x_um: Array
    holder_z_um: Array
    nodes: Array
    force_N_per_mm: Array

    @property
    def force(self) -> Array:
        """`force_N_per_mm`, as it is called of bodies of any dimension."""
        return self.force_N_per_mm


@dataclass(frozen=True, eq=False)
class PlanarResult:
    """All that a planar run leaves; `evolution` maps column names to arrays over the logged cycles.

    status: running, complete or failed, with a message for a person.
    """

    contact_kind: ClassVar[str] = "line-contact"

    name: str
    fidelity: str
    status: str
    message: str
    study: Mapping[str, Any]
    settings: Mapping[str, Any]
    quality: Mapping[str, float]
    profiles: tuple[PlanarProfile, ...]
    loops: tuple[PlanarLoop, ...]
    evolution: Mapping[str, Array]
    variant: str = ""
    forces: tuple[PlanarForces, ...] = ()

    @property
    def label(self) -> str:
        """What the result is called beside others."""
        return f"{self.name}, {self.variant}" if self.variant else self.name

    def profile(self, cycle: int, body: str) -> PlanarProfile:
        """A body's profile at a logged cycle; ResultError when there is none."""
        for profile in self.profiles:
            if (profile.cycle, profile.body) == (cycle, body):
                return profile
        raise ResultError(f"no profile of the {body} is logged at cycle {cycle}")


def write_planar_result(folder: Path, result: PlanarResult) -> list[Path]:
    """Write result.h5 and the CSV tables, each in one step; ResultError when that fails."""
    import polars as pl

    tables = {
        "profiles.csv": _long_table(result.profiles, ("cycle", "body"), PROFILE_COLUMNS),
        "loops.csv": _long_table(result.loops, ("cycle",), LOOP_COLUMNS),
        "evolution.csv": dict(result.evolution),
    }
    image = hdf5_image(lambda file: _fill(file, result), track_order=True)
    with writing(ResultError, f"cannot write the results to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        written = [write_csv(folder / name, pl.DataFrame(columns)) for name, columns in tables.items()]
        return [*written, write_bytes(folder / RESULT_FILE_NAME, image)]


def _fill(file: h5py.File, result: PlanarResult) -> None:
    file.attrs["kind"], file.attrs["format"] = KIND, _FORMAT
    file.attrs["name"], file.attrs["fidelity"] = result.name, result.fidelity
    if result.status != "complete":
        # Files without these are of complete runs.
        file.attrs["status"], file.attrs["message"] = result.status, result.message
    if result.variant:
        file.attrs["variant"] = result.variant
    for name in ("study", "settings", "quality"):
        file[name] = json.dumps(getattr(result, name), ensure_ascii=False)
    groups = (
        ("profiles", result.profiles, ("cycle", "body"), PROFILE_COLUMNS),
        ("contact_forces", result.forces, ("cycle", "body"), FORCES_COLUMNS),
        ("loops", result.loops, ("cycle",), LOOP_COLUMNS),
    )
    for place, items, keys, columns in groups:
        for index, item in enumerate(items):
            group = file.create_group(f"{place}/{index:04d}")
            for key in keys:
                group.attrs[key] = getattr(item, key)
            for name in columns:
                group[name] = getattr(item, name)
    evolution = file.create_group("evolution", track_order=True)
    for column, values in result.evolution.items():
        evolution[column] = values


def _long_table(items: Sequence[object], keys: Sequence[str], columns: Sequence[str]) -> dict[str, Any]:
    """Arrays of several objects one below the other, with the keys of each repeated beside them."""
    lengths = [len(getattr(item, columns[0])) for item in items]
    repeated = {
        key: [value for item, n in zip(items, lengths, strict=True) for value in [getattr(item, key)] * n]
        for key in keys
    }
    return repeated | {
        name: np.concatenate([np.zeros(0), *(getattr(item, name) for item in items)]) for name in columns
    }


@contextmanager
def opened_planar_result(path: Path) -> Iterator[h5py.File]:
    """The open result.h5 at a path, or in the folder there.

    Raises:
        ResultError: there is none, or it is no result of a line contact, or something in it is missing.
    """
    file_path = path / RESULT_FILE_NAME if path.is_dir() else path
    with opened_hdf5(file_path, ResultError, "result file", unsealed=_UNSEALED) as file:
        if file.attrs.get("kind") != KIND:
            raise ResultError(f"{file_path} is no result of a planar study.")
        yield file


def read_planar_result(path: Path) -> PlanarResult:
    """Read a result.h5, or that of a run's folder.

    Raises:
        ResultError: there is none, or it is no result of a planar run.
    """
    with opened_planar_result(path) as file:
        study, settings, quality = (json.loads(file[name][()]) for name in ("study", "settings", "quality"))
        return PlanarResult(
            name=str(file.attrs["name"]),
            fidelity=str(file.attrs["fidelity"]),
            status=str(file.attrs.get("status", "complete")),
            message=str(file.attrs.get("message", "")),
            study=study,
            settings=settings,
            quality=quality,
            profiles=tuple(
                PlanarProfile(int(group.attrs["cycle"]), str(group.attrs["body"]), **_columns(group, PROFILE_COLUMNS))
                for group in file["profiles"].values()
            ),
            loops=tuple(
                PlanarLoop(int(group.attrs["cycle"]), **_columns(group, LOOP_COLUMNS))
                for group in file["loops"].values()
            ),
            evolution=_arrays(file["evolution"]),
            variant=str(file.attrs.get("variant", "")),
            forces=tuple(
                PlanarForces(int(group.attrs["cycle"]), str(group.attrs["body"]), **_columns(group, FORCES_COLUMNS))
                for group in file.get("contact_forces", {}).values()
            ),
        )


def _arrays(group: h5py.Group) -> dict[str, Array]:
    return {name: np.asarray(column[()], dtype=np.float64) for name, column in group.items()}


def _columns(group: h5py.Group, names: tuple[str, ...]) -> dict[str, Array]:
    """Columns by name, NaN for those that an earlier version did not write."""
    found = _arrays(group)
    nothing = np.full(len(next(iter(found.values()))), np.nan)
    return {name: found.get(name, nothing) for name in names}


def is_planar_result(path: Path) -> bool:
    """Whether a file, or that in the folder there, says that it is of a line contact; a damaged one says nothing."""
    with suppress(ResultError), opened_planar_result(path):
        return True
    return False
