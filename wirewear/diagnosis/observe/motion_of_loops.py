"""The motion of a record's drive, told from what its displacement sensor reads over time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.model.motion import SINE, FastMotion
from wirewear.diagnosis.model.setup import Array

_KNOWN = constants("observe.motion_of_loops")

#: Harmonics of a loop's displacement that are told at most, and samples for each.
MOST_HARMONICS, SAMPLES_A_HARMONIC = _KNOWN.count("most_harmonics"), _KNOWN.count("samples_a_harmonic")

#: A harmonic belongs to the motion if it stands out of its noise by so many deviations: a sine stays one.
STANDING_OUT = _KNOWN.number("standing_out")


def harmonics_of(time_s: Array, period_s: float, displacement_um: Array) -> NDArray[np.complex128]:
    """Harmonics (k,) of one cycle's displacement (n,), turned so that the first is a sine's, of unit size."""
    count = max(1, min(MOST_HARMONICS, time_s.size // SAMPLES_A_HARMONIC))
    turns = np.exp(2j * np.pi * np.outer(time_s / period_s, np.arange(1, count + 1)))
    design = np.column_stack([np.ones(time_s.size), turns.real, turns.imag])
    found = np.linalg.lstsq(design, displacement_um, rcond=None)[0]
    harmonics = found[1 : count + 1] - 1j * found[count + 1 :]
    order = np.arange(1, count + 1)
    return np.asarray(harmonics * np.exp(-1j * order * (np.angle(harmonics[0]) + 0.5 * np.pi)) / np.abs(harmonics[0]))


def motion_of(loops: Sequence[NDArray[np.complex128]], noise: float) -> FastMotion:
    """The motion that the harmonics of several loops have in common; `noise` is that of one loop's harmonic.

    The median scatters by √(π/2) more than the mean.
    """
    if not loops:
        return SINE
    count = min(one.size for one in loops)
    stacked = np.stack([one[:count] for one in loops])
    common = np.median(stacked.real, axis=0) + 1j * np.median(stacked.imag, axis=0)
    common[1:] *= np.abs(common[1:]) > STANDING_OUT * noise * np.sqrt(0.5 * np.pi / len(loops))
    return FastMotion(np.asarray(common[: int(np.flatnonzero(common)[-1]) + 1]))
