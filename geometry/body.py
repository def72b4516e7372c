"""The mesh of a three-dimensional body, all of hexahedra and refined at its contact patch, and its elastic material.

gmsh sweeps a graded cross-section of a quarter of the body (y >= 0, x >= 0) along x; the points are moved where the
body is curved along x, and the quarter is mirrored twice, so the mesh is symmetric to the last bit. The contact patch
is the part of the surface that may touch the other body; the grip is the part that the holder holds.
"""

import ctypes
import signal
from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from typing import Any, Self

import numpy as np

from geometry.arrays import Array, BoolArray, IntArray
from geometry.errors import GeometryError
from geometry.grading import GivenAxis, GradedAxis, Layering, RimGradedAxis, graded_layers
from geometry.mesh import HexMesh, lowered
from geometry.patch import ContactPatch
from geometry.profiles import Profile
from geometry.solid import Host

_HEXAHEDRON = 5


LEAST_SCALED_JACOBIAN = 0.2  #: Elements with a smaller scaled Jacobian than this are refused.

#: Debian's packages of the libraries that gmsh and VTK load; tools/prepare_machine.sh installs them.
SYSTEM_PACKAGES = "libgl1 libglu1-mesa libegl1 libgl1-mesa-dri libxcursor1 libxft2 libxinerama1 libxfixes3 libgomp1"

#: Differences from symmetry, in shares of the largest depth, that come from the computer's arithmetic.
_ROUND_OFF = 1e-9


@contextmanager
def gmsh_session() -> Iterator[Any]:
    """Open a quiet, reproducible gmsh session, give the gmsh module and close the session at the end.

    Raises GeometryError when gmsh cannot be loaded, and in place of any error within the session.
    """
    try:
        import gmsh
    except OSError as error:
        raise GeometryError(
            f"gmsh does not find a library of the system ({error}): install what it and VTK load, on Debian by: "
            f"apt-get install {SYSTEM_PACKAGES}."
        ) from error
    with _pipes_untouched():
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


@contextmanager
def _pipes_untouched() -> Iterator[None]:
    """Restore the process's handler of SIGPIPE afterwards; gmsh sets one that ends the process at a broken pipe."""
    getsig, setsig = ctypes.pythonapi.PyOS_getsig, ctypes.pythonapi.PyOS_setsig
    getsig.restype, setsig.restype, setsig.argtypes = ctypes.c_void_p, ctypes.c_void_p, (ctypes.c_int, ctypes.c_void_p)
    before = getsig(signal.SIGPIPE)
    try:
        yield
    finally:
        setsig(signal.SIGPIPE, before)


def extruded_hexahedra(section: Array, quads: IntArray, lines_mm: Array) -> tuple[Array, IntArray]:
    """Sweep a cross-section along x into hexahedra: points (n k, 3) in mm as (x, y, z), and cells (m (k - 1), 8) in VTK
    order.

    section: (n, 2) points (y, z) in mm. quads: (m, 4) their indices, counter-clockwise. lines_mm: (k,) positions of the
    mesh's cross-sections on x, the first 0. Raises GeometryError when gmsh leaves other elements than hexahedra.
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


class BodyGeometry(ABC):
    """Dimensions and mesh sizes from which the mesh of a body is built; lengths in mm.

    In the body's own frame x is its axis, the origin the point of first contact and +z the outward normal there.
    """

    axial: GradedAxis | RimGradedAxis | GivenAxis  #: Grading of the contact patch along the body.
    transverse: GradedAxis | RimGradedAxis | GivenAxis  #: Grading of the contact patch across the body.
    coarse_mm: float  #: Largest element far from the contact.
    layering: Layering  #: Thicknesses of the elements' layers under the patch.
    grip_stiffness_N_per_mm3: float | None  #: Stiffness of the grip per area; None if the grip is rigid.

    @property
    @abstractmethod
    def profile(self) -> Profile:
        """Height of the unworn surface in the contact patch."""

    @property
    def meshed_profile(self) -> Profile:
        """Height of the surface that is meshed, by default `profile`. Elements that lie above `profile`, on the side of
        the other body, count as already worn away there: contact sees `profile`, stiffness the elements.
        """
        return self.profile

    @property
    @abstractmethod
    def half_length_mm(self) -> float:
        """Half of the body's extent along its axis x."""

    @property
    @abstractmethod
    def least_extent_mm(self) -> float:
        """Smallest dimension of the body, a tube's wall included."""

    @abstractmethod
    def section(self) -> tuple[Array, IntArray]:
        """Half of the cross-section that is swept along x: points (n, 2) in mm as (y >= 0, z), and quads (m, 4), their
        indices counter-clockwise.
        """

    @abstractmethod
    def gripped(self, centres_mm: Array) -> BoolArray:
        """(n,) True for each boundary facet that the holder grips, by the facets' centres (n, 3) in mm."""

    def bent(self, points_mm: Array) -> Array:
        """Positions (n, 3) in mm to which points (n, 3) of the straight swept quarter move; by default their own."""
        return points_mm

    def fitted(self, points_mm: Array) -> Array:
        """Positions (n, 3) in mm to which points (n, 3) of the whole mesh move, after `bent`; by default their own."""
        return points_mm

    def built(self) -> "BodyMesh":
        """The mesh of this body. Raises GeometryError as `build_body`."""
        return swept_body(self)

    @property
    def round_mm(self) -> float | None:
        """Radius of a round bar, for drawing the chords of its coarse elements as arcs; None for other bodies."""
        return None

    @property
    def finest_mm(self) -> float:
        return min(axis.finest_mm for axis in (self.axial, self.transverse))

    @property
    def layers(self) -> tuple[float, float]:
        """Thickness of the uppermost elements under the patch in mm, and the factor by which it grows downwards."""
        return self.layering.first * self.finest_mm, self.layering.growth

    def as_table(self) -> dict[str, object]:
        """All dimensions by name as nested plain values, for JSON."""
        return asdict(self)  # type: ignore[call-overload,no-any-return]

    def with_layering(self, layering: Layering) -> Self:
        return replace(self, layering=layering)  # type: ignore[type-var]


