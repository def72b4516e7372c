"""Preparation of a measured loop for reading: cleaned, split into branches, with its noise and drive harmonics.

The knee of a branch is where sliding begins. The stretch of correlated noise is the factor by which the correlation of
neighbouring samples raises the error of a mean of many.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from geometry.arrays import Array, ComplexArray
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.observe.local_lines import OUTLYING, ObservedBranch, force_at, knee_index
from wirewear.diagnosis.surrogate.loop_states import SINE, FastMotion
from wirewear.loops import LoopError
from wirewear.loops.branches import Branch, split_branches, upright
from wirewear.loops.cleaning import VARIES, CleanLoop, clean_loop
from wirewear.loops.drive import even_period, period_of, series
from wirewear.loops.noise import (
    correlated_noise,
    correlation_of,
    correlation_of_neighbours,
    median_in_steps,
    noise_of_neighbours,
    rounding_noise,
    step_of,
    stretch_of,
)
from wirewear.loops.sensor import enclosed_area
from wirewear.records import MeasuredLoop
from wirewear.records.tables import Noise

_OF_MOTION_OF_LOOPS = constants("observe.measured_loops.motion_of_loops")

#: Harmonics of a loop's displacement that are used at most, and samples for each.
MOST_HARMONICS, SAMPLES_A_HARMONIC = (
    _OF_MOTION_OF_LOOPS.count("most_harmonics"),
    _OF_MOTION_OF_LOOPS.count("samples_a_harmonic"),
)


_KNOWN = constants("observe.measured_loops")

#: Half-widths of the local fits' windows, as such shares.
POSITION_WINDOW, FORCE_WINDOW = _KNOWN.each("position_window", "force_window")

#: A branch begins at the largest force among so many samples at the end of the other one.
LAST_SAMPLES = _KNOWN.count("last_samples")

#: Forces within this share of the amplitude are those at mid-stroke; later than that share no knee may come; a branch
#: has at least so many samples.
MIDDLE, LATEST_KNEE = _KNOWN.each("middle", "latest_knee")
FEWEST_SAMPLES = _KNOWN.count("fewest_samples")

#: Nothing is known better than this share of it.
LEAST_NOISE = _KNOWN.number("least_noise")

_OF_NOISE = constants("observe.measured_loops.noise_of_samples")

#: Neighbours that are more alike than this are a drift, not noise.
MOST_CORRELATED = constants("observe.measured_loops.noise_of_sums").number("most_correlated")

#: Least and largest degree of the curve through a sliding branch about which its noise is taken, and samples for each:
#: the walls of a deep scar bend a branch sharply near its ends.
SMOOTH_DEGREES = tuple(int(degree) for degree in _OF_NOISE.numbers("smooth_degrees"))
SAMPLES_A_DEGREE = _OF_NOISE.count("samples_a_degree")

#: Harmonics of a drive about which the noise of few displacements is taken.
DRIVE_HARMONICS = _OF_NOISE.count("drive_harmonics")


def harmonics_of(time_s: Array, period_s: float, displacement_um: Array) -> ComplexArray:
    """Complex harmonics (k,) of one cycle's displacement (n,) over the size of the first, which becomes a sine. time_s:
    (n,). period_s: duration of the cycle.
    """
    count = max(1, min(MOST_HARMONICS, time_s.size // SAMPLES_A_HARMONIC))
    turns = np.exp(2j * np.pi * np.outer(time_s / period_s, np.arange(1, count + 1)))
    design = np.column_stack([np.ones(time_s.size), turns.real, turns.imag])
    found = np.linalg.lstsq(design, displacement_um, rcond=None)[0]
    harmonics = found[1 : count + 1] - 1j * found[count + 1 :]
    order = np.arange(1, count + 1)
    return np.asarray(harmonics * np.exp(-1j * order * (np.angle(harmonics[0]) + 0.5 * np.pi)) / np.abs(harmonics[0]))


def motion_of(loops: Sequence[ComplexArray], noise: float) -> FastMotion:
    """Common motion of a drive: median of the harmonics (k,) of several loops; a sine if there are none.

    noise: standard deviation of one harmonic of one loop. Harmonics within their noise are dropped; a median scatters
    by √(π/2) more than the mean.
    """
    if not loops:
        return SINE
    count = min(one.size for one in loops)
    stacked = np.stack([one[:count] for one in loops])
    common = np.median(stacked.real, axis=0) + 1j * np.median(stacked.imag, axis=0)
    common[1:] *= np.abs(common[1:]) > OUTLYING * noise * np.sqrt(0.5 * np.pi / len(loops))
    return FastMotion(np.asarray(common[: int(np.flatnonzero(common)[-1]) + 1]))


@dataclass(frozen=True, eq=False)
class ReducedLoop:
    """Measured loop as two branches, with its noise. Displacements are counted from the middle between both tips.

    branches: towards +x, then −x. mid_force_N: force at mid-stroke in each branch's direction, mean of both; in partial
    slip half the range of the force. displacement_noise_um, sample_noise_N: of one sample. force_noise_N: that of the
    force as it counts for means of correlated samples. normal_N, normal_error_N: mean normal force of each branch while
    sliding, and its error; None and NaN if not measured. harmonics: (k,) complex, of the displacement, see
    `harmonics_of`.
    """

    repeat: int
    cycle: int
    branches: tuple[ObservedBranch, ObservedBranch]
    amplitude_um: float
    amplitude_error_um: float
    mid_force_N: float
    displacement_noise_um: float
    force_noise_N: float
    sample_noise_N: float
    normal_N: tuple[float, float] | None
    normal_error_N: float
    harmonics: ComplexArray
    sticks: bool = False  #: True if the loop is in partial slip.
    force_step_N: float = 0.0  #: In which the force is written.

    @property
    def correlation(self) -> float:
        """Correlation of the force noise of neighbouring samples."""
        return correlation_of(self.force_noise_N / self.sample_noise_N)

    @property
    def energy_mJ(self) -> float:
        x = np.concatenate([branch.sign * branch.displacement_um for branch in self.branches])
        q = np.concatenate([branch.sign * branch.force_N for branch in self.branches])
        return 1e-3 * abs(enclosed_area(x, q))

    @property
    def half_width_um(self) -> float:
        """Half of the loop's width at zero force, in µm."""
        crossings = [
            float(np.interp(0.0, np.maximum.accumulate(branch.force_N[: branch.knee + 1]),
                            branch.displacement_um[: branch.knee + 1]))
            for branch in self.branches
        ]  # fmt: skip
        return -0.5 * sum(crossings)


