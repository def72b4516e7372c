"""Bodies from files, of meshes or of condensed stiffnesses: their keys, and their geometry under a contact patch.

A patch is the finely meshed part of a surface that may touch.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import degrees, inf, sqrt
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, Field, PlainValidator, model_validator

from geometry import BodyGeometry, GeometryError, GradedAxis, Layering, RimGradedAxis
from geometry.embedded import EmbeddedGeometry, OwnGrid, as_grid, block_fits
from geometry.mesh_files import FORMATS, MATRICES, digest_of
from geometry.own_surface import MeshSource, OwnSurface, own_surface
from geometry.stiffness_files import of_stiffness
from wirewear.base.errors import StudyError
from wirewear.base.words import shown
from wirewear.test import keys
from wirewear.test.bodies import Body, ElasticKeys

MM_PER_UNIT = {"m": 1e3, "cm": 10.0, "mm": 1.0, "um": 1e-3, "in": 25.4}
_SMALLEST_mm, _LARGEST_mm = 0.05, 500.0  #: Limits of a body's largest extent.
_FALL = 0.2  #: How far the face may fall to the sides of the block under the contact, over its sharper radius.
_ROOM, _DEEP = 3.0, 3.0  #: Extents of that block over the patch's half-width: to each side, and below.
_FINER = 0.6  #: Largest elements of the block over the file's.
_SMALLER = 0.85  #: Factor by which the block is made smaller where it does not fit.
_TURN = 0.35  #: By how much the normal may turn from one of the file's faces to the next, in radians.
#: Poisson's ratio from which a body of tetrahedra of four nodes is too stiff.
_LOCKS = 0.45


STIFFNESS_KEYS = ("file", "contact", "held", "digest")
_ALLOWED = {"unit": f", one of {', '.join(MM_PER_UNIT)}"}


def _unstated(
    stated: MeshKeys, shape: str, endings: tuple[str, ...], needed: tuple[str, ...]
) -> tuple[str, str] | None:
    """A key that a shape needs but lacks, or a file of another ending, and the rest of a sentence on it."""
    for key in needed:
        if getattr(stated, key) is None:
            return key, f'is missing, but a body of shape "{shape}" states it{_ALLOWED.get(key, "")}'
    if not (stated.file or "").lower().endswith(endings):
        return "file", f'is {stated.file!r}, but of a body of shape "{shape}" it ends in {" or ".join(endings)}'
    return None


def unfit_stiffness(stated: MeshKeys) -> tuple[str, str] | None:
    """(key, rest of a sentence on it) if the stated file gives no body by its condensed stiffness; None if it does."""
    if problem := _unstated(stated, "stiffness", MATRICES, ("file", "contact", "held")):
        return problem
    try:
        of_stiffness(source_of(stated))
    except GeometryError as problem:
        return "file", f"gives a body that cannot be taken: {str(problem).rstrip('.')}"
    return None


def _checked_direction(value: object) -> tuple[float, float, float]:
    if isinstance(value, list | tuple) and len(value) == 3:
        try:
            x, y, z = (float(one) for one in value)
        except (TypeError, ValueError):
            x = y = z = 0.0
        if 0.0 < x * x + y * y + z * z < inf:
            return x, y, z
    raise ValueError(f"is {shown(value)}, but must be a direction in the file's axes such as [0, 0, 1]")


def _checked_place(value: object) -> tuple[float, float, float]:
    try:
        x, y, z = (float(one) for one in value)  # type: ignore[attr-defined]
    except (TypeError, ValueError):
        x = inf
    if not abs(x) < inf:
        raise ValueError(f"is {shown(value)}, but must be a place in mm in the file's axes such as [0, 0, 1.5]")
    return x, y, z


Direction = Annotated[tuple[float, float, float], BeforeValidator(_checked_direction)]
Place = Annotated[tuple[float, float, float], BeforeValidator(_checked_place)]


class MeshKeys(keys.Table):
    """Keys of a body from a mesh file or from a file of its condensed stiffness."""

    file: str | None = Field(
        None,
        description="mesh of the body, gmsh's .msh or Abaqus' .inp, or its condensed stiffness, .npz or .mtx",
        examples=["ball.msh"],
    )
    unit: Annotated[str, PlainValidator(keys.one_of(*MM_PER_UNIT))] | None = Field(
        None, description="unit of the mesh's coordinates"
    )
    contact: str | None = Field(None, description="set of the mesh's faces, or of their nodes, that may touch")
    held: str | None = Field(None, description="set of those that the holder grips")
    outward: Direction | None = Field(
        None, description="direction in the file, from the body to the other one; without it the mean of the contact's"
    )
    along: Direction | None = Field(
        None, description="direction of the body's axis in the file; without it that in which its face is straighter"
    )
    at_mm: Place | None = Field(
        None, description="place in the file, in mm, that touches first; without it the outermost one"
    )
    parts: Mapping[str, ElasticKeys] = Field(
        {}, description="sets of elements of another material than the body's own, each with it"
    )
    digest: str | None = Field(None, description="of the file's contents, noted when it was read")

    @model_validator(mode="before")
    @classmethod
    def _with_digest(cls, table: Any) -> Any:
        if not isinstance(table, Mapping) or not isinstance(name := table.get("file"), str):
            return table
        try:
            # A result or a record that notes the name is read in other folders, too.
            return {**table, "file": str(Path(name).absolute()), "digest": table.get("digest") or digest_of(name)}
        except GeometryError as problem:
            raise ValueError(f"gives a file that cannot be taken: {str(problem).rstrip('.')}") from None


MESH_KEYS = tuple(MeshKeys.model_fields)


def source_of(stated: MeshKeys) -> MeshSource:
    """The file, sets, directions and materials of parts that these keys state; unstated names are empty."""
    return MeshSource(
        stated.file or "",
        stated.digest or "",
        MM_PER_UNIT[stated.unit or "mm"],
        stated.contact or "",
        stated.held or "",
        stated.outward,
        stated.along,
        stated.at_mm,
        tuple((name, one.youngs_modulus_MPa, one.poissons_ratio) for name, one in stated.parts.items()),
    )


def unfit_mesh(stated: MeshKeys, poissons_ratio: float) -> tuple[str, str] | None:
    """(key, rest of a sentence on it) if a key is missing, or the mesh is damaged, of an unlikely size, too coarse
    under the contact, or of elements that lock at this Poisson's ratio; None if it can be taken.
    """
    if problem := _unstated(stated, "mesh", FORMATS, ("file", "unit", "contact", "held")):
        return problem
    try:
        solid = source_of(stated).solid
        size = np.ptp(solid.points, axis=0)
        if not _SMALLEST_mm <= size.max() <= _LARGEST_mm:
            return "unit", (
                f"is {stated.unit!r}, by which the body measures {' × '.join(f'{each:.4g}' for each in size)} mm, but "
                f"its largest extent must lie between {_SMALLEST_mm:g} and {_LARGEST_mm:g} mm: state the unit in which "
                "the file was written"
            )
        own = own_surface(source_of(stated))
    except GeometryError as problem:
        return "file", f"gives a body that cannot be taken: {str(problem).rstrip('.')}"
    if 4 in own.solid.cells and max([poissons_ratio, *(one.poissons_ratio for one in stated.parts.values())]) > _LOCKS:
        return "file", (
            f"holds tetrahedra of 4 nodes, which are far too stiff at a Poisson's ratio above {_LOCKS:g}: mesh it with "
            "tetrahedra of 10 nodes, or with hexahedra"
        )
    if (turn := own.turn_rad) > _TURN:
        return "file", (
            f"is too coarse under the contact: its faces there turn by {degrees(turn):.0f}° from one to the next, but "
            f"must by at most {degrees(_TURN):.0f}°: elements of {own.element_mm * _TURN / turn:.2g} mm would do on a "
            "round face, none on an edge or a tip"
        )
    return None


@dataclass(frozen=True)
class OwnBody(Body):
    """A body from a mesh file, `source`."""

    source: MeshSource

    @property
    def own(self) -> OwnSurface:
        return own_surface(self.source)

    @property
    def curvatures_per_mm(self) -> tuple[float, float]:
        return self.own.curvatures_per_mm

    def geometry(
        self, axial: GradedAxis | RimGradedAxis, transverse: GradedAxis | RimGradedAxis, layering: Layering
    ) -> BodyGeometry:
        """The file's elements if they are a grid that resolves the contact; else a finer block embedded in them."""
        grid = as_grid(self.source, self.bedding_N_per_mm3)
        wanted = (axial, transverse)
        if grid is not None and _resolves(grid, wanted):
            return grid
        reach = max(axis.half_extent_mm for axis in wanted)
        element = self.own.element_within(2.0 * reach)
        along, across, height = self._block(tuple(axis.half_extent_mm for axis in wanted), element)
        coarse = min(max(_FINER * element, axial.finest_mm), 0.25 * min(along, across, height))
        extents = (along, across, height)
        return EmbeddedGeometry(
            *self.curvatures_per_mm,
            *extents,
            axial,
            transverse,
            coarse,
            self.bedding_N_per_mm3,
            layering,
            source=self.source,
        )

    def _block(self, reach_mm: tuple[float, ...], element_mm: float) -> tuple[float, float, float]:
        """Half-widths (along, across) and height in mm of the block under a patch. Raises StudyError if none fits."""
        sharpest = max(self.curvatures_per_mm)
        fall = _FALL / sharpest if sharpest else inf
        widest = [sqrt(fall * (2.0 / curved - fall)) if curved else inf for curved in self.curvatures_per_mm]
        # Its extents are at least so many of the file's elements there.
        least = 2.0 * element_mm
        widths = [min(max(_ROOM * reach, least), wide) for reach, wide in zip(reach_mm, widest, strict=True)]
        height = max(_DEEP * max(reach_mm), least)
        narrowest = [reach / 0.9 for reach in reach_mm]
        while all(width >= low for width, low in zip(widths, narrowest, strict=True)):
            if block_fits(self.own, (widths[0], widths[1]), height):
                return widths[0], widths[1], height
            if all(width <= low for width, low in zip(widths, narrowest, strict=True)) and height < 0.5 * max(reach_mm):
                break
            widths = [max(_SMALLER * width, low) for width, low in zip(widths, narrowest, strict=True)]
            height *= _SMALLER
        raise StudyError(
            f"the {self.name} body is too small for this test: the contact is expected to need "
            f"{1e3 * max(reach_mm):.0f} um to each side of its middle, under which no block of elements fits into the "
            "mesh of its file; give a contact farther from its edges, lower the cycles, load, stroke or wear "
            "coefficient, or give a smaller scar_half_width_um in [mesh]"
        )


