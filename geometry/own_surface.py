"""The contact surface of a body from a file: the point of first contact, its axes there, and the smooth face under a
patch.

A mesh's nodes lie on the surface that was meant, but its faces are chords of it. So a barrel is fitted through the
nodes. If it meets all of them, it is the face; otherwise the nodes' heights above it are interpolated with continuous
slopes and added. The body's own axes are x along its axis, z along the outward normal, with the origin at the first
contact; the plane is that of x and y. A set is a group of nodes, faces or cells that the file names.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import degrees
from typing import TYPE_CHECKING

import numpy as np

from geometry.arrays import Array, IntArray
from geometry.errors import GeometryError
from geometry.mesh_files import read_solid
from geometry.profiles import Barrel
from geometry.solid import SolidMesh

if TYPE_CHECKING:
    from scipy.interpolate import CloughTocher2DInterpolator, NearestNDInterpolator

Vector = tuple[float, float, float]

_NODES = 60  #: Nodes nearest to the first contact through which a face is fitted at first.
_STRAIGHT = 1e-6  #: Curvature times the surface's size below which it counts as straight.
_EXACT = 1e-7  #: Distance of nodes from a barrel over the surface's size below which it is the face.
_ROUND = 0.05  #: Difference of curvatures, over the larger, from which one of them shows the axis.
_STEPS = 30


@dataclass(frozen=True)
class MeshSource:
    """The mesh file of a body, and the sets and directions in it that define the body."""

    file: str
    digest: str  #: SHA-256 of its contents.
    mm_per_unit: float  #: Length in mm of the file's unit.
    contact: str  #: Name of the set of the contact surface.
    held: str  #: Name of the set of the held surface.
    #: Contact's outward normal, of any length, in the file's axes; None: the mean normal of its set.
    outward: Vector | None = None
    #: Body's axis, of any length, in the file's axes; None: the direction in which its face is straighter.
    along: Vector | None = None
    at_mm: Vector | None = None  #: Point of first contact in the file's axes; None: the outermost point.
    #: Sets of cells of other materials, each (name, Young's modulus in MPa, Poisson's ratio).
    parts: tuple[tuple[str, float, float], ...] = ()

    @property
    def solid(self) -> SolidMesh:
        return read_solid(self.file, self.digest, self.mm_per_unit)


@dataclass(frozen=True, eq=False)
class FittedFace:
    """The smooth face of a body from a file, a `Profile`: a barrel plus interpolated heights of n nodes above it."""

    barrel: Barrel
    nodes_mm: Array  #: (n, 2) places of the nodes in the plane.
    off_mm: Array  #: (n,) their heights above the barrel; (0,) if the barrel meets all of them.

    def height(self, plane_mm: Array) -> Array:
        height = self.barrel.height(plane_mm)
        if not len(self.off_mm):
            return height
        return np.asarray(height + self._off(plane_mm))

    def slope(self, plane_mm: Array) -> Array:
        slope = self.barrel.slope(plane_mm)
        if not len(self.off_mm):
            return slope
        step = 1e-5 * float(np.ptp(self.nodes_mm, axis=0).max())
        for axis, shift in enumerate(step * np.eye(2)):
            slope[:, axis] += (self._off(plane_mm + shift) - self._off(plane_mm - shift)) / (2.0 * step)
        return slope

    def require_within(self, along_mm: float, across_mm: float) -> None:
        self.barrel.require_within(along_mm, across_mm)

    def _off(self, plane_mm: Array) -> Array:
        smooth, nearest = self._interpolated
        found = smooth(plane_mm)
        beside = np.isnan(found)
        found[beside] = nearest(plane_mm[beside])
        return np.asarray(found)

    @cached_property
    def _interpolated(self) -> tuple[CloughTocher2DInterpolator, NearestNDInterpolator]:
        from scipy.interpolate import CloughTocher2DInterpolator, NearestNDInterpolator

        return (
            CloughTocher2DInterpolator(self.nodes_mm, self.off_mm),
            NearestNDInterpolator(self.nodes_mm, self.off_mm),
        )


@dataclass(frozen=True, eq=False)
class OwnSurface:
    """The mesh of a file in the body's own axes, with the smooth face of its contact surface."""

    solid: SolidMesh  #: In the body's own axes.
    face: FittedFace
    axes: Array  #: (3, 3) rows are x, y and z in the file's axes.
    #: (t, 3) faces of the contact's set, split into triangles, that look along z within 60 degrees.
    triangles: IntArray
    nodes: IntArray  #: Indices of the nodes of these faces, those on edges included.
    off_mm: float  #: Largest distance of those nodes from the fitted barrel.

    @property
    def curvatures_per_mm(self) -> tuple[float, float]:
        """Curvatures of the fitted barrel (along, across) the body's axis, never negative."""
        return self.face.barrel.curvature_along_per_mm, self.face.barrel.curvature_across_per_mm

    @cached_property
    def element_mm(self) -> float:
        """Size of the file's elements around the point of first contact."""
        return self.element_within(0.0)

    @property
    def turn_rad(self) -> float:
        """Largest angle between the normals of the file's faces that meet at the node nearest to the first contact."""
        nearest = self.nodes[np.linalg.norm(self.solid.points[self.nodes], axis=1).argmin()]
        about = self.triangles[(self.triangles == nearest).any(axis=1)]
        about = (
            about
            if len(about)
            else self.triangles[(self.solid.points[self.triangles] ** 2).sum(axis=(1, 2)).argsort()[:4]]
        )
        normals = _normals(self.solid.points, about)
        normals = normals / np.linalg.norm(normals, axis=1)[:, None]
        return float(np.arccos(np.clip(normals @ normals.T, -1.0, 1.0)).max())

    def element_within(self, reach_mm: float) -> float:
        """Size in mm of elements near the first contact: the 90th percentile over those within `reach_mm` of it, and at
        least the eight nearest.
        """
        away = np.linalg.norm(self.solid.middles, axis=1)
        near = (away <= reach_mm) | (away <= np.partition(away, min(7, len(away) - 1))[min(7, len(away) - 1)])
        return float(np.percentile(self.solid.edges_mm[near], 90.0))


