"""Micro-slip stiffness, from a line over the first half of each branch's micro-slip, and the roundness of its corner.

The corner is where a branch passes from micro-slip into its plateau.
"""

import math
from dataclasses import dataclass

import numpy as np

from geometry.arrays import Array
from wirewear.loops.branches import Branch, MicroSlip, remaining_force
from wirewear.loops.cleaning import CleanLoop
from wirewear.loops.figures import Measured, MicroSlipBranch, mean_of
from wirewear.loops.robust import CHOICE, RobustLine, fit_line, median_deviation

STEEP = 0.7  # a concave course rises along the first half of its travel by at least its mean slope
OFF = 0.1  # of its rise; the course of a contact that softens evenly is off a line by 0.025
RESOLVED = 4  # fewer samples than this in half of the micro-slip region cannot tell its slope

SHARES = (0.0, 2.0)  #: Corners from sharp to twice as round as a Mindlin contact's.
NEAR = 0.45  #: Part of the plateau that is fitted with the corner: farther away a hook says nothing about it.

# Coarser than this, the travel's estimate has settled.
_SETTLED = 1e-4
_MOST_STEPS = 25


@dataclass(frozen=True)
class Corner:
    """Roundness of the corner from micro-slip to plateau: share r of the micro-slip travel that a Cattaneo–Mindlin
    contact takes, mean of both branches, with its standard deviation.

    0 makes a sharp corner (a spring and Coulomb friction), 1 the corner of the contact alone; fits reach up to 2.
    """

    share: float
    deviation: float

    @property
    def curvature(self) -> Measured:
        """Area that the rounded corner cuts off, over the area of the triangle below the sharp corner: 0 is sharp, 0.2
        is a Cattaneo–Mindlin contact alone.

        The sharp corner is where the branch's first tangent meets the extended plateau; the triangle lies between the
        reversal, that corner and the force's rise there.
        """
        low, high = np.clip([self.share - 1.96 * self.deviation, self.share + 1.96 * self.deviation], *SHARES)
        return Measured(_rounding(self.share), (_rounding(float(low)), _rounding(float(high))))

    @property
    def sliding_over_measured_stiffness(self) -> float:
        """Secant stiffness of the whole micro-slip over the slope of its first half, K_t,m; at most 1.

        Force over secant stiffness is the elastic yielding of bodies, rig and contact when sliding begins.
        """
        travel = np.linspace(0.0, 0.5, 101)
        slope = np.polyfit(travel, remaining_force(travel, min(self.share, 1.0)), 1)[0]
        return float(-1.0 / slope)


def corner_of(forward: tuple[Branch, MicroSlip], backward: tuple[Branch, MicroSlip]) -> Corner | None:
    """Roundness of the corner, mean of both branches (each with its fit); None where fewer than four samples lie near
    the corner of one of them.
    """
    found = [_corner(*one) for one in (forward, backward)]
    known = [corner for corner in found if corner is not None]
    if len(known) < len(found):
        return None
    shares, deviations = zip(*known, strict=True)
    return Corner(float(np.mean(shares)), 0.5 * float(np.hypot(*deviations)))


def _rounding(share: float) -> float:
    """Rounded-off area (2r/15)/(1 − r/3), from ∫g dx over the course x(s), g(s) of `remaining_force`."""
    return 2.0 * share / 15.0 / (1.0 - share / 3.0)


def _corner(branch: Branch, slip: MicroSlip) -> tuple[float, float] | None:
    """Least-squares share r of a Mindlin contact in the micro-slip travel, and its standard deviation; None if too few
    samples.

    Gauss–Newton steps in r and the logarithm of the elastic travel; the rise and the plateau follow linearly from them
    (variable projection; Golub & Pereyra, SIAM J. Numer. Anal. 10 (1973) 413).
    """
    onset = min(slip.travel_um, branch.length_um)
    inside = branch.travel_um <= onset + NEAR * (branch.length_um - onset)
    travel, force = branch.travel_um[inside], branch.force_N[inside]
    elastic = slip.travel_um * (1.0 - slip.share / 3.0)
    # Samples between half and one and a half of the elastic travel, below which a branch's corner is not seen.
    if np.count_nonzero(np.abs(travel - elastic) <= 0.5 * elastic) < 4:
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


