"""What the reduction to observables takes away: structure that sliding branches have at full sampling.

Residual forces of the best explanation, less a smooth curve along each branch, hold nothing but noise if nothing is
left. A ripple that stays at its place adds up over loops and branches; hum of the mains does so at its frequency in
time, with another phase in every loop. The null is the noise's own correlation, that of a first-order autoregression,
whose periodogram is exponentially distributed (Priestley, Spectral Analysis and Time Series, 1981, section 6.1).
"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import gamma

from geometry.arrays import Array
from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.infer.weighing import log_surprise
from wirewear.diagnosis.model.forward import simulate
from wirewear.diagnosis.model.readings import still_to_come
from wirewear.diagnosis.model.setup import Setup
from wirewear.diagnosis.model.wear_states import WearStates
from wirewear.diagnosis.observe.measured_loops import ReducedLoop
from wirewear.diagnosis.observe.plateau import PAST_KNEE

_KNOWN = constants("infer.full_sampling")

#: Samples that a sliding branch has at least, and degree of the smooth curve that is taken from it.
FEWEST_SAMPLES, DEGREE = _KNOWN.count("fewest_samples"), _KNOWN.count("degree")

#: Waves are tried with this many samples a length at least; half a length apart in phase over the branch.
SAMPLES_A_WAVE = _KNOWN.number("samples_a_wave")

#: A ripple stands out that chance would make so seldom, and that is so large a share of the plateau force: surfaces of
#: a mesh leave smaller ones.
LEAST_P, LEAST_SHARE = _KNOWN.each("least_p", "least_share")


@dataclass(frozen=True)
class Ripple:
    """A wave in the force of sliding branches.

    Attributes:
        along: "stroke" if it stays at its place, "time" if it runs on from loop to loop.
        amplitude_N: of it.
        length: wavelength in µm along the stroke, or frequency in Hz in time.
        p_value: the chance of one as strong at any length.
    """

    along: str
    amplitude_N: float
    length: float
    p_value: float

    @property
    def log_surprise(self) -> float:
        """How much it says for something else being at work."""
        return log_surprise(self.p_value)


@dataclass(frozen=True, eq=False)
class _Rest:
    """Residuals (m,) of one sliding branch in units of white noise, at places fixed to the rig, one sample apart."""

    place_um: Array
    deviates: Array
    design: Array
    unit_N: float
    correlation: float


def ripple(states: WearStates, setup: Setup, loops: tuple[ReducedLoop, ...]) -> Ripple | None:
    """A ripple beside an explanation that chance would not make, along the stroke or in time, whichever is higher."""
    if not loops:
        return None
    cycles = np.unique([loop.cycle for loop in loops]).astype(float)
    course = simulate(states, setup, cycles)
    rests = [rest for loop in loops for rest in _rests(loop, course.displacement_um, course.tangential_force_N, cycles)]
    if not rests:
        return None
    samples = np.median([sum(branch.force_N.size for branch in loop.branches) for loop in loops])
    found = [_along_stroke(rests, setup), _in_time(rests, float(samples) * setup.frequency_Hz)]
    # A strong wave of one kind leaves a weaker one in the other.
    strongest = max(found, key=lambda one: one.amplitude_N if one.p_value < LEAST_P else 0.0)
    seen = strongest.p_value < LEAST_P and strongest.amplitude_N > LEAST_SHARE * setup.plateau_force_N
    return strongest if seen else None


def _rests(loop: ReducedLoop, x: Array, q: Array, cycles: Array) -> list[_Rest]:
    row = int(np.searchsorted(cycles, loop.cycle))
    rests = []
    for side, branch in enumerate(loop.branches):
        slides = branch.displacement_um > branch.knee_um + PAST_KNEE * loop.amplitude_um
        slides[: branch.knee + 1] = False
        # A reading that leans against the force goes on outwards while the contact sticks again.
        slides &= branch.displacement_um <= branch.sign * x[row, side, -1]
        y, force = branch.displacement_um[slides], branch.force_N[slides]
        if y.size < FEWEST_SAMPLES:
            continue
        model = np.interp(y, still_to_come(branch.sign * x[row, side]), branch.sign * q[row, side])
        at = 2.0 * (y - y.min()) / max(float(np.ptp(y)), 1e-9) - 1.0
        design = np.linalg.qr(np.polynomial.chebyshev.chebvander(at, DEGREE))[0]
        rest = force - model
        rest = rest - design @ (design.T @ rest)
        spread = 1.4826 * float(np.median(np.abs(rest))) + 1e-12
        # Outliers are no ripples.
        rest = np.clip(rest, -4.0 * spread, 4.0 * spread)
        unit = float(rest.std() * np.sqrt(rest.size / (rest.size - DEGREE - 1.0)))
        rests.append(_Rest(branch.sign * y, rest / unit, design, unit, loop.correlation))
    return rests


def _along_stroke(rests: list[_Rest], setup: Setup) -> Ripple:
    """The strongest wave at fixed places, of friction (turning with the direction) or of force."""
    stroke = 2.0 * setup.amplitude_um
    spacing = float(np.median([np.ptp(rest.place_um) / rest.place_um.size for rest in rests]))
    shortest = SAMPLES_A_WAVE * spacing
    # Below the degree of the smooth curve nothing is left.
    waves = np.arange(0.5 * DEGREE, stroke / shortest, 0.5)
    if waves.size == 0:
        return Ripple("stroke", 0.0, stroke, 1.0)
    # Each branch towards +x and towards −x has a sum of its own: two waves of any amplitude and phase.
    squares, amplitude2 = np.zeros(waves.size), np.zeros(waves.size)
    for sign in (1, -1):
        own = [rest for rest in rests if (rest.place_um[-1] > rest.place_um[0]) == (sign > 0)]
        if not own:
            continue
        total, power = np.zeros(waves.size, dtype=complex), np.zeros(waves.size)
        height, count = np.zeros(waves.size, dtype=complex), 0.0
        for rest in own:
            wave = np.exp(-2j * np.pi * waves[:, None] * rest.place_um / stroke)
            kept = wave - (wave @ rest.design) @ rest.design.T
            total += kept @ rest.deviates
            # Correlated neighbours: the lowest frequencies are the noisiest, and no wave is noisier than that.
            power += _power(rest.correlation, waves / rest.place_um.size) * (np.abs(kept) ** 2).sum(axis=1)
            height += rest.unit_N * (kept @ rest.deviates)
            count += rest.place_um.size
        squares += np.abs(total) ** 2 / np.maximum(power, 1e-12)
        amplitude2 += np.abs(2.0 * height / count) ** 2
    best = int(np.argmax(squares))
    chance = float(gamma.sf(squares[best], 2.0))
    p_value = min(1.0, waves.size * chance)
    return Ripple("stroke", float(np.sqrt(0.5 * amplitude2[best])), float(stroke / waves[best]), p_value)


def _in_time(rests: list[_Rest], sampled_Hz: float) -> Ripple:
    """The strongest wave of one frequency in time, of any phase in each branch."""
    size = int(np.median([rest.deviates.size for rest in rests]))
    share = np.arange(0.5 * DEGREE, size / SAMPLES_A_WAVE, 0.5) / size
    if share.size == 0:
        return Ripple("time", 0.0, 0.0, 1.0)
    squares, amplitude2 = np.zeros(share.size), np.zeros(share.size)
    for rest in rests:
        wave = np.exp(-2j * np.pi * share[:, None] * np.arange(rest.deviates.size))
        kept = wave - (wave @ rest.design) @ rest.design.T
        sums = kept @ rest.deviates
        squares += np.abs(sums) ** 2 / (_power(rest.correlation, share) * (np.abs(kept) ** 2).sum(axis=1))
        amplitude2 += np.abs(2.0 * rest.unit_N * sums / rest.deviates.size) ** 2 / len(rests)
    best = int(np.argmax(squares))
    p_value = min(1.0, share.size * float(gamma.sf(squares[best], len(rests))))
    return Ripple("time", float(np.sqrt(amplitude2[best])), float(share[best]) * sampled_Hz, p_value)


def _power(correlation: float, share: Array) -> Array:
    """Spectrum of a first-order autoregression of unit variance at frequencies (k,) a sample."""
    spectrum: Array = (1.0 - correlation**2) / (1.0 - 2.0 * correlation * np.cos(2.0 * np.pi * share) + correlation**2)
    return spectrum
