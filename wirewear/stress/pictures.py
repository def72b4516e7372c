"""Pictures of bodies: sections with von Mises stress, a cut in 3D, tractions as arrows, and a cycle as an animation.

`states` are those of all bodies at one position (moment) of a recorded cycle. Each raises ResultError if the bodies are
apart there.
"""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Colormap, LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation
from PIL import Image

from geometry.arrays import Array, BoolArray, IntArray
from wirewear.base.errors import ResultError
from wirewear.base.writing import write_bytes, writing
from wirewear.pictures.style import INK, PRESSURE_COLOURS, cycle_name, new_figure, panel_letters, styled
from wirewear.results.scar import called
from wirewear.stress.bodies import BodyState, Tracked, body_grid, section, untracked

if TYPE_CHECKING:
    import pyvista


#: Stress: pale where there is none.
STRESS_COLOURS: Colormap = LinearSegmentedColormap.from_list(
    "stress", ["#ededea", *colormaps["inferno_r"](np.linspace(0.08, 0.92, 12))]
)
_LEVELS = 11
#: What a section near the contact shows, over the contact's half extent.
_AROUND = 2.2
_ARROWS = 12  #: Arrows of shear across the contact, at most.
_PIXELS = 1100


def draw_section(states: Sequence[BodyState]) -> Figure:
    """Picture of both bodies' von Mises stress in three sections.

    The whole bodies along the motion, and the neighbourhood of the contact along and across the motion.
    """
    grids = [body_grid(state) for state in states]
    centre, reach = _contact(states)
    largest = _largest(grids)
    figure = new_figure(2.6)
    panels = figure.subplots(1, 3, width_ratios=(1.0, 1.35, 1.35))
    whole = 1.05 * max(float(np.ptp(grid.points[:, 2])) for grid in grids)
    _draw_cut(panels[0], grids, 1, centre, whole, largest, lines=False)
    _draw_cut(panels[1], grids, 1, centre, _AROUND * reach, largest)
    _draw_cut(panels[2], grids, 0, centre, _AROUND * reach, largest)
    for axes, title in zip(panels, ("both bodies", "along the motion", "across the motion"), strict=True):
        axes.set_title(title)
    panel_letters(list(panels))
    colours = ScalarMappable(Normalize(0.0, largest), STRESS_COLOURS)
    figure.colorbar(colours, ax=panels, label="von Mises stress [MPa]", shrink=0.75, pad=0.01)
    figure.suptitle(_moment(states[0]), fontsize=9)
    return figure


def draw_tractions(states: Sequence[BodyState]) -> Figure:
    """Picture of the contact from above for each body: pressure as colour, shear as arrows that show its size."""
    figure = new_figure(4.1)
    panels = figure.subplots(1, len(states), squeeze=False)[0]
    fields = [_tractions(state) for state in states]
    largest = max(float(pressure.max()) for _, pressure, _ in fields)
    strongest = max(float(np.hypot(*shear.T).max()) for _, _, shear in fields)
    centre, reach = _contact(states)
    for axes, state, (points, pressure, shear) in zip(panels, states, fields, strict=True):
        nodes = state.body.patch.nodes
        axes.pcolormesh(
            points[nodes, 0],
            points[nodes, 1],
            pressure[nodes],
            shading="gouraud",
            cmap=PRESSURE_COLOURS,
            norm=Normalize(0.0, largest),
        )
        drawn = _spread(points[:, :2], pressure > 0.0, 2.0 * reach / _ARROWS)
        if strongest > 0.0:
            # As long as the way to the next arrow at most, so that pressures are seen between them.
            scale = strongest / (1.7 * reach / _ARROWS)
            look = {"angles": "xy", "scale_units": "xy", "width": 0.006, "edgecolor": INK, "linewidth": 0.4}
            axes.quiver(*points[drawn, :2].T, *shear[drawn].T, scale=scale, color="white", **look)
        axes.set(
            aspect="equal",
            xlim=(centre[0] - 1.4 * reach, centre[0] + 1.4 * reach),
            ylim=(centre[1] - 1.4 * reach, centre[1] + 1.4 * reach),
            xlabel="x, along the motion [µm]",
            title=f"{called(state.name)}, shear up to {strongest:.0f} MPa",
        )
        axes.grid(visible=False)
    panels[0].set_ylabel("y [µm]")
    panel_letters(list(panels))
    figure.colorbar(
        ScalarMappable(Normalize(0.0, largest), PRESSURE_COLOURS), ax=panels, label="pressure [MPa]", pad=0.01
    )
    figure.suptitle(_moment(states[0]), fontsize=9)
    return figure


