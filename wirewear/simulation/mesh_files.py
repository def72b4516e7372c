"""The meshes of a study, written for other programs and drawn."""

from __future__ import annotations

from pathlib import Path

from geometry import build_wire
from wirewear.errors import ResultError
from wirewear.files import in_one_step, writing
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
    with writing(ResultError, f"cannot write meshes to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        for name, wire in wires.items():
            with in_one_step(folder / f"{name}.vtu") as partial:
                wire.mesh.write(partial, surface_fields(wire))
    angle = study.wires.crossing_angle_deg
    picture = save(lambda: wire_meshes(wires["moving"], wires["fixed"], angle), folder / "mesh.png")
    return [*(folder / f"{name}.vtu" for name in wires), picture]
