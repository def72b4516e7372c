"""Stress at the points of a contact's surface: the elements' field, corrected between the nodes by superposition.

Elements hold no stress that changes within one of them, as the tension behind a sliding contact does, which has a cusp
at the contact's very edge (Hamilton, Proc. Inst. Mech. Eng. 197C (1983) 53). Near the surface a body is a half-space.
So from the elements' field is taken what they make of the contact's tractions on a half-space, and the closed-form
field of these tractions (Boussinesq, Cerruti: Johnson, Contact Mechanics, 1985, section 3.2) is put in its place. What
remains of the elements' field is smooth: the body's size, its curvature, its grip. Both fields are summed over a few
elements around a point only: farther away elements resolve them.

The window is the part of the patch on which this is done, a grid of (m_a, m_t) evenly spaced lines about the patch's
middle. Stresses are (..., 6): xx, yy, zz, xy, yz, xz, tension positive; a traction's normal part is negative in
pressure.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache

import numpy as np
from scipy.fft import next_fast_len
from scipy.linalg import solve_banded
from scipy.ndimage import distance_transform_edt

from geometry import BodyMesh, ContactPatch, Elastic, HexMesh
from geometry.arrays import Array, BoolArray, IntArray
from solvers.elasticity.linear_elasticity import components, tensors
from solvers.stress.lattice_error import ComplexArray, lattice_error
from solvers.stress.nearby_tractions import half_space_stress
from solvers.stress.subgrid_traction import SubgridTraction

_ALIKE = 0.02  #: Elements are alike that differ by no more than this share.
_LOADED = 1e-6  #: Share of the largest traction that counts as some.
#: What differs from its mirror image by no more than this share is its own: its stresses are computed on one side.
_MIRRORED = 1e-9
_ACROSS = np.array([1.0, -1.0])  #: The mirror image about y = 0 of a point of the plane,
_IMAGE = np.array([1.0, 1.0, 1.0, -1.0, -1.0, 1.0])  #: and of a stress.


@dataclass(frozen=True, eq=False)
class SurfaceStress:
    """Surface of a meshed body's patch, whose stresses by elements are corrected between nodes, within a window about
    its middle; mm, MPa.
    """

    mesh: HexMesh
    patch: ContactPatch
    material: Elastic
    #: Thickness of the uppermost elements in mm, and the factor by which it grows from layer to layer.
    layers: tuple[float, float]
    #: Distances (along, across) from the middle in mm: if elements shrink towards the patch's rim, the window is as
    #: fine as those at this place; infinite: as the finest.
    place_mm: tuple[float, float] = (np.inf, np.inf)
    _elsewhere: dict[tuple[float, float], "SurfaceStress"] = field(default_factory=dict, repr=False)

    @classmethod
    def of(cls, body: BodyMesh, material: Elastic) -> "SurfaceStress":
        """The surface of a meshed body of this material."""
        return cls(body.mesh, body.patch, material, body.geometry.layers)

    @cached_property
    def lines(self) -> tuple[Array, Array]:
        """Lines along and across, in mm, of the window in which stresses are corrected."""
        return window_lines(self.patch.axial_mm), window_lines(self.patch.transverse_mm)

    @property
    def spacing_mm(self) -> tuple[float, float]:
        """Spacing along and across of `lines` on either side of the place."""
        along, across = (_spacing(lines, place) for lines, place in zip(self.lines, self.place_mm, strict=True))
        return along, across

    def on_lines(self, nodal: Array) -> Array:
        """Values `nodal` (n_a, n_t, ...) at the patch's nodes, of those the window's (m_a, m_t, ...)."""
        known = self.patch.axial_mm, self.patch.transverse_mm
        chosen = (np.flatnonzero(np.isin(all_lines, own)) for all_lines, own in zip(known, self.lines, strict=True))
        return np.asarray(nodal[np.ix_(*chosen)])

    @cached_property
    def window_normals(self) -> Array:
        return self.on_lines(self.normals)

    @cached_property
    def normals(self) -> Array:
        """(n_a, n_t, 3) outward unit normals at the patch's nodes."""
        facets = self.mesh.surfaces["contact"]
        corners = self.mesh.points[facets]
        areas = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
        total = np.zeros_like(self.mesh.points)
        np.add.at(total, facets, areas[:, None])
        found = total[self.patch.nodes]
        return np.asarray(found / np.linalg.norm(found, axis=-1, keepdims=True))

    @property
    def stencil(self) -> Array:
        """(2 w + 1, 2 w + 1, 6, 3) stresses that elements give, around a node, by component of a unit traction at it
        that falls bilinearly to zero at the next; none beyond w nodes.
        """
        return _stencil(*self._elements)

    @property
    def _elements(self) -> tuple[float, float, float, float, float]:
        """Sizes of the elements along and across and thickness of the first layer, over the mean of both sizes; growth
        of the layers; Poisson's ratio. Rounded, so that elements alike are one case: stencils take a second each.
        """
        (along, across), (first, growth) = self.spacing_mm, self.layers
        mean = np.sqrt(along * across)
        # Proportions of elements that differ beyond these decimals are the same.
        along, across, first = (round(float(size / mean), 9) for size in (along, across, first))
        return along, across, first, growth, self.material.poissons_ratio

    @cached_property
    def waves(self) -> tuple[tuple[int, int], ComplexArray]:
        """A size (rows, columns) of the grid on which the stencil's sums over the window do not come round, and the
        stencil's Fourier transform (rows, columns // 2 + 1, 6, 3) on it.
        """
        return _waves(*self._elements, *(len(lines) for lines in self.lines))

    @cached_property
    def is_symmetric(self) -> bool:
        """True if the window's lines and normals are their own mirror images about y = 0."""
        across, normals = self.lines[1], self.window_normals
        alike_lines = np.allclose(across, -across[::-1], rtol=0.0, atol=_MIRRORED * self.spacing_mm[1])
        return bool(alike_lines and np.abs(normals - normals[:, ::-1] * [1.0, -1.0, 1.0]).max() < _MIRRORED)

    def under(self, force_N: Array) -> "LoadedSurface":
        """The surface under forces (n, 3) in N in the body's axes at the patch's nodes, in the order of the grid."""
        patch = self.patch
        plane = force_N.reshape(*patch.shape, 3)
        for axis, lines in enumerate((patch.axial_mm, patch.transverse_mm)):
            plane = np.moveaxis(unspread(lines, np.moveaxis(plane, axis, 0)), 0, axis)
        window = self._at_trailing_edge(force_N)
        frames = _frames(window.window_normals)
        # Of a tilted surface there is more than of the plane beneath it.
        local = np.einsum("ijab,ijb->ija", frames, window.on_lines(plane)) * frames[..., 2, 2, None]
        return LoadedSurface(window, local)

    def _at_trailing_edge(self, force_N: Array) -> "SurfaceStress":
        """This surface, its elements being taken for those where the shear of forces (n, 3) ends: the tension is
        largest there.
        """
        places = np.abs(self.patch.grid()[np.abs(force_N[:, 2]) > _LOADED * np.abs(force_N[:, 2]).max(initial=0.0)])
        shear = np.abs(force_N[:, :2].sum(axis=0))
        if not len(places) or not shear.any():
            return self
        ends = places.max(axis=0) * shear / np.linalg.norm(shear)
        along, across = (
            float(lines[np.searchsorted(lines, end, side="right") - 1])
            for lines, end in zip((self.patch.axial_mm, self.patch.transverse_mm), ends, strict=True)
        )
        if (along, across) not in self._elsewhere:
            self._elsewhere[along, across] = replace(self, place_mm=(along, across), _elsewhere={})
        return self._elsewhere[along, across]