@lru_cache(maxsize=4)
def own_surface(source: MeshSource) -> OwnSurface:
    """The body of a file in its own axes. Results are kept for the last four files.

    Raises GeometryError, in one sentence, if the file cannot be read or its contact surface cannot be used.
    """
    solid = source.solid
    for role, name in (("contact", source.contact), ("held", source.held)):
        _require_set(solid, role, name)
    contact, held = (np.unique(solid.triangles_of(name)) for name in (source.contact, source.held))
    # Beside an edge both sets may share a few faces, all of whose corners are on it.
    if np.isin(contact, held).mean() > 0.5:
        raise GeometryError(
            f"most of its contact surface {source.contact!r} is in the held set {source.held!r}, too: what touches "
            "must be free to give way"
        )
    for name, *_ in source.parts:
        if name not in solid.parts:
            raise GeometryError(_without(name, "of elements with a material of its own", solid.parts))
    triangles = solid.triangles_of(source.contact)
    outward = _outward(solid, triangles, source)
    normals = _normals(solid.points, triangles)
    size = np.linalg.norm(normals, axis=1)
    # Faces are fitted whose normal's share along the outward direction is at least this.
    triangles = triangles[normals @ outward >= 0.5 * size]
    if not len(triangles):
        raise GeometryError(f"no face of its set {source.contact!r} looks along outward within 60°: state its normal")
    corners = np.unique(triangles)
    nodes = solid.nodes_between(corners)
    points = solid.points
    axes = _any_axes(outward, source)
    scale = float(np.ptp(points[corners], axis=0).max())
    if source.at_mm is None:
        start = _outermost(points, corners, triangles, outward)
    else:
        start = _stated_place(points, corners, triangles, np.array(source.at_mm))
    origin, form = _apex(points[nodes], start, axes, scale, moves=source.at_mm is None)
    axes = _principal(axes, form, source)
    local = (points - origin) @ axes.T
    barrel, shift = _barrel(local[nodes], scale, moves=source.at_mm is None)
    # A node that is as near is taken for the place, which keeps the symmetry of a symmetric mesh.
    origin = origin + shift @ axes
    away = np.linalg.norm(points[nodes] - origin, axis=1)
    origin = points[nodes[away.argmin()]] if away.min() <= _EXACT * scale else origin
    local = (points - origin) @ axes.T
    off = local[nodes, 2] - barrel.height(local[nodes, :2])
    largest = float(np.abs(off).max())
    face = FittedFace(barrel, local[nodes, :2], np.zeros(0))
    if largest > _EXACT * scale:
        face = FittedFace(barrel, local[nodes, :2], off)
        rise = np.array([0.0, 0.0, float(face.height(np.zeros((1, 2)))[0])])
        face, local, origin = FittedFace(barrel, local[nodes, :2], off - rise[2]), local - rise, origin + rise @ axes
    return OwnSurface(solid.moved(local), face, axes, triangles, nodes, largest)


