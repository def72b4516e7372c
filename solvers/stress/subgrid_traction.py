"""A contact's tractions between the nodes of its grid: what elements cannot hold where the contact ends.

Where smooth surfaces part, the pressure falls as the root of the distance from the edge (Johnson, Contact Mechanics,
1985, section 5.1). So its square is smooth, and where it becomes zero is the edge. The square is fitted by quadratics
of the nodes around each, as in moving least squares (Lancaster & Salkauskas, Math. Comput. 37 (1981) 141), continued
beyond the edge, which equilibrium then moves by one distance all around until the load is carried: for Hertz's ellipse
the inner nodes give the peak pressure p0, and the load P the area 3 P / (2 p0). Hertz's pressure is reproduced.

A grid of one line only, (n_a, 1), stands for tractions that are alike across it, as those of a line contact.

Tractions are (..., 3): x, y, and z outwards; pressure is negative z.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from geometry.arrays import Array, BoolArray
from solvers.jit_cache import compiled

_LOADED = 0.05  #: Nodes with less than this share of the largest pressure are outside.
_WIDTH = 3.0  #: Of the fits' weights, in elements.
#: Of nodes that share elements with unloaded ones, of those that share them with these, and of the next row: by how
#: much of its change over an element the square may be off for the mesh alone (a cylinder on a flat, 14 to 40 elements:
#: 0.17, 0.12, 0.06); weights in a fit that explains them so, and in one that misses them by twice as much, as it does
#: the pressures of worn surfaces. Other nodes have 1.
_OFF, _DOUBTED, _TRUSTED = (0.25, 0.18, 0.09), (0.001, 0.02, 0.2), (0.2, 1.0, 1.0)
_ROUND_OFF = 1e-12  #: Of squares over the largest one.
_BEYOND = 3  #: The square is continued so many elements beyond the contact.
#: An edge lies no farther out than one element: squares beyond are below zero by this share of the largest one within
#: so many elements.
_OUTSIDE, _NEAREST = 0.3, 4
_MOVED = 0.25  #: How far equilibrium moves an edge at most, in elements.
_MOST_SCALED = 2.0
_SAMPLES = 4
_HALVINGS = 40
#: Weights of the four nodes around a place between the middle two, by powers of the place.
KEYS = 0.5 * np.array([[0.0, -1.0, 2.0, -1.0], [2.0, 0.0, -5.0, 3.0], [0.0, 1.0, 4.0, -3.0], [0.0, 0.0, -1.0, 1.0]])
_POWERS = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))


@dataclass(frozen=True, eq=False)
class SubgridTraction:
    """Tractions on a grid of equal elements: √square × ratio where the square is positive, else none; nodal values,
    bicubic (square) and bilinear (ratio) between the nodes.
    """

    square: Array  #: (n_a, n_t) squared pressure in MPa², negative outside the contact.
    ratio: Array  #: (n_a, n_t, 3) traction over pressure.

    @classmethod
    def of_nodes(cls, traction: Array, lines: tuple[Array, Array] | None = None) -> "SubgridTraction":
        """The field that carries what nodal tractions (n_a, n_t, 3) in MPa carry, along x, y and the outward z; lines:
        see `fitted_square`.
        """
        pressure = np.maximum(-traction[..., 2], 0.0)
        loaded = pressure > _LOADED * pressure.max(initial=0.0)
        if not loaded.any():
            return cls(np.full(pressure.shape, -1.0), np.zeros_like(traction))
        square = carrying(fitted_square(pressure, lines=lines), pressure, lines)
        ratio = _ratios(traction, pressure, loaded)
        return cls(square * _scale(square, pressure) ** 2, ratio)

    def edge(self) -> Array:
        """Points (k, 2), in elements from the first node, where grid lines cross the contact's edge, just inside."""
        return np.asarray(_edge(self.square))


