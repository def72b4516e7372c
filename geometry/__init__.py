"""Meshes and unworn surfaces of the contacting bodies: gmsh hexahedra, contact patches, mesh quality, export.

A module of this package is imported when one of its names is first used, so catching a GeometryError loads no gmsh.
"""

from typing import TYPE_CHECKING

from geometry.lazy import loaded_late

if TYPE_CHECKING:
    from geometry.body import BodyGeometry, BodyMesh, Elastic, build_body
    from geometry.errors import GeometryError
    from geometry.grading import EdgeGradedAxis, GradedAxis, Layering, RimGradedAxis, graded_layers
    from geometry.mesh import HexMesh, QuadMesh, mirror_images
    from geometry.patch import ContactPatch
    from geometry.profiles import (
        Arc,
        Barrel,
        Cylinder,
        Flat,
        LoweredSurface,
        Profile,
        RoundedFlat,
        TabledProfile,
        Turned,
    )
    from geometry.ring import RingGeometry
    from geometry.shapes import BlockGeometry, PlanarGeometry, PlanarMesh, WireGeometry, build_planar

__all__ = [
    "Arc", "Barrel", "BlockGeometry", "BodyGeometry", "BodyMesh", "ContactPatch", "Cylinder", "EdgeGradedAxis",
    "Elastic", "Flat", "GeometryError", "GradedAxis", "HexMesh", "Layering", "LoweredSurface", "PlanarGeometry",
    "PlanarMesh", "Profile", "QuadMesh", "RimGradedAxis", "RingGeometry", "RoundedFlat", "TabledProfile", "Turned",
    "WireGeometry", "build_body", "build_planar", "graded_layers", "mirror_images",
]  # fmt: skip

__getattr__ = loaded_late(__name__)
