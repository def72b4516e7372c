"""Stress at the points of a line contact's surface: as in `surface_stress`, with a half-plane's closed forms.

On the surface of a half-plane only the stress along it depends on tractions elsewhere: by shear at a distance r ahead
it is 2/(π r) times its size, by pressure it is the pressure itself (Johnson, Contact Mechanics, 1985, section 2.5). The
window is the part of the patch, of m nodes, whose lines are evenly spaced; there stresses are corrected.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geometry import ContactPatch, Elastic, PlanarMesh, QuadMesh
from geometry.arrays import Array, BoolArray
from solvers.elasticity.linear_elasticity import components, tensors
from solvers.jit_cache import compiled
from solvers.stress.lattice_error import line_lattice_error
from solvers.stress.subgrid_traction import SubgridTraction, bicubic
from solvers.stress.surface_stress import alike, corrected_nodes, unspread

_DISTANCES = 2000  #: Distances at which shear ahead and behind is summed; their roots are evenly spaced.


@dataclass(frozen=True, eq=False)
class LineSurfaceStress:
    """A planar body's contact patch whose stresses are to be corrected within a window about its middle."""

    mesh: QuadMesh
    patch: ContactPatch
    material: Elastic
    #: Thickness of the uppermost elements in mm, and the factor by which it grows from layer to layer.
    layers: tuple[float, float]

    @classmethod
    def of(cls, body: PlanarMesh, material: Elastic) -> "LineSurfaceStress":
        """The surface of a meshed pad or specimen of this material."""
        geometry = body.geometry
        return cls(body.mesh, body.patch, material, (float(geometry.layers()[0]), geometry.growth))

    @cached_property
    def window(self) -> slice:
        """The slice of the patch's lines that are evenly spaced."""
        return alike(self.patch.axial_mm)

    @property
    def spacing_mm(self) -> float:
        return float(np.diff(self.patch.axial_mm[self.window]).mean())

    @cached_property
    def frames(self) -> Array:
        """(m, 3, 3) matrices from the body's axes into the surface's at the window's nodes; rows: its tangent, y, its
        outward normal.
        """
        points = self.mesh.points[self.patch.nodes[:, 0]]
        slope = np.gradient(points[:, 1], points[:, 0])[self.window]
        size = np.hypot(1.0, slope)
        frames = np.zeros((len(slope), 3, 3))
        frames[:, 0, 0] = frames[:, 2, 2] = 1.0 / size
        frames[:, 0, 2], frames[:, 2, 0] = slope / size, -slope / size
        frames[:, 1, 1] = 1.0
        return frames

    @cached_property
    def stencil(self) -> Array:
        """(2 m - 1, 6, 3) stresses that elements give, around a node, by component of a unit traction at it that falls
        linearly to zero at the next.
        """
        nu, count = self.material.poissons_ratio, len(self.patch.axial_mm[self.window])
        error = line_lattice_error(self.spacing_mm, *self.layers, nu)
        reach, half = count - 1, len(error) // 2
        result = np.zeros((2 * reach + 1, 6, 3))
        result[:, 0, 0] = _by_hat(np.arange(-reach, reach + 1.0))
        result[reach, 0, 2] = result[reach, 2, 2] = result[reach, 4, 1] = result[reach, 5, 0] = 1.0
        result[:, 1] = nu * (result[:, 0] + result[:, 2])
        kept = min(reach, half)
        result[reach - kept : reach + kept + 1] += error[half - kept : half + kept + 1]
        return result

    def under(self, force_N_per_mm: Array) -> "LoadedLine":
        """The surface under forces (n, 3) in N per mm, in the body's axes, at the patch's nodes."""
        traction = unspread(self.patch.axial_mm, force_N_per_mm)[self.window]
        # Of a tilted surface there is more than of the plane beneath it.
        local = np.einsum("iab,ib->ia", self.frames, traction) * self.frames[:, 2, 2, None]
        return LoadedLine(self, local)


