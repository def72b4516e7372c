"""A loop as it is read, before any figure is taken from it: clean, upright and in time."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from wirewear.loops.branch_fits import BranchFits, branch_fits_of
from wirewear.loops.branches import upright
from wirewear.loops.cleaning import CleanLoop, clean_loop
from wirewear.loops.energy import dissipated_energy
from wirewear.loops.lag import earlier, goes_with_velocity, is_certain, lag_of

LATE = (
    "the force comes {:.1f} samples late: it begins to fall only behind the reversals. It was read as much earlier; "
    "dissipated_energy is {:.4g} mJ as read, which its interval holds"
)

EARLY = (
    "the force begins to fall {:.1f} samples before the reversals, as a displacement that comes late makes it, or a "
    "friction that falls with the speed; dissipated_energy is {:.4g} mJ where the displacement is late, which its "
    "interval holds"
)


class ReadLoop(NamedTuple):
    """A loop as it is read: clean, upright and in time.

    other_mJ: energy with another lag, which its interval has to cover. lag: in samples, that may be left in the force.
    removed_lag: in samples, by which the force was read earlier.
    """

    loop: CleanLoop
    fits: BranchFits
    other_mJ: float
    lag: float
    removed_lag: float

    @property
    def length_um(self) -> float:
        """Distance between the drive's reversals."""
        lean, loop = self.loop.lean_um_per_N, self.loop
        return float(np.ptp(loop.displacement_um - lean * loop.force_N)) if lean else self.fits.length_um


def read_loop(
    displacement_um: ArrayLike,
    tangential_force_N: ArrayLike,
    normal_force_N: ArrayLike | None = None,
    *,
    time_s: ArrayLike | None = None,
) -> ReadLoop:
    """Read the samples of a loop, before any figure is taken from them. Arguments and errors are those of
    `analyse_loop`.
    """
    loop = upright(clean_loop(displacement_um, tangential_force_N, normal_force_N, time_s=time_s))
    return _in_time(*_followed(loop))


def _in_time(loop: CleanLoop, fits: BranchFits) -> ReadLoop:
    """Loop and branches with a certain lag of the force removed.

    The other energy is the one as read where a lag was removed, and else the one without the lag that the reversals
    allow. The lag is 0 where it was removed. A force that is certainly early is noted and not corrected.
    """
    lag, as_read = None if goes_with_velocity(loop) else lag_of(loop), dissipated_energy(loop).value
    if lag is None:
        return ReadLoop(loop, fits, as_read, 0.0, 0.0)
    sooner = earlier(loop, lag.value)
    value = dissipated_energy(sooner).value
    if not is_certain(lag):
        return ReadLoop(loop, fits, value, lag.value, 0.0)
    if lag.value < 0.0:
        most = dissipated_energy(earlier(loop, lag.interval95[0])).value
        return ReadLoop(loop.noted(EARLY.format(-lag.value, value)), fits, most, lag.value, 0.0)
    sooner = sooner.noted(LATE.format(lag.value, as_read))
    return ReadLoop(sooner, branch_fits_of(sooner), as_read, 0.0, lag.value)


def _followed(loop: CleanLoop) -> tuple[CleanLoop, BranchFits]:
    """Loop and its branch fits; uses the unsmoothed drive if times are unknown and that fits clearly better."""
    fits = branch_fits_of(loop)
    if not loop.smoothed or loop.times_known:
        return loop, fits
    raw = loop.without_smooth_drive()
    raw_fits = branch_fits_of(raw)
    if raw_fits.misfit < 0.8 * fits.misfit:
        return raw, raw_fits
    return loop, fits
