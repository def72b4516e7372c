"""A contact's tractions between the nodes of its grid: what elements cannot hold where the contact ends.

Where smooth surfaces part, the pressure falls as the root of the distance from the edge (Johnson, Contact Mechanics,
1985, section 5.1). So its square is smooth, and where it becomes zero is the edge. The square is fitted by quadratics
of the nodes around each, as in moving least squares (Lancaster & Salkauskas, Math. Comput. 37 (1981) 141), continued
beyond the edge, and scaled so that it carries the nodes' forces. Hertz's pressure is reproduced.

A grid of one line only, (n_a, 1), stands for tractions that are alike across it, as those of a line contact.

What bricks make of the stresses on a half-space's surface: their error for tractions bilinear between nodes.

Bricks that are alike along both axes, layer below layer, answer a wave of nodal forces with a wave. So their response
is found wave by wave: the stiffness between two levels of nodes becomes a matrix (6, 6), layers are eliminated from
below, stresses at integration points are projected to nodes as on a mesh. The half-space answers the same wave in
closed form (Johnson, Contact Mechanics, 1985, sections 2.5 and 3.6, transformed). The difference, summed over waves, is
short: long waves are resolved.

Stresses are (..., 6) in VTK's order: xx, yy, zz, xy, yz, xz. Tractions are (..., 3): x, y, and z outwards; pressure is
negative z.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, convolve1d, distance_transform_edt, gaussian_filter, grey_dilation

from geometry import Elastic, HexMesh
from geometry.arrays import Array, BoolArray
from geometry.elements import BRICK
from solvers.elasticity.strain import IntegrationPoints, integration_points
from solvers.jit_cache import compiled

ComplexArray = NDArray[np.complexfloating]

#: Nodes of the lattice along each axis before it repeats; odd, so that no wave alternates from node to node.
_PERIOD = 41
_DEPTH = 24.0  #: How deep the lattice reaches, in elements.
_ALIASES = 12  #: Shorter waves beneath those that the lattice resolves, which a bilinear traction contains.
#: Corners of a brick along each axis, in the order of its nodes.
_CORNERS = (BRICK.nodes + 1.0) / 2.0
_OF_TRACTION = ((2, 2), (4, 1), (5, 0))  #: Stress components that are the traction itself: zz, yz, xz of z, y, x.


@lru_cache(maxsize=32)
def lattice_error(
    along_mm: float, across_mm: float, first_layer_mm: float, growth: float, poissons_ratio: float
) -> Array:
    """Elements' surface stress less the half-space's by a unit traction at one node, bilinear to zero at the next.

    Returns (2 w + 1, 2 w + 1, 6, 3): at the nodes up to w away along and across, by component of stress and traction.
    Bricks measure `along_mm` by `across_mm`; the layers' thickness grows from `first_layer_mm` by the factor `growth`.
    """
    along, across = (each.ravel() for each in np.meshgrid(_waves(), _waves(), indexing="ij"))
    layers = _layers(first_layer_mm, growth, _DEPTH * max(along_mm, across_mm))
    error = _error(along, across, (along_mm, across_mm), layers, poissons_ratio)
    stencil = np.fft.ifft2(error.reshape(_PERIOD, _PERIOD, 6, 3), axes=(0, 1)).real
    return np.asarray(np.fft.fftshift(stencil, axes=(0, 1)))


@lru_cache(maxsize=32)
def line_lattice_error(along_mm: float, first_layer_mm: float, growth: float, poissons_ratio: float) -> Array:
    """Stencil (2 w + 1, 6, 3) of the error of a half-plane's quadrilaterals, from waves that do not change across.

    Under these, bricks are quadrilaterals in plane strain, whatever their width.
    """
    along = _waves()
    layers = _layers(first_layer_mm, growth, _DEPTH * along_mm)
    error = _error(along, np.zeros_like(along), (along_mm, along_mm), layers, poissons_ratio)
    return np.asarray(np.fft.fftshift(np.fft.ifft(error, axis=0).real, axes=0))


def surface_response(kx: Array, ky: Array, poissons_ratio: float) -> ComplexArray:
    """Stress in a half-space's surface by waves of traction of wave numbers (n,), (n, 6, 3).

    Of what depends on the direction, the mean of all directions for a constant traction.
    """
    size = np.hypot(kx, ky)
    inverse = np.divide(1.0, size, out=np.zeros_like(size), where=size > 0.0)
    n = np.stack([kx * inverse, ky * inverse])
    nu = poissons_ratio
    result = np.zeros((len(kx), 6, 3), dtype=complex)
    for row, component in _OF_TRACTION:
        result[:, row, component] = 1.0
    for row, (i, j) in ((0, (0, 0)), (1, (1, 1)), (3, (0, 1))):
        same = float(i == j)
        for c in range(2):
            direct = n[i] * (j == c) + n[j] * (i == c)
            result[:, row, c] = 1j * (direct - 2.0 * nu * n[i] * n[j] * n[c] + 2.0 * nu * same * n[c])
        result[:, row, 2] = 2.0 * nu * same + (1.0 - 2.0 * nu) * np.where(size > 0.0, n[i] * n[j], 0.5 * same)
    return result


def _of_half_space(kx: Array, ky: Array, size: tuple[float, float], nu: float) -> ComplexArray:
    """The response at nodes to bilinear tractions with a wave of nodal values, (n, 6, 3)."""
    result = np.zeros((len(kx), 6, 3), dtype=complex)
    shorter = np.arange(-_ALIASES, _ALIASES + 1)
    for m in shorter:
        for n in shorter:
            x, y = kx + 2.0 * np.pi * m / size[0], ky + 2.0 * np.pi * n / size[1]
            share = (np.sinc(x * size[0] / (2.0 * np.pi)) * np.sinc(y * size[1] / (2.0 * np.pi))) ** 2
            result += share[:, None, None] * surface_response(x, y, nu)
    for row, component in _OF_TRACTION:
        # What the shorter waves that are left out would add up to.
        result[:, row, component] = 1.0
    return result


def _waves() -> Array:
    return np.asarray(2.0 * np.pi * np.fft.fftfreq(_PERIOD))


def _error(along: Array, across: Array, size: tuple[float, float], layers: Array, nu: float) -> ComplexArray:
    """Elements' stress less the half-space's by waves (n,) of bilinear traction, (n, 6, 3); none of the longest."""
    found = _of_elements(along, across, size, layers, nu)
    found *= (size[0] * size[1] * (2.0 + np.cos(along)) * (2.0 + np.cos(across)) / 9.0)[:, None, None]
    error = found - _of_half_space(along / size[0], across / size[1], size, nu)
    error[0] = 0.0
    return error


def _layers(first: float, growth: float, depth: float) -> Array:
    layers = [first]
    while sum(layers) < depth:
        layers.append(layers[-1] * growth)
    return np.array(layers)


def _of_elements(along: Array, across: Array, size: tuple[float, float], layers: Array, nu: float) -> ComplexArray:
    """Projected stress at the surface's nodes by a wave of nodal forces, (n, 6, 3)."""
    material = Elastic(1.0, nu)
    offset = np.exp(1j * (np.outer(along, _CORNERS[:, 0]) + np.outer(across, _CORNERS[:, 1])))
    phase = offset.conj()[:, :, None] * offset[:, None, :]
    bricks = [_Brick.of(_brick(size, thickness), material, phase) for thickness in layers]
    steps: list[ComplexArray] = []
    answer = bricks[-1].stiffness[:, 0, 0]
    for upper in bricks[-2::-1]:
        steps.append(-np.linalg.solve(upper.stiffness[:, 1, 1] + answer, upper.stiffness[:, 1, 0]))
        answer = upper.stiffness[:, 0, 0] + upper.stiffness[:, 0, 1] @ steps[-1]
    moved = [np.linalg.inv(answer)]
    for step in reversed(steps):
        moved.append(step @ moved[-1])
    moved.append(np.zeros_like(moved[-1]))
    return _projected(bricks, moved)


