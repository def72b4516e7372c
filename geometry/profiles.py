"""Unworn surfaces of contacting bodies: heights relative to the plane that touches them at the point of first contact.

Plane points are (n, 2) coordinates in mm in the body's own frame: along and across the body's axis. A face is a surface
that is straight across the body's axis; its fall is how far it lies below its highest point. Far beside a contact
patch, where a round surface becomes steep, heights and slopes are those of its last gentle place.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

import numpy as np

from geometry.arrays import Array
from geometry.errors import GeometryError

if TYPE_CHECKING:
    from scipy.interpolate import PchipInterpolator, RegularGridInterpolator


_ARC_REACH = 0.9999  # Where an arc is as good as upright.
_REACH = 0.95  # Far beside a contact patch any finite height will do; a cylinder has none there.


class Profile(Protocol):
    """Height of an unworn surface as a function of the position in the plane, with its gradient.

    Points are (n, 2) plane coordinates (along, across) in mm in the body's own frame.
    """

    def height(self, plane_mm: Array) -> Array:
        """Heights (n,) in mm at plane points (n, 2): zero at the origin, nowhere positive."""
        ...

    def slope(self, plane_mm: Array) -> Array:
        """Gradient (n, 2) of the height at plane points (n, 2): its derivatives along and across the body's axis."""
        ...

    def require_within(self, along_mm: float, across_mm: float) -> None:
        """Raise GeometryError if a patch reaching `along_mm` and `across_mm` to each side does not fit the surface."""
        ...


@dataclass(frozen=True)
class Cylinder:
    """A round cylinder about a line along the body's axis, as a wire; with `curved_along`, about a line across it, as a
    planar pad.
    """

    radius_mm: float
    curved_along: bool = False

    def height(self, plane_mm: Array) -> Array:
        """-(R - sqrt(R² - t²)), (n,) in mm, with t the distance of a point from the cylinder's highest line."""
        t = self._clipped(plane_mm)
        return -(t**2) / (self.radius_mm + np.sqrt(self.radius_mm**2 - t**2))

    def slope(self, plane_mm: Array) -> Array:
        t = self._clipped(plane_mm)
        slope = np.zeros((len(t), 2))
        slope[:, 0 if self.curved_along else 1] = -t / np.sqrt(self.radius_mm**2 - t**2)
        return slope

    def require_within(self, along_mm: float, across_mm: float) -> None:
        """Raise GeometryError when the patch reaches as far as the cylinder's radius in the direction of curvature."""
        reach = along_mm if self.curved_along else across_mm
        if reach >= self.radius_mm:
            raise GeometryError(
                f"a contact patch {reach} mm to the side does not fit on a cylinder of radius {self.radius_mm} mm"
            )

    def _clipped(self, plane_mm: Array) -> Array:
        t = plane_mm[:, 0 if self.curved_along else 1]
        return np.minimum(np.maximum(t, -_REACH * self.radius_mm), _REACH * self.radius_mm)


@dataclass(frozen=True)
class Arc:
    """An arc along the body's axis that may come close to half a circle: a pin's surface, or a bore's that holds it.

    radius_mm: of a pin above 0, of a bore below. A contact reaches far around: unlike where bodies touch in a narrow
    strip, the two heights nearly cancel, and both must be averaged over elements alike.
    """

    radius_mm: float

    def height(self, plane_mm: Array) -> Array:
        x, radius, root = self._circle(plane_mm)
        return np.asarray(-np.copysign(x**2 / (radius + root), self.radius_mm))

    def slope(self, plane_mm: Array) -> Array:
        x, _, root = self._circle(plane_mm)
        return np.column_stack([-np.copysign(1.0, self.radius_mm) * x / root, np.zeros_like(x)])

    def require_within(self, along_mm: float, across_mm: float) -> None:  # noqa: ARG002 - straight across
        """GeometryError when the patch reaches the arc's radius."""
        if along_mm >= abs(self.radius_mm):
            raise GeometryError(
                f"a contact patch {along_mm} mm to the side does not fit on an arc of {abs(self.radius_mm)} mm"
            )

    def _circle(self, plane_mm: Array) -> tuple[Array, float, Array]:
        radius = abs(self.radius_mm)
        x = np.clip(plane_mm[:, 0], -_ARC_REACH * radius, _ARC_REACH * radius)
        return x, radius, np.sqrt(radius**2 - x**2)


