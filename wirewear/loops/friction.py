"""Friction of one loop: its largest ratio of forces, and the value at mid-slip that the scar's shape does not change.

The slip position x = δ − Q/K is the displacement less the elastic yielding of bodies and rig; mid-slip is the middle of
its range. A plateau is the part of a branch that slides; a hook is the rise of its force towards the end of the stroke,
where the contact runs up the wall (slope) of its scar.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Array, BoolArray
from wirewear.loops.branches import Branch, MicroSlip, slides_visibly
from wirewear.loops.cleaning import FEWEST_SAMPLES, CleanLoop
from wirewear.loops.figures import Measured, mean_of
from wirewear.loops.noise import sample_noise, step_of
from wirewear.loops.robust import LinearFit, best_fit, fit_linear
from wirewear.loops.stick_slip import FittedBranch

MIDDLE_SHARE = 0.4

INNER_SHARE = 0.75  #: Of the range of slip, that whose samples give friction.

PLACES = 41  #: Places at which both directions are read: about as many as a loop of 200 samples has there.

#: So many noises above what is fitted to a branch, a sample is no chance: outliers have been left out.
BEYOND_NOISE = 5.0

#: A drive goes back where the mean of so many samples falls behind by so many noises and steps, and that share of the
#: way.
SAMPLES_OF_MEAN, BEHIND_NOISES, BEHIND_STEPS, BEHIND_SHARE = 5, 4.0, 1.5, 0.002


@dataclass(frozen=True)
class Plateau:
    """The n samples of one branch at which the contact slides; all (n,)."""

    slip_position_um: Array  #: Displacement less the elastic yielding of bodies and rig, see `slip_position`.
    travel_um: Array  #: Displacement since the reversal, positive.
    force_N: Array  #: Magnitude of the tangential force.
    ratio: Array  #: Tangential over normal force, or the former in N if no normal force is known.
    samples: NDArray[np.intp]  #: Positions in the input.


def slip_position(branch: Branch, stiffness_N_per_um: float) -> Array:
    """Slip position x = δ − Q/K in µm of a branch's samples, (n,): displacement less the elastic yielding of bodies and
    rig, of stiffness K.
    """
    displacement = branch.origin_um + branch.direction * branch.travel_um
    position: Array = displacement - branch.direction * branch.force_N / stiffness_N_per_um
    return position


def sliding_part(branch: Branch, slip: MicroSlip, stiffness_N_per_um: float) -> Plateau:
    """Samples of a branch at travels beyond the onset of gross slip that `slip`, its fit, shows. stiffness_N_per_um: K
    of bodies and rig, for the slip positions.
    """
    slides = branch.travel_um > slip.travel_um
    position = slip_position(branch, stiffness_N_per_um)[slides]
    return Plateau(
        position, branch.travel_um[slides], branch.force_N[slides], force_ratio(branch)[slides], branch.samples[slides]
    )


def advancing(branch: Branch) -> Branch:
    """The branch without the samples at which the drive goes back, and on until it has come as far again: where the
    mean of five travels falls behind by 4 noises, 1.5 steps and 0.2 % of the branch. Unchanged if 16 samples would not
    be left.

    A ripple of the drive unloads the contact, which sticks there.
    """
    travel, pad = branch.travel_um, SAMPLES_OF_MEAN // 2
    if travel.size < FEWEST_SAMPLES:
        return branch
    mean = np.convolve(np.pad(travel, pad, mode="edge"), np.full(SAMPLES_OF_MEAN, 1.0 / SAMPLES_OF_MEAN), "valid")
    behind = np.maximum.accumulate(mean) - mean
    noise = sample_noise(travel, np.arange(travel.size, dtype=float))
    least = max(BEHIND_NOISES * noise, BEHIND_STEPS * step_of(travel), BEHIND_SHARE * branch.length_um)
    runs = np.cumsum(behind == 0.0)
    deepest = np.zeros(int(runs[-1]) + 1)
    np.maximum.at(deepest, runs, behind)
    advances = (behind == 0.0) | (deepest[runs] <= least)
    if advances.all() or np.count_nonzero(advances) < FEWEST_SAMPLES:
        return branch
    normal = None if branch.normal_force_N is None else branch.normal_force_N[advances]
    return replace(
        branch,
        travel_um=travel[advances],
        force_N=branch.force_N[advances],
        normal_force_N=normal,
        samples=branch.samples[advances],
    )


def force_ratio(branch: Branch) -> Array:
    """Ratio |Q|/P (n,) of a branch's samples, or |Q| in N if the normal force is unknown."""
    return branch.force_N if branch.normal_force_N is None else branch.force_N / branch.normal_force_N


