"""Unworn surfaces of contacting bodies: heights above the plane that touches them where contact begins."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

import numpy as np

from geometry.arrays import Array
from geometry.errors import GeometryError

if TYPE_CHECKING:
    from scipy.interpolate import PchipInterpolator, RegularGridInterpolator


_REACH = 0.95  # Far beside a contact patch any finite height will do; a cylinder has none there.


class Profile(Protocol):
    """Height of an unworn surface over the plane, with its gradient.

    Points are (n, 2) plane coordinates (along, across) in mm in the body's own frame.
    """

    def height(self, plane_mm: Array) -> Array:
        """Height at plane points, shape (n,), in mm: zero at the origin, nowhere positive."""
        ...

    def slope(self, plane_mm: Array) -> Array:
        """Gradient of the height at plane points, shape (n, 2)."""
        ...

    def require_within(self, along_mm: float, across_mm: float) -> None:
        """GeometryError when a patch of these half-extents does not fit on the surface."""
        ...


@dataclass(frozen=True)
class Cylinder:
    """A cylinder whose surface curves across the body's axis, as a wire's does, or along it, as a planar pad's does."""

    radius_mm: float
    curved_along: bool = False

    def height(self, plane_mm: Array) -> Array:
        """-(R - sqrt(R² - t²)), t being the distance from the highest line."""
        t = self._clipped(plane_mm)
        return -(t**2) / (self.radius_mm + np.sqrt(self.radius_mm**2 - t**2))

    def slope(self, plane_mm: Array) -> Array:
        """-t / sqrt(R² - t²) in the direction of curvature."""
        t = self._clipped(plane_mm)
        slope = np.zeros((len(t), 2))
        slope[:, 0 if self.curved_along else 1] = -t / np.sqrt(self.radius_mm**2 - t**2)
        return slope

    def require_within(self, along_mm: float, across_mm: float) -> None:
        """GeometryError when the patch reaches the cylinder's flank."""
        reach = along_mm if self.curved_along else across_mm
        if reach >= self.radius_mm:
            raise GeometryError(
                f"a contact patch {reach} mm to the side does not fit on a cylinder of radius {self.radius_mm} mm"
            )

    def _clipped(self, plane_mm: Array) -> Array:
        t = plane_mm[:, 0 if self.curved_along else 1]
        return np.minimum(np.maximum(t, -_REACH * self.radius_mm), _REACH * self.radius_mm)


@dataclass(frozen=True)
class Barrel:
    """A surface of revolution about a line along the body's axis, whose profile is an arc: a ball, a barrel, a flat.

    curvature_along_per_mm, curvature_across_per_mm: one over the radii of the arc and of the thickest circle.
    """

    curvature_along_per_mm: float
    curvature_across_per_mm: float

    def height(self, plane_mm: Array) -> Array:
        """-(s + r - sqrt(r² - y²)), s being the fall along the crown and r the radius of the circle there."""
        x, y, share, root = self._circle(plane_mm)
        across = self.curvature_across_per_mm
        return -(self._fall(x) + across * y**2 / (share + root))

    def slope(self, plane_mm: Array) -> Array:
        """Along and across."""
        x, y, share, root = self._circle(plane_mm)
        k = self.curvature_along_per_mm
        along = k * x / np.sqrt(1.0 - (k * x) ** 2)
        return -np.column_stack([along * share, self.curvature_across_per_mm * y]) / root[:, None]

    def require_within(self, along_mm: float, across_mm: float) -> None:
        """GeometryError when the patch reaches the flank."""
        k, across = self.curvature_along_per_mm, self.curvature_across_per_mm
        if k * along_mm >= _REACH or across * across_mm >= _REACH * (1.0 - across * self._fall(np.array(along_mm))):
            raise GeometryError(
                f"a contact patch {along_mm} mm to the side along and {across_mm} mm across does not fit on a surface "
                f"of curvatures {k:g} and {across:g} per mm"
            )

    def _fall(self, x: Array) -> Array:
        k = self.curvature_along_per_mm
        return np.asarray(k * x**2 / (1.0 + np.sqrt(1.0 - (k * x) ** 2)))

    def _circle(self, plane_mm: Array) -> tuple[Array, Array, Array, Array]:
        """Points clipped short of the flank; over the thickest circle's radius, that of the one there, and its root."""
        x, y = plane_mm.T
        k, across = self.curvature_along_per_mm, self.curvature_across_per_mm
        x = np.clip(x, -_REACH / k, _REACH / k) if k else x
        share = np.maximum(1.0 - across * self._fall(x), 1.0 - _REACH)
        y = np.clip(y, -_REACH * share / across, _REACH * share / across) if across else y
        return x, y, share, np.sqrt(share**2 - (across * y) ** 2)


@dataclass(frozen=True)
class Flat:
    """A plane surface."""

    def height(self, plane_mm: Array) -> Array:
        """Zero."""
        return np.zeros(len(plane_mm))

    def slope(self, plane_mm: Array) -> Array:
        """Zero."""
        return np.zeros((len(plane_mm), 2))

    def require_within(self, along_mm: float, across_mm: float) -> None:
        """Any patch fits."""