def _spread(places: Array, loaded: BoolArray, step: float) -> IntArray:
    """Indices of the loaded places (n, 2) that lie nearest to the middle of a square of that width, one a square."""
    found = np.flatnonzero(loaded)
    squares = np.floor(places[found] / step)
    off = np.linalg.norm(places[found] - (squares + 0.5) * step, axis=1)
    order = np.argsort(off)
    _, first = np.unique(squares[order], axis=0, return_index=True)
    return found[order[first]]


def draw_cut(states: Sequence[BodyState]) -> Figure:
    """Picture of both bodies cut open along the motion, whole and near the contact, coloured by von Mises stress."""
    grids = [body_grid(state) for state in states]
    centre, reach = _contact(states)
    largest = _largest(grids)
    figure = new_figure(3.7)
    panels = figure.subplots(1, 2)
    tall = 1.15 * sum(float(np.ptp(grid.points[:, 2])) for grid in grids)
    for axes, height, title in zip(
        panels, (tall, 4.0 * _AROUND * reach), ("both bodies", "near the contact"), strict=True
    ):
        axes.imshow(_rendered(grids, centre, height, largest, edges=height < tall))
        axes.set_title(title)
        axes.set_axis_off()
    panel_letters(list(panels))
    colours = ScalarMappable(Normalize(0.0, largest), STRESS_COLOURS)
    figure.colorbar(colours, ax=panels, label="von Mises stress [MPa]", shrink=0.8, pad=0.01)
    figure.suptitle(_moment(states[0]), fontsize=9)
    return figure


def animate_cycle(moments: Sequence[Sequence[BodyState]], path: Path, tracked: Tracked = untracked) -> Path:
    """Write a GIF of sections along the motion over a cycle to `path`, and return that; each moment holds the states of
    all bodies. Raises ResultError if the file cannot be written, or there is no moment.
    """
    if not moments:
        raise ResultError(f"there is nothing to animate in {path}: no position of the cycle is recorded")
    windows = [_contact(states) for states in moments]
    reach = max(reach for _, reach in windows)
    travel = np.array([centre for centre, _ in windows])
    middle, half = 0.5 * (travel.min(axis=0) + travel.max(axis=0)), 0.5 * float(np.ptp(travel[:, 0]))
    grids = [[body_grid(state) for state in states] for states in moments]
    largest = max(_largest(each) for each in grids)
    frames = []
    with styled():
        for states, each in tracked(list(zip(moments, grids, strict=True)), "animating"):
            figure = new_figure(3.6, 5.4)
            axes = figure.subplots()
            _draw_cut(axes, each, 1, middle, half + 1.6 * reach, largest)
            axes.set_title(_moment(states[0]))
            colours = ScalarMappable(Normalize(0.0, largest), STRESS_COLOURS)
            figure.colorbar(colours, ax=axes, label="von Mises stress [MPa]")
            image = BytesIO()
            figure.savefig(image, format="png", dpi=90)
            frames.append(Image.open(image).convert("P", palette=Image.Palette.ADAPTIVE))
    result = BytesIO()
    frames[0].save(result, format="GIF", save_all=True, append_images=frames[1:], duration=160, loop=0)
    with writing(ResultError, f"cannot write the animation {path}"):
        write_bytes(path, result.getvalue())
    return path


def _draw_cut(
    axes: Axes,
    grids: Sequence[pyvista.UnstructuredGrid],
    axis: int,
    centre: Array,
    half: float,
    largest: float,
    *,
    lines: bool = True,
) -> None:
    """Sections of all bodies where the coordinate `axis` is that of the contact, and contours of equal stress."""
    levels = np.linspace(0.0, largest, _LEVELS)
    for grid in grids:
        cut = section(grid, axis, float(centre[axis]))
        if not len(cut.triangles):
            continue
        places = cut.places
        axes.tricontourf(places, np.clip(cut.values, 0.0, 0.9999 * largest), levels=levels, cmap=STRESS_COLOURS)
        if lines:
            axes.tricontour(places, cut.values, levels=levels[1:], colors=INK, linewidths=0.3)
        _outline(axes, places)
    axes.set(
        aspect="equal",
        xlim=(centre[1 - axis] - half, centre[1 - axis] + half),
        ylim=(centre[2] - half, centre[2] + half),
        xlabel="x, along the motion [µm]" if axis == 1 else "y, across the motion [µm]",
        ylabel="z [µm]",
    )
    axes.grid(visible=False)


