"""What layers of other materials change of the stress beneath a contact: that of the layered half-space under the same
tractions, less that of the half-space of the body's own material. The layers are as thick everywhere.

Waves and their amplitudes are those of `solvers.elasticity.coats`. Stresses are (..., 6): xx, yy, zz, xy, yz, xz.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy import fft
from scipy.ndimage import map_coordinates

from geometry import ContactPatch, Elastic
from geometry.arrays import Array
from solvers.elasticity.coats import DEEP, Coating, half_space, lifted, plane_modulus

SIDE = 1e-9  #: Share of a depth by which both sides of an interface lie beside it.
_IN_LAYER, _BELOW = 5, 14  #: Depths at which the stress is computed, in each layer and below all.
_WIDER = 3.0  #: The periodic grid over the extent of what is loaded.
_MOST = 243  #: Points of the grid, each way.


@dataclass(frozen=True, eq=False)
class CoatStress:
    """The change of stress in a body by a coating on it, at any points, under tractions (n_a, n_t, 3) in MPa on the
    nodes of its patch, in its own axes.
    """

    coating: Coating
    patch: ContactPatch
    traction_MPa: Array

    def at(self, plane_mm: Array, depth_mm: Array) -> Array:
        """Stresses (n, 6) in MPa at places (n, 2) on the plane and depths (n,) below the surface; beyond the grid 0."""
        levels, values = self._field
        level = np.interp(depth_mm, levels, np.arange(len(levels)), left=0.0, right=len(levels))
        found = [level]
        for places, lines in zip(plane_mm.T, self._lines, strict=True):
            step = lines[1] - lines[0] if len(lines) > 1 else 1.0
            found.append((places - lines[0]) / step if len(lines) > 1 else np.zeros_like(places))
        return np.stack([map_coordinates(values[..., k], found, order=1) for k in range(6)], axis=-1)

    @cached_property
    def _lines(self) -> tuple[Array, Array]:
        """Lines (n_x,) and (n_y,) in mm of a regular grid about what is loaded."""
        found, loaded = [], np.abs(self.traction_MPa).max(axis=2) > 0.0
        for axis, lines in enumerate((self.patch.axial_mm, self.patch.transverse_mm)):
            if len(lines) == 1:
                found.append(lines)
                continue
            at = lines[loaded.any(axis=1 - axis)]
            at = at if at.size else lines
            half = 0.5 * _WIDER * max(float(np.ptp(at)), 4.0 * self.patch.smallest_element)
            count = min(2 * int(np.ceil(half / self.patch.smallest_element)) + 1, _MOST)
            found.append(0.5 * (at[0] + at[-1]) + np.linspace(-half, half, count))
        return found[0], found[1]

    @cached_property
    def _field(self) -> tuple[Array, Array]:
        """Depths (l,) in mm, both sides of each interface among them, and stresses (l, n_x, n_y, 6) there."""
        x, y = self._lines
        places = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
        nodes, weights, _ = self.patch.locate(places)
        traction = np.einsum("kc,kci->ki", weights, self.traction_MPa.reshape(-1, 3)[nodes]).reshape(len(x), len(y), 3)
        waves = fft.fft2(traction, axes=(0, 1))
        numbers = [2.0 * np.pi * fft.fftfreq(len(own), own[1] - own[0] if len(own) > 1 else 1.0) for own in (x, y)]
        kx, ky = np.meshgrid(*numbers, indexing="ij")
        k = np.hypot(kx, ky)
        k[0, 0] = 1e-3 * k[k > 0.0].min()
        c, s = kx / k, ky / k
        c[0, 0] = 1.0
        p, r, pressed = (
            -1j * (c * waves[..., 0] + s * waves[..., 1]),
            c * waves[..., 1] - s * waves[..., 0],
            waves[..., 2],
        )
        depths = self._depths()
        radial = np.geomspace(0.9 * k.min(), 1.1 * k.max(), 300)
        plain = Coating((), self.coating.below)
        change = _waves(self.coating, radial, depths) - _waves(plain, radial, depths)
        place = np.interp(np.log(k), np.log(radial), np.arange(len(radial)))
        low = np.minimum(place.astype(int), len(radial) - 2)
        part = place - low
        result = np.zeros((len(depths), len(x), len(y), 6))
        for stress, of in zip(result, change, strict=True):
            ez, zz, ee, tt, tz, et = (
                row[low] * (1.0 - part)[..., None] + row[low + 1] * part[..., None] for row in of.transpose(1, 0, 2)
            )
            by = np.stack([p, pressed, r], axis=-1)
            ez, zz, ee, tt, tz, et = (
                1j * (ez * by).sum(-1), (zz * by).sum(-1), (ee * by).sum(-1), (tt * by).sum(-1),
                (tz * by).sum(-1), 1j * (et * by).sum(-1),
            )  # fmt: skip
            # The mean has no direction.
            ee[0, 0] = tt[0, 0] = 0.5 * (ee[0, 0] + tt[0, 0])
            ez[0, 0] = tz[0, 0] = et[0, 0] = 0.0
            inner = np.stack([
                c * c * ee + s * s * tt - 2.0 * c * s * et,
                s * s * ee + c * c * tt + 2.0 * c * s * et,
                zz,
                c * s * (ee - tt) + (c * c - s * s) * et,
                s * ez + c * tz,
                c * ez - s * tz,
            ], axis=-1)  # fmt: skip
            stress[...] = fft.ifft2(inner, axes=(0, 1)).real
        return depths, result

    def _depths(self) -> Array:
        faces = np.cumsum([0.0, *(thickness for thickness, _ in self.coating.layers)])
        inside = [
            low + (high - low) * np.linspace(SIDE if low else 0.0, 1.0 - SIDE, _IN_LAYER)
            for low, high in pairwise(faces)
        ]
        reach = max(float(np.ptp(own)) for own in self._lines)
        below = np.geomspace(0.25 * max(faces[-1], self.patch.smallest_element), reach, _BELOW)
        return np.concatenate([*inside, [faces[-1] * (1.0 + SIDE)], faces[-1] + below])


def across_interface(stress: Array, here: Elastic, there: Elastic) -> Array:
    """Stresses (n, 6) on the other side of an interface of constant z between a material and another: tractions and
    strains in its plane go through.
    """
    nu, mu = here.poissons_ratio, there.poissons_ratio
    x, y, z = stress[:, 0], stress[:, 1], stress[:, 2]
    along, across = ((one - nu * (other + z)) / here.youngs_modulus_MPa for one, other in ((x, y), (y, x)))
    found = stress.copy()
    found[:, 0] = plane_modulus(there) * (along + mu * across) + mu / (1.0 - mu) * z
    found[:, 1] = plane_modulus(there) * (across + mu * along) + mu / (1.0 - mu) * z
    found[:, 3] *= there.shear_modulus_MPa / here.shear_modulus_MPa
    return found


def _waves(coating: Coating, k: Array, depths_mm: Array) -> Array:
    """Stresses (l, n, 6, 3) ez/i, zz, ee, tt, tz, et/i at depths (l,) under waves of numbers k (n,) of tractions P, S
    and R of unit size.
    """
    faces = np.cumsum([0.0, *(thickness for thickness, _ in coating.layers)])
    cuts = np.unique(np.concatenate([faces, depths_mm]))
    spans = []
    for low, high in pairwise(cuts):
        at = int(np.searchsorted(faces, 0.5 * (low + high), side="right")) - 1
        spans.append((low, high, coating.layers[at][1] if at < len(coating.layers) else coating.below))
    plane, across = half_space(coating.below)
    # Compliances at the upper face of each span, from the lowest up; and how tractions go down through it.
    now, aside = np.broadcast_to(plane, (len(k), 2, 2)), np.full(len(k), across)
    down = []
    for low, high, material in reversed(spans):
        depth = k * (high - low)
        above, beside, through, ratio = lifted(now, aside, np.minimum(depth, DEEP), material)
        felt = depth < DEEP
        down.append((now, aside, through * felt[:, None, None], ratio * felt))
        now, aside = above, beside
    down.reverse()
    traction, sideways = np.broadcast_to(np.eye(2), (len(k), 2, 2)), np.ones(len(k))
    at_cuts = [_stress(now, aside, traction, sideways, spans[0][2])]
    both = [at_cuts[0]]
    for (_, _, material), (below, beside, through, ratio) in zip(spans, down, strict=True):
        traction, sideways = through @ traction, ratio * sideways
        # A depth belongs to the material above it, but for the first.
        both.append(_stress(below, beside, traction, sideways, material))
    return np.array([both[int(np.searchsorted(cuts, depth))] for depth in depths_mm])


def _stress(plane: Array, across: Array, traction: Array, sideways: Array, material: Elastic) -> Array:
    """Stresses (n, 6, 3) as in `_waves`, in a material where the compliance below is known and tractions arrive."""
    moved = plane @ traction
    nu = material.poissons_ratio
    found = np.zeros((len(sideways), 6, 3))
    found[:, 0, :2], found[:, 1, :2] = traction[:, 0], traction[:, 1]
    found[:, 2, :2] = nu / (1.0 - nu) * traction[:, 1] - plane_modulus(material) * moved[:, 0]
    found[:, 3, :2] = nu * (found[:, 2, :2] + found[:, 1, :2])
    found[:, 4, 2] = sideways
    found[:, 5, 2] = material.shear_modulus_MPa * across * sideways
    return found
