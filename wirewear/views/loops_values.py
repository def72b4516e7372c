"""A loop as it comes from any source."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wirewear.records.values import MeasuredLoop

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

    @classmethod
    def of(cls, loop: MeasuredLoop, load_N: float | None) -> SampledLoop:
        """A record's loop, under that load where none was measured."""
        normal = load_N if loop.normal_force_N is None else loop.normal_force_N
        return cls(loop.repeat, loop.cycle, loop.displacement_um, loop.tangential_force_N, normal, loop.time_s)
