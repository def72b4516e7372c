"""A study's wires for scripts that go beneath a run: meshes, also as files, condensation, single increments."""

from __future__ import annotations

from pathlib import Path

from geometry import BodyMesh, Elastic, HexMesh, build_body
from solvers import (
    ContactProblem,
    ContactState,
    IncrementReport,
    advance,
    closed_cycle,
    first_quarter,
    press,
    run_cycle,
    unloaded_state,
)
from solvers.condensation import compliance_of, piece_to_condense
from solvers.elasticity import stiffness_matrix
from solvers.substructuring import schur_complement, schur_complements
from wirewear.base.errors import ResultError
from wirewear.base.writing import in_one_step, writing
from wirewear.simulation.budget import require_affordable
from wirewear.simulation.discretisation import Discretisation, discretise
from wirewear.simulation.plan import RunPlan
from wirewear.simulation.problem import contact_problem
from wirewear.study import Study

__all__ = [
    "BodyMesh",
    "ContactProblem",
    "ContactState",
    "Discretisation",
    "Elastic",
    "HexMesh",
    "IncrementReport",
    "advance",
    "build_body",
    "closed_cycle",
    "compliance_of",
    "contact_problem",
    "discretise",
    "first_quarter",
    "piece_to_condense",
    "press",
    "run_cycle",
    "schur_complement",
    "schur_complements",
    "stiffness_matrix",
    "unloaded_state",
]


def write_meshes(study: Study, fidelity: str, folder: Path) -> list[Path]:
    """Mesh both wires; leave moving.vtu, fixed.vtu (surfaces as point data), mesh.png and
    boundary_conditions.png in a folder.

    Where the meshes follow the scar, those of its last stage are written and the first one is drawn as well. Variants
    of a study that mesh alike share one mesh: that of the study as a whole is written.

    Raises:
        StudyError: the study cannot be discretised.  GeometryError: the mesh is distorted.
        ResultError: the files cannot be written.
    """
    from wirewear.pictures import save, surface_fields, wire_meshes
    from wirewear.pictures.wire_supports import wire_supports

    plan = RunPlan.of(study, fidelity)
    require_affordable(plan)
    first, *others = plan.meshes.stages
    last = others[-1] if others else first
    wires = {"moving": build_body(last.moving), "fixed": build_body(last.fixed)}
    fresh = build_body(first.moving) if others else None
    with writing(ResultError, f"cannot write meshes to {folder}"):
        folder.mkdir(parents=True, exist_ok=True)
        for name, wire in wires.items():
            with in_one_step(folder / f"{name}.vtu") as partial:
                wire.mesh.write(partial, surface_fields(wire))
    angle = study.wires.crossing_angle_deg
    picture = save(lambda: wire_meshes(wires["moving"], wires["fixed"], angle, fresh), folder / "mesh.png")
    supports = save(lambda: wire_supports(study, wires["moving"], wires["fixed"]), folder / "boundary_conditions.png")
    return [*(folder / f"{name}.vtu" for name in wires), picture, supports]
