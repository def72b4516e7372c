"""Metal that flows beneath a contact: plastic and residual strain, and the print that is left on the surface.

Plastic strain acts as initial strain of an elastic half-space (Mendelson, Plasticity (1968)). It is found as that by
which the metal flows under the strain that it and the contact make; from one round to the next by Anderson's mixing (J.
ACM 12 (1965) 547). Points lie in the middles of l layers, on a grid of (n_x, n_y); z points out of the half-space.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from geometry.arrays import Array, IntArray
from solvers.errors import NotConvergedError
from solvers.jit_cache import compiled
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
    zones: Sequence[PlasticZone],
    tractions: Tractions,
    before: Sequence[Flowed],
    tolerance: float = PRESSING_TOLERANCE,
    guess: Sequence[Array] | None = None,
) -> tuple[Flowed, ...]:
    """Half-spaces after a step to tractions that depend on the residual displacements of all.

    tolerance: of the plastic strain, over yield stress over 2 G. guess: of the plastic strain (k, 6) of each after the
    step; None: that before. Raises NotConvergedError if they cannot be carried, or nearly so.
    """
    strain = [one.flow.strain for one in before] if guess is None else guess
    mixing, ends = _Mixing(), np.cumsum([len(own) for own in strain])[:-1]
    initial = [zone.stressed(old.flow.strain) for zone, old in zip(zones, before, strict=True)]
    for _ in range(_MOST_ROUNDS):
        inner = [zone.space.waves(_upper(zone.stressed(own))) for zone, own in zip(zones, strain, strict=True)]
        residual = [zone.space.displacements(own) for zone, own in zip(zones, inner, strict=True)]
        pushed, flows, totals, missed = tractions(residual), [], [], 0.0
        for zone, own, push, old, trial, last in zip(zones, inner, pushed, before, initial, strain, strict=True):
            shear = zone.space.material.shear_modulus_MPa
            total = zone.space.stresses(zone.space.strains(own, push))
            flow = flown(zone.metal, shear, (total - trial).reshape(-1, 6), old.flow)
            flows.append(flow)
            totals.append(total)
            missed = max(missed, _apart(flow.strain, last) * 2.0 * shear / zone.metal.yield_stress_MPa)
        if missed <= tolerance:
            stresses = [
                total - zone.stressed(own.strain) for zone, total, own in zip(zones, totals, flows, strict=True)
            ]
            return tuple(Flowed(*of) for of in zip(flows, stresses, residual, pushed, strict=True))
        found = np.concatenate([own.strain for own in flows])
        flowed = np.flatnonzero(np.concatenate([own.accumulated for own in flows]))
        strain = np.split(mixing.next(np.concatenate(strain), found, flowed), ends)
    raise NotConvergedError("the body flows without end under the contact's forces")


def _upper(stress: Array) -> Array:
    """Stresses (m, ...) of the upper layers, below which all are zero."""
    flows = [bool(own.any()) for own in stress]
    return stress[: len(flows) - flows[::-1].index(True) if any(flows) else 0]


@compiled
def _apart(one: Array, other: Array) -> float:
    """The largest difference of two fields (k, 6)."""
    largest = 0.0
    for k in range(len(one)):
        for c in range(6):
            largest = max(largest, abs(one[k, c] - other[k, c]))
    return largest


@dataclass
class _Mixing:
    """The next of a series of guesses (k, 6), by the last ones and what was found from them."""

    points: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))  #: Those that flow.
    last: Array | None = None  #: At them, what was found from the last guess, and what that missed.
    changes: Array = field(default_factory=lambda: np.zeros((0, 2, 0, 6)))  #: Of both, from guess to guess.

    def next(self, guess: Array, found: Array, points: IntArray) -> Array:
        """The guess that, were all linear, would be found from itself; points: those that have flowed."""
        self._widen(points)
        own = np.stack([found[self.points], found[self.points] - guess[self.points]])
        if self.last is not None:
            self.changes = np.concatenate([self.changes, (own - self.last)[None]])[-_REMEMBERED:]
        self.last = own
        missed = self.changes[:, 1].reshape(len(self.changes), own[1].size)
        weights, *_ = np.linalg.lstsq(missed @ missed.T, missed @ own[1].ravel(), rcond=1e-12)
        mixed = found.copy()
        mixed[self.points] -= np.tensordot(weights, self.changes[:, 0], axes=1)
        return mixed

    def _widen(self, points: IntArray) -> None:
        """Take in points that have had no strain so far."""
        points = np.union1d(self.points, points)
        if len(points) > len(self.points):
            place = np.searchsorted(points, self.points)
            changes = np.zeros((len(self.changes), 2, len(points), 6))
            changes[:, :, place] = self.changes
            self.changes = changes
            if self.last is not None:
                last = np.zeros((2, len(points), 6))
                last[:, place] = self.last
                self.last = last
            self.points = points
