"""Pictures of the finite-element meshes of both bodies in contact.

A facet is a quadrilateral face of an element; a patch is the finely meshed surface where contact may occur.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import radians
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from geometry import BodyMesh
from geometry.arrays import Array
from wirewear.base.words import counted
from wirewear.pictures.style import INK, WIDTH_in, new_figure, panel_letters, round_below

IntArray = NDArray[np.int_]

PARTS = 6  #: Parts into which each edge is divided.
ON_SURFACE = 1e-6  #: A corner this close to the wire's surface, as a share of its radius, lies on it.

PIXELS = 1400
MOVING_COLOUR, FIXED_COLOUR, GRIP_COLOUR, PATCH_COLOUR = "#d9dde3", "#c9d7e8", "#7d8791", "#f2b8a2"
EDGE_COLOUR = "#303438"


def round_facets(points_mm: Array, facets: IntArray, radius_mm: float | None) -> tuple[Array, IntArray, IntArray]:
    """(points (m, 3) in mm, quads (k·PARTS², 4), edges (4k, PARTS + 1)) of k facets cut into PARTS × PARTS; quads and
    edges hold indices of points.

    facets (k, 4): indices of their corners in points_mm, in order. The body's axis is x, its crown is the origin and
    its material lies below. radius_mm: facets on the surface of a round bar of this radius are curved; None leaves all
    flat.
    """
    corners = points_mm[facets]
    u, v = np.meshgrid(*2 * [np.linspace(0.0, 1.0, PARTS + 1)], indexing="ij")
    weights = np.stack([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v], axis=-1)
    finer = np.einsum("uvc,kcd->kuvd", weights, corners)
    along = np.linspace(0.0, 1.0, PARTS + 1)
    # Edge from the first to the second corner at v = 0, and so on around the facet; each with the blend to its middle.
    for start, end, blend, varies in ((0, 1, 1 - v, u), (3, 2, v, u), (0, 3, 1 - u, v), (1, 2, u, v)):
        if radius_mm is None:
            continue
        moved = _bulge(corners[:, start], corners[:, end], along, radius_mm)
        place = np.round(varies * PARTS).astype(int)
        finer += blend[None, ..., None] * moved[:, place]
    n = (PARTS + 1) ** 2
    index = np.arange(n).reshape(PARTS + 1, PARTS + 1)
    quad = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(-1, 4)
    rim = np.stack([index[:, 0], index[:, -1], index[0], index[-1]])
    first = n * np.arange(len(facets))
    return (
        finer.reshape(-1, 3),
        (first[:, None, None] + quad).reshape(-1, 4),
        (first[:, None, None] + rim).reshape(-1, PARTS + 1),
    )


def _bulge(start: Array, end: Array, along: Array, radius_mm: float) -> Array:
    """Vectors from points on straight edges to the round surface (k, n, 3); start and end hold the edges' ends
    (k, 3).
    """
    straight = start[:, None] + along[None, :, None] * (end - start)[:, None]
    centre = np.array([0.0, 0.0, -radius_mm])
    across = (straight - centre) * np.array([0.0, 1.0, 1.0])
    distance = np.linalg.norm(across, axis=-1, keepdims=True)
    on_surface = (np.abs(distance[:, [0, -1]] - radius_mm) < ON_SURFACE * radius_mm).all(axis=1)[:, None]
    outward = across * (radius_mm / np.maximum(distance, ON_SURFACE * radius_mm) - 1.0)
    return np.asarray(np.where(on_surface, outward, 0.0))


def body_meshes(
    moving: BodyMesh,
    fixed: BodyMesh,
    crossing_angle_deg: float,
    names: tuple[str, str],
    first_moving: BodyMesh | None = None,
) -> Figure:
    """Picture of both meshes in contact, with a close view of the driven patch; grips are dark, contact patches red.

    crossing_angle_deg: from the driven body's axis to the held one's. names: of the driven and the held body.
    first_moving: mesh of the driven body for the fresh contact, shown beside the one for the grown scar; None for none.
    """
    patches = {f"contact patch of the {names[0]}": moving}
    if first_moving is not None:
        patches = {"patch of the fresh contact": first_moving, "patch of the grown scar": moving}
    figure = new_figure((0.5 if first_moving is None else 0.37) * WIDTH_in + 0.66)
    # Titles of two lines stand clear of the edge.
    figure.set_layout_engine("constrained", h_pad=0.08)
    panels = figure.subplots(1, 1 + len(patches))
    angle = radians(crossing_angle_deg)
    lower = _Body(moving, MOVING_COLOUR, names[0], lambda points: points)
    upper = _Body(fixed, FIXED_COLOUR, names[1], lambda points: upper_position(points, angle))
    views = [_rendered([lower, upper], (-0.55, -0.75, 0.5), None)]
    titles = [f"both bodies\n{counted(len(moving.mesh.cells) + len(fixed.mesh.cells))} elements"]
    both = (axis for body in patches.values() for axis in (body.geometry.axial, body.geometry.transverse))
    height_mm = 2.6 * max(axis.half_extent_mm for axis in both)
    for name, body in patches.items():
        alone = _Body(body, MOVING_COLOUR, "", lambda points: points)
        views.append(_rendered([alone], (-0.15, -0.35, 0.9), height_mm))
        titles.append(f"{name}\n{element_sizes(body)}")
    for axes, view, title in zip(panels, views, titles, strict=True):
        show_bodies(axes, view)
        axes.set_title(title)
    panel_letters(list(panels))
    keys = [Patch(color=PATCH_COLOUR, label="contact patch"), Patch(color=GRIP_COLOUR, label="grip, where it is held")]
    figure.legend(handles=keys, loc="outside lower center", ncols=len(keys))
    return figure


def element_sizes(body: BodyMesh) -> str:
    """Words on the sizes in µm of a patch's fine elements, along and across."""
    along, across = (1e3 * axis.fine_mm for axis in (body.geometry.axial, body.geometry.transverse))
    return f"elements of {along:.1f} × {across:.1f} µm"


