"""A friction loop, or a scar from above, in a panel: drawn once for all pictures, with the same line, axes and signs.

Scars are in true proportions, with the body's axis; fields are interpolated smoothly between the grid points (see
`smooth`).
"""

from typing import Literal, Unpack

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import Colormap, Normalize
from numpy.typing import ArrayLike

from geometry.arrays import Array
from wirewear.pictures.smooth import smooth_scar
from wirewear.pictures.style import DEPTH_COLOURS, GREY, AreaLook, LineLook
from wirewear.results import Scar

DISPLACEMENT = "displacement δ [µm]"

RESOLUTION = 420  #: Pixels along the longer side of a map of a simulated scar.


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


def draw_scar(axes: Axes, scar: Scar, half_x: float, half_y: float, norm: Normalize) -> None:
    """Draw the worn depth of a simulated scar over |x| ≤ half_x and |y| ≤ half_y in µm, and the body's axis if it has
    one.
    norm: scale of depths in µm for DEPTH_COLOURS.
    """
    step = 2.0 * max(half_x, half_y) / RESOLUTION
    x, y = (np.arange(-half + step / 2, half, step) for half in (half_x, half_y))
    extent = (x[0] - step / 2, x[-1] + step / 2, y[0] - step / 2, y[-1] + step / 2)
    image = smooth_scar(scar).sampled(x, y).T
    axes.imshow(image, cmap=DEPTH_COLOURS, norm=norm, origin="lower", extent=extent, interpolation="bilinear")
    _frame(axes, half_x, half_y)
    if scar.diameter_mm != scar.diameter_along_mm:
        draw_axis(axes, scar.axis_angle_deg)


def draw_map(
    axes: Axes,
    at_um: tuple[Array, Array],
    values: ArrayLike,
    norm: Normalize,
    colours: Colormap | str,
    half_um: tuple[float, float] | None = None,
    *,
    shading: Literal["nearest", "gouraud"] = "nearest",
) -> QuadMesh:
    """Draw a field (n_x, n_y) at its grid points as colours, and return what is drawn, for a colour bar.

    at_um: coordinates along and across the motion, as grid lines (n_x,) and (n_y,) or at each point (n_x, n_y). norm:
    scale of the values. half_um: |x| and |y| up to which is shown, None for all. shading: as matplotlib names it.
    """
    places = np.meshgrid(*at_um, indexing="ij") if at_um[0].ndim == 1 else at_um
    drawn = axes.pcolormesh(*places, values, norm=norm, cmap=colours, shading=shading, rasterized=True)
    _frame(axes, *(half_um or ()))
    return drawn


def _frame(axes: Axes, half_x: float | None = None, half_y: float | None = None) -> None:
    axes.grid(visible=False)
    axes.spines[:].set_visible(True)
    axes.set(aspect="equal")
    if half_x is not None and half_y is not None:
        axes.set(xlim=(-half_x, half_x), ylim=(-half_y, half_y))


def draw_axis(axes: Axes, angle_deg: float) -> None:
    """Draw a body's axis as a dash-dotted line through the origin, at this angle to the motion."""
    angle, dashes = np.radians(angle_deg), (0, (8, 2, 1, 2))
    axes.axline((0.0, 0.0), (np.cos(angle), np.sin(angle)), color=GREY, linewidth=0.7, linestyle=dashes)
