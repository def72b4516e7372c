"""All-hexahedral mesh of one wire, refined at its contact patch, built with gmsh.

A quarter of the wire (y >= 0, x >= 0) is swept by gmsh from a graded cross-section and mirrored twice, so the mesh is
symmetric to the last bit.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from math import pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.errors import GeometryError
from geometry.grading import GradedAxis, Layering, graded_layers
from geometry.hexmesh import HexMesh
from geometry.mesh_motion import lowered
from geometry.patch import ContactPatch
from geometry.profiles import Cylinder
from geometry.wire_section import wire_section

_HEXAHEDRON = 5

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

#: Elements with a smaller scaled Jacobian than this are refused.
LEAST_SCALED_JACOBIAN = 0.2

#: Differences from symmetry, in shares of the largest depth, that come from the computer's arithmetic.
_ROUND_OFF = 1e-9


@contextmanager
def gmsh_session() -> Iterator[Any]:
    """A quiet, reproducible gmsh session; gmsh's own errors become GeometryError."""
    import gmsh

    gmsh.initialize(interruptible=False)
    try:
        for name, value in {"General.Terminal": 0, "General.NumThreads": 1, "Mesh.RandomSeed": 1}.items():
            gmsh.option.setNumber(name, value)
        yield gmsh
    except GeometryError:
        raise
    except Exception as error:
        raise GeometryError(f"gmsh could not mesh the body: {error}") from error
    finally:
        gmsh.finalize()


def extruded_hexahedra(section: Array, quads: IntArray, lines_mm: Array) -> tuple[Array, IntArray]:
    """Sweep a section along x.

    section: (n, 2) points (y, z) in mm; quads: (m, 4) counter-clockwise; lines_mm: (k,) mesh lines on x, first one 0.
    Returns points (n k, 3) and cells (m (k - 1), 8) in VTK order; GeometryError when gmsh leaves anything but
    hexahedra.
    """
    with gmsh_session() as gmsh:
        geo = gmsh.model.geo
        vertices = [geo.addPoint(y, z, 0.0) for y, z in section]
        lines: dict[tuple[int, int], int] = {}

        def line(a: int, b: int) -> int:
            if (b, a) in lines:
                return -lines[b, a]
            if (a, b) not in lines:
                lines[a, b] = int(geo.addLine(vertices[a], vertices[b]))
            return lines[a, b]

        surfaces = []
        for quad in quads.tolist():
            loop = geo.addCurveLoop([line(quad[i], quad[(i + 1) % 4]) for i in range(4)])
            surfaces.append((2, int(geo.addPlaneSurface([loop]))))
        for tag in lines.values():
            geo.mesh.setTransfiniteCurve(tag, 2)
        for _, tag in surfaces:
            geo.mesh.setTransfiniteSurface(tag)
            geo.mesh.setRecombine(2, tag)
        # Else gmsh looks for coincident entities after every single quadrilateral.
        gmsh.option.setNumber("Geometry.AutoCoherence", 0)
        length = float(lines_mm[-1])
        layers = [1] * (len(lines_mm) - 1)
        geo.extrude(surfaces, 0.0, 0.0, length, layers, list(lines_mm[1:] / length), recombine=True)
        geo.removeAllDuplicates()
        geo.synchronize()
        gmsh.model.mesh.generate(3)
        return _collect(gmsh)


def _collect(gmsh: Any) -> tuple[Array, IntArray]:
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    types, _, _ = gmsh.model.mesh.getElements(3)
    if list(types) != [_HEXAHEDRON]:
        raise GeometryError("gmsh left other elements than hexahedra in the body; please report this study")
    cells = gmsh.model.mesh.getElementsByType(_HEXAHEDRON)[1].astype(np.int64).reshape(-1, 8)
    row = np.full(int(tags.max()) + 1, -1, dtype=np.int64)
    row[tags.astype(np.int64)] = np.arange(len(tags))
    used = np.unique(row[cells])
    new = np.full(len(tags), -1, dtype=np.int64)
    new[used] = np.arange(len(used))
    y, z, x = coordinates.reshape(-1, 3)[used].T
    return np.column_stack([x, y, z]), new[row[cells]]


