"""Runs of a study: one, or one for each of its variants, one after another or side by side."""

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from solvers import ContactProblem, ContactState, CycleTrace, IncrementReport
from wirewear.base.engine import Engine, LocalProcesses
from wirewear.results import PRESSURE_LENGTH, ContactForces, RunResult, Scar
from wirewear.results.flat import TIME_SERIES_FILES
from wirewear.simulation.contact_forces import forces_of
from wirewear.simulation.cycling import cycle_through
from wirewear.simulation.folder import InMemory, MeshHistory, RunFolder
from wirewear.simulation.observers import NoObserver, Observer
from wirewear.simulation.plan import RunPlan, affordable_jobs, require_affordable
from wirewear.simulation.problem import condense_bodies
from wirewear.simulation.recorded import MEASURED, Recorded, holder_settings, scars_of
from wirewear.simulation.tally import bends
from wirewear.simulation.together import Task, run_together
from wirewear.study import Study

#: What `wirewear show` and `report` make of a run, relative to its folder; here, as drawing takes long to import.
PICTURES = (
    "report.html",
    *(
        f"pictures/{name}.{ending}"
        for name in ("loops", "evolution", "scars_from_above", "contact*", "scar_series*", "sections", "scars_3d")
        for ending in ("png", "svg", "pdf")
    ),
    "pictures/loop_and_scar*.gif",
)
ObserverOf = Callable[[str], AbstractContextManager[Observer]]


class PointRecord(Recorded):
    """The record of one run of a contact at a point."""

    length_mm = None

    def __init__(self, plan: RunPlan) -> None:
        """Empty, before the run."""
        super().__init__(plan.study, plan.fidelity, plan.pressure_length_mm)
        self.plan = plan
        self.contact_kind, self.bodies = plan.study.contact_kind, plan.discretisation.bodies

    def restore(self, before: RunResult, done: float) -> None:
        """Take over what the interrupted run had recorded up to that cycle."""
        super().restore(before, done)
        # A run that had done its last cycle measures its holder no more.
        self._holder = {name: value for name, value in before.settings.items() if name.startswith(MEASURED)}

    def pressed(self, state: ContactState, report: IncrementReport) -> None:
        """Record the fresh contact under the normal load alone."""
        super().pressed(state, report)
        self.tally.fresh |= {
            "fresh_approach_um": -1e3 * state.holder_z,
            "fresh_contact_radius_um": 1e3 * (report.contact_area / np.pi) ** 0.5,
        }

    def holder_of(self, problem: ContactProblem, trace: CycleTrace) -> dict[str, float | str]:
        """Its stiffnesses and its play."""
        return holder_settings(problem, trace)

    def follows(self, problem: ContactProblem, state: ContactState, done: float, work_mJ: float) -> bool:
        """Whether the energy since the latest loop has gone as between two loops it is taken to; see `Recorded`."""
        last = self._rows[-1]
        if not super().follows(problem, state, done, work_mJ):
            return False
        if self.schedule.at(last["cycle"]) is not self.schedule.at(done):
            return True  # a loop of another block says nothing of this one's
        since = (last["cycle"], last["dissipated_energy_mJ"], 1e3 * last["accumulated_energy_J"])
        return not bends(since, (done, work_mJ, state.wear.energy_mJ))

    def logs(self, cycle: int, done: float) -> bool:
        """Those that the plan logs, and the last."""
        return self.ends or cycle in self.plan.logged_cycles or done >= self.plan.study.conditions.cycles

    def scars(self, problem: ContactProblem, trace: CycleTrace, cycle: int) -> tuple[Scar, Scar]:
        """Those of the driven and of the held body."""
        return scars_of(problem, trace, cycle, self.plan.study)

    def forces(self, problem: ContactProblem, trace: CycleTrace, cycle: int) -> tuple[ContactForces, ...]:
        """With what bodies are meshed of."""
        return forces_of(problem, trace, cycle, self.plan)

    def tables(self) -> dict[str, Any]:
        """The study with what it leaves open."""
        return self.plan.study.resolved()

    def settings(self, history: MeshHistory) -> dict[str, Any]:
        """The discretisation, and what was measured of the holder."""
        plan, counters = self.plan, self.tally.counters
        return {
            **plan.discretisation.settings(),
            PRESSURE_LENGTH: 1e3 * plan.pressure_length_mm,
            **self.tally.fresh,
            **self._holder,
            "mesh_changes": list(history.changes),
            "mesh_stages": [1e3 * stage.to_half_width_mm for stage in plan.meshes.stages],
            "increments": counters.increments,
            "simulated_cycles": counters.simulated_cycles,
            "mean_iterations_per_increment": counters.iterations / max(counters.increments, 1.0),
            "identity": str(plan.identity),
        }