@dataclass(frozen=True)
class Barrel:
    """A surface of revolution about a line parallel to the body's axis, whose outline along the axis is an arc: a ball,
    a barrel, a cylinder or a flat.

    curvature_along_per_mm: one over the radius of that arc, 0 for a straight outline. curvature_across_per_mm: one over
    the radius of the thickest circle around the line, 0 for a surface that is straight across.
    """

    curvature_along_per_mm: float
    curvature_across_per_mm: float

    def height(self, plane_mm: Array) -> Array:
        """-(s + r - sqrt(r² - y²)), (n,) in mm. s: fall of the outline at x. r = R - s: radius of the circle around the
        line there, with R that of the thickest one.
        """
        x, y, share, root = self._circle(plane_mm)
        across = self.curvature_across_per_mm
        return -(self._fall(x) + across * y**2 / (share + root))

    def slope(self, plane_mm: Array) -> Array:
        x, y, share, root = self._circle(plane_mm)
        k = self.curvature_along_per_mm
        along = k * x / np.sqrt(1.0 - (k * x) ** 2)
        return -np.column_stack([along * share, self.curvature_across_per_mm * y]) / root[:, None]

    def require_within(self, along_mm: float, across_mm: float) -> None:
        """Raise GeometryError when the patch reaches 0.95 of a radius of curvature, where the surface becomes steep."""
        k, across = self.curvature_along_per_mm, self.curvature_across_per_mm
        if k * along_mm >= _REACH or across * across_mm >= _REACH * (1.0 - across * self._fall(np.array(along_mm))):
            raise GeometryError(
                f"a contact patch {along_mm:.4g} mm to the side along and {across_mm:.4g} mm across does not fit on a "
                f"surface of curvatures {k:g} and {across:g} per mm"
            )

    def _fall(self, x: Array) -> Array:
        k = self.curvature_along_per_mm
        return np.asarray(k * x**2 / (1.0 + np.sqrt(1.0 - (k * x) ** 2)))

    def _circle(self, plane_mm: Array) -> tuple[Array, Array, Array, Array]:
        """Four arrays (n,): x and y of the points in mm, kept short of the steep flank, and, over the thickest circle's
        radius, the radius of the circle at x and the height of the point above the axis of revolution.
        """
        x, y = plane_mm.T
        k, across = self.curvature_along_per_mm, self.curvature_across_per_mm
        x = np.clip(x, -_REACH / k, _REACH / k) if k else x
        share = np.maximum(1.0 - across * self._fall(x), 1.0 - _REACH)
        y = np.clip(y, -_REACH * share / across, _REACH * share / across) if across else y
        return x, y, share, np.sqrt(share**2 - (across * y) ** 2)


@dataclass(frozen=True)
class Flat:
    """A plane surface, of height 0."""

    def height(self, plane_mm: Array) -> Array:
        return np.zeros(len(plane_mm))

    def slope(self, plane_mm: Array) -> Array:
        return np.zeros((len(plane_mm), 2))

    def require_within(self, along_mm: float, across_mm: float) -> None:
        """Do nothing: any patch fits on a plane."""