def face_through(nodes: Array) -> FittedFace:
    """The smooth face through nodes (n, 3) in a body's own axes, which touches the plane z = 0 at the origin.

    Raises GeometryError, in one sentence, if it does not, or is hollow.
    """
    scale = float(np.ptp(nodes[:, :2], axis=0).max())
    barrel, _ = _barrel(nodes, scale, moves=False)
    off = nodes[:, 2] - barrel.height(nodes[:, :2])
    face = FittedFace(barrel, nodes[:, :2], off if np.abs(off).max() > _EXACT * scale else np.zeros(0))
    if abs(height := float(face.height(np.zeros((1, 2)))[0])) > 1e-3 * scale:
        raise GeometryError(f"its surface lies {height:.3g} mm above the origin, but touches first there")
    return face


def _require_set(solid: SolidMesh, role: str, name: str) -> None:
    what = f"of the {role} surface"
    if name not in solid.sets:
        raise GeometryError(_without(name, what, solid.sets))
    if not sum(map(len, solid.faces_of(name))):
        raise GeometryError(
            f"its set {name!r} {what} holds no whole face of the body's boundary: name faces, or all of their nodes"
        )


def _without(name: str, what: str, sets: object) -> str:
    known = ", ".join(repr(one) for one in sets) if sets else "no sets at all"  # type: ignore[attr-defined]
    return f"it has no set {name!r} {what}, but {known}"


def _normals(points: Array, triangles: IntArray) -> Array:
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return np.asarray(np.cross(b - a, c - a))


def _outward(solid: SolidMesh, triangles: IntArray, source: MeshSource) -> Array:
    """Outward unit normal (3,) of the contact, in the file's axes."""
    if source.outward is not None:
        outward = np.array(source.outward)
        return np.asarray(outward / np.linalg.norm(outward))
    normals = _normals(solid.points, triangles)
    mean = normals.sum(axis=0) / np.linalg.norm(normals, axis=1).sum()
    length = float(np.linalg.norm(mean))
    # The mean normal of half a ball is 0.5.
    if length < 0.3:
        raise GeometryError(
            f"its set {source.contact!r} faces all ways round, so its normal is not known: state it, as in "
            "outward = [0, 0, 1]"
        )
    mean = mean / length
    # A face that was meant to look along an axis does so.
    rounded = np.round(mean)
    return np.asarray(rounded if np.abs(mean - rounded).max() < 2e-3 else mean)


