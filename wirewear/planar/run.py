"""A planar run: the cycles and solvers are those of the wires, in plane strain."""

from __future__ import annotations

from pathlib import Path

from solvers import unloaded_state
from wirewear.effects import problem_with
from wirewear.files.identity import PLANAR_CODE, added_code, identity_of
from wirewear.planar.model import PlanarPlan, plan, planar_problem
from wirewear.planar.record import PlanarRecord
from wirewear.planar.results import PlanarResult, read_planar_result, write_planar_result
from wirewear.planar.tables import PlanarStudy
from wirewear.simulation import NoObserver
from wirewear.simulation.cycler import FrettingTest, Motion
from wirewear.simulation.cycling import cycle_through
from wirewear.simulation.folder import InMemory, RunFolder, occupied_by_runs
from wirewear.simulation.mesh_history import OneMesh
from wirewear.simulation.observers import Observer

#: Pictures and tables of a run, relative to its folder.
DERIVED = ("profiles.png", "loops.png", "profiles.csv", "loops.csv", "evolution.csv")


def run_planar_study(
    study: PlanarStudy,
    *,
    fidelity: str = "standard",
    output: Path | None = None,
    resume: bool = False,
    observer: Observer[PlanarResult] | None = None,
) -> PlanarResult:
    """Simulate a planar study; with `output`, leave result.h5, the CSV tables and the pictures there.

    With `resume`, the run in `output` continues at its last checkpoint; one that is complete is left as it is.

    Raises:
        StudyError: the study cannot be meshed.
        RunError: nothing can be written to `output`, or another command does; or it is to be resumed and holds another
            run.
        SolverError: the contact did not converge, or left the fine patch; everything up to there is on disk.
    """
    from wirewear.planar.pictures import draw_planar_result

    planned = plan(study, fidelity)
    identity = identity_of(
        {"study": study.model_dump(mode="json", exclude_none=True), "fidelity": fidelity},
        PLANAR_CODE,
        planned.settings() | {"added": added_code((*study.effects, study.contact.friction_law))},
    )
    test = planar_test(study, planned)
    record = PlanarRecord(study, fidelity, planned.settings() | {"identity": str(identity)})
    watched = observer or NoObserver()
    if output is None:
        return cycle_through(test, record, InMemory[PlanarResult](identity), watched)
    folder = RunFolder(output, identity, read_planar_result, write_planar_result, DERIVED)
    with occupied_by_runs(output, study.name, [folder], resume=resume) as (found,):
        if found.complete is not None:
            return found.complete
        if found.note:
            watched.note(found.note)
        result = cycle_through(test, record, folder, watched, resume=resume)
        draw_planar_result(output, result)
        return result


def planar_test(study: PlanarStudy, planned: PlanarPlan) -> FrettingTest:
    """The test as a run goes through it."""
    conditions, n = study.conditions, planned.increments_per_cycle
    motion = Motion(
        amplitude_mm=1e-3 * conditions.displacement_amplitude_um,
        increments=n,
        wear_increments=n,
        follows_force=study.mesh.increments_per_cycle is None,
        fresh=unloaded_state,
        aged=lambda problem, age: problem_with(problem, study.effects, age),
    )
    milestones = tuple(float(cycle) for cycle in sorted({1, *study.log.loop_cycles, conditions.cycles}))
    return FrettingTest(motion, OneMesh(lambda: planar_problem(study, planned)), milestones, planned.jump_tolerance)