def fitted_square(pressure: Array, trust: float | None = None, lines: tuple[Array, Array] | None = None) -> Array:
    """Squared pressure (n_a, n_t) fitted to nodal pressures (n_a, n_t), some of them positive; it is continued beyond
    the contact, where it is negative.

    trust: weight in the fit of loaded nodes that share elements with unloaded ones, others having 1; None: they and the
    next rows weigh little unless the others' fit misses them.
    lines: places (n_a,) and (n_t,) of the nodes along both axes, in any unit; evenly spaced if not given.
    """
    moments = [_moments(one) for one in lines or [np.arange(1.0 * n) for n in pressure.shape]]
    largest = float(pressure.max()) ** 2
    square, loaded = pressure**2 / largest, pressure > _LOADED * pressure.max()
    doubted = _by_row(loaded, _DOUBTED if trust is None else (trust,), 1.0)
    fit = _fit(square, loaded, doubted, moments)
    if trust is None:
        off = _by_row(loaded, _OFF, np.inf) * np.hypot(fit[..., 1], fit[..., 2])
        missed = np.clip(np.abs(fit[..., 0] - square) / np.maximum(off, _ROUND_OFF) - 1.0, 0.0, 1.0)
        weight = doubted + missed * (_by_row(loaded, _TRUSTED, 1.0) - doubted)
        fit = _fit(square, loaded, weight, moments)
    return largest * _continued(fit[..., 0], loaded)


def carrying(square: Array, pressure: Array, lines: tuple[Array, Array] | None = None) -> Array:
    """A squared pressure (n_a, n_t) with the contact's edge moved until it carries the load of nodal pressures; lines:
    see `fitted_square`.

    A field changed by its slope times a distance has its zero moved by this distance; its peaks stay.
    """
    slope = np.sqrt(sum(np.gradient(square, axis=axis) ** 2 for axis, size in enumerate(square.shape) if size > 1))
    places = [np.arange(1.0 * size) for size in square.shape] if lines is None else lines
    fine, steep = refined(square, _SAMPLES), refined(slope, _SAMPLES)
    near = fine > -_MOVED * steep
    parts, fine, steep = areas_of(refined_lines(places, _SAMPLES))[near], fine[near], steep[near]
    load = float((areas_of(places) * pressure).sum())
    inwards, outwards = -_MOVED, _MOVED
    for _ in range(_HALVINGS):
        moved = 0.5 * (inwards + outwards)
        carried = float(parts @ np.sqrt(np.maximum(fine + moved * steep, 0.0)))
        inwards, outwards = (moved, outwards) if carried < load else (inwards, moved)
    return np.asarray(square + 0.5 * (inwards + outwards) * slope)


def refined_lines(lines: Sequence[Array], parts: int) -> list[Array]:
    """Lines along both axes of the grid on which `refined` gives a field of the grid with these lines."""
    return [np.interp(np.arange((len(one) - 1) * parts + 1) / parts, np.arange(len(one)), one) for one in lines]


def areas_of(lines: Sequence[Array]) -> Array:
    """Areas (n_a, n_t) of the nodes of a grid of lines; one line has a width of 1."""
    return np.outer(*(np.gradient(line) if len(line) > 1 else np.ones(1) for line in lines))


def _by_row(loaded: BoolArray, rows: tuple[float, ...], others: float) -> Array:
    """A value at each node: of the loaded ones by their row from the unloaded on inwards, 0 where nothing is loaded."""
    result, left = np.zeros(loaded.shape), loaded
    for own in (*rows, others):
        result[left] = own
        left = scipy.ndimage.binary_erosion(left, structure=_around_one(loaded))
    return result


def _around_one(grid: Array | BoolArray) -> Array:
    return np.ones((3, 3 if grid.shape[1] > 1 else 1))


def _moments(lines: Array) -> Array:
    """Weights (5, n, n) in the fit at each of n lines of all of them, times powers 0 to 4 of their distance in elements
    as they are there; (5, 1, 1) of one line, which stands for equal ones.
    """
    reach = int(np.ceil(3.0 * _WIDTH)) + _BEYOND
    if len(lines) == 1:
        distance = np.arange(-reach, reach + 1.0)[None]
    else:
        distance = (lines - lines[:, None]) / np.gradient(lines)[:, None]
    weight = np.where(np.abs(distance) < reach + 0.5, np.exp(-0.5 * distance**2 / _WIDTH**2), 0.0)
    found = np.stack([weight * distance**power for power in range(5)])
    return found.sum(axis=2, keepdims=True) if len(lines) == 1 else found