@dataclass(frozen=True)
class RoundedFlat:
    """A flat face that reaches half_width_mm to each side along the body's axis and then falls along arcs of
    `edge_radius_mm`. Raises GeometryError for a `cut` face wider than 0.95 of a cylinder of that radius.
    """

    half_width_mm: float
    edge_radius_mm: float
    #: False: the arcs begin level, without a corner. True: they are what is left of a cylinder of that radius from
    #: which the flat was cut, with corners at the flat's ends.
    cut: bool = False

    def __post_init__(self) -> None:
        if self.cut and not self.half_width_mm < _REACH * self.edge_radius_mm:
            raise GeometryError(
                f"a flat of half-width {self.half_width_mm} mm is no face cut off a radius of {self.edge_radius_mm} mm"
            )

    def height(self, plane_mm: Array) -> Array:
        brink = self._edge.height(np.array([[self.half_width_mm - self._centre_mm, 0.0]]))
        return np.asarray(self._edge.height(self._beyond(plane_mm)) - brink)

    def slope(self, plane_mm: Array) -> Array:
        return self._edge.slope(self._beyond(plane_mm)) * (np.abs(plane_mm[:, :1]) > self.half_width_mm)

    def require_within(self, along_mm: float, across_mm: float) -> None:  # noqa: ARG002 - the face is straight across
        """Raise GeometryError when the patch reaches the end of the arc."""
        if along_mm >= self._centre_mm + self.edge_radius_mm:
            raise GeometryError(
                f"a contact patch {along_mm} mm to the side does not fit on a face of half-width {self.half_width_mm} "
                f"mm with edges rounded by {self.edge_radius_mm} mm"
            )

    @property
    def _edge(self) -> Cylinder:
        return Cylinder(self.edge_radius_mm, curved_along=True)

    @property
    def _centre_mm(self) -> float:
        """Distance of the centres of the edges' arcs from the middle, along the body's axis."""
        return 0.0 if self.cut else self.half_width_mm

    def _beyond(self, plane_mm: Array) -> Array:
        x = plane_mm[:, 0]
        beyond = np.copysign(np.maximum(np.abs(x), self.half_width_mm) - self._centre_mm, x)
        return np.column_stack([beyond, plane_mm[:, 1]])


@dataclass(frozen=True)
class TabledProfile:
    """A face given by points (x, fall) in mm along the body's axis, with x increasing and the least fall 0.

    If x begins at 0, both sides are alike; otherwise points are needed on both sides. The face is a smooth curve
    through the points that overshoots none of them (monotone cubics); where both sides are alike it is level in the
    middle. Raises GeometryError for points of which that is not so, or that fall nowhere.
    """

    points_mm: tuple[tuple[float, float], ...]

    def __post_init__(self) -> None:
        x, fall = np.array(self.points_mm, dtype=float).reshape(-1, 2).T
        sided = len(x) >= 3 and (x[0] == 0.0 or x[0] < 0.0 < x[-1])
        if not (sided and (np.diff(x) > 0.0).all() and fall.min() == 0.0):
            raise GeometryError(
                "a profile needs at least three points (x, fall) with x increasing from 0, or from below to above it, "
                "and a least fall of 0"
            )
        if not self._hull[1][-1] > 0.0:
            raise GeometryError("a profile that falls nowhere has no edge; give its points as far as it falls")

    @property
    def is_even(self) -> bool:
        """True if the points begin at x = 0, so that both sides are alike."""
        return self.points_mm[0][0] == 0.0

    @property
    def reach_mm(self) -> float:
        """Distance from the middle up to which the points reach on both sides."""
        first, last = self.points_mm[0][0], self.points_mm[-1][0]
        return last if self.is_even else min(-first, last)

    @property
    def even(self) -> TabledProfile:
        """The face, alike on both sides and falling steadily outwards, whose fall at a distance from the middle is the
        least of this face's from there on, on either side.

        It nowhere lies below this face, so the contact of this face lies within its contact.
        """
        return TabledProfile(tuple(zip(*(values.tolist() for values in self._hull), strict=True)))

    def height(self, plane_mm: Array) -> Array:
        return -np.asarray(self._fall(self._clipped(plane_mm)))

    def slope(self, plane_mm: Array) -> Array:
        x = self._clipped(plane_mm)
        return np.column_stack([-self._fall(x, 1), np.zeros_like(x)])

    def require_within(self, along_mm: float, across_mm: float) -> None:  # noqa: ARG002 - the face is straight across
        """Raise GeometryError when a patch that reaches `along_mm` to each side ends beyond the points."""
        if along_mm > self.reach_mm:
            raise GeometryError(
                f"a body {along_mm} mm to the side reaches beyond its profile, whose points end at {self.reach_mm} mm"
            )

    @cached_property
    def _both_sides(self) -> tuple[Array, Array]:
        x, fall = np.array(self.points_mm, dtype=float).T
        if not self.is_even:
            return x, fall
        return np.concatenate([-x[:0:-1], x]), np.concatenate([fall[:0:-1], fall])

    @cached_property
    def _hull(self) -> tuple[Array, Array]:
        """Distances (k,) from the middle in mm, and the least fall (k,) in mm at or beyond each distance on either
        side.
        """
        x, fall = self._both_sides
        inwards = np.argsort(-np.abs(x), kind="stable")
        least = np.minimum.accumulate(fall[inwards])
        far = np.unique(np.append(0.0, np.abs(x)[np.abs(x) <= self.reach_mm]))
        return far, least[np.searchsorted(-np.abs(x)[inwards], -far, side="right") - 1]

    @cached_property
    def _fall(self) -> PchipInterpolator:
        from scipy.interpolate import PchipInterpolator

        return PchipInterpolator(*self._both_sides)

    def _clipped(self, plane_mm: Array) -> Array:
        x = self._both_sides[0]
        return np.clip(plane_mm[:, 0], x[0], x[-1])


