"""Two planar bodies that stick together, moved by a grip: their stiffness, and how they deform.

The same stiffness and grip as in `elasticity.condensation`.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix

from geometry import Elastic, PlanarMesh
from geometry.arrays import Array, IntArray
from solvers.elasticity.linear_elasticity import stiffness_matrix
from solvers.errors import SolverError


@dataclass(frozen=True)
class StuckMotion:
    """How two planar bodies, stuck together, deform when the upper one's grip moves by 1 along x over the held grip of
    the lower one.
    """

    upper: PlanarMesh
    lower: PlanarMesh
    #: (n, 2) displacements (x, z) of nodes per motion of the grip, z upwards for both bodies.
    upper_displacement: Array
    lower_displacement: Array
    force_N_per_mm2: float  #: Tangential force in N per mm of thickness and per mm of motion.

    def stiffness_between(self, depth_mm: float) -> float:
        """Stiffness in N/mm² (force per thickness and motion) between two points on x = 0, one in each body at this
        depth; in a body that is not so deep, at its grip.
        """
        above = _at_depth(self.upper.mesh.points, self.upper_displacement, depth_mm)
        below = _at_depth(self.lower.mesh.points, self.lower_displacement, depth_mm)
        return self.force_N_per_mm2 / (above - below)


def move_stuck(
    upper: PlanarMesh, lower: PlanarMesh, upper_material: Elastic, lower_material: Elastic, half_width_mm: float
) -> StuckMotion:
    """Join two planar bodies where |x| <= `half_width_mm` and move the upper one's grip by a unit along x.

    The upper body is the mirror image of its mesh, facing down. Points of the contact keep their places on both bodies,
    so that the small gap between curved faces, which the normal load closes, does not distort elements. Both patches
    must have the same mesh lines. Raises SolverError if fewer than three nodes would be joined.
    """
    x = lower.patch.axial_mm
    joined = np.abs(x) <= half_width_mm * (1.0 + 1e-9)
    if joined.sum() < 3:
        raise SolverError(
            f"a contact of half-width {half_width_mm} mm joins fewer than three nodes; give a finer mesh under it"
        )
    m, n = len(lower.mesh.points), len(upper.mesh.points)
    number = np.full(n, -1)
    number[upper.patch.nodes[joined, 0]] = lower.patch.nodes[joined, 0]
    own = number < 0
    number[own] = m + np.arange(own.sum())
    size = 2 * (m + int(own.sum()))
    to_upper = _selection(number, size, mirrored=True)
    to_lower = _selection(np.arange(m), size, mirrored=False)
    stiffness = (
        to_upper.T @ _in_plane(upper, upper_material) @ to_upper
        + to_lower.T @ _in_plane(lower, lower_material) @ to_lower
    ).tocsr()
    moved = number[upper.mesh.surface_nodes("grip")]
    held = np.concatenate([moved, lower.mesh.surface_nodes("grip")])
    motion = np.zeros(size)
    motion[2 * moved] = 1.0
    free = np.setdiff1d(np.arange(size), np.concatenate([2 * held, 2 * held + 1]))
    from scipy.sparse.linalg import spsolve

    motion[free] = spsolve(stiffness[free][:, free].tocsc(), -(stiffness[free] @ motion))
    return StuckMotion(
        upper=upper,
        lower=lower,
        upper_displacement=motion.reshape(-1, 2)[number],
        lower_displacement=motion.reshape(-1, 2)[:m],
        force_N_per_mm2=float((stiffness @ motion)[2 * moved].sum()),
    )


def _in_plane(body: PlanarMesh, material: Elastic) -> csr_matrix:
    """Stiffness without the unknowns along y, which are separate."""
    unknowns = np.flatnonzero(np.arange(3 * len(body.mesh.points)) % 3 != 1)
    return stiffness_matrix(body.mesh, material)[unknowns][:, unknowns]


def _selection(number: IntArray, size: int, *, mirrored: bool) -> csr_matrix:
    """From all unknowns to those of one body's frame, whose z points down if it is mirrored."""
    columns = (2 * number[:, None] + np.arange(2)).ravel()
    signs = np.tile([1.0, -1.0 if mirrored else 1.0], len(number))
    return csr_matrix((signs, (np.arange(len(columns)), columns)), shape=(len(columns), size))


def _at_depth(points: Array, displacements: Array, depth_mm: float) -> float:
    """Displacement along x on the axis x = 0 of a body whose face lies at z = 0."""
    axis = np.flatnonzero(points[:, 0] == 0.0)
    axis = axis[np.argsort(points[axis, 1])]
    return float(np.interp(-depth_mm, points[axis, 1], displacements[axis, 0]))
