"""The two branches of a loop between the reversals of the drive, and the end of micro-slip on each.

Branch coordinates: travel is the distance from the last reversal, and force is multiplied by the direction of motion,
so that it rises along both branches. A displacement sensor may be deflected by the force; its reading then runs on
after the drive has reversed, and the reversal is found after a correction δ + kQ (the "lean" k in µm/N).
"""

from dataclasses import dataclass, replace
from functools import cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Array
from wirewear.loops.cleaning import CleanLoop

PLATEAU_SHARE = 0.85  # the last part of a branch may hook upwards and says nothing about the onset of sliding
SHARES = np.array([0.0, 0.08, 0.2, 0.45, 0.7, 1.0])  # of a Mindlin contact in the travel of micro-slip, as searched

#: A force that has turned within the first share of a branch, of which a fit says that sliding begins after the second,
#: and whose medians over thirds of the branch are no farther apart than the third, rings.
EARLY, LATE, STEADY = 0.05, 0.3, 0.6

#: A reading runs on if before it turns the force has fallen below this share of what it slides at: only a stick flank
#: falls so far.
FALLEN = 0.5

#: It turns with the drive once the force there is above this share: noise and ripples take a sliding contact no lower.
SLIDING = 0.85

#: Leans that are tried, as shares of the stroke over the force's range, and by how much the least that helps is passed:
#: with no more than that a flank would be upright, and noise alone say where it turns.
LEANS, PASSED = (0.02, 0.04, 0.08, 0.16, 0.32), 1.5

SLIDING_PERCENTILES = (10.0, 90.0)  #: Forces beyond these percentiles say at what force a loop slides.

_PARAMETER = np.linspace(1.0, 0.0, 200)


def upright(loop: CleanLoop) -> CleanLoop:
    """The loop with k·Q added to its displacement, k (its `lean_um_per_N`) just large enough that the reading reverses
    where the drive does; unchanged if it does already.

    A sensor that the force deflects by more than the contact yields keeps running after the drive has reversed. δ + kQ
    encloses the same area as δ and is as wide at any force (∮Q d(kQ) = 0).
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
    """Compliance k in µm/N such that displacement + k·force, of one cycle (n,), reverses with the drive; 0 if the
    displacement does already, or no such k is found.
    """
    if not _runs_on(displacement_um, force_N):
        return 0.0
    unit = float(np.ptp(displacement_um)) / float(np.ptp(force_N))
    helps = (share for share in LEANS if not _runs_on(displacement_um + share * unit * force_N, force_N, SLIDING))
    return PASSED * next(helps, 0.0) * unit


def _runs_on(displacement_um: Array, force_N: Array, share: float = FALLEN) -> bool:
    """True if at either end the force has fallen below this share of its sliding value before the displacement
    reverses.
    """
    low, high = np.percentile(force_N, SLIDING_PERCENTILES)
    level = (2.0 * force_N - low - high) / max(high - low, 1e-300)
    before_top, before_low = int(np.argmax(displacement_um)) - 1, int(np.argmin(displacement_um)) - 1
    return bool(level[before_top] < share or -level[before_low] < share)


def vertex(loop: CleanLoop, centre: int) -> tuple[float, bool]:
    """Displacement (µm) at which the drive reverses near the sample of index `centre`, and True if that sample was
    taken at or after the reversal.

    It is the extreme of the parabola through three samples, or the meeting point of straight lines through two samples
    on either side, whichever is nearer: a drive that reverses sharply has no round tip.
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
    """Times relative to a sample, and displacements, of five samples (5,) centred on it, around the closed cycle."""
    count = len(loop.index)
    places = np.arange(centre - 2, centre + 3) % count
    steps = np.diff(loop.time[places])
    # Where a cycle ends and the next begins, the step is as its neighbours are.
    sound = steps > 0.0
    steps = np.where(sound, steps, np.mean(steps[sound]) if sound.any() else 1.0)
    times = np.concatenate([[0.0], np.cumsum(steps)])
    return times - times[2], loop.displacement_um[places]


def _meeting(*points: tuple[float, float]) -> float:
    """Value where the line through the first two points (time, value) meets the line through the last two; inf if
    parallel.
    """
    (t0, v0), (t1, v1), (t2, v2), (t3, v3) = points
    one, other = (v1 - v0) / (t1 - t0), (v3 - v2) / (t3 - t2)
    if one == other:
        return np.inf
    time = (v2 - v1 + one * t1 - other * t2) / (one - other)
    return v1 + one * (time - t1)


