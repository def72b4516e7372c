"""What bricks make of the stresses on a half-space's surface: their error for tractions bilinear between nodes.

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

from geometry import Elastic, HexMesh
from geometry.arrays import Array
from geometry.elements import BRICK
from solvers.elasticity.linear_elasticity import TENSOR_PLACES, IntegrationPoints, integration_points

ComplexArray = NDArray[np.complexfloating]

#: Nodes of the lattice along each axis before it repeats; odd, so that no wave alternates from node to node.
_PERIOD = 41
_DEPTH = 60.0  #: How deep the lattice reaches, in elements: longer than its longest wave.
_ALIASES = 12  #: Shorter waves beneath those that the lattice resolves, which a bilinear traction contains.
#: Corners of a brick along each axis, in the order of its nodes.
_CORNERS = (BRICK.nodes + 1.0) / 2.0
_OF_TRACTION = ((2, 2), (4, 1), (5, 0))  #: Stress components that are the traction itself: zz, yz, xz of z, y, x.


@lru_cache(maxsize=32)
def lattice_error(
    along_mm: float, across_mm: float, first_layer_mm: float, growth: float, poissons_ratio: float
) -> Array:
    """Stress in the surface of a lattice of bricks less the stress in a half-space's, by a traction that is 1 at one
    node and falls bilinearly to zero at its neighbours.

    Returns (_PERIOD, _PERIOD, 6, 3): that error, per unit of traction, at the nodes around the loaded one, which is in
    the middle, along and across; by component of stress and component of traction. Bricks measure `along_mm` by
    `across_mm` in the surface; the thickness of their layers grows from `first_layer_mm` by the factor `growth`.
    """
    forward = _waves()[: _PERIOD // 2 + 1]
    along, across = (each.ravel() for each in np.meshgrid(forward, forward, indexing="ij"))
    layers = _layers(first_layer_mm, growth, _DEPTH * max(along_mm, across_mm))
    error = _error(along, across, (along_mm, across_mm), layers, poissons_ratio)
    error = error.reshape(len(forward), len(forward), 6, 3)
    for axis in (0, 1):
        # Waves that run backwards are mirror images.
        sides = np.where(np.arange(3) == axis, -1.0, 1.0)
        of_stress = np.array([sides[i] * sides[j] for i, j in TENSOR_PLACES])
        backward = np.flip(error, axis).take(range(_PERIOD // 2), axis) * of_stress[:, None] * sides
        error = np.concatenate([error, backward], axis)
    stencil = np.fft.ifft2(error, axes=(0, 1)).real
    return np.asarray(np.fft.fftshift(stencil, axes=(0, 1)))


@lru_cache(maxsize=32)
def line_lattice_error(along_mm: float, first_layer_mm: float, growth: float, poissons_ratio: float) -> Array:
    """`lattice_error` for quadrilaterals in plane strain, (_PERIOD, 6, 3): their stress less a half-plane's.

    It is computed by bricks under waves that do not change across, for which their width does not matter.
    """
    along = _waves()
    layers = _layers(first_layer_mm, growth, _DEPTH * along_mm)
    error = _error(along, np.zeros_like(along), (along_mm, along_mm), layers, poissons_ratio)
    return np.asarray(np.fft.fftshift(np.fft.ifft(error, axis=0).real, axes=0))


def surface_response(kx: Array, ky: Array, poissons_ratio: float) -> ComplexArray:
    """Stress (n, 6, 3) in a half-space's surface, by component, under waves of traction of unit amplitude. kx, ky: (n,)
    wave numbers; at 0 what depends on the direction is the mean of all directions.
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
        """Matrices of a brick, one hexahedron, under n waves. phase: (n, 8, 8) complex; [:, c, d] is what a wave is at
        corner d over what it is at corner c.
        """
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
