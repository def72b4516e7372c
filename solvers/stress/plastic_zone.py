"""Metal that flows beneath a contact: plastic and residual strain, and the print that is left on the surface.

Plastic strain acts as initial strain of an elastic half-space (Mendelson, Plasticity (1968)). It is found as that by
which the metal flows under the strain that it and the contact make; from one round to the next by Anderson's mixing (J.
ACM 12 (1965) 547). Points lie in the middles of l layers, on a grid of (n_x, n_y); z points out of the half-space.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from geometry.arrays import Array
from solvers.errors import NotConvergedError
from solvers.laws.plasticity import Flow, Metal, flown
from solvers.stress.half_space import HalfSpace

_MOST_ROUNDS, _REMEMBERED = 100, 8
_TOLERANCE = 1e-3  #: Of the plastic strain of a step over the largest elastic one, yield stress over modulus.


@dataclass(frozen=True)
class Flowed:
    """A half-space after a step of loading: plastic state `flow` of its points; stress (l, n_x, n_y, 6) in MPa;
    residual_mm (n_x, n_y, 3), displacement of the surface by plastic strain alone; traction_MPa (n_x, n_y, 3) on the
    surface.
    """

    flow: Flow
    stress: Array
    residual_mm: Array
    traction_MPa: Array


@dataclass(frozen=True, eq=False)
class PlasticZone:
    """An elastic half-space whose metal flows."""

    space: HalfSpace
    metal: Metal

    @property
    def fresh(self) -> Flowed:
        """The half-space before any load: without strain, stress or traction."""
        along, across = self.space.shape
        points = (len(self.space.layers_mm), along, across)
        return Flowed(
            Flow.none(int(np.prod(points))), np.zeros((*points, 6)), np.zeros((along, across, 3)),
            np.zeros((along, across, 3)),
        )  # fmt: skip

    def under(self, traction_MPa: Array, before: Flowed) -> Flowed:
        """The half-space after a step from `before` to given tractions (n_x, n_y, 3). Raises NotConvergedError."""
        return self.loaded(lambda _: traction_MPa, before)

    def loaded(self, traction: Callable[[Array], Array], before: Flowed) -> Flowed:
        """The half-space after a step from `before` to tractions (n_x, n_y, 3) in MPa; traction: gives them from the
        residual displacement (n_x, n_y, 3) in mm. Raises NotConvergedError if the metal cannot bear them, or nearly so.
        """
        points, shear = before.stress.shape, self.space.material.shear_modulus_MPa
        old, strain, mixing = before.flow.strain, before.flow.strain, _Mixing()
        scale = _TOLERANCE * self.metal.yield_stress_MPa / (2.0 * shear)
        for _ in range(_MOST_ROUNDS):
            inner, residual = self.space.moved(None, 2.0 * shear * strain.reshape(points))
            pushed = traction(residual)
            total = self.space.stresses(inner + self.space.moved(pushed, None)[0])
            flow = flown(self.metal, shear, total.reshape(-1, 6) - 2.0 * shear * old, before.flow)
            if np.abs(flow.strain - strain).max() <= scale:
                return Flowed(flow, total - 2.0 * shear * flow.strain.reshape(points), residual, pushed)
            strain = mixing.next(strain, flow.strain)
        raise NotConvergedError("the body flows without end under the contact's forces")


@dataclass
class _Mixing:
    """The next of a series of guesses, by the last ones and what was found from them."""

    guesses: list[Array] = field(default_factory=list)
    found: list[Array] = field(default_factory=list)

    def next(self, guess: Array, found: Array) -> Array:
        """The guess that, were all linear, would be found from itself."""
        self.guesses, self.found = [*self.guesses[-_REMEMBERED:], guess], [*self.found[-_REMEMBERED:], found]
        off = [(own - at).ravel() for own, at in zip(self.found, self.guesses, strict=True)]
        changes = np.array([off[-1] - own for own in off[:-1]])
        if not len(changes):
            return found
        weights, *_ = np.linalg.lstsq(changes @ changes.T, changes @ off[-1], rcond=1e-12)
        mixed = found.copy()
        for weight, own in zip(weights, self.found[:-1], strict=True):
            mixed -= weight * (found - own)
        return mixed
