"""Metal that flows beneath a contact: plastic and residual strain, and the print that is left on the surface.

Plastic strain acts as initial strain of an elastic half-space (Mendelson, Plasticity (1968)). It is found as that by
which the metal flows under the strain that it and the contact make; from one round to the next by Anderson's mixing (J.
ACM 12 (1965) 547). Points lie in the middles of l layers, on a grid of (n_x, n_y); z points out of the half-space.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from geometry.arrays import Array
from solvers.errors import NotConvergedError
from solvers.laws.plasticity import Flow, Metal, flown
from solvers.stress.half_space import HalfSpace

_MOST_ROUNDS, _REMEMBERED = 100, 8
PRESSING_TOLERANCE = 1e-3  #: Of the plastic strain of a step over the largest elastic one, yield stress over modulus.


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
        """The half-space after a step to tractions (n_x, n_y, 3), which may depend on the residual displacement.
        Raises NotConvergedError if it cannot bear them, or nearly so.
        """
        return loaded_together((self,), lambda left: (traction(left[0]),), (before,))[0]

    def stressed(self, strain: Array) -> Array:
        """Stresses (l, n_x, n_y, 6) in MPa by which plastic strain (k, 6) would be elastic."""
        size = 2.0 * self.space.material.shear_modulus_MPa
        return size * strain.reshape(len(self.space.layers_mm), *self.space.shape, 6)


#: From residual displacements of half-spaces to their tractions, (n_x, n_y, 3) each.
Tractions = Callable[[Sequence[Array]], Sequence[Array]]


def loaded_together(
    zones: Sequence[PlasticZone], tractions: Tractions, before: Sequence[Flowed], tolerance: float = PRESSING_TOLERANCE
) -> tuple[Flowed, ...]:
    """Half-spaces after a step to tractions that depend on the residual displacements of all.

    tolerance: of the plastic strain, over yield stress over 2 G. Raises NotConvergedError if they cannot be borne, or
    nearly so.
    """
    strain, mixing = [one.flow.strain for one in before], _Mixing()
    for _ in range(_MOST_ROUNDS):
        inner = [zone.space.spectrum(zone.stressed(own)) for zone, own in zip(zones, strain, strict=True)]
        residual = [zone.space.displaced(own) for zone, own in zip(zones, inner, strict=True)]
        pushed, flows, stresses, missed = tractions(residual), [], [], 0.0
        for zone, own, push, old, guess in zip(zones, inner, pushed, before, strain, strict=True):
            total = zone.space.stresses(zone.space.strained(push, own)[0])
            shear = zone.space.material.shear_modulus_MPa
            flow = flown(zone.metal, shear, (total - zone.stressed(old.flow.strain)).reshape(-1, 6), old.flow)
            flows.append(flow)
            stresses.append(total - zone.stressed(flow.strain))
            missed = max(missed, np.abs(flow.strain - guess).max() * 2.0 * shear / zone.metal.yield_stress_MPa)
        if missed <= tolerance:
            return tuple(Flowed(*of) for of in zip(flows, stresses, residual, pushed, strict=True))
        ends = np.cumsum([own.size for own in strain])[:-1]
        found = [own.strain for own in flows]
        mixed = mixing.next(*(np.concatenate([own.ravel() for own in of]) for of in (strain, found)))
        strain = [own.reshape(-1, 6) for own in np.split(mixed, ends)]
    raise NotConvergedError("the body flows without end under the contact's forces")


@dataclass
class _Mixing:
    """The next of a series of guesses, by the last ones and what was found from them."""

    last: tuple[Array, Array] | None = None  #: What was found from the last guess, and what that missed.
    found: list[Array] = field(default_factory=list)  #: Changes of both from guess to guess.
    missed: list[Array] = field(default_factory=list)
    products: Array = field(default_factory=lambda: np.zeros((0, 0)))  #: Of the latter with each other.

    def next(self, guess: Array, found: Array) -> Array:
        """The guess (n,) that, were all linear, would be found from itself."""
        missed, last = found - guess, self.last
        self.last = found, missed
        if last is None:
            return found
        kept = slice(max(len(self.missed) + 1 - _REMEMBERED, 0), None)
        self.found = [*self.found, found - last[0]][kept]
        self.missed = [*self.missed, missed - last[1]][kept]
        products = np.zeros((len(self.missed),) * 2)
        products[:-1, :-1] = self.products[kept, kept]
        products[-1] = products[:, -1] = [own @ self.missed[-1] for own in self.missed]
        self.products = products
        weights, *_ = np.linalg.lstsq(products, np.array([own @ missed for own in self.missed]), rcond=1e-12)
        return np.asarray(found - sum(w * own for w, own in zip(weights, self.found, strict=True)))
