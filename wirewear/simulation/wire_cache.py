"""Condensed wires kept on disk, as condensation takes most of the time of a short run."""

from __future__ import annotations

from dataclasses import asdict, replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geometry import ContactPatch, Cylinder, Elastic, WireGeometry, WireMesh, build_wire
from solvers.condensation import CondensedBody, condense
from solvers.near_field import Bricks
from solvers.patch_compliance import PatchCompliance
from wirewear.files import in_one_step
from wirewear.files.cache import allowed_bytes, keep_within, kept_file, mark_used, not_kept
from wirewear.files.identity import CONDENSATION_CODE, identity_of

Array = NDArray[np.float64]


def condensed_wire(geometry: WireGeometry, material: Elastic, directory: Path | None = None) -> CondensedBody:
    """Mesh and condense a wire, or load it when the same has been condensed before.

    A file that cannot be read is made anew; one that cannot be written is left out.
    """
    name = f"wire-{_key(geometry, material)}.npz"
    path = kept_file(name) if directory is None else directory / name
    stored = None if path is None else _load(path, geometry.radius_mm)
    if path is not None and stored is not None:
        mark_used(path)
        return _on_bricks(stored, geometry, material)
    wire = build_wire(geometry)
    body = condense(wire.mesh, wire.patch, material, bedding=wire.bedding)
    if path is not None:
        _store(path, body)
    return _on_bricks(body, geometry, material)


def condensed_worn_wire(geometry: WireGeometry, material: Elastic, worn_depth_mm: Array) -> tuple[CondensedBody, float]:
    """Condense a wire whose patch's nodes are moved by a vertical depth (n_a, n_t) below the fresh surface.

    Returns the body and the smallest scaled Jacobian of its mesh. Not kept: every state of wear comes but once.
    GeometryError naming the place of an element that the motion distorts too much.
    """
    wire = _fresh_wire(geometry).worn(worn_depth_mm)
    body = condense(wire.mesh, wire.patch, material, bedding=wire.bedding)
    return _on_bricks(body, geometry, material), wire.smallest_scaled_jacobian


def _on_bricks(body: CondensedBody, geometry: WireGeometry, material: Elastic) -> CondensedBody:
    """The body with what it is known of the elements under its patch."""
    return replace(body, bricks=Bricks(material, geometry.layers))


@lru_cache(maxsize=2)
def _fresh_wire(geometry: WireGeometry) -> WireMesh:
    """Kept, as both wires of a run are worn again and again from the same fresh mesh."""
    return build_wire(geometry)


def _key(geometry: WireGeometry, material: Elastic) -> str:
    asked = {"geometry": asdict(geometry), "material": asdict(material)}
    return identity_of(asked, CONDENSATION_CODE, {}).name


def _load(path: Path, radius_mm: float) -> CondensedBody | None:
    try:
        # What numpy opens itself it leaves open where the archive is damaged.
        with path.open("rb") as file, np.load(file) as data:
            lines, nodes = (data["axial"], data["transverse"]), data["nodes"]
            patch = ContactPatch(*lines, nodes, Cylinder(radius_mm))
            planes = tuple(data["planes"].tolist())
            return CondensedBody(patch, PatchCompliance(patch.shape, planes, data["blocks"]))
    except Exception:  # noqa: BLE001 - a damaged archive raises errors of zipfile and zlib, too many to name
        return None


def _store(path: Path, body: CondensedBody) -> None:
    patch = body.patch
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with in_one_step(path) as partial, partial.open("wb") as file:
            np.savez(
                file,
                axial=patch.axial_mm,
                transverse=patch.transverse_mm,
                nodes=patch.nodes,
                planes=np.array(body.folded.planes, dtype=np.int64),
                blocks=body.folded.blocks,
            )
        keep_within(path.parent, allowed_bytes(), newest=path)
    except OSError as problem:
        not_kept(path, problem)
