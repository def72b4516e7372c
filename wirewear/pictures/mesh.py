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


def wire_meshes(
    moving: WireMesh, fixed: WireMesh, crossing_angle_deg: float, first_moving: WireMesh | None = None
) -> Figure:
    """Both meshes in contact, and the moving wire's patch from close by; grips dark, contact patches red.

    first_moving: the moving wire's mesh for the fresh contact, shown beside that for the grown scar.
    """
    patches = {"patch of the moving wire": moving}
    if first_moving is not None:
        patches = {"fresh contact": first_moving, "grown scar": moving}
    figure = new_figure((0.5 if first_moving is None else 0.37) * WIDTH_in)
    panels = figure.subplots(1, 1 + len(patches))
    images = [_render(_both(moving, fixed, crossing_angle_deg), (-0.55, -0.75, 0.5), None)]
    titles = [f"both wires: {len(moving.mesh.cells) + len(fixed.mesh.cells):,} hexahedra"]
    height = 1.3 * max(_extent(wire) for wire in patches.values())
    for name, wire in patches.items():
        images.append(_render([(wire.mesh, wire.mesh.points, MOVING_COLOUR)], (-0.15, -0.35, 0.9), height))
        titles.append(f"{name}: {_elements(wire)}")
    for axes, image, title in zip(panels, images, titles, strict=True):
        axes.imshow(image)
        axes.set_title(title)
        axes.set_axis_off()
    panel_letters(list(panels))
    return figure


def _elements(wire: WireMesh) -> str:
    """Sizes of the smallest elements of a patch along and across the wire."""
    along, across = (1e3 * axis.fine_mm for axis in (wire.geometry.axial, wire.geometry.transverse))
    return f"{along:.1f} × {across:.1f} µm"


def _extent(wire: WireMesh) -> float:
    return 2.0 * max(wire.geometry.axial.half_extent_mm, wire.geometry.transverse.half_extent_mm)


def surface_fields(wire: WireMesh) -> dict[str, NDArray[np.float64]]:
    """Point data that mark a mesh's named surfaces, for export: name -> (n,) 1 on the surface, 0 elsewhere."""
    fields = {}
    for name in wire.mesh.surfaces:
        field = np.zeros(len(wire.mesh.points))
        field[wire.mesh.surface_nodes(name)] = 1.0
        fields[name] = field
    return fields


#: Meshes with the places of their points and their colours.
_Bodies = list[tuple[HexMesh, NDArray[np.float64], str]]


def _both(moving: WireMesh, fixed: WireMesh, angle_deg: float) -> _Bodies:
    turned = _upper_position(fixed.mesh.points, radians(angle_deg))
    return [(moving.mesh, moving.mesh.points, MOVING_COLOUR), (fixed.mesh, turned, FIXED_COLOUR)]


def _render(bodies: _Bodies, eye: tuple[float, float, float], height_mm: float | None) -> Any:
    """A view from `eye` of everything, or of so much about the point of contact."""
    import pyvista

    # VTK looks for an X server first and complains before it takes EGL.
    with pyvista.vtk_verbosity("off"):
        plotter: Any = pyvista.Plotter(off_screen=True, window_size=[PIXELS, PIXELS])
        plotter.set_background("white")
        for mesh, points, colour in bodies:
            _add(plotter, mesh, points, colour)
        plotter.enable_parallel_projection()
        plotter.view_vector(eye, viewup=(0.0, 0.0, 1.0))
        if height_mm is None:
            plotter.camera.zoom(1.25)
        else:
            plotter.camera.focal_point = (0.0, 0.0, 0.0)
            plotter.camera.parallel_scale = 0.5 * height_mm
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