@dataclass(frozen=True)
class BodyMesh:
    """The mesh of a body in the body's own frame.

    The mesh's boundary has the named surfaces 'contact' (the patch), 'grip' (held by the holder), 'ends' (the parts of
    the two end faces that are not held) and 'side' (the rest).
    """

    geometry: BodyGeometry  #: From which the mesh was built.
    mesh: HexMesh
    patch: ContactPatch
    smallest_scaled_jacobian: float  #: Of all elements: 1 for a right-angled brick, 0 or less if inside out.
    #: The file's elements around the mesh, with which its surface 'grip' then moves; None for a whole body.
    host: Host | None = None

    @property
    def bedding(self) -> Array | None:
        """(n,) stiffness in N/mm by which an elastic grip holds each node of the mesh, or of its host's if it has one;
        None where the grip is rigid.
        """
        stiffness = self.geometry.grip_stiffness_N_per_mm3
        if stiffness is None:
            return None
        return stiffness * (self.mesh.surface_areas("grip") if self.host is None else self.host.areas_mm2)

    def beneath_patch(self, reach: float) -> BoolArray:
        """(n,) nodes of the box that leaves the patch on each side and below by `reach` times its least half-width."""
        patch, points = self.patch, self.mesh.points
        ends = np.array([[lines[0], lines[-1]] for lines in (patch.axial_mm, patch.transverse_mm)])
        farther = 0.5 * reach * float(np.ptp(ends, axis=1).min())
        low = np.append(ends[:, 0], points[patch.nodes, 2].min()) - farther
        high = np.append(ends[:, 1] + farther, np.inf)
        return np.asarray(((points >= low) & (points <= high)).all(axis=1))

    def worn(self, depth_mm: Array, moving: BoolArray | None = None) -> "BodyMesh":
        """A copy of this mesh with the nodes of its patch moved down by a depth (n_a, n_t) in mm along z, on top of
        earlier ones; the patch's `height` is then that of the worn surface. moving: (n,) nodes that may move with
        them, None for all.

        Raises GeometryError, naming the element's place, when the scaled Jacobian of an element falls below
        LEAST_SCALED_JACOBIAN.
        """
        patch, depth_mm = self.patch, _without_round_off(depth_mm)
        mesh = lowered(self.mesh, patch.nodes.ravel(), depth_mm.ravel(), moving)
        smallest = mesh.require_quality(LEAST_SCALED_JACOBIAN)
        before = 0.0 if patch.repositioned_depth_mm is None else patch.repositioned_depth_mm
        return replace(
            self,
            mesh=mesh,
            patch=replace(patch, repositioned_depth_mm=before + depth_mm),
            smallest_scaled_jacobian=smallest,
        )


def _without_round_off(depth_mm: Array) -> Array:
    """The depth (n_a, n_t), made exactly symmetric along or across the body where it is symmetric within round-off."""
    for axis in (0, 1):
        image = np.flip(depth_mm, axis)
        if np.abs(depth_mm - image).max() <= _ROUND_OFF * np.abs(depth_mm).max():
            depth_mm = 0.5 * (depth_mm + image)
    return depth_mm


