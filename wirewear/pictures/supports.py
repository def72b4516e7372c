"""Pictures of the boundary conditions of two bodies in contact: grips, load, stroke, springs.

The reference node stands for the holder of the upper body, which load and springs act on.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from geometry import BodyMesh
from geometry.arrays import Array, IntArray
from wirewear.pictures.mesh import round_facets, upper_position
from wirewear.pictures.style import GREY, INK, new_figure, panel_letters
from wirewear.test import Study

HELD_COLOUR, ELASTIC_COLOUR, LOAD_COLOUR, MOTION_COLOUR = "#0072B2", "#56B4E9", "#D55E00", "#009E73"
_ARROW = {"arrowstyle": "-|>", "linewidth": 1.6, "mutation_scale": 12, "shrinkA": 0, "shrinkB": 0}
_MOST_LINES = 15  #: At most so many lines are drawn from a reference node to what it holds.


@dataclass(frozen=True, eq=False)
class HeldBody:
    """Section of a body: its outline and its held part, as k line segments (k, 2, 2) in mm. elastic: the grip is."""

    edge: Array
    grip: Array
    elastic: bool = False


@dataclass(frozen=True)
class Supports:
    """Labels of the load, the lower body's stroke and the holder's springs; empty for a spring that is rigid.
    pivot_height: of the holder's pivot above the contact in mm; None if it does not rotate.
    """

    load: str
    stroke: str
    tangential: str = ""
    normal: str = ""
    rotational: str = ""
    pivot_height: float | None = None


def draw_boundary_conditions(
    views: Sequence[tuple[str, HeldBody, HeldBody]], supports: Supports, *, along_motion: Sequence[bool]
) -> Figure:
    """Picture with a panel for each view (title, upper body, lower body); the motion is drawn if along_motion."""
    figure = new_figure(3.9)
    panels = figure.subplots(1, len(views), squeeze=False)[0]
    for axes, (title, upper, lower), moves in zip(panels, views, along_motion, strict=True):
        _draw_view(axes, upper, lower, supports, moves=moves)
        axes.set_title(title)
    panel_letters(list(panels))
    handles = [
        axes.plot([], [], color=HELD_COLOUR, linewidth=3.0, label="held rigidly")[0],
        axes.plot([], [], color=ELASTIC_COLOUR, linewidth=3.0, linestyle=":", label="held elastically")[0],
        axes.plot([], [], color=GREY, linewidth=0.6, label="coupled to the reference node")[0],
    ]
    elastic = any(body.elastic for _, *bodies in views for body in bodies)
    shown = handles if elastic else [handles[0], handles[2]]
    figure.legend(handles=shown, loc="outside lower center", ncols=len(shown))
    return figure


def _draw_view(axes: Axes, upper: HeldBody, lower: HeldBody, supports: Supports, *, moves: bool) -> None:
    points = np.concatenate([upper.edge.reshape(-1, 2), lower.edge.reshape(-1, 2)])
    low, high = points.min(axis=0), points.max(axis=0)
    size = float(high[1] - low[1])
    for body in (upper, lower):
        _draw_lines(axes, body.edge, color=INK, linewidth=0.8)
        style = {"color": ELASTIC_COLOUR, "linestyle": ":"} if body.elastic else {"color": HELD_COLOUR}
        _draw_lines(axes, body.grip, linewidth=3.0, **style)
    node = np.array([0.0, high[1] + 0.16 * size])
    for place in _spread(upper.grip.mean(axis=1)):
        axes.plot(*np.column_stack([node, place]), color=GREY, linewidth=0.6)
    axes.plot(*node, marker="o", color=INK, markersize=4)
    _arrow(axes, node + [0.0, 0.24 * size], node + [0.0, 0.03 * size], LOAD_COLOUR)
    load = supports.load if not supports.normal else f"{supports.load}, spring {supports.normal}"
    axes.text(node[0] + 0.03 * size, node[1] + 0.2 * size, load, color=LOAD_COLOUR, va="center", fontsize=7.5)
    wide = float(np.abs(points[:, 0]).max())
    if moves:
        _draw_holder(axes, node, wide, size, supports)
        below = low[1] - 0.1 * size
        half = 0.22 * size
        _arrow(axes, np.array([-half, below]), np.array([half, below]), MOTION_COLOUR, "<|-|>")
        axes.text(0.0, below - 0.04 * size, supports.stroke, color=MOTION_COLOUR, ha="center", va="top", fontsize=7.5)
    axes.set(
        aspect="equal",
        xlim=(-max(1.15 * wide, 0.75 * size), max(1.15 * wide, 0.75 * size)),
        ylim=(low[1] - 0.28 * size, node[1] + 0.3 * size),
    )
    axes.set_axis_off()


def _spread(places: Array) -> Array:
    """At most _MOST_LINES of the points (k, 2), spread evenly over the width."""
    if not len(places):
        return places
    reach = float(np.abs(places[:, 0]).max())
    wanted = np.linspace(-reach, reach, _MOST_LINES)
    nearest = np.unique(np.abs(places[:, 0] - wanted[:, None]).argmin(axis=1))
    return np.asarray(places[nearest])


def _draw_holder(axes: Axes, node: Array, wide: float, size: float, supports: Supports) -> None:
    """Draw the holder's spring, or a rigid link, from its reference node to ground, and its pivot if it rotates."""
    wall = max(0.95 * wide, 0.6 * size)
    if supports.tangential:
        t = np.linspace(0.15, 0.85, 15)
        sides = np.where(np.arange(15) % 2 == 0, 0.03, -0.03) * size
        sides[[0, -1]] = 0.0
        x = np.concatenate([[node[0]], node[0] + t * (wall - node[0]), [wall]])
        axes.plot(x, node[1] + np.concatenate([[0.0], sides, [0.0]]), color=MOTION_COLOUR, linewidth=1.2)
    else:
        axes.plot([node[0], wall], [node[1], node[1]], color=MOTION_COLOUR, linewidth=2.0)
    for k in range(6):
        y = node[1] + (k / 5.0 - 0.5) * 0.16 * size
        axes.plot([wall, wall + 0.04 * size], [y, y + 0.03 * size], color=INK, linewidth=0.6)
    axes.plot([wall, wall], [node[1] - 0.09 * size, node[1] + 0.09 * size], color=INK, linewidth=1.2)
    text = supports.tangential or "rigid"
    axes.text(
        0.5 * (node[0] + wall), node[1] + 0.05 * size, text, color=MOTION_COLOUR, ha="center", va="bottom", fontsize=7.5
    )
    if supports.pivot_height is not None:
        pivot = np.array([0.0, min(supports.pivot_height, float(node[1]))])
        axes.plot(*pivot, marker="o", markerfacecolor="none", color=MOTION_COLOUR, markersize=8)
        axes.text(pivot[0] - 0.05 * size, pivot[1], supports.rotational, color=MOTION_COLOUR, ha="right", fontsize=7.5)


