"""Where the drive turns round: at the outermost readings, unless these run on while the force already falls."""

from dataclasses import replace

import numpy as np

from wirewear.loops.cleaning import CleanLoop
from wirewear.loops.figures import Array

#: A reading runs on if before it turns the force has fallen below this share of what it slides at: only a stick flank
#: falls so far.
FALLEN = 0.5

#: It turns with the drive once the force there is above this share: noise and ripples take a sliding contact no lower.
SLIDING = 0.85

#: Leans that are tried, as shares of the stroke over the force's range, and by how much the least that helps is passed:
#: with no more than that a flank would be upright, and noise alone say where it turns.
LEANS, PASSED = (0.02, 0.04, 0.08, 0.16, 0.32), 1.5

#: Forces beyond these percentiles say at what force a loop slides.
SLIDING_PERCENTILES = (10.0, 90.0)


def upright(loop: CleanLoop) -> CleanLoop:
    """The loop with as much displacement in proportion to its force as makes its reading turn where the drive does.

    A reading that leans against the force by more than the contact yields runs on after the drive has turned round,
    while the contact sticks: its outermost samples are where sliding begins again. δ + kQ encloses what δ does, and is
    as wide at any force (∮Q d(kQ) = 0); it turns with the drive, from a k on. Other loops are returned as they are.
    """
    lean = lean_of(loop.displacement_um, loop.force_N)
    if lean == 0.0:
        return loop
    added = lean * loop.force_N
    return replace(
        loop,
        displacement_um=loop.displacement_um + added,
        raw_displacement_um=loop.raw_displacement_um + added,
        lean_um_per_N=lean,
    )


def lean_of(displacement_um: Array, force_N: Array) -> float:
    """Displacement per force to be added to those of one cycle (n,), in µm/N; 0 where they turn with the drive."""
    if not _runs_on(displacement_um, force_N):
        return 0.0
    unit = float(np.ptp(displacement_um)) / float(np.ptp(force_N))
    helps = (share for share in LEANS if not _runs_on(displacement_um + share * unit * force_N, force_N, SLIDING))
    return PASSED * next(helps, 0.0) * unit


def _runs_on(displacement_um: Array, force_N: Array, share: float = FALLEN) -> bool:
    """Whether the force has fallen below a share before the displacement turns, at either end."""
    low, high = np.percentile(force_N, SLIDING_PERCENTILES)
    level = (2.0 * force_N - low - high) / max(high - low, 1e-300)
    before_top, before_low = int(np.argmax(displacement_um)) - 1, int(np.argmin(displacement_um)) - 1
    return bool(level[before_top] < share or -level[before_low] < share)


def vertex(loop: CleanLoop, centre: int) -> tuple[float, bool]:
    """Displacement at which the drive turns, near its outermost sample, and whether that is taken at or after it.

    The extreme value of the parabola through three neighbours, or where the straight lines through two samples on
    either side meet, if that is nearer: a drive that turns sharply has no round tip.
    """
    values = loop.displacement_um
    times, (far_before, before, here, after, far_after) = _neighbours(loop, centre)
    rise, fall = (here - before) / -times[1], (after - here) / times[3]
    curvature = 2.0 * (fall - rise) / (times[3] - times[1])
    if curvature == 0.0 or not np.isfinite(curvature):
        return float(here), True
    slope = (rise * times[3] - fall * times[1]) / (times[3] - times[1])
    passed = bool(-slope / curvature <= 1e-6 * (times[3] - times[1]))
    beyond = -0.5 * slope**2 / curvature
    if passed:
        tip = _meeting((times[0], far_before), (times[1], before), (0.0, here), (times[3], after))
    else:
        tip = _meeting((times[1], before), (0.0, here), (times[3], after), (times[4], far_after))
    outwards = float(np.sign(here - 0.5 * (before + after)))
    room = max(outwards * (tip - here), 0.0)
    if not loop.times_known:
        # how far a sine may pass its outermost sample, twice over, as nothing tells how the samples are spread
        room = min(room, float(np.ptp(values)) * 0.5 * (np.pi / len(values)) ** 2)
    return float(here + outwards * min(abs(beyond), room)), passed


def _neighbours(loop: CleanLoop, centre: int) -> tuple[Array, Array]:
    """Times from a sample, and displacements, of two samples before it, itself and two after it, cyclic."""
    count = len(loop.index)
    places = np.arange(centre - 2, centre + 3) % count
    steps = np.diff(loop.time[places])
    # Where a cycle ends and the next begins, the step is as its neighbours are.
    sound = steps > 0.0
    steps = np.where(sound, steps, np.mean(steps[sound]) if sound.any() else 1.0)
    times = np.concatenate([[0.0], np.cumsum(steps)])
    return times - times[2], loop.displacement_um[places]


def _meeting(*points: tuple[float, float]) -> float:
    """Where the line through the first two points (time, value) meets that through the last two; infinite if never."""
    (t0, v0), (t1, v1), (t2, v2), (t3, v3) = points
    one, other = (v1 - v0) / (t1 - t0), (v3 - v2) / (t3 - t2)
    if one == other:
        return np.inf
    time = (v2 - v1 + one * t1 - other * t2) / (one - other)
    return v1 + one * (time - t1)
