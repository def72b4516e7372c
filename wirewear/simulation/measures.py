"""Slip amplitude and energy of a simulated cycle, each from the loop and from what the contact itself did.

A trace may also be half a cycle, whose other half is its mirror image. The contact's displacement is the driven body's
less the holder's. A probe solves one increment from a state to another displacement of the drive.
"""

from collections.abc import Callable
from math import nan

import numpy as np

from geometry import ContactPatch
from geometry.arrays import BoolArray
from solvers import ContactState, CycleTrace
from wirewear.loops.sensor import enclosed_area

_PROBED = 1e-4  # Of the drive's range: accuracy to which the place of the mean force is sought.
# Of a loop's energy where one ring of nodes slips, of which the edge consists of many or of few: the first on all
# gradings alike, the second where the rims of nodes do not make up for each other, as of a line contact.
_ONE_RING, _FEW_NODES = 0.12, 0.6

#: The state after one increment from a state to a place of the drive in mm.
Probe = Callable[[ContactState, float], ContactState]


def is_half(trace: CycleTrace) -> bool:
    """True if a trace is half a cycle, a stroke one way."""
    falling = trace.phase <= 0.5
    return bool(falling.all() or not falling.any())


def dissipated_energy_mJ(trace: CycleTrace) -> float:
    """Area of the loop of force over drive in mJ, at least 0; `trace` is a whole cycle that closes."""
    return max(enclosed_area(trace.drive, trace.tangential_force), 0.0)


def friction_work_mJ(trace: CycleTrace) -> float:
    """Friction work of a cycle in mJ, also from half of one; about the loop's area if no bulk stress works."""
    return (2.0 if is_half(trace) else 1.0) * trace.friction_work


def slid_amplitude_mm(trace: CycleTrace) -> float:
    """A quarter of the slip path of a cycle in mm, weighted by load over the nodes; also from half a cycle."""
    return (0.5 if is_half(trace) else 0.25) * float(np.abs(trace.slips).sum())


def slip_mismatch(trace: CycleTrace) -> float:
    """Difference of the slip amplitudes by the loop and by the contact, over the contact's displacement amplitude.

    NaN, as the two are then not equal, if the bodies part or do not slide as a whole in both directions.
    """
    slides, ways = _all_slide(trace), np.sign(trace.slips)
    apart = [state.drive - state.holder_x for state in (trace.start, *trace.states)]
    if trace.normal_force.min() <= 0.0 or not {-1.0, 1.0} <= {*ways[slides].tolist()}:
        return nan
    return abs(slip_amplitude_mm(trace) - slid_amplitude_mm(trace)) / (0.5 * float(np.ptp(apart)))


def unresolved_slip(patch: ContactPatch, trace: CycleTrace) -> float:
    """Estimated relative error of a closed loop's energy because few nodes slip around a middle that sticks.

    Whole nodes slip one after another, so the contact yields in steps; the error falls with the number of rings of
    nodes in the slipping annulus. 1 if no node slips; NaN if nothing moves, or none sticks for good and most energy is
    that of sliding as a whole. patch: of the primary body, whose nodes carry the tractions.
    """
    pressed, slips = trace.start.traction[:, 2] > 0.0, trace.slid[0] > 0.0
    if not np.ptp(trace.tangential_force) > 0.0 or not ((pressed & ~slips).any() or _mostly_slips_in_part(trace)):
        return nan
    touched = np.pad((pressed | slips).reshape(patch.shape), 1)
    within = touched[2:, 1:-1] & touched[:-2, 1:-1] & (touched[1:-1, 2:] & touched[1:-1, :-2] | (patch.shape[1] == 1))
    edge = int((touched[1:-1, 1:-1] & ~within).sum())
    rings = int(slips.sum()) / edge
    return min((_ONE_RING + _FEW_NODES / edge) / max(rings, _PROBED) ** 2, 1.0)


def slip_amplitude_mm(trace: CycleTrace, probe: Probe | None = None) -> float:
    """Slip amplitude in mm: half the width, at its mean force, of a closed loop of force over the contact's
    displacement; also from half a cycle. 0 if no node slips.

    The rig's springs and play are not in it, even where changing loads move the rig. After a reversal the elastic
    strain is given back until the mean force is met, or until all nodes slide: the slope of a worn scar may carry more
    than friction. probe: finds where the force is met within an increment under a steady load; None interpolates
    linearly.
    """
    slips = trace.slips
    if not slips.any():
        # Where all floats in free play the force that the loop would be judged by is round-off.
        return 0.0
    force, half = trace.tangential_force, is_half(trace)
    places = np.array([state.drive - state.holder_x for state in (trace.start, *trace.states)])
    slides, opened = _all_slide(trace), trace.normal_force <= 0.0
    if half:
        places, force, slips = np.append(places, -places[1:]), np.append(force, -force), np.append(slips, -slips)
        slides, opened = np.append(slides, slides), np.append(opened, opened)
    moved, places = np.diff(places), places[1:]
    mean = 0.0 if half else float(np.abs(moved) @ (force + np.roll(force, 1))) / (2.0 * float(np.abs(moved).sum()))
    ends = []
    for turn, sign in ((int(np.argmax(places)), 1.0), (int(np.argmin(places)), -1.0)):
        order = (turn + np.arange(1, len(places) + 1)) % len(places)
        back, above = slides[order] & (sign * slips[order] < 0.0), sign * (np.append(force[turn], force[order]) - mean)
        met = int(np.argmax(back | (above[1:] <= 0.0) | opened[order]))
        k, passed = int(order[met]), above[met] - above[met + 1]
        share = float(np.clip(above[met] / passed, 0.0, 1.0)) if passed > 0.0 else 0.0
        strain = moved[k] - slips[k] if back[met] else moved[k]
        end = float(places[k - 1] + share * min(sign * strain, 0.0) * sign)
        if probe is not None and 0.0 < share < 1.0:
            end = _probed(trace, probe, k, mean)
        ends.append(end)
    return max(0.5 * (ends[0] - ends[1]), 0.0)


def _mostly_slips_in_part(trace: CycleTrace) -> bool:
    work = trace.normal_force * np.abs(trace.slips)
    return bool(work[~_all_slide(trace)].sum() > 0.5 * work.sum())


def _all_slide(trace: CycleTrace) -> BoolArray:
    """True (n,) for increments over which all nodes under pressure slid."""
    return np.array(
        [
            bool((new.primary_slid > old.primary_slid)[new.traction[:, 2] > 0.0].all())
            for old, new in zip((trace.start, *trace.states), trace.states, strict=False)
        ]
    )


def _probed(trace: CycleTrace, probe: Probe, increment: int, mean_N: float) -> float:
    """The contact's displacement in mm where an increment meets the mean force; increments of the mirrored half count
    on.
    """
    from scipy.optimize import brentq

    image = -1.0 if increment >= len(trace.states) else 1.0
    k = increment % len(trace.states)
    old, new = (trace.start, *trace.states)[k : k + 2]

    def found(share: float) -> tuple[float, float]:
        state = (
            new if share == 1.0 else old if share == 0.0 else probe(old, old.drive + share * (new.drive - old.drive))
        )
        return image * float(state.primary_force[:, 0].sum()) - mean_N, image * (state.drive - state.holder_x)

    within = _PROBED * float(np.ptp(trace.drive)) / max(abs(new.drive - old.drive), 1e-300)
    share = brentq(lambda share: found(share)[0], 0.0, 1.0, xtol=min(max(within, 1e-9), 0.5))
    return found(float(share))[1]
