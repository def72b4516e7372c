"""One run from its first cycle to its last: cycle jumps, loops at the milestones, meshes that follow the scar.

It is the same for all kinds of contact. A `FrettingTest` is the test, a `Recorded` what is recorded of it, a `RunStore`
where that is kept, and `WearJumps` take the jumps. Milestones are the cycles at which a loop is measured; a stop
is a value of a figure, such as the depth, that ends the test. FIGURES take these from a state, by the stops' keys.
"""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import log

from threadpoolctl import threadpool_limits

from solvers import ContactProblem, ContactState, JumpStep, PatchLeftError, SolverError
from wirewear.base.words import counted
from wirewear.results import RunResult
from wirewear.simulation.cycler import Cycler
from wirewear.simulation.meshes import MeshHistory
from wirewear.simulation.observers import Observer, moment_of
from wirewear.simulation.plan import FrettingTest, Motion
from wirewear.simulation.recorded import Recorded
from wirewear.simulation.store import Checkpoint, RunStore
from wirewear.simulation.wear_jumps import WearJumps, wear_jumps
from wirewear.test.conditions import Stop

FIGURES: Mapping[str, Callable[[ContactState], float]] = {
    "depth_um": lambda state: 1e3 * max(float(depth.max()) for depth in state.wear.depths),
    "worn_volume_mm3": lambda state: state.wear.primary_volume_mm3 + state.wear.secondary_volume_mm3,
    "accumulated_energy_J": lambda state: 1e-3 * state.wear.energy_mJ,
    "tangential_force_N": lambda state: abs(float(state.primary_force[:, 0].sum())),
    "clearance_um": lambda state: 1e3 * (state.pressed_z - state.holder_z),
}


@dataclass
class Ending:
    """The stops of a test by key, and its figures so far by key, as (cycles, figure)."""

    stops: Mapping[str, float]
    figures_so_far: dict[str, list[tuple[float, float]]] = field(default_factory=dict)

    @classmethod
    def of(cls, stated: Stop | None) -> "Ending":
        """The stops that a study states, none for None, without figures so far."""
        given = {} if stated is None else {key: getattr(stated, key) for key in FIGURES}
        return cls({key: float(target) for key, target in given.items() if target is not None})

    def reached(self, state: ContactState) -> str | None:
        """Key of the stop that a state has reached, by the largest ratio if there are several; None if it has none."""
        shares = {key: FIGURES[key](state) / target for key, target in self.stops.items()}
        passed = {key: share for key, share in shares.items() if share >= 1.0}
        return max(passed, key=lambda key: passed[key], default=None)

    def shorter(self, before: ContactState, after: ContactState, jump: float) -> float | None:
        """The whole number of cycles in which a jump of `jump` cycles from `before` to `after` should be taken, to end
        at its stop; None if it reaches none, or exceeds it by 0.1 % at most.
        """
        key = self.reached(after)
        if key is None:
            return None
        start, end, target = FIGURES[key](before), FIGURES[key](after), self.stops[key]
        size = float(max(round(jump * (target - start) / (end - start)), 1)) if end > start else jump
        # A stop is met within this share, or within a cycle.
        return size if end > (1.0 + 1e-3) * target and size < jump else None

    def follow(self, state: ContactState, done: float) -> None:
        """Add the figures of the state after `done` cycles."""
        for key in self.stops:
            self.figures_so_far.setdefault(key, []).append((done, FIGURES[key](state)))

    def expected_end(self) -> str:
        """The end of a sentence on when the first stop will be reached; empty if that cannot be predicted."""
        found = {key: ends for key in self.stops if (ends := self._ends(key)) is not None}
        if not found:
            return ""
        key = min(found, key=lambda one: found[one][0])
        best, low, high = (counted(round(end)) for end in found[key])
        return f"; {key} = {self.stops[key]:g} is expected after {best} cycles ({low} to {high})"

    def _ends(self, key: str) -> tuple[float, float, float] | None:
        """Cycles at which a figure is expected to meet its stop, and both ends of an interval; None if not predictable.

        The figure is taken to grow with a power of the cycles: the latest exponent gives the best estimate, an earlier
        one and one that has changed further give the interval.
        """
        known = [(done, figure) for done, figure in self.figures_so_far.get(key, ()) if done >= 1.0 and figure > 0.0]
        if not known:
            return None
        done, figure = known[-1]
        # The latest exponent is that since half as many cycles.
        earlier = [next((at for at in reversed(known) if at[0] <= done / 2.0**k), None) for k in (1, 2)]
        if earlier[0] is None or earlier[1] is None:
            return None
        late, early = _slope(earlier[0], known[-1]), _slope(earlier[1], earlier[0])
        # Of the change of the power so far: what it may change by on the way.
        slopes = [late, early, late + 2.0 * (late - early)]
        # Of logarithms: a figure that grows more slowly has no end to predict.
        if min(slopes) < 0.02:
            return None
        best, *others = (done * (self.stops[key] / figure) ** (1.0 / slope) for slope in slopes)
        return best, min(best, *others), max(best, *others)


