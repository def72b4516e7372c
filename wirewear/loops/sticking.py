"""Friction of a contact in partial slip, bounded by the energy, stiffness and shape of one loop.

After a reversal a contact yields by twice its first loading at half the force (Masing). Under a constant load that
first loading is the curve of its pressing, scaled (J. Jäger, Arch. Appl. Mech. 65 (1995) 478; M. Ciavarella, J. Mech.
Phys. Solids 46 (1998) 2349): if P grows with the power 1/n of the approach, the contact has yielded by 1 − (1 − Q/µP)^n
of its displacement at the onset of gross slip. n is ⅔ for Hertz contacts (Mindlin and Deresiewicz 1953), ½ for cones
and for evenly spread limits (Iwan 1966), and near 1 for parallel cylinders. Bodies and rig act as a spring in series.
"""

from dataclasses import dataclass

import numpy as np

from geometry.arrays import Array
from wirewear.loops.branches import Branch, MicroSlip
from wirewear.loops.cleaning import CleanLoop
from wirewear.loops.figures import WITHIN95, Measured, Regime, Sticking
from wirewear.loops.stick_slip import FittedBranch

EXPONENTS = np.array([2.0 / 3.0, 0.5, 1.0])  #: n of the shapes that are tried; at 1 the limit, of cylinders.
CYLINDERS = 0.2  #: Of the travel until cylinders slide, their contact takes no more: the rest is their bodies'.

TRAVELS = np.geomspace(0.8, 60.0, 48)  #: Travels until sliding that are tried, over that of a branch.
SHARES = np.linspace(0.0, 1.0, 13)  #: Shares of the contact in them.

FEWEST, FEWEST_ON_BRANCH = 24, 6  #: Samples of a loop, and of either branch: fewer have no bend to be read.
STEADY = 0.05  #: A load that changes by more within the cycle leaves other loops.

MODEL = 5e-4  #: What contacts and sensors depart from any such course by, of the force's amplitude.
#: Standard deviations of what readings may hide: a lag in samples, an offset of reversals and a drift, of the stroke.
LAG, OFFSET, DRIFT = 0.5, 1e-3, 3e-3

PARTIAL_SLIP = (
    "partial slip: no plateau follows the micro-slip branches, so friction_max is a lower bound, "
    "slip_amplitude is the loop's half width without global sliding, and the figures of sliding are left out"
)

BY_MICRO_SLIP = (
    "friction_partial_slip and used_share are read from energy, stiffness and shape of the loop together, for contacts "
    "from cones to cylinders behind a spring under a steady load"
)

ONLY_BOUNDED = (
    "the branches bend so little, or so unlike those of an unworn contact, that nothing bounds friction above; their "
    "largest force bounds it below"
)

MAY_BE_WORN = (
    "where the annulus that slips has worn, branches straighten and look like those of a higher friction: without "
    "knowing that the surfaces are unworn, friction_partial_slip and used_share are bounds, from the largest force to "
    "what an unworn contact shows"
)

#: Cycles after which surfaces still count as unworn: at 10⁻⁴ mm³/J they take 0.02 % of what the annulus of a steel ball
#: or wire loses until it carries nothing.
UNWORN_CYCLES = 10

SHORT = (
    "the contact slides, but no farther than it gives way before: figures that need a plateau are left out, and "
    "friction_partial_slip is that of the loop's energy, stiffness and shape together"
)

#: Worn annuli of balls, by rings of boundary elements, leave straight ends of 0.2 to 0.39 of a branch's first slope
#: where Q*/µP is 0.95 or more, and energy ratios of at most this.
STEEP, MOST_OF_WORN = 0.15, 0.35

_REMAINING = np.linspace(1.0, 0.0, 240) ** 1.5  # dense where a contact begins to slide


def sticking_of(loop: CleanLoop, fitted: tuple[FittedBranch, FittedBranch], *, worn: bool) -> Sticking | None:
    """Contacts in partial slip that would leave such a loop. fitted: forward and backward branch with their fits.
    worn: the contact's annulus may have worn.

    None where the load varies by more than 5 % within the cycle, a branch has fewer than 6 samples or both fewer than
    24, or the force falls along them.
    """
    load = loop.normal_force_N
    if load is not None and float(np.ptp(load)) > STEADY * float(np.mean(load)):
        return None
    samples = [branch.travel_um.size for branch, _ in fitted]
    if sum(samples) < FEWEST or min(samples) < FEWEST_ON_BRANCH:
        return None
    readings = _readings(loop, fitted)
    tried = _searched(readings, TRAVELS, SHARES)
    if not tried.size:
        return None
    # Twice, as many of both are tried again, about those that the last search leaves.
    for _ in range(2):
        # A corner is found only by travels that are near to it, and what fits best says what noise and model leave.
        best = tried[:, int(np.argmin(tried[0]))]
        tried = np.hstack([tried, _about(readings, tried, best[:, None])])
    tried = np.hstack([tried, _about(readings, tried, tried[:, _chi_squared(readings, tried)[0] <= WITHIN95])])
    chi_squared, scale = _chi_squared(readings, tried)
    _, limit, deviation, share, part, travel, exponent = tried
    per_force = readings.length_um * travel / (2.0 * limit)
    own = np.where(exponent < 1.0, part * exponent, 0.0)
    found = Sticking(
        chi_squared=chi_squared,
        limit_N=limit,
        # Real pressures leave a deviation of µP itself where a contact all but slides.
        deviation_N=np.hypot(np.sqrt(scale) * deviation, 0.005 * limit),
        share=share,
        contact_um_per_N=per_force * own,
        rig_um_per_N=per_force * (1.0 - part * np.where(exponent < 1.0, 1.0, CYLINDERS)),
        # Where travels beyond this are not distinguished from others, nothing shows that the contact slips.
        unseen=travel > 50.0,
        load_N=None if load is None else Measured.from_deviation(float(np.mean(load)), loop.normal_noise_N),
        worn=worn,
    )
    return found.kept(chi_squared)