def _resolves(grid: OwnGrid, wanted: tuple[GradedAxis | RimGradedAxis, ...]) -> bool:
    """True if a body's own nodes reach as far as wanted along and across, and lie as closely."""
    return all(
        own.half_extent_mm >= asked.half_extent_mm * (1.0 - 1e-6) and own.finest_mm <= asked.finest_mm * (1.0 + 1e-6)
        for own, asked in zip((grid.axial, grid.transverse), wanted, strict=True)
    )


@dataclass(frozen=True)
class StiffBody(Body):
    """A body whose condensed stiffness is read from the file `source`."""

    source: MeshSource

    @property
    def curvatures_per_mm(self) -> tuple[float, float]:
        barrel = of_stiffness(self.source).profile.barrel
        return barrel.curvature_along_per_mm, barrel.curvature_across_per_mm

    def geometry(
        self, axial: GradedAxis | RimGradedAxis, transverse: GradedAxis | RimGradedAxis, layering: Layering
    ) -> BodyGeometry:
        del layering
        grid = of_stiffness(self.source)
        if _resolves(grid, (axial, transverse)):
            return grid
        reach, fine = (
            " × ".join(f"{1e3 * getattr(one, key):.4g}" for one in (axial, transverse))
            for key in ("half_extent_mm", "finest_mm")
        )
        own, least = (
            " × ".join(f"{1e3 * getattr(one, key):.4g}" for one in (grid.axial, grid.transverse))
            for key in ("half_extent_mm", "finest_mm")
        )
        raise StudyError(
            f"the nodes of the {self.name} body reach {own} um to each side, {least} um apart at the least, but this "
            f"test needs {reach} um and {fine} um: give a stiffness with more nodes, or a lower fidelity, load, stroke "
            "or wear"
        )