def _any_axes(outward: Array, source: MeshSource) -> Array:
    """Rows x, y and z (3, 3) in the file's axes: z outwards, x along the stated axis or, without one, along an axis of
    the file.
    """
    along = np.eye(3)[0 if abs(outward[0]) < 0.9 else 1] if source.along is None else np.array(source.along)
    x = along - (along @ outward) * outward
    if np.linalg.norm(x) < 1e-3 * np.linalg.norm(along):
        raise GeometryError("along is the direction of the contact's normal, but must lie in its face")
    x = x / np.linalg.norm(x)
    return np.stack([x, np.cross(outward, x), outward])


def _outermost(points: Array, nodes: IntArray, triangles: IntArray, outward: Array) -> Array:
    """Centre (3,) of the outermost part of the contact surface: of its facets, if there are any, or of its nodes."""
    height = points[nodes] @ outward
    top = nodes[height >= height.max() - 1e-6 * float(np.ptp(points[nodes], axis=0).max())]
    whole = triangles[np.isin(triangles, top).all(axis=1)]
    if len(whole):
        size = np.linalg.norm(_normals(points, whole), axis=1)
        return np.asarray((points[whole].mean(axis=1) * size[:, None]).sum(axis=0) / size.sum())
    return np.asarray(0.5 * (points[top].min(axis=0) + points[top].max(axis=0)))


def _stated_place(points: Array, nodes: IntArray, triangles: IntArray, place: Array) -> Array:
    """The place (3,), stated as that of first contact. Raises GeometryError if it lies off the contact surface."""
    nearest = nodes[np.linalg.norm(points[nodes] - place, axis=1).argmin()]
    away = float(np.linalg.norm(points[nearest] - place))
    if away > float(np.linalg.norm(np.diff(points[triangles], axis=1), axis=2).max()):
        raise GeometryError(
            f"at_mm lies {away:.3g} mm from the nearest node of its contact surface: state a place on it"
        )
    return place


def _apex(nodes: Array, start: Array, axes: Array, scale: float, *, moves: bool) -> tuple[Array, Array]:
    """Position (3,) of the surface's highest point and its curvature matrix (2, 2) there, by paraboloids through near
    nodes.
    """
    origin = start
    for _ in range(_STEPS):
        local = (nodes - origin) @ axes.T
        near = np.argsort((local**2).sum(axis=1))[:_NODES]
        if len(near) < 6:
            raise GeometryError(
                f"its contact surface has {len(nodes)} nodes, which do not show how it is curved: mesh it more finely"
            )
        x, y, z = local[near].T
        columns = np.column_stack([np.ones_like(x), x, y, 0.5 * x**2, x * y, 0.5 * y**2])
        weight = np.exp(-0.5 * (x**2 + y**2) / max(float((x**2 + y**2).mean()), 1e-300))[:, None]
        found, *_ = np.linalg.lstsq(columns * weight, z * weight[:, 0], rcond=None)
        form = -np.array([[found[3], found[4]], [found[4], found[5]]])
        if not moves:
            _require_level(found[1:3], axes)
            break
        values, vectors = np.linalg.eigh(form)
        step = np.zeros(2)
        for value, vector in zip(values, vectors.T, strict=True):
            # With a smaller share of the larger curvature a paraboloid does not show where it is highest.
            if value > max(_STRAIGHT / scale, 1e-3 * values[1]):
                step += np.clip((vector @ found[1:3]) / value, -0.2 * scale, 0.2 * scale) * vector
        height = found[0] + found[1:3] @ step - 0.5 * step @ form @ step
        origin = origin + np.array([*step, height]) @ axes
        if np.abs(step).max() < 1e-9 * scale:
            break
    return origin, form


def _require_level(slope: Array, axes: Array) -> None:
    """Raise GeometryError if a surface of this slope (2,) at a stated place is tilted to its normal, with a better
    one.
    """
    # A ball's highest point is then 0.035 radii off.
    if (tilt := degrees(np.arctan(np.hypot(*slope)))) > 2.0:
        normal = np.array([-slope[0], -slope[1], 1.0]) @ axes
        better = ", ".join(f"{value:g}" for value in np.round(normal / np.linalg.norm(normal), 3) + 0.0)
        raise GeometryError(
            f"its surface is tilted by {tilt:.3g}° to its normal at at_mm: give outward = [{better}] with it"
        )


