"""What bricks get wrong of the displacements near a loaded node, so that it can be made good.

Near the contact both bodies are half-spaces. There a node that is pressed gives way half as much again in the elements
of the body that carries the tractions, and too little in the other, which sees them spread by the mortar. What it ought
to give way is the mean displacement of its cell under uniform traction on its own. The difference is found wave by
wave: bricks alike along both axes answer a wave of nodal forces with a wave, layer below layer, and a half-space does
so in closed form (Johnson, Contact Mechanics, 1985, sections 3.2 and 3.6, transformed). It fades within a few elements,
as long waves are resolved.

Displacements and forces are (..., 3): x, y, and z outwards.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from geometry import Elastic, HexMesh
from geometry.arrays import Array, ComplexArray, IntArray
from solvers.strain import integration_points

Pair = tuple[float, float]

#: How deep the lattice reaches, in elements.
_DEPTH = 24.0
#: The correction reaches so many of the larger elements.
_REACH = 6.0
#: Shorter waves beneath those that a lattice tells apart, which a cell's uniform traction contains.
_ALIASES = 4
#: Shares of a wave that are left out.
_NEGLIGIBLE = 1e-3
#: Corners of a brick along each axis, in the order of its nodes; the first four are below.
_CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])


@dataclass(frozen=True)
class Bricks:
    """The elements under a contact patch.

    layers: thickness of the uppermost ones in mm, and the factor by which it grows from layer to layer.
    """

    material: Elastic
    layers: Pair


def reach(size_mm: Pair) -> tuple[int, int]:
    """How many elements of a size a correction reaches along each axis."""
    along, across = (int(np.ceil(_REACH * max(size_mm) / each)) for each in size_mm)
    return along, across


@lru_cache(maxsize=256)
def missing_displacement(own: Bricks, own_mm: Pair, other: Bricks, other_mm: Pair, turn: tuple[Pair, Pair]) -> Array:
    """Displacement that two bodies' elements lack about a node of the first by a unit force on it, mm/N.

    Returns (2 a + 1, 2 t + 1, 3, 3) for the nodes up to `reach` away, by component of displacement and force, in the
    first body's axes. The first carries the tractions, the other one faces it; bricks measure `own_mm` and `other_mm`.
    turn: (2, 2) from the first body's plane axes to the other's. The other's lattice may lie anywhere beneath the
    first's: the mean of all places is taken.
    """
    counts = tuple(2 * each + 1 for each in reach(own_mm))
    numbers = (2.0 * np.pi * np.fft.fftfreq(n) for n in counts)
    along, across = (each.ravel() for each in np.meshgrid(*numbers, indexing="ij"))
    lacking = _of_cells(along, across, own_mm, own.material) - _of_bricks(along, across, own_mm, own)
    to_other = np.zeros((3, 3))
    to_other[:2, :2], to_other[2, 2] = turn, -1.0
    lacking += to_other.T @ _lacking_in_other(along, across, own_mm, other, other_mm, to_other) @ to_other
    lacking[0] = 0.0
    found = np.fft.ifft2(lacking.reshape(*counts, 3, 3), axes=(0, 1)).real
    return np.asarray(np.fft.fftshift(found, axes=(0, 1)))


def half_space_response(kx: Array, ky: Array, material: Elastic) -> ComplexArray:
    """Displacement of a half-space's surface by waves of traction of wave numbers (n,) in 1/mm, (n, 3, 3); 0 for 0."""
    size = np.hypot(kx, ky)
    inverse = np.divide(1.0, size, out=np.zeros_like(size), where=size > 0.0)
    n = np.stack([kx * inverse, ky * inverse])
    nu = material.poissons_ratio
    result = np.zeros((len(kx), 3, 3), dtype=np.complex128)
    for i in range(2):
        for j in range(2):
            result[:, i, j] = 2.0 * inverse * ((i == j) - nu * n[i] * n[j])
        result[:, 2, i] = 1j * (1.0 - 2.0 * nu) * inverse * n[i]
        result[:, i, 2] = -result[:, 2, i]
    result[:, 2, 2] = 2.0 * (1.0 - nu) * inverse
    return np.asarray(result * ((1.0 + nu) / material.youngs_modulus_MPa))