@dataclass(frozen=True)
class RoundedFlat:
    """A flat face of half-width b along the body's axis whose edges are rounded with a radius."""

    half_width_mm: float
    edge_radius_mm: float
    #: The edges are what a flat cut off a cylinder of that radius leaves of it, with a corner at b, in place of arcs
    #: that begin level there.
    cut: bool = False

    def __post_init__(self) -> None:
        if self.cut and not self.half_width_mm < _REACH * self.edge_radius_mm:
            raise GeometryError(
                f"a flat of half-width {self.half_width_mm} mm is no face cut off a radius of {self.edge_radius_mm} mm"
            )

    def height(self, plane_mm: Array) -> Array:
        """Zero on the flat, that of the rounding beside it."""
        brink = self._edge.height(np.array([[self.half_width_mm - self._centre_mm, 0.0]]))
        return np.asarray(self._edge.height(self._beyond(plane_mm)) - brink)

    def slope(self, plane_mm: Array) -> Array:
        """Zero on the flat, that of the rounding beside it."""
        return self._edge.slope(self._beyond(plane_mm)) * (np.abs(plane_mm[:, :1]) > self.half_width_mm)

    def require_within(self, along_mm: float, across_mm: float) -> None:  # noqa: ARG002 - the face is straight across
        """GeometryError when the patch reaches the end of the rounding."""
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
        """Where the arcs' centres lie to each side of the middle."""
        return 0.0 if self.cut else self.half_width_mm

    def _beyond(self, plane_mm: Array) -> Array:
        x = plane_mm[:, 0]
        beyond = np.copysign(np.maximum(np.abs(x), self.half_width_mm) - self._centre_mm, x)
        return np.column_stack([beyond, plane_mm[:, 1]])


@dataclass(frozen=True)
class TabledProfile:
    """A face given by points (x, fall) in mm along the body's axis, x increasing, the least fall being 0.

    From x = 0 on they stand for both sides, which are alike; else there are points on either side. Between them the
    face is a smooth curve without bumps of its own (monotone cubics), where both sides are alike level in the middle.
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
        """Whether both sides are alike because one stands for both."""
        return self.points_mm[0][0] == 0.0

    @property
    def reach_mm(self) -> float:
        """How far it goes to both sides."""
        first, last = self.points_mm[0][0], self.points_mm[-1][0]
        return last if self.is_even else min(-first, last)

    @property
    def even(self) -> TabledProfile:
        """The face, alike on both sides, that has fallen as much where this one has everywhere beyond, on either side.

        A contact with this face lies within the one with that.
        """
        return TabledProfile(tuple(zip(*(values.tolist() for values in self._hull), strict=True)))

    def height(self, plane_mm: Array) -> Array:
        """Minus the fall."""
        return -np.asarray(self._fall(self._clipped(plane_mm)))

    def slope(self, plane_mm: Array) -> Array:
        """Along the body's axis."""
        x = self._clipped(plane_mm)
        return np.column_stack([-self._fall(x, 1), np.zeros_like(x)])

    def require_within(self, along_mm: float, across_mm: float) -> None:  # noqa: ARG002 - the face is straight across
        """GeometryError when the patch reaches beyond the points."""
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
        """Distances from the middle, and the least fall from there on."""
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
    """A face turned about the normal at its middle: along every radius what it is along a body's axis."""

    face: Cylinder | RoundedFlat | TabledProfile

    def height(self, plane_mm: Array) -> Array:
        """Height (n,) in mm at positions (n, 2): the face's at that distance from its middle; beyond its last point it
        goes on as steeply.
        """
        along, beyond = self._along(plane_mm)
        return np.asarray(self.face.height(along) + beyond * self.face.slope(along)[:, 0])

    def slope(self, plane_mm: Array) -> Array:
        """Along the radius."""
        along, beyond = self._along(plane_mm)
        far = np.maximum(along[:, 0] + beyond, np.finfo(float).tiny)
        return np.asarray(self.face.slope(along)[:, :1] / far[:, None] * plane_mm)

    def require_within(self, along_mm: float, across_mm: float) -> None:
        """Any patch fits: what has no points is low."""

    def _along(self, plane_mm: Array) -> tuple[Array, Array]:
        """Places (n, 2) on the face, and how far (n,) points lie beyond its end."""
        far = np.hypot(*plane_mm.T)
        within = np.minimum(far, self.face.reach_mm) if isinstance(self.face, TabledProfile) else far
        return np.column_stack([within, np.zeros_like(far)]), far - within


@dataclass(frozen=True, eq=False)
class LoweredSurface:
    """A surface that lies below another one by depths as they were measured: an old scar, or errors of its form.

    x_mm (n_x,), y_mm (n_y,), depth_mm (n_x, n_y): a map.  to_map: (2, 2), turns plane vectors into the map's axes.
    Between lines depths and their gradients are bilinear, beside the map those of its rim.
    """

    base: Profile
    x_mm: Array
    y_mm: Array
    depth_mm: Array
    to_map: Array

    def height(self, plane_mm: Array) -> Array:
        """Of the other surface less the depth."""
        return np.asarray(self.base.height(plane_mm) - self._at(plane_mm)[:, 0])

    def slope(self, plane_mm: Array) -> Array:
        """Likewise."""
        return np.asarray(self.base.slope(plane_mm) - self._at(plane_mm)[:, 1:] @ self.to_map)

    def require_within(self, along_mm: float, across_mm: float) -> None:
        """As of the other surface."""
        self.base.require_within(along_mm, across_mm)

    def _at(self, plane_mm: Array) -> Array:
        """Depth and gradient (n, 3) in the map's axes."""
        lines = (self.x_mm, self.y_mm)
        places = [np.clip(own, line[0], line[-1]) for own, line in zip(self.to_map @ plane_mm.T, lines, strict=True)]
        return np.asarray(self._interpolated(np.column_stack(places)))

    @cached_property
    def _interpolated(self) -> RegularGridInterpolator:
        from scipy.interpolate import RegularGridInterpolator

        lines = (self.x_mm, self.y_mm)
        return RegularGridInterpolator(lines, np.stack([self.depth_mm, *np.gradient(self.depth_mm, *lines)], axis=-1))
