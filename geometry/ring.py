"""Rings of unit thickness in the plane (x, z), for conforming line contacts: a pin held at its core, and a plate with a
bore held at its rim.

Mesh lines are rays from the ring's centre, close to each other on the contact surface; arc length is measured on it.
"""

from dataclasses import dataclass
from math import inf, pi

import numpy as np

from geometry.arrays import Array, IntArray
from geometry.errors import GeometryError
from geometry.grading import EdgeGradedAxis, GradedAxis, graded_layers
from geometry.mesh import QuadMesh
from geometry.patch import ContactPatch
from geometry.profiles import Arc

WIDEST_rad = 88.0 / 180.0 * pi  #: Half-angle of the widest patch: beyond a quarter turn a surface is no height over x.
_WIDEST_RAYS_rad = 0.12  # An eighth of a radius: far from the contact, stresses vary over the radius.


@dataclass(frozen=True)
class RingGeometry:
    """Dimensions and mesh sizes of a pin or a plate with a bore; it is held all around on its other circle."""

    radius_mm: float  #: Of the contact surface: above 0 for a pin, below 0 for a bore.
    height_mm: float  #: Distance from the contact surface to the circle that is held.
    along: (
        GradedAxis | EdgeGradedAxis
    )  #: Mesh lines of the contact patch, as arc lengths from the point of first contact.
    growth: float = 1.15  #: Ratio of the sizes of neighbouring elements away from the patch.
    grip_half_width_mm: float | None = None  #: None: the whole circle is held, always.
    grip_stiffness_N_per_mm3: float | None = None  #: Stiffness of the grip per area; None: the grip is rigid.

    def __post_init__(self) -> None:
        widest = WIDEST_rad * abs(self.radius_mm)
        if self.along.half_extent_mm > widest * (1.0 + 1e-9):
            raise GeometryError(
                f"a contact patch of {self.along.half_extent_mm:.4g} mm to each side reaches further than "
                f"{widest:.4g} mm around an arc of radius {abs(self.radius_mm)} mm"
            )
        if not self.along.fine_mm < self.height_mm < (self.radius_mm if self.radius_mm > 0.0 else inf):
            raise GeometryError(
                f"a ring whose contact surface has the radius {abs(self.radius_mm)} mm cannot be {self.height_mm} mm "
                f"high with elements of {self.along.fine_mm} mm"
            )

    @property
    def profile(self) -> Arc:
        return Arc(self.radius_mm)

    @property
    def half_width_mm(self) -> float:
        """How far the ring reaches to each side of the point of first contact."""
        return max(abs(self.radius_mm), abs(self._held_mm))

    @property
    def _held_mm(self) -> float:
        """Radius of the circle that is held, with the sign of the contact surface's."""
        return self.radius_mm - self.height_mm

    def layers(self) -> Array:
        """Thicknesses (n,) in mm of the rows of elements from the contact surface to the circle that is held."""
        first, coarse = float(self.along.half_lines()[1]), 0.15 * self.half_width_mm
        return graded_layers(min(first, coarse), self.growth, coarse, self.height_mm)

    def above_back(self, points_mm: Array) -> Array:
        """Share (n,) of the way from the held circle to the contact surface at points (n, 2), 0 beside the half of the
        ring that carries the contact.
        """
        x, z = points_mm[:, 0], points_mm[:, 1] + self.radius_mm
        share = (np.hypot(x, z) - abs(self._held_mm)) / (abs(self.radius_mm) - abs(self._held_mm))
        return np.asarray(np.where(z * self.radius_mm > 0.0, share, 0.0))

    def meshed(self) -> tuple[QuadMesh, ContactPatch]:
        """The mesh with the surfaces 'contact' and 'grip', and its patch."""
        angles, on_patch = self._rays()
        layers = graded_layers(
            float(self.along.half_lines()[1]), self.growth, 0.15 * self.half_width_mm, self.height_mm
        )
        radii = self.radius_mm - np.concatenate([[0.0], np.cumsum(layers)])
        radii[-1] = self._held_mm
        sines = np.append(np.sin(angles[:-1]), 0.0)  # Of the last, pi, not but for rounding.
        x, z = np.outer(sines, np.abs(radii)), np.outer(np.cos(angles), radii) - self.radius_mm
        n = np.arange(x.size).reshape(x.shape)
        ahead = np.roll(n, -1, axis=0)
        cells = np.stack([n[:, :-1], n[:, 1:], ahead[:, 1:], ahead[:, :-1]], axis=-1).reshape(-1, 4)
        top = n[on_patch, 0]
        surfaces = {"contact": np.column_stack([top[:-1], top[1:]]), "grip": np.column_stack([n[:, -1], ahead[:, -1]])}
        patch = ContactPatch(x[on_patch, 0], np.zeros(1), top[:, None], self.profile)
        return QuadMesh(np.column_stack([x.ravel(), z.ravel()]), cells, surfaces), patch

    def _rays(self) -> tuple[Array, IntArray]:
        """Angles (n,) in rad of the rays from that to the point of first contact, exactly antisymmetric but for the
        last, and the indices (k,) of those on the patch.
        """
        half = self.along.half_lines() / abs(self.radius_mm)
        rest = pi - half[-1]
        size = min(self.growth * (half[-1] - half[-2]), _WIDEST_RAYS_rad)
        outer = half[-1] + np.cumsum(graded_layers(size, self.growth, _WIDEST_RAYS_rad, rest))
        outer[-1] = pi
        half, patch = np.concatenate([half, outer]), len(half)
        middle = len(half) - 2
        angles = np.concatenate([-half[-2:0:-1], half])
        return angles, np.arange(middle - patch + 1, middle + patch)
