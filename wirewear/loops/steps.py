"""Steps in which a channel was recorded: those of an encoder or of an analogue-to-digital converter."""

from __future__ import annotations

import numpy as np

from wirewear.loops.robust import Array

#: So large a share of the samples lies on the steps, within that share of one: others were put in between.
ON_STEPS, WITHIN = 0.95, 1e-3


def step_of(values: Array) -> float:
    """Least distance of different values (n,) of which all others are multiples; 0 where they have no step."""
    levels = np.unique(values)
    apart = np.diff(levels)
    apart = apart[apart > 1e-9 * max(float(np.abs(levels).max(initial=0.0)), 1e-300)]
    if apart.size == 0:
        return 0.0
    # Written digits make equal steps differ a little, and values that were put in between are few.
    step = float(np.median(apart[apart < 1.5 * np.quantile(apart, 0.05)]))
    multiples = (values - levels[levels.size // 2]) / step
    return step if float(np.mean(np.abs(multiples - np.round(multiples)) < WITHIN)) >= ON_STEPS else 0.0


def rounding_noise(step: float) -> float:
    """Standard deviation of what rounding to steps adds to a sample, step/√12.

    Source: Bennett, Bell System Technical Journal 27 (1948) 446.
    """
    return step / float(np.sqrt(12.0))
