"""Line contacts that no memory holds, refused before anything is meshed."""

from __future__ import annotations

from geometry import EdgeGradedAxis, PlanarGeometry
from wirewear.base.budget import free_memory, size_text
from wirewear.base.errors import StudyError
from wirewear.base.quantity import counted
from wirewear.planar.model import PlanarPlan

#: Dense matrices of a contact's unknowns that are there at a time: those of both bodies, and one in the making.
_MATRICES = 3


def require_affordable_meshes(name: str, plan: PlanarPlan) -> None:
    """See that the compliances of both bodies can be held.

    Raises:
        StudyError: they take more memory than there is.
    """
    nodes = max(least_nodes(plan.pad), least_nodes(plan.specimen))
    needed, free = _MATRICES * 8.0 * (2.0 * nodes) ** 2, free_memory()
    if needed > free:
        fits_um = 1e3 * plan.pad.along.fine_mm * (needed / free) ** 0.5
        raise StudyError(
            f"the study {name!r} asks for {counted(nodes)} nodes in a contact and {size_text(needed)} of memory, of "
            f"which {size_text(free)} are free: give contact_mesh_um = {fits_um:.2g} or more, or allow more by "
            "--most-memory."
        )


def least_nodes(body: PlanarGeometry) -> int:
    """Nodes in the fine zone of a body's contact; those beyond are fewer."""
    along = body.along
    if isinstance(along, EdgeGradedAxis):
        fine_mm = along.half_extent_mm - along.fine_from_mm
    else:
        fine_mm = along.fine_half_extent_mm
    return int(2.0 * fine_mm / along.fine_mm) + 1