def slip_of(
    loop: CleanLoop,
    fitted: tuple[FittedBranch, FittedBranch],
    seen: Regime,
    *,
    hides: bool,
    viscous: bool,
    worn: bool,
    steep: bool,
) -> tuple[Regime, tuple[Regime, ...], Sticking | None]:
    """Regime of a loop, all regimes that its uncertainty allows, and the possible contacts in partial slip (None if
    that is not the regime, or they cannot be found).

    seen: regime that the branches show. hides: True if walls of a scar may hide a plateau. viscous: True if the force
    follows the velocity. worn: the contact's annulus may have worn. steep: what seems a plateau may be the spring of
    what sticks within.
    """
    sticking = sticking_of(loop, fitted, worn=worn) if seen == "partial slip" and not (hides or viscous) else None
    if steep:
        return seen, ("partial slip", "gross slip"), sticking
    if sticking is None:
        return seen, ("partial slip", "gross slip") if hides and seen == "partial slip" else (seen,), None
    left = sticking.regimes
    return "gross slip" if left == ("gross slip",) else "partial slip", left, sticking


def may_be_worn(cycle: int | None) -> bool:
    """Whether the annulus that slips may have worn by a cycle of this number; None: not known."""
    return cycle is None or not 0 < cycle <= UNWORN_CYCLES


def stiffens(branch: Branch) -> bool:
    """True if the end of a branch is steeper than its middle; contacts in partial slip only soften (Masing)."""
    place = branch.travel_um / branch.length_um
    windows = (place > 0.4) & (place < 0.6), place > 0.8
    if min(np.unique(place[window]).size for window in windows) < 3:
        return False
    middle, end = (float(np.polyfit(place[window], branch.force_N[window], 1)[0]) for window in windows)
    # A branch stiffens if the last fifth of its travel is so much steeper than the middle one.
    return end > 1.5 * max(middle, 0.0)


def looks_worn(fitted: tuple[FittedBranch, FittedBranch], slope: Measured | None, ratio: Measured | None) -> bool:
    """True if what seems a plateau of such a slope may be the spring of what sticks within a worn annulus.

    fitted: forward and backward branch with their fits. ratio: the loop's energy ratio A.
    """
    if slope is None or ratio is None or ratio.value > MOST_OF_WORN or all(stiffens(one) for one, _ in fitted):
        return False
    height, travel = (sum(getattr(slip, name) for _, slip in fitted) for name in ("height_N", "travel_um"))
    return bool(slope.value * travel > STEEP * height)


def notes_on(regime: Regime, sticking: Sticking | None) -> list[str]:
    """Sentences on the friction that a loop without a plateau shows, and on its limits; none for a sliding loop with a
    plateau. sticking: None if no contact in partial slip is known.
    """
    if regime != "partial slip":
        return [] if sticking is None else [SHORT]
    if sticking is None:
        return [PARTIAL_SLIP]
    if np.isinf(sticking.limit.interval95[1]):
        return [PARTIAL_SLIP, ONLY_BOUNDED]
    return [PARTIAL_SLIP, BY_MICRO_SLIP, *([MAY_BE_WORN] if sticking.only_bounded else [])]


@dataclass(frozen=True, eq=False)
class _Readings:
    """Both branches one after the other (n,): forces over noise, with reading errors (k columns) projected out."""

    travel_um: Array
    length_um: float  #: Travel from reversal to reversal, mean of both branches.
    per_noise: Array  #: Inverse of the forces' noise (n,), in 1/N.
    basis: Array  #: Orthonormal columns (n + k, k) of possible reading errors, with rows for their likelihood.
    freed: Array  #: Forces over their noise (n + k,), with reading errors projected out.
    likely: float  #: Variance by which contacts depart from the model, over that of the noise.

    def clear(self, columns: Array) -> Array:
        """Columns (…, n + k) with the possible reading errors projected out."""
        cleared: Array = columns - (columns @ self.basis) @ self.basis.T
        return cleared


