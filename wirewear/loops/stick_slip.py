"""Stick-slip on the plateaus of a sliding loop, and the static peak by which the force first exceeds its plateau.

A slip is a sudden fall of the force within at most three samples. A fitted branch has with it the fit of its micro-slip
and plateau; `fitted` are (forward, backward).
"""

import numpy as np

from geometry.arrays import Array
from wirewear.loops.branches import Branch, MicroSlip
from wirewear.loops.cleaning import CleanLoop
from wirewear.loops.figures import Measured, StickSlip
from wirewear.loops.noise import noise_along

FittedBranch = tuple[Branch, MicroSlip]


#: A fall of the force is a slip from so many standard deviations of a step on, and from this share of the plateau.
CERTAIN_SLIP, LEAST_DROP = 7.0, 0.03


FEWEST_SLIPS = 4  #: So many slips of a cycle are no chance.


#: Slips are resolved where at least this share of those is seen that the stick branches' stiffness lets expect.
RESOLVED = 0.6


EARLY = 0.12  #: Where a static force is sought: from the onset on over this share of the plateau.


def stick_slip(loop: CleanLoop, fitted: tuple[FittedBranch, FittedBranch]) -> StickSlip | None:
    """Stick-slip on both plateaus of a sliding loop; None if fewer than four slips are found, or none on one."""
    found = [_slips(loop, *one) for one in fitted]
    slips = np.concatenate([drops for drops, _, _ in found])
    if slips.size < FEWEST_SLIPS or min(drops.size for drops, _, _ in found) == 0:
        return None
    sliding = sum(count for _, count, _ in found)
    chattering = sum(share * count for _, count, share in found)
    per_cycle = float(slips.size)
    frequency = None
    if loop.times_known:
        duration = abs(float(loop.time[-1] - loop.time[0])) * len(loop.time) / (len(loop.time) - 1)
        frequency = per_cycle / duration * len(loop.time) / max(sliding, 1)
    spread = 1.4826 * float(np.median(np.abs(slips - np.median(slips)))) / float(np.sqrt(slips.size))
    return StickSlip(
        share=chattering / max(sliding, 1),
        slips_per_cycle=int(slips.size),
        frequency_Hz=frequency,
        force_drop_share=Measured.from_deviation(float(np.median(slips)), 1.25 * spread),
        resolved=slips.size >= RESOLVED * _expected(fitted, float(np.median(slips))),
    )


def _expected(fitted: tuple[FittedBranch, FittedBranch], drop_share: float) -> float:
    """Number of slips that would fill the sliding of a cycle, if the contact sticks after each until the force is
    regained.

    drop_share: fall of the force in a slip over the sliding force.
    """
    count = 0.0
    for branch, slip in fitted:
        stretched = drop_share * abs(slip.onset_force_N) * slip.travel_um / max(slip.height_N, 1e-300)
        count += (branch.length_um - slip.travel_um) / max(stretched, 1e-300)
    return count


def _slips(loop: CleanLoop, branch: Branch, slip: MicroSlip) -> tuple[Array, int, float]:
    """Falls of the force on one plateau over the sliding force (k,), number of plateau samples, and share between
    slips.
    """
    force = branch.force_N[branch.travel_um > slip.travel_um]
    if force.size < 6:
        return np.empty(0), force.size, 0.0
    level = float(np.percentile(np.abs(force), 75))
    if not level:
        return np.empty(0), force.size, 0.0
    least = max(CERTAIN_SLIP * np.sqrt(2.0) * _stick_noise(loop, branch, slip), LEAST_DROP * level)
    falling = np.diff(force) < 0.0
    edges = np.flatnonzero(np.diff(np.concatenate([[False], falling, [False]]).astype(int)))
    # A slip takes no more steps between samples than this; a longer fall is a slope.
    falls = [(int(a), int(b)) for a, b in edges.reshape(-1, 2) if force[a] - force[b] > least and b - a <= 3]
    sizes = np.array([force[start] - force[stop] for start, stop in falls])
    if not falls:
        return sizes, force.size, 0.0
    usual = (falls[-1][1] - falls[0][0]) / max(len(falls) - 1, 1)
    first, last = max(falls[0][0] - usual, 0.0), min(falls[-1][1] + usual, force.size - 1)
    return sizes / level, force.size, float(last - first) / (force.size - 1)


def _stick_noise(loop: CleanLoop, branch: Branch, slip: MicroSlip) -> float:
    """Noise of one force sample in N, from the branch's stick part where that has at least ten samples."""
    stick = branch.force_N[branch.travel_um < 0.8 * slip.travel_um]
    return loop.force_noise_N if stick.size < 10 else noise_along(stick)


def static_overshoot(loop: CleanLoop, fitted: tuple[FittedBranch, FittedBranch]) -> Measured | None:
    """Share of the plateau's later peaks by which the force just before sliding exceeds them, mean of both directions;
    None if either direction has no such static peak.
    """
    found = [_overshoot(loop, *one) for one in fitted]
    if None in found:
        return None
    shares, deviations = zip(*[item for item in found if item is not None], strict=True)
    return Measured.from_deviation(float(np.mean(shares)), 0.5 * float(np.hypot(*deviations)))


def _overshoot(loop: CleanLoop, branch: Branch, slip: MicroSlip) -> tuple[float, float] | None:
    span = branch.length_um - slip.travel_um
    begin, end = slip.travel_um - 0.1 * span, slip.travel_um + EARLY * span
    early = (branch.travel_um > begin) & (branch.travel_um < end)
    later = (branch.travel_um >= end) & (branch.travel_um < end + 0.4 * span)
    if np.count_nonzero(early) < 2 or np.count_nonzero(later) < 6:
        return None
    noise = _stick_noise(loop, branch, slip)
    top = int(np.flatnonzero(early)[np.argmax(branch.force_N[early])])
    # The peak lies between its highest sample and the next, up to where the rise would have led.
    step = max(float(branch.force_N[top] - branch.force_N[top - 1]), 0.0) if top else 0.0
    peak, plateau = float(branch.force_N[top]) + 0.5 * step, float(branch.force_N[later].max())
    if not plateau:
        # Nothing resists the motion there, which a peak could be set against.
        return None
    share = peak / plateau - 1.0
    deviation = float(np.hypot(np.sqrt(2.0) * noise, step / np.sqrt(12.0))) / abs(plateau)
    return (share, deviation) if plateau > 0.0 and share > max(2.5 * deviation, LEAST_DROP) else None
