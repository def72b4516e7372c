"""Cycle jumps without any finite elements: of a scripted contact that wears by its cycles."""

from dataclasses import dataclass, field, replace
from typing import Any, cast

import pytest

import solvers
from solvers import (
    ContactProblem,
    ContactState,
    CycleTrace,
    IncrementReport,
    JumpStep,
    NotConvergedError,
    PatchLeftError,
)
from wirewear.base.cache import Identity
from wirewear.effects import Age
from wirewear.simulation import Observer
from wirewear.simulation.cycling import cycle_through
from wirewear.simulation.meshes import Meshes, MeshHistory
from wirewear.simulation.plan import FrettingTest, Motion
from wirewear.simulation.statistics import Tally
from wirewear.simulation.store import Checkpoint


@dataclass(frozen=True)
class Result:
    status: str
    message: str
    measured: tuple[tuple[float, int], ...]
    settings: dict[str, Any] = field(default_factory=dict)


class Record:
    """Cycles at which a loop was closed, each with the stage of the meshes; `bends_at` are those asked for besides."""

    def __init__(self, bends_at: tuple[float, ...] = ()) -> None:
        self.tally = Tally()
        self.bends_at = bends_at
        self.rows: list[tuple[float, int]] = []

    def restore(self, before: Result, done: float) -> None:
        self.rows = [row for row in before.measured if row[0] <= done]

    def record_pressed(self, _problem: ContactProblem, _state: ContactState, _report: IncrementReport) -> None:
        pass

    def record_loop(
        self, problem: ContactProblem, _state: ContactState, _trace: CycleTrace, done: float, *_: object
    ) -> None:
        self.rows.append((done, stage_of(problem)))

    def follows(self, _problem: ContactProblem, _state: ContactState, done: float, _work_mJ: float) -> bool:
        return done not in self.bends_at

    def result(self, status: str, message: str, _history: MeshHistory) -> Result:
        return Result(status, message, tuple(self.rows))


@dataclass
class Store:
    identity: Identity = field(default_factory=lambda: Identity("scripted", "here"))
    results: list[Result] = field(default_factory=list)
    checkpoint: Checkpoint | None = None
    checkpoints_written: list[float] = field(default_factory=list)

    def interrupted(self) -> tuple[Checkpoint, Result] | None:
        return None if self.checkpoint is None else (self.checkpoint, self.results[-1])

    def write(self, result: Result) -> Result:
        self.results.append(result)
        return result

    def write_checkpoint(self, checkpoint: Checkpoint) -> None:
        self.checkpoint = checkpoint
        self.checkpoints_written.append(checkpoint.done)

    def begin(self) -> None:
        self.checkpoint = None

    def drop_checkpoint(self) -> None:
        self.checkpoint = None


@dataclass(frozen=True)
class Stages(Meshes):
    """Meshes for a scar that has worn by up to `limits` cycles."""

    limits: tuple[float, ...]

    def problem(self, history: MeshHistory, _report: object) -> Any:
        return history.stage

    def next_stage(self, history: MeshHistory, _cycle: float) -> MeshHistory | None:
        return replace(history, stage=history.stage + 1) if history.stage + 1 < len(self.limits) else None

    def outgrown(self, history: MeshHistory, state: Any, cycle: float) -> MeshHistory | None:
        return self.next_stage(history, cycle) if state >= self.limits[history.stage] else None


def stage_of(problem: Any) -> int:
    return int(problem)


#: Cycles after which motions were entered, with their amplitudes.
ENTERED: list[tuple[float, float]] = []


class Unchanging(Motion):
    """A block whose problem is the one on the meshes, at any age."""

    def aged(self, problem: ContactProblem, _age: Age) -> ContactProblem:
        return problem

    def under(self, problem: ContactProblem) -> ContactProblem:
        return problem


class ScriptedCycler:
    """The state is the number of cycles worn, the problem the stage of its meshes."""

    guide = None
    friction_work_mJ = 1.0
    sticks = None

    def __init__(self, motion: Motion, *_: object) -> None:
        self.motion, self.now = motion, 1.0

    def entered(self, problem: Any, state: float, motion: Motion, done: float) -> tuple[Any, float]:
        self.motion = motion
        ENTERED.append((done, motion.drive.amplitude_mm))
        return problem, state

    def aged(self, problem: Any, *_: object) -> Any:
        return problem

    def pressed(self, _problem: Any) -> tuple[float, None]:
        return 0.0, None

    def printed(self, _problem: Any, state: float) -> float:
        return state

    def moved_out(self, _problem: Any, state: float) -> float:
        return state

    def closed_loop(self, _problem: Any, state: float, _done: float) -> tuple[float, None]:
        return state, None

    def goes_on_from(self, *_: object) -> bool:
        return False

    def remeshed(self, _problem: Any, state: float, _onto: Any, _done: float) -> float:
        return state


@dataclass
class Stepper:
    """Jumps of at most `size` cycles that leave the patch of a stage beyond a number of cycles worn."""

    size: float = 40.0
    reach: tuple[float, ...] = (1e9, 1e9)
    stop_after: float = 1e9
    first_jump: float = 10.0
    failure: Exception | None = None

    def step(self, problem: Any, state: Any, done: float, wanted: float, milestones: Any, _end: float) -> JumpStep[Any]:
        if done >= self.stop_after:
            raise self.failure or KeyboardInterrupt
        jump = min(wanted, self.size, min(m for m in milestones if m > done) - done)
        if state + jump > self.reach[stage_of(problem)]:
            raise PatchLeftError("left")
        return JumpStep(state + jump, jump, 0.0, 2.0 * wanted)


