"""Layers between the surfaces (roughness, third body) that deform, and layers on a surface (coatings) that wear.

A layer between the surfaces is local (a Winkler layer): its closure, by which the surfaces approach, depends on the
pressure at the node alone, and its shear on the tangential traction there. It acts in series with the bodies' elastic
compliance; its closure does not count as penetration, nor its shear as slip. A coating is as elastic as its body, a
good approximation while it is thin against the contact's width; it differs in wear and friction alone.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import Protocol

import numpy as np

from geometry.arrays import Array, IntArray
from solvers.errors import SolverError
from solvers.laws.local_state import LocalState
from solvers.laws.yielding import YieldAtNodes

_LEAST_SHARE = 1e-6  # Share of the engagement pressure below which a rough layer is as it is at first touch.


# Over the last part of a layer's thickness its friction passes linearly to that of what lies below it.
_FADING = 0.1


class ContactLayer(Protocol):
    """A layer between the surfaces; k is the number of nodes, worn_mm the worn depth (k,) of both bodies together whose
    debris is still there: less than they have worn where some has left.
    """

    @property
    def retained_fraction(self) -> float:
        """Share of both bodies' worn depths that stays between the surfaces as debris, in [0, 1)."""
        ...

    def closure(self, pressure_MPa: Array, worn_mm: Array, /) -> tuple[Array, Array]:
        """Closure (k,) in mm, positive as surfaces approach, at pressures (k,) in MPa, and its derivative by these."""
        ...

    def shear_compliance(self, pressure_MPa: Array, worn_mm: Array, /) -> tuple[Array, Array]:
        """Tangential displacement per traction (k,) in mm/MPa at pressures (k,), and its derivative by pressure."""
        ...


@dataclass(frozen=True)
class RoughLayer:
    """Asperities with exponentially distributed heights: p = p_c (exp(w / s) - 1) at the closure w, of stiffness (p +
    p_c) / s.

    Greenwood & Williamson, Proc. R. Soc. A 295 (1966) 300, for this distribution. Self-affine roughness, too, has a
    stiffness in proportion to pressure (Persson, Phys. Rev. Lett. 99 (2007) 125502).
    """

    decay_mm: float  #: s, the closure that raises the pressure e-fold, about the standard deviation of heights.
    engagement_pressure_MPa: float = 100.0  #: p_c, at which the stiffness is twice that of first touch.
    #: Tangential over normal compliance; for each asperity (2 - nu) / (2 - 2 nu) by Mindlin (J. Appl. Mech. 16
    #: (1949) 259): 1.21 for nu = 0.3.
    shear_ratio: float = 1.21

    retained_fraction = 0.0

    def closure(self, pressure_MPa: Array, _worn_mm: Array, /) -> tuple[Array, Array]:
        share = pressure_MPa / self.engagement_pressure_MPa
        pressed = np.maximum(share, 0.0)
        slope = self.decay_mm / self.engagement_pressure_MPa / (1.0 + pressed)
        return self.decay_mm * (np.log1p(pressed) + np.minimum(share, 0.0)), slope

    def shear_compliance(self, pressure_MPa: Array, _worn_mm: Array, /) -> tuple[Array, Array]:
        share = np.maximum(pressure_MPa / self.engagement_pressure_MPa, _LEAST_SHARE)
        secant = np.log1p(share) / share
        unit = self.shear_ratio * self.decay_mm / self.engagement_pressure_MPa
        return unit * secant, unit / self.engagement_pressure_MPa * (1.0 / (1.0 + share) - secant) / share


