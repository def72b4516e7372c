"""Shapes of distortions that pass in time: what a channel does to a loop by its answer to what went before.

A drive passes its stroke in time as `Branches.motion` tells; a cycle is 2π long, and all channels are periodic.
"""

from collections.abc import Callable

import numpy as np

from geometry.arrays import Array
from wirewear.diagnosis.infer.shapes import Branches, Shape, loaded
from wirewear.diagnosis.model.forward import LoopCourse
from wirewear.diagnosis.model.readings import HARMONICS, Answers, at_even_phases, at_phases, filtered, phases_of

#: Answer of a filter, complex (k,), to harmonics of the drive (k,).
Answer = Callable[[Array], Answers]


def leaking(turn: float) -> Shape:
    """A force channel whose charge leaks: iωτ/(1 + iωτ), 1/(2π τ f) near `turn`; the mean force is lost, as a zero is.

    Unit size is a time constant of a cycle over 2π. Source: Bendat & Piersol, Random Data, 4th ed., section 2.3.
    """
    return _force_through(lambda k: np.where(k == 0.0, 0.0, -1.0 / (turn + 1j * np.maximum(k, 1.0))))


def ringing(harmonic: float, damping: float) -> tuple[Shape, Shape]:
    """A force channel that rings at so many times the drive's frequency, and the same a quarter of its period later.

    1/(1 − r² + 2iζr) − 1 (den Hartog, Mechanical Vibrations, section 2.9); unit size is the whole of it.
    """

    def rings(k: Array) -> Answers:
        ratio = k / harmonic
        return np.asarray(1.0 / (1.0 - ratio**2 + 2j * damping * ratio) - 1.0)

    return _force_through(rings), _force_through(lambda k: np.asarray(1j * k / harmonic * rings(k)))


def giving_late(lag: float) -> Shape:
    """A displacement channel that gives way under the force behind a first-order filter of such a phase.

    A Kelvin–Voigt joint less its spring, which the library has; unit size gives the amplitude at the plateau force.
    """

    def shape(b: Branches, size: float) -> Array:
        through = _filtered(b, b.course.tangential_force_N, lambda k: -1j * k * lag / (1.0 + 1j * k * lag))
        return size * b.amplitude_um / b.force_N * through

    return lambda b, size: b.read_with(b.course.displacement_um + shape(b, size), b.course.tangential_force_N)


def averaged(window: float) -> Shape:
    """Channels that are averaged about each sample over a share of a cycle: sin(π w k)/(π w k), without a lag."""

    def rounds(k: Array) -> Answers:
        return np.asarray(np.sinc(window * k) - 1.0, dtype=np.complex128)

    def shape(b: Branches, size: float) -> LoopCourse:
        displacement, force = b.course.displacement_um, b.course.tangential_force_N
        read = displacement + size * _filtered(b, displacement, rounds)
        return b.read_with(read, force + size * _filtered(b, force, rounds))

    return shape


def slewing(share: float) -> Shape:
    """A force channel that follows no faster than a share of the force's own fastest turn; unit size is all of it."""

    def shape(b: Branches, size: float) -> LoopCourse:
        force = b.course.tangential_force_N
        phases = phases_of(b.course.displacement_um, b.motion)
        even = at_even_phases(phases, force)
        most = share * np.abs(np.diff(even, axis=1)).max(axis=1)
        at, followed = even[:, -1], np.empty_like(even)
        for _ in range(2):  # The second cycle repeats itself.
            for i in range(even.shape[1]):
                at = np.clip(even[:, i], at - most, at + most)
                followed[:, i] = at
        return b.read_with(b.course.displacement_um, force + size * at_phases(phases, followed - even))

    return shape


def rattling(harmonic: float, fades: float) -> tuple[Shape, Shape]:
    """A load that swings at so many times the drive's frequency after each reversal, and a quarter of a swing later.

    Its swings fade within a share of a cycle, as a damped oscillator's do after a blow (den Hartog, Mechanical
    Vibrations, chapter 2).
    """

    def swinging(swing: Callable[[Array], Array]) -> Shape:
        def share(b: Branches) -> Array:
            phases = phases_of(b.course.displacement_um, b.motion)
            since = (phases - phases[:, :, :1]) % (2.0 * np.pi)
            return np.asarray(np.exp(-since / (2.0 * np.pi * fades)) * swing(harmonic * since))

        return loaded(share)

    return swinging(np.sin), swinging(np.cos)


def _force_through(answer: Answer) -> Shape:
    """A force channel that adds what a filter answers to the force."""

    def added(b: Branches, size: float) -> Array:
        force = b.course.tangential_force_N
        return np.asarray(force + size * _filtered(b, force, answer))

    return lambda b, size: b.read_with(b.course.displacement_um, added(b, size))


def _filtered(b: Branches, values: Array, answer: Answer) -> Array:
    """What a filter answers to a periodic channel (n, 2, m)."""
    return filtered(phases_of(b.course.displacement_um, b.motion), values, answer(HARMONICS))
