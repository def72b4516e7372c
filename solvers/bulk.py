"""Bulk stress: what a body carries beside its contact, as a straight bar that is pulled, bent and twisted in a cycle.

The bar lies along the body's own x axis and is touched at z = 0. Axial stress is even over its section; bending stress
is linear and torsion of a round bar radial (Timoshenko, Strength of Materials), both named by their value at the
contact. Stresses have six components in VTK's order (xx, yy, zz, xy, yz, xz), in MPa, tension positive.
"""

from dataclasses import dataclass

import numpy as np

from geometry import Elastic
from geometry.arrays import Array


@dataclass(frozen=True)
class BulkStress:
    """Axial, bending and torsion stress at the contact, in MPa: mean + amplitude cos(2π t − phase), with t the share of
    the cycle passed since the drive's rest at +amplitude.

    plane_strain: the body is a section of one that does not stretch across.
    """

    material: Elastic
    mean: tuple[float, float, float] = (0.0, 0.0, 0.0)
    amplitude: tuple[float, float, float] = (0.0, 0.0, 0.0)
    phase_rad: float = 0.0
    plane_strain: bool = False

    @property
    def none(self) -> bool:
        """Whether there is no such stress."""
        return not any((*self.mean, *self.amplitude))

    def nominal(self, times: Array) -> Array:
        """Axial, bending and torsion stress at the contact (m, 3) at shares (m,) of the cycle."""
        swing = np.cos(2.0 * np.pi * np.asarray(times) - self.phase_rad)
        return np.asarray(np.array(self.mean) + swing[..., None] * np.array(self.amplitude))

    def gradient(self, nominal: Array) -> Array:
        """Displacement gradient (m, 2, 2) of the surface at the contact, along x and y, under stresses (m, 3) as
        `nominal` gives them; the line along y does not turn by torsion.
        """
        nu, modulus = self.material.poissons_ratio, self.material.youngs_modulus_MPa
        strain = (nominal[..., 0] + nominal[..., 1]) / modulus
        found = np.zeros((*nominal.shape[:-1], 2, 2))
        found[..., 0, 0] = strain * (1.0 - nu**2) if self.plane_strain else strain
        found[..., 1, 1] = 0.0 if self.plane_strain else -nu * strain
        found[..., 1, 0] = nominal[..., 2] / self.material.shear_modulus_MPa
        return found


def section_stress(nominal: Array, points_mm: Array, axis_depth_mm: float, across: float = 0.0) -> Array:
    """Stresses (m, n, 6) of a bar at points (n, 3) by axial, bending and torsion stress (m, 3) at its contact.

    across: share of the stress along x that there is along y, Poisson's ratio in plane strain.
    """
    y, share = points_mm[:, 1] / axis_depth_mm, 1.0 + points_mm[:, 2] / axis_depth_mm
    axial, bending, torsion = (nominal[..., k, None] for k in range(3))
    stress = np.zeros((*nominal.shape[:-1], len(points_mm), 6))
    stress[..., 0] = axial + bending * share
    stress[..., 1] = across * stress[..., 0]
    stress[..., 3] = torsion * share
    stress[..., 5] = -torsion * y
    return stress
