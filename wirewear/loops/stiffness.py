"""Measured tangential stiffness: a line over half of the micro-slip region of each branch."""

import math

import numpy as np

from wirewear.loops.branches import Branch, MicroSlip
from wirewear.loops.cleaning import CleanLoop
from wirewear.loops.corners import Corner
from wirewear.loops.figures import Measured, MicroSlipBranch
from wirewear.loops.robust import RobustLine, fit_line

BENT = 0.45  # a Cattaneo-Mindlin contact alone softens by 0.16 from the first half of the region to the second
STEEP = 0.7  # a concave course rises along the first half of its travel by at least its mean slope
OFF = 0.1  # of its rise; the course of a contact that softens evenly is off a line by 0.025
RESOLVED = 4  # fewer samples than this in half of the micro-slip region cannot tell its slope


def micro_slip_branch(loop: CleanLoop, branch: Branch, slip: MicroSlip) -> MicroSlipBranch:
    """Fit the line; its interval also holds what a region a fifth longer or shorter would give."""
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
    inside = np.flatnonzero(branch.travel_um <= reach_um)
    if len(inside) < 2:
        inside = np.argsort(branch.travel_um)[:2]
    z, y = branch.travel_um[inside], branch.force_N[inside]
    return fit_line(z, y, loop.displacement_noise_um, loop.force_noise_N), inside


def samples_told_by(branch: Branch, slip: MicroSlip) -> int:
    """How many samples lie in half of the micro-slip region."""
    return int(np.count_nonzero(branch.travel_um <= 0.5 * slip.travel_um))


def bent(loop: CleanLoop, branch: Branch, slip: MicroSlip) -> bool:
    """Whether half of the micro-slip region is no line of a contact that yields.

    Its halves rise by slopes that have too little in common, it rises by less than the region on the whole, or samples
    are off the line by more than any contact's: a force that rings, or a play that too few of them resolve.
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
    return apart > BENT * max(lines[0].slope, lines[1].slope) and apart > 5.0 * doubt


def mean_stiffness(forward: MicroSlipBranch, backward: MicroSlipBranch) -> Measured | None:
    """K_t,m, mean slope of both branches; None where the samples jump over the branches, which leaves no slope."""
    slopes = forward.stiffness_N_per_um, backward.stiffness_N_per_um
    if min(slope.value for slope in slopes) <= 0.0:
        return None
    deviation = 0.5 * float(np.hypot(slopes[0].deviation, slopes[1].deviation))
    return Measured.from_deviation(0.5 * (slopes[0].value + slopes[1].value), deviation)


def sliding_stiffness(measured: Measured | None, corner: Corner | None) -> float:
    """What bodies and rig take up per force while sliding, in N/µm; infinite where the loop shows no stiffness."""
    if measured is None:
        return math.inf
    return measured.value * (1.0 if corner is None else corner.sliding_over_measured_stiffness)
