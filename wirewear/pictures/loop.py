"""Drawing of a friction loop in a panel, for all pictures, with the same line, axes and signs."""

from typing import Unpack

import numpy as np
from matplotlib.axes import Axes

from geometry.arrays import Array
from wirewear.pictures.style import GREY, AreaLook, LineLook

DISPLACEMENT = "displacement δ [µm]"


def draw_loop(axes: Axes, displacement_um: Array, force: Array, *, label: str = "", **line: Unpack[LineLook]) -> None:
    """Draw a loop of n samples (n,) as one closed line. label: for the legend; empty for none."""
    closed = (np.append(values, values[0]) for values in (displacement_um, force))
    axes.plot(*closed, solid_capstyle="butt", label=label or None, **line)


def draw_loop_band(axes: Axes, displacement_um: Array, low: Array, high: Array, **area: Unpack[AreaLook]) -> None:
    """Fill the area between the forces `low` and `high`, (n,) each, over a loop's displacements (n,)."""
    n, top, bottom = displacement_um.size, int(displacement_um.argmax()), int(displacement_um.argmin())
    for start, end in ((bottom, top), (top, bottom)):
        # In order of time, each with the reversals at its ends.
        branch = (start + np.arange((end - start) % n + 1)) % n
        axes.fill_between(displacement_um[branch], low[branch], high[branch], linewidth=0.0, **area)


def name_axes(axes: Axes, unit: str = "N") -> None:
    """Label the axes of a loop and draw its zero lines. unit: of the forces."""
    for line in (axes.axhline, axes.axvline):
        line(0.0, color=GREY, linewidth=0.6, zorder=1)
    axes.set(xlabel=DISPLACEMENT, ylabel=f"tangential force Q [{unit}]")