def _principal(axes: Array, form: Array, source: MeshSource) -> Array:
    """The axes, with x turned to the direction in which the surface is straighter unless the body's axis is stated."""
    values, vectors = np.linalg.eigh(form)
    apart = values[1] - values[0] > _ROUND * np.abs(values).max()
    if not apart:
        return axes
    turn = vectors[:, 0] * (1.0 if vectors[0, 0] >= 0.0 else -1.0)
    if source.along is None:
        turn = np.round(turn) if np.abs(turn - np.round(turn)).max() < 2e-3 else turn
        x = turn @ axes[:2]
        return np.stack([x, np.cross(axes[2], x), axes[2]])
    # So much of the largest curvature may be a twist about the axes.
    if abs(form[0, 1]) > max(2e-3 * np.abs(values).max(), 5e-2 * (values[1] - values[0])):
        if abs(form[0, 0] - form[1, 1]) < 1e-12:
            return axes
        better = ", ".join(f"{value:.4g}" for value in turn @ axes[:2])
        angle = degrees(np.arctan2(turn[1], turn[0]))
        raise GeometryError(
            f"its surface is straightest at {angle:.3g}° to the axis stated: give along = [{better}], or leave it out"
        )
    return axes


def _barrel(nodes: Array, scale: float, *, moves: bool) -> tuple[Barrel, Array]:
    """The barrel that fits nodes (n, 3) best, and the shift (3,) of its first contact from the origin."""
    from scipy.optimize import least_squares

    away = np.linalg.norm(nodes[:, :2], axis=1)
    near = nodes[away <= max(float(np.sort(away)[:_NODES][-1]), 0.5 * float(away.max()))]

    def missed(unknowns: Array) -> Array:
        x, y, z, along, across = unknowns
        place = near - scale * np.array([x * moves, y * moves, z])
        barrel = Barrel(max(along, 0.0) / scale, max(across, 0.0) / scale)
        hollow = (min(along, 0.0) * place[:, 0] ** 2 + min(across, 0.0) * place[:, 1] ** 2) / (2.0 * scale)
        return np.asarray((place[:, 2] - barrel.height(place[:, :2]) + hollow) / scale)

    x, y, z = near.T / scale
    # Exact of balls and cylinders.
    columns = np.column_stack([np.ones_like(x), -0.5 * x**2, -0.5 * (y**2 + z**2)])
    (_, along, across), *_ = np.linalg.lstsq(columns, z, rcond=None)
    start = np.array([0.0, 0.0, 0.0, along, across])
    found = least_squares(
        missed, start, x_scale=np.array([0.01, 0.01, 0.01, 0.1, 0.1]), xtol=1e-15, ftol=1e-15, gtol=1e-15
    ).x
    curved = np.where(np.abs(found[3:]) < max(_EXACT, 1e-5 * np.abs(found[3:]).max()), 0.0, found[3:])
    largest = np.abs(curved).max()
    # A curve of the sag c/8 shows only where nodes are less uneven than that.
    uneven = 8.0 * float(np.abs(missed(found)).max())
    # A hollow curvature below this share of the largest counts as straight.
    if (curved < -max(1e-3 * largest, _STRAIGHT, uneven)).any():
        raise GeometryError(
            f"its contact surface is hollow, of radius {scale / abs(float(curved.min())):.4g} mm: bodies at a point "
            "are round or flat"
        )
    curved = np.maximum(curved, 0.0)
    # What is straight one way is the same wherever it is touched along it.
    shift = scale * found[:3] * np.array([moves and curved[0] > 0.0, moves and curved[1] > 0.0, True])
    return Barrel(float(curved[0] / scale), float(curved[1] / scale)), np.asarray(shift)
