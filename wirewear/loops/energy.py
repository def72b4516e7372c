"""Energy and width of a loop, and the ratios A and B of its energy to the boxes of its stroke and of its slip.

The ratios are criteria of sliding (Fouvry, Kapsa & Vincent, Wear 185 (1995) 35). For a sphere on a flat, or crossed
wires, the transition from partial to gross slip lies at A = 0.2 and B = 0.77.
"""

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Array
from wirewear.loops.branches import Branch, MicroSlip
from wirewear.loops.cleaning import CleanLoop
from wirewear.loops.figures import Measured, mean_of
from wirewear.loops.robust import fit_linear
from wirewear.loops.sensor import enclosed_area

MICROJOULE_IN_MILLIJOULE = 1e-3


ENERGY_TRANSITION, SYSTEM_FREE_TRANSITION = 0.2, 0.77  #: Values at the transition from partial slip to gross slip.


#: No unworn contact in partial slip has a larger energy ratio: that of evenly spread limits where it begins to slide
#: (Iwan 1966).
MOST_IN_PARTIAL_SLIP = 1.0 / 3.0


def mean_force(loop: CleanLoop) -> Measured:
    """Mean tangential force in N over the path, ∮Q|dδ| / ∮|dδ|; each sample counts by the way around it."""
    step = np.abs(np.roll(loop.displacement_um, -1) - loop.displacement_um)
    weight = 0.5 * (step + np.roll(step, 1))
    weight /= weight.sum()
    deviation = loop.force_noise_N * float(np.sqrt(np.sum(weight**2)))
    return Measured.from_deviation(float(weight @ loop.force_N), deviation)


def dissipated_energy(loop: CleanLoop) -> Measured:
    """Dissipated energy ∮Q dδ in mJ: area of the samples' polygon, plus what coarse sampling cuts off its corners."""
    x, y = loop.displacement_um, loop.force_N
    corners = _cut_corners(x, y, loop.force_noise_N, loop.displacement_noise_um)
    area = enclosed_area(x, y) + corners
    dx, dy = 0.5 * (np.roll(x, -1) - np.roll(x, 1)), 0.5 * (np.roll(y, -1) - np.roll(y, 1))
    from_force = loop.force_noise_N * float(np.sqrt(np.sum(dx**2)))
    from_displacement = loop.displacement_noise_um * float(np.sqrt(np.sum(dy**2)))
    from_stroke = 2.0 * float(np.ptp(y)) * loop.amplitude_noise_um
    deviation = float(np.linalg.norm([from_force, from_displacement, from_stroke, 0.25 * corners]))
    return Measured.from_deviation(area * MICROJOULE_IN_MILLIJOULE, deviation * MICROJOULE_IN_MILLIJOULE)


def _cut_corners(x: Array, y: Array, force_noise: float, displacement_noise: float) -> float:
    """Area between the samples' polygon and the curve through them, in N·µm.

    Extending the chords on either side of a chord makes a triangle on it. A sharp corner of the curve fills the whole
    triangle, a smooth arc a third of it; two thirds are taken. Triangles no higher than the noise are left out, as are
    those that reach beyond the stroke beside a sharp tip.
    """
    width, height = float(np.ptp(x)), float(np.ptp(y))
    points = np.column_stack([x / width, y / height])
    chord = np.roll(points, -1, axis=0) - points
    before, after = np.roll(chord, 1, axis=0), np.roll(chord, -1, axis=0)
    turn, entry, leave = _cross(before, after), _cross(before, chord), _cross(chord, after)
    # the extensions meet on the outer side only if all three turns agree
    meets = (turn * entry > 0.0) & (turn * leave > 0.0)
    reach = np.where(meets, leave / np.where(turn == 0.0, 1.0, turn), 0.0)
    apex = points[:, 0] + reach * before[:, 0]
    overshoot = 0.125 * (2.0 * np.pi / len(x)) ** 2  # how far a sine may pass its outermost sample, of its range
    inside = (apex > points[:, 0].min() - overshoot) & (apex < points[:, 0].max() + overshoot)
    doubled_area = reach * entry
    noise = float(np.hypot(force_noise / height, displacement_noise / width))
    visible = np.abs(doubled_area) > 6.0 * noise * np.linalg.norm(chord, axis=1)
    # a dissipating loop turns clockwise: negative turns cut area off
    return float(-2.0 / 3.0 * 0.5 * np.sum(doubled_area[inside & visible])) * width * height


def _cross(a: Array, b: Array) -> Array:
    product: Array = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return product


