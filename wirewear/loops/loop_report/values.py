"""A loop as it comes from any source."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SampledLoop:
    """Samples of one cycle, arrays (n,); `normal_load_N` may be one number or unknown, `time_s` unknown.

    `notes` say how the cycle was told.
    """

    repeat: int
    cycle: int
    displacement_um: Array
    tangential_force_N: Array
    normal_load_N: Array | float | None
    time_s: Array | None
    notes: tuple[str, ...] = ()
