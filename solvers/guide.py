"""First guesses for the increments of a cycle from a cycle simulated before."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from solvers.contact_state import ContactState
from solvers.wear_path import Stroke

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FirstGuess:
    """Where an increment is expected to end; units as in `ContactState`."""

    holder_x: float
    overlap_area: float
    traction: Array


@dataclass(frozen=True)
class Guide:
    """What m increments of a cycle ended with.

    phase: (m,) increasing share of the cycle passed since its +amplitude, in (0, 1].  drive, holder_x: (m,), mm.
    overlap_area: (m,), mm².  traction: (m, n, 3), MPa.
    """

    phase: Array
    drive: Array
    holder_x: Array
    overlap_area: Array
    traction: Array

    def at(self, phase: float, drive: float) -> FirstGuess | None:
        """The guess for an increment that ends at a drive, on the stroke to which a phase of the cycle belongs: where
        the holder stood at that drive, and the contact recorded nearest to it. None on a stroke not recorded.
        """
        falling = self.phase <= 0.5
        own = np.flatnonzero(falling if phase <= 0.5 else ~falling)
        if not len(own):
            return None
        nearest = own[int(np.argmin(np.abs(self.drive[own] - drive)))]
        # A stroke starts where the other one ends.
        before = np.flatnonzero(~falling if phase <= 0.5 else falling)[-1:]
        along = np.concatenate([before, own])
        along = along[np.argsort(self.drive[along], kind="stable")]
        return FirstGuess(
            holder_x=float(np.interp(drive, self.drive[along], self.holder_x[along])),
            overlap_area=float(self.overlap_area[nearest]),
            traction=self.traction[nearest],
        )

    def stroke(self, side: float) -> Stroke:
        """Where the holder stood from side x amplitude on to the other end, mirrored if side is -1, as in `wear_path`.

        A stroke that was not recorded is taken to be the mirror image of the other one.
        """
        falling = self.phase <= 0.5
        own = falling if side > 0.0 else ~falling
        if own.any():
            return Stroke(side * self.drive[own], side * self.holder_x[own])
        return Stroke(-side * self.drive, -side * self.holder_x)


def guide_from(phases: Array, states: list[ContactState]) -> Guide:
    """The guide that the states at the given phases of a cycle make."""
    order = np.argsort(phases)
    return Guide(
        phase=phases[order],
        drive=np.array([states[i].drive for i in order]),
        holder_x=np.array([states[i].holder_x for i in order]),
        overlap_area=np.array([states[i].overlap_area for i in order]),
        traction=np.array([states[i].traction for i in order]),
    )
