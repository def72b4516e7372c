"""A body from a file as it was understood: its sets, its axes, and how far its faces are from the fitted surface."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from geometry.arrays import Array
from geometry.own_surface import MeshSource, OwnSurface, own_surface
from wirewear.pictures.mesh import EDGE_COLOUR, GRIP_COLOUR, MOVING_COLOUR, PATCH_COLOUR, PIXELS
from wirewear.pictures.style import WIDTH_in, new_figure, panel_letters

_AXES = {"x": "#b03030", "y": "#2f7d32", "z": "#2453a6"}  #: Colours of the body's axes.


def own_body(source: MeshSource, half_extents_mm: tuple[float, float], name: str) -> Figure:
    """Picture of the file's body with the sets that may touch and that are held, and its axes where it touches first;
    beside it the height in µm of its faces above the fitted surface under the contact patch.

    half_extents_mm: of the patch, along and across the body's axis. name: what the body is called.
    """
    own = own_surface(source)
    figure = new_figure(0.5 * WIDTH_in + 0.5)
    figure.set_layout_engine("constrained", h_pad=0.08)
    whole, face = figure.subplots(1, 2)
    whole.imshow(_rendered(own, source))
    whole.set_axis_off()
    measured = " × ".join(f"{each:.3g}" for each in np.ptp(own.solid.points, axis=0))
    whole.set_title(f"{name}\n{own.solid.size} elements, {measured} mm")
    _draw_deviation(face, own, half_extents_mm)
    panel_letters([whole, face])
    keys = [
        Patch(color=PATCH_COLOUR, label=f"{source.contact}, may touch"),
        Patch(color=GRIP_COLOUR, label=f"{source.held}, is held"),
        *(Patch(color=colour, label=axis) for axis, colour in _AXES.items()),
    ]
    figure.legend(handles=keys, loc="outside lower center", ncols=len(keys))
    return figure


def _rendered(own: OwnSurface, source: MeshSource) -> Any:
    import pyvista

    size = float(np.ptp(own.solid.points, axis=0).max())
    with pyvista.vtk_verbosity("off"):
        plotter: Any = pyvista.Plotter(off_screen=True, window_size=[PIXELS, PIXELS])
        plotter.set_background("white")
        named = {source.contact: PATCH_COLOUR, source.held: GRIP_COLOUR}
        plotter.add_mesh(
            _faces(own, own.solid.boundary),
            color=MOVING_COLOUR,
            show_edges=True,
            edge_color=EDGE_COLOUR,
            lighting=False,
        )
        for each, colour in named.items():
            shown = _faces(own, own.solid.faces_of(each))
            actor = plotter.add_mesh(shown, color=colour, show_edges=True, edge_color=EDGE_COLOUR, lighting=False)
            actor.mapper.SetResolveCoincidentTopologyToPolygonOffset()
            actor.mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(-2.0, -2.0)
        for direction, colour in zip(np.eye(3), _AXES.values(), strict=True):
            plotter.add_mesh(pyvista.Arrow(direction=direction, scale=0.3 * size), color=colour)
        plotter.enable_parallel_projection()
        plotter.view_vector((-0.55, -0.75, 0.5), viewup=(0.0, 0.0, 1.0))
        image = plotter.screenshot(return_img=True)
        plotter.close()
    return image


def _faces(own: OwnSurface, faces: tuple[Any, ...]) -> Any:
    import pyvista

    rows = [np.column_stack([np.full(len(each), each.shape[1]), each]).ravel() for each in faces]
    return pyvista.PolyData(own.solid.points, faces=np.concatenate(rows))


def _draw_deviation(axes: Axes, own: OwnSurface, half_extents_mm: tuple[float, float]) -> None:
    along, across = (np.linspace(-half, half, 61) for half in half_extents_mm)
    off = 1e3 * _file_heights_off(own, along, across)
    largest = max(float(np.nanmax(np.abs(off))), 1e-6)
    drawn = axes.pcolormesh(
        1e3 * along, 1e3 * across, off.T, cmap="RdBu_r", vmin=-largest, vmax=largest, shading="gouraud"
    )
    axes.set_aspect("equal")
    axes.set_xlabel("x along the body [µm]")
    axes.set_ylabel("y across [µm]")
    axes.set_title(f"file's faces off the fitted surface\nelements of {own.element_mm:.2g} mm there")
    axes.figure.colorbar(drawn, ax=axes, label="height [µm]", shrink=0.8)


def _file_heights_off(own: OwnSurface, along: Array, across: Array) -> Array:
    """Height of the file's faces over the fitted one (n_a, n_t) in mm, NaN beside them."""
    from matplotlib.tri import LinearTriInterpolator, Triangulation

    points = own.solid.points
    heights = LinearTriInterpolator(Triangulation(points[:, 0], points[:, 1], own.triangles), points[:, 2])
    x, y = np.meshgrid(along, across, indexing="ij")
    fitted = own.face.height(np.column_stack([x.ravel(), y.ravel()])).reshape(x.shape)
    return np.asarray(heights(x, y).filled(np.nan) - fitted)
