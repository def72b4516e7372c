"""Fretting cycles: the drive's path, and simulated cycles along it.

Cycles start and end at either end of the stroke; increments are those of a cosine, short near the
reversals, where the contact changes from slip to stick and back.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from geometry.arrays import Array
from solvers.contact import ContactProblem, advance, press, unloaded_state
from solvers.contact.linearisation import facing_offset
from solvers.contact_state import ContactState, Guide, IncrementReport, guide_from
from solvers.drive import Drive, Path
from solvers.wear_path import wear_path

# A loop is closed when it starts and ends with the same force within this share of the largest force.
_CLOSURE = 2e-3
_MOST_REPEATS = 4

Watch = Callable[[ContactState, IncrementReport], None]  #: Called after every increment.


@dataclass(frozen=True)
class CycleTrace:
    """A simulated cycle, or part of one, of n increments; arrays (n,) hold the ends of increments.

    phase: share of its cycle that a cosine from +amplitude has passed at that place, in (0, 1].  time: share of the
    cycle passed, by the drive's waveform.  drive, holder_x in mm, forces in N, work in mJ (of the increment, for one
    cycle).  guide: first guesses for a similar cycle.  slid: distance that each node of the primary and the secondary
    patch slid under pressure, mm.  start: the state before.  middle: that when the drive passes zero moving towards +x.
    states: n, at the same ends.
    """

    phase: Array
    time: Array
    drive: Array
    holder_x: Array
    tangential_force: Array
    normal_force: Array
    work: Array
    reports: tuple[IncrementReport, ...]
    guide: Guide
    slid: tuple[Array, Array]
    start: ContactState
    middle: ContactState
    states: tuple[ContactState, ...]

    @property
    def friction_work(self) -> float:
        """Friction work of the cycle, mJ."""
        return float(self.work.sum())


def bulk_work(problem: ContactProblem, trace: CycleTrace) -> float:
    """Work in mJ that what stretches the bodies does on their contact over a cycle, by the trapezoidal rule.

    A loop's area is friction work and this one: it is negative where bulk strain makes the surfaces slide.
    """
    every, total = np.arange(problem.primary.patch.size), 0.0
    for old, new in pairwise((trace.start, *trace.states)):
        offset = facing_offset(problem, new, new.drive, new.holder_x)
        moved = problem.stretched(new.bulk - old.bulk, every, offset)
        total += 0.5 * float(problem.surface.areas @ ((old.traction + new.traction) * moved).sum(axis=1))
    return total


def cosine_places(amplitude_mm: float, increments: int) -> Array:
    """Places at the ends of the increments of half a cycle from +amplitude to -amplitude, shape (increments,).

    Mirrored in the middle, so that both quarters are the same to the last bit.
    """
    quarter = amplitude_mm * np.cos(0.5 * np.pi * np.arange(1, increments // 2 + 1) / (increments // 2))
    quarter[-1] = 0.0
    return np.concatenate([quarter, -quarter[-2::-1], [-amplitude_mm]])


def first_quarter(
    problem: ContactProblem, state: ContactState, drive: Drive, increments: int, watch: Watch | None = None
) -> ContactState:
    """Move from mid-stroke to +amplitude without wear."""
    path = _cosine_stroke(drive, -1.0, increments).from_middle
    return _follow(problem, state, path, 0.0, watch, None)[0]


def run_cycle(
    problem: ContactProblem,
    state: ContactState,
    drive: Drive,
    increments: int,
    cycles: float,
    watch: Watch | None = None,
    guide: Guide | None = None,
) -> tuple[ContactState, CycleTrace]:
    """Simulate one cycle, from the end of the stroke where the state is, that wears as `cycles` cycles (0: frozen).

    guide: of a cycle with the same stroke and little wear since.
    """
    return _follow(problem, state, _path_from(state, drive, increments), cycles, watch, guide)


def traced_cycle(
    problem: ContactProblem,
    state: ContactState,
    drive: Drive,
    increments: int,
    *,
    half: bool,
    watch: Watch | None = None,
    guide: Guide | None = None,
) -> tuple[ContactState, CycleTrace]:
    """A cycle with the wear frozen, or its first half, from the end of the stroke where the state is.

    Its increments are those by which surfaces wear: spread evenly over the slip of the guide, see `wear_path`.
    """
    side, count = _side(state), increments // 2
    out = None if guide is None else guide.stroke(side)
    there = drive.stroke(side, side * wear_path(drive.amplitude_mm, side * state.holder_x, count, out))
    if half:
        return _follow(problem, state, there, 0.0, watch, guide)
    home = None if guide is None else guide.stroke(-side)
    carried = side * state.holder_x if out is None else -float(out.holder_x[-1])
    back = drive.stroke(-side, -side * wear_path(drive.amplitude_mm, carried, count, home))
    return _follow(problem, state, there + back, 0.0, watch, guide)


def closed_cycle(
    problem: ContactProblem,
    state: ContactState,
    drive: Drive,
    increments: int,
    watch: Watch | None = None,
    guide: Guide | None = None,
    settling_increments: int | None = None,
) -> tuple[ContactState, CycleTrace]:
    """A closed loop with the wear frozen; it starts and ends at the other end of the stroke.

    A cycle jump leaves tractions that belong to a slightly different surface; half a cycle of sliding, in steps of
    1/settling_increments of a cycle (default: 1/increments), removes their memory. Where the contact sticks almost
    throughout, cycles are repeated until the loop closes.
    """
    state, trace = settled(problem, state, drive, settling_increments or increments, watch, guide)
    for _ in range(_MOST_REPEATS):
        before = float(trace.tangential_force[-1])
        state, trace = run_cycle(problem, state, drive, increments, 0.0, watch, guide)
        guide = trace.guide
        if abs(float(trace.tangential_force[-1]) - before) <= _CLOSURE * float(np.abs(trace.tangential_force).max()):
            break
    return state, trace


def settled(
    problem: ContactProblem,
    state: ContactState,
    drive: Drive,
    increments: int,
    watch: Watch | None = None,
    guide: Guide | None = None,
) -> tuple[ContactState, CycleTrace]:
    """Half a cycle of frozen wear to the other end of the stroke, which removes the memory of other tractions.

    Where the contact sticks in its middle all the way, it cannot: the contact is then moved anew from mid-stroke.
    """
    half = _cosine_stroke(drive, _side(state), increments)
    end, trace = _follow(problem, state, half, 0.0, watch, guide)
    if not sticks_throughout(state, end):
        return end, trace
    return _follow(problem, anew(problem, state, drive, increments, watch), half, 0.0, watch, None)


def sticks_throughout(start: ContactState, end: ContactState) -> bool:
    """Whether a part of the contact has stuck all the way from one end of the stroke to the other."""
    loaded = (start.traction[:, 2] > 0.0) & (end.traction[:, 2] > 0.0)
    return bool((loaded & (start.primary_slid == end.primary_slid)).any())


def anew(
    problem: ContactProblem, state: ContactState, drive: Drive, increments: int, watch: Watch | None = None
) -> ContactState:
    """The worn bodies pressed together at mid-stroke and moved to the end of the stroke where the state is.

    What has stuck ever since has not moved, whatever wore around it; tractions carried over from surfaces before a jump
    would let it move by what they have lost. Slopes of what has worn beside it must not turn its normals while the
    bodies are pressed either: radial tractions would be left at its edge, which slips the sooner.
    """
    blank = replace(unloaded_state(problem), wear=state.wear, core=state.core, bulk=drive.mean_bulk)
    pressed, _ = press(problem, blank)
    pressed = replace(pressed, pressed_z=state.pressed_z)
    path = _cosine_stroke(drive, -_side(state), increments).from_middle
    return _follow(problem, pressed, path, 0.0, watch, None)[0]


def _side(state: ContactState) -> float:
    return 1.0 if state.drive > 0.0 else -1.0


def _cosine_stroke(drive: Drive, side: float, increments: int) -> Path:
    return drive.stroke(side, side * cosine_places(drive.amplitude_mm, increments // 2))


def _path_from(state: ContactState, drive: Drive, increments: int) -> Path:
    there, back = (_cosine_stroke(drive, side * _side(state), increments) for side in (1.0, -1.0))
    return there + back


def _follow(
    problem: ContactProblem, state: ContactState, path: Path, cycles: float, watch: Watch | None, guide: Guide | None
) -> tuple[ContactState, CycleTrace]:
    rows: list[tuple[float, float, float, float]] = []
    everything: list[IncrementReport] = []
    states: list[ContactState] = []
    middle = start = state
    # What has been gathered before decides about round-off: a resumed run is to end with the very same numbers.
    for body in (problem.primary, problem.secondary):
        body.latest_block.clear()
    for drive, phase, _time, load, bulk in path:
        rising = drive > state.drive
        guess = guide.at(float(phase), float(drive)) if guide is not None else None
        state, reports = advance(problem, state, float(drive), cycles, guess, float(load), bulk)
        states.append(state)
        everything.extend(reports)
        if watch:
            for report in reports:
                watch(state, report)
        work = sum(report.friction_work for report in reports)
        rows.append((state.holder_x, reports[-1].tangential_force, reports[-1].normal_force, work))
        if rising and drive == 0.0:
            middle = state
    holder_x, tangential, normal, work_done = np.array(rows).T
    trace = CycleTrace(
        phase=path.phase,
        time=path.time,
        drive=path.drive,
        holder_x=holder_x,
        tangential_force=tangential,
        normal_force=normal,
        work=work_done,
        reports=tuple(everything),
        guide=guide_from(path.phase, states),
        slid=(state.primary_slid - start.primary_slid, state.secondary_slid - start.secondary_slid),
        start=start,
        middle=middle,
        states=tuple(states),
    )
    return state, trace
