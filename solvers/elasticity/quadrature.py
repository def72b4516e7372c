"""Integrals of one body's surface over the supports of another body's nodes, at Gauss points of the latter's patch.

A node's support is the cells around it; integrals are weighted with its bilinear shape function.
"""

from typing import NamedTuple

import numpy as np

from geometry import ContactPatch
from geometry.arrays import Array, BoolArray, IntArray
from solvers.elasticity.nodal_transfer import (
    ROUND_OFF,
    CommonAxes,
    GaussLines,
    NodalTransfer,
    cell_of,
    transfer_along_axes,
)
from solvers.jit_cache import compiled, inlined


class GaussPoints(NamedTuple):
    """The Gauss points of all cells around some nodes, in the axes of the other body."""

    first: IntArray  #: (c_a, c_t) index of each cell's first point, -1 for cells not around the nodes.
    positions: Array  #: (g, 2) in the other body's axes, mm.
    axes: CommonAxes | None  #: From the nodes' axes to the other body's; None unless these differ by a multiple of 90°.


def points_about(nodes: IntArray, along: GaussLines, across: GaussLines, turn: Array, offset_mm: Array) -> GaussPoints:
    """The Gauss points around nodes (k,) of a patch, at `turn @ (position - offset)` in the other body's axes.

    along, across: Gauss points on the patch's lines.  turn: (2, 2) from the patch's axes to the other body's.
    offset_mm: (2,) position of its origin in the patch's axes.
    """
    found = _points(nodes, along.positions, across.positions, len(across.positions) + 1, turn, offset_mm)
    return GaussPoints(*found, CommonAxes.of(turn, offset_mm))


class Integrals(NamedTuple):
    """Integrals over the supports of k nodes, weighted with their shape functions; the surface is the other body's."""

    area: Array  #: (k,), mm².
    height: Array  #: (k,) of the worn surface's height, mm³.
    slope: Array  #: (k, 2) of the worn surface's slope in its patch's axes, mm².
    moment: Array  #: (k, 2) of the positions in that patch's axes, mm³.
    transfer: NodalTransfer  #: From nodal fields of the other body to their integrals over the k supports.
    outside: BoolArray  #: (k,) True if a part of the support lies outside the other body's patch.


def integrals(
    nodes: IntArray,
    points: GaussPoints,
    along: GaussLines,
    across: GaussLines,
    patch: ContactPatch,
    depth_mm: Array,
    depth_gradient: Array,
) -> Integrals:
    """Integrals of the surface of `patch`, worn by depths (n_a, n_t), over the supports of nodes (k,) of another patch.

    points: around these nodes, in the axes of `patch`.  along, across: Gauss points of the nodes' own patch.
    depth_gradient: (n, 2) gradient of the depth at the nodes of `patch`, as from `gradient`.
    """
    fresh = patch.profile.height(points.positions), patch.profile.slope(points.positions)
    steps = along.lengths, across.lengths, along.lower, across.lower
    if points.axes is None:
        outside, first, columns, weights = _transfer(
            nodes, points.first, points.positions, *steps, patch.axial_mm, patch.transverse_mm
        )
    else:
        outside, first, columns, weights = transfer_along_axes(nodes, along, across, points.axes, patch)
    transfer = NodalTransfer(first, columns, weights, patch.size)
    worn = depth_mm.ravel(), depth_gradient
    sums = _sums(nodes, points.first, points.positions, *steps, *fresh, transfer, *worn)
    return Integrals(*sums, transfer, outside)


def gradient(field: Array, patch: ContactPatch) -> Array:
    """Gradient (n, 2) along and across a patch at its nodes, of a field (n_a, n_t), by central differences; one-sided
    at edges, 0 across a planar body.
    """
    return _gradient(np.ascontiguousarray(field), patch.axial_mm, patch.transverse_mm)


def at_points(positions: Array, patch: ContactPatch, weights: Array) -> NodalTransfer:
    """The transfer from a patch's nodal fields to their values at positions (k, 2) in mm in its axes, times `weights`
    (k,); 0 at positions outside the patch.
    """
    corner, shares, _ = _located(np.ascontiguousarray(positions), patch.axial_mm, patch.transverse_mm)
    planar, across = len(patch.transverse_mm) == 1, len(patch.transverse_mm)
    step = np.array([0, 1]) if planar else np.array([0, 1, across, across + 1])
    entries = shares[:, : len(step)] * weights[:, None]
    first = np.arange(len(positions) + 1) * len(step)
    return NodalTransfer(first, (corner[:, None] + step).ravel(), entries.ravel(), patch.size)