@dataclass(frozen=True)
class ThirdBody:
    """Debris that stays in both scars as an elastic bed and carries the load (Godet, Wear 100 (1984) 437; Berthier,
    Vincent & Godet, Wear 125 (1988) 25).

    Debris fills a share of both bodies' worn depths. The bed of this thickness h, thin against its width, closes by h p
    / M under a pressure p and shears by h q / G under a traction q.
    """

    retained_fraction: float  #: Share of both worn depths that debris fills.
    modulus_MPa: float = inf  #: M, of the laterally confined bed.
    poissons_ratio: float = 0.3  #: Poisson's ratio of the debris, which gives G = M (1 - 2 nu) / (2 - 2 nu).

    def closure(self, pressure_MPa: Array, worn_mm: Array, /) -> tuple[Array, Array]:
        compliance = self.retained_fraction * worn_mm / self.modulus_MPa
        return compliance * pressure_MPa, compliance

    def shear_compliance(self, _pressure_MPa: Array, worn_mm: Array, /) -> tuple[Array, Array]:
        over_confined = (2.0 - 2.0 * self.poissons_ratio) / (1.0 - 2.0 * self.poissons_ratio)
        return over_confined * self.retained_fraction * worn_mm / self.modulus_MPa, np.zeros_like(worn_mm)


@dataclass(frozen=True)
class LayersAtNodes:
    """All layers between the surfaces, in series, at k paired nodes during an increment; yielding: pressure limits of
    the surfaces, None for elastic ones.
    """

    layers: tuple[ContactLayer, ...]
    worn: Array  #: (k,) worn depth of both bodies together whose debris is still there, mm.
    old_displacement: Array  #: (k, 3) shear of the layers under the tractions before the increment, mm.
    yielding: YieldAtNodes | None = None

    def closure(self, pressure: Array) -> tuple[Array, Array]:
        """Closure (k,) in mm of all layers and by yielding, at pressures (k,) in MPa, and its derivative by these."""
        parts = [layer.closure(pressure, self.worn) for layer in self.layers]
        return _sum(parts if self.yielding is None else [*parts, self.yielding.closure(pressure)])

    def among(self, nodes: IntArray) -> "LayersAtNodes":
        """The layers at the nodes of these indices into the k."""
        yielding = None if self.yielding is None else self.yielding.among(nodes)
        return LayersAtNodes(self.layers, self.worn[nodes], self.old_displacement[nodes], yielding)

    def shear_compliance(self, pressure: Array) -> tuple[Array, Array]:
        """Tangential displacement per traction (k,) in mm/MPa of all layers under pressures (k,) in MPa, and its
        derivative by pressure.
        """
        return _sheared(self.layers, pressure, self.worn)


def layers_at_nodes(
    layers: tuple[ContactLayer, ...],
    worn: Array,
    old_traction: Array,
    normals: Array,
    yielding: YieldAtNodes | None = None,
) -> LayersAtNodes:
    """The layers at k nodes where debris of both bodies' worn depth `worn` (k,) in mm is still there.

    old_traction, normals: (k, 3) the traction in MPa before the increment and the unit normal, in world axes. yielding:
    pressure limits of the surfaces; None for elastic ones.
    """
    pressure = np.einsum("ij,ij->i", old_traction, normals)
    compliance, _ = _sheared(layers, pressure, worn)
    return LayersAtNodes(layers, worn, compliance[:, None] * old_traction, yielding)


def _sheared(layers: Sequence[ContactLayer], pressure: Array, worn: Array) -> tuple[Array, Array]:
    none = np.zeros_like(pressure)
    return _sum([(none, none), *(layer.shear_compliance(pressure, worn) for layer in layers)])


def _sum(parts: list[tuple[Array, Array]]) -> tuple[Array, Array]:
    if len(parts) == 1:
        return parts[0]
    values, derivatives = zip(*parts, strict=True)
    # Of the few parts, arrays of them cost more than their sum.
    return np.asarray(sum(values)), np.asarray(sum(derivatives))