@dataclass(frozen=True, eq=False)
class LoadedSurface:
    """Tractions (m_a, m_t, 3) in MPa at the nodes of a surface's window, along two tangents and its outward normal."""

    surface: SurfaceStress
    traction: Array

    @cached_property
    def between(self) -> SubgridTraction:
        return SubgridTraction.of_nodes(self.traction, self.surface.lines)

    def edge(self) -> Array:
        """Points (k, 2) in mm of the patch at which the window's lines cross the contact's edge."""
        numbers = self.between.edge()
        return np.column_stack(
            [
                np.interp(numbers[:, k], np.arange(float(len(lines))), lines)
                for k, lines in enumerate(self.surface.lines)
            ]
        )

    def correction(self, points_mm: Array) -> Array:
        """Stresses (k, 6) in MPa, in the body's axes, to be added to the elements' stresses at points (k, 2) in mm of
        the patch; 0 at points far from the contact or outside the window.
        """
        if not self._is_symmetric:
            return self._correction(points_mm)
        points, places = np.unique(points_mm * np.where(points_mm < 0.0, _ACROSS, 1.0), axis=0, return_inverse=True)
        found = self._correction(points)[places.ravel()]
        found[points_mm[:, 1] < 0.0] *= _IMAGE
        return found

    @cached_property
    def _is_symmetric(self) -> bool:
        """Whether surface and tractions are their own mirror image about y = 0."""
        unlike = np.abs(self.traction - self.traction[:, ::-1] * [1.0, -1.0, 1.0]).max(initial=0.0)
        return self.surface.is_symmetric and bool(unlike <= _MIRRORED * np.abs(self.traction).max(initial=0.0))

    def _correction(self, points_mm: Array) -> Array:
        places = self._numbers(points_mm)
        cell = np.floor(places + 1e-9).astype(int)
        shape = np.array(self.traction.shape[:2])
        cell = np.where(np.abs(places - shape + 1) < 1e-9, shape - 2, cell)
        inside: BoolArray = np.asarray(((cell >= 0) & (cell <= shape - 2)).all(axis=1))
        for i in (0, 1):
            for j in (0, 1):
                # Only nodes that have a weight at the point count, or a node would belong to one side of it.
                weight = np.abs(1 - i - places + cell)[:, 0] * np.abs(1 - j - places + cell)[:, 1]
                corner = np.clip(cell + [i, j], 0, shape - 1)
                inside &= self._near[tuple(corner.T)] | (weight < 1e-9)
        result = np.zeros((len(points_mm), 6))
        if inside.any():
            result[inside] = self._corrected(places[inside], cell[inside])
        return result

    def _corrected(self, places: Array, cell: IntArray) -> Array:
        u, v = (places - cell).T
        weights = np.stack([(1 - u) * (1 - v), (1 - u) * v, u * (1 - v), u * v])
        corners = [(cell[:, 0] + i, cell[:, 1] + j) for i in (0, 1) for j in (0, 1)]
        size, nu = _proportions(*self.surface.spacing_mm), self.surface.material.poissons_ratio
        local = half_space_stress(places, size, self.between.square, self.between.ratio, True, nu)
        normal = np.zeros((len(places), 3))
        for weight, corner in zip(weights, corners, strict=True):
            local -= weight[:, None] * self._of_elements[corner]
            normal += weight[:, None] * self.surface.window_normals[corner]
        frames = _frames(normal / np.linalg.norm(normal, axis=-1, keepdims=True))
        return components(np.swapaxes(frames, -1, -2) @ tensors(local) @ frames)

    @cached_property
    def _near(self) -> BoolArray:
        """Nodes of the window from which tractions are in reach, and all of them known."""
        return corrected_nodes(np.abs(self.traction).max(axis=-1), self.surface.spacing_mm)

    @cached_property
    def _of_elements(self) -> Array:
        """What elements make of the tractions in reach on a half-space, at the nodes of the window (n_a, n_t, 6)."""
        size, waves = self.surface.waves
        field = np.fft.rfft2(self.traction, size, axes=(0, 1))
        whole = np.fft.irfft2(np.einsum("ijsc,ijc->ijs", waves, field), size, axes=(0, 1))
        reach, (rows, columns) = len(self.surface.stencil) // 2, self.traction.shape[:2]
        return np.asarray(whole[reach : reach + rows, reach : reach + columns])

    def _numbers(self, points_mm: Array) -> Array:
        """Places in elements from the window's first node."""
        return np.column_stack(
            [
                np.interp(points_mm[:, k], lines, np.arange(float(len(lines))), -1.0, 1e9)
                for k, lines in enumerate(self.surface.lines)
            ]
        )


