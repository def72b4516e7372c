"""Fretting cycles of a contact during a test: pressed, moved, worn and measured, with effects that depend on its age.

A cycle jump is one simulated cycle whose wear counts for several. A drive holds its amplitude or another figure of the
loop (`HeldFigure`). The age of a test is its cycles and friction energy. A guide holds first guesses for the next
cycle.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import solvers
from wirewear.effects import Age
from wirewear.simulation.control import AmplitudeSearch, amplitude_from, elastic_amplitude_from
from wirewear.simulation.measures import Probe
from wirewear.simulation.plan import Motion
from wirewear.simulation.statistics import Tally

#: Called at every increment: the state after it, and the cycles done before the jump that it belongs to.
Watch = Callable[[solvers.ContactState, float], None]

_Cycle = tuple[solvers.ContactState, solvers.CycleTrace]
#: A loop with its problem and motion, and the states before and after it.
_Loop = tuple[solvers.ContactProblem, Motion, tuple[solvers.ContactState, ...], solvers.CycleTrace]

Reported = Callable[[solvers.ContactState, solvers.IncrementReport], None]  #: Called after every increment.


@dataclass(frozen=True)
class Traced:
    """A cycle traced without wear, and the problem (without effects of age) and state that it was traced for.

    start: the state from which it closes, after cycles that were repeated from `state` until one does; if the drive
    holds a figure of the loop, as slip or energy, at the amplitude that meets it.
    """

    problem: solvers.ContactProblem
    state: solvers.ContactState
    symmetry: solvers.Symmetry
    start: solvers.ContactState
    trace: solvers.CycleTrace
    reports: list[solvers.IncrementReport]  #: Reports of all increments that it took.

    @property
    def work_mJ(self) -> float:
        return self.symmetry.strokes * self.trace.friction_work


class Cycler:
    """Moves a contact through cycles under one motion, and counts increments.

    Problems are passed without the effects of the test's age, which are added here. guide: first guesses for the next
    cycle. now: cycles done before the current jump. friction_work_mJ: of the cycle after the latest jump. sticks: True
    if the middle stuck throughout the latest cycle; None before the first under the current motion.
    """

    def __init__(self, motion: Motion, tally: Tally, watch: Watch) -> None:
        """A cycler before the first cycle, without a guide. watch: called at every increment."""
        self._latest: Traced | None = None
        self._quarter: solvers.CycleTrace | None = None
        self._loop: _Loop | None = None
        self.motion, self.tally, self._notify = motion, tally, watch
        self.guide: solvers.Guide | None = None
        self.now = 1.0
        self.friction_work_mJ = 0.0
        self.sticks: bool | None = None

    def entered(
        self, problem: solvers.ContactProblem, state: solvers.ContactState, motion: Motion, done: float
    ) -> tuple[solvers.ContactProblem, solvers.ContactState]:
        """(problem, state) under another motion after `done` cycles, at the same end of the new stroke."""
        self.motion, self.guide, self.sticks = motion, None, None
        problem = motion.under(problem)
        drive = motion.drive if motion.held is None else replace(motion.drive, amplitude_mm=motion.held.first_mm)
        return problem, self._turned(self.aged(problem, state, done), state, drive, self._watch)

    def _turned(
        self, current: solvers.ContactProblem, state: solvers.ContactState, drive: solvers.Drive, watch: Reported
    ) -> solvers.ContactState:
        """The state moved to the same end of another drive's stroke. A contact that slid keeps, on a soft rig, the
        force that it slid with: if what the drive holds needs a shorter stroke, the bodies are pressed again instead.
        """
        if self.motion.held is not None and drive.amplitude_mm < abs(state.drive):
            return solvers.restarted(current, state, drive, self.motion.wear_increments, watch)
        end = drive.end(1.0 if state.drive > 0.0 else -1.0)
        place, load = float(end.drive[-1]), float(end.load[-1])
        state, reports = solvers.advance(current, state, place, 0.0, load_share=load, bulk=end.bulk[-1])
        for report in reports:
            watch(state, report)
        return state

    def _drive(self, state: solvers.ContactState) -> solvers.Drive:
        """The motion's drive; if it holds a figure, with the amplitude at which the state is."""
        motion = self.motion
        if motion.held is None:
            return motion.drive
        return replace(motion.drive, amplitude_mm=abs(state.drive) or motion.held.first_mm)

    def _holding(
        self,
        current: solvers.ContactProblem,
        begin: solvers.ContactState,
        drive: solvers.Drive,
        cycle: Callable[[solvers.ContactState, solvers.Drive, solvers.Guide | None], _Cycle],
        watch: Reported,
        probe: Probe | None = None,
    ) -> tuple[solvers.ContactState, solvers.CycleTrace, solvers.Guide | None]:
        """A cycle from a state, with the amplitude at which the drive holds its figure, and the guide that it was
        simulated with.

        cycle: simulates one from a state, a drive and a guide. Without a held figure the drive is used as it is.
        """
        guide = self.guide
        search = None if self.motion.held is None else AmplitudeSearch(self.motion.held)
        while True:
            state, trace = cycle(begin, drive, guide)
            if search is None:
                return state, trace, guide
            # With a core the amplitude may have been met on the way from mid-stroke.
            drive = replace(drive, amplitude_mm=abs(trace.start.drive))
            wanted = search.following(drive.amplitude_mm, trace, probe)
            if wanted is None:
                return state, trace, guide
            drive = replace(drive, amplitude_mm=wanted)
            begin, guide = self._turned(current, state, drive, watch), trace.guide

    def aged(
        self, problem: solvers.ContactProblem, state: solvers.ContactState, cycles: float
    ) -> solvers.ContactProblem:
        """The problem with its effects after `cycles` cycles and the friction energy of the state."""
        return self.motion.aged(problem, Age(cycles, 1e-3 * state.wear.energy_mJ))

    def pressed(self, problem: solvers.ContactProblem) -> tuple[solvers.ContactState, solvers.IncrementReport]:
        """(state, report) of fresh bodies pressed together under the normal load at mid-stroke."""
        state = replace(self.motion.fresh(problem), bulk=self.motion.drive.mean_bulk)
        state, report = solvers.press(self.aged(problem, state, 0.0), state)
        self.tally.counters.count(report)
        return state, report

    def printed(self, problem: solvers.ContactProblem, state: solvers.ContactState) -> solvers.ContactState:
        """The state of pressed bodies, pressed again with the prints that sliding leaves; unchanged without any."""
        if (wear := self.motion.slid(problem, state.wear)) is None:
            return state
        again = replace(solvers.unloaded_state(problem), wear=wear, bulk=state.bulk)
        pressed, report = solvers.press(self.aged(problem, state, 0.0), again)
        self.tally.counters.count(report)
        return replace(pressed, pressed_z=state.pressed_z)

    def moved_out(self, problem: solvers.ContactProblem, state: solvers.ContactState) -> solvers.ContactState:
        """The state moved from mid-stroke to the stroke's end at +x, without wear. If the drive holds a figure that a
        state shows, the amplitude is where it meets its target; under a load that changes, where it would without
        slip, from which cycles find it.
        """
        fresh, motion = self.aged(problem, state, 0.0), self.motion
        drive = self._drive(state)
        if motion.held is not None and motion.held.of_state is not None:
            find = amplitude_from if drive.steady else elastic_amplitude_from
            amplitude = find(
                motion.held, motion.held.of_state, lambda place: solvers.advance(fresh, state, place, 0.0)[0]
            )
            drive = replace(drive, amplitude_mm=amplitude)
        end, self._quarter = solvers.traced_quarter(fresh, state, drive, motion.increments, self._watch)
        return end

    def worn(
        self, problem: solvers.ContactProblem, state: solvers.ContactState, before: float, cycles: float
    ) -> solvers.ContactState:
        """The state after one simulated cycle whose wear counts `cycles` times; `before` cycles are done before it.
        Effects are those at the middle of these cycles.
        """
        current, motion = self.aged(problem, state, before + 0.5 * cycles), self.motion
        increments = motion.drive.followed_by(motion.wear_increments)
        state, trace = solvers.run_cycle(current, state, motion.drive, increments, cycles, self._watch, self.guide)
        self._took(trace)
        return state

    def traced(self, problem: solvers.ContactProblem, state: solvers.ContactState, done: float) -> Traced:
        """A cycle without wear after `done` cycles, from before if it was the latest; its increments are not counted
        yet.
        """
        if self._latest is not None and self.goes_on_from(problem, state):
            return self._latest
        current, motion = self.aged(problem, state, done), self.motion
        symmetry = solvers.symmetry_of(current).under(motion.drive)
        begins = solvers.mirrored_prints(state, symmetry)
        symmetry = solvers.kept_by(symmetry, begins)
        reports = list[solvers.IncrementReport]()

        def watch(passed: solvers.ContactState, report: solvers.IncrementReport) -> None:
            reports.append(report)
            self._notify(passed, self.now)

        def forced(begins: solvers.ContactState, place: float) -> solvers.ContactState:
            after, taken = solvers.advance(current, begins, place, 0.0)
            reports.extend(taken)
            return after

        def cycle(begin: solvers.ContactState, drive: solvers.Drive, guide: solvers.Guide | None) -> _Cycle:
            how = (current, begin, drive, motion.wear_increments, symmetry, watch, guide)
            return solvers.closed_trace(*how, None if motion.held is None else motion.held.lacking)

        probe = forced if motion.drive.steady else None
        start, trace, _ = self._holding(current, begins, self._drive(state), cycle, watch, probe)
        self.sticks = solvers.sticks_throughout(trace.start, trace.states[-1])
        self._latest = Traced(problem, state, symmetry, start, trace, reports)
        return self._latest

    def count(self, traced: Traced) -> None:
        """Add a traced cycle and its increments to the counters."""
        self.tally.counters.simulated_cycles += 1
        for report in traced.reports:
            self.tally.counters.count(report)

    def closed_loop(
        self, problem: solvers.ContactProblem, state: solvers.ContactState, done: float
    ) -> tuple[solvers.ContactState, solvers.CycleTrace]:
        """(state, trace) of a closed loop without wear after `done` cycles, taken from before if nothing changed."""
        current, motion = self.aged(problem, state, done), self.motion
        if self._loop is not None and problem.unchanging and state.core.any():
            known, of, ends, loop = self._loop
            if known is current and of is motion and any(end is state for end in ends):
                return ends[1], loop
        # Where the contact wears, the next jump starts from the cycle that leads to the loop.
        moved, quarter = None, self._quarter
        if not problem.unchanging:
            moved = self.traced(problem, state, done).trace
        elif quarter is not None and quarter.states[-1] is state and state.core.any():
            # Where the contact sticks in its middle, the way from mid-stroke is half of a stroke's.
            moved = quarter
        elif motion.held is not None:
            moved = self.traced(problem, state, done).trace
        steady = motion.drive.steady
        increments = motion.drive.followed_by(motion.increments) if motion.follows_force else motion.increments

        def cycle(begin: solvers.ContactState, drive: solvers.Drive, guide: solvers.Guide | None) -> _Cycle:
            how = (current, begin, drive, increments, self._watch, guide, motion.wear_increments)
            # Shorter steps than a cosine's would follow how bodies stick and slip where friction falls with the speed.
            if motion.follows_force and steady and not problem.friction_law.timed:
                after, trace = solvers.closed_adaptive_cycle(*how, moved=moved if begin is state else None)
            else:
                after, trace = solvers.closed_cycle(*how)
            self._took(trace)
            return after, trace

        drive = self._drive(state if moved is None else moved.states[-1])
        after, trace, guide = self._holding(current, state, drive, cycle, self._watch)
        if self.goes_on_from(problem, state):
            self.guide = guide
        self._loop = current, motion, (state, after), trace
        return after, trace

    def goes_on_from(self, problem: solvers.ContactProblem, state: solvers.ContactState) -> bool:
        """True if the cycle from which the next jump starts has already been traced from this state of this problem."""
        known = self._latest
        return known is not None and known.state is state and known.problem is problem

    def remeshed(
        self, problem: solvers.ContactProblem, state: solvers.ContactState, onto: solvers.ContactProblem, done: float
    ) -> solvers.ContactState:
        """The state on the meshes of the problem `onto`, after half a cycle without wear to settle there."""
        before, after = (self.aged(either, state, done) for either in (problem, onto))
        state, report = solvers.remeshed(before, state, after)
        self.tally.counters.count(report)
        state, trace = solvers.settled(after, state, self._drive(state), self.motion.wear_increments, self._watch)
        self.guide = trace.guide
        return state

    def pressed_again(
        self, problem: solvers.ContactProblem, state: solvers.ContactState, onto: solvers.ContactProblem, done: float
    ) -> solvers.ContactState:
        """The state of the worn bodies on the meshes of the problem `onto`, pressed together at mid-stroke and moved to
        the stroke's end. For contacts with a core, whose state depends on where it was pressed.
        """
        patches = [(each.primary.patch, each.secondary.patch) for each in (problem, onto)]
        wear, bulk = solvers.transferred_wear(state.wear, *patches), self.motion.drive.mean_bulk
        current = self.aged(onto, state, done)
        pressed, report = solvers.press(current, replace(solvers.unloaded_state(onto), wear=wear, bulk=bulk))
        self.tally.counters.count(report)
        return self.moved_out(onto, replace(pressed, pressed_z=state.pressed_z))

    def _took(self, trace: solvers.CycleTrace) -> None:
        self.guide, self.friction_work_mJ = trace.guide, trace.friction_work
        self.sticks = solvers.sticks_throughout(trace.start, trace.states[-1])
        self.tally.counters.simulated_cycles += 1

    def _watch(self, state: solvers.ContactState, report: solvers.IncrementReport) -> None:
        self.tally.counters.count(report)
        self._notify(state, self.now)