def retained_share(layers: Sequence[ContactLayer]) -> float:
    """Share (from 0, below 1) of the worn depth that debris fills, in all layers together; wear opens the gap by the
    rest.

    Raises SolverError if the layers' retained fractions sum to less than 0, or to 1 or more.
    """
    filled = sum(layer.retained_fraction for layer in layers)
    if not 0.0 <= filled < 1.0:
        raise SolverError(f"the layers fill {filled:g} of the worn depth; together they must fill less than all of it")
    return filled


@dataclass(frozen=True)
class SurfaceLayer:
    """A layer on a body, such as a coating, of the same thickness everywhere."""

    thickness_mm: float
    wear_factor: float  #: Wear coefficient of the layer over that of the body.
    #: Coefficient of friction where this layer is at the surface, over that without layers; None: it is equal.
    friction_factor: float | None = None


Layers = Sequence[SurfaceLayer]  #: All coatings of one body, the outermost first.


def work_through(layers: Layers) -> tuple[Array, Array]:
    """Two arrays (m + 1,) for a body with m layers, in the unit of their thickness: depths of the surface (0) and of
    each layer's lower face, and the depths to which the body without layers would have worn when it has worn down to
    each.
    """
    thickness = np.array([0.0, *(layer.thickness_mm for layer in layers)])
    factors = np.array([1.0, *(layer.wear_factor for layer in layers)])
    return np.cumsum(thickness), np.cumsum(thickness / factors)


def bare_depth(layers: Layers, depth: Array) -> Array:
    """Depth to which the body without layers would have worn by the wear work that has worn the layered one to `depth`.

    Any shape; in the unit of the layers' thickness.
    """
    faces, bare = work_through(layers)
    return np.asarray(np.interp(depth, faces, bare) + np.maximum(depth - faces[-1], 0.0))


def receded(layers: Layers, depth_mm: Array, bare_mm: Array) -> Array:
    """Depth in mm by which surfaces already worn to `depth_mm` recede while the body without layers would recede by
    `bare_mm`.

    Any shape; exact across the layers' lower faces.
    """
    if not layers:
        return bare_mm
    (faces, bare), wanted = work_through(layers), bare_depth(layers, depth_mm) + bare_mm
    return np.asarray(np.interp(wanted, bare, faces) + np.maximum(wanted - bare[-1], 0.0) - depth_mm)


def friction_factor(upper: Layers, lower: Layers, local: LocalState) -> float | Array:
    """Factor on the coefficient of friction from the coatings of both bodies at k nodes: (k,), or 1 if no coating has
    one.

    A body's factor is that of the coating at its surface; where both bodies have one, the mean of both counts.
    """
    if not (upper or lower):
        return 1.0
    layered = [
        (layers, body_is_upper)
        for layers, body_is_upper in ((upper, True), (lower, False))
        if any(layer.friction_factor is not None for layer in layers)
    ]
    if not layered:
        return 1.0
    more = there = np.zeros(1)
    for layers, body_is_upper in layered:
        primary = body_is_upper == local.primary_is_upper
        depth = local.wear.depths[0 if primary else 1].ravel()
        at = local.of_primary if primary else local.of_secondary
        faces, known = work_through(layers)[0], [layer.friction_factor for layer in layers]
        starts = faces[1:] - _FADING * np.diff(faces)
        places = np.ravel(np.column_stack([starts, faces[1:]]))
        more = more + at(_of_surface([0.0 if own is None else own - 1.0 for own in (*known, None)], places, depth))
        if len(layered) > 1:
            there = there + at(_of_surface([0.0 if own is None else 1.0 for own in (*known, None)], places, depth))
    return np.asarray(1.0 + more / np.maximum(there, 1.0))


def _of_surface(values: Sequence[float], places: Array, depth: Array) -> Array:
    """The value (n,) of the layer at the surface at depths (n,); values: of m layers and of the body. places: (2 m,)
    depths at which each layer begins to give way to the next one, and ends.
    """
    course = np.ravel(np.column_stack([values[:-1], values[1:]]))
    return np.asarray(np.interp(depth, places, course))
