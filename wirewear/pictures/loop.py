"""A friction loop in a panel: every picture of one is drawn here, with the same line, axes and signs."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from geometry.arrays import Array, IntArray
from wirewear.pictures.style import GREY

DISPLACEMENT = "displacement δ [µm]"


def draw_loop(axes: Axes, displacement_um: Array, force: Array, **line: Any) -> None:
    """Draw a loop of n samples (n,) as one closed line. line: what matplotlib takes of a line."""
    closed = (np.append(values, values[0]) for values in (displacement_um, force))
    axes.plot(*closed, **{"solid_capstyle": "butt"} | line)


def draw_loop_band(axes: Axes, displacement_um: Array, low: Array, high: Array, **area: Any) -> None:
    """Fill between the lowest and the highest force at each sample (n,) of a loop, branch by branch.

    area: what matplotlib takes of an area.
    """
    for branch in _branches(displacement_um):
        axes.fill_between(displacement_um[branch], low[branch], high[branch], **{"linewidth": 0.0} | area)


def _branches(displacement_um: Array) -> Iterator[IntArray]:
    """Samples of both branches in order of time, each with the reversals at its ends."""
    n, top, bottom = displacement_um.size, int(displacement_um.argmax()), int(displacement_um.argmin())
    for start, end in ((bottom, top), (top, bottom)):
        yield (start + np.arange((end - start) % n + 1)) % n


def name_axes(axes: Axes, unit: str = "N") -> None:
    """Name the axes of a loop, and draw its zero lines. unit: of forces."""
    for line in (axes.axhline, axes.axvline):
        line(0.0, color=GREY, linewidth=0.6, zorder=1)
    axes.set(xlabel=DISPLACEMENT, ylabel=f"tangential force Q [{unit}]")