def _slope(before: tuple[float, float], after: tuple[float, float]) -> float:
    return log(after[1] / before[1]) / log(after[0] / before[0])


def cycle_through(
    test: FrettingTest, record: Recorded, store: RunStore, observer: Observer, *, resume: bool = False
) -> RunResult:
    """Simulate a test and return its result; with `resume` from its last checkpoint, if it has one.

    record: an empty record of its kind. store: where result and checkpoint are kept. observer: hears of the progress.
    Raises RunError if the store holds another run's checkpoint, ResultError if the checkpoint is damaged, and
    SolverError if the contact did not converge, or left the fine patch; everything up to there is stored.
    """
    return _Run(test, record, store, observer).go(resume=resume)


class _OtherMeshesError(Exception):
    """The contact has started to stick in its middle, or to slide as a whole, and needs the meshes for that."""

    def __init__(self, history: MeshHistory) -> None:
        super().__init__()
        self.history = history


class _Run:
    """A run in progress. Everything that is recorded is stored before the next cycle jump begins."""

    def __init__(self, test: FrettingTest, record: Recorded, store: RunStore, observer: Observer) -> None:
        self.test, self.record, self.store, self.observer = test, record, store, observer
        self.meshes, self.history = test.meshes, test.meshes.first()
        self.cycler = Cycler(test.motion_after(0.0), record.tally, self._moved)
        self.ending = Ending.of(test.stop)
        self._fitted = -1.0  # The cycle at which meshes have followed the regime.

    def go(self, *, resume: bool) -> RunResult:
        checkpoint = self._restored() if resume else None
        started = time.perf_counter()
        if checkpoint is not None:
            # Where a block ends there, the state is still that of its last cycle.
            self.cycler.motion = self.test.motion_at(checkpoint.done)
        problem = self._problem()
        self.record.tally.preparation_s = time.perf_counter() - started
        self.record.tally.start_cycling()
        try:
            # Thousands of small dense problems: sharing each between cores costs more than it gains.
            with threadpool_limits(limits=1, user_api="blas"):
                if checkpoint is None:
                    problem, state = self._started(problem)
                    message = self._cycle_on(problem, state, 1.0, None)
                else:
                    message = self._cycle_on(problem, checkpoint.state, checkpoint.done, checkpoint.next_jump)
        except SolverError as error:
            self._store("failed", str(error))
            raise
        result = self._store("complete", message)
        self.store.drop_checkpoint()
        return result

    def _restored(self) -> Checkpoint | None:
        """The last checkpoint, with record, meshes and counters restored as they were then; None if there is none."""
        interrupted = self.store.interrupted()
        if interrupted is None:
            return None
        checkpoint, before = interrupted
        self.record.restore(before, checkpoint.done)
        self.record.tally.restore(checkpoint.counters)
        self.history, self.cycler.guide = checkpoint.meshes, checkpoint.guide
        return checkpoint

    def _started(self, problem: ContactProblem) -> tuple[ContactProblem, ContactState]:
        """The problem and the state after the first cycle, with its wear, on the first meshes that hold the contact.

        Soft layers between the bodies let them touch far beyond the contact for which the first meshes are made.
        """
        self.store.begin()
        while True:
            try:
                state, report = self.cycler.pressed(problem)
                self.record.record_pressed(problem, state, report)
                state, done = self.cycler.moved_out(problem, self.cycler.printed(problem, state)), 0.0
                # The meshes must fit what sticks of the contact at the end of its first loading.
                fitted = self.meshes.fitted(self.history, problem, state)
                if fitted is not None:
                    raise _OtherMeshesError(fitted)
                jumps = wear_jumps(self.test, self.cycler, problem)
                while done < 1.0:
                    step = jumps.step(problem, state, done, 1.0, (1.0,), 1.0)
                    state, done = step.state, done + step.jump
                return problem, self._measure_loop(problem, state, 1.0, 1.0)
            except _OtherMeshesError as other:
                fitting = other.history
            except PatchLeftError:
                larger = self.meshes.next_stage(self.history, 0.0)
                if larger is None:
                    raise
                fitting = larger
            # Nothing of the run has been on the other meshes: that is no change.
            self.history = MeshHistory(fitting.stage, core=fitting.core)
            problem, self.cycler.guide = self._problem(), None

    def _problem(self) -> ContactProblem:
        """The contact problem on the current meshes and under the current motion."""
        return self.cycler.motion.under(self.meshes.problem(self.history, self.observer.stage))

    def _cycle_on(self, problem: ContactProblem, state: ContactState, done: float, jump: float | None) -> str:
        """Simulate up to the test's end or a stop; return a sentence on how it ended."""
        jumps = wear_jumps(self.test, self.cycler, problem)
        wanted = jumps.first_jump if jump is None else jump
        end = self.test.cycles
        if jump is None and done < end:
            # From now on the run can be resumed.
            self._store("running", f"{counted(done)} of {counted(end)} cycles simulated")
            self._keep(done, wanted, state)
        while done < end and self.ending.reached(state) is None:
            self.cycler.now = done
            motion = self.test.motion_after(done)
            if motion is not self.cycler.motion:
                problem, state = self._entered(motion, problem, state, done)
                jumps = wear_jumps(self.test, self.cycler, problem)
            problem, state = self._on_due_meshes(problem, state, done)
            try:
                step = self._stepped(jumps, problem, state, done, wanted)
            except PatchLeftError:
                # The scar has become larger than its volume let expect.
                larger = self.meshes.next_stage(self.history, done)
                if larger is None:
                    raise
                problem, state = self._on_meshes(larger, problem, state, done)
                continue
            state, wanted = step.state, step.next_jump
            problem = self.meshes.coats_worn(problem, state)
            ahead = min(milestone for milestone in self.test.stops if milestone > done)
            # A jump that ends within this share of a milestone has met it.
            reached = abs(ahead - done - step.jump) < 1e-6 * ahead
            done = ahead if reached else done + step.jump
            self.ending.follow(state, done)
            self.record.ends = self.ending.reached(state) is not None
            # A part of a cycle is less than what a stop is met within.
            done = float(round(done)) if self.record.ends else done
            if (
                self.record.ends
                or done in self.test.milestones
                or not self.record.follows(problem, state, done, self.cycler.friction_work_mJ)
            ):
                # On the meshes on which the surfaces have worn: they fit each other worse on the next ones.
                self.cycler.now = done
                problem, state = self._at_milestone(problem, state, done, step.jump)
                expected = "" if self.record.ends else self.ending.expected_end()
                self._store("running", f"{counted(done)} of {counted(end)} cycles simulated{expected}")
            elif (fitting := self._fitting(state, done)) is not None:
                problem, state = self._on_meshes(fitting, problem, state, done)
            self._keep(done, wanted, state)
        stop = self.ending.reached(state)
        why = self.ending.expected_end() if stop is None else f": {stop} has reached its stop"
        return f"{counted(done)} cycles simulated{why}"

    def _stepped(
        self, jumps: WearJumps, problem: ContactProblem, state: ContactState, done: float, wanted: float
    ) -> JumpStep[ContactState]:
        """A jump that does not go beyond the test's stop."""
        step = jumps.step(problem, state, done, wanted, self.test.stops, self.test.cycles)
        while (size := self.ending.shorter(state, step.state, step.jump)) is not None:
            step = jumps.step(problem, state, done, size, (done + size,), self.test.cycles)
        return step

    def _on_due_meshes(
        self, problem: ContactProblem, state: ContactState, done: float
    ) -> tuple[ContactProblem, ContactState]:
        """Problem and state on larger meshes if the scar has outgrown the present ones, and with nodes moved
        where due.
        """
        while (larger := self.meshes.outgrown(self.history, state, done)) is not None:
            problem, state = self._on_meshes(larger, problem, state, done)
        self.history, problem = self.meshes.moved_nodes(self.history, problem, state, done, self.observer.stage)
        return self.meshes.coats_worn(problem, state), state

    def _at_milestone(
        self, problem: ContactProblem, state: ContactState, done: float, jump: float
    ) -> tuple[ContactProblem, ContactState]:
        """Problem and state after measuring the loop, on larger or other meshes if the loop needs them."""
        while True:
            try:
                return problem, self._measure_loop(problem, state, done, jump)
            except _OtherMeshesError as other:
                problem, state = self._on_meshes(other.history, problem, state, done)
            except PatchLeftError:
                larger = self.meshes.next_stage(self.history, done)
                if larger is None:
                    raise
                problem, state = self._on_meshes(larger, problem, state, done)

    def _entered(
        self, motion: Motion, problem: ContactProblem, state: ContactState, done: float
    ) -> tuple[ContactProblem, ContactState]:
        """Problem and state under another motion, on larger meshes if its stroke needs them."""
        try:
            return self.cycler.entered(problem, state, motion, done)
        except PatchLeftError:
            larger = self.meshes.next_stage(self.history, done)
            if larger is None:
                raise
            return self._on_meshes(larger, problem, state, done)

    def _fitting(self, state: ContactState, done: float) -> MeshHistory | None:
        """The meshes for the latest cycle, sticking or sliding; None if the contact has them. Sought once per number of
        cycles.
        """
        if self.cycler.sticks is None or self._fitted == done:
            return None
        since = max((end for end, _ in self.test.motions if end < done), default=0.0)
        fitting = self.meshes.fitting(self.history, state, (since, done), self.cycler.sticks)
        self._fitted = self._fitted if fitting is None else done
        return fitting

    def _on_meshes(
        self, history: MeshHistory, problem: ContactProblem, state: ContactState, done: float
    ) -> tuple[ContactProblem, ContactState]:
        self.history = history
        onto = self._problem()
        onto = self.meshes.coats_worn(onto, state, problem)
        if history.stage < 0:
            return onto, self.cycler.pressed_again(problem, state, onto, done)
        return onto, self.cycler.remeshed(problem, state, onto, done)

    def _measure_loop(self, problem: ContactProblem, state: ContactState, done: float, jump: float) -> ContactState:
        """Close a loop without wear and record it; return the state from which the run goes on."""
        after, trace = self.cycler.closed_loop(problem, state, done)
        fitting = self._fitting(after, done)
        if fitting is not None:
            raise _OtherMeshesError(fitting)
        held = self.cycler.motion.held
        self.record.record_loop(self.cycler.aged(problem, after, done), after, trace, done, jump, held)
        return state if self.cycler.goes_on_from(problem, state) else after

    def _moved(self, state: ContactState, done: float) -> None:
        self.observer.moved(moment_of(state, done, self.test.cycles, self.record.tally.cycling_s))

    def _keep(self, done: float, jump: float, state: ContactState) -> None:
        counters, identity = self.record.tally.for_checkpoint(), str(self.store.identity)
        self.store.write_checkpoint(Checkpoint(done, jump, state, self.cycler.guide, counters, self.history, identity))

    def _store(self, status: str, message: str) -> RunResult:
        result = self.store.write(self.record.result(status, message, self.history))
        self.observer.logged(result)
        return result