@dataclass(frozen=True)
class Branch:
    """Samples between two reversals, in coordinates in which the force of both branches rises along the travel."""

    direction: Literal[1, -1]  #: +1 forward, −1 backward.
    travel_um: Array  #: Distance from the reversal (n,).
    force_N: Array  #: Direction × tangential force (n,).
    normal_force_N: Array | None  #: (n,) or None.
    origin_um: float  #: Displacement at the reversal; displacement = origin + direction × travel.
    length_um: float  #: Travel from reversal to reversal.
    samples: NDArray[np.intp]  #: Positions in the input (n,).
    play_um: float = 0.0  #: Free play that was taken out of the travel; half of it is added to the origin.


@dataclass(frozen=True)
class MicroSlip:
    """Fit of one branch: a spring in series with a Mindlin contact up to the onset of gross slip, then a plateau."""

    travel_um: float  #: Travel from reversal to onset of gross slip; beyond the branch in partial slip.
    height_N: float  #: Rise of the force from the reversal to the onset (extrapolated in partial slip).
    plateau_slope_N_per_um: float  #: Mean slope of the plateau.
    misfit: float  #: Sum of squared residuals.
    slides: bool  #: True if a plateau was found.
    length_um: float  #: Travel from reversal to reversal.
    plateau: tuple[float, ...]  #: Coefficients of the plateau's polynomial in travel/length − ½.
    shape: int  #: Index of the fitted shape in SHARES.

    @property
    def share(self) -> float:
        """Share of the micro-slip travel that the Mindlin contact takes; the spring in series takes the rest."""
        return float(SHARES[self.shape])

    @property
    def onset_force_N(self) -> float:
        """Fitted force at the onset of gross slip, or at the branch's end in partial slip."""
        return float(self.force(np.array([min(self.travel_um, self.length_um)]))[0])

    def force(self, travel_um: Array) -> Array:
        """Fitted force (n,) in N at travels (n,) in µm since the reversal."""
        table_x, table_g = _remaining_force_table()
        # Steps may leave a micro-slip without any length.
        remaining = np.interp(travel_um / max(self.travel_um, 1e-12 * self.length_um), table_x[self.shape], table_g)
        powers = np.vander(travel_um / self.length_um - 0.5, len(self.plateau), increasing=True)
        force: Array = powers @ np.array(self.plateau) - self.height_N * remaining
        return force


def slides_visibly(fitted: tuple[Branch, MicroSlip]) -> bool:
    """True if a branch has a plateau, by its fit, with at least three samples."""
    branch, slip = fitted
    return slip.slides and int(np.count_nonzero(branch.travel_um > slip.travel_um)) >= 3


def split_branches(loop: CleanLoop) -> tuple[Branch, Branch]:
    """Forward branch (lowest to highest displacement) and backward branch of a loop, taken as a closed cycle."""
    count = len(loop.index)
    loop = loop.taken(np.roll(np.arange(count), -int(np.argmin(loop.displacement_um))))
    top = int(np.argmax(loop.displacement_um))
    low, low_passed = vertex(loop, 0)
    high, high_passed = vertex(loop, top)
    # a sample taken before the drive turned round belongs to the branch that ends there
    forward = np.arange(0 if low_passed else 1, top + (0 if high_passed else 1))
    backward = np.arange(top if high_passed else top + 1, count + (0 if low_passed else 1)) % count
    return _branch(loop, forward, 1, low, high - low), _branch(loop, backward, -1, high, high - low)


def _branch(
    loop: CleanLoop, order: NDArray[np.intp], direction: Literal[1, -1], origin: float, length: float
) -> Branch:
    normal = None if loop.normal_force_N is None else loop.normal_force_N[order]
    travel = direction * (loop.displacement_um[order] - origin)
    return Branch(direction, travel, direction * loop.force_N[order], normal, origin, length, loop.index[order])


def remaining_force(travel: Array, share: float) -> Array:
    """Share g (n,) of the micro-slip's rise in force that is still to come at travels (n,), in shares of the travel up
    to the onset of gross slip.

    x(s) = (1−r)(1−s³) + r(1−s²), g = s³, for a spring in series with a Mindlin contact that takes the share r =
    `share`.
    """
    s = _PARAMETER
    return np.interp(travel, (1.0 - share) * (1.0 - s**3) + share * (1.0 - s**2), s**3)


@cache
def _remaining_force_table() -> tuple[Array, Array]:
    """Values of `remaining_force` for all SHARES: travels (6, 200), rising to 1, and remaining forces (200,)."""
    s, shares = _PARAMETER, SHARES[:, None]
    return (1.0 - shares) * (1.0 - s**3) + shares * (1.0 - s**2), s**3


