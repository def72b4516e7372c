"""Closed cycles that are traced for a jump, and their strokes: where they end, and how slip follows from motion and
strain.

A stroke is the motion from one end of the drive's path to the other; a core is the part of the contact that has stuck
ever since the bodies were pressed together.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from solvers.contact import ContactProblem
from solvers.contact_state import ContactState, Guide
from solvers.drive import Drive
from solvers.fretting import CycleTrace, Lacking, Watch, restarted, sticks_throughout, traced_cycle
from solvers.wear_path import sliding_increments
from solvers.wear_step.grip import grip_of_core
from solvers.wear_step.orbits import Position
from solvers.wear_step.places import worn_places
from solvers.wear_step.symmetry import Mirror, Symmetry, mirrored, with_images

# A cycle is closed when friction at its end differs from that at its start by this share of it, summed over the nodes,
# and the holder's place by this share of the way that the bodies slide: on a soft rig, little friction moves it far.
_CLOSURE, _CLOSURE_OF_SLIP = 0.01, 1e-3
_MOST_CYCLES = 4


def closed_trace(
    problem: ContactProblem,
    state: ContactState,
    drive: Drive,
    increments: int,
    symmetry: Symmetry,
    watch: Watch | None = None,
    guide: Guide | None = None,
    lacking: Lacking | None = None,
) -> tuple[ContactState, CycleTrace]:
    """Trace a cycle, repeated up to 4 times until it closes, with the worn depths held fixed: the state where it
    starts, at either end of the stroke, and its trace. Where the symmetry maps its first half onto the second, the
    first half only.

    increments: number in a cycle. watch: called after each increment. guide: first guesses from a similar cycle; None:
    none. lacking: what the drive's figure lacks at a stroke's end; with a core the amplitude follows. None: the drive's
    own. Sliding wipes out what a state remembers of surfaces before they wore; a contact with a core is instead moved
    again from mid-stroke. Under a load or bulk stress that changes, `trace.worn` says by which increments surfaces
    wear.
    """
    mirror, start = symmetry.half_cycle, state
    guide = None if guide is None else with_images(guide, mirror)
    sticks = drive.steady and bool(state.core.any())
    if sticks:
        start = replace(start, grip=grip_of_core(problem, start, symmetry.across))
        start = restarted(problem, start, drive, increments, watch, lacking)
        drive = replace(drive, amplitude_mm=abs(start.drive))
    for cycle in range(_MOST_CYCLES):
        half, goes_on = mirror is not None, sticks and cycle == 0
        end, trace = traced_cycle(
            problem, start, drive, increments, half=half, watch=watch, guide=guide, goes_on=goes_on
        )
        if cycle == 0 and not sticks and sticks_throughout(start, end):
            start, guide = restarted(problem, start, drive, increments, watch), None
            continue
        image = end if mirror is None else mirrored(end, mirror)
        # The first guess may be of no cycle: places that follow a load lie over the slip of one.
        followed = drive.steady or guide is not None
        if cycle == _MOST_CYCLES - 1 or (followed and _closes(problem, drive, trace, image)):
            break
        start, guide = end, with_images(trace.guide, mirror)
    if drive.steady:
        return start, trace
    count = sliding_increments(increments) // symmetry.strokes
    return start, replace(trace, worn=worn_places(problem, trace, count))


def _closes(problem: ContactProblem, drive: Drive, trace: CycleTrace, end: ContactState) -> bool:
    """Whether a cycle that ends like this does so as it began."""
    areas, start = problem.surface.areas, trace.start
    total = float(areas @ np.abs(start.traction[:, 0]))
    friction = float(areas @ np.abs(start.traction[:, 0] - end.traction[:, 0]))
    # Under a load that stays, the bodies slide until a stroke ends, with the same friction.
    least = np.inf if drive.steady else _CLOSURE_OF_SLIP * float(np.abs(trace.slips).sum())
    return friction <= _CLOSURE * total and abs(end.holder_x - start.holder_x) <= least


def ends_of_strokes(positions: Sequence[Position], half_cycle: Mirror | None) -> list[int]:
    """Increasing indices of the positions at which strokes end: of half a cycle the last one alone, of a whole one
    (half_cycle None) also that whose drive differs most from the last one's.
    """
    last = len(positions) - 1
    if half_cycle is not None:
        return [last]
    drives = np.array([position.state.drive for position in positions])
    return [int(np.argmax(np.abs(drives - drives[-1]))), last]


def strain_counts(positions: Sequence[Position], half_cycle: Mirror | None) -> bool:
    """True if slip depends on the bodies' strain at the ends of strokes.

    That is so if a core sticks throughout the cycle, or if strain takes more than 5 % of the rigid bodies' motion in a
    contact that keeps more than half of its load on nodes pressed at both ends. half_cycle: the mirror onto the other
    half; None if the positions cover the whole cycle.
    """
    last = positions[-1].state
    if last.core.any():
        return True
    start = positions[ends_of_strokes(positions, half_cycle)[0]].state
    other, moved = start.traction, abs(_apart(last) - _apart(start))
    if half_cycle is not None:
        other, moved = half_cycle.image(last.traction, half_cycle.primary), 2.0 * abs(_apart(last))
    pressure = np.maximum(last.traction[:, 2], 0.0)
    # Of the pressures at a stroke's end: on nodes under pressure at its start as well, whose slip is known by both
    # ends.
    stays = float(pressure[other[:, 2] > 0.0].sum()) > 0.5 * float(pressure.sum())
    strokes = 1.0 if half_cycle is not None else 2.0
    # Of the rigid bodies' motion over a stroke: where strain takes a larger share, slip follows the strain at both
    # ends; else it is the rigid bodies' at each position.
    return stays and sum(map(mean_slip, positions)) < (1.0 - 0.05) * strokes * moved


def slip_is_left_over(positions: Sequence[Position], half_cycle: Mirror | None) -> bool:
    """True if slip is less than 70 % of the drive's motion, the rest being taken by rig and strain: an error of these
    large motions is then a large error of the slip.

    half_cycle: the mirror that maps these positions onto the other half of the cycle; None if they cover the whole
    cycle.
    """
    start, last = positions[ends_of_strokes(positions, half_cycle)[0]].state, positions[-1].state
    driven = 2.0 * abs(last.drive if half_cycle is not None else last.drive - start.drive)
    # Of what the drive moves: where less is left for the slip, it is a small difference of what the drive and the
    # friction force move.
    return sum(map(mean_slip, positions)) < 0.7 * driven


def _apart(state: ContactState) -> float:
    """Where the rigid bodies stand against each other, mm."""
    return state.drive - state.holder_x


def mean_slip(position: Position) -> float:
    """Slip in mm up to a position, mean over its nodes weighted with their loads there; 0 without load."""
    load = position.pairing.areas * np.maximum(position.state.traction[position.nodes, 2], 0.0)
    return float(load @ position.before) / max(float(load.sum()), 1e-300)
