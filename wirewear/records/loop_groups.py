"""Loops that were sampled alike."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from wirewear.records.values import MeasuredLoop


def of_equal_times(loops: Iterable[MeasuredLoop]) -> list[list[MeasuredLoop]]:
    """Groups of complete loops whose samples lie at the same times within a microsecond, largest group first."""
    groups: dict[bytes, list[MeasuredLoop]] = {}
    for loop in loops:
        if loop.complete is loop:
            groups.setdefault(np.round(loop.time_s - loop.time_s[0], 6).tobytes(), []).append(loop)
    return sorted(groups.values(), key=len, reverse=True)
