"""What the clock of a loop tells: a force that is read late, and a force that goes with the velocity."""

from dataclasses import replace

import numpy as np

from wirewear.loops.branches import Branch, split_branches
from wirewear.loops.cleaning import CleanLoop
from wirewear.loops.figures import Measured
from wirewear.loops.sensor import enclosed_area

#: Levels of the force's rise at which travels are compared, below a play's shelf; the travel at the second over that at
#: the first is the one behind a spring, and the other for evenly spread limits (Iwan); Mindlin contacts lie between.
LEVELS, RATIOS = (0.2, 0.4), (2.0, 2.135)

BEFORE = 8  #: Samples of the branch before, with which the reversal is passed: a force may come so many too early.
READING = 0.15  #: Standard deviation of what samples on either side of a reversal tell of its time, in samples.
LEAST_LAG, CERTAIN = 1.0, 3.0  #: A lag is one from so many samples on, and from so many of its standard deviations.

#: A force whose third harmonic is this small a share of its first has no plateau; Coulomb friction alone makes it 1/3.
SMOOTH = 0.02

FULL = 0.5  #: Loops this full, of the box around them, are opened by more than micro-slip; an ellipse fills π/4.


def lag_of(loop: CleanLoop) -> Measured | None:
    """By how many samples the force comes late, told by where it falls about reversals; None where that tells nothing.

    Behind a contact that sticks, the force's rise says when it began. The deviation is what the contact's unknown shape
    leaves open, and how far both reversals are apart.
    """
    if loop.lean_um_per_N or not (loop.times_known or loop.smoothed) or not _even(loop):
        return None
    forward, backward = split_branches(loop)
    found = _branch_lags(backward, forward), _branch_lags(forward, backward)
    if found[0] is None or found[1] is None:
        return None
    each = np.array(found)
    shape, apart = 0.5 * float(abs(np.diff(each.mean(axis=0))[0])), 0.5 * float(abs(np.diff(each.mean(axis=1))[0]))
    return Measured.from_deviation(float(each.mean()), float(np.linalg.norm([shape, apart, READING])))


def is_certain(lag: Measured) -> bool:
    """Whether a lag, of the force or of the displacement, is one for certain."""
    return abs(lag.value) > max(LEAST_LAG, CERTAIN * lag.deviation)


def _even(loop: CleanLoop) -> bool:
    steps = np.abs(np.diff(loop.time))
    return bool(steps.min() > 0.5 * np.median(steps))


def _branch_lags(before: Branch, branch: Branch) -> tuple[float, float] | None:
    """The lags τ for which the travels at both levels, read τ earlier, have either of the ratios of travels."""
    later = branch.force_N[branch.travel_um > 0.4 * branch.length_um]
    if later.size < 4 or branch.travel_um.size < 8 or before.travel_um.size < BEFORE:
        return None
    travel = np.concatenate([before.travel_um[-BEFORE:] - before.length_um, branch.travel_um])
    force = np.concatenate([-before.force_N[-BEFORE:], branch.force_N])
    top = float(np.median(later))
    half = int(np.argmax(force[BEFORE:] >= 0.5 * (top + force[BEFORE])))
    begin = int(np.argmin(force[: BEFORE + half + 1]))
    rise = (force - force[begin]) / max(top - float(force[begin]), 1e-300)
    passed = [begin + int(np.argmax(rise[begin:] >= level)) for level in LEVELS]
    if min(passed) <= begin:
        return None
    at = [
        place - (rise[place] - level) / (rise[place] - rise[place - 1])
        for place, level in zip(passed, LEVELS, strict=True)
    ]
    samples = np.arange(travel.size, dtype=float)
    # Travel near a reversal goes with the square of time, which its root makes a line through it.
    root = np.sign(travel) * np.sqrt(np.abs(travel))
    first, second = (float(np.interp(place, samples, root)) for place in at)
    turned = float(np.interp(0.0, root, samples))
    # (r2 − s)/(r1 − s) is the root of the ratio, and s the root of the travel that the lag passes.
    ends = [(np.sqrt(ratio) * first - second) / (np.sqrt(ratio) - 1.0) for ratio in RATIOS]
    lags = [float(np.interp(end, root, samples)) - turned for end in ends]
    return lags[0], lags[1]


def earlier(loop: CleanLoop, samples: float) -> CleanLoop:
    """The loop with its force read so many samples earlier, the cycle closed."""
    places = np.arange(loop.force_N.size, dtype=float)
    force = np.interp(places + samples, places, loop.force_N, period=loop.force_N.size)
    return replace(loop, force_N=force)


def branch_earlier(branch: Branch, samples: float) -> Branch:
    """The branch with its force read so many samples earlier."""
    places = np.arange(branch.force_N.size, dtype=float)
    return replace(branch, force_N=np.interp(places + samples, places, branch.force_N))


def goes_with_velocity(loop: CleanLoop) -> bool:
    """Whether a wide loop has no plateau: an ellipse, as viscous friction makes it, or an elastic force that lags."""
    box = float(np.ptp(loop.displacement_um) * np.ptp(loop.force_N))
    if abs(enclosed_area(loop.displacement_um, loop.force_N)) < FULL * box or not _even(loop):
        return False
    harmonics = np.abs(np.fft.rfft(loop.force_N - loop.force_N.mean()))
    noise = loop.force_noise_N * float(np.sqrt(loop.force_N.size))
    return bool(harmonics[3] < SMOOTH * harmonics[1] + 2.0 * noise and 5.0 * noise < harmonics[1] / 3.0)