def crossing_travel(
    branch: Branch, slip: MicroSlip, level_N: float, force_noise_N: float
) -> tuple[float, float, NDArray[np.intp]]:
    """Travel in µm at which a branch passes the tangential force `level_N` (in the loop's sign), its standard deviation
    in µm, and the input's samples that gave it; (0, half of the first travel, none) if it never passes.

    slip: the branch's fit. force_noise_N: standard deviation of a sample. A parabola is fitted to samples around the
    crossing if at least six lie there; else it is interpolated between the two samples on either side.
    """
    level = branch.direction * level_N
    z, y = branch.travel_um, branch.force_N - level
    tip = slip.onset_force_N - slip.height_N if slip.slides else float(branch.force_N.min())
    room = min(slip.onset_force_N - level, level - tip)
    near = (np.abs(y) < 0.6 * room) & (z <= 1.25 * slip.travel_um)
    # A branch that passes a force again after so large a share of the stroke does so by ringing, chatter or an outlier.
    wavers, at = 0.05 * branch.length_um, balance(z, y)
    if np.count_nonzero(near) >= 6 and force_noise_N > 1e-3 * room:
        fit = fit_linear(np.vander(y[near] / room, 3, increasing=True), z[near])
        travel, deviation = float(fit.coefficients[0]), float(np.sqrt(fit.covariance[0, 0]))
        if abs(travel - at) <= wavers + 3.0 * deviation:
            return travel, deviation, branch.samples[near]
    passed = np.flatnonzero((y[:-1] < 0.0) & (y[1:] >= 0.0))
    passed = passed[(z[passed] - at <= wavers) & (at - z[passed + 1] <= wavers)]
    if not len(passed):
        return 0.0, 0.5 * float(abs(z[0])), branch.samples[:0]
    travels = [_passage(slip, level, z[i : i + 2], branch.force_N[i : i + 2]) for i in passed[[0, -1]]]
    first, last = passed[0], passed[-1] + 1
    slope = float((y[last] - y[first]) / max(z[last] - z[first], 1e-300))
    used = branch.samples[np.unique([*passed[[0, -1]], *(passed[[0, -1]] + 1)])]
    return 0.5 * sum(travels), 0.5 * abs(travels[1] - travels[0]) + force_noise_N / slope, used


def balance(travel: Array, force: Array) -> float:
    """Travel (µm) at which a branch's forces (n,), counted from a level, change from negative to positive on the whole:
    that at which their integral over travel (n,) is least.

    Forces that oscillate cross the level several times, but over travels that add little to the integral.
    """
    order = np.argsort(travel, kind="stable")
    z, y = travel[order], force[order]
    sums = np.concatenate([[0.0], np.cumsum(0.5 * (y[1:] + y[:-1]) * np.diff(z))])
    return float(z[int(np.argmin(sums))])


def _passage(slip: MicroSlip, level: float, z: Array, force: Array) -> float:
    """Travel between two samples at which the fitted course, adjusted to pass through both, reaches a level."""
    if z[0] == z[1]:
        return float(z[0])
    between = np.linspace(z[0], z[1], 65)
    course = slip.force(between)
    course += force[0] - course[0] + (between - z[0]) / (z[1] - z[0]) * (force[1] - course[-1] - force[0] + course[0])
    return float(np.interp(level, np.maximum.accumulate(course), between))


def slip_amplitude(
    loop: CleanLoop, forward: tuple[Branch, MicroSlip], backward: tuple[Branch, MicroSlip], level_N: float
) -> tuple[Measured, tuple[int, ...]]:
    """δ0 in µm, half the distance between two branches at the force `level_N`, and the input's samples that gave it.
    forward, backward: each with its fit.
    """
    up, up_deviation, rising = crossing_travel(*forward, level_N, loop.force_noise_N)
    down, down_deviation, falling = crossing_travel(*backward, level_N, loop.force_noise_N)
    right = backward[0].origin_um - down
    left = forward[0].origin_um + up
    deviation = float(np.linalg.norm([0.5 * up_deviation, 0.5 * down_deviation, loop.amplitude_noise_um]))
    return Measured.from_deviation(0.5 * (right - left), deviation), (*rising.tolist(), *falling.tolist())


def by_energy(energy: Measured, height_N: Measured) -> Measured:
    """δ0 in µm from the loop's energy and the mean |Q| of both directions at mid-slip, E_d/(4Q).

    It is exact for a parallelogram, whatever curve its middle follows: the slopes of a scar raise the force in one
    direction as much as they lower it in the other.
    """
    return energy.over(height_N, times=0.25 / MICROJOULE_IN_MILLIJOULE)


def narrow(slip: Measured, other: Measured, amplitude_um: float) -> bool:
    """True if a slip amplitude read from the loop's width is below 0.85 of the `other`, by its energy (or of the
    displacement amplitude, if that is less), or exceeds the displacement amplitude beyond its interval.
    """
    wide = slip.value > amplitude_um + (slip.interval95[1] - slip.value)
    # A width at mid force below this share of what energy and sliding force give was read where the loop slides.
    return wide or slip.value < 0.85 * min(other.value, amplitude_um)


def force_amplitude(loop: CleanLoop, tops: tuple[Measured, Measured]) -> Measured:
    """Amplitude Q* in N: mean of the largest |Q| of both directions, which a force offset does not shift.

    tops: largest |Q|/P of either direction, or largest |Q| if the normal force is unknown.
    """
    load = 1.0 if loop.normal_force_N is None else float(np.median(loop.normal_force_N))
    mean = mean_of(*tops)
    return Measured.from_deviation(load * mean.value, load * mean.deviation)


def energy_ratio(energy_mJ: Measured, amplitude_um: Measured, force_N: Measured) -> Measured | None:
    """Energy over the box 4 δ Q*: ratio A if `amplitude_um` is the displacement amplitude, B if it is the slip
    amplitude. None if that box is empty.
    """
    if amplitude_um.value * force_N.value <= 0.0:
        return None
    return energy_mJ.over(amplitude_um, force_N, times=0.25 / MICROJOULE_IN_MILLIJOULE)
