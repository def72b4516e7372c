"""Closed loops with increments just short enough for straight lines between them to follow the tangential force.

A stroke starts with short steps, since the force changes its slope most just after a reversal. From there on the slopes
of two neighbouring chords (straight lines between the ends of steps) show how far the force departs from them: steps
grow and shrink with that, and one that proves too long is taken again. The way back of a symmetric contact is the
mirror image of the way out; any other takes the same steps, refined where its own force requires it. Places are
distances in mm from the start of a stroke.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import acos, cos, pi, sqrt

import numpy as np

from geometry.arrays import Array
from solvers.contact import ContactProblem, advance
from solvers.contact.linearising import sliding_force
from solvers.contact_state import ContactState, FirstGuess, Guide, IncrementReport, guide_from
from solvers.drive import Drive, phases
from solvers.fretting import CycleTrace, Watch, closed_cycle, last_stroke, settled
from solvers.wear_path import forced_path
from solvers.wear_step.symmetry import Mirror, kept_by, mirrored, symmetry_of

# A loop is closed when it starts and ends with the same force within this share of the largest force.
_CLOSURE = 2e-3
_MOST_REPEATS = 4
# Of the stroke: the first step after a reversal, and one below which nothing is refined.
_FIRST_STEP, _SMALLEST_STEP = 1.0 / 1000.0, 1.0 / 8000.0
_SAFETY, _LARGEST_GROWTH, _LARGEST_CUT = 0.8, 2.0, 0.2
# What was thought right, or is given by the way out, is only taken again when it is wrong by more than this factor.
_PATIENCE = 2.0


def closed_adaptive_cycle(
    problem: ContactProblem,
    state: ContactState,
    drive: Drive,
    increments: int,
    watch: Watch | None = None,
    guide: Guide | None = None,
    settling_increments: int | None = None,
    tolerance: float = 3e-3,
    moved: CycleTrace | None = None,
) -> tuple[ContactState, CycleTrace]:
    """A closed loop without wear, as from `closed_cycle`, with increments short where the force bends: the state at its
    end and its trace.

    increments: no step is longer than those of a cosine with so many increments per cycle. settling_increments: number
    per cycle in the half cycle that precedes the loop; None: `increments`. tolerance: allowed distance of the force
    from straight lines between increments, over the friction force; in partial slip over the largest force or the half
    height of a rectangular loop of the same work, whichever is less; with hardly any friction over 0.3 % of the load.
    moved: a cycle or half of one, without wear, that ends where the loop starts; None: half a cycle is moved first.

    The normal load must not change. With a core (a part that has stuck ever since the bodies were pressed together) the
    number of increments is `increments`, see `forced_path`.
    """
    trace = moved or settled(problem, state, drive, settling_increments or increments, watch, guide)[1]
    state = trace.states[-1]
    mirror = kept_by(symmetry_of(problem), state).half_cycle
    if state.core.any():
        if mirror is None or not drive.steady:
            return closed_cycle(problem, state, drive, increments, watch, moved=trace)
        return _closed_by_mirror(problem, drive, increments, watch, trace, mirror)
    friction = sliding_force(problem, state)
    largest, way = float(np.abs(trace.tangential_force).max()), np.abs(np.diff(trace.drive, prepend=trace.start.drive))
    # Of a rectangular loop that is its half height.
    # The area of a thin loop needs a straighter force; of one that opens less, no straighter still.
    opening = max(trace.friction_work / float(way.sum()), 0.002 * largest)
    # Of the normal load: loops of less force than this are followed no better than loops of so much, whether they lack
    # friction or move in free play. The remaining force is how pressures tilt on the elements, which no step resolves.
    height, least = min(friction, largest, opening), 3e-3 * float(trace.normal_force.max())
    walk = _Walk(
        problem,
        drive.amplitude_mm,
        tolerance * (height if min(friction, largest) > least else max(height, least)),
        increments,
    )
    there = back = None
    for _ in range(_MOST_REPEATS):
        start = state
        solved = out = walk.stroke(state, there)
        there = np.array([step.end for step in out])
        if mirror is not None:
            steps = [*out, *_mirrored(out, mirror)]
        else:
            home = walk.stroke(out[-1].after, there if back is None else back)
            back = np.array([step.end for step in home])
            solved = steps = [*out, *home]
        _show(solved, watch)
        state, trace = steps[-1].after, _trace(start, steps, drive)
        if _closes(trace):
            break
    return state, trace


def _closed_by_mirror(
    problem: ContactProblem, drive: Drive, increments: int, watch: Watch | None, moved: CycleTrace, mirror: Mirror
) -> tuple[ContactState, CycleTrace]:
    """A closed loop of bodies with a core, after `moved`, a cycle or a part of one; its way back mirrors its
    way out.
    """
    for _ in range(_MOST_REPEATS):
        start = moved.states[-1]
        side = 1.0 if start.drive > 0.0 else -1.0
        places = forced_path(drive, side, increments, *last_stroke(moved)).drive[: increments // 2]
        out, state, begin = list[_Step](), start, 0.0
        for place in places:
            guess = _extrapolated(out[-1].before, state) if out else None
            after, reports = advance(problem, state, float(place), 0.0, guess)
            end = abs(float(place) - start.drive)
            out.append(_Step(state, after, begin, end, tuple(reports)))
            state, begin = after, end
        _show(out, watch)
        moved = _trace(start, [*out, *_mirrored(out, mirror)], drive)
        if _closes(moved):
            break
    return moved.states[-1], moved


def _extrapolated(before: ContactState, state: ContactState) -> FirstGuess:
    """First guess of the state after `state` where forces grow alike from step to step."""
    traction = np.where(state.traction[:, 2:] > 0.0, 2.0 * state.traction - before.traction, 0.0)
    return FirstGuess(2.0 * state.holder_x - before.holder_x, state.overlap_area, traction)


def _show(steps: "Sequence[_Step]", watch: Watch | None) -> None:
    """Report all increments of the steps to `watch`."""
    if watch is not None:
        for step in steps:
            for report in step.reports:
                watch(step.after, report)


def _closes(trace: CycleTrace) -> bool:
    """True if a loop ends with the force with which it starts, within `_CLOSURE`."""
    change = abs(_force(trace.states[-1]) - _force(trace.start))
    return change <= _CLOSURE * float(np.abs(trace.tangential_force).max())


@dataclass(frozen=True)
class _Step:
    """An increment from one place along a stroke to another, in mm from the stroke's start."""

    before: ContactState
    after: ContactState
    start: float
    end: float
    reports: tuple[IncrementReport, ...]

    @property
    def length(self) -> float:
        return self.end - self.start

    @property
    def slope(self) -> float:
        return (_force(self.after) - _force(self.before)) / self.length


