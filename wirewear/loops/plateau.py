"""The sliding part of each branch: force at mid-slip, peaks, slope."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wirewear.loops.branches import Branch, MicroSlip
from wirewear.loops.figures import Array, Measured
from wirewear.loops.robust import best_fit, fit_linear

MIDDLE_SHARE = 0.4

#: Places at which both directions are read: about as many as a loop of 200 samples has there.
PLACES = 41

#: So many noises above what is fitted to a branch, a sample is no chance: outliers have been left out.
BEYOND_NOISE = 5.0


@dataclass(frozen=True)
class Plateau:
    """Sliding samples of one branch: slip position x = δ − Q/K, travel, |Q|, and |Q|/P (|Q| again without P), (n,)."""

    slip_position_um: Array
    travel_um: Array
    force_N: Array
    ratio: Array


def slip_position(branch: Branch, stiffness_N_per_um: float) -> Array:
    """Displacement less what bodies and rig take up elastically, x = δ − Q/K, in µm (n,)."""
    displacement = branch.origin_um + branch.direction * branch.travel_um
    position: Array = displacement - branch.direction * branch.force_N / stiffness_N_per_um
    return position


def sliding_part(branch: Branch, slip: MicroSlip, stiffness_N_per_um: float) -> Plateau:
    """Samples after the onset of gross slip."""
    slides = branch.travel_um > slip.travel_um
    position = slip_position(branch, stiffness_N_per_um)[slides]
    return Plateau(position, branch.travel_um[slides], branch.force_N[slides], force_ratio(branch)[slides])


def force_ratio(branch: Branch) -> Array:
    """|Q|/P (n,), or |Q| where no normal force is known."""
    return branch.force_N if branch.normal_force_N is None else branch.force_N / branch.normal_force_N


def value_at(position: Array, values: Array, where: float, half_window: float) -> Measured:
    """Value at a position by a robust parabola over ± half_window (a chord if fewer than 5 samples lie there)."""
    near = np.abs(position - where) <= half_window
    if np.count_nonzero(near) < 5:
        order = np.argsort(position)
        return Measured.from_deviation(float(np.interp(where, position[order], values[order])), 0.0)
    centred = (position[near] - where) / half_window
    fit = fit_linear(np.vander(centred, 3, increasing=True), values[near])
    return Measured.from_deviation(float(fit.coefficients[0]), float(np.sqrt(fit.covariance[0, 0])))


def peak(travel: Array, values: Array, noise: float, *, slides: bool) -> Measured:
    """Largest value of a branch, free of the upward bias of noise.

    With noise, that of a robust Legendre series whose degree (0 … 8) minimises Schwarz's criterion; else of the
    samples, and where these pass the series by more than noise, as the tip of a branch that does not slide may.
    """
    if noise <= 1e-3 * float(np.max(np.abs(values))) or len(values) < 20:
        return Measured.from_deviation(float(values.max()), noise)
    scaled = 2.0 * (travel - travel.min()) / float(np.ptp(travel)) - 1.0
    every = np.polynomial.legendre.legvander(scaled, 8)
    designs = [every[:, : degree + 1] for degree in (0, 1, 2, 3, 5, 8)]
    design = designs[best_fit(designs, values)]
    fit = fit_linear(design, values)
    smooth = design @ fit.coefficients
    top = int(np.argmax(smooth))
    if not slides and float(values.max() - smooth[top]) > BEYOND_NOISE * noise:
        return Measured.from_deviation(float(values.max()), noise)
    return Measured.from_deviation(float(smooth[top]), float(np.sqrt(design[top] @ fit.covariance @ design[top])))


def height_at(
    branches: tuple[Branch, Branch], stiffnesses_N_per_um: Sequence[float], where: float, half_window: float
) -> Measured:
    """Mean |Q| of both directions at a slip position, each pair of forces read at the same place.

    A scar's walls raise one by what they take from the other. Where the stiffness is right that lets places be told
    from displacements, the mean is alike all about: that stiffness counts which makes it so.
    """

    def read(stiffness: float) -> tuple[Array, Array]:
        positions = [slip_position(branch, stiffness) for branch in branches]
        at = np.linspace(where - half_window, where + half_window, PLACES)
        orders = [np.argsort(position) for position in positions]
        forces = [np.interp(at, p[o], b.force_N[o]) for p, o, b in zip(positions, orders, branches, strict=True)]
        return at, 0.5 * (forces[0] + forces[1])

    at, heights = min((read(stiffness) for stiffness in stiffnesses_N_per_um), key=lambda one: float(np.std(one[1])))
    return value_at(at, heights, where, half_window)


def middle_slope(plateau: Plateau) -> Measured:
    """Slope of |Q| along the travel over the middle three fifths of the plateau, in N/µm."""
    z, y = plateau.travel_um, plateau.force_N
    low, high = float(z.min()), float(z.max())
    middle = np.abs(z - 0.5 * (low + high)) <= 0.3 * (high - low)
    if np.count_nonzero(middle) < 3:
        middle = np.ones(len(z), bool)
    fit = fit_linear(np.vander(z[middle] - z[middle].mean(), 2, increasing=True), y[middle])
    return Measured.from_deviation(float(fit.coefficients[1]), float(np.sqrt(fit.covariance[1, 1])))
