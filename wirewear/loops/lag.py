"""Lag of the force behind the displacement in one loop, and loops whose force follows the velocity.

A lag is counted in samples: positive where the force is read late. It shows where the force turns after the drive.
"""

from dataclasses import replace

import numpy as np

from geometry.arrays import Array
from wirewear.loops.branches import Branch, split_branches
from wirewear.loops.cleaning import CleanLoop
from wirewear.loops.figures import Measured
from wirewear.loops.noise import rounding_noise, step_of
from wirewear.loops.sensor import enclosed_area

#: Levels of the force's rise at which travels are compared, below a play's shelf; the travel at the second over that at
#: the first is the one behind a spring, and the other for evenly spread limits (Iwan); Mindlin contacts lie between.
LEVELS, RATIOS = (0.2, 0.4), (2.0, 2.135)


BEFORE = 8  #: Samples of the branch before, with which the reversal is passed: a force may come so many too early.


LEAST_LAG, CERTAIN = 1.0, 3.0  #: A lag is one from so many samples on, and from so many of its standard deviations.


FULL = 0.5  #: Loops this full, of the box around them, are opened by more than micro-slip; an ellipse fills π/4.


def lag_of(loop: CleanLoop) -> Measured | None:
    """Number of samples by which the force is read late (negative: early); None where the loop does not show it, or its
    samples are uneven in time.

    Behind a contact that sticks, the rise of the force shows when the reversal was. The deviation covers the contact's
    unknown shape, the difference of both reversals, and the steps in which both channels are read.
    """
    if loop.lean_um_per_N or not (loop.times_known or loop.smoothed) or not _even(loop):
        return None
    forward, backward = split_branches(loop)
    steps = step_of(loop.displacement_um), step_of(loop.force_N)
    found = [_branch_lags(*pair, steps) for pair in ((backward, forward), (forward, backward))]
    known = [lags for lags in found if lags is not None]
    if len(known) < len(found):
        return None
    each, hidden = np.array([lags[:2] for lags in known]), max(lags[2] for lags in known)
    shape, apart = 0.5 * float(abs(np.diff(each.mean(axis=0))[0])), 0.5 * float(abs(np.diff(each.mean(axis=1))[0]))
    # The last is what samples on either side of a reversal leave open of its time, in samples.
    return Measured.from_deviation(float(each.mean()), float(np.linalg.norm([shape, apart, hidden, 0.15])))


def is_certain(lag: Measured) -> bool:
    """True if a lag, of either sign, exceeds one sample and three of its standard deviations."""
    return abs(lag.value) > max(LEAST_LAG, CERTAIN * lag.deviation)


def _even(loop: CleanLoop) -> bool:
    steps = np.abs(np.diff(loop.time))
    return bool(steps.min() > 0.5 * np.median(steps))


def _branch_lags(before: Branch, branch: Branch, steps: tuple[float, float]) -> tuple[float, float, float] | None:
    """Lags in samples for the two ratios of travels in RATIOS, and their standard deviation by the reading steps.

    `steps` are those of displacement (µm) and force (N). None where the branch has too few samples.
    """
    later = branch.force_N[branch.travel_um > 0.4 * branch.length_um]
    if later.size < 4 or branch.travel_um.size < 8 or before.travel_um.size < BEFORE:
        return None
    travel = np.concatenate([before.travel_um[-BEFORE:] - before.length_um, branch.travel_um])
    force = np.concatenate([-before.force_N[-BEFORE:], branch.force_N])
    top = float(np.median(later))
    half = int(np.argmax(force[BEFORE:] >= 0.5 * (top + force[BEFORE])))
    begin = int(np.argmin(force[: BEFORE + half + 1]))
    rise = (force - force[begin]) / max(top - float(force[begin]), 1e-300)
    at = [_passed(rise, begin, level) for level in LEVELS]
    if min(at) <= begin:
        return None
    samples = np.arange(travel.size, dtype=float)
    # Travel near a reversal goes with the square of time, which its root makes a line through it.
    root = np.sign(travel) * np.sqrt(np.abs(travel))
    first, second = (float(np.interp(place, samples, root)) for place in at)
    # Within a step of the displacement nothing tells where it turned.
    resting = np.flatnonzero(np.abs(travel) <= steps[0])
    turned = float(np.mean(resting)) if steps[0] else float(np.interp(0.0, root, samples))
    # (r2 − s)/(r1 − s) is the root of the ratio, and s the root of the travel that the lag passes.
    ends = [(np.sqrt(ratio) * first - second) / (np.sqrt(ratio) - 1.0) for ratio in RATIOS]
    lags = [float(np.interp(end, root, samples)) - turned for end in ends]
    step = steps[1] / max(top - float(force[begin]), 1e-300)
    waits = [0.5 * (_passed(rise, begin, level + step) - _passed(rise, begin, level - step)) for level in LEVELS]
    # Of the root of the travels' ratio, as of `ends`.
    shares = np.array([np.sqrt(RATIOS[0]), 1.0]) / (np.sqrt(RATIOS[0]) - 1.0)
    waited = float(np.linalg.norm([*(shares * waits), resting.size if steps[0] else 0.0]))
    return lags[0], lags[1], rounding_noise(waited)


def _passed(rise: Array, begin: int, level: float) -> float:
    """Fractional sample index at which a rise (n,), counted from index `begin`, first reaches a level.

    Where it never does, the last step is extended to the level.
    """
    place = begin + int(np.argmax(rise[begin:] >= level)) if rise.max() >= level else rise.size - 1
    step = float(rise[place] - rise[place - 1]) if place > begin else 0.0
    return place - float(rise[place] - level) / step if step else float(place)


def earlier(loop: CleanLoop, samples: float) -> CleanLoop:
    """Copy of the loop with its force read this number of samples earlier (interpolated), around the cycle."""
    places = np.arange(loop.force_N.size, dtype=float)
    force = np.interp(places + samples, places, loop.force_N, period=loop.force_N.size)
    return replace(loop, force_N=force)


def branch_earlier(branch: Branch, samples: float) -> Branch:
    """Copy of the branch with its force read earlier by this number of samples (interpolated)."""
    places = np.arange(branch.force_N.size, dtype=float)
    return replace(branch, force_N=np.interp(places + samples, places, branch.force_N))


def goes_with_velocity(loop: CleanLoop) -> bool:
    """True for a loop that fills half or more of its box without a plateau: an ellipse, as viscous friction or a
    lagging elastic force makes it.
    """
    box = float(np.ptp(loop.displacement_um) * np.ptp(loop.force_N))
    if abs(enclosed_area(loop.displacement_um, loop.force_N)) < FULL * box or not _even(loop):
        return False
    harmonics = np.abs(np.fft.rfft(loop.force_N - loop.force_N.mean()))
    noise = loop.force_noise_N * float(np.sqrt(loop.force_N.size))
    # A force whose third harmonic is this small a share of its first has no plateau; Coulomb friction alone makes it
    # 1/3.
    return bool(harmonics[3] < 0.02 * harmonics[1] + 2.0 * noise and 5.0 * noise < harmonics[1] / 3.0)