@dataclass(frozen=True)
class _Walk:
    """How strokes are divided into steps: drive amplitude in mm, allowed error of chords in N, and the cosine's
    `increments`.
    """

    problem: ContactProblem
    amplitude: float
    allowed: float
    increments: int

    @property
    def _shortest(self) -> float:
        return _SMALLEST_STEP * 2.0 * self.amplitude

    def stroke(self, state: ContactState, proposed: Array | None) -> list[_Step]:
        """The steps of a stroke from the end where the state is to the other end.

        proposed: (m,) places in mm to step to, refined where the force requires it.
        """
        whole, start = 2.0 * self.amplitude, state
        sign = 1.0 if start.drive > 0.0 else -1.0
        stops = np.array([self.amplitude, whole]) if proposed is None else proposed
        allowed = self.allowed if proposed is None else _PATIENCE * self.allowed
        steps: list[_Step] = []
        bends: list[float] = []
        refused: list[tuple[_Step, float]] = []
        size = _FIRST_STEP * whole if proposed is None else whole
        restarted_at = 0.0
        while not steps or steps[-1].end < whole:
            state, place = (steps[-1].after, steps[-1].end) if steps else (start, 0.0)
            stop = float(stops[np.searchsorted(stops, place, side="right")])
            # Longest step in mm from a place: the cosine's. Near a scar's end the force bends to and fro, which chords
            # would miss.
            turned = acos(max(1.0 - place / self.amplitude, -1.0)) + 2.0 * pi / self.increments
            target = _target(place, min(size, self.amplitude * (1.0 - cos(min(turned, pi))) - place), stop)
            after, reports = advance(self.problem, state, sign * (self.amplitude - target), 0.0)
            step = _Step(state, after, place, target, tuple(reports))
            bend = _bend(steps[-1], step) if steps else 0.0
            behind, ahead = (bend * steps[-1].length ** 2 if steps else 0.0), bend * step.length**2
            if not refused and behind > _PATIENCE * allowed and place > restarted_at:
                restarted_at = place
                size = max(0.5 * steps.pop().length, self._shortest)
                bends.pop()
                continue
            if ahead > allowed and step.length > 2.0 * self._shortest:
                # A force that bends as much over shorter steps is rough, not bent: after so many cuts that do not help,
                # the first step is taken, and the stroke is followed no better than it is rough.
                if len(refused) < 2 or ahead < 0.5 * refused[0][1]:
                    refused.append((step, ahead))
                    size = step.length * _change(ahead, allowed)
                    continue
                allowed = max(allowed, min(error for _, error in refused))
                step, growth = refused[0][0], 1.0
            else:
                # A force that bends ever more goes on doing so, up to where the contact slides.
                trend = float(np.clip(bend / bends[-1], 1.0, 4.0)) if bends and bends[-1] > 0.0 else 1.0
                growth = _change(ahead * trend, allowed)
            steps.append(step)
            bends.append(bend)
            on_the_way_out = proposed is not None and not refused
            size = whole if on_the_way_out else max(step.length * growth, self._shortest)
            refused.clear()
        return steps