@dataclass(frozen=True, eq=False)
class LoadedLine:
    """Tractions (m, 3) in MPa at the nodes of a surface's window, along its tangent, y and its outward normal."""

    surface: LineSurfaceStress
    traction: Array

    @cached_property
    def between(self) -> SubgridTraction:
        return SubgridTraction.of_nodes(self.traction[:, None])

    def edge(self) -> Array:
        """Points (k, 2) in mm of the patch at which the contact ends; their second coordinate is 0."""
        lines = self.surface.patch.axial_mm[self.surface.window]
        along = np.interp(self.between.edge()[:, 0], np.arange(float(len(lines))), lines)
        return np.column_stack([along, np.zeros(len(along))])

    def correction(self, points_mm: Array) -> Array:
        """Stresses (k, 6) in MPa, in the body's axes, to be added to the elements' stresses at points (k, 2) in mm of
        the patch; 0 at points far from the contact or outside the window.
        """
        lines, along_mm = self.surface.patch.axial_mm[self.surface.window], points_mm[:, 0]
        places = np.interp(along_mm, lines, np.arange(float(len(lines))))
        cell = np.clip(np.floor(places + 1e-9).astype(int), 0, len(lines) - 2)
        ahead = np.clip(places - cell, 0.0, 1.0)
        near = (along_mm >= lines[0] - 1e-9) & (along_mm <= lines[-1] + 1e-9)
        # Only nodes that have a weight at the place count.
        near &= (self._near[cell] | (ahead > 1.0 - 1e-9)) & (self._near[cell + 1] | (ahead < 1e-9))
        result = np.zeros((len(along_mm), 6))
        for k in np.flatnonzero(near):
            weights = ((cell[k], 1.0 - ahead[k]), (cell[k] + 1, ahead[k]))
            local = self._exact(places[k]) - sum(w * self._of_elements[node] for node, w in weights)
            frame = sum(w * self.surface.frames[node] for node, w in weights)
            frame /= np.linalg.norm(frame, axis=-1, keepdims=True)
            result[k] = components(frame.T @ tensors(local) @ frame)
        return result

    @cached_property
    def _near(self) -> BoolArray:
        return corrected_nodes(np.abs(self.traction).max(axis=-1), (self.surface.spacing_mm,))

    @cached_property
    def _of_elements(self) -> Array:
        """What elements make of the tractions on a half-plane, at the nodes of the window (m, 6)."""
        count = len(self.traction)
        offset = np.arange(count)[:, None] - np.arange(count)[None] + count - 1
        return np.asarray(np.einsum("ijsc,jc->is", self.surface.stencil[offset], self.traction, optimize=True))

    def _exact(self, place: float) -> Array:
        """The half-plane's stress (6,) by the tractions between the nodes."""
        square, ratio = self.between.square[:, 0], self.between.ratio[:, 0]
        own = np.zeros(3)
        _traction(square, ratio, place, own)
        along = own[2] + 2.0 / np.pi * _pulled(square, ratio, place)
        nu = self.surface.material.poissons_ratio
        return np.array([along, nu * (along + own[2]), own[2], 0.0, own[1], own[0]])


def _by_hat(distance: Array) -> Array:
    """Stress along the surface at distances (n,) from a unit shear that falls to zero over one of them to each side."""
    ahead, here, behind = distance + 1.0, distance, distance - 1.0

    def term(x: Array) -> Array:
        return np.asarray(x * np.log(np.where(x == 0.0, 1.0, np.abs(x))))

    return np.asarray(2.0 / np.pi * (2.0 * term(here) - term(ahead) - term(behind)))


@compiled
def _pulled(square: Array, ratio: Array, place: float) -> float:
    """The integral of the shear ahead less that behind, over the distance."""
    farthest = max(place, len(square) - 1.0 - place) + 1.0
    step = np.sqrt(farthest) / _DISTANCES
    ahead, behind = np.zeros(3), np.zeros(3)
    total = 0.0
    for n in range(_DISTANCES):
        root = (n + 0.5) * step
        _traction(square, ratio, place + root**2, ahead)
        _traction(square, ratio, place - root**2, behind)
        total += 2.0 * step * (ahead[0] - behind[0]) / root
    return total


@compiled
def _traction(square: Array, ratio: Array, place: float, result: Array) -> None:
    """The traction at a place in elements: linear, times the root of the cubic square."""
    result[:] = 0.0
    if place < 0.0 or place > len(square) - 1.0:
        return
    under = bicubic(square.reshape(-1, 1), place, 0.0)
    if under <= 0.0:
        return
    i = min(int(np.floor(place)), len(square) - 2)
    for a in range(3):
        result[a] = np.sqrt(under) * ((1.0 - place + i) * ratio[i, a] + (place - i) * ratio[i + 1, a])