def value_at(position: Array, values: Array, where: float, half_window: float) -> Measured:
    """Value at the slip position `where`, of values (n,) at positions (n,) in µm: by a robust parabola over ±
    half_window µm, or by interpolation, then without uncertainty, if fewer than 5 samples lie there.
    """
    near = np.abs(position - where) <= half_window
    if np.count_nonzero(near) < 5:
        order = np.argsort(position)
        return Measured.from_deviation(float(np.interp(where, position[order], values[order])), 0.0)
    centred = (position[near] - where) / half_window
    fit = fit_linear(np.vander(centred, 3, increasing=True), values[near])
    return Measured.from_deviation(float(fit.coefficients[0]), float(np.sqrt(fit.covariance[0, 0])))


def peak(travel: Array, values: Array, noise: float, *, slides: bool) -> Measured:
    """Largest of a branch's values (n,) at travels (n,), without the upward bias of noise.

    With noise it is the top of a robust Legendre series whose degree (0 to 8) minimises Schwarz's criterion. Without
    noise, with fewer than 20 samples, or where the tip of a branch that does not slide exceeds the series by five
    noises, it is the largest sample. noise: standard deviation of one value. slides: True if the branch has a plateau.
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
    """Mean |Q| of both directions in N at the slip position `where` (µm), from a window of ± half_window µm; both
    forces are read at equal slip positions.

    A scar's walls raise one direction's force as much as they lower the other's. Slip positions use the one of the
    given stiffnesses K for which the mean varies least over the window.
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


@dataclass(frozen=True)
class SlidingFigures:
    """Figures that only a sliding loop has, named as in `LoopFigures`; height_N: mean |Q| of both directions at
    mid-slip. None where they are not known. samples: those of the input that gave friction.
    """

    height_N: Measured | None = None
    friction: Measured | None = None
    slope: Measured | None = None
    hook: Measured | None = None
    asymmetry: Measured | None = None
    forward: Measured | None = None
    backward: Measured | None = None
    samples: tuple[int, ...] = ()


def peaks(loop: CleanLoop, forward: FittedBranch, backward: FittedBranch) -> tuple[Measured, Measured]:
    """Largest |Q|/P of the forward and of the backward branch, or largest |Q| without a normal force."""
    return _peak(loop, *forward), _peak(loop, *backward)


def largest_ratio(loop: CleanLoop, tops: tuple[Measured, Measured], *, slides: bool) -> Measured | None:
    """Largest |Q|/P of the cycle; None without a normal force.

    It is the larger of `tops`, the peaks of both directions. In partial slip (not `slides`) under a changing normal
    force, |Q|/P may be larger just after a reversal; then the largest sample counts.
    """
    if loop.normal_force_N is None:
        return None
    found = max(tops, key=lambda figure: figure.value)
    own, noise = float(np.max(np.abs(loop.force_N) / loop.normal_force_N)), _ratio_noise(loop)
    passed = not slides and own - found.value > BEYOND_NOISE * noise
    return Measured.from_deviation(own, noise) if passed else found


def _ratio_noise(loop: CleanLoop) -> float:
    return loop.force_noise_N / (1.0 if loop.normal_force_N is None else float(np.median(loop.normal_force_N)))


def _peak(loop: CleanLoop, branch: Branch, slip: MicroSlip) -> Measured:
    slides = slides_visibly((branch, slip))
    branch = advancing(branch) if slides else branch
    part = branch.travel_um > (slip.travel_um if slides else 0.0)
    return peak(branch.travel_um[part], force_ratio(branch)[part], _ratio_noise(loop), slides=slides)


def sliding_figures(
    loop: CleanLoop,
    fitted: tuple[FittedBranch, FittedBranch],
    tops: tuple[Measured, Measured],
    stiffness_N_per_um: float,
) -> SlidingFigures:
    """Plateau slope, hooks, asymmetry and (with a normal force) geometry-independent friction of a sliding loop; all
    None if its force does not resist the motion both ways.

    fitted: branches (forward, backward) with their fits. tops: largest |Q|/P of each (largest |Q| without a normal
    force). stiffness_N_per_um: K of bodies and rig while the contact slides.
    """
    branches = advancing(fitted[0][0]), advancing(fitted[1][0])
    plateaus = (
        sliding_part(branches[0], fitted[0][1], stiffness_N_per_um),
        sliding_part(branches[1], fitted[1][1], stiffness_N_per_um),
    )
    # Ends of the slip are taken where outliers and noise do not reach.
    every = np.concatenate([plateau.slip_position_um for plateau in plateaus])
    low, high = np.percentile(every, [1, 99]).tolist()
    middle, half_range = 0.5 * (low + high), 0.5 * (high - low)
    centres = [value_at(part.slip_position_um, part.ratio, middle, MIDDLE_SHARE * half_range) for part in plateaus]
    total = centres[0].value + centres[1].value
    if total <= 0.0 or not all(centre.value for centre in centres):
        # What does not resist the motion on both ways has no plateaus to compare.
        return SlidingFigures()
    slopes = [middle_slope(part) for part in plateaus]
    hooks = [top.over(centre) for top, centre in zip(tops, centres, strict=True)]
    load = 1.0 if loop.normal_force_N is None else float(np.mean(loop.normal_force_N))
    near = [np.abs(part.slip_position_um - middle) <= INNER_SHARE * half_range for part in plateaus]
    friction = _geometry_independent(loop, plateaus, near, (middle, half_range), stiffness_N_per_um)
    doubt = load * mean_of(*centres).deviation
    height = height_at(branches, (stiffness_N_per_um, np.inf), middle, MIDDLE_SHARE * half_range)
    return SlidingFigures(
        height_N=Measured.from_deviation(height.value, doubt),
        # Whether a tilt or the sensor's zero makes both directions unlike, a loop does not tell.
        friction=None if friction is None else friction.reaching(0.5 * total),
        slope=mean_of(*slopes),
        hook=mean_of(*hooks),
        asymmetry=Measured.from_deviation(
            (centres[0].value - centres[1].value) / total,
            float(np.hypot(centres[0].deviation, centres[1].deviation)) / total,
        ),
        forward=None if loop.normal_force_N is None else centres[0],
        backward=None if loop.normal_force_N is None else centres[1],
        samples=()
        if friction is None
        else tuple(np.concatenate([one.samples[own] for one, own in zip(plateaus, near, strict=True)]).tolist()),
    )


