"""The bodies of the reference problems: gripped steel wires, and what in their compliance is not the contact's.

The closed forms are for half-spaces; a wire of radius R gripped at its back is one only near the contact. Displacement
at a distance r from a point force is that on a half-space (Boussinesq, Cerruti) plus the body's own: bending and
shear of the gripped wire, less what the half-space does beyond it. That part varies on the scale of R, so over a
contact of radius a it is a constant kappa times the force, up to relative terms of (a/R)². kappa is read from the
condensed compliance alone, as the mean of u(r) - u_half-space(r) over a ring just outside the contact; no contact is
solved for it and no contact formula enters. Approach and tangential displacement are then compared after subtracting
kappa times the force (both bodies), and in series with a rig's spring it is a second spring. Table rows give the
error without this correction too. With a/R = 0.03-0.05 what is left, the curvature of surface and arc included, is
below half a per cent. Pressures, radii and the energy at a given force need none: a rigid motion does not enter them.
"""

from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from geometry import BodyMesh, Elastic, GradedAxis, HexMesh, Layering, WireGeometry, build_body
from solvers import CondensedBody, ContactProblem, Holder, WearRates, condense, facing, place
from solvers.near_field import Bricks
from wirewear import reference

Array = NDArray[np.float64]

STEEL = Elastic(210_000.0, 0.3)
RADIUS_mm = 0.5
#: Contact radius for which the meshes are made, 0.03 R.
CONTACT_RADIUS_mm = 0.015
CONTACT_MODULUS_MPa = reference.contact_modulus(STEEL, STEEL)
#: Normal load that gives this radius to equal wires crossed at right angles.
LOAD_N = 4.0 * CONTACT_MODULUS_MPa * CONTACT_RADIUS_mm**3 / (3.0 * RADIUS_mm)
RIGHT_ANGLE_deg = 90.0


def wire_geometry(resolution: float, *, radius_mm: float = RADIUS_mm, long_patch: bool = False) -> WireGeometry:
    """A wire with `resolution` elements per contact radius; a long patch has room to slide by 3 contact radii."""
    a = CONTACT_RADIUS_mm
    element, outer = a / resolution, max(a / resolution, 0.75 * a)
    axial = GradedAxis(element, 4.2 * a, outer, 4.5 * a) if long_patch else GradedAxis(element, 2.0 * a, outer, 4.0 * a)
    transverse = GradedAxis(element, 2.0 * a, outer, 3.0 * a if long_patch else 4.0 * a)
    diameter = 2.0 * radius_mm
    # One layer more than in a run: what is compared with closed forms may cost more.
    layering = Layering(6, 1.2, 0.6).refined(max(1.0, resolution / 4.0))
    return WireGeometry(diameter, 2.2 * diameter, axial, transverse, 0.155 * diameter, layering=layering)


@cache
def condensed(geometry: WireGeometry) -> CondensedBody:
    """Such a wire of steel, condensed anew: what is verified must not come from the cache on disk."""
    meshed = build_body(geometry)
    return replace(condense(meshed.mesh, meshed.patch, STEEL), bricks=Bricks(STEEL, geometry.layers))


def scaled(meshed: BodyMesh, factor: float) -> BodyMesh:
    """The same mesh in another unit of length."""
    mesh, patch = meshed.mesh, meshed.patch
    return replace(meshed, mesh=HexMesh(mesh.points * factor, mesh.cells, mesh.surfaces), patch=patch.scaled(factor))


def crossed(
    lower: CondensedBody,
    upper: CondensedBody,
    holder: Holder,
    *,
    friction: float = 0.0,
    angle_deg: float = RIGHT_ANGLE_deg,
    wear: WearRates | None = None,
    primary_is_upper: bool = True,
) -> ContactProblem:
    """The lower wire along the motion, the upper one at an angle to it."""
    above = place(upper, upper=True, axis_angle_rad=float(np.radians(angle_deg)))
    below = place(lower, upper=False, axis_angle_rad=0.0)
    return ContactProblem(
        upper=facing(above, below) if primary_is_upper else above,
        lower=below if primary_is_upper else facing(below, above),
        holder=holder,
        friction=friction,
        wear=wear or WearRates(),
        primary_is_upper=primary_is_upper,
    )


def element_mm(body: CondensedBody) -> float:
    """Size of the elements in the middle of the patch; grading may stretch it a little from what was asked."""
    lines = body.patch.transverse_mm
    return float(np.diff(lines)[len(lines) // 2])


def bulk_compliance(body: CondensedBody, axis: int, contact_radius_mm: float) -> float:
    """Compliance kappa of the body beyond that of a half-space, in mm/N, for forces along its own axis 0, 1 or 2.

    The mean over nodes at 1 to 1.5 contact radii from a point force at the middle; half-space: Johnson, Contact
    Mechanics, 1985, sections 3.2 and 3.6.
    """
    positions = body.patch.grid()
    loaded = int(np.argmin((positions**2).sum(axis=1)))
    r = np.hypot(*positions.T)
    ring = (r > contact_radius_mm) & (r < 1.5 * contact_radius_mm)
    moved = body.compliance.reshape(body.patch.size, 3, body.patch.size, 3)[ring, axis, loaded, axis]
    nu, modulus = STEEL.poissons_ratio, STEEL.youngs_modulus_MPa
    shape = 1.0 - nu**2
    if axis < 2:
        shape = (1.0 + nu) * (1.0 - nu + nu * positions[ring, axis] ** 2 / r[ring] ** 2)
    return float((moved - shape / (np.pi * modulus * r[ring])).mean())


def crossed_bulk_compliance(body: CondensedBody, *, normal: bool, contact_radius_mm: float) -> float:
    """Bulk compliance of two such wires crossed at right angles, normal or along the motion, in mm/N."""
    axes = (2, 2) if normal else (0, 1)
    return sum(bulk_compliance(body, axis, contact_radius_mm) for axis in axes)
