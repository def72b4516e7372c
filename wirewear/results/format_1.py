"""Results of line contacts in the separate format of earlier versions, with all values per mm of their length.

/                            attributes: format = 1 or 2 (1 without a checksum), kind, name, fidelity, and of runs
                             that are not complete or of variants status, message, variant
/study /settings /quality    JSON, one scalar string each
/profiles/NNNN               attributes: cycle, body; data sets (n,): x_um, depth_um, energy_density_mJ_per_mm2,
                             pressure_MPa, slip_amplitude_um (a quarter of the path slid in a cycle)
/loops/NNNN                  attribute: cycle; data sets (n,), forces in N_per_mm
/contact_forces/NNNN         as in `hdf5`, without tangential forces
/evolution                   data sets (n,), with the names of `per_mm`
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from geometry.arrays import Array
from wirewear.base import kinds
from wirewear.base.errors import ResultError
from wirewear.results.contact_forces import ContactForces
from wirewear.results.evolution import Evolution
from wirewear.results.export import whole
from wirewear.results.scar import Scar
from wirewear.results.values import LOOP_COLUMNS, Loop, RunResult
from wirewear.test.lengths import whole_test

KIND = "wirewear planar result"

_LENGTH_mm = 1.0


def line_result(file: h5py.File, path: Path) -> RunResult:
    """The result of a line contact in an open file of that format; ResultError if its contents do not form one."""
    attributes = file.attrs
    evolution = whole(_arrays(file["evolution"]))
    nothing = np.full(evolution["cycle"].size, np.nan)
    missing = (
        "displacement_amplitude_um",
        "normal_force_N",
        "slip_amplitude_um",
        "contact_half_width_um",
        "jump_cycles",
    )
    tables: dict[str, Any] = {name: json.loads(file[name][()]) for name in ("study", "settings", "quality")}
    tables["study"] = whole_test(tables["study"], str(path), ResultError)
    return RunResult(
        name=str(attributes["name"]),
        variant=str(attributes.get("variant", "")),
        fidelity=str(attributes["fidelity"]),
        message=str(attributes.get("message", "")),
        status=str(attributes.get("status", "complete")),
        **tables,
        loops=tuple(_loop(group) for group in file["loops"].values()),
        evolution=Evolution(dict.fromkeys(missing, nothing) | evolution),
        scars=tuple(_scar(group) for group in file["profiles"].values()),
        contact_forces=tuple(_forces(group) for group in file.get("contact_forces", {}).values()),
        versions={},
        timings_s={},
        path=path,
        contact_kind=kinds.LINE_CONTACT,
        bodies=("specimen", "pad"),
        length_mm=_LENGTH_mm,
    )


def _loop(group: h5py.Group) -> Loop:
    found = whole(_arrays(group))
    nothing = np.full(found["time_s"].size, np.nan)
    return Loop(int(group.attrs["cycle"]), **{name: found.get(name, nothing) for name in LOOP_COLUMNS})


def _scar(group: h5py.Group) -> Scar:
    found: dict[str, Any] = {name: column[:, None] for name, column in _arrays(group).items()}
    amplitude = found.pop("slip_amplitude_um", np.zeros_like(found["depth_um"]))
    return Scar(
        cycle=int(group.attrs["cycle"]),
        body=str(group.attrs["body"]),
        diameter_mm=np.inf,
        axis_angle_deg=0.0,
        axial_um=found.pop("x_um")[:, 0],
        transverse_um=np.zeros(1),
        slip_distance_um=4.0 * amplitude,
        **found,
        length_mm=_LENGTH_mm,
    )


def _forces(group: h5py.Group) -> ContactForces:
    found: dict[str, Any] = _arrays(group)
    force, body = found.pop("force_N_per_mm"), str(group.attrs["body"])
    along = force[:, :, 0].sum(axis=1)
    return ContactForces(
        cycle=int(group.attrs["cycle"]),
        body=body,
        tangential_force_N=along if body == "pad" else -along,
        nodes=found.pop("nodes").astype(np.int64),
        force_N=force,
        **found,
    )


def _arrays(group: Mapping[str, Any]) -> dict[str, Array]:
    return {name: np.asarray(column[()], dtype=np.float64) for name, column in group.items()}