def corrected_nodes(size: Array, spacing_mm: tuple[float, ...]) -> BoolArray:
    """Marks, of the grid's shape, of the nodes of an evenly spaced grid at which stresses are corrected: within five
    elements of tractions, and farther than four from where the grid cuts them off.

    size: size of the traction at each node, of any dimension. spacing_mm: of the grid, one for each dimension.
    """
    loaded = size > _LOADED * size.max(initial=0.0)
    away = distance_transform_edt(~loaded, sampling=spacing_mm) if loaded.any() else np.inf * size
    # Points no farther from loaded nodes than so many elements are corrected.
    near = away <= 5.0 * max(spacing_mm)
    # Where the contact leaves these elements, or ends at their very end, its tractions between the nodes are not known.
    # Tractions found from nodal forces fade beyond a contact, to 0.04 within two and a half elements.
    cut = size > 0.1 * size.max(initial=0.0)
    cut[(slice(2, -2),) * size.ndim] = False
    if cut.any():
        # Nor are those nearer than so many elements to where a contact leaves the elements that are alike.
        near &= distance_transform_edt(~cut) > 4.0
    return np.asarray(near)


@lru_cache(maxsize=8)
def _stencil(along: float, across: float, first_layer: float, growth: float, nu: float) -> Array:
    """The `SurfaceStress.stencil` of elements of these proportions under layers that grow from the first."""
    result: Array = lattice_error(along, across, first_layer, growth, nu).copy()
    size, middle = result.shape[0], result.shape[0] // 2
    # In the order of memory in which all places come, or the kernels would be compiled twice.
    places = np.argwhere(np.ones((size, size))).astype(float, order="C")
    proportions = _proportions(along, across)
    for component in range(3):
        unit = np.zeros((size, size, 3))
        unit[middle, middle, component] = 1.0
        exact = half_space_stress(places, proportions, np.ones((size, size)), unit, False, nu)
        result[..., component] += exact.reshape(size, size, 6)
    return result