@compiled
def _points(
    nodes: IntArray, along: Array, across: Array, per_row: int, turn: Array, offset: Array
) -> tuple[IntArray, Array]:
    planar = across.shape[0] == 1 and across.shape[1] == 1
    count_t = 1 if planar else per_row
    first = np.full((along.shape[0], across.shape[0]), -1)
    used = 0
    size = along.shape[1] * across.shape[1]
    for k in range(len(nodes)):
        i, j = nodes[k] // count_t, nodes[k] % count_t
        for a in range(max(i - 1, 0), min(i + 1, along.shape[0])):
            for t in range(max(j - 1, 0), min(j + 1, across.shape[0])):
                if first[a, t] < 0:
                    first[a, t] = used
                    used += size
    positions = np.empty((used, 2))
    for a in range(along.shape[0]):
        for t in range(across.shape[0]):
            point = first[a, t]
            if point < 0:
                continue
            for p in range(along.shape[1]):
                for q in range(across.shape[1]):
                    x, y = along[a, p] - offset[0], across[t, q] - offset[1]
                    positions[point, 0] = turn[0, 0] * x + turn[0, 1] * y
                    positions[point, 1] = turn[1, 0] * x + turn[1, 1] * y
                    point += 1
    return first, positions


@compiled
def _gradient(field: Array, along: Array, across: Array) -> Array:
    rows, columns = field.shape
    result = np.zeros((rows * columns, 2))
    for i in range(rows):
        for j in range(columns):
            if i == 0:
                result[j, 0] = (field[1, j] - field[0, j]) / (along[1] - along[0])
            elif i == rows - 1:
                result[i * columns + j, 0] = (field[i, j] - field[i - 1, j]) / (along[i] - along[i - 1])
            else:
                before, after = along[i] - along[i - 1], along[i + 1] - along[i]
                rise = before * before * (field[i + 1, j] - field[i, j]) + after * after * (
                    field[i, j] - field[i - 1, j]
                )
                result[i * columns + j, 0] = rise / (before * after * (before + after))
            if columns == 1:
                continue
            if j == 0:
                result[i * columns, 1] = (field[i, 1] - field[i, 0]) / (across[1] - across[0])
            elif j == columns - 1:
                result[i * columns + j, 1] = (field[i, j] - field[i, j - 1]) / (across[j] - across[j - 1])
            else:
                before, after = across[j] - across[j - 1], across[j + 1] - across[j]
                rise = before * before * (field[i, j + 1] - field[i, j]) + after * after * (
                    field[i, j] - field[i, j - 1]
                )
                result[i * columns + j, 1] = rise / (before * after * (before + after))
    return result


@compiled
def _located(positions: Array, along: Array, across: Array) -> tuple[IntArray, Array, BoolArray]:
    """First corner (g,) of the cell around each point, weights (g, 4) of its corners, whether it lies on the patch
    (g,).

    A planar body's cells have two corners.
    """
    count_t = len(across)
    corner = np.empty(len(positions), dtype=np.int64)
    weights = np.zeros((len(positions), 4))
    inside = np.empty(len(positions), dtype=np.bool_)
    i = j = 0
    for g in range(len(positions)):
        i = cell_of(along, positions[g, 0], i)
        u = (positions[g, 0] - along[i]) / (along[i + 1] - along[i])
        v = 0.0
        if count_t > 1:
            j = cell_of(across, positions[g, 1], j)
            v = (positions[g, 1] - across[j]) / (across[j + 1] - across[j])
        corner[g] = i * count_t + j
        inside[g] = -ROUND_OFF <= u <= 1.0 + ROUND_OFF and -ROUND_OFF <= v <= 1.0 + ROUND_OFF
        if inside[g]:
            if count_t == 1:
                weights[g, 0], weights[g, 1] = 1.0 - u, u
                continue
            weights[g, 0], weights[g, 1] = (1.0 - u) * (1.0 - v), (1.0 - u) * v
            weights[g, 2], weights[g, 3] = u * (1.0 - v), u * v
    return corner, weights, inside


@compiled
def field_at(field: Array, positions: Array, along: Array, across: Array) -> tuple[Array, BoolArray]:
    """A patch's nodal field (n_a, n_t) at positions (g, 2) in its axes, and whether they lie on the patch, (g,).

    along, across: (n_a,) and (n_t,) grid lines of the patch.
    """
    step = np.array([0, 1]) if len(across) == 1 else np.array([0, 1, len(across), len(across) + 1])
    corner, weights, inside = _located(positions, along, across)
    values, flat = np.zeros(len(positions)), field.ravel()
    for g in range(len(positions)):
        for c in range(len(step)):
            values[g] += weights[g, c] * flat[corner[g] + step[c]]
    return values, inside


