"""A run: a study simulated from the first cycle to the last, logged, checkpointed and resumable."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack, nullcontext
from dataclasses import fields, replace
from functools import partial
from importlib.metadata import version
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from solvers import (
    ContactProblem,
    ContactState,
    Guide,
    IncrementReport,
    JumpController,
    PatchLeftError,
    SolverError,
    closed_cycle,
    extrapolated,
    first_quarter,
    press,
    remeshed,
    run_cycle,
    settled,
    take_step,
    wear_difference,
)
from wirewear.checkpoint import CHECKPOINT_FILE_NAME, Checkpoint, read_checkpoint, write_checkpoint
from wirewear.discretisation import LEVELS, Discretisation, discretise
from wirewear.effects import Age
from wirewear.errors import RunError
from wirewear.expected_wear import flattened_volume
from wirewear.measure import Counters, area_mismatch, evolution_row, holder_settings, volume_mismatch
from wirewear.mesh_stages import mesh_stages
from wirewear.model import condense_wires, fresh_state, loop_of, problem_at, scars_of
from wirewear.observers import Moment, NoObserver, RunObserver
from wirewear.results import RESULT_FILE_NAME, Evolution, Loop, RunResult, Scar, read_result, write_result
from wirewear.run_meshes import RunMeshes
from wirewear.side_by_side import run_side_by_side
from wirewear.study import Study
from wirewear.study.reading import default_loop_cycles

#: Packages whose versions a result records.
_PROGRAMS = ("wirewear", "numpy", "scipy", "scikit-fem", "gmsh", "h5py")

ObserverOf = Callable[[str], AbstractContextManager[RunObserver]]


def run_study(
    study: Study,
    *,
    fidelity: str = "standard",
    output: Path,
    resume: bool = False,
    observer_of: ObserverOf | None = None,
    jobs: int = 1,
) -> list[RunResult]:
    """Simulate a study, or each of its variants, and leave OUTPUT[/<variant>]/result.h5.

    `observer_of` opens an observer for each run by its label. With `resume`, a run continues at its last checkpoint,
    and one that is complete is left as it is. With `jobs` above 1, that many variants run side by side, each in a
    process of its own; the results are the same.

    Raises:
        StudyError: the study cannot be discretised.
        RunError: a run is to be resumed, but the folder holds that of another study.
        SolverError: the contact did not converge, or left the fine patch; everything up to there is on disk.
    """
    variants = [study.variant(name) for name in study.variant_names] or [study]
    folders = [output / variant.variant_name if study.variant_names else output for variant in variants]
    plans = [_plan(variant, fidelity) for variant in variants]
    tasks = [
        partial(_run, variant, fidelity, folder, plan, resume)
        for variant, folder, plan in zip(variants, folders, plans, strict=True)
    ]
    labels = [variant.variant_name or variant.name for variant in variants]

    def observer(label: str) -> AbstractContextManager[RunObserver]:
        return observer_of(label) if observer_of else nullcontext(NoObserver())

    if jobs <= 1 or len(tasks) == 1:
        results = []
        for task, label in zip(tasks, labels, strict=True):
            with observer(label) as watching:
                results.append(task(watching))
        return results
    with ExitStack() as stack:
        watchers = [stack.enter_context(observer(label)) for label in labels]
        # Variants mostly share their wires: condensed once here, they are loaded by every process.
        for variant, (_, meshes) in zip(variants, plans, strict=True):
            for stage in meshes.stages:
                condense_wires(variant, stage, watchers[0].stage)
        return run_side_by_side(tasks, watchers, min(jobs, len(tasks)))


_Plan = tuple[Discretisation, RunMeshes]


def _plan(study: Study, fidelity: str) -> _Plan:
    plan = discretise(study, fidelity)
    return plan, RunMeshes(study, mesh_stages(study, fidelity, plan))


def _run(study: Study, fidelity: str, folder: Path, plan: _Plan, resume: bool, observer: RunObserver) -> RunResult:
    return _Run(study, fidelity, folder, plan, observer).go(resume=resume)


class _Run:
    """One variant's run. Everything that is logged is written before the next cycle jump begins."""

    def __init__(self, study: Study, fidelity: str, folder: Path, plan: _Plan, observer: RunObserver) -> None:
        self.study, self.fidelity, self.folder, self.observer = study, fidelity, folder, observer
        self.plan, self.meshes = plan
        self.history = self.meshes.first(flattened_volume(study))
        self.amplitude = study.conditions.displacement_amplitude_um * 1e-3
        self.end = float(study.conditions.cycles)
        self.logged_cycles = study.log.loop_cycles or default_loop_cycles(study.conditions.cycles)
        self.milestones = _milestones(self.logged_cycles, study.conditions.cycles, LEVELS[fidelity].loop_spacing)
        self.explicit_jump = study.wear.explicit_jump_cycles if study.wear else None
        self.guide: Guide | None = None
        self.identity = _identity(study, fidelity, self.plan)
        self.loops: list[Loop] = []
        self.scars: list[Scar] = []
        self.rows: list[dict[str, float]] = []
        self.counters = Counters()
        self.pressed: dict[str, float] = {}
        self.holder: dict[str, float | str] = {}
        self.preparation_s = 0.0
        self.cycling_started = 0.0

    def go(self, *, resume: bool) -> RunResult:
        finished = self._finished() if resume else None
        if finished is not None:
            return finished
        checkpoint = self._checkpoint() if resume else None
        self.folder.mkdir(parents=True, exist_ok=True)
        started = time.perf_counter()
        if checkpoint is not None:
            self.history = checkpoint.meshes
        problem = self.meshes.problem(self.history, self.observer.stage)
        self.preparation_s = time.perf_counter() - started
        self.cycling_started = time.perf_counter()
        try:
            # Thousands of small dense problems: sharing each between cores costs more than it gains.
            with threadpool_limits(limits=1, user_api="blas"):
                if checkpoint is None:
                    problem, state = self._started(problem)
                    done, jump = 1.0, JumpController(self.plan.jump_tolerance).first_jump
                else:
                    state, done, jump = checkpoint.state, checkpoint.done, checkpoint.next_jump
                    self.guide = checkpoint.guide
                self._cycle_on(problem, state, done, jump)
        except SolverError as error:
            self._write("failed", str(error))
            raise
        self._write("complete", f"{self.study.conditions.cycles:,} cycles simulated")
        (self.folder / CHECKPOINT_FILE_NAME).unlink(missing_ok=True)
        return read_result(self.folder / RESULT_FILE_NAME)

    def _started(self, problem: ContactProblem) -> tuple[ContactProblem, ContactState]:
        """The problem and the state after the first cycle, on the first meshes that hold the contact.

        Soft layers between the wires let them touch far beyond the contact for which the first meshes are made.
        """
        while True:
            try:
                return problem, self._start(problem)
            except PatchLeftError:
                if not self.meshes.more_stages(self.history):
                    raise
                self.history = replace(self.history, stage=self.history.stage + 1)
                problem = self.meshes.problem(self.history, self.observer.stage)

    def _start(self, problem: ContactProblem) -> ContactState:
        """Press, move to +amplitude and log the first cycle, during which wear is still nothing."""
        (self.folder / CHECKPOINT_FILE_NAME).unlink(missing_ok=True)
        state = fresh_state(problem, self.study)
        fresh = self._aged(problem, state, 0.0)
        state, report = press(fresh, state)
        self.counters.count(report)
        self.pressed = {
            "fresh_max_pressure_MPa": report.max_pressure,
            "fresh_approach_um": -1e3 * state.holder_z,
            "fresh_contact_radius_um": 1e3 * (report.contact_area / np.pi) ** 0.5,
        }
        state = first_quarter(fresh, state, self.amplitude, self.plan.increments_per_cycle, self._watch(1.0))
        return self._log(problem, state, 1.0, 1.0)

    def _cycle_on(self, problem: ContactProblem, state: ContactState, done: float, jump: float) -> None:
        controller = JumpController(self.plan.jump_tolerance)
        n = self.plan.increments_per_wear_cycle

        def cycle(start: ContactState, before: float, cycles: float) -> ContactState:
            current = self._aged(problem, start, before + 0.5 * cycles)
            after, trace = run_cycle(current, start, self.amplitude, n, cycles, self._watch(done), self.guide)
            self.guide = trace.guide
            self.counters.simulated_cycles += 1
            return after

        def difference(whole: ContactState, halves: ContactState) -> float:
            return wear_difference(problem, whole, halves)

        def combined(whole: ContactState, halves: ContactState) -> ContactState:
            return extrapolated(problem, whole, halves)

        milestones = self.milestones
        while done < self.end:
            problem, state = self._on_due_meshes(problem, state, done)
            ahead = min(m for m in milestones if m > done)
            try:
                if problem.wear.none:
                    size = ahead - done
                elif self.explicit_jump is not None:
                    size = min(self.explicit_jump, ahead - done)
                    state = cycle(state, done, size)
                else:
                    step = take_step(controller, state, jump, done, milestones, self.end, cycle, difference, combined)
                    state, jump, size = step.state, step.next_jump, step.jump
            except PatchLeftError:
                if not self.meshes.more_stages(self.history):
                    raise
                # The scar has become larger than its volume let expect.
                problem, state = self._on_next_stage(problem, state, done)
                continue
            reached = abs(ahead - done - size) < 1e-6 * ahead
            done = ahead if reached else done + size
            if reached:
                problem, state = self._on_due_meshes(problem, state, done)
                problem, state = self._logged(problem, state, done, size)
                self._write("running", f"{done:,.0f} of {self.end:,.0f} cycles simulated")
            counters = {**self.counters.__dict__, "preparation_s": self.preparation_s}
            counters["cycling_s"] += time.perf_counter() - self.cycling_started
            counters |= self.pressed
            write_checkpoint(
                self.folder, Checkpoint(done, jump, state, self.guide, counters, self.history, self.identity)
            )

    def _on_due_meshes(
        self, problem: ContactProblem, state: ContactState, done: float
    ) -> tuple[ContactProblem, ContactState]:
        """The problem and state on new meshes where the scar has outgrown the old, with nodes moved where due."""
        while self.meshes.due_stage(self.history, state):
            problem, state = self._on_next_stage(problem, state, done)
        if self.meshes.due_motion(self.history, problem, state):
            self.history, problem = self.meshes.with_nodes_moved(
                self.history, problem, state, done, self.observer.stage
            )
        return problem, state

    def _logged(
        self, problem: ContactProblem, state: ContactState, done: float, jump: float
    ) -> tuple[ContactProblem, ContactState]:
        """The state after the loop has been measured, on larger meshes where it leaves those of now."""
        while True:
            try:
                return problem, self._log(problem, state, done, jump)
            except PatchLeftError:
                if not self.meshes.more_stages(self.history):
                    raise
                problem, state = self._on_next_stage(problem, state, done)

    def _on_next_stage(
        self, problem: ContactProblem, state: ContactState, done: float
    ) -> tuple[ContactProblem, ContactState]:
        """The problem and state on the next stage's meshes."""
        self.history = self.meshes.next_stage(self.history, done)
        fresh = self.meshes.problem(self.history, self.observer.stage)
        before, after = self._aged(problem, state, done), self._aged(fresh, state, done)
        state, report = remeshed(before, state, after)
        self.counters.count(report)
        n = self.plan.increments_per_wear_cycle
        state, trace = settled(after, state, self.amplitude, n, self._watch(done))
        self.guide = trace.guide
        return fresh, state

    def _aged(self, problem: ContactProblem, state: ContactState, cycles: float) -> ContactProblem:
        """The problem as it is at that cycle and after the energy accumulated so far."""
        return problem_at(problem, self.study, Age(cycles, 1e-3 * state.wear.energy_mJ))

    def _log(self, problem: ContactProblem, state: ContactState, done: float, jump: float) -> ContactState:
        """Measure a closed loop with the wear frozen; record it, with the scars, where the study asks for it."""
        n, settling = self.plan.increments_per_cycle, self.plan.increments_per_wear_cycle
        problem = self._aged(problem, state, done)
        state, trace = closed_cycle(problem, state, self.amplitude, n, self._watch(done), self.guide, settling)
        self.guide = trace.guide
        self.counters.simulated_cycles += 1
        loop = loop_of(trace, round(done), self.study.conditions.frequency_Hz)
        scars = scars_of(problem, trace, round(done), self.study)
        self.holder = holder_settings(problem, trace)
        counters = self.counters
        counters.loop_area_against_friction_work = max(
            counters.loop_area_against_friction_work, area_mismatch(loop, trace.friction_work)
        )
        counters.volume_against_energy = max(counters.volume_against_energy, volume_mismatch(problem, state, scars))
        self.rows.append(evolution_row(state, trace, loop, scars, done, jump))
        if round(done) in self.logged_cycles or done >= self.end:
            self.loops.append(loop)
            self.scars.extend(scars)
        return state

    def _watch(self, done: float) -> Callable[[ContactState, IncrementReport], None]:
        def watch(state: ContactState, report: IncrementReport) -> None:
            self.counters.count(report)
            elapsed = self.counters.cycling_s + time.perf_counter() - self.cycling_started
            deepest = max(float(state.wear.primary_depth.max()), float(state.wear.secondary_depth.max()))
            # Jumps grow with the cycles done, so the logarithm of the cycles is what passes evenly.
            fraction = float(np.log(max(done, 1.0)) / np.log(max(self.end, 1.0 + 1e-9)))
            self.observer.moved(
                Moment(done, int(self.end), 1e-3 * state.wear.energy_mJ, 1e3 * deepest, min(fraction, 1.0), elapsed)
            )

        return watch

    def _result(self, status: str, message: str) -> RunResult:
        counters = self.counters
        cycling = counters.cycling_s + time.perf_counter() - self.cycling_started
        increments = max(counters.increments, 1.0)
        return RunResult(
            name=self.study.name,
            variant=self.study.variant_name,
            fidelity=self.fidelity,
            status=status,
            message=message,
            study=self.study.resolved(),
            loops=tuple(self.loops),
            evolution=Evolution.from_rows(self.rows),
            scars=tuple(self.scars),
            settings={
                **self.plan.settings(),
                **self.pressed,
                **self.holder,
                "mesh_changes": list(self.history.changes),
                "mesh_stages": [1e3 * stage.to_half_width_mm for stage in self.meshes.stages],
                "increments": counters.increments,
                "simulated_cycles": counters.simulated_cycles,
                "mean_iterations_per_increment": counters.iterations / increments,
                "identity": self.identity,
            },
            quality=counters.quality(),
            versions={program: version(program) for program in _PROGRAMS},
            timings_s={
                "preparation": self.preparation_s,
                "cycling": cycling,
                "total": self.preparation_s + cycling,
            },
        )

    def _write(self, status: str, message: str) -> None:
        result = self._result(status, message)
        write_result(self.folder / RESULT_FILE_NAME, result)
        self.observer.logged(result)

    def _finished(self) -> RunResult | None:
        path = self.folder / RESULT_FILE_NAME
        if not path.exists():
            return None
        result = read_result(path)
        self._require_same(result.settings.get("identity"))
        return result if result.status == "complete" else None

    def _checkpoint(self) -> Checkpoint | None:
        checkpoint = read_checkpoint(self.folder)
        if checkpoint is None:
            return None
        self._require_same(checkpoint.identity)
        before = read_result(self.folder / RESULT_FILE_NAME)
        self.loops = [loop for loop in before.loops if loop.cycle <= checkpoint.done]
        self.scars = [scar for scar in before.scars if scar.cycle <= checkpoint.done]
        evolution = before.evolution
        self.rows = [
            {name: float(column[i]) for name, column in evolution.items()}
            for i in range(len(evolution["cycle"]))
            if evolution["cycle"][i] <= checkpoint.done
        ]
        known = {
            name: value
            for name, value in checkpoint.counters.items()
            if name in {field.name for field in fields(Counters)}
        }
        self.counters = Counters(**known)
        self.pressed = {name: value for name, value in checkpoint.counters.items() if name.startswith("fresh_")}
        return checkpoint

    def _require_same(self, identity: object) -> None:
        if identity != self.identity:
            raise RunError(
                f"{self.folder} holds a run of another study, fidelity or version of wirewear, which cannot be "
                "resumed; choose another --output, or run without --resume to replace it"
            )


def _milestones(logged: tuple[int, ...], cycles: int, spacing: float) -> tuple[float, ...]:
    """Cycles at which the loop is measured: those to be logged, and of the series 1, 2, 5, 10, ... those apart from
    them by the ratio `spacing`.
    """
    between = (
        cycle
        for cycle in default_loop_cycles(cycles)
        if all(max(cycle / other, other / cycle) >= spacing for other in logged)
    )
    return tuple(float(cycle) for cycle in sorted({*logged, *between, cycles}))


def _identity(study: Study, fidelity: str, plan: Discretisation) -> str:
    parts = {
        "study": study.resolved(),
        "variant": study.variant_name,
        "fidelity": fidelity,
        "plan": plan.settings(),
        "version": version("wirewear"),
    }
    return hashlib.sha256(json.dumps(parts, sort_keys=True, default=str).encode()).hexdigest()
