"""The meshes of a study, written for other programs and drawn."""

from __future__ import annotations

from pathlib import Path

from geometry import build_wire
from wirewear.errors import ResultError
from wirewear.files import why_not_written
from wirewear.simulation.discretisation import discretise
from wirewear.study import Study


def write_meshes(study: Study, fidelity: str, folder: Path) -> list[Path]:
    """Mesh both wires; leave moving.vtu, fixed.vtu (with their surfaces as point data) and mesh.png in a folder.

    Variants of a study that mesh alike share one mesh: that of the study as a whole is written.

    Raises:
        StudyError: the study cannot be discretised.  GeometryError: the mesh is distorted.
        ResultError: the files cannot be written.
    """
    from wirewear.pictures import save, surface_fields, wire_meshes

    plan = discretise(study, fidelity)
    wires = {"moving": build_wire(plan.moving), "fixed": build_wire(plan.fixed)}
    try:
        folder.mkdir(parents=True, exist_ok=True)
        paths = []
        for name, wire in wires.items():
            path = folder / f"{name}.vtu"
            wire.mesh.write(path, surface_fields(wire))
            paths.append(path)
        angle = study.wires.crossing_angle_deg
        paths.append(save(lambda: wire_meshes(wires["moving"], wires["fixed"], angle), folder / "mesh.png"))
    except OSError as error:
        raise ResultError(f"cannot write meshes to {folder}: {why_not_written(error)}") from error
    return paths