@dataclass(frozen=True, eq=False)
class _Brick:
    """A layer of equal bricks under waves of displacement: n waves, two sides (above, below)."""

    stiffness: ComplexArray  #: (n, 2, 2, 3, 3) forces on a side by displacements of a side.
    loads: ComplexArray  #: (n, 2, 2, 6, 3) integrals of stress times shape functions.
    mass: ComplexArray  #: (n, 2, 2) of products of shape functions.

    @classmethod
    def of(cls, points: IntegrationPoints, material: Elastic, phase: ComplexArray) -> "_Brick":
        """phase: (n, 8, 8) by which a wave differs between two corners."""
        unit = np.eye(24).reshape(24, 8, 3)
        stress = np.array([points.stresses(material, one)[0] for one in unit])
        forces = np.array([points.internal_forces(one[None]) for one in stress]).reshape(8, 3, 8, 3)
        loads = np.einsum("qc,kqs,q->kcs", points.shapes, stress, points.volumes[0]).reshape(8, 3, 8, 6)
        mass = np.einsum("qc,qd,q->cd", points.shapes, points.shapes, points.volumes[0])
        # Corners 4 to 7 are above.
        above = np.array([[0, 0, 0, 0, 1, 1, 1, 1], [1, 1, 1, 1, 0, 0, 0, 0]], dtype=float)
        return cls(
            np.einsum("ncd,sc,td,dbca->nstab", phase, above, above, forces, optimize=True),
            np.einsum("ncd,sc,td,dbca->nstab", phase, above, above, loads, optimize=True),
            np.einsum("ncd,sc,td,cd->nst", phase, above, above, mass, optimize=True),
        )