def surface_fields(body: BodyMesh) -> dict[str, Array]:
    """Point data (n,) for each named surface of a mesh, by its name: 1 on the surface, 0 elsewhere."""
    fields = {}
    for name in body.mesh.surfaces:
        field = np.zeros(len(body.mesh.points))
        field[body.mesh.surface_nodes(name)] = 1.0
        fields[name] = field
    return fields


@dataclass(frozen=True)
class _Body:
    """A body's mesh with its colour, name and the function that moves its points to their place."""

    meshed: BodyMesh
    colour: str
    name: str
    placed: Callable[[Array], Array]


@dataclass(frozen=True)
class DrawnBodies:
    """A rendered image (PIXELS, PIXELS, 3), its scale, and where names stand: pixels (right, down) in it."""

    image: NDArray[np.uint8]
    mm_per_pixel: float
    names: dict[str, tuple[float, float]]


def _rendered(bodies: Sequence[_Body], eye: tuple[float, float, float], height_mm: float | None) -> DrawnBodies:
    """View of the bodies from the direction `eye`, whole or limited to `height_mm` about the point of contact."""
    import pyvista

    # VTK looks for an X server first and complains before it takes EGL.
    with pyvista.vtk_verbosity("off"):
        plotter: Any = pyvista.Plotter(off_screen=True, window_size=[PIXELS, PIXELS])
        plotter.set_background("white")
        for body in bodies:
            _add(plotter, body)
        plotter.enable_parallel_projection()
        plotter.view_vector(eye, viewup=(0.0, 0.0, 1.0))
        if height_mm is None:
            plotter.camera.zoom(1.2)
        else:
            plotter.camera.focal_point = (0.0, 0.0, 0.0)
            plotter.camera.parallel_scale = 0.5 * height_mm
        image = plotter.screenshot(return_img=True)
        names = {body.name: _above_end(plotter, body) for body in bodies if body.name}
        scale = 2.0 * float(plotter.camera.parallel_scale) / PIXELS
        plotter.close()
    return DrawnBodies(image, scale, names)


def _add(plotter: Any, body: _Body) -> None:
    import pyvista

    mesh, radius_mm = body.meshed.mesh, body.meshed.geometry.round_mm
    for name, facets in ((name, facets) for name, facets in mesh.surfaces.items() if len(facets)):
        points, quads, edges = round_facets(mesh.points, facets, radius_mm)
        placed = body.placed(points)
        shade = {"grip": GRIP_COLOUR, "contact": PATCH_COLOUR}.get(name, body.colour)
        actor = plotter.add_mesh(pyvista.PolyData(placed, faces=_counted_rows(quads)), color=shade)
        # Edges lie in front of the faces that they bound.
        actor.mapper.SetResolveCoincidentTopologyToPolygonOffset()
        actor.mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(2.0, 2.0)
        plotter.add_mesh(pyvista.PolyData(placed, lines=_counted_rows(edges)), color=EDGE_COLOUR, line_width=1.0)


def _counted_rows(rows: NDArray[np.int_]) -> NDArray[np.int_]:
    """Flat array of rows of point indices, each preceded by its length, as VTK expects."""
    return np.column_stack([np.full(len(rows), rows.shape[1]), rows]).ravel()


def _above_end(plotter: Any, body: _Body) -> tuple[float, float]:
    """Middle of the body's nearer end in the image, in pixels from the upper left."""
    length, middle = body.meshed.geometry.half_length_mm, 0.5 * float(body.meshed.mesh.points[:, 2].min())
    ends = body.placed(np.array([[-length, 0.0, middle], [length, 0.0, middle]]))
    nearer = ends[np.argmax(ends @ np.array(plotter.camera.position))]
    renderer = plotter.renderer
    renderer.SetWorldPoint(*nearer, 1.0)
    renderer.WorldToDisplay()
    x, y, _ = renderer.GetDisplayPoint()
    return float(x), PIXELS - float(y)


def show_bodies(axes: Axes, view: DrawnBodies) -> None:
    """Draw the image of `view` in a panel, with a scale bar in its lower left corner and the bodies' names."""
    axes.imshow(view.image)
    axes.set_axis_off()
    box = {"facecolor": "white", "alpha": 0.8, "edgecolor": "none", "pad": 1.2}
    for name, (x, y) in view.names.items():
        axes.text(x, y, name, ha="center", va="center", fontsize=7.5, color=INK, bbox=box)
    length_mm = round_below(0.3 * PIXELS * view.mm_per_pixel)
    start, y = 0.04 * PIXELS, 0.95 * PIXELS
    axes.plot([start, start + length_mm / view.mm_per_pixel], [y, y], color=INK, linewidth=2.5, solid_capstyle="butt")
    label = f"{length_mm:g} mm" if length_mm >= 0.5 else f"{1e3 * length_mm:g} µm"
    axes.text(start, y - 0.02 * PIXELS, label, ha="left", va="bottom", fontsize=7.5, bbox=box)


def upper_position(points: Array, angle_rad: float) -> Array:
    """Points (n, 3) of the upper body turned upside down about its axis, then about the normal by `angle_rad`."""
    x, y, z = points[:, 0], -points[:, 1], -points[:, 2]
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return np.column_stack([c * x - s * y, s * x + c * y, z])