def _outline(axes: Axes, places: Triangulation) -> None:
    """The edge of a section: sides of triangles that belong to one triangle only."""
    sides = np.sort(np.vstack([places.triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])]), axis=1)
    unique, counts = np.unique(sides, axis=0, return_counts=True)
    edge = unique[counts == 1]
    x, z = places.x[edge], places.y[edge]
    gaps = np.full((len(edge), 1), np.nan)
    axes.plot(
        np.hstack([x, gaps]).ravel(), np.hstack([z, gaps]).ravel(), color=INK, linewidth=0.7, solid_capstyle="round"
    )


def _contact(states: Sequence[BodyState]) -> tuple[Array, float]:
    """Where the contact is in the test's axes, µm, and its half extent."""
    found = []
    for state in states:
        loaded = np.flatnonzero((state.applied != 0.0).any(axis=1))
        found.append(state.world_points_um(state.body.mesh.points[loaded]))
    points = np.vstack(found)
    if not len(points):
        raise ResultError("there is no contact at that position of the cycle")
    low, high = points.min(axis=0), points.max(axis=0)
    return 0.5 * (low + high), 0.5 * float((high - low)[:2].max())


def _tractions(state: BodyState) -> tuple[Array, Array, Array]:
    """Points (n, 3) in µm, pressure (n,) and shear (n, 2) of the contact in MPa, in the test's axes."""
    mesh = state.body.mesh
    traction, normal = state.traction_MPa, state.surface_normal
    pressure = -(traction * normal).sum(axis=1)
    shear = (traction + pressure[:, None] * normal) @ state.to_world.T
    return state.world_points_um(mesh.points), np.maximum(pressure, 0.0), shear[:, :2]


def _largest(grids: Sequence[pyvista.UnstructuredGrid]) -> float:
    """Largest stress, as that of cells: single nodes on an edge of a grip or a contact overshoot."""
    return max(float(grid.cell_data["von_mises_MPa"].max()) for grid in grids)


def _moment(state: BodyState) -> str:
    forces, k = state.forces, state.position
    return (
        f"cycle {cycle_name(forces.cycle)}, drive {forces.drive_um[k]:.1f} µm, "
        f"tangential force {forces.tangential_force_N[k]:.2f} N"
    )


def _rendered(
    grids: Sequence[pyvista.UnstructuredGrid], centre: Array, height_um: float, largest: float, *, edges: bool
) -> Any:
    import pyvista

    # VTK looks for an X server first and complains before it takes EGL.
    with pyvista.vtk_verbosity("off"):
        plotter: Any = pyvista.Plotter(off_screen=True, window_size=[_PIXELS, _PIXELS])
        plotter.set_background("white")
        for grid in grids:
            # Whole cells are left out, so that the cut shows the elements.
            kept = grid.extract_cells(np.asarray(grid.cell_centers().points[:, 1] > centre[1]))
            plotter.add_mesh(
                kept,
                scalars="von_mises_MPa",
                preference="point",
                cmap=STRESS_COLOURS,
                clim=(0.0, largest),
                show_edges=edges,
                edge_color="#50545a",
                line_width=0.5,
                show_scalar_bar=False,
                lighting=False,
            )
            # Without light, colours are those of the colour bar; edges give the bodies their shape.
            outside = kept.extract_surface(algorithm="dataset_surface").extract_feature_edges(40.0)
            plotter.add_mesh(outside, color=INK, line_width=2.0)
        plotter.enable_parallel_projection()
        plotter.view_vector((-0.35, -1.0, 0.25), viewup=(0.0, 0.0, 1.0))
        plotter.camera.focal_point = tuple(centre)
        plotter.camera.parallel_scale = 0.5 * height_um
        image = plotter.screenshot(return_img=True)
        plotter.close()
    return image