@dataclass(frozen=True)
class WireGeometry:
    """What a wire's mesh is built from; lengths in mm.

    axial, transverse: gradings of the contact patch along and across the wire.
    coarse_mm: largest element far from the contact.
    layering: of the elements under the patch.
    grip_half_angle_rad: half of the sector of the lateral surface, measured from the back, that the holder grips.
    """

    diameter_mm: float
    length_mm: float
    axial: GradedAxis
    transverse: GradedAxis
    coarse_mm: float
    grip_half_angle_rad: float = pi / 4
    grip_half_length_mm: float | None = None
    grip_stiffness_N_per_mm3: float | None = None
    layering: Layering = field(default_factory=Layering)

    def __post_init__(self) -> None:
        if not self.diameter_mm > 0.0:
            raise GeometryError(f"a wire's diameter must be positive, but is {self.diameter_mm} mm")
        if self.transverse.half_extent_mm > 0.42 * self.diameter_mm:
            raise GeometryError(
                f"the contact patch reaches {self.transverse.half_extent_mm:.4g} mm to each side of a wire of diameter "
                f"{self.diameter_mm} mm; at most 0.42 diameters can be meshed"
            )
        if self.axial.half_extent_mm > 0.45 * self.length_mm:
            raise GeometryError(
                f"the contact patch reaches {self.axial.half_extent_mm:.4g} mm to each side along a wire of length "
                f"{self.length_mm} mm; it must leave a tenth of the length free: give a longer wire"
            )
        if self.grip_half_length_mm is not None and not self.grip_half_length_mm > 0.0:
            raise GeometryError(f"the grip's half-length must be positive, but is {self.grip_half_length_mm} mm")
        if self.grip_stiffness_N_per_mm3 is not None and not self.grip_stiffness_N_per_mm3 > 0.0:
            raise GeometryError(f"the grip's stiffness must be positive, but is {self.grip_stiffness_N_per_mm3} N/mm³")
        if not 0.1 <= self.grip_half_angle_rad <= 2.0:
            raise GeometryError(f"the grip's half-angle must lie in 0.1 ... 2 rad, but is {self.grip_half_angle_rad}")

    @property
    def radius_mm(self) -> float:
        """Radius of the wire."""
        return self.diameter_mm / 2.0

    @property
    def layers(self) -> tuple[float, float]:
        """Thickness of the uppermost elements under the patch in mm, and the factor by which it grows downwards."""
        finest = min(float(axis.half_lines()[1]) for axis in (self.axial, self.transverse))
        return self.layering.first * finest, self.layering.growth

    def refined(self, factor: float) -> WireGeometry:
        """A copy whose elements are smaller by `factor` everywhere."""

        def finer(axis: GradedAxis) -> GradedAxis:
            return replace(
                axis,
                fine_mm=axis.fine_mm / factor,
                outer_mm=axis.outer_mm / factor,
                growth=axis.growth ** (1.0 / factor),
            )

        return replace(
            self,
            axial=finer(self.axial),
            transverse=finer(self.transverse),
            coarse_mm=self.coarse_mm / factor,
            layering=self.layering.refined(factor),
        )


@dataclass(frozen=True)
class WireMesh:
    """A meshed wire in its own frame: axis along x, contact at the origin facing +z.

    The mesh's surfaces are named 'contact' (the patch), 'grip' (held by the holder), 'side' (rest of the lateral
    surface) and 'ends'.
    """

    geometry: WireGeometry
    mesh: HexMesh
    patch: ContactPatch
    smallest_scaled_jacobian: float

    @property
    def bedding(self) -> Array | None:
        """Stiffness (n,) in N/mm by which an elastic grip holds each node, None where the grip is rigid."""
        stiffness = self.geometry.grip_stiffness_N_per_mm3
        return None if stiffness is None else stiffness * self.mesh.surface_areas("grip")

    def worn(self, depth_mm: Array) -> WireMesh:
        """This mesh with the nodes of its patch moved into a surface worn by a vertical depth (n_a, n_t).

        The patch's height is that of the moved nodes. GeometryError when the depth has another shape than the patch or
        is negative somewhere, or naming the place of an element that the motion distorts too much.
        """
        patch = self.patch
        if depth_mm.shape != patch.shape:
            raise GeometryError(f"a depth of shape {depth_mm.shape} does not belong to a patch of shape {patch.shape}")
        depth_mm = _without_round_off(depth_mm)
        mesh = lowered(self.mesh, patch.nodes.ravel(), depth_mm.ravel())
        smallest = mesh.require_quality(LEAST_SCALED_JACOBIAN)
        before = 0.0 if patch.repositioned_depth_mm is None else patch.repositioned_depth_mm
        return replace(
            self,
            mesh=mesh,
            patch=replace(patch, repositioned_depth_mm=before + depth_mm),
            smallest_scaled_jacobian=smallest,
        )


