"""Parts of a simulation for scripts that go beneath a run: meshes, also as files, condensation, single increments."""

from functools import partial
from pathlib import Path

from geometry import BodyMesh, Cylinder, Elastic, Flat, GradedAxis, HexMesh, PlanarGeometry, build_body, build_planar
from solvers import (
    ContactProblem,
    ContactState,
    IncrementReport,
    advance,
    closed_cycle,
    first_quarter,
    move_stuck,
    press,
    run_cycle,
    unloaded_state,
)
from solvers.elasticity.condensation import compliance_of, piece_to_condense
from solvers.elasticity.elimination import schur_complements
from solvers.elasticity.linear_elasticity import stiffness_matrix
from wirewear.base.errors import ResultError
from wirewear.base.writing import in_one_step, writing
from wirewear.results.scar import called
from wirewear.simulation.discretisation import Discretisation, discretise
from wirewear.simulation.line_model import line_plan
from wirewear.simulation.line_runs import require_affordable_lines
from wirewear.simulation.meshes import MeshStage
from wirewear.simulation.point_runs import PointRun
from wirewear.simulation.problem import contact_problem, write_condensed
from wirewear.test import LineStudy, Study
from wirewear.test.own_bodies import OwnBody

__all__ = [
    "BodyMesh", "ContactProblem", "ContactState", "Cylinder", "Discretisation", "Elastic", "Flat", "GradedAxis",
    "HexMesh", "IncrementReport", "PlanarGeometry", "advance", "build_body", "build_planar", "closed_cycle",
    "compliance_of", "contact_problem", "discretise", "first_quarter", "move_stuck", "piece_to_condense", "press",
    "run_cycle", "schur_complements", "stiffness_matrix", "unloaded_state",
]  # fmt: skip


def write_meshes(study: Study, fidelity: str, folder: Path, ending: str = "vtu") -> list[Path]:
    """Mesh both bodies of a study and write a mesh file of each, such as moving.vtu, and pictures of meshes and
    supports to a folder; return the files.

    ending: a mesh format, or "npz" for the condensed stiffness of each body, without pictures. If the meshes follow the
    scar, those of the last stage are written and the first one is drawn as well; stiffnesses are of one mesh for the
    whole test. Of a study with variants, the mesh of the study as a whole is written. Raises StudyError if the study
    cannot be discretised, GeometryError if the mesh is distorted, and ResultError if the files cannot be written.
    """
    from wirewear.pictures import body_meshes, save, surface_fields
    from wirewear.pictures.own_body import own_body
    from wirewear.pictures.supports import supports

    run = PointRun.of(study if ending != "npz" else study.with_values({"mesh.follow_scar": False}), fidelity)
    run.require_affordable()
    first, *others = run.meshes.stages
    last = others[-1] if others else first
    if ending == "npz":
        return _write_stiffnesses(study, last, folder)
    meshed = build_body(last.moving), build_body(last.fixed)
    names = run.discretisation.bodies
    fresh = build_body(first.moving) if others else None
    files: list[Path] = []
    with writing(ResultError, f"cannot write meshes to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        for name, body in zip(names, meshed, strict=True):
            files.append(folder / f"{name}.{ending}")
            with in_one_step(files[-1]) as unfinished:
                body.mesh.write(unfinished, surface_fields(body) if ending == "vtu" else None)
    spoken, angle = (called(names[0]), called(names[1])), study.crossing_angle_deg
    picture = save(lambda: body_meshes(*meshed, angle, spoken, fresh), folder / "mesh.png")
    held = save(lambda: supports(study, *meshed), folder / "boundary_conditions.png")
    pictures = [picture, held]
    for stated, mesh, name in zip(study.bodies, meshed, spoken, strict=True):
        if isinstance(stated, OwnBody):
            extents = mesh.geometry.axial.half_extent_mm, mesh.geometry.transverse.half_extent_mm
            drawn = partial(own_body, stated.source, extents, name)
            pictures.append(save(drawn, folder / f"{stated.name}_of_file.png"))
    return [*files, *pictures]


def _write_stiffnesses(study: Study, meshes: MeshStage, folder: Path) -> list[Path]:
    files = [folder / f"{body.name}.npz" for body in study.bodies]
    with writing(ResultError, f"cannot write stiffnesses to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        for path, body, geometry in zip(files, study.bodies, (meshes.moving, meshes.fixed), strict=True):
            with in_one_step(path) as unfinished:
                write_condensed(unfinished, geometry, body.material)
    return files


def write_line_meshes(study: LineStudy, fidelity: str, folder: Path) -> list[Path]:
    """Mesh pad and specimen and write pad.vtu, specimen.vtu and boundary_conditions.png to a folder; return the files.

    Raises StudyError if the study cannot be meshed, or needs more memory than is free; GeometryError if the mesh is
    distorted; ResultError if the files cannot be written.
    """
    from wirewear.pictures import save
    from wirewear.pictures.line_contacts import line_supports

    meshes = line_plan(study, fidelity)
    require_affordable_lines(study.name, meshes)
    bodies = {"pad": build_planar(meshes.pad), "specimen": build_planar(meshes.specimen)}
    with writing(ResultError, f"cannot write meshes to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        for name, body in bodies.items():
            with in_one_step(folder / f"{name}.vtu") as partial:
                body.mesh.write(partial)
    picture = save(lambda: line_supports(study, *bodies.values()), folder / "boundary_conditions.png")
    return [*(folder / f"{name}.vtu" for name in bodies), picture]
