"""How sharp a loop's corners are, where micro-slip passes into sliding."""

from dataclasses import dataclass

import numpy as np

from wirewear.loops.branches import Branch, MicroSlip, remaining_force
from wirewear.loops.figures import Array, Measured
from wirewear.loops.robust import CHOICE, median_deviation

#: Samples between half and one and a half of the elastic travel, below which a branch's corner cannot be told.
FEWEST_AT_CORNER = 4
#: Corners from sharp to twice as round as a Mindlin contact's.
SHARES = (0.0, 2.0)

#: Part of the plateau that is fitted with the corner: farther away a hook says nothing about it.
NEAR = 0.45

# Coarser than this, the travel's estimate has settled.
_SETTLED = 1e-4
_MOST_STEPS = 25


@dataclass(frozen=True)
class Corner:
    """Share r of the micro-slip's travel that a Cattaneo–Mindlin contact takes, mean of both branches.

    0 makes a sharp corner (a spring and Coulomb friction), 1 that of the contact alone.
    """

    share: float
    deviation: float

    @property
    def curvature(self) -> Measured:
        """Area that rounding cuts off the corner over that of the triangle below it.

        The corner is where the branch's first tangent meets the plateau's continuation; the triangle lies between the
        reversal, the corner and the force's rise there. 0 is sharp, 0.2 a Cattaneo–Mindlin contact alone.
        """
        low, high = np.clip([self.share - 1.96 * self.deviation, self.share + 1.96 * self.deviation], *SHARES)
        return Measured(_rounding(self.share), (_rounding(float(low)), _rounding(float(high))))

    @property
    def sliding_over_measured_stiffness(self) -> float:
        """Rise over travel of the whole micro-slip in shares of K_t,m, the slope of its first half.

        This is what bodies and rig take up while sliding; a Mindlin contact has by then given way by more than K_t,m
        says.
        """
        travel = np.linspace(0.0, 0.5, 101)
        slope = np.polyfit(travel, remaining_force(travel, min(self.share, 1.0)), 1)[0]
        return float(-1.0 / slope)


def corner_of(forward: tuple[Branch, MicroSlip], backward: tuple[Branch, MicroSlip]) -> Corner | None:
    """The corners of both branches; None where too few samples lie at one of them."""
    found = [_corner(*course) for course in (forward, backward)]
    known = [corner for corner in found if corner is not None]
    if len(known) < len(found):
        return None
    shares, deviations = zip(*known, strict=True)
    return Corner(float(np.mean(shares)), 0.5 * float(np.hypot(*deviations)))


def _rounding(share: float) -> float:
    """(2r/15)/(1 − r/3): from ∫g dx over the course x(s) = (1−r)(1−s³) + r(1−s²), g = s³ of `remaining_force`."""
    return 2.0 * share / 15.0 / (1.0 - share / 3.0)


def _corner(branch: Branch, slip: MicroSlip) -> tuple[float, float] | None:
    """Least-squares share r of a Mindlin contact in the micro-slip's travel, and its standard deviation.

    Gauss–Newton steps in r and the logarithm of the elastic travel; the rise and the plateau follow linearly from
    them (variable projection; Golub & Pereyra, SIAM J. Numer. Anal. 10 (1973) 413).
    """
    onset = min(slip.travel_um, branch.length_um)
    inside = branch.travel_um <= onset + NEAR * (branch.length_um - onset)
    travel, force = branch.travel_um[inside], branch.force_N[inside]
    elastic = slip.travel_um * (1.0 - slip.share / 3.0)
    if np.count_nonzero(np.abs(travel - elastic) <= 0.5 * elastic) < FEWEST_AT_CORNER:
        return None
    powers = np.vander(travel / branch.length_um - 0.5, len(slip.plateau), increasing=True)

    def residuals(logarithm: float, share: float) -> Array:
        shape = remaining_force(travel * (1.0 - share / 3.0) / np.exp(logarithm), share)
        base = np.linalg.qr(np.column_stack([powers, shape]))[0]
        left: Array = force - base @ (base.T @ force)
        return left

    at = np.array([np.log(elastic), slip.share])
    step_sizes = np.array([1e-4, 1e-3])
    best = residuals(*at)
    for _ in range(_MOST_STEPS):
        jacobian = np.column_stack(
            [(residuals(*(at + step)) - residuals(*(at - step))) / (2.0 * step.max()) for step in np.diag(step_sizes)]
        )
        step = -np.linalg.lstsq(jacobian, best, rcond=None)[0]
        step = np.clip(step, [-0.1, -0.4], [0.1, 0.4])
        while True:
            new = at + step
            new[1] = np.clip(new[1], *SHARES)
            tried = residuals(*new)
            if tried @ tried < best @ best or np.abs(step).max() < _SETTLED:
                break
            step = 0.5 * step
        moved = float(np.abs(new - at).max())
        if tried @ tried < best @ best:
            at, best = new, tried
        if moved < _SETTLED:
            break
    spread = CHOICE * max(median_deviation(best), float(np.sqrt(best @ best / max(best.size - 4.0, 1.0))))
    covariance = np.linalg.pinv(jacobian.T @ jacobian)
    return float(at[1]), spread * float(np.sqrt(covariance[1, 1]))