def _without_round_off(depth_mm: Array) -> Array:
    """A depth that is its own mirror image along or across the wire but for round-off, made so to the last bit."""
    for axis in (0, 1):
        image = np.flip(depth_mm, axis)
        if np.abs(depth_mm - image).max() <= _ROUND_OFF * np.abs(depth_mm).max():
            depth_mm = 0.5 * (depth_mm + image)
    return depth_mm


def build_wire(geometry: WireGeometry) -> WireMesh:
    """Mesh a wire; GeometryError when gmsh fails, leaves other elements than hexahedra or elements are distorted."""
    across = geometry.transverse.half_lines()
    finest = min(float(geometry.axial.half_lines()[1]), float(across[1]))
    section, quads = wire_section(geometry.radius_mm, across, geometry.coarse_mm, geometry.layering, finest)
    points, cells = extruded_hexahedra(section, quads, _half_lines_to_end(geometry))
    mesh = HexMesh(points, cells, {}).with_mirror_image(axis=1).with_mirror_image(axis=0)
    smallest = mesh.require_quality(LEAST_SCALED_JACOBIAN)
    patch = _patch(geometry, mesh)
    named = HexMesh(mesh.points, mesh.cells, _named_surfaces(geometry, mesh, patch))
    return WireMesh(geometry, named, patch, smallest)


def _half_lines_to_end(geometry: WireGeometry) -> Array:
    """Mesh lines along half the wire, from the middle to the end: the patch's lines, then growing ones."""
    patch_lines = geometry.axial.half_lines()
    last = patch_lines[-1] - patch_lines[-2]
    rest = geometry.length_mm / 2.0 - patch_lines[-1]
    layers = graded_layers(min(last * 1.3, rest), 1.35, 1.5 * geometry.coarse_mm, rest)
    return np.concatenate([patch_lines, patch_lines[-1] + np.cumsum(layers)])


def _patch(geometry: WireGeometry, mesh: HexMesh) -> ContactPatch:
    axial, transverse = geometry.axial.lines(), geometry.transverse.lines()
    radius = geometry.radius_mm
    y, z = mesh.points[:, 1], mesh.points[:, 2]
    on_surface = np.abs(np.hypot(y, z + radius) - radius) < 1e-6 * radius
    tolerance = 1e-3 * min(np.diff(axial).min(), np.diff(transverse).min())
    inside = (
        on_surface
        & (z > -radius)
        & (np.abs(mesh.points[:, 0]) < axial[-1] + tolerance)
        & (np.abs(y) < transverse[-1] + tolerance)
    )
    nodes = np.flatnonzero(inside)
    i = _nearest(axial, mesh.points[nodes, 0])
    j = _nearest(transverse, y[nodes])
    grid = np.full((len(axial), len(transverse)), -1, dtype=np.int64)
    grid[i, j] = nodes
    if len(nodes) != grid.size or np.any(grid < 0):
        raise GeometryError(
            f"the contact patch has {len(nodes)} surface nodes where {grid.size} were planned; please report this study"
        )
    return ContactPatch(axial, transverse, grid, Cylinder(radius))


def _nearest(lines: Array, values: Array) -> IntArray:
    return np.asarray(np.abs(values[:, None] - lines[None, :]).argmin(axis=1))


def _named_surfaces(geometry: WireGeometry, mesh: HexMesh, patch: ContactPatch) -> dict[str, IntArray]:
    n = patch.nodes
    contact = np.stack([n[:-1, :-1], n[1:, :-1], n[1:, 1:], n[:-1, 1:]], axis=-1).reshape(-1, 4)
    facets = mesh.boundary_facets()
    at_end = (np.abs(mesh.points[facets, 0]) > geometry.length_mm / 2.0 * (1.0 - 1e-9)).all(axis=1)
    lateral = facets[~at_end]
    centres = mesh.points[lateral].mean(axis=1)
    from_back = np.abs(np.arctan2(centres[:, 1], -(centres[:, 2] + geometry.radius_mm)))
    in_patch = np.isin(lateral, n).all(axis=1)
    gripped = (from_back <= geometry.grip_half_angle_rad) & ~in_patch
    if geometry.grip_half_length_mm is not None:
        gripped &= np.abs(centres[:, 0]) <= geometry.grip_half_length_mm
    return {
        "contact": contact,
        "grip": lateral[gripped],
        "side": lateral[~gripped & ~in_patch],
        "ends": facets[at_end],
    }
