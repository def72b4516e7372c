"""Half of a straight wire or tube in hexahedra of 20 nodes, which bend, for wires that lie on several contacts."""

from math import pi

import numpy as np

from geometry.arrays import Array
from geometry.elements import BRICK, ELEMENT_KINDS
from geometry.solid import SolidMesh

_SECTORS, _LAYERS = 8, 2  #: Elements around half of the circumference, and across a ring.


def bar_mesh(radius_mm: float, bore_radius_mm: float, lines_mm: Array) -> SolidMesh:
    """The half y >= 0 of a wire or tube about the x axis, cut into slices at `lines_mm`; bore_radius_mm is 0 for a
    wire. Middles of edges on its surfaces lie on the circle.
    """
    section = _half_section(radius_mm, bore_radius_mm)
    count = len(lines_mm) - 1
    corners = np.empty((count, len(section), 8, 3))
    for half, lines in ((slice(0, 4), lines_mm[:-1]), (slice(4, 8), lines_mm[1:])):
        corners[:, :, half, 0], corners[:, :, half, 1:] = lines[:, None, None], section
    shapes = BRICK.shapes(ELEMENT_KINDS[20].nodes)
    points = shapes @ corners.reshape(-1, 8, 3)
    away = np.hypot(points[..., 1], points[..., 2])
    for radius in (radius_mm, bore_radius_mm):
        on = np.abs(np.hypot(corners[..., 1], corners[..., 2]).reshape(-1, 8) - radius) < 1e-9 * radius_mm
        round_, scale = on @ shapes.T > 1.0 - 1e-9, radius / np.where(away > 0.0, away, 1.0)
        points[..., 1:] *= np.where(round_, scale, 1.0)[..., None]
    # Nodes within so much of each other, over the radius, are one.
    places, first, cells = np.unique(
        np.rint(points.reshape(-1, 3) / (1e-6 * radius_mm)), axis=0, return_index=True, return_inverse=True
    )
    del places
    return SolidMesh(points.reshape(-1, 3)[first], {20: cells.reshape(-1, 20)}, {}, {})


def _half_section(radius: float, bore: float) -> Array:
    """Corners (m, 4, 2) of quadrilaterals as (y >= 0, z), counter-clockwise."""
    angles = np.linspace(0.0, pi, _SECTORS + 1)
    around = np.column_stack([np.sin(angles), np.cos(angles)])
    around[[0, -1], 0] = 0.0
    inner, core = bore * around, np.zeros((0, 4, 2))
    if not bore:
        steps = 0.4 * radius * np.linspace(-1.0, 1.0, 5)  # Of a square core.
        y, z = np.meshgrid(steps[2:], steps, indexing="ij")
        grid = np.stack([y, z], axis=-1)
        core = np.stack([grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]], axis=2).reshape(-1, 4, 2)
        inner = np.concatenate([grid[:, -1], grid[-1, -2::-1], grid[-2::-1, 0]])
    share = np.linspace(0.0, 1.0, _LAYERS + 1)[:, None, None]
    ring = (1.0 - share) * inner + share * radius * around
    rings = np.stack([ring[:-1, :-1], ring[:-1, 1:], ring[1:, 1:], ring[1:, :-1]], axis=2).reshape(-1, 4, 2)
    return np.concatenate([core, rings])
