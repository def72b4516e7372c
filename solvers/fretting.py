"""Fretting cycles: simulated cycles along the drive's path, and the holder's elements measured from their loops.

Cycles start and end at either end of the stroke. Their increments are those of a cosine, short near the reversals,
where the contact changes from slip to stick and back; cycles by which surfaces wear have theirs where
`solvers.wear_path` puts them. A cycle is traced or settled without wear (worn depths fixed). Common arguments:
increments, of a whole cycle; watch, called after each increment, or None; guide, first guesses from a similar cycle, or
None for the increment before.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from geometry.arrays import Array
from solvers.contact import ContactProblem, advance, press, unloaded_state
from solvers.contact.problem import facing_offset
from solvers.contact_state import ContactState, FirstGuess, Guide, IncrementReport, guide_from
from solvers.drive import Drive, Path
from solvers.errors import SolverError
from solvers.wear_path import WornPlaces, cosine_places, forced_path, loop_path, traced_path

# A loop is closed when it starts and ends with the same force within this share of the largest force.
_CLOSURE = 2e-3
_MOST_REPEATS = 4
_MET, _MOST_CORRECTIONS = 2e-4, 4  # What counts as not lacking, and how often an end of the stroke is moved.

#: What a drive's figure lacks at a state, as a share of what it holds: positive where the stroke is too short.
Lacking = Callable[[ContactState], float]
Watch = Callable[[ContactState, IncrementReport], None]  #: Called after every increment.


@dataclass(frozen=True)
class CycleTrace:
    """A simulated cycle, or part of one, of n increments; arrays (n,) hold values at the ends of increments."""

    phase: Array  #: Share of its cycle, in (0, 1], that a cosine from +amplitude has passed at that displacement.
    time: Array  #: Share of the cycle passed, by the drive's waveform.
    drive: Array  #: Displacement of the lower body, mm.
    holder_x: Array  #: Position of the upper body's holder, mm.
    tangential_force: Array  #: Force on the upper body along x, N.
    normal_force: Array  #: Force on the upper body along z, N.
    work: Array  #: Friction work of the increment, for one cycle, in mJ.
    reports: tuple[IncrementReport, ...]  #: Of all increments made, more than n where some were cut.
    guide: Guide  #: First guesses for a similar cycle.
    #: Distance in mm that each node of (primary, secondary) slid under pressure, (n,) nodes each.
    slid: tuple[Array, Array]
    start: ContactState  #: The state before the first increment.
    middle: ContactState  #: The state when the drive passes 0 towards +x; `start` if it does not.
    states: tuple[ContactState, ...]  #: The n states at the ends of increments.
    worn: WornPlaces | None = None  #: The increments at whose ends surfaces wear; None: all.

    @property
    def slips(self) -> Array:
        """Slip (n,) in mm of the bodies over each increment, mean over the nodes weighted with their loads.

        Positive where the lower body moves towards +x relative to the upper one; 0 where they do not touch.
        """
        every = (self.start, *self.states)
        forces, moved = np.array([of.primary_force for of in every]), np.diff([of.drive - of.holder_x for of in every])
        slid, means = np.diff([of.primary_slid for of in every], axis=0), forces[1:] + forces[:-1]
        weights = np.maximum(means[..., 2], 0.0)
        # A node that is pressed at one end alone slides half of the way.
        whole = weights * np.where((forces[1:, :, 2] > 0.0) == (forces[:-1, :, 2] > 0.0), 1.0, 2.0)
        # Under a load that goes, strain is given back against the slip; walls may push more than friction.
        rubbed = np.where(np.diff([of.load_share for of in every]), (slid * means[..., 0]).sum(axis=1), moved)
        return np.asarray(np.sign(rubbed) * (slid * whole).sum(axis=1) / np.maximum(weights.sum(axis=1), 1e-300))

    @property
    def friction_work(self) -> float:
        return float(self.work.sum())


def bulk_work(problem: ContactProblem, trace: CycleTrace) -> float:
    """Work in mJ that bulk strain (by bulk stress, see `solvers.drive`) does on the contact over a cycle, by the
    trapezoidal rule.

    A loop's area is friction work plus this work, which is negative where bulk strain makes the surfaces slide.
    """
    every, total = np.arange(problem.primary.patch.size), 0.0
    for old, new in pairwise((trace.start, *trace.states)):
        offset = facing_offset(problem, new, new.drive, new.holder_x)
        moved = problem.stretched(new.bulk - old.bulk, every, offset)
        total += 0.5 * float(problem.surface.areas @ ((old.traction + new.traction) * moved).sum(axis=1))
    return total


def first_quarter(
    problem: ContactProblem, state: ContactState, drive: Drive, increments: int, watch: Watch | None = None
) -> ContactState:
    """The state at +amplitude, reached from mid-stroke without wear."""
    return traced_quarter(problem, state, drive, increments, watch)[0]


def traced_quarter(
    problem: ContactProblem, state: ContactState, drive: Drive, increments: int, watch: Watch | None = None
) -> tuple[ContactState, CycleTrace]:
    """Move from mid-stroke to +amplitude without wear; returns the state there and the trace."""
    path = _cosine_stroke(drive, -1.0, increments).from_middle
    return _follow(problem, state, path, 0.0, watch, None)


def run_cycle(
    problem: ContactProblem,
    state: ContactState,
    drive: Drive,
    increments: int,
    cycles: float,
    watch: Watch | None = None,
    guide: Guide | None = None,
) -> tuple[ContactState, CycleTrace]:
    """Simulate one cycle from the end of the stroke where the state is; its wear counts `cycles` times (0: no wear).
    Returns the state at its end and the trace.
    """
    there, back = (_cosine_stroke(drive, side * _side(state), increments) for side in (1.0, -1.0))
    return _follow(problem, state, there + back, cycles, watch, guide)


def traced_cycle(
    problem: ContactProblem,
    state: ContactState,
    drive: Drive,
    increments: int,
    *,
    half: bool,
    watch: Watch | None = None,
    guide: Guide | None = None,
    goes_on: bool = False,
) -> tuple[ContactState, CycleTrace]:
    """Simulate a cycle without wear, or its first half only (`half`), whose increments are those by which surfaces
    wear: spread evenly over the slip that the guide shows, see `solvers.wear_path`. Returns the state at the end and
    the trace. goes_on: True if the increments before were part of the same simulation.
    """
    path = traced_path(drive, _side(state), state.holder_x, increments, guide, half=half)
    return _follow(problem, state, path, 0.0, watch, guide, goes_on=goes_on)


def closed_cycle(
    problem: ContactProblem,
    state: ContactState,
    drive: Drive,
    increments: int,
    watch: Watch | None = None,
    guide: Guide | None = None,
    settling_increments: int | None = None,
    *,
    moved: CycleTrace | None = None,
) -> tuple[ContactState, CycleTrace]:
    """Simulate a closed loop without wear; returns the state at its end and its trace.

    After a cycle jump the tractions belong to a slightly different surface; half a cycle of sliding, in
    settling_increments / 2 steps (default: increments / 2), removes their memory, so the loop starts at the other end
    of the stroke. A loop is repeated up to 4 times, until the tangential force at its end differs from that at its
    start by at most 0.2 % of the largest.

    moved: a cycle, or half of one, that ends where the loop is to start; None: half a cycle is moved first.
    """
    if moved is None:
        moved = settled(problem, state, drive, settling_increments or increments, watch, guide)[1]
    state, trace = moved.states[-1], moved
    for _ in range(_MOST_REPEATS):
        before = float(trace.tangential_force[-1])
        followed = drive.steady or guide is not None
        if drive.steady and state.core.any():
            path = forced_path(drive, _side(state), increments, *last_stroke(trace))
        else:
            path = loop_path(drive, _side(state), increments, guide)
        state, trace = _follow(problem, state, path, 0.0, watch, guide)
        guide, change = trace.guide, abs(float(trace.tangential_force[-1]) - before)
        if followed and change <= _CLOSURE * float(np.abs(trace.tangential_force).max()):
            break
    return state, trace


def last_stroke(trace: CycleTrace) -> tuple[Array, Array]:
    """Drive in mm and tangential force in N, (m,) each, at the start and all ends of increments of the last stroke."""
    every = (trace.start, *trace.states)
    drives = np.array([state.drive for state in every])
    first = len(every) - 1 - int(np.argmax(np.abs(drives - drives[-1])[::-1]))
    return drives[first:], np.array([float(state.primary_force[:, 0].sum()) for state in every[first:]])


def settled(
    problem: ContactProblem,
    state: ContactState,
    drive: Drive,
    increments: int,
    watch: Watch | None = None,
    guide: Guide | None = None,
) -> tuple[ContactState, CycleTrace]:
    """Move half a cycle without wear to the other end of the stroke, which removes the memory of earlier tractions.
    Returns the state there and the trace.

    A part that sticks all the way would keep its memory: the contact is then pressed and moved again from mid-stroke.
    """
    half = _cosine_stroke(drive, _side(state), increments)
    end, trace = _follow(problem, state, half, 0.0, watch, guide)
    if not sticks_throughout(state, end):
        return end, trace
    return _follow(problem, restarted(problem, state, drive, increments, watch), half, 0.0, watch, None)


def sticks_throughout(start: ContactState, end: ContactState) -> bool:
    """True if a node pressed in both states has not slid from `start` to `end`, the two ends of a stroke."""
    loaded = (start.traction[:, 2] > 0.0) & (end.traction[:, 2] > 0.0)
    return bool((loaded & (start.primary_slid == end.primary_slid)).any())


def restarted(
    problem: ContactProblem,
    state: ContactState,
    drive: Drive,
    increments: int,
    watch: Watch | None = None,
    lacking: Lacking | None = None,
) -> ContactState:
    """The state of the worn bodies pressed together at mid-stroke and moved, without wear, to the end of the stroke
    where `state` is. Its core, the nodes that have stuck ever since the first pressing, is kept.

    The core has not moved, however much has worn around it; tractions carried over from the surfaces before a jump
    would let it move by what they have lost. Slopes of the worn surface beside it must not turn its normals during
    pressing either: radial tractions would be left at its edge, which would slip sooner. The stroke is as long as
    `lacking` asks; None: the drive's.
    """
    problem.forget()
    blank = unloaded_state(problem)
    blank = replace(blank, wear=state.wear, core=state.core, bulk=drive.mean_bulk, holder_z=state.holder_z)
    pressed, _ = press(problem, blank, FirstGuess(0.0, state.overlap_area, state.traction))
    pressed = replace(pressed, pressed_z=state.pressed_z, grip=state.grip)
    path = _cosine_stroke(drive, -_side(state), increments).from_middle
    guide = guide_from(path.phase[-1:], [state])
    end, trace = _follow(problem, pressed, path, 0.0, watch, guide, goes_on=True)
    return end if lacking is None else _met(problem, (pressed, *trace.states)[-2:], lacking, watch)


def _met(
    problem: ContactProblem, latest: tuple[ContactState, ...], lacking: Lacking, watch: Watch | None
) -> ContactState:
    """The state moved on, or less far, until nothing is lacking; latest: two on the way there from mid-stroke."""
    behind, end = latest
    places, left = [behind.drive, end.drive], [lacking(behind), lacking(end)]
    for _ in range(_MOST_CORRECTIONS):
        slope = (left[-1] - left[-2]) / (places[-1] - places[-2])
        if abs(left[-1]) <= _MET or slope * end.drive >= 0.0:
            break
        place = places[-1] - left[-1] / slope
        start = end if left[-1] > 0.0 else behind
        if abs(place) <= abs(start.drive):
            break
        end, reports = advance(problem, start, place, 0.0)
        if watch:
            for report in reports:
                watch(end, report)
        places, left, behind = [*places, place], [*left, lacking(end)], start
    return end


def _side(state: ContactState) -> float:
    return 1.0 if state.drive > 0.0 else -1.0


def _cosine_stroke(drive: Drive, side: float, increments: int) -> Path:
    return drive.stroke(side, side * cosine_places(drive.amplitude_mm, increments // 2))


def _follow(
    problem: ContactProblem,
    state: ContactState,
    path: Path,
    cycles: float,
    watch: Watch | None,
    guide: Guide | None,
    *,
    goes_on: bool = False,
) -> tuple[ContactState, CycleTrace]:
    rows: list[tuple[float, float, float, float]] = []
    everything: list[IncrementReport] = []
    states: list[ContactState] = []
    middle = start = state
    # What has been gathered before decides about round-off: a resumed run is to end with the very same numbers.
    if not goes_on:
        problem.forget()
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


@dataclass(frozen=True)
class HolderElements:
    """The elements in series between contact and ground; a stiffness is infinite where the element is rigid.

    contact_stiffness_N_per_mm: along x at the contact, of spring and rotation together, without the free play.
    """

    tangential_stiffness_N_per_mm: float
    rotational_stiffness_N_mm_per_rad: float
    play_mm: float
    contact_stiffness_N_per_mm: float


def measured_holder(problem: ContactProblem, states: Sequence[ContactState]) -> HolderElements:
    """Fit the holder's elements to the states of a loop by least squares of each element's motion.

    The translation is fitted by C Q + (g/2) sign(Q) with the tangential force Q, compliance C and free play g; the tilt
    by the moment about the pivot over the rotational stiffness. Raises SolverError if the states carry no tangential
    force in both directions.
    """
    holder = problem.holder
    force = np.array([state.primary_force[:, 0].sum() for state in states])
    least = 1e-6 * holder.normal_load_N
    if not force.min() < -least < least < force.max():
        raise SolverError("the holder's elements can only be measured from states with forces in both directions")
    # Lower forces show nothing of a spring.
    loaded = np.abs(force) > 0.05 * float(np.abs(force).max())
    tilt = np.array([state.holder_tilt for state in states])
    moved = np.array([state.holder_x for state in states])
    translation = moved - holder.pivot_height_mm * tilt
    moment = np.array([_moment(problem, state) for state in states])
    spring, half_play = _fit(np.column_stack([force, np.sign(force)])[loaded], translation[loaded])
    (rotation,) = _fit(moment[loaded, None], tilt[loaded])
    (together, _) = _fit(np.column_stack([force, np.sign(force)])[loaded], moved[loaded])
    return HolderElements(_stiffness(spring), _stiffness(rotation), 2.0 * half_play, _stiffness(together))


def _moment(problem: ContactProblem, state: ContactState) -> float:
    """Moment in N mm about the holder's pivot of the contact's forces and of the load on the tilted holder."""
    force = state.primary_force
    ahead = 0.0 if problem.primary_is_upper else problem.offset(state.drive, state.holder_x)[0]
    lever = problem.primary.node_positions[:, 0] - ahead
    sideways = force[:, 0].sum() + problem.holder.normal_load_N * state.holder_tilt
    return float(problem.holder.pivot_height_mm * sideways + lever @ force[:, 2])


def _fit(columns: Array, values: Array) -> list[float]:
    solution, *_ = np.linalg.lstsq(columns, values, rcond=None)
    # Round-off of a rigid element is no compliance.
    return [float(x) if abs(x) > 1e-13 else 0.0 for x in solution]


def _stiffness(compliance: float) -> float:
    return 1.0 / compliance if compliance else float("inf")