def build_body(geometry: BodyGeometry) -> BodyMesh:
    """The mesh of a body, built by `geometry.built`.

    Raises GeometryError when gmsh fails, leaves other elements than hexahedra, or the scaled Jacobian of an element is
    below LEAST_SCALED_JACOBIAN.
    """
    return geometry.built()


def swept_body(geometry: BodyGeometry) -> BodyMesh:
    """The mesh that is swept from a body's cross-section. Raises GeometryError as `build_body`."""
    # Mesh lines (k,) in mm on x from the middle to the body's end: the patch's lines, then ever wider spacings.
    patch_lines = geometry.axial.half_lines()
    last = patch_lines[-1] - patch_lines[-2]
    rest = geometry.half_length_mm - patch_lines[-1]
    layers = graded_layers(min(last * 1.3, rest), 1.35, 1.5 * geometry.coarse_mm, rest)
    points, cells = extruded_hexahedra(
        *geometry.section(), np.concatenate([patch_lines, patch_lines[-1] + np.cumsum(layers)])
    )
    mesh = HexMesh(geometry.bent(points), cells, {}).with_mirror_image(axis=1).with_mirror_image(axis=0)
    mesh = HexMesh(geometry.fitted(mesh.points), mesh.cells, {})
    smallest = mesh.require_quality(LEAST_SCALED_JACOBIAN)
    patch = _patch(geometry, mesh)
    named = HexMesh(mesh.points, mesh.cells, _named_surfaces(geometry, mesh, patch))
    return BodyMesh(geometry, named, patch, smallest)


def _patch(geometry: BodyGeometry, mesh: HexMesh) -> ContactPatch:
    axial, transverse, profile = geometry.axial.lines(), geometry.transverse.lines(), geometry.profile
    x, y, z = mesh.points.T
    tolerance = 1e-3 * min(np.diff(axial).min(), np.diff(transverse).min())
    above = np.flatnonzero((np.abs(x) < axial[-1] + tolerance) & (np.abs(y) < transverse[-1] + tolerance))
    nodes = above[np.abs(z[above] - geometry.meshed_profile.height(mesh.points[above, :2])) < tolerance]
    i = _nearest(axial, x[nodes])
    j = _nearest(transverse, y[nodes])
    grid = np.full((len(axial), len(transverse)), -1, dtype=np.int64)
    grid[i, j] = nodes
    if len(nodes) != grid.size or np.any(grid < 0):
        raise GeometryError(
            f"the contact patch has {len(nodes)} surface nodes where {grid.size} were planned; please report this study"
        )
    return ContactPatch(axial, transverse, grid, profile)


def _nearest(lines: Array, values: Array) -> IntArray:
    return np.asarray(np.abs(values[:, None] - lines[None, :]).argmin(axis=1))


def _named_surfaces(geometry: BodyGeometry, mesh: HexMesh, patch: ContactPatch) -> dict[str, IntArray]:
    facets = mesh.boundary_facets()
    rest = facets[~np.isin(facets, patch.nodes).all(axis=1)]
    gripped = geometry.gripped(mesh.points[rest].mean(axis=1))
    at_end = (np.abs(mesh.points[rest, 0]) > geometry.half_length_mm * (1.0 - 1e-9)).all(axis=1)
    return {
        "contact": patch.facets(),
        "grip": rest[gripped],
        "side": rest[~gripped & ~at_end],
        "ends": rest[~gripped & at_end],
    }


@dataclass(frozen=True)
class Elastic:
    """An isotropic linear elastic material. Raises ValueError unless the modulus is positive and Poisson's ratio
    between 0 and 0.5.
    """

    youngs_modulus_MPa: float
    poissons_ratio: float

    def __post_init__(self) -> None:
        if not self.youngs_modulus_MPa > 0.0:
            raise ValueError(f"youngs_modulus_MPa must be positive, not {self.youngs_modulus_MPa:g}")
        if not 0.0 <= self.poissons_ratio <= 0.5:
            raise ValueError(f"poissons_ratio must lie between 0 and 0.5, not {self.poissons_ratio:g}")

    @property
    def shear_modulus_MPa(self) -> float:
        """Shear modulus G = E / (2 (1 + ν))."""
        return self.youngs_modulus_MPa / (2.0 * (1.0 + self.poissons_ratio))

    @property
    def lame_MPa(self) -> float:
        """Lamé's first parameter λ = 2 G ν / (1 - 2 ν)."""
        return 2.0 * self.shear_modulus_MPa * self.poissons_ratio / (1.0 - 2.0 * self.poissons_ratio)
