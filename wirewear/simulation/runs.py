"""Runs of a study: one, or one for each of its variants, one after another or side by side."""

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from solvers import ContactProblem, ContactState, CycleTrace, IncrementReport
from wirewear.base.budget import free_memory
from wirewear.base.engine import Engine, LocalProcesses
from wirewear.results import PRESSURE_LENGTH, ContactForces, RunResult, Scar
from wirewear.simulation.contact_forces import forces_of
from wirewear.simulation.cycling import cycle_through
from wirewear.simulation.folder import MeshHistory, RunFolder, RunStore
from wirewear.simulation.line_runs import LineRun, LineRunRecord
from wirewear.simulation.observers import Observer
from wirewear.simulation.plan import RunPlan
from wirewear.simulation.recorded import MEASURED, Recorded, holder_settings, scars_of
from wirewear.simulation.tally import bends
from wirewear.simulation.together import Task, run_together
from wirewear.study import AnyStudy, LineStudy, Study
from wirewear.study.any_study import alone

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


#: How a test is planned and recorded, by its study.
_WAYS: dict[type[AnyStudy[Any]], tuple[Any, Callable[[Any], Recorded]]] = {
    Study: (RunPlan, PointRecord),
    LineStudy: (LineRun, LineRunRecord),
}


def run_study(
    study: AnyStudy[Any],
    *,
    fidelity: str = "standard",
    output: str | Path,
    resume: bool = False,
    observer_of: ObserverOf | None = None,
    jobs: int = 1,
    engine: Engine | None = None,
) -> list[RunResult]:
    """Simulate a study of any kind, or each of its variants, and leave OUTPUT[/<variant>]/result.h5.

    `observer_of` opens an observer for each run by its label. With `resume`, a run continues at its last checkpoint,
    and one that is complete is read from its file and left as it is; one that another version of the program made is
    run anew, of which the observer is told. With `jobs` above 1, that many variants run side by side, each in a
    process of its own, or where `engine` does it, whose workers must see the folder; the results are the same.

    Raises StudyError if the study cannot be discretised, or asks for more memory or cycle jumps than can be had;
    RunError if a run is to be resumed, but the folder holds that of another study; or another command is writing to the
    folder, or it cannot be written; ResultError if a run is to be resumed, but what it has left is damaged; or a file
    cannot be written; SolverError if the contact did not converge, or left the fine patch; everything up to there is on
    disk.
    """
    way, output = _WAYS[type(study)][0], Path(output)
    variants = [study.variant(name) for name in study.variant_names] or [study]
    plans = [way.of(variant, fidelity) for variant in variants]
    tasks = [
        Task(
            plan.label,
            RunFolder(plan.identity, output / plan.study.variant_name if study.variant_names else output, plan.derived),
            partial(run_cycles, plan),
            partial(type(plan).prepare, plan),
        )
        for plan in plans
    ]
    plan_in = {task.folder.path: plan for task, plan in zip(tasks, plans, strict=True)}

    def engine_for(left: Sequence[Task]) -> Engine:
        due = [plan_in[task.folder.path] for task in left]
        for plan in due:
            plan.require_affordable()
        largest = max((plan.needed_memory for plan in due), default=1.0)
        return engine or LocalProcesses(max(1, min(jobs, len(due), int(min(free_memory() / largest, 1e6)))))

    return run_together(
        output,
        study.name,
        tasks,
        engine_for,
        variants=bool(study.variant_names),
        resume=resume,
        observer_of=observer_of,
    )


def simulate(study: AnyStudy[Any], *, fidelity: str = "standard", observer: Observer | None = None) -> RunResult:
    """Simulate a study without variants, or one variant, and leave no file.
    Raises StudyError if it has variants, cannot be discretised, or asks for more memory or cycle jumps than can be had;
    SolverError if the contact did not converge, or left the fine patch.
    """
    way, record_of = _WAYS[type(alone(study, 'take one of them, as in study.variant("{first}")'))]
    plan = way.of(study, fidelity)
    plan.require_affordable()
    return cycle_through(plan.test, record_of(plan), RunStore(plan.identity), observer or Observer(), resume=False)


def needed_memory(study: AnyStudy[Any], fidelity: str) -> float:
    """Bytes that the run of a study takes at least; StudyError where it cannot be discretised."""
    return float(_WAYS[type(study)][0].of(study, fidelity).needed_memory)


def run_cycles(plan: Any, folder: RunFolder, observer: Observer, *, resume: bool) -> RunResult:
    """Simulate a run, from its last checkpoint on where it is to be resumed and has one; raises as `cycle_through`."""
    return cycle_through(plan.test, _WAYS[type(plan.study)][1](plan), folder, observer, resume=resume)
