"""Layers of other materials on a half-space: how they change its surface's compliance, and the stresses below.

A wave of tractions of number k runs along e, with t across it and z outwards. Displacements are (i U, T, W) exp(i k
e.x), tractions on planes of constant z are (i P, R, S) k exp(i k e.x), all of U to S real. A matrix of the material
alone carries them through a thickness k z. The compliance C with (U, W) = C (P, S) is carried in place of them, from
the half-space's upwards, so that nothing grows exponentially (Burmister, J. Appl. Phys. 16 (1945) 89, solves the same
equations).

In the plane the change of compliance is a sum of Gaussians, whose means over cells of a grid are products of a factor
along and one across, exact for cells of any size. A node answers by what wear has left of the layers there, a pair of
nodes by the mean of both, as in `PatchCompliance.with_neighbours`.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy

from geometry import ContactPatch, Elastic
from geometry.arrays import Array, IntArray
from solvers.elasticity.patch_compliance import PatchCompliance
from solvers.jit_cache import compiled

DEEP = 14.0  #: k z beyond which nothing is felt of what lies below.
_RATIO = 1.8  #: Of the widths of neighbouring Gaussians.
_CHANGED = 0.02  #: Of a coating's thickness: less that has worn does not count.
_OF_CONTACT = 2.4  #: Number of the wave that stands for a contact's pressure, over its radius.
_LEVELS = 25  #: Of what is left of a coating, between which is interpolated.


@dataclass(frozen=True)
class Coating:
    """Layers on a body, the outermost first, as (thickness in mm, material), and the material below them."""

    layers: tuple[tuple[float, Elastic], ...]
    below: Elastic

    @cached_property
    def thickness_mm(self) -> float:
        return sum(thickness for thickness, _ in self.layers)

    def worn(self, depth_mm: float) -> "Coating":
        """What is left of it under a surface worn by this depth (>= 0)."""
        left = []
        for thickness, material in self.layers:
            rest = max(thickness - depth_mm, 0.0)
            depth_mm = max(depth_mm - thickness, 0.0)
            left += [(rest, material)] if rest > 0.0 else []
        return Coating(tuple(left), self.below)

    def softening(self, k: Array) -> tuple[Array, Array]:
        """What the layers add to the surface's compliance under waves of numbers k (n,) in 1/mm: (n, 2, 2) to U and W
        by P and S, (n,) to T by R, in mm/MPa of tractions that are not divided by k.
        """
        plane, across = half_space(self.below)
        now, aside = np.broadcast_to(plane, (len(k), 2, 2)), np.full(len(k), across)
        for thickness, material in reversed(self.layers):
            now, aside = _through(now, aside, k * thickness, material)
        return (now - plane) / k[:, None, None], (aside - across) / k

    def felt(self, radius_mm: float) -> Elastic:
        """The half-space that yields as much under a contact of this radius, by the wave that stands for its pressure:
        contacts of coatings 0.25 to 4 times as stiff and 0.1 to 2 radii thick are then as wide within 2.4 %.
        """
        k = np.array([_OF_CONTACT / radius_mm])
        softened = 2.0 / plane_modulus(self.below) + k[0] * self.softening(k)[0][0, 1, 1]
        nu = self.below.poissons_ratio
        return Elastic(float(2.0 * (1.0 - nu**2) / softened), nu)


def plane_modulus(material: Elastic) -> float:
    return material.youngs_modulus_MPa / (1.0 - material.poissons_ratio**2)


def _rates(material: Elastic) -> Array:
    """Matrix (4, 4) of the derivatives of U, W, P and S by k z."""
    shear, lame = material.shear_modulus_MPa, material.lame_MPa
    confined = lame + 2.0 * shear
    return np.array([
        [0.0, -1.0, 1.0 / shear, 0.0],
        [lame / confined, 0.0, 0.0, 1.0 / confined],
        [plane_modulus(material), 0.0, 0.0, -lame / confined],
        [0.0, 0.0, 1.0, 0.0],
    ])  # fmt: skip


def half_space(material: Elastic) -> tuple[Array, float]:
    """Compliance (2, 2) of U and W by P and S, and of T by R (Johnson, Contact Mechanics, 1985, section 3.2)."""
    nu = material.poissons_ratio
    size, coupled = 2.0 * (1.0 - nu), 1.0 - 2.0 * nu
    plane = (1.0 + nu) / material.youngs_modulus_MPa * np.array([[size, -coupled], [-coupled, size]])
    return plane, 1.0 / material.shear_modulus_MPa


def _through(plane: Array, across: Array, depth: Array, material: Elastic) -> tuple[Array, Array]:
    """The compliances (n, 2, 2) and (n,) on top of a layer of thicknesses k z = depth (n,) from those at its bottom."""
    depth = np.minimum(depth, DEEP)
    steps = int(np.ceil(depth.max()))
    for _ in range(steps):
        plane, across, _, _ = lifted(plane, across, depth / steps, material)
    return plane, across


def lifted(plane: Array, across: Array, depth: Array, material: Elastic) -> tuple[Array, Array, Array, Array]:
    """The compliances (n, 2, 2) and (n,) on top of a part of a layer from those at its bottom, and what tractions there
    are of those on top: (n, 2, 2) of P and S, (n,) of R. depth: (n,) thicknesses k z, of at most `DEEP`.
    """
    over, soft = _carried(depth, material), 1.0 / material.shear_modulus_MPa
    down = np.asarray(np.linalg.inv(over[:, 2:, :2] @ plane + over[:, 2:, 2:]), dtype=np.float64)
    turn, part = np.tanh(depth), across / soft
    whole = 1.0 + part * turn
    above = (over[:, :2, :2] @ plane + over[:, :2, 2:]) @ down
    return above, soft * (part + turn) / whole, down, 1.0 / (np.cosh(depth) * whole)


def _carried(depth: Array, material: Elastic) -> Array:
    """Matrices (n, 4, 4) that carry U, W, P and S up through thicknesses k z = depth (n,)."""
    one = _rates(material)
    # Its eigenvalues are 1 and -1, twice each: its exponential is a cubic of itself.
    x = depth[:, None, None]
    sinh, cosh = np.sinh(x), np.cosh(x)
    even = (cosh - 0.5 * x * sinh) * np.eye(4) + 0.5 * x * sinh * (one @ one)
    return np.asarray(even + 0.5 * (3.0 * sinh - x * cosh) * one + 0.5 * (x * cosh - sinh) * (one @ one @ one))


@dataclass(frozen=True, eq=False)
class CoatedPatch:
    """A patch's compliance, to which that of coatings on it and on the body that faces it is to be added.

    coatings: of the patch's own body and of the other one, None for none. The other's layers shift with their body,
    but act as they stand at mid-stroke, and what is left of both as the mean over the mirror images of the patch.
    """

    patch: ContactPatch
    bare: PatchCompliance
    coatings: tuple[Coating | None, Coating | None]

    def left_mm(self, own_mm: Array, other_mm: Array) -> Array:
        """Thicknesses (2, q) left of both coatings at the nodes of the patch's piece, where the bodies are worn by
        these depths (n,) at the patch's nodes.
        """
        found = np.zeros((2, *self.patch.shape))
        for k, (coating, worn) in enumerate(zip(self.coatings, (own_mm, other_mm), strict=True)):
            if coating is not None:
                found[k] = np.clip(coating.thickness_mm - worn.reshape(found[k].shape), 0.0, coating.thickness_mm)
        for axis in self.bare.planes:
            found = 0.5 * (found + np.flip(found, 1 + axis))
        return np.asarray(found.reshape(2, -1)[:, self.bare.piece_nodes()])

    def differs(self, one_mm: Array, other_mm: Array) -> bool:
        """True if thicknesses (2, q) left of both coatings differ by as much as counts."""
        whole = [np.inf if coating is None else coating.thickness_mm for coating in self.coatings]
        return bool((np.abs(one_mm - other_mm).max(axis=1) > _CHANGED * np.array(whole)).any())

    def compliance(self, left_mm: Array) -> PatchCompliance:
        """The compliance with coatings of which `left_mm` (2, q) is left."""
        blocks, q = self.bare.blocks.copy(), left_mm.shape[1]
        answers = np.zeros((4, len(self._widths_mm), q))
        for sign, coating, table, left in zip((1.0, -1.0), self.coatings, self._answers, left_mm, strict=True):
            if coating is not None:
                at = (_LEVELS - 1) * np.sqrt(left / coating.thickness_mm)
                low = np.minimum(at.astype(int), _LEVELS - 2)
                found = table[low] + (at - low)[:, None, None] * (table[low + 1] - table[low])
                # Outwards of the other body is inwards of this one.
                answers += np.moveaxis(found, 0, -1) * np.array([1.0, 1.0, 1.0, sign])[:, None, None]
        turn, sides = self.bare.rotation, self.bare.sides
        _add_coats(blocks, sides, np.ascontiguousarray(0.5 * answers), turn, *self._factors)
        return replace(self.bare, blocks=blocks)

    @cached_property
    def _widths_mm(self) -> Array:
        """Standard deviations (m,) of the Gaussians: from a part of a cell to more than the patch."""
        lines = [own for own in (self.patch.axial_mm, self.patch.transverse_mm) if len(own) > 1]
        low, high = 0.15 * self.patch.smallest_element, 8.0 * max(np.ptp(own) for own in lines)
        return np.asarray(low * _RATIO ** np.arange(np.log(high / low) / np.log(_RATIO) + 1.0))

    @cached_property
    def _answers(self) -> list[Array]:
        """For each coating, the sizes (levels, 4, m) of Gaussians at levels of what is left of it, see `_gaussians`."""
        found = []
        for coating in self.coatings:
            sizes = np.zeros((_LEVELS, 4, len(self._widths_mm)))
            for k in range(1, _LEVELS):
                if coating is not None:
                    worn = coating.thickness_mm * (1.0 - (k / (_LEVELS - 1)) ** 2)
                    sizes[k] = _gaussians(coating.worn(worn), self._widths_mm)
            found.append(sizes)
        return found

    @cached_property
    def _factors(self) -> tuple[Array, Array]:
        """Factors (2, 3, m, l, l) along and across of the Gaussians between the piece's lines: on the same side and on
        the other; themselves, their first and their second derivatives.
        """
        found = []
        for axis, lines in enumerate((self.patch.axial_mm, self.patch.transverse_mm)):
            means = _between_cells(lines, self._widths_mm)
            half = len(lines) // 2 if axis in self.bare.planes else 0
            other = means[:, :, half:, half::-1] if axis in self.bare.planes else means
            found.append(np.stack([means[:, :, half:, half:], other]))
        return found[0], found[1]


def _gaussians(coating: Coating, widths_mm: Array) -> Array:
    """Sizes (4, m) of Gaussians of these standard deviations (m,) whose sum is what a coating adds to the compliance:
    in all directions of the plane, normal to it, and potentials of what differs along a wave and of what couples both.
    """
    k = np.geomspace(0.5 / widths_mm[-1], 2.5 / widths_mm[0], 8 * len(widths_mm))
    plane, across = coating.softening(k)
    size = k[:, None] * widths_mm
    bell = np.exp(-0.5 * size**2)
    wanted = (across, plane[:, 1, 1], plane[:, 0, 0] - across, -plane[:, 1, 0])
    found = []
    for values, power in zip(wanted, (0, 0, 2, 1), strict=True):
        weight = 1.0 / np.maximum(np.abs(values), 1e-3 * np.abs(values).max(initial=1e-30))
        basis = weight[:, None] * size**power * bell
        found.append(np.linalg.lstsq(basis, weight * values, rcond=1e-9)[0] * widths_mm**power)
    return np.array(found)


def _between_cells(lines: Array, widths_mm: Array) -> Array:
    """Means (3, m, l, l) over two cells of nodes on `lines` (l,) of normal densities of their distance, with standard
    deviations (m,), and of their first and second derivatives; 1, 0 and 0 for a single line.
    """
    if len(lines) == 1:
        return np.array([1.0, 0.0, 0.0])[:, None, None, None] * np.ones((1, len(widths_mm), 1, 1))
    middles = 0.5 * (lines[1:] + lines[:-1])
    low, high = np.append(lines[0], middles), np.append(middles, lines[-1])
    result = np.zeros((3, len(widths_mm), len(lines), len(lines)))
    for moved, loaded, sign in ((high, low, 1.0), (low, low, -1.0), (high, high, -1.0), (low, high, 1.0)):
        x = (moved[:, None] - loaded) / widths_mm[:, None, None]
        bell, part = np.exp(-0.5 * x**2) / np.sqrt(2.0 * np.pi), scipy.special.ndtr(x)
        width = widths_mm[:, None, None]
        result += sign * np.stack([width * (x * part + bell), part, bell / width])
    result /= np.outer(high - low, high - low)
    result[np.abs(result) < 1e-12 * np.abs(result).max(axis=(2, 3), keepdims=True)] = 0.0
    return result


@compiled
def _add_coats(blocks: Array, sides: IntArray, answers: Array, turn: Array, along: Array, across: Array) -> None:
    """Add to `blocks` (2^p, 3 q, 3 q) what Gaussians of sizes `answers` (4, m, q) at each node add, in place.

    sides: (2^p, 2) 1 where an image of the piece is reversed along an axis. turn: (3, 3) from the body's axes.
    """
    rows, columns = along.shape[3], across.shape[3]
    sums = np.zeros((6, columns))
    for image in range(len(blocks)):
        x, y = along[sides[image, 0]], across[sides[image, 1]]
        mirror = np.array([1.0 - 2.0 * sides[image, 0], 1.0 - 2.0 * sides[image, 1], 1.0])
        for a in range(rows):
            for b in range(rows):
                for t in range(columns):
                    _summed(sums, answers, x[:, :, a, b], y[:, :, t], a * columns + t, b * columns)
                    _put(blocks[image], sums, mirror, turn, a * columns + t, b * columns)


@compiled
def _summed(sums: Array, answers: Array, x: Array, y: Array, own: int, first: int) -> None:
    """Set `sums` (6, t), what node `own` moves by forces on those of a line, `first` and on: xx, xy, yy, zx, zy, zz.

    x, y: (3, m) and (3, m, t) factors along and across.
    """
    for s in range(sums.shape[1]):
        for n in range(6):
            sums[n, s] = 0.0
    for m in range(x.shape[1]):
        x0, x1, x2 = x[0, m], x[1, m], x[2, m]
        if x0 == 0.0 and x1 == 0.0 and x2 == 0.0:
            continue
        plain, normal, along_wave, coupled = (
            answers[0, m, own],
            answers[1, m, own],
            answers[2, m, own],
            answers[3, m, own],
        )
        for s in range(sums.shape[1]):
            y0, y1, y2, other = y[0, m, s], y[1, m, s], y[2, m, s], first + s
            even = (plain + answers[0, m, other]) * x0 * y0
            odd, slope = along_wave + answers[2, m, other], coupled + answers[3, m, other]
            sums[0, s] += even - odd * x2 * y0
            sums[1, s] -= odd * x1 * y1
            sums[2, s] += even - odd * x0 * y2
            sums[3, s] += slope * x1 * y0
            sums[4, s] += slope * x0 * y1
            sums[5, s] += (normal + answers[1, m, other]) * x0 * y0


@compiled
def _put(block: Array, sums: Array, mirror: Array, turn: Array, own: int, first: int) -> None:
    """Add `sums` to a block, forces mirrored and all turned."""
    local = np.zeros((3, 3))
    for s in range(sums.shape[1]):
        local[0, 0], local[0, 1], local[0, 2] = sums[0, s], sums[1, s], -sums[3, s]
        local[1, 0], local[1, 1], local[1, 2] = sums[1, s], sums[2, s], -sums[4, s]
        local[2, 0], local[2, 1], local[2, 2] = sums[3, s], sums[4, s], sums[5, s]
        for u in range(3):
            for v in range(3):
                for c in range(3):
                    for d in range(3):
                        block[3 * own + u, 3 * (first + s) + v] += turn[u, c] * local[c, d] * mirror[d] * turn[v, d]