def _fit(square: Array, loaded: BoolArray, weight: Array, moments: list[Array]) -> Array:
    """Quadratics (n_a, n_t, 6), by `_POWERS`, fitted to squares (n_a, n_t) of loaded nodes with weights, at these and a
    few elements around them.
    """

    def moment(values: Array, i: int, j: int) -> Array:
        return np.asarray(moments[0][i] @ values @ moments[1][j].T)

    found: dict[tuple[int, int], Array] = {}
    matrix = np.empty((*square.shape, 6, 6))
    for row, (i, j) in enumerate(_POWERS):
        for column, (k, m) in enumerate(_POWERS):
            powers = (i + k, j + m)
            if powers not in found:
                found[powers] = moment(weight, *powers)
            matrix[..., row, column] = found[powers]
    right = np.stack([moment(weight * square, i, j) for i, j in _POWERS], axis=-1)
    around = scipy.ndimage.binary_dilation(loaded, structure=_around_one(loaded), iterations=_BEYOND)
    chosen = matrix[around]
    # Curvatures that the nodes do not show are small.
    chosen += 1e-6 * chosen[:, :1, :1] * np.diag([0.0, 1.0, 1.0, 1.0, 1.0, 1.0])
    result = np.zeros((*square.shape, 6))
    result[around] = np.linalg.solve(chosen, right[around][..., None])[..., 0]
    return result


def _continued(square: Array, loaded: BoolArray) -> Array:
    """Fitted squares (n_a, n_t), low enough beyond the contact for its edge to lie no farther out than one element."""
    width = 2 * _NEAREST + 1
    inside = scipy.ndimage.grey_dilation(
        np.where(loaded, square, 0.0), footprint=np.ones((width, width if square.shape[1] > 1 else 1))
    )
    near, around = (
        scipy.ndimage.binary_dilation(loaded, structure=_around_one(loaded), iterations=n) for n in (1, _BEYOND)
    )
    square = np.where(near, square, np.minimum(square, -_OUTSIDE * np.maximum(inside, 0.0)))
    # A step to where nothing is fitted would swing back into what is.
    nearest = scipy.ndimage.distance_transform_edt(~around, return_distances=False, return_indices=True)
    return np.asarray(square[tuple(nearest)])


def _ratios(traction: Array, pressure: Array, loaded: BoolArray) -> Array:
    """Traction over pressure at loaded nodes; elsewhere that of those nearby."""
    ratio = np.zeros_like(traction)
    ratio[..., 2] = -1.0
    carrying = _smoothed(np.where(loaded, pressure, 0.0), 1.0)
    for k in (0, 1):
        shear = np.where(loaded, traction[..., k], 0.0)
        around = _smoothed(shear, 1.0)
        mean = np.divide(around, carrying, out=np.zeros_like(around), where=carrying > 1e-9 * pressure.max())
        ratio[..., k] = np.divide(shear, pressure, out=mean, where=loaded)
    return ratio


def _scale(square: Array, pressure: Array) -> Array:
    """By how much the pressure between nodes must be larger to carry, around each node, what the nodes carry."""
    fine = np.sqrt(np.maximum(refined(square, _SAMPLES), 0.0))
    hat = 1.0 - np.abs(np.arange(1 - _SAMPLES, _SAMPLES)) / _SAMPLES
    carried = _summed(fine, hat / _SAMPLES, hat / _SAMPLES)[::_SAMPLES, ::_SAMPLES]
    line = np.array([1.0, 4.0, 1.0]) / 6.0
    is_, should = (_smoothed(each, 2.0) for each in (carried, _summed(pressure, line, line)))
    ratio = np.divide(should, is_, out=np.ones_like(is_), where=is_ > 1e-6 * is_.max())
    return np.asarray(np.clip(ratio, 1.0 / _MOST_SCALED, _MOST_SCALED))