def _brick(size: tuple[float, float], thickness: float) -> IntegrationPoints:
    corners = _CORNERS * np.array([*size, thickness])
    return integration_points(HexMesh(corners, np.arange(8)[None], {}))


def _projected(bricks: list[_Brick], moved: list[ComplexArray]) -> ComplexArray:
    """Stresses (n, 6, 3) at the uppermost nodes, as projected in the mean square, by displacements of all levels."""
    levels = len(moved)
    loads = [np.zeros((len(moved[0]), 6, 3), dtype=complex) for _ in range(levels)]
    mass = [np.zeros(len(moved[0]), dtype=complex) for _ in range(levels)]
    for k, brick in enumerate(bricks):
        for side in range(2):
            mass[k + side] = mass[k + side] + brick.mass[:, side, side]
            for other in range(2):
                loads[k + side] = loads[k + side] + brick.loads[:, side, other] @ moved[k + other]
    value, weight = loads[-1], mass[-1]
    for k in range(levels - 2, -1, -1):
        down, up = bricks[k].mass[:, 0, 1], bricks[k].mass[:, 1, 0]
        value = loads[k] - (down / weight)[:, None, None] * value
        weight = mass[k] - down * up / weight
    return np.asarray(value / weight[:, None, None])


_LOADED = 0.05  #: Nodes with less than this share of the largest pressure are outside.
#: Width of the fits' weights, in elements, and the weight of nodes that share elements with unloaded ones.
_WIDTH = 2.5
_BEYOND = 3  #: The square is continued so many elements beyond the contact.
#: An edge lies no farther out than one element: squares beyond are below zero by this share of the largest one within
#: so many elements.
_OUTSIDE, _NEAREST = 0.3, 4
_MOST_SCALED = 2.0
_SAMPLES = 4
_HALVINGS = 40
#: Weights of the four nodes around a place between the middle two, by powers of the place.
KEYS = 0.5 * np.array([[0.0, -1.0, 2.0, -1.0], [2.0, 0.0, -5.0, 3.0], [0.0, 1.0, 4.0, -3.0], [0.0, 0.0, -1.0, 1.0]])
_POWERS = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))


@dataclass(frozen=True, eq=False)
class SubgridTraction:
    """Tractions on a grid of equal elements: √square times ratio, between nodes bicubic and bilinear."""

    square: Array  #: (n_a, n_t) in MPa², negative outside.
    ratio: Array  #: (n_a, n_t, 3) of the traction to the pressure.

    @classmethod
    def of_nodes(cls, traction: Array) -> "SubgridTraction":
        """From tractions (n_a, n_t, 3) at the nodes: x, y, and z outwards."""
        pressure = np.maximum(-traction[..., 2], 0.0)
        loaded = pressure > _LOADED * pressure.max(initial=0.0)
        if not loaded.any():
            return cls(np.full(pressure.shape, -1.0), np.zeros_like(traction))
        square = fitted_square(pressure)
        ratio = _ratios(traction, pressure, loaded)
        return cls(square * _scale(square, pressure) ** 2, ratio)

    def edge(self) -> Array:
        """Points (k, 2) where lines of the grid leave the contact, in elements from the first node, just inside."""
        return np.asarray(_edge(self.square))