def reduced_loop(measured: MeasuredLoop, stated: Noise, normal_load_N: float) -> ReducedLoop:
    """A measured loop split into branches, with its noise from its samples or, where they are few, as stated.

    stated: noise of one sample. normal_load_N: stands in for a normal force that was not measured. Raises LoopError if
    the loop cannot be read, or slides as a whole only at the ends of its stroke.
    """
    loop = measured.complete
    clean = clean_loop(loop.displacement_um, loop.tangential_force_N, loop.normal_force_N, time_s=loop.time_s)
    middle = 0.5 * (clean.displacement_um.max() + clean.displacement_um.min())
    amplitude = 0.5 * float(np.ptp(clean.displacement_um))
    halves = split_branches(upright(clean))
    branches = [
        _branch(clean, half, other, middle, amplitude, loop.normal_force_N)
        for half, other in zip(halves, halves[::-1], strict=True)
    ]
    lines = [force_at(branch, 0.0, 2.0 * POSITION_WINDOW * amplitude) for branch in branches]
    mid = float(np.mean([np.nan if line is None else line.value for line in lines]))
    shown, sticks = [branch.knee for branch in branches], False
    if not mid > 0.0 or any(branch.knee_um > LATEST_KNEE * amplitude for branch in branches):
        if loop.figures(normal_load_N).regime == "gross slip":
            raise LoopError("it slides as a whole over a small part of the stroke alone, which hides how.")
        # All samples before the largest force count as sticking.
        branches = [replace(branch, knee=int(np.argmax(branch.force_N))) for branch in branches]
        mid = 0.5 * float(np.ptp(clean.force_N))
        # The later half stands for what slides.
        shown, sticks = [branch.force_N.size // 2 for branch in branches], True
    pairs = [*zip(branches, shown, strict=True)]
    normal = [branch.normal_N[first:] for branch, first in pairs if branch.normal_N is not None]
    sliding = [(branch.displacement_um[first:], branch.force_N[first:]) for branch, first in pairs]
    step_um, step_N = (step_of(values) for values in (loop.displacement_um, loop.tangential_force_N))
    rounding_um, rounding_N = rounding_noise(step_um), rounding_noise(step_N)
    noise, stretch, normal_noise = _noise_of_samples(sliding, normal, clean, stated, rounding_N)
    correlated = noise_of_neighbours(correlation_of(stretch))
    # Rounding is like none of its neighbours.
    under = float(np.sqrt(max(clean.raw_noise_um**2 - rounding_um**2, 0.0)))
    noise_x = max(float(np.hypot(under * correlated, rounding_um)), LEAST_NOISE * amplitude)
    noise_q = max(noise, LEAST_NOISE * mid)
    error = clean.amplitude_noise_um * correlated * stretch if clean.smoothed else noise_x
    means, normal_error = _normal(normal, normal_noise, stretch)
    if means is not None and (sticks or any(load_varies(branch.normal_N) for branch in branches)):
        loads = [(own.displacement_um, own.normal_N) for own in branches if own.normal_N is not None]
        one, other = (mean_load(*own, late=sticks) for own in loads)
        means = float(one), float(other)
    return ReducedLoop(
        repeat=loop.repeat,
        cycle=loop.cycle,
        branches=(branches[0], branches[1]),
        amplitude_um=amplitude,
        amplitude_error_um=max(error, LEAST_NOISE * amplitude),
        mid_force_N=mid,
        displacement_noise_um=noise_x,
        force_noise_N=noise_q * stretch,
        sample_noise_N=noise_q,
        normal_N=means,
        normal_error_N=normal_error,
        sticks=sticks,
        force_step_N=step_N,
        harmonics=harmonics_of(clean.time, period_of(clean.time, clean.raw_displacement_um), clean.raw_displacement_um),
    )


def common_motion(loops: Sequence[ReducedLoop]) -> FastMotion:
    """Motion of the drive over a cycle by the harmonics of these loops; a sine if there are none, or noise explains all
    but the first harmonic.
    """
    if not loops:
        return SINE
    samples, noise = (
        float(np.median(found))
        for found in (
            [sum(branch.force_N.size for branch in loop.branches) for loop in loops],
            [stretch_of(loop.correlation) * loop.displacement_noise_um / loop.amplitude_um for loop in loops],
        )
    )
    harmonics = [loop.harmonics for loop in loops]
    free = samples - 2.0 * min(one.size for one in harmonics) - 1.0
    return motion_of(harmonics, noise * float(np.sqrt(2.0 / free)))


def of_one_recorder(loops: list[ReducedLoop]) -> list[ReducedLoop]:
    """Copies of the loops that all have the median of their noise, as one recorder took them."""
    force, sample, displacement = (
        float(np.median([getattr(loop, name) for loop in loops]))
        for name in ("force_noise_N", "sample_noise_N", "displacement_noise_um")
    )
    return [
        replace(loop, force_noise_N=force, sample_noise_N=sample, displacement_noise_um=displacement) for loop in loops
    ]


def _branch(
    clean: CleanLoop, branch: Branch, other: Branch, middle: float, amplitude: float, normal_N: Array | None
) -> ObservedBranch:
    sign = int(branch.direction)
    order = np.argsort(clean.index)
    order = order[np.searchsorted(clean.index, branch.samples, sorter=order)]
    x, q = sign * (clean.raw_displacement_um[order] - middle), branch.force_N
    if q.size < FEWEST_SAMPLES:
        raise LoopError(f"one of its branches has fewer than {FEWEST_SAMPLES} samples.")
    # Of a channel that comes late the last samples may have fallen already.
    reversal = -float(other.force_N[-LAST_SAMPLES:].max())
    knee = knee_index(branch.travel_um, q, float(np.median(q[np.abs(x) < MIDDLE * amplitude])), amplitude, reversal)
    return ObservedBranch(sign, x, q, knee, None if normal_N is None else normal_N[branch.samples], reversal)


def load_varies(load_N: Array | None) -> bool:
    """True if the normal force varies along one of some branches (..., n) by more than walls of scars make it."""
    return load_N is not None and bool((np.ptp(load_N, axis=-1) > 2.0 * VARIES * load_N.mean(axis=-1)).any())


def mean_load(displacement_um: Array, load_N: Array, *, late: bool = False) -> Array:
    """Mean normal force (...) over the displacement of branches (..., n), wherever they slide; late: over its later
    half.
    """
    share = displacement_um - displacement_um[..., :1]
    share = share / share[..., -1:]
    return np.asarray(np.trapezoid(load_N, np.maximum(2.0 * share - 1.0, 0.0) if late else share, axis=-1))


def _normal(sliding: list[Array], noise_N: float | None, stretch: float) -> tuple[tuple[float, float] | None, float]:
    """Mean normal force of both branches while sliding, and its error in N; None and NaN if not measured."""
    if not sliding:
        return None, np.nan
    means = []
    for values in sliding:
        centre, spread = _usual(values)
        means.append(float(values[np.abs(values - centre) < OUTLYING * spread].mean()))
    noise = spread if noise_N is None else noise_N
    return (means[0], means[1]), float(stretch * noise / np.sqrt(values.size) + LEAST_NOISE * abs(means[0]))


def _noise_of_samples(
    sliding: Sequence[tuple[Array, Array]],
    normal_N: Sequence[Array],
    clean: CleanLoop,
    stated: Noise,
    rounding_N: float,
) -> tuple[float, float, float | None]:
    """Noise of one force sample in N, its stretch by correlation in means, and the normal force's noise in N (or None).

    sliding: displacements and forces of the branches past their knees.  normal_N: normal forces there.
    rounding_N: noise that the force's steps add. If samples are too few to separate noise from shape, the correlation
    is taken from the normal force, or from the displacement about a smooth drive, or from the stated noise.
    """
    if (known := _force_noise(sliding, stated, rounding_N)) is not None:
        return *known, None
    own = clean.force_noise_N if stated.tangential_force_N is None else stated.tangential_force_N
    if (other := _noise_of_another(normal_N, clean, stated)) is not None:
        return own, other[1], other[0]
    if not stated.displacement_um or not clean.raw_noise_um:
        return own, 1.0, None
    # Correlated neighbours lie nearer to each other than the noise of a sample.
    alike = correlation_of_neighbours(stated.displacement_um / clean.raw_noise_um, MOST_CORRELATED)
    return own, stretch_of(alike), None


def _usual(values: Array) -> tuple[float, float]:
    """Median of values, and their robust standard deviation about it, at least what their steps add."""
    centre = median_in_steps(values)
    spread = 1.4826 * median_in_steps(np.abs(values - centre))
    return centre, max(spread, rounding_noise(step_of(values))) + 1e-12


def _force_noise(
    sliding: Sequence[tuple[Array, Array]], stated: Noise, rounding_N: float
) -> tuple[float, float] | None:
    """Noise of sliding forces in N about a smooth curve, and its stretch by correlation in means; None if too few
    samples.
    """
    parts: list[tuple[Array, Array]] = []
    for x, q in sliding:
        degree = min(x.size // SAMPLES_A_DEGREE, SMOOTH_DEGREES[1])
        if degree < SMOOTH_DEGREES[0]:
            return None
        place = 2.0 * (x - x.min()) / max(float(np.ptp(x)), 1e-12) - 1.0
        design = np.polynomial.chebyshev.chebvander(place, degree)
        rest = q - design @ np.linalg.lstsq(design, q, rcond=None)[0]
        spread = max(1.4826 * float(np.median(np.abs(rest))), rounding_N)
        parts.append((design, np.clip(rest, -OUTLYING * spread, OUTLYING * spread)))
    return correlated_noise(parts, stated.tangential_force_N, rounding_N)


def _noise_of_another(normal_N: Sequence[Array], clean: CleanLoop, stated: Noise) -> tuple[float, float] | None:
    """Noise and its stretch by correlation in another channel: the normal force, or else the displacement about its
    drive.

    None if there is no normal force and no smooth drive explains the displacement.
    """
    parts: list[tuple[Array, Array]] = []
    for values in normal_N:
        centre, spread = _usual(values)
        design = np.stack([np.ones(values.size), np.linspace(-1.0, 1.0, values.size)], axis=1)
        parts.append((design, np.clip(values, centre - OUTLYING * spread, centre + OUTLYING * spread)))
    if parts:
        return correlated_noise(parts, stated.normal_force_N)
    if not clean.smoothed:
        return None
    design = series(clean.time, even_period(clean.time), DRIVE_HARMONICS)
    return correlated_noise([(design, clean.raw_displacement_um)], stated.displacement_um)