def _readings(loop: CleanLoop, fitted: tuple[FittedBranch, FittedBranch]) -> _Readings:
    branches = [branch for branch, _ in fitted]
    travel, force = (np.concatenate([getattr(one, name) for one in branches]) for name in ("travel_um", "force_N"))
    slope = np.concatenate([_slope(*one) for one in fitted])
    length = float(np.mean([branch.length_um for branch in branches]))
    direction = np.repeat([float(branch.direction) for branch in branches], [one.travel_um.size for one in branches])
    forward = direction == branches[0].direction
    of_displacement = 0.0 if loop.smoothed else loop.displacement_noise_um
    amplitude = 0.5 * float(np.ptp(np.percentile(force, [1.0, 99.0])))
    noise = np.sqrt(loop.force_noise_N**2 + (slope * of_displacement) ** 2 + (1e-6 * amplitude) ** 2)
    speed = np.concatenate([np.gradient(branch.travel_um) for branch in branches])
    progress = np.concatenate([np.linspace(-0.5, 0.5, branch.travel_um.size) for branch in branches])
    drift = direction * (progress + np.where(forward, 0.0, 1.0))
    hidden = np.column_stack([direction, *(slope * one for one in (speed, forward, ~forward, drift))])
    offset = max(3.0 * loop.displacement_noise_um, OFFSET * length)
    likely = np.diag([0.0, 1.0 / LAG, 1.0 / offset, 1.0 / offset, 1.0 / (DRIFT * length)])
    basis = np.linalg.qr(np.vstack([hidden / noise[:, None], likely]))[0]
    values = np.append(force / noise, np.zeros(hidden.shape[1]))
    depart = force.size * (MODEL * amplitude / float(np.median(noise))) ** 2
    return _Readings(travel, length, 1.0 / noise, basis, values - basis @ (basis.T @ values), depart)


def _slope(branch: Branch, slip: MicroSlip) -> Array:
    """Slope of the course fitted to a branch, at its samples (n,), in N/µm."""
    near = 1e-3 * branch.length_um
    ends = np.maximum(branch.travel_um - near, 0.0), np.maximum(branch.travel_um, 0.0) + near
    slope: Array = (slip.force(ends[1]) - slip.force(ends[0])) / (ends[1] - ends[0])
    return slope


def _about(readings: _Readings, tried: Array, left: Array) -> Array:
    """Contacts of a finer search over the ranges that the contacts in `left` span, widened by one step on either side.

    All arrays are (7, n) with the rows of `_searched`.
    """
    parts, travels = np.unique(tried[4]), np.unique(tried[5])
    low, high = left[4].min(), left[4].max()
    shares = np.linspace(max(parts[parts < low], default=low), min(parts[parts > high], default=high), SHARES.size)
    low, high = left[5].min(), left[5].max()
    ends = max(travels[travels < low], default=low), min(travels[travels > high], default=high)
    return _searched(readings, np.geomspace(*ends, TRAVELS.size), shares)


def _searched(readings: _Readings, travels: Array, shares: Array) -> Array:
    """Contacts of all shapes for these travels until sliding and shares of the contact in the travel, as an array (7,
    n).

    Rows: sum of squares left, µP, deviation of µP by noise alone, Q*/µP, share, travel, exponent.
    """
    count = readings.travel_um.size
    tried = []
    for exponent in EXPONENTS:
        for share in shares:
            course = _travel(exponent, share * (1.0 if exponent < 1.0 else CYLINDERS))
            rise, whole = (
                1.0 - np.interp(at / travels[:, None], course, _REMAINING)
                for at in (readings.travel_um / readings.length_um, np.ones(1))
            )
            # The closed loop turns at plus and minus half of what a branch rises by.
            columns = np.zeros((travels.size, readings.basis.shape[0]))
            columns[:, :count] = (rise - 0.5 * whole) * readings.per_noise
            columns = readings.clear(columns)
            power = np.einsum("kn,kn->k", columns, columns)
            height = (columns @ readings.freed) / power
            left = readings.freed @ readings.freed - height**2 * power
            at = np.full(travels.size, share), travels, np.full(travels.size, exponent)
            tried.append(np.stack([left, 0.5 * height, 0.5 / np.sqrt(power), whole[:, 0], *at]))
    found = np.concatenate(tried, axis=1)
    rising: Array = found[:, np.isfinite(found[0]) & (found[1] > 0.0)]
    return rising


def _chi_squared(readings: _Readings, tried: Array) -> tuple[Array, float]:
    """χ² of each contact less the smallest one (n,), and the variance of a reading over that of its noise alone."""
    count = readings.travel_um.size
    least = float(tried[0].min()) / count
    # Misfit that noise does not explain is alike in all samples, as a departure of the contact is.
    beyond = count * max(least - 1.0 - 3.0 * np.sqrt(2.0 / count), 0.0)
    scale = max(least, 1.0) + readings.likely + beyond
    return (tried[0] - count * least) / scale, scale


def _travel(exponent: float, share: float) -> Array:
    """Travel, over that until sliding, at which the shares _REMAINING of the force's rise are still to come."""
    left = _REMAINING
    own = 1.0 - left**exponent if exponent < 1.0 else 1.0 - left + left * np.log(np.maximum(left, 1e-300))
    travel: Array = (1.0 - share) * (1.0 - left) + share * own
    return travel