def _geometry_independent(
    loop: CleanLoop,
    plateaus: tuple[Plateau, Plateau],
    near: list[BoolArray],
    slip_range_um: tuple[float, float],
    stiffness_N_per_um: float,
) -> Measured | None:
    """Return tan φ at mid-slip, from one fit to the friction angles of both directions over the inner slip range.

    near: samples of either plateau that lie there. slip_range_um: middle and half of the range.

    Both share φ, straight in x; the scar's slope θ, of either sign, is a polynomial in x whose degree minimises
    Schwarz's criterion. Sharing keeps the walls of the scar out of φ and halves its scatter. The stiffness is known to
    5 % only, so both directions may be shifted against each other: where there are walls, they tell.
    """
    if loop.normal_force_N is None:
        return None
    middle, half_range = slip_range_um
    if min(int(np.count_nonzero(inside)) for inside in near) < 5:
        return None
    ratio = np.concatenate([part.ratio[inside] for part, inside in zip(plateaus, near, strict=True)])
    position = np.concatenate([part.slip_position_um[inside] for part, inside in zip(plateaus, near, strict=True)])
    sign = np.repeat([1.0, -1.0], [int(np.count_nonzero(inside)) for inside in near])
    force = float(np.mean(np.concatenate([part.force_N for part in plateaus])))
    likely_shift = 0.05 * abs(force) / stiffness_N_per_um / half_range
    fit = _friction_angle(np.arctan(ratio), (position - middle) / half_range, sign, likely_shift)
    friction = float(np.tan(fit.coefficients[0]))
    deviation = (1.0 + friction**2) * float(np.sqrt(fit.covariance[0, 0]))
    load_share = loop.normal_noise_N / float(np.mean(loop.normal_force_N))
    return Measured.from_deviation(friction, float(np.hypot(deviation, friction * load_share)))


def _friction_angle(angle: Array, x: Array, sign: Array, likely_shift: float) -> LinearFit:
    """Fit φ0 + φ1 x ± θ(x ∓ ε) to the angles atan(Q/P) in rad (n,) of both directions; φ0 is the first coefficient.

    θ, the wall's angle, is a polynomial; ε shifts it against the positions. x: positions (n,) from mid-slip over the
    half range, as ε. sign: +1 or −1 by direction (n,). likely_shift: standard deviation of ε.
    """
    powers = min(7, len(x) // 6) + 1
    even = np.vander(x, 2, increasing=True)
    odd = np.vander(x, powers, increasing=True) * sign[:, None]
    degrees = [degree for degree in (0, 1, 3, 5, 7) if degree < powers]
    designs = [np.column_stack([even, odd[:, : degree + 1]]) for degree in degrees]
    degree = degrees[best_fit(designs, angle)]
    fit = fit_linear(designs[degrees.index(degree)], angle)
    shift = 0.0
    for _ in range(3 if likely_shift > 0.0 and degree > 0 else 0):
        at = x - sign * shift
        theta = np.polynomial.Polynomial(fit.coefficients[2 : degree + 3])
        slope = theta.deriv()(at)
        design = np.column_stack([even, np.vander(at, degree + 1, increasing=True) * sign[:, None], -slope])
        # One more "sample" says what is expected of the shift before.
        doubt = max(fit.scale, 1e-12) / likely_shift
        belief = np.append(np.zeros(design.shape[1] - 1), doubt)
        fit = fit_linear(np.vstack([design, belief]), np.append(angle, -doubt * shift))
        shift += float(fit.coefficients[-1])
    return fit
