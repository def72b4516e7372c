"""What the clock of a loop tells: a force that is read late, and a force that goes with the velocity."""

from dataclasses import replace

import numpy as np

from wirewear.loops.area import enclosed_area
from wirewear.loops.branches import Branch
from wirewear.loops.cleaning import CleanLoop
from wirewear.loops.courses import Courses

#: Levels of the force's rise at which travels are compared; that at the second is twice that at the first behind a
#: spring, and 2.12 times for a Mindlin contact alone.
LEVELS, RATIO = (0.25, 0.5), 2.0

#: Lags below so many samples are not told from how samples fall about a reversal; both ends agree within this share.
LEAST_LAG, ALIKE = 1.5, 0.4

#: A force whose third harmonic is this small a share of its first has no plateau; Coulomb friction alone makes it 1/3.
SMOOTH = 0.02

#: Loops this full, of the box around them, are opened by more than micro-slip; an ellipse fills π/4. Emptier ones than
#: the other share have no plateau that a late force could go on with.
FULL, WIDE = 0.5, 0.2


def lag_of(loop: CleanLoop, courses: Courses) -> float:
    """By how many samples the force comes late, told by where it falls after reversals; 0 if it does not."""
    if courses.shelves is not None or loop.lean_um_per_N or not courses.slide or not _even(loop):
        return 0.0
    if _fullness(loop) < WIDE:
        return 0.0
    found = [_branch_lag(branch) for branch, _ in courses.both]
    late = 0.5 * sum(found)
    return late if min(found) > LEAST_LAG and abs(found[1] - found[0]) < ALIKE * late else 0.0


def _even(loop: CleanLoop) -> bool:
    steps = np.abs(np.diff(loop.time))
    return bool(steps.min() > 0.5 * np.median(steps))


def _branch_lag(branch: Branch) -> float:
    """The lag τ for which the travels at both levels, read τ earlier, have the ratio of a contact that sticks."""
    later = branch.force_N[branch.travel_um > 0.4 * branch.length_um]
    if later.size < 4 or branch.travel_um.size < 8:
        return 0.0
    # Behind the first sample: the reversal's own place among the samples is a root of its parabola.
    rise = branch.force_N - float(branch.force_N[0])
    top = float(np.median(later)) - float(branch.force_N[0])
    passed = [int(np.argmax(rise >= level * top)) for level in LEVELS]
    if top <= 0.0 or min(passed) < 1:
        return 0.0
    at = [
        place - (rise[place] - level * top) / max(rise[place] - rise[place - 1], 1e-300)
        for place, level in zip(passed, LEVELS, strict=True)
    ]
    samples = np.arange(branch.travel_um.size, dtype=float)
    # Travel near a reversal goes with the square of time, which its root makes a line to follow back.
    root = np.sqrt(np.maximum(branch.travel_um, 0.0))
    # The reversal is at most one sample before a branch's first, whatever noise leaves of their difference.
    start = -root[0] / max(root[1] - root[0], root[0], 1e-300)
    roots = [float(np.interp(place, samples, root)) for place in at]
    speed = (roots[1] - roots[0]) / max(at[1] - at[0], 1e-300)
    # (r2 − s)/(r1 − s) is the root of the ratio, and s the root of the travel that the lag passes.
    ratio = float(np.sqrt(RATIO))
    passed_root = (ratio * roots[0] - roots[1]) / (ratio - 1.0)
    if passed_root <= 0.0 or speed <= 0.0:
        return 0.0
    return float(np.interp(passed_root, root, samples) - start)


def earlier(loop: CleanLoop, samples: float) -> CleanLoop:
    """The loop with its force read so many samples earlier, the cycle closed."""
    places = np.arange(loop.force_N.size, dtype=float)
    force = np.interp(places + samples, places, loop.force_N, period=loop.force_N.size)
    return replace(loop, force_N=force)


def goes_with_velocity(loop: CleanLoop) -> bool:
    """Whether a wide loop has no plateau: an ellipse, as viscous friction makes it, or an elastic force that lags."""
    if _fullness(loop) < FULL or not _even(loop):
        return False
    harmonics = np.abs(np.fft.rfft(loop.force_N - loop.force_N.mean()))
    noise = loop.force_noise_N * float(np.sqrt(loop.force_N.size))
    return bool(harmonics[3] < SMOOTH * harmonics[1] + 2.0 * noise and 5.0 * noise < harmonics[1] / 3.0)


def _fullness(loop: CleanLoop) -> float:
    """Area over that of the box around it."""
    box = float(np.ptp(loop.displacement_um) * np.ptp(loop.force_N))
    return abs(enclosed_area(loop.displacement_um, loop.force_N)) / box
