"""How a drive passes its stroke in time: a lag shifts a channel in time, so what it does to a loop follows that."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Array, ComplexArray
from wirewear.diagnosis.calibration import constants

Harmonics = ComplexArray

_KNOWN = constants("model.motion")

#: Even phases at which a motion is tabulated.
_PHASES = _KNOWN.count("phases")

#: Corners are looked for in motions of so many harmonics at least, in all but the first of so many parts of them; there
#: are so many at most, none below this share of the largest.
_FEWEST, _PARTS, _MOST_CORNERS = _KNOWN.count("fewest"), _KNOWN.count("parts"), _KNOWN.count("most_corners")
_LEAST_CORNER = _KNOWN.number("least_corner")


@dataclass(frozen=True, eq=False)
class FastMotion:
    """A periodic motion by its harmonics: Re Σ c_k exp(ikφ) over a cycle of phases φ, k = 1, 2, …

    harmonics: (k,) complex.
    """

    harmonics: Harmonics

    def before(self, lag: float) -> FastMotion:
        """What moves so behind a first-order filter whose time constant is a phase, its corners sharp.

        Source: Bendat & Piersol, Random Data, 4th ed., section 2.3.
        """
        undone = self.harmonics * (1.0 + 1j * lag * self._orders)
        return FastMotion(np.concatenate([undone, _beyond(undone)]))

    def behind(self, lag: float) -> FastMotion:
        """This motion behind such a filter."""
        return FastMotion(np.asarray(self.harmonics / (1.0 + 1j * lag * self._orders)))

    def phases(self, place: Array) -> Array:
        """When places (..., 2, m) are passed, −1 and 1 being the ends of the stroke, one way and back; both increase.

        A drive that stays at an end begins the next branch when it leaves it.
        """
        bent = np.arcsin(np.clip(place, -1.0, 1.0))
        there, back = (
            np.interp(sign * bent[..., side, :], *table)
            for side, (sign, table) in enumerate(zip((1.0, -1.0), self._tables, strict=True))
        )
        return np.stack([there, back], axis=-2)

    def at(self, phase: Array) -> Array:
        """The motion at phases (...)."""
        return np.interp(phase, _even_phases(), self._even, period=2.0 * np.pi)

    @cached_property
    def half_range(self) -> float:
        """Half of its stroke."""
        return 0.5 * float(np.ptp(self._even))

    @property
    def _orders(self) -> NDArray[np.intp]:
        return np.arange(1, self.harmonics.size + 1)

    @cached_property
    def _even(self) -> Array:
        """The motion (PHASES,) at even phases."""
        return _at_even_phases(self.harmonics)

    @cached_property
    def _tables(self) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
        """Arcsines of places in the direction of travel, and their phases, one way and back."""
        even = self._even
        # An eccentric's sine is a straight line in these.
        bent = np.arcsin(np.clip((even - 0.5 * (even.max() + even.min())) / self.half_range, -1.0, 1.0))
        bottom, top = int(np.argmin(even)), int(np.argmax(even))
        top += _PHASES if top < bottom else 0
        return _table(bent, bottom, top), _table(-bent, top, bottom + _PHASES)


@cache
def _even_phases() -> Array:
    return np.asarray(2.0 * np.pi * np.arange(_PHASES) / _PHASES)


def _table(values: Array, first: int, last: int) -> tuple[Array, Array]:
    """Values that rise from one even phase to another, and these phases."""
    places = np.arange(first, last + 1)
    return np.asarray(np.maximum.accumulate(values[places % _PHASES])), np.asarray(2.0 * np.pi / _PHASES * places)


def _at_even_phases(harmonics: Harmonics, first: int = 1) -> Array:
    """Re Σ c_k exp(ikφ) of harmonics (k,), from that order on, at even phases (PHASES,)."""
    spectrum = np.zeros(_PHASES // 2 + 1, dtype=np.complex128)
    spectrum[first : first + harmonics.size] = harmonics
    return np.asarray(np.fft.irfft(0.5 * _PHASES * spectrum, _PHASES))


def _beyond(harmonics: Harmonics) -> Harmonics:
    """Harmonics that follow the known ones (k,) where the motion has corners.

    A speed that jumps by J at φ has the harmonics −J exp(−ikφ)/(π k²), which fall off slower than those of any smooth
    motion: the last ones that are known tell J and φ.
    """
    if harmonics.size < _FEWEST:
        return np.zeros(0, dtype=np.complex128)
    order = np.arange(harmonics.size // _PARTS, harmonics.size + 1)
    given = -np.pi * order**2 * harmonics[order - 1]
    places: list[float] = []
    jumps, left = np.zeros(0), given
    for _ in range(_MOST_CORNERS):
        best = int(np.argmax(np.abs(_at_even_phases(left, int(order[0])))))
        turns = np.exp(-1j * np.outer(order, [*places, _even_phases()[best]]))
        design = np.concatenate([turns.real, turns.imag])
        found = np.linalg.lstsq(design, np.concatenate([given.real, given.imag]), rcond=None)[0]
        if np.abs(found).min() < _LEAST_CORNER * np.abs(found).max():
            break
        places.append(float(_even_phases()[best]))
        jumps, left = found, given - turns @ found
    beyond = np.arange(harmonics.size + 1, _PHASES // 2)
    turns = np.exp(-1j * np.outer(beyond, places))
    return np.asarray(-(turns @ jumps) / (np.pi * beyond**2), dtype=np.complex128)


#: That of an eccentric.
SINE = FastMotion(np.array([-1j]))
