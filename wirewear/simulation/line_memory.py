"""Memory that a line contact's run needs, and whether there is enough."""

from geometry import EdgeGradedAxis, PlanarGeometry, RingGeometry
from wirewear.base.memory import free_memory
from wirewear.simulation.line_model import LinePlan
from wirewear.simulation.problem import too_much


def needed_memory(meshes: LinePlan) -> float:
    """Bytes that the compliances of both bodies take at a time."""
    # Dense matrices of a contact's unknowns that are there at a time: those of both bodies, and one in the making.
    return 3 * 8.0 * (2.0 * _nodes(meshes)) ** 2


def require_affordable_lines(name: str, meshes: LinePlan) -> None:
    """Raise StudyError if the compliances of both bodies take more memory than is free. name: the study's."""
    needed, free = needed_memory(meshes), free_memory()
    if needed > free:
        fits_um = 1e3 * meshes.pad.along.fine_mm * (needed / free) ** 0.5
        raise too_much(f"{name!r}", _nodes(meshes), needed, free, f"give contact_mesh_um = {fits_um:.2g} or more")


def _nodes(meshes: LinePlan) -> int:
    return max(_fine_nodes(meshes.pad), _fine_nodes(meshes.specimen))


def _fine_nodes(body: PlanarGeometry | RingGeometry) -> int:
    """Number of nodes in the fine zone of a body's contact; those outside are fewer."""
    along = body.along
    if isinstance(along, EdgeGradedAxis):
        fine_mm = along.half_extent_mm - along.fine_from_mm
    else:
        fine_mm = along.fine_half_extent_mm
    return int(2.0 * fine_mm / along.fine_mm) + 1
