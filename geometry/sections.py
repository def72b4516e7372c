"""Quadrilateral meshes of half a cross-section, of a wire, tube or block: fine at the contact, coarse elsewhere.

Columns of elements go down from the contact. Transition rows join three columns into one where columns are narrow, so a
fine contact costs few elements inside the body; any number of columns can be joined. The columns of a wire end in a
core, around which the layers go on as rings to the wire's back; those of a tube end at its bore, and its layers go on
as rings, too; those of a block end at its back. Points are (y, z) in mm with y >= 0.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from math import cos, pi, sin

import numpy as np

from geometry.arrays import Array, IntArray
from geometry.grading import Layering, graded_layers

_LEAST_CORNER_ANGLE = 0.25 * pi  #: Of a wire's core.
#: Longest bricks around a tube over its wall: they make a thin ring 5 % too stiff in bending, a tube with a load at a
#: point 1 % (19.05 mm, wall 1.09 mm).
_COARSE_PER_WALL = 1.0 / 3.0
#: Share of a tube's wall or a block's height that its columns pass through without being joined.
_UNJOINED = {"tube": 0.3, "block": 0.5}


@dataclass
class _Quads:
    """Points (y, z) and quadrilaterals of a cross-section under construction."""

    points: list[tuple[float, float]] = field(default_factory=list)
    quads: list[tuple[int, int, int, int]] = field(default_factory=list)

    def polar(self, radius: float, angle: float) -> int:
        return self.plane(radius * sin(angle), radius * cos(angle))

    def plane(self, y: float, z: float) -> int:
        self.points.append((y, z))
        return len(self.points) - 1

    def below(self, top: float) -> tuple[Array, IntArray]:
        """All points (n, 2), moved down by `top` so that the contact is at z = 0, and all quadrilaterals (m, 4)."""
        points = np.array(self.points)
        points[:, 1] -= top
        points[np.abs(points[:, 0]) < 1e-12 * top, 0] = 0.0
        return points, np.array(self.quads, dtype=np.int64)


def wire_section(
    radius_mm: float,
    half_lines_mm: Array,
    coarse_mm: float,
    layering: Layering,
    finest_mm: float | None = None,
    bore_radius_mm: float = 0.0,
) -> tuple[Array, IntArray]:
    """Mesh half of the cross-section of a wire or tube: points (n, 2) in mm as (y >= 0, z), the contact at the origin
    and +z outwards, and quads (m, 4), their indices counter-clockwise.

    half_lines_mm: (k,) grid lines of the contact patch across the wire, from 0; each becomes a node on the surface.
    coarse_mm: largest element far from the contact. layering: of the elements under the contact. finest_mm: the patch's
    smallest spacing along the wire, from which the uppermost layer's thickness follows if it is smaller than the
    spacing across; None: that across. bore_radius_mm: inner radius of a tube, 0 for a wire.
    """
    section = _Quads()
    if bore_radius_mm:
        coarse_mm = min(coarse_mm, _COARSE_PER_WALL * (radius_mm - bore_radius_mm))
    angles = _top_angles(radius_mm, half_lines_mm, coarse_mm)
    across = float(half_lines_mm[1])
    columns = _Columns(section, section.polar, lambda radius: radius, layering, coarse_mm)
    first = layering.first * min(across, finest_mm or across)
    if bore_radius_mm:
        _, angles, edge = columns.through(angles, radius_mm, bore_radius_mm, first, _UNJOINED["tube"])
        _rings(section, edge, _ring_angles(float(angles[-1]), coarse_mm / radius_mm))
    else:
        row, angles, edge, _ = columns.down(angles, radius_mm, first, 0.5 * radius_mm)
        _rings_and_core(section, row, edge, angles, radius_mm, coarse_mm)
    return section.below(radius_mm)


def block_section(
    half_width_mm: float, height_mm: float, half_lines_mm: Array, coarse_mm: float, layering: Layering, finest_mm: float
) -> tuple[Array, IntArray]:
    """Mesh half of a rectangular cross-section whose upper side carries the contact: points (n, 2) in mm as (y >= 0, z
    <= 0), and quads (m, 4), their indices.

    half_lines_mm: (k,) grid lines of the contact patch across, from 0. coarse_mm: largest element far from the contact.
    layering: of the elements under the contact. finest_mm: the patch's smallest spacing, from which the uppermost
    layer's thickness follows.
    """
    section = _Quads()
    beside = half_width_mm - half_lines_mm[-1]
    size = min(1.4 * float(half_lines_mm[-1] - half_lines_mm[-2]), beside)
    lines = np.append(half_lines_mm, half_lines_mm[-1] + np.cumsum(graded_layers(size, 1.4, coarse_mm, beside)))
    columns = _Columns(section, lambda level, y: section.plane(y, level), lambda _: 1.0, layering, coarse_mm)
    columns.through(lines, height_mm, 0.0, layering.first * finest_mm, _UNJOINED["block"])
    return section.below(height_mm)


@dataclass
class _Columns:
    """Columns of elements that go down from the contact, fewer from each transition row on."""

    section: _Quads
    place: Callable[[float, float], int]  #: Adds a point at a level (mm, falling) of a column.
    scale: Callable[[float], float]  #: Factor from columns' differences to distances in mm at a level.
    layering: Layering
    coarse_mm: float

    def down(
        self, columns: Array, top: float, thickness: float, least: float
    ) -> tuple[list[int], Array, list[int], float]:
        """Lay out rows of elements from the level `top` down, the first `thickness` mm thick, without going below
        `least`.

        Returns the last row of points, its columns, the points on the outer edge of each row, and the last level in mm.
        """
        layering, level = self.layering, top
        row = [self.place(level, column) for column in columns]
        edge = [row[-1]]
        layers = 0
        while True:
            widths = self.scale(level) * np.diff(columns)
            layers += 1
            flat = thickness < layering.first * float(widths.min())
            joins = _joined_columns(widths, self.coarse_mm) if layers > layering.count and not flat else []
            if joins:
                joined = np.concatenate([widths[j : j + 3] for j in joins])
                step = 2.0 * float(joined.mean())
            else:
                step = min(thickness, self.coarse_mm)
            if level - step < least:
                return row, columns, edge, level
            if joins:
                row, columns = self._transition_row(row, columns, joins, level, step)
                layers, thickness = layering.count - 1, 0.5 * step
            else:
                row = _plain_row(self.section, row, [self.place(level - step, column) for column in columns])
            thickness *= layering.growth
            level -= step
            edge.append(row[-1])

    def through(
        self, columns: Array, top: float, bottom: float, thickness: float, unjoined: float
    ) -> tuple[list[int], Array, list[int]]:
        """Lay out rows from the level `top` down to `bottom`, joining no columns in the share `unjoined` above
        `bottom`.

        Returns the last row of points, its columns, and the points on the outer edge of each row.
        """
        row, columns, edge, level = self.down(columns, top, thickness, bottom + unjoined * (top - bottom))
        last, rest = self.scale(level) * float(np.diff(columns).min()), level - bottom
        for step in np.cumsum(graded_layers(min(last, rest), self.layering.growth, self.coarse_mm, rest)):
            row = _plain_row(self.section, row, [self.place(max(level - step, bottom), column) for column in columns])
            edge.append(row[-1])
        return row, columns, edge

    def _transition_row(
        self, row: list[int], columns: Array, joins: list[int], level: float, step: float
    ) -> tuple[list[int], Array]:
        quads = self.section.quads
        kept = [j for j in range(len(row)) if not any(first < j < first + 3 for first in joins)]
        lower = {j: self.place(level - step, columns[j]) for j in kept}
        for first in joins:
            t0, t1, t2, t3 = row[first : first + 4]
            b0, b3 = lower[first], lower[first + 3]
            m1 = self.place(level - 0.5 * step, columns[first + 1])
            m2 = self.place(level - 0.5 * step, columns[first + 2])
            quads += [(t0, b0, m1, t1), (t1, m1, m2, t2), (t2, m2, b3, t3), (m1, b0, b3, m2)]
        for j, following in pairwise(kept):
            if following == j + 1:
                quads.append((row[j], lower[j], lower[following], row[following]))
        return [lower[j] for j in kept], columns[kept]


def _top_angles(radius: float, half_lines: Array, coarse: float) -> Array:
    """Angles in rad of the columns at the surface: the patch's lines, then ever wider spacings up to the core's
    corner.
    """
    angles = list(np.arcsin(half_lines / radius))
    size = angles[-1] - angles[-2]
    while angles[-1] < _LEAST_CORNER_ANGLE - 0.5 * size:
        size = min(1.4 * size, coarse / radius)
        angles.append(angles[-1] + size)
    return np.array(angles)


def _joined_columns(widths: Array, coarse: float) -> list[int]:
    """Index of the first column of each group of three that a transition row joins; empty if elements would be too
    coarse.
    """
    # Columns wider than this multiple of the row's narrowest are not joined with others.
    limit = min(2.2 * float(widths.min()), 0.4 * coarse)
    joins = []
    column = 0
    while column + 3 <= len(widths):
        if widths[column : column + 3].max() <= limit:
            joins.append(column)
            column += 3
        else:
            column += 1
    return joins


def _plain_row(section: _Quads, upper: list[int], lower: list[int]) -> list[int]:
    for j in range(len(upper) - 1):
        section.quads.append((upper[j], lower[j], lower[j + 1], upper[j + 1]))
    return lower


def _rings_and_core(
    section: _Quads, row: list[int], edge: list[int], angles: Array, radius: float, coarse: float
) -> None:
    """Add rings of elements from the columns' outer edge to the wire's back, and the core inside them."""
    columns = len(row) - 1
    corner = float(angles[-1])
    rim = 0.35 * radius
    half_width, top, bottom = rim * sin(corner), rim * cos(corner), -rim * sin(pi / 4)
    ring_angles = _ring_angles(corner, coarse / radius, columns)
    sides = len(ring_angles) - columns - 1
    upper = _rings(section, edge, ring_angles)
    # A full row around the core: its top from the columns, its side and bottom from the rings.
    across = np.sin(angles) / sin(corner)
    bulge = 0.12 * rim
    core_top = [section.plane(half_width * t, top + bulge * (1.0 - t * t)) for t in across]
    core_side = [
        section.plane(half_width + bulge * 4.0 * s * (1.0 - s), top + (bottom - top) * s)
        for s in np.linspace(0.0, 1.0, sides + 1)[1:]
    ]
    core_bottom = [
        section.plane(half_width * t, bottom - bulge * (1.0 - t * t)) for t in np.linspace(1.0, 0.0, columns + 1)[1:]
    ]
    _plain_row(section, row, core_top)
    _plain_row(section, upper, [core_top[-1], *core_side, *core_bottom])
    _core(section, core_top, [core_top[-1], *core_side], [core_side[-1], *core_bottom][::-1])


def _ring_angles(corner: float, size: float, at_back: int | None = None) -> Array:
    """Angles (n,) in rad, 0 at the contact and π at the back, of rings of about `size` rad from the angle `corner` on.
    at_back: number of rings in the last quarter, from 3/4 π, the edge of what is gripped by default; None: by `size`.
    """
    sides, back = max(2, round((0.75 * pi - corner) / size)), at_back or max(2, round(0.25 * pi / size))
    return np.append(np.linspace(corner, 0.75 * pi, sides + 1), np.linspace(0.75 * pi, pi, back + 1)[1:])


def _rings(section: _Quads, edge: list[int], angles: Array) -> list[int]:
    """Add rings of elements from the points on the columns' outer edge along the angles to the back; return the last
    ring.
    """
    rows = [[node, *(section.polar(float(np.hypot(*section.points[node])), a) for a in angles[1:])] for node in edge]
    for upper, lower in pairwise(rows):
        _plain_row(section, upper, lower)
    return rows[-1]


def _core(section: _Quads, top: list[int], side: list[int], bottom: list[int]) -> None:
    """Add the core's elements by transfinite interpolation between its top, side and bottom; the fourth side is
    y = 0.
    """
    p = np.array(section.points)
    rows, columns = len(side) - 1, len(top) - 1
    previous = top
    for i in range(1, rows + 1):
        s = i / rows
        current = bottom
        if i < rows:
            current = []
            for j in range(columns):
                t = p[top[j], 0] / p[top[-1], 0]
                blend = (1 - s) * p[top[j]] + s * p[bottom[j]]
                corners = (1 - s) * p[top[-1]] + s * p[bottom[-1]]
                y, z = blend + t * (p[side[i]] - corners)
                current.append(section.plane(y if j else 0.0, z))
            current.append(side[i])
        previous = _plain_row(section, previous, current)