def fit_micro_slip(branch: Branch) -> MicroSlip:
    """Fit a branch by least squares and find where its gross slip begins.

    Two models compete by Schwarz's criterion: a curved plateau after an early onset, and a level plateau whose onset
    may lie anywhere. An onset beyond the branch means partial slip.
    """
    length, count = branch.length_um, len(branch.travel_um)
    # A later onset leaves too little plateau to tell its curve from micro-slip
    curved = _search(branch, np.geomspace(0.006, 0.6, 44) * length, 2)
    onsets = np.geomspace(0.02, 8.0, 60) * length
    level = _search(branch, onsets, 0)
    is_flat = curved.plateau_slope_N_per_um < 0.4 * curved.height_N / curved.travel_um
    rises = curved.height_N > 0.25 * float(np.ptp(branch.force_N))
    is_needed = count * np.log(max(curved.misfit, 1e-300) / max(level.misfit, 1e-300)) < -2.0 * np.log(count)
    # without hooks to fear, the whole branch tells a late onset from none
    return curved if is_flat and rises and is_needed else _search(branch, onsets, 0, share=1.0)


def _search(branch: Branch, onsets: Array, order: int, share: float = PLATEAU_SHARE) -> MicroSlip:
    length = branch.length_um
    inside = branch.travel_um <= share * length
    z, y = branch.travel_um[inside], branch.force_N[inside]
    table_x, table_g = _remaining_force_table()
    remaining = np.stack([np.interp(z[:, None] / onsets, row, table_g) for row in table_x])  # (shape, n, onset)
    basis = np.vander(z / length - 0.5, order + 1, increasing=True)
    orthogonal = np.linalg.qr(basis)[0]

    def clear(columns: Array) -> Array:
        cleared: Array = columns - orthogonal @ (orthogonal.T @ columns)
        return cleared

    free_y, free_g = clear(y), clear(remaining)
    power = np.sum(free_g**2, axis=1)
    overlap = np.einsum("n,snk->sk", free_y, free_g)
    height = np.where(power > 1e-12, -overlap / np.maximum(power, 1e-12), 0.0)
    misfit = free_y @ free_y - np.where(height > 0.0, height**2 * power, 0.0)
    shape, best = np.unravel_index(int(np.argmin(misfit)), misfit.shape)
    rise = float(height[shape, best])
    coefficients = np.linalg.lstsq(basis, y + rise * remaining[shape, :, best], rcond=None)[0]
    onset = float(np.exp(_between(np.log(onsets), misfit[shape], int(best))))

    last = PLATEAU_SHARE * length
    ends = np.vander(np.array([onset, last]) / length - 0.5, order + 1, increasing=True) @ coefficients
    return MicroSlip(
        travel_um=onset,
        height_N=rise,
        plateau_slope_N_per_um=float(ends[1] - ends[0]) / (last - onset) if order else 0.0,
        misfit=float(misfit[shape, best]),
        slides=onset < 0.95 * length,
        length_um=length,
        plateau=tuple(float(c) for c in coefficients),
        shape=int(shape),
    )


def settled(branch: Branch, slip: MicroSlip, crossing_um: float) -> MicroSlip:
    """The fit of a branch, replaced by one with an early onset where the force only oscillates about its plateau.

    The fit may take such an oscillation for micro-slip up to the branch's end; the medians over thirds of the branch
    show the plateau. crossing_um: travel at which the force changes sign.
    """
    if crossing_um > EARLY * branch.length_um or slip.travel_um < LATE * branch.length_um:
        return slip
    thirds = np.clip((3.0 * branch.travel_um / branch.length_um).astype(int), 0, 2)
    levels = [float(np.median(branch.force_N[thirds == third])) for third in range(3) if np.any(thirds == third)]
    if len(levels) < 3 or min(levels) < STEADY * max(levels) or min(levels) <= 0.0:
        return slip
    level = float(np.median(branch.force_N[branch.travel_um > EARLY * branch.length_um]))
    travel = max(2.0 * crossing_um, float(branch.travel_um[branch.travel_um > 0.0].min()))
    return replace(slip, travel_um=travel, height_N=2.0 * level, plateau_slope_N_per_um=0.0, slides=True,
                   plateau=(level,), shape=0)  # fmt: skip


def _between(x: Array, values: Array, best: int) -> float:
    """Abscissa of the minimum of the parabola through grid point `best` and its two neighbours."""
    if best in {0, len(x) - 1}:
        return float(x[best])
    before, here, after = values[best - 1 : best + 2]
    curvature = before - 2.0 * here + after
    step = x[best + 1] - x[best]
    return float(x[best] + (0.5 * (before - after) / curvature * step if curvature > 0.0 else 0.0))