def micro_slip_branch(loop: CleanLoop, branch: Branch, slip: MicroSlip) -> MicroSlipBranch:
    """Line fitted over the first half of a branch's micro-slip (`slip`, its fit); its interval covers a region 20 %
    longer or shorter.
    """
    travel = min(slip.travel_um, branch.length_um)
    line, fitted = _line(loop, branch, 0.5 * travel)
    others = [_line(loop, branch, part * travel)[0].slope for part in (0.4, 0.6)]
    of_region = 0.5 * abs(others[1] - others[0])
    of_drive = line.slope * loop.amplitude_noise_um / (0.5 * travel)
    deviation = float(np.linalg.norm([line.slope_deviation, of_region, of_drive]))
    if len(fitted) < RESOLVED:
        deviation = max(deviation, 0.5 * abs(line.slope) / (1 + np.count_nonzero(branch.travel_um <= 0.5 * travel)))
    begin = branch.origin_um - 0.5 * branch.direction * branch.play_um
    ends = [float(loop.displacement_um[loop.index == branch.samples[place]][0]) for place in fitted[[0, -1]]]
    return MicroSlipBranch(
        direction=branch.direction,
        stiffness_N_per_um=Measured.from_deviation(line.slope, deviation),
        intercept_N=branch.direction * line.intercept - line.slope * begin,
        displacement_um=(ends[0], ends[1]),
        micro_slip_travel_um=travel,
        samples=tuple(int(i) for i in branch.samples[fitted]),
    )


def _line(
    loop: CleanLoop, branch: Branch, reach_um: float
) -> tuple[RobustLine, np.ndarray[tuple[int], np.dtype[np.intp]]]:
    # A force stays on its step at the reversal until it has changed by half of one.
    off = branch.force_N > branch.force_N[0] + 0.5 * loop.force_step_N
    inside = np.flatnonzero((branch.travel_um <= reach_um) & (np.maximum.accumulate(off) | ~off.any()))
    if len(inside) < 2:
        inside = np.argsort(branch.travel_um)[:2]
    z, y = branch.travel_um[inside], branch.force_N[inside]
    return fit_line(z, y, loop.displacement_noise_um, loop.force_noise_N), inside


def bent(loop: CleanLoop, branch: Branch, slip: MicroSlip) -> bool:
    """True if the first half of a branch's micro-slip is too bent, flat or scattered for a line: its stiffness has no
    meaning.

    That is so if its halves differ in slope by 0.45 of the larger slope (any contact's do by less), if it rises by less
    than 0.7 of the whole micro-slip's mean slope, or if samples lie off the line by more than 0.1 of its rise, as where
    the force oscillates or free play is hidden.
    """
    reach = 0.5 * min(slip.travel_um, branch.length_um)
    line, inside = _line(loop, branch, reach)
    off = branch.force_N[inside] - line.intercept - line.slope * branch.travel_um[inside]
    spread = float(np.sqrt(off @ off / max(len(inside) - 2, 1)))
    noise = float(np.hypot(loop.force_noise_N, line.slope * loop.displacement_noise_um))
    if len(inside) >= RESOLVED and line.slope * slip.travel_um < STEEP * slip.height_N:
        return True
    if len(inside) >= RESOLVED and spread > max(OFF * line.slope * reach, 3.0 * noise):
        return True
    parts = [
        (branch.travel_um >= low * reach) & (branch.travel_um <= high * reach) for low, high in ((0, 0.5), (0.5, 1))
    ]
    if min(int(np.count_nonzero(part)) for part in parts) < RESOLVED:
        return False
    lines = [
        fit_line(branch.travel_um[part], branch.force_N[part], loop.displacement_noise_um, loop.force_noise_N)
        for part in parts
    ]
    apart = abs(lines[1].slope - lines[0].slope)
    doubt = float(np.hypot(lines[0].slope_deviation, lines[1].slope_deviation))
    # A Cattaneo-Mindlin contact alone softens by 0.16 from the first half of the region to the second
    return apart > 0.45 * max(lines[0].slope, lines[1].slope) and apart > 5.0 * doubt


def mean_stiffness(forward: MicroSlipBranch, backward: MicroSlipBranch) -> Measured | None:
    """K_t,m in N/µm, mean slope of both branches; None where either slope is not positive."""
    slopes = forward.stiffness_N_per_um, backward.stiffness_N_per_um
    if min(slope.value for slope in slopes) <= 0.0:
        return None
    return mean_of(*slopes)


def sliding_stiffness(measured: Measured | None, corner: Corner | None) -> float:
    """Stiffness in N/µm by which bodies and rig have yielded while the contact slides: `measured` (K_t,m), lowered by
    the corner's roundness if known; infinite if `measured` is None.
    """
    if measured is None:
        return math.inf
    return measured.value * (1.0 if corner is None else corner.sliding_over_measured_stiffness)