def _summed(values: Array, along: Array, across: Array) -> Array:
    """Sums around each node of a grid with weights that are products; nothing lies beyond it but across one line."""
    first = scipy.ndimage.convolve1d(values, along, axis=0, mode="constant")
    return np.asarray(scipy.ndimage.convolve1d(first, across, axis=1, mode=_beyond(values)))


def _smoothed(values: Array, width: float) -> Array:
    return np.asarray(scipy.ndimage.gaussian_filter(values, width, mode=("constant", _beyond(values))))


def _beyond(values: Array) -> str:
    return "nearest" if values.shape[1] == 1 else "constant"


@compiled
def _edge(square: Array) -> Array:
    found = []
    for axis in range(2 if square.shape[1] > 1 else 1):
        lines, length = square.shape[1 - axis], square.shape[axis] - 1
        for line in range(lines):
            for k in range(length * _SAMPLES):
                inside, outside = k / _SAMPLES, (k + 1) / _SAMPLES
                before, after = _on_line(square, axis, line, inside), _on_line(square, axis, line, outside)
                if (before > 0.0) == (after > 0.0):
                    continue
                if after > 0.0:
                    inside, outside = outside, inside
                for _ in range(_HALVINGS):
                    middle = 0.5 * (inside + outside)
                    if _on_line(square, axis, line, middle) > 0.0:
                        inside = middle
                    else:
                        outside = middle
                found.append((inside, float(line)) if axis == 0 else (float(line), inside))
    result = np.empty((len(found), 2))
    for k in range(len(found)):
        result[k, 0], result[k, 1] = found[k]
    return result


@compiled
def _on_line(square: Array, axis: int, line: int, along: float) -> float:
    return bicubic(square, along, float(line)) if axis == 0 else bicubic(square, float(line), along)


@compiled
def refined(square: Array, parts: int) -> Array:
    """The bicubic field of nodal values (n_a, n_t) on `parts` times as many lines, ((n_a - 1) parts + 1, (n_t - 1)
    parts + 1).
    """
    along, across = (square.shape[0] - 1) * parts + 1, (square.shape[1] - 1) * parts + 1
    result = np.empty((along, across))
    for i in range(along):
        for j in range(across):
            result[i, j] = bicubic(square, i / parts, j / parts)
    return result


@compiled
def bicubic(square: Array, u: float, v: float) -> float:
    """Value of a nodal field at a place (u, v) in elements from its first node, by cubic convolution; -1 beyond the
    grid.

    It reproduces quadratics (Keys, IEEE Trans. Acoust. Speech Signal Process. 29 (1981) 1153).
    """
    if u < 0.0 or v < 0.0 or u > square.shape[0] - 1.0 or v > square.shape[1] - 1.0:
        return -1.0
    i, j = int(np.floor(u)), int(np.floor(v))
    coefficients = np.empty((4, 4))
    bicubic_coefficients(square, i, j, coefficients)
    return polynomial(coefficients, u - i, v - j)


@compiled
def bicubic_coefficients(square: Array, i: int, j: int, result: Array) -> None:
    """Write to `result` (4, 4) the coefficients, at [m, n] of u^m v^n, of the bicubic polynomial that interpolates the
    nodal values `square` by the weights `KEYS` in the cell between the nodes (i, j) and (i + 1, j + 1). u and v go from
    0 to 1 within the cell.
    """
    for m in range(4):
        for n in range(4):
            result[m, n] = 0.0
    for m in range(4):
        row = min(max(i + m - 1, 0), square.shape[0] - 1)
        for n in range(4):
            column = min(max(j + n - 1, 0), square.shape[1] - 1)
            for a in range(4):
                for b in range(4):
                    result[a, b] += KEYS[m, a] * KEYS[n, b] * square[row, column]


@compiled
def polynomial(coefficients: Array, u: float, v: float) -> float:
    """Value of the polynomial of `coefficients` (4, 4), of u^m v^n, at the point (u, v) of a cell."""
    total = 0.0
    for m in range(3, -1, -1):
        row = coefficients[m]
        total = total * u + (((row[3] * v + row[2]) * v + row[1]) * v + row[0])
    return total
