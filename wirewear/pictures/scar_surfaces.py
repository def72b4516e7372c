"""3D pictures of both scars: the worn surfaces in true proportions, coloured by depth.

The crown is the highest line or point of the unworn body, at which it was first touched. The sliding frame has x along
the motion, y across and z out of the body.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from geometry.arrays import Array
from wirewear.pictures.scar_maps import deepest, last_scars
from wirewear.pictures.smooth import smooth_scar, worn_half_extent
from wirewear.pictures.style import (
    DEPTH_COLOURS,
    INK,
    WIDTH_in,
    cycle_name,
    new_figure,
    panel_letters,
    round_below,
    titled,
)
from wirewear.results import RunResult, Scar

if TYPE_CHECKING:
    import pyvista

RESOLUTION = 320  #: Points along each side of a surface.

#: Where light comes from in the sliding frame, and how strong: a low sun that shades the bowls, a fill from the eye.
#: Much of it is ambient, so that a colour stays the one on the colour bar.
LIGHTS = (((-1.0, -0.35, 0.75), 0.5), ((0.4, -0.8, 0.9), 0.22))
AMBIENT = 0.42

CUT_COLOUR = "#b9bcc1"
PIXELS = 1100  #: Width of a rendering, about twice the width of its panel: shrinking it smooths the edges.


@dataclass(frozen=True)
class View:
    """Orthographic view: unit vectors (3,) to the right, upwards and towards the eye, in the sliding frame."""

    right: Array
    up: Array
    eye: Array

    @classmethod
    def from_angles(cls, azimuth_deg: float, elevation_deg: float) -> "View":
        """View from this azimuth (from x towards y) and elevation above the surface, with z upwards in the picture."""
        a, e = np.radians(azimuth_deg), np.radians(elevation_deg)
        eye = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
        right = np.array([-np.sin(a), np.cos(a), 0.0])
        return cls(right, np.cross(eye, right), eye)

    def project(self, points: ArrayLike) -> Array:
        """Coordinates (..., 2), to the right and upwards in the picture, of points (..., 3), in the points' unit."""
        positions: Array = np.asarray(points, dtype=np.float64) @ np.stack([self.right, self.up], axis=1)
        return positions


VIEW = View.from_angles(azimuth_deg=-62.0, elevation_deg=38.0)


def scars_in_3d(results: Sequence[RunResult]) -> Figure:
    """Picture of the worn surfaces of both bodies at each run's last logged cycle, crowns up: one row a run, one view
    and scale for all. Raises ResultError if a run has no scars.
    """
    rows = [last_scars(result) for result in results]
    scars = [scar for row in rows for scar in row]
    half_length = 1.3 * max(worn_half_extent(scars))
    radii = [scar.radius_um for scar in scars if np.isfinite(scar.radius_um) and np.isinf(scar.diameter_along_mm)]
    # Half-width of the strip of cylinder that is shown, in radii, at least.
    half_strip = max(0.75 * max(radii, default=0.0), 0.8 * half_length)
    norm = Normalize(0.0, deepest(rows))
    pictures = [[_render(scar, half_length, half_strip, norm.vmax or 1.0) for scar in row] for row in rows]
    left, right, bottom, top = (
        extreme(picture[1][place] for row in pictures for picture in row)
        for place, extreme in enumerate((min, max, min, max))
    )
    panel_width_in = 0.44 * WIDTH_in
    # Height of the line of text below the rulers.
    text_um = 0.16 * (right - left) / panel_width_in
    bottom -= text_um
    figure = new_figure(len(rows) * (panel_width_in * (top - bottom) / (right - left) + 0.35))
    grid = figure.subplots(len(rows), 2, squeeze=False)
    for axes_row, scar_row, picture_row, result in zip(grid, rows, pictures, results, strict=True):
        for axes, scar, (pixels, extent) in zip(axes_row, scar_row, picture_row, strict=True):
            axes.imshow(pixels, extent=extent, interpolation="antialiased")
            axes.set_axis_off()
            axes.set(
                xlim=(left, right),
                ylim=(bottom, top),
                title=titled(results, result, f"{result.called(scar.body)}, {cycle_name(scar.cycle)} cycles"),
            )
            _draw_rulers(axes, round_below(0.5 * half_length), text_um)
    panel_letters(list(grid.flat))
    figure.colorbar(ScalarMappable(norm, DEPTH_COLOURS), ax=grid, label="worn depth [µm]", shrink=0.7, pad=0.01)
    return figure


