"""One run from its first cycle to its last: cycle jumps, loops at the milestones, meshes that follow the scar."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

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
from wirewear.effects import Age
from wirewear.results import RunResult
from wirewear.simulation.checkpoint import Checkpoint, write_checkpoint
from wirewear.simulation.expected_wear import flattened_volume
from wirewear.simulation.folder import RunFolder
from wirewear.simulation.log import RunLog
from wirewear.simulation.observers import Moment, RunObserver
from wirewear.simulation.plan import RunPlan
from wirewear.simulation.problem import fresh_state, problem_at


def run_cycles(plan: RunPlan, folder: RunFolder, observer: RunObserver, *, resume: bool) -> RunResult:
    """Simulate a run, from its last checkpoint on where it is to be resumed and has one.

    Raises:
        RunError: the folder holds another run's checkpoint.
        ResultError: the checkpoint is damaged.
        SolverError: the contact did not converge, or left the fine patch; everything up to there is on disk.
    """
    return _Run(plan, folder, observer).go(resume=resume)


class _Run:
    """A run under way. Everything that is logged is written before the next cycle jump begins."""

    def __init__(self, plan: RunPlan, folder: RunFolder, observer: RunObserver) -> None:
        self.plan, self.folder, self.observer = plan, folder, observer
        self.study, self.meshes = plan.study, plan.meshes
        self.increments = plan.discretisation.increments_per_cycle
        self.wear_increments = plan.discretisation.increments_per_wear_cycle
        self.explicit_jump = plan.study.wear.explicit_jump_cycles if plan.study.wear else None
        self.history = plan.meshes.first(flattened_volume(plan.study))
        self.guide: Guide | None = None
        self.log = RunLog(plan)

    def go(self, *, resume: bool) -> RunResult:
        interrupted = self.folder.interrupted() if resume else None
        started = time.perf_counter()
        if interrupted is not None:
            self.log.restore(*interrupted)
            self.history = interrupted[0].meshes
        problem = self.meshes.problem(self.history, self.observer.stage)
        self.log.preparation_s = time.perf_counter() - started
        self.log.start_cycling()
        try:
            # Thousands of small dense problems: sharing each between cores costs more than it gains.
            with threadpool_limits(limits=1, user_api="blas"):
                if interrupted is None:
                    problem, state = self._started(problem)
                    done, jump = 1.0, JumpController(self.plan.discretisation.jump_tolerance).first_jump
                else:
                    checkpoint = interrupted[0]
                    state, done, jump = checkpoint.state, checkpoint.done, checkpoint.next_jump
                    self.guide = checkpoint.guide
                self._cycle_on(problem, state, done, jump)
        except SolverError as error:
            self._write("failed", str(error))
            raise
        self._write("complete", f"{self.study.conditions.cycles:,} cycles simulated")
        self.folder.drop_checkpoint()
        return self.folder.result()

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
        self.folder.drop_checkpoint()
        state = fresh_state(problem, self.study)
        fresh = self._aged(problem, state, 0.0)
        state, report = press(fresh, state)
        self.log.pressed(state, report)
        state = first_quarter(fresh, state, self.plan.amplitude_mm, self.increments, self._watch(1.0))
        return self._measure(problem, state, 1.0, 1.0)

    def _cycle_on(self, problem: ContactProblem, state: ContactState, done: float, jump: float) -> None:
        controller = JumpController(self.plan.discretisation.jump_tolerance)
        milestones, end = self.plan.milestones, self.plan.cycles

        def cycle(start: ContactState, before: float, cycles: float) -> ContactState:
            current = self._aged(problem, start, before + 0.5 * cycles)
            after, trace = run_cycle(
                current, start, self.plan.amplitude_mm, self.wear_increments, cycles, self._watch(done), self.guide
            )
            self.guide = trace.guide
            self.log.counters.simulated_cycles += 1
            return after

        def difference(whole: ContactState, halves: ContactState) -> float:
            return wear_difference(problem, whole, halves)

        def combined(whole: ContactState, halves: ContactState) -> ContactState:
            return extrapolated(problem, whole, halves)

        while done < end:
            problem, state = self._on_due_meshes(problem, state, done)
            ahead = min(m for m in milestones if m > done)
            try:
                if problem.wear.none:
                    size = ahead - done
                elif self.explicit_jump is not None:
                    size = min(self.explicit_jump, ahead - done)
                    state = cycle(state, done, size)
                else:
                    step = take_step(controller, state, jump, done, milestones, end, cycle, difference, combined)
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
                problem, state = self._at_milestone(problem, state, done, size)
                self._write("running", f"{done:,.0f} of {end:,.0f} cycles simulated")
            write_checkpoint(
                self.folder.path,
                Checkpoint(
                    done, jump, state, self.guide, self.log.for_checkpoint(), self.history, self.folder.identity
                ),
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

    def _at_milestone(
        self, problem: ContactProblem, state: ContactState, done: float, jump: float
    ) -> tuple[ContactProblem, ContactState]:
        """The state after the loop has been measured, on larger meshes where it leaves those of now."""
        while True:
            try:
                return problem, self._measure(problem, state, done, jump)
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
        self.log.counters.count(report)
        state, trace = settled(after, state, self.plan.amplitude_mm, self.wear_increments, self._watch(done))
        self.guide = trace.guide
        return fresh, state

    def _aged(self, problem: ContactProblem, state: ContactState, cycles: float) -> ContactProblem:
        """The problem as it is at that cycle and after the energy accumulated so far."""
        return problem_at(problem, self.study, Age(cycles, 1e-3 * state.wear.energy_mJ))

    def _measure(self, problem: ContactProblem, state: ContactState, done: float, jump: float) -> ContactState:
        """Close a loop with the wear frozen, and log it."""
        problem = self._aged(problem, state, done)
        state, trace = closed_cycle(
            problem,
            state,
            self.plan.amplitude_mm,
            self.increments,
            self._watch(done),
            self.guide,
            self.wear_increments,
        )
        self.guide = trace.guide
        self.log.measured(problem, state, trace, done, jump)
        return state

    def _watch(self, done: float) -> Callable[[ContactState, IncrementReport], None]:
        def watch(state: ContactState, report: IncrementReport) -> None:
            self.log.counters.count(report)
            end = self.plan.cycles
            deepest = max(float(state.wear.primary_depth.max()), float(state.wear.secondary_depth.max()))
            # Jumps grow with the cycles done, so the logarithm of the cycles is what passes evenly.
            fraction = float(np.log(max(done, 1.0)) / np.log(max(end, 1.0 + 1e-9)))
            self.observer.moved(
                Moment(
                    done,
                    int(end),
                    1e-3 * state.wear.energy_mJ,
                    1e3 * deepest,
                    min(fraction, 1.0),
                    self.log.cycling_s,
                )
            )

        return watch

    def _write(self, status: str, message: str) -> None:
        result = self.log.result(status, message, self.history)
        self.folder.write(result)
        self.observer.logged(result)