@compiled
def _sums(
    nodes: IntArray,
    first: IntArray,
    positions: Array,
    lengths_a: Array,
    lengths_t: Array,
    lower_a: Array,
    lower_t: Array,
    height_at: Array,
    slope_at: Array,
    transfer: NodalTransfer,
    depth: Array,
    gradient: Array,
) -> tuple[Array, Array, Array, Array]:
    """Area, height, slope and moment as in `Integrals` of a surface, from its unworn heights and slopes at the points,
    less its worn depth (n,) and the depth's gradient (n, 2), which the transfer averages.
    """
    own_t = _lines_across(lengths_t)
    count = len(nodes)
    area, height, slope, moment = np.empty(count), np.empty(count), np.empty((count, 2)), np.empty((count, 2))
    for k in range(count):
        i, j = nodes[k] // own_t, nodes[k] % own_t
        # Sums apart from the arrays, which the compiler cannot keep in registers: this is a run's innermost loop.
        covered = up = slope_a = slope_t = moment_a = moment_t = 0.0
        for a in range(max(i - 1, 0), min(i + 1, first.shape[0])):
            for t in range(max(j - 1, 0), min(j + 1, first.shape[1])):
                g = first[a, t]
                for p in range(len(lower_a)):
                    shape_a = lengths_a[a, p] * (lower_a[p] if a == i else 1.0 - lower_a[p])
                    for q in range(len(lower_t)):
                        weight = shape_a * lengths_t[t, q] * (lower_t[q] if t == j else 1.0 - lower_t[q])
                        covered += weight
                        moment_a += weight * positions[g, 0]
                        moment_t += weight * positions[g, 1]
                        up += weight * height_at[g]
                        slope_a += weight * slope_at[g, 0]
                        slope_t += weight * slope_at[g, 1]
                        g += 1
        fallen = steeper_a = steeper_t = 0.0
        for entry in range(transfer.first[k], transfer.first[k + 1]):
            node, weight = transfer.columns[entry], transfer.weights[entry]
            fallen += weight * depth[node]
            steeper_a += weight * gradient[node, 0]
            steeper_t += weight * gradient[node, 1]
        up, slope_a, slope_t = up - fallen, slope_a - steeper_a, slope_t - steeper_t
        area[k], height[k] = covered, up
        slope[k, 0], slope[k, 1], moment[k, 0], moment[k, 1] = slope_a, slope_t, moment_a, moment_t
    return area, height, slope, moment


@inlined
def _lines_across(lengths: Array) -> int:
    """Number of grid lines across a patch with cells of these lengths; 1 for a planar body, of one cell of length 1."""
    return 1 if lengths.shape[0] == 1 and lengths.shape[1] == 1 else lengths.shape[0] + 1


@compiled
def _transfer(
    nodes: IntArray,
    first: IntArray,
    positions: Array,
    lengths_a: Array,
    lengths_t: Array,
    lower_a: Array,
    lower_t: Array,
    along: Array,
    across: Array,
) -> tuple[BoolArray, IntArray, IntArray, Array]:
    """Integrals of products of hat functions, for axes at any angle: whether each support leaves the patch, (k,), and
    first, columns and weights as in `NodalTransfer`.
    """
    own_t = _lines_across(lengths_t)
    # Of the four corners about a point only two are nodes on a planar body.
    step = np.array([0, 1]) if len(across) == 1 else np.array([0, 1, len(across), len(across) + 1])
    corner, weights, inside = _located(positions, along, across)
    count, q_a, q_t = len(nodes), len(lower_a), len(lower_t)
    outside = np.zeros(count, dtype=np.bool_)
    rows = np.zeros(count + 1, dtype=np.int64)
    capacity = 16 * count * len(step)
    columns, entries = np.empty(capacity, dtype=np.int64), np.empty(capacity)
    place = np.full(len(along) * len(across), -1)
    used = 0
    for k in range(count):
        i, j = nodes[k] // own_t, nodes[k] % own_t
        begin = used
        for a in range(max(i - 1, 0), min(i + 1, first.shape[0])):
            for t in range(max(j - 1, 0), min(j + 1, first.shape[1])):
                for p in range(q_a):
                    shape_a = lengths_a[a, p] * (lower_a[p] if a == i else 1.0 - lower_a[p])
                    for q in range(q_t):
                        g = first[a, t] + p * q_t + q
                        weight = shape_a * lengths_t[t, q] * (lower_t[q] if t == j else 1.0 - lower_t[q])
                        outside[k] |= not inside[g] and weight > 0.0
                        if used + len(step) > len(columns):
                            columns = np.concatenate((columns, np.empty_like(columns)))
                            entries = np.concatenate((entries, np.empty_like(entries)))
                        for c in range(len(step)):
                            node, share = corner[g] + step[c], weights[g, c]
                            if share == 0.0:
                                continue
                            if place[node] < begin:
                                place[node] = used
                                columns[used], entries[used] = node, 0.0
                                used += 1
                            entries[place[node]] += weight * share
        rows[k + 1] = used
    return outside, rows, columns[:used].copy(), entries[:used].copy()