def run_study(
    study: Study,
    *,
    fidelity: str = "standard",
    output: str | Path,
    resume: bool = False,
    observer_of: ObserverOf | None = None,
    jobs: int = 1,
    engine: Engine | None = None,
) -> list[RunResult]:
    """Simulate a study, or each of its variants, and leave OUTPUT[/<variant>]/result.h5.

    `observer_of` opens an observer for each run by its label. With `resume`, a run continues at its last checkpoint,
    and one that is complete is read from its file and left as it is; one that another version of the program made is
    run anew, of which the observer is told. With `jobs` above 1, that many variants run side by side, each in a
    process of its own, or where `engine` does it, whose workers must see the folder; the results are the same.

    Raises:
        StudyError: the study cannot be discretised, or asks for more memory or cycle jumps than can be had.
        RunError: a run is to be resumed, but the folder holds that of another study; or another command is writing to
            the folder, or it cannot be written.
        ResultError: a run is to be resumed, but what it has left is damaged; or a file cannot be written.
        SolverError: the contact did not converge, or left the fine patch; everything up to there is on disk.
    """

    def engine_for(left: Sequence[RunPlan]) -> Engine:
        for plan in left:
            require_affordable(plan)
        return engine or LocalProcesses(min(affordable_jobs(list(left), jobs), max(len(left), 1)))

    # Variants mostly share their bodies: condensed once here, they are loaded by every process.
    return run_planned(
        study,
        RunPlan.of,
        PointRecord,
        fidelity,
        Path(output),
        engine_for,
        (*TIME_SERIES_FILES, *PICTURES),
        prepare=_condense,
        resume=resume,
        observer_of=observer_of,
    )


def run_planned(
    study: Any,
    plan_of: Callable[[Any, str], Any],
    record_of: Callable[[Any], Recorded],
    fidelity: str,
    output: Path,
    engine_for: Callable[[Sequence[Any]], Engine],
    derived: tuple[str, ...],
    *,
    prepare: Callable[[Any, Callable[[str], None]], None] | None = None,
    resume: bool = False,
    observer_of: ObserverOf | None = None,
) -> list[RunResult]:
    """The results of a study of any kind, or of each of its variants in a folder of its own; raises as `run_study`.

    plan_of: of a study without variants at a fidelity, with study, label, identity and test as `RunPlan` has them.
    record_of: an empty record of a plan.  engine_for: says what does the runs that are left; StudyError where one
    cannot be afforded.  derived: patterns of the files that are made of a run's result.  prepare: does what runs side
    by side would all have to do.
    """
    variants = [study.variant(name) for name in study.variant_names] or [study]
    plans = [plan_of(variant, fidelity) for variant in variants]
    tasks = [
        Task(
            plan.label,
            RunFolder(output / plan.study.variant_name if study.variant_names else output, plan.identity, derived),
            partial(run_cycles, plan, record_of),
            None if prepare is None else partial(prepare, plan),
        )
        for plan in plans
    ]
    plan_in = {task.folder.path: plan for task, plan in zip(tasks, plans, strict=True)}
    return run_together(
        output,
        study.name,
        tasks,
        lambda left: engine_for([plan_in[task.folder.path] for task in left]),
        variants=bool(study.variant_names),
        resume=resume,
        observer_of=observer_of,
    )


def simulate(study: Study, *, fidelity: str = "standard", observer: Observer | None = None) -> RunResult:
    """Simulate a study without variants, or one variant, and leave no file.
    Raises StudyError if it cannot be discretised, or asks for more memory or cycle jumps than can be had; SolverError
    if the contact did not converge, or left the fine patch.
    """
    plan = RunPlan.of(study, fidelity)
    require_affordable(plan)
    kept = InMemory(plan.identity)
    return cycle_through(plan.test, PointRecord(plan), kept, observer or NoObserver(), resume=False)


def _condense(plan: RunPlan, stage: Callable[[str], None]) -> None:
    for meshes in plan.meshes.stages:
        condense_bodies(plan.study, meshes, stage)


def run_cycles(
    plan: Any, record_of: Callable[[Any], Recorded], folder: RunFolder, observer: Observer, *, resume: bool
) -> RunResult:
    """Simulate a run, from its last checkpoint on where it is to be resumed and has one; raises as `cycle_through`."""
    return cycle_through(plan.test, record_of(plan), folder, observer, resume=resume)
