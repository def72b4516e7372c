"""Condensed wires kept on disk, as condensation takes most of the time of a short run."""

from __future__ import annotations

import hashlib
import json
import os
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geometry import ContactPatch, Cylinder, WireGeometry, build_wire
from solvers.condensation import CondensedBody, condense
from solvers.elasticity import Elastic

Array = NDArray[np.float64]

# Raise when meshing or condensation change their results.
_GENERATION = 1


def cache_directory() -> Path:
    """WIREWEAR_CACHE if set, else the user's cache folder."""
    chosen = os.environ.get("WIREWEAR_CACHE")
    if chosen:
        return Path(chosen)
    return Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "wirewear"


def condensed_wire(
    geometry: WireGeometry, material: Elastic, directory: Path | None = None, *, worn_depth_mm: Array | None = None
) -> CondensedBody:
    """Mesh and condense a wire, or load it when the same has been condensed before.

    worn_depth_mm: (n_a, n_t) total depth by which the nodes of the fresh patch are moved, None to leave them.
    A file that cannot be read is made anew; one that cannot be written is left out.
    """
    path = (directory or cache_directory()) / f"wire-{_key(geometry, material, worn_depth_mm)}.npz"
    stored = _load(path, geometry.radius_mm, worn_depth_mm)
    if stored is not None:
        return stored
    wire = build_wire(geometry)
    if worn_depth_mm is not None:
        wire = wire.worn(worn_depth_mm)
    body = condense(wire.mesh, wire.patch, material)
    _store(path, body)
    return body


def _key(geometry: WireGeometry, material: Elastic, worn_depth_mm: Array | None) -> str:
    motion = None if worn_depth_mm is None else hashlib.sha256(np.ascontiguousarray(worn_depth_mm, float).tobytes())
    parts = {
        "generation": _GENERATION,
        "gmsh": version("gmsh"),
        "geometry": asdict(geometry),
        "material": asdict(material),
        "motion": motion and motion.hexdigest(),
    }
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:24]


def _load(path: Path, radius_mm: float, worn_depth_mm: Array | None) -> CondensedBody | None:
    try:
        with np.load(path) as data:
            lines, nodes = (data["axial"], data["transverse"]), data["nodes"]
            patch = ContactPatch(*lines, nodes, Cylinder(radius_mm), worn_depth_mm)
            compliance = data["compliance"]
    except (OSError, ValueError, KeyError, EOFError):
        return None
    except Exception:  # noqa: BLE001 - a damaged archive raises errors of zipfile and zlib, too many to name
        return None
    return CondensedBody(patch, compliance) if compliance.shape == (3 * patch.size, 3 * patch.size) else None


def _store(path: Path, body: CondensedBody) -> None:
    patch = body.patch
    temporary = path.with_name(f".{path.name}.{os.getpid()}.partial")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with temporary.open("wb") as file:
            np.savez(
                file,
                axial=patch.axial_mm,
                transverse=patch.transverse_mm,
                nodes=patch.nodes,
                compliance=body.compliance,
            )
        temporary.replace(path)
    except OSError:
        temporary.unlink(missing_ok=True)
