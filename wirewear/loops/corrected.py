"""A loop with what rig and sensors do to it taken out: drift, lag, play, compliance, zero of the force."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from geometry.arrays import Array, BoolArray
from wirewear.loops.analysis import analyse_loop
from wirewear.loops.branches import Branch, split_branches
from wirewear.loops.figures import LoopFigures
from wirewear.loops.free_play import Shelf, play_of
from wirewear.loops.reading import read_loop


@dataclass(frozen=True, eq=False)
class CorrectedLoop:
    """A loop of n samples in the order of the input; NaN where a sample was left out.

    displacement_um: without drift and free play. force_N: in time, from its sensor's zero. slip_um: displacement less
    the elastic yielding Q/K of bodies, contact and rig, K the measured stiffness. used: (n,) for each figure, True for
    samples that gave it.
    """

    displacement_um: Array
    force_N: Array
    slip_um: Array
    used: Mapping[str, BoolArray]
    figures: LoopFigures
    drift_um: float  #: Range of what was taken out as drift, 0 if nothing.
    lag_samples: float  #: By which the force was read earlier.
    lean_um_per_N: float  #: Deflection of the displacement sensor by the force that was undone.
    free_play_um: float
    compliance_um_per_N: float  #: 1/K; 0 where no stiffness was measured.
    force_zero_N: float


def corrected_loop(
    displacement_um: ArrayLike,
    tangential_force_N: ArrayLike,
    normal_force_N: ArrayLike | None = None,
    *,
    time_s: ArrayLike | None = None,
    cycle: int | None = None,
) -> CorrectedLoop:
    """The corrected loop of one cycle, with its figures; arguments and errors are those of `analyse_loop`.

    Neither of the corrections changes the energy but lag and drift, as ∮Q dQ is zero, and a play is passed without
    force.
    """
    channels = displacement_um, tangential_force_N, normal_force_N
    found = analyse_loop(*channels, time_s=time_s, cycle=cycle)
    loop, fits, _, _, lag = read_loop(*channels, time_s=time_s)
    given, count = np.asarray(displacement_um, dtype=float), np.size(displacement_um)
    lean = loop.lean_um_per_N
    # What was added for a lean is no drift.
    moved = given[loop.index] - (loop.raw_displacement_um - lean * loop.force_N)
    moved -= moved.mean()
    place, x = np.full(count, -1), loop.raw_displacement_um.copy()
    place[loop.index] = np.arange(loop.index.size)
    play = 0.0 if fits.shelves is None else play_of(fits.shelves).value
    if fits.shelves is not None:
        for branch, shelf in zip(split_branches(loop), fits.shelves, strict=True):
            x[place[branch.samples]] += _play_taken_out(branch, shelf, play)
    zero = 0.0 if fits.force_zero is None else fits.force_zero.value
    force = loop.force_N - zero
    stiffness = found.measured_stiffness_N_per_um
    yields = 0.0 if stiffness is None else 1.0 / stiffness.value

    def whole(values: Array) -> Array:
        filled = np.full(count, np.nan)
        filled[loop.index] = values
        return filled

    return CorrectedLoop(
        whole(x),
        whole(force),
        whole(x - yields * force),
        {name: np.isin(np.arange(count), samples) for name, samples in found.used.items()},
        found,
        drift_um=float(np.ptp(moved)),
        lag_samples=lag,
        lean_um_per_N=lean,
        free_play_um=play,
        compliance_um_per_N=yields,
        force_zero_N=zero,
    )


def _play_taken_out(branch: Branch, shelf: Shelf, play_um: float) -> Array:
    """What is added to the displacements (n,) of a branch that passes a play along a shelf: half of the play before it,
    less half behind it.
    """
    passed = np.clip((branch.travel_um - shelf.begin_um) / shelf.width_um, 0.0, 1.0)
    return branch.direction * play_um * (0.5 - passed)