def _aliases(along: Array, across: Array, count: int) -> list[tuple[Array, Array, Array]]:
    """Waves that look alike at the nodes, and what share of each a uniform traction on the cells contains."""
    found = []
    for m in range(-count, count + 1):
        for n in range(-count, count + 1):
            x, y = along + 2.0 * np.pi * m, across + 2.0 * np.pi * n
            found.append((x, y, np.sinc(x / (2.0 * np.pi)) * np.sinc(y / (2.0 * np.pi))))
    return found


def _of_cells(along: Array, across: Array, size: Pair, material: Elastic) -> ComplexArray:
    """Mean displacement of cells by waves of forces on cells, each spread evenly over its own, (n, 3, 3)."""
    result = np.zeros((len(along), 3, 3), dtype=np.complex128)
    for x, y, cell in _aliases(along, across, _ALIASES):
        result += (cell**2)[:, None, None] * half_space_response(x / size[0], y / size[1], material)
    return np.asarray(result / (size[0] * size[1]))


def _lacking_in_other(
    along: Array, across: Array, size: Pair, bricks: Bricks, other: Pair, to_other: Array
) -> ComplexArray:
    """What the facing body's bricks lack, in its own axes; they are loaded by hat functions and seen as their means."""
    result = np.zeros((len(along), 3, 3), dtype=np.complex128)
    seen: list[tuple[IntArray, Array, Array]] = []
    for x, y, cell in _aliases(along, across, _ALIASES):
        k = to_other[:2, :2] @ np.stack([x / size[0], y / size[1]])
        result += (cell**2)[:, None, None] * half_space_response(k[0], k[1], bricks.material)
        angles = k * np.array(other)[:, None]
        share = (cell * np.sinc(angles[0] / (2.0 * np.pi)) * np.sinc(angles[1] / (2.0 * np.pi))) ** 4
        which = np.flatnonzero((share > _NEGLIGIBLE) & (np.hypot(*angles) > 0.0))
        seen.append((which, share[which] * other[0] * other[1], angles[:, which]))
    all_angles = np.concatenate([angles for *_, angles in seen], axis=1)
    found = _of_bricks(all_angles[0], all_angles[1], other, bricks)
    weights = np.concatenate([share for _, share, _ in seen])
    np.subtract.at(result, np.concatenate([which for which, *_ in seen]), weights[:, None, None] * found)
    return np.asarray(result / (size[0] * size[1]))


def _of_bricks(along: Array, across: Array, size: Pair, bricks: Bricks) -> ComplexArray:
    """Displacement of nodes by waves of nodal forces, which turn by these angles from node to node, (n, 3, 3).

    A wave of no length is left out: it has none.
    """
    waves = np.exp(1j * (np.outer(along, _CORNERS[:4, 0]) + np.outer(across, _CORNERS[:4, 1])))
    phase = (waves.conj()[:, :, None] * waves[:, None, :]).reshape(-1, 16)
    thickness, growth = bricks.layers
    layers = [thickness]
    while sum(layers) < _DEPTH * max(size):
        layers.append(layers[-1] * growth)
    answer = np.zeros((len(along), 3, 3), dtype=np.complex128)
    for k, stiffness in enumerate(_between_sides(size, np.array(layers[::-1]), bricks.material)):
        below, rise, fall, above = (phase @ stiffness).reshape(len(along), 4, 3, 3).swapaxes(0, 1)
        # The lowest side is held.
        answer = above - fall @ np.linalg.solve(below + answer, rise) if k else above
    return np.asarray(np.linalg.inv(answer))


def _between_sides(size: Pair, thickness_mm: Array, material: Elastic) -> Array:
    """Stiffness of bricks of different thickness, (l, 16, 36): of the pairs of one side's corners with another's, of
    forces on a side (below, above) by displacements of a side.
    """
    count = len(thickness_mm)
    corners = _CORNERS * np.array([*size, 1.0]) * np.stack([np.ones(count), np.ones(count), thickness_mm], -1)[:, None]
    points = integration_points(HexMesh(corners.reshape(-1, 3), np.arange(8 * count).reshape(-1, 8), {}))
    unit = np.tile(np.eye(24).reshape(24, 1, 8, 3), (1, count, 1, 1)).reshape(24, -1, 3)
    columns = np.array([points.internal_forces(points.stresses(material, one)) for one in unit])
    # Axes: side, corner and component moved; layer; side, corner and component of the force.
    forces = columns.reshape(2, 4, 3, count, 2, 4, 3).transpose(3, 5, 1, 4, 0, 6, 2)
    return np.ascontiguousarray(forces.reshape(count, 16, 36))