@lru_cache(maxsize=8)
def _waves(
    along: float, across: float, first_layer: float, growth: float, nu: float, rows: int, columns: int
) -> tuple[tuple[int, int], ComplexArray]:
    """Shape of the transform and the stencil's transform for a window of so many rows and columns of elements."""
    stencil = _stencil(along, across, first_layer, growth, nu)
    size = tuple(next_fast_len(len(stencil) + lines - 1, real=True) for lines in (rows, columns))
    return (size[0], size[1]), np.fft.rfft2(stencil, size, axes=(0, 1))


def _proportions(along_mm: float, across_mm: float) -> Array:
    """Sizes (2,) of an element over their geometric mean."""
    return np.asarray(np.array([along_mm, across_mm]) / np.sqrt(along_mm * across_mm))


def alike(lines: Array) -> slice:
    """The slice of a grid's increasing lines about its middle between which spacings differ by at most 2 %."""
    spacing = np.diff(lines)
    middle = len(spacing) // 2
    other = np.flatnonzero(np.abs(spacing - spacing[middle]) > _ALIKE * spacing[middle])
    first = int(other[other < middle].max(initial=-1)) + 1
    last = int(other[other > middle].min(initial=len(spacing)))
    return slice(first, last + 1)


def window_lines(lines: Array) -> Array:
    """The mesh lines, of `lines` (n,) in mm, around the middle one whose spacing is nearly even; all lines where
    spacings away from the middle are smaller than there, as towards the rim of a contact that sticks.
    """
    spacing = np.diff(lines)
    shrinks = spacing.min() <= (1.0 - _ALIKE) * spacing[len(spacing) // 2]
    return lines if shrinks else lines[alike(lines)]


def _spacing(lines: Array, place_mm: float) -> float:
    """Mean spacing of a grid's lines beside the line nearest to a place, the shortest if that is infinitely far."""
    if not np.isfinite(place_mm):
        return float(np.diff(lines).min())
    nearest = int(np.abs(lines - place_mm).argmin())
    return float(np.diff(lines[max(nearest - 1, 0) : nearest + 2]).mean())


def unspread(lines: Array, force: Array) -> Array:
    """Nodal values (n, ...) per mm of the piecewise linear field on `lines` (n,) in mm whose integrals with hat
    functions are `force` (n, ...).
    """
    size = np.diff(lines)
    bands = np.zeros((3, len(lines)))
    bands[0, 1:] = bands[2, :-1] = size / 6.0
    bands[1, :-1] = size / 3.0
    bands[1, 1:] += size / 3.0
    return np.asarray(solve_banded((1, 1), bands, force.reshape(len(lines), -1)).reshape(force.shape))


def _frames(normals: Array) -> Array:
    """Matrices (..., 3, 3) into a surface's own axes: the tangent most along x, the other one, the normal."""
    first = np.array([1.0, 0.0, 0.0]) - normals[..., :1] * normals
    first /= np.linalg.norm(first, axis=-1, keepdims=True)
    return np.stack([first, np.cross(normals, first), normals], axis=-2)