def _arrow(axes: Axes, start: Array, end: Array, colour: str, style: str = "-|>") -> None:
    axes.annotate("", xy=tuple(end), xytext=tuple(start), arrowprops=_ARROW | {"color": colour, "arrowstyle": style})


def _draw_lines(axes: Axes, lines: Array, **style: object) -> None:
    gaps = np.full((len(lines), 1), np.nan)
    x, z = (np.hstack([lines[:, :, k], gaps]).ravel() for k in (0, 1))
    axes.plot(x, z, solid_capstyle="round", **style)  # type: ignore[arg-type]


def supports(study: Study, moving: BodyMesh, fixed: BodyMesh) -> Figure:
    """Picture of both bodies' sections along and across the motion with their supports. moving, fixed: meshes of the
    driven (lower) and held (upper) body.
    """
    angle = np.radians(study.crossing_angle_deg)
    motion = np.radians(study.motion_angle_deg)

    def view(axis: int) -> tuple[HeldBody, HeldBody]:
        upper = _held(fixed, lambda points: upper_position(points, float(angle - motion)), axis)
        return upper, _held(moving, lambda points: _turned(points, float(-motion)), axis)

    views = [("along the motion", *view(1)), ("across the motion", *view(0))]
    return draw_boundary_conditions(views, _supports(study), along_motion=(True, False))


def _supports(study: Study) -> Supports:
    conditions, holder = study.conditions, study.holder
    tangential, rotational = holder.tangential_stiffness_N_per_mm, holder.rotational_stiffness_N_mm_per_rad
    spring = holder.normal_spring_stiffness_N_per_mm
    return Supports(
        load=f"{conditions.normal_load_N:g} N" if conditions.approach_um is None else f"{conditions.approach_um:g} µm",
        stroke=f"±{conditions.displacement_amplitude_um:g} µm",
        tangential="" if tangential == "rigid" else f"{tangential:g} N/mm",
        normal=f"{spring:g} N/mm" if spring > 0.0 else "",
        rotational="" if rotational == "rigid" else f"{rotational:g} N mm/rad",
        pivot_height=None if rotational == "rigid" else holder.pivot_height_mm,
    )


def _held(body: BodyMesh, placed: Callable[[Array], Array], axis: int) -> HeldBody:
    """Section of a body normal to a coordinate axis; `placed` moves its points (n, 3) to their place in the test."""

    def cut(facets: IntArray) -> Array:
        points, finer, _ = round_facets(body.mesh.points, facets, body.geometry.round_mm)
        return _cut(placed(points), finer, axis)

    elastic = body.geometry.grip_stiffness_N_per_mm3 is not None
    return HeldBody(cut(body.mesh.boundary_facets()), cut(body.mesh.surfaces["grip"]), elastic)


def _cut(points: Array, facets: IntArray, axis: int) -> Array:
    """Line segments (k, 2, 2), in the other horizontal coordinate and z, where facets (m, 4) cross zero of coordinate
    `axis`.
    """
    import pyvista

    faces = np.column_stack([np.full(len(facets), 4), facets]).ravel()
    normal = np.eye(3)[axis]
    # A section lies so far beside its plane [mm]: mirror planes are full of facets that would be cut twice.
    cut = pyvista.PolyData(points, faces).slice(normal=tuple(normal), origin=tuple(1e-6 * normal))
    if not cut.n_cells:
        return np.zeros((0, 2, 2))
    lines = np.asarray(cut.lines).reshape(-1, 3)[:, 1:]
    return np.asarray(np.asarray(cut.points)[lines][:, :, [1 - axis, 2]])


def _turned(points: Array, angle_rad: float) -> Array:
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    x, y, z = points.T
    return np.column_stack([c * x - s * y, s * x + c * y, z])
