"""Stress in a body's bulk at the contact, over a cycle, and the stretch of its surface by it.

It is that of a bar along the body's own x axis, touched at z = 0: axial stress is uniform over its section, bending
stress linear and torsion of a round bar radial (Timoshenko, Strength of Materials); each is given by its value at the
contact. Stresses have six components in VTK's order (xx, yy, zz, xy, yz, xz), in MPa, tension positive.
"""

from dataclasses import dataclass

import numpy as np

from geometry import Elastic
from geometry.arrays import Array


@dataclass(frozen=True)
class BulkStress:
    """Bulk stress of a body at the contact: mean + amplitude cos(2π t − phase), each as (axial, bending, torsion) in
    MPa, with t the share of the cycle passed since the drive was at +amplitude.
    """

    material: Elastic
    mean: tuple[float, float, float] = (0.0, 0.0, 0.0)
    amplitude: tuple[float, float, float] = (0.0, 0.0, 0.0)
    phase_rad: float = 0.0
    plane_strain: bool = False  #: True for a planar body, which does not stretch along y.

    @property
    def none(self) -> bool:
        return not any((*self.mean, *self.amplitude))

    def nominal(self, times: Array) -> Array:
        """Axial, bending and torsion stress (m, 3) in MPa at the contact, at shares (m,) of the cycle."""
        swing = np.cos(2.0 * np.pi * np.asarray(times) - self.phase_rad)
        return np.asarray(np.array(self.mean) + swing[..., None] * np.array(self.amplitude))

    def gradient(self, nominal: Array) -> Array:
        """Displacement gradient (m, 2, 2) of the surface at the contact, d u_i / d x_j for x and y, under stresses (m,
        3) in MPa.

        Torsion shears along y only: a line along y does not turn.
        """
        nu, modulus = self.material.poissons_ratio, self.material.youngs_modulus_MPa
        strain = (nominal[..., 0] + nominal[..., 1]) / modulus
        found = np.zeros((*nominal.shape[:-1], 2, 2))
        found[..., 0, 0] = strain * (1.0 - nu**2) if self.plane_strain else strain
        found[..., 1, 1] = 0.0 if self.plane_strain else -nu * strain
        found[..., 1, 0] = nominal[..., 2] / self.material.shear_modulus_MPa
        return found


def section_stress(nominal: Array, points_mm: Array, axis_depth_mm: float, across: float = 0.0) -> Array:
    """Stresses (m, n, 6) in MPa at points (n, 3) of a bar's own axes, mm, for axial, bending and torsion stress (m, 3)
    in MPa at its contact, the origin.

    axis_depth_mm: depth of the bar's axis below the contact. across: stress along y over that along x (Poisson's ratio
    in plane strain, else 0).
    """
    y, share = points_mm[:, 1] / axis_depth_mm, 1.0 + points_mm[:, 2] / axis_depth_mm
    axial, bending, torsion = (nominal[..., k, None] for k in range(3))
    stress = np.zeros((*nominal.shape[:-1], len(points_mm), 6))
    stress[..., 0] = axial + bending * share
    stress[..., 1] = across * stress[..., 0]
    stress[..., 3] = torsion * share
    stress[..., 5] = -torsion * y
    return stress