@dataclass(frozen=True)
class Turned:
    """A surface of revolution about the normal at its middle; on every radius it falls as `face` along its axis."""

    face: Cylinder | RoundedFlat | TabledProfile

    def height(self, plane_mm: Array) -> Array:
        """Heights (n,) in mm at plane points (n, 2): the face's at that radius; beyond a tabled face's last point it
        falls on at the slope that it has there.
        """
        along, beyond = self._along(plane_mm)
        return np.asarray(self.face.height(along) + beyond * self.face.slope(along)[:, 0])

    def slope(self, plane_mm: Array) -> Array:
        along, beyond = self._along(plane_mm)
        far = np.maximum(along[:, 0] + beyond, np.finfo(float).tiny)
        return np.asarray(self.face.slope(along)[:, :1] / far[:, None] * plane_mm)

    def require_within(self, along_mm: float, across_mm: float) -> None:
        """Do nothing: any patch fits, since the surface goes on falling beyond the face's last point."""

    def _along(self, plane_mm: Array) -> tuple[Array, Array]:
        """Points (n, 2) on the face at the radii of plane points (n, 2), and how far (n,) in mm those lie beyond the
        face's end.
        """
        far = np.hypot(*plane_mm.T)
        within = np.minimum(far, self.face.reach_mm) if isinstance(self.face, TabledProfile) else far
        return np.column_stack([within, np.zeros_like(far)]), far - within


@dataclass(frozen=True, eq=False)
class LoweredSurface:
    """A surface that lies below a base surface by a map of measured depths: an old scar, or deviations from nominal
    form.

    x_mm (n_x,), y_mm (n_y,), depth_mm (n_x, n_y): the map, depths positive downwards. to_map: (2, 2) turns plane
    vectors (along, across) to the map's (x, y). Depths and their gradients are bilinear between the map's lines;
    outside the map they are those at its rim.
    """

    base: Profile
    x_mm: Array
    y_mm: Array
    depth_mm: Array
    to_map: Array

    def height(self, plane_mm: Array) -> Array:
        return np.asarray(self.base.height(plane_mm) - self._at(plane_mm)[:, 0])

    def slope(self, plane_mm: Array) -> Array:
        return np.asarray(self.base.slope(plane_mm) - self._at(plane_mm)[:, 1:] @ self.to_map)

    def require_within(self, along_mm: float, across_mm: float) -> None:
        self.base.require_within(along_mm, across_mm)

    def _at(self, plane_mm: Array) -> Array:
        """At plane points (n, 2): the depth and its derivatives along the map's x and y, (n, 3)."""
        lines = (self.x_mm, self.y_mm)
        places = [np.clip(own, line[0], line[-1]) for own, line in zip(self.to_map @ plane_mm.T, lines, strict=True)]
        return np.asarray(self._interpolated(np.column_stack(places)))

    @cached_property
    def _interpolated(self) -> RegularGridInterpolator:
        from scipy.interpolate import RegularGridInterpolator

        lines = (self.x_mm, self.y_mm)
        return RegularGridInterpolator(lines, np.stack([self.depth_mm, *np.gradient(self.depth_mm, *lines)], axis=-1))