def fitted_square(pressure: Array, trust_at_edge: float = 0.2) -> Array:
    """Square (n_a, n_t) of pressures at nodes, some of them positive, as it is fitted: negative outside the contact.

    trust_at_edge: weight of nodes that share elements with unloaded ones.
    """
    largest = float(pressure.max()) ** 2
    return largest * _fitted(pressure**2 / largest, pressure > _LOADED * pressure.max(), trust_at_edge)


def _fitted(square: Array, loaded: BoolArray, trust_at_edge: float) -> Array:
    """Quadratics fitted to squares (n_a, n_t) of loaded nodes, at these and a few elements around them."""
    around_one = np.ones((3, 3 if square.shape[1] > 1 else 1))
    inner = ~binary_dilation(~loaded, structure=around_one, border_value=1)
    trust = np.where(loaded, np.where(inner, 1.0, trust_at_edge), 0.0)
    reach = int(np.ceil(3.0 * _WIDTH)) + _BEYOND
    # A node at +d counts for the fit here: convolution turns the offset round.
    d = -np.arange(-reach, reach + 1.0)
    weight = np.exp(-0.5 * d**2 / _WIDTH**2)

    def moment(values: Array, i: int, j: int) -> Array:
        return _summed(values, weight * d**i, weight * d**j)

    found: dict[tuple[int, int], Array] = {}
    matrix = np.empty((*square.shape, 6, 6))
    for row, (i, j) in enumerate(_POWERS):
        for column, (k, m) in enumerate(_POWERS):
            powers = (i + k, j + m)
            if powers not in found:
                found[powers] = moment(trust, *powers)
            matrix[..., row, column] = found[powers]
    right = np.stack([moment(trust * square, i, j) for i, j in _POWERS], axis=-1)
    around = binary_dilation(loaded, structure=around_one, iterations=_BEYOND)
    near = binary_dilation(loaded, structure=around_one)
    chosen = matrix[around]
    # Curvatures that the nodes do not show are small.
    chosen += 1e-6 * chosen[:, :1, :1] * np.diag([0.0, 1.0, 1.0, 1.0, 1.0, 1.0])
    result = np.zeros(square.shape)
    result[around] = np.linalg.solve(chosen, right[around][..., None])[:, 0, 0]
    width = 2 * _NEAREST + 1
    inside = grey_dilation(
        np.where(loaded, result, 0.0), footprint=np.ones((width, width if square.shape[1] > 1 else 1))
    )
    result[~near] = np.minimum(result, -_OUTSIDE * np.maximum(inside, 0.0))[~near]
    # A step to where nothing is fitted would swing back into what is.
    nearest = distance_transform_edt(~around, return_distances=False, return_indices=True)
    return np.asarray(result[tuple(nearest)])


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
    first = convolve1d(values, along, axis=0, mode="constant")
    return np.asarray(convolve1d(first, across, axis=1, mode=_beyond(values)))


def _smoothed(values: Array, width: float) -> Array:
    return np.asarray(gaussian_filter(values, width, mode=("constant", _beyond(values))))


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
    """The bicubic field on lines `parts` times as many, from the first node to the last."""
    along, across = (square.shape[0] - 1) * parts + 1, (square.shape[1] - 1) * parts + 1
    result = np.empty((along, across))
    for i in range(along):
        for j in range(across):
            result[i, j] = bicubic(square, i / parts, j / parts)
    return result


@compiled
def bicubic(square: Array, u: float, v: float) -> float:
    """A field at a place in elements from its first node, by cubic convolution; far outside beyond the grid.

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
    """Set the coefficients (4, 4) of the bicubic field in the cell behind a node, by powers of the place in it."""
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
    """Its value at a place in the cell."""
    total = 0.0
    for m in range(3, -1, -1):
        row = coefficients[m]
        total = total * u + (((row[3] * v + row[2]) * v + row[1]) * v + row[0])
    return total