def worn_surface(scar: Scar, half_length_um: float, half_strip_um: float) -> "pyvista.StructuredGrid":
    """A pyvista mesh in µm of the worn surface near a body's crown, in the sliding frame, with the point data
    `depth_um`. It covers |axial| ≤ half_length_um and |transverse| ≤ half_strip_um, or less where the body ends before.
    """
    import pyvista

    reach = (half_length_um, half_strip_um)
    half_length, half_strip = (min(one, flank) for one, flank in zip(reach, scar.flanks_um, strict=True))
    axial = np.linspace(-half_length, half_length, RESOLUTION)[:, None]
    transverse = np.linspace(-half_strip, half_strip, RESOLUTION)[None, :]
    x, y = scar.sliding_coordinates(axial, transverse)
    depth = smooth_scar(scar).depth_at(x, y)
    z = scar.unworn_height_um(axial, transverse) - depth
    surface = pyvista.StructuredGrid(x, y, z)
    surface["depth_um"] = depth.ravel(order="F")
    return surface


def _render(
    scar: Scar, half_length_um: float, half_strip_um: float, worst_um: float
) -> tuple[NDArray[np.uint8], tuple[float, float, float, float]]:
    """Image of the worn body, and its extent (left, right, bottom, top) in the plane of the picture in µm."""
    import pyvista

    surface = worn_surface(scar, half_length_um, half_strip_um)
    flat = VIEW.project(surface.points)
    (left, bottom), (right, top) = flat.min(axis=0), flat.max(axis=0)
    centre_flat = np.array([left + right, bottom + top]) / 2
    width, height = 1.02 * (right - left), 1.02 * (top - bottom)
    # VTK looks for an X server first and complains before it takes EGL.
    with pyvista.vtk_verbosity("off"):
        plotter = pyvista.Plotter(
            off_screen=True, window_size=[PIXELS, round(PIXELS * height / width)], lighting="none"
        )
        for direction, intensity in LIGHTS:
            plotter.add_light(pyvista.Light(position=direction, intensity=intensity, light_type="scene light"))
        smooth = surface.extract_surface(algorithm="dataset_surface").compute_normals(split_vertices=False)
        plotter.add_mesh(
            smooth,
            scalars="depth_um",
            cmap=DEPTH_COLOURS,
            clim=(0.0, worst_um),
            smooth_shading=True,
            show_scalar_bar=False,
            ambient=AMBIENT,
            specular=0.12,
            specular_power=12.0,
        )
        for end in _cut_faces(surface):
            plotter.add_mesh(end, color=CUT_COLOUR, ambient=AMBIENT)
        centre = VIEW.right * centre_flat[0] + VIEW.up * centre_flat[1]
        camera = plotter.camera
        camera.focal_point = tuple(centre)
        camera.position = tuple(centre + 10.0 * (half_length_um + half_strip_um) * VIEW.eye)
        camera.up = tuple(VIEW.up)
        camera.parallel_projection = True
        camera.parallel_scale = height / 2
        pixels: Any = plotter.screenshot(None, return_img=True, transparent_background=True)
        plotter.close()
    extent = (
        centre_flat[0] - width / 2,
        centre_flat[0] + width / 2,
        centre_flat[1] - height / 2,
        centre_flat[1] + height / 2,
    )
    return pixels, extent


def _cut_faces(surface: "pyvista.StructuredGrid") -> list["pyvista.PolyData"]:
    """Plane faces that close both ends of the body, from its surface down to the lower edge of the strip."""
    import pyvista

    points = surface.points.reshape((*surface.dimensions[:2], 3), order="F")
    return [
        pyvista.PolyData(edge, faces=[len(edge), *range(len(edge))]).triangulate() for edge in (points[0], points[-1])
    ]


def _draw_rulers(axes: Axes, length_um: float, text_um: float) -> None:
    """Draw arrows of this length along x, y and z in the lower left corner, projected as the body is."""
    directions = {"x (sliding)": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
    tips = {name: VIEW.project(direction) * length_um for name, direction in directions.items()}
    corner = np.array([axes.get_xlim()[0], axes.get_ylim()[0]])
    # All three must stay inside the panel, with room for the line of text below.
    origin = corner - np.minimum(np.min(list(tips.values()), axis=0), 0.0) + np.array([0.05, 1.5]) * text_um
    for name, tip in tips.items():
        start, end = origin, origin + tip
        arrow = {"arrowstyle": "-|>", "color": INK, "linewidth": 1.0, "mutation_scale": 8, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", xy=tuple(end), xytext=tuple(start), arrowprops=arrow)
        upright = abs(tip[0]) < 1e-9 * length_um
        x, y = end + 0.06 * tip
        axes.text(x, y, name, fontsize=7.5, ha="center" if upright else "left", va="bottom" if upright else "center")
    axes.text(corner[0], corner[1], f"each arrow {length_um:g} µm", fontsize=7.5, va="bottom")
