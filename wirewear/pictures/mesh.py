"""The finite-element meshes of both wires, as they lie against each other."""

from __future__ import annotations

from math import radians
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from geometry import HexMesh, WireMesh
from wirewear.pictures.style import WIDTH_in, new_figure, panel_letters

PIXELS = 1400
MOVING_COLOUR, FIXED_COLOUR, GRIP_COLOUR, PATCH_COLOUR = "#d9dde3", "#c9d7e8", "#7d8791", "#f2b8a2"


def wire_meshes(moving: WireMesh, fixed: WireMesh, crossing_angle_deg: float) -> Figure:
    """Both meshes in contact, and a close view of the contact; grips dark, contact patches red."""
    figure = new_figure(0.5 * WIDTH_in)
    panels = figure.subplots(1, 2)
    whole = _render(moving, fixed, crossing_angle_deg, zoom=1.25, only_moving=False)
    close = _render(moving, fixed, crossing_angle_deg, zoom=2.5, only_moving=True)
    titles = (
        f"both wires: {len(moving.mesh.cells) + len(fixed.mesh.cells):,} hexahedra",
        f"patch of the moving wire: {1e3 * moving.geometry.transverse.fine_mm:.1f} µm elements",
    )
    for axes, image, title in zip(panels, (whole, close), titles, strict=True):
        axes.imshow(image)
        axes.set_title(title)
        axes.set_axis_off()
    panel_letters(list(panels))
    return figure


def surface_fields(wire: WireMesh) -> dict[str, NDArray[np.float64]]:
    """Point data that mark a mesh's named surfaces, for export: name -> (n,) 1 on the surface, 0 elsewhere."""
    fields = {}
    for name in wire.mesh.surfaces:
        field = np.zeros(len(wire.mesh.points))
        field[wire.mesh.surface_nodes(name)] = 1.0
        fields[name] = field
    return fields


def _render(moving: WireMesh, fixed: WireMesh, angle_deg: float, zoom: float, *, only_moving: bool) -> Any:
    import pyvista

    # VTK looks for an X server first and complains before it takes EGL.
    with pyvista.vtk_verbosity("off"):
        plotter: Any = pyvista.Plotter(off_screen=True, window_size=[PIXELS, PIXELS])
        plotter.set_background("white")
        _add(plotter, moving.mesh, moving.mesh.points, MOVING_COLOUR)
        if not only_moving:
            _add(plotter, fixed.mesh, _upper_position(fixed.mesh.points, radians(angle_deg)), FIXED_COLOUR)
        plotter.enable_parallel_projection()
        eye = (-0.25, -0.45, 0.9) if only_moving else (-0.55, -0.75, 0.5)
        plotter.view_vector(eye, viewup=(0.0, 0.0, 1.0))
        if only_moving:
            plotter.camera.focal_point = (0.0, 0.0, 0.0)
        plotter.camera.zoom(zoom)
        image = plotter.screenshot(return_img=True)
        plotter.close()
    return image


def _add(plotter: Any, mesh: HexMesh, points: NDArray[np.float64], colour: str) -> None:
    import pyvista

    for name, facets in mesh.surfaces.items():
        faces = np.column_stack([np.full(len(facets), 4), facets]).ravel()
        shade = {"grip": GRIP_COLOUR, "contact": PATCH_COLOUR}.get(name, colour)
        plotter.add_mesh(
            pyvista.PolyData(points, faces), color=shade, show_edges=True, edge_color="#303438", line_width=0.6
        )


def _upper_position(points: NDArray[np.float64], angle_rad: float) -> NDArray[np.float64]:
    """The upper wire, turned over about its axis and then about the normal by the crossing angle."""
    x, y, z = points[:, 0], -points[:, 1], -points[:, 2]
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return np.column_stack([c * x - s * y, s * x + c * y, z])