MILESTONES = (1.0, 30.0, 100.0, 300.0)


def run(
    monkeypatch: pytest.MonkeyPatch,
    stepper: Stepper,
    store: Store,
    limits: tuple[float, ...] = (1e9,),
    *,
    resume: bool = False,
    record: Record | None = None,
    blocks: tuple[tuple[float, float], ...] = ((300.0, 1.0),),
) -> Result:
    monkeypatch.setattr("wirewear.simulation.cycling.Cycler", ScriptedCycler)
    monkeypatch.setattr("wirewear.simulation.cycling.wear_jumps", lambda *_: stepper)
    ENTERED.clear()
    motions = tuple((end, Unchanging(solvers.Drive(own), 16, 16, follows_force=False)) for end, own in blocks)
    test = FrettingTest(motions, Stages(limits), MILESTONES, 0.1)
    recorded: Any = record or Record()
    kept: Any = store
    result: Any = cycle_through(test, recorded, kept, Observer(), resume=resume)
    return cast(Result, result)


def test_the_loop_is_measured_at_every_milestone_and_nowhere_else(monkeypatch: pytest.MonkeyPatch) -> None:
    store = Store()
    result = run(monkeypatch, Stepper(), store)
    assert result.status == "complete"
    assert [cycle for cycle, _ in result.measured] == list(MILESTONES)
    assert store.checkpoint is None
    # One after every jump, each of which is as long as the step before wanted.
    assert store.checkpoints_written == [1.0, 11.0, 30.0, 70.0, 100.0, 140.0, 180.0, 220.0, 260.0, 300.0]
    assert [r.status for r in store.results] == ["running"] * 4 + ["complete"]


BLOCKS = ((20.0, 1.0), (70.0, 2.0), (300.0, 1.0))


def test_no_jump_passes_the_end_of_a_block_and_every_block_is_entered_once(monkeypatch: pytest.MonkeyPatch) -> None:
    store = Store()
    result = run(monkeypatch, Stepper(), store, blocks=BLOCKS)
    assert [cycle for cycle, _ in result.measured] == list(MILESTONES)
    assert {20.0, 70.0} <= set(store.checkpoints_written)
    assert ENTERED == [(20.0, 2.0), (70.0, 1.0)]


@pytest.mark.parametrize(("stop_after", "entered"), [(40.0, [(70.0, 1.0)]), (20.0, [(20.0, 2.0), (70.0, 1.0)])])
def test_a_run_resumed_in_or_after_a_block_equals_the_unbroken_one(
    monkeypatch: pytest.MonkeyPatch, stop_after: float, entered: list[tuple[float, float]]
) -> None:
    store = Store()
    with pytest.raises(KeyboardInterrupt):
        run(monkeypatch, Stepper(stop_after=stop_after), store, blocks=BLOCKS)
    result = run(monkeypatch, Stepper(), store, resume=True, blocks=BLOCKS)
    assert entered == ENTERED
    assert [cycle for cycle, _ in result.measured] == list(MILESTONES)


def test_a_loop_is_measured_where_the_energy_bends_between_two_milestones(monkeypatch: pytest.MonkeyPatch) -> None:
    result = run(monkeypatch, Stepper(), Store(), record=Record(bends_at=(70.0, 220.0)))
    assert [cycle for cycle, _ in result.measured] == [1.0, 30.0, 70.0, 100.0, 220.0, 300.0]


@pytest.mark.parametrize(("reach", "limit"), [((1e9, 1e9), 60.0), ((50.0, 1e9), 1e9)], ids=["outgrown", "patch left"])
def test_a_scar_that_outgrows_its_meshes_or_leaves_the_patch_goes_on_with_the_next(
    monkeypatch: pytest.MonkeyPatch, reach: tuple[float, float], limit: float
) -> None:
    store = Store()
    result = run(monkeypatch, Stepper(reach=reach), store, limits=(limit, 1e9))
    assert result.measured == ((1.0, 0), (30.0, 0), (100.0, 1), (300.0, 1))
    assert store.checkpoints_written[:4] == [1.0, 11.0, 30.0, 70.0]


@pytest.mark.parametrize("failure", [PatchLeftError("beyond the largest meshes"), NotConvergedError("not found")])
def test_a_run_that_cannot_go_on_says_why_and_is_kept(monkeypatch: pytest.MonkeyPatch, failure: Exception) -> None:
    store = Store()
    with pytest.raises(type(failure)):
        run(monkeypatch, Stepper(stop_after=100.0, failure=failure), store)
    kept = store.results[-1]
    assert (kept.status, kept.message) == ("failed", str(failure))
    assert [cycle for cycle, _ in kept.measured] == [1.0, 30.0, 100.0]


def test_a_resumed_run_ends_as_one_that_was_not_interrupted(monkeypatch: pytest.MonkeyPatch) -> None:
    unbroken, broken = Store(), Store()
    expected = run(monkeypatch, Stepper(), unbroken, limits=(60.0, 1e9))
    with pytest.raises(KeyboardInterrupt):
        run(monkeypatch, Stepper(stop_after=180.0), broken, limits=(60.0, 1e9))
    before = len(broken.checkpoints_written)
    assert run(monkeypatch, Stepper(), broken, limits=(60.0, 1e9), resume=True) == expected
    assert 0 < before < len(broken.checkpoints_written)
    assert broken.checkpoints_written == unbroken.checkpoints_written