def _mirrored(out: Sequence[_Step], mirror: Mirror) -> list[_Step]:
    """The steps of the way back of a symmetric contact, from those of the way out."""
    start, turned, home = out[0].before, out[-1].after, list[_Step]()
    for step in out:
        primary, secondary = (
            step.after.primary_slid - start.primary_slid,
            step.after.secondary_slid - start.secondary_slid,
        )
        after = replace(
            mirrored(step.after, mirror),
            primary_slid=turned.primary_slid + mirror.image(primary, mirror.primary),
            secondary_slid=turned.secondary_slid + mirror.image(secondary, mirror.secondary),
        )
        reports = tuple(replace(of, drive=-of.drive, tangential_force=-of.tangential_force) for of in step.reports)
        home.append(replace(step, before=home[-1].after if home else turned, after=after, reports=reports))
    return home


def _change(error: float, allowed: float) -> float:
    """Factor on the length of the next step, after one with this error; errors grow with the square of the length."""
    wanted = _SAFETY * sqrt(allowed / max(error, 1e-12 * allowed))
    return min(max(wanted, _LARGEST_CUT), _LARGEST_GROWTH)


def _target(place: float, size: float, stop: float) -> float:
    """Place where a step of about `size` from `place` ends: the next stop is met, without a tiny step before it."""
    ahead = stop - place
    return stop if size >= 0.8 * ahead else place + min(size, 0.5 * ahead)


def _bend(behind: _Step, ahead: _Step) -> float:
    """Largest distance of the force from the chord of either step over its length squared, N/mm².

    Twice that of a parabola, since the bend may be sharp.
    """
    return abs(ahead.slope - behind.slope) / (2.0 * (behind.length + ahead.length))


def _force(state: ContactState) -> float:
    return float(state.primary_force[:, 0].sum())


def _trace(start: ContactState, steps: Sequence[_Step], driven: Drive) -> CycleTrace:
    states = [step.after for step in steps]
    drive = np.array([state.drive for state in states])
    falling = np.array([step.before.drive > step.after.drive for step in steps])
    places = drive / driven.amplitude_mm
    phase = np.where(falling, phases(places, falling=True), phases(places, falling=False))
    middle = next(state for state, down in zip(states, falling, strict=True) if state.drive == 0.0 and not down)
    end = states[-1]
    return CycleTrace(
        drive=drive,
        phase=phase,
        time=driven.waveform.times(places, phase),
        holder_x=np.array([state.holder_x for state in states]),
        tangential_force=np.array([step.reports[-1].tangential_force for step in steps]),
        normal_force=np.array([step.reports[-1].normal_force for step in steps]),
        work=np.array([sum(report.friction_work for report in step.reports) for step in steps]),
        reports=tuple(report for step in steps for report in step.reports),
        guide=guide_from(phase, states),
        slid=(end.primary_slid - start.primary_slid, end.secondary_slid - start.secondary_slid),
        start=start,
        middle=middle,
        states=tuple(states),
    )
