"""Metal that flows beneath a contact: plastic and residual strain, and the print that is left on the surface.

Plastic strain acts as initial strain of an elastic half-space (Mendelson, Plasticity (1968)). It is found as that by
which the metal flows under the strain that it and the contact make; from one round to the next by Anderson's mixing (J.
ACM 12 (1965) 547). Points lie in the middles of l layers, on a grid of (n_x, n_y); z points out of the half-space.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from geometry.arrays import Array, BoolArray, ComplexArray, IntArray
from solvers.errors import NotConvergedError
from solvers.jit_cache import compiled
from solvers.laws.plasticity import Flow, Metal, flown
from solvers.stress.half_space import HalfSpace

_MOST_ROUNDS, _REMEMBERED = 100, 8
#: Part of the shear modulus by which a point's flow relieves it: about the rest its surroundings keep up. What is found
#: does not depend on it.
_YIELDING = 0.4
#: Of this many times the tolerance, all layers have their say again: one round less where that is the last one.
_NEARLY = 5.0
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

    def flowing(self, strain: Array, *, whole: bool) -> int:
        """Number of upper layers that flow soon: all, or to a little beneath those that have plastic strain (k, 6)."""
        layers = len(self.space.layers_mm)
        flows = [layer for layer, own in enumerate(strain.reshape(layers, -1)) if own.any()]
        return layers if whole or not flows else min(flows[-1] + 3, layers)

    def waves(self, strain: Array, layers: int) -> ComplexArray:
        """Displacements of the levels of the upper `layers` by plastic strain (k, 6), as `HalfSpace.waves`."""
        inner = strain.reshape(len(self.space.layers_mm), *self.space.shape, 6)
        count = layers if inner[:layers].any() else 0
        return self.space.waves(2.0 * self.space.material.shear_modulus_MPa * inner[:count], layers)

    def flown(self, strain: Array, before: Flow, guess: Array) -> Flow:
        """The state of all points after a step from `before` in which the upper layers have strains (m, n_x, n_y, 6)
        and the deeper ones do not flow.

        guess: (k, 6) plastic strain that makes these strains. That which is found is the same if it is right.
        """
        lame, shear = self.space.elastic
        trial = strain.reshape(-1, 6).copy()
        _tried(trial, before.strain, guess, lame, shear, _YIELDING * shear)
        return flown(self.metal, _YIELDING * shear, trial, before)


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
    strain = [one.flow.strain for one in before] if guess is None else list(guess)
    base = np.concatenate([old.flow.strain for old in before])
    mixing, ends, whole = _Mixing(base), np.cumsum([len(own) for own in strain])[:-1], True
    for _ in range(_MOST_ROUNDS):
        depths = [zone.flowing(own, whole=whole) for zone, own in zip(zones, strain, strict=True)]
        inner = [zone.waves(own, deep) for zone, own, deep in zip(zones, strain, depths, strict=True)]
        residual = [zone.space.displacements(own) for zone, own in zip(zones, inner, strict=True)]
        pushed, flows, totals, missed = tractions(residual), [], [], 0.0
        for zone, own, push, old, last in zip(zones, inner, pushed, before, strain, strict=True):
            total = zone.space.strains(own, push)
            flow = zone.flown(total, old.flow, last)
            flows.append(flow)
            totals.append(total)
            shear = zone.space.material.shear_modulus_MPa
            missed = max(missed, _apart(flow.strain, last) * 2.0 * shear / zone.metal.yield_stress_MPa)
        if missed <= tolerance and whole:
            for zone, total, flow in zip(zones, totals, flows, strict=True):
                _tried(total.reshape(-1, 6), flow.strain, flow.strain, *zone.space.elastic, 0.0)
            return tuple(Flowed(*of) for of in zip(flows, totals, residual, pushed, strict=True))
        # Deeper layers have their say at first, and once the upper ones have all but found theirs.
        whole = missed <= _NEARLY * tolerance
        if missed > tolerance:
            found = np.concatenate([own.strain for own in flows])
            strain = np.split(mixing.next(np.concatenate(strain), found), ends)
    raise NotConvergedError("the body flows without end under the contact's forces")


@compiled
def _tried(strain: Array, before: Array, guess: Array, lame: float, shear: float, part: float) -> None:
    """Change strains (k, 6) to the stresses from which metal returns that yields to its flow by 2 `part` alone."""
    for k in range(len(strain)):
        mean = lame * (strain[k, 0] + strain[k, 1] + strain[k, 2])
        for c in range(6):
            stress = 2.0 * shear * (strain[k, c] - guess[k, c]) + (mean if c < 3 else 0.0)
            strain[k, c] = stress + 2.0 * part * (guess[k, c] - before[k, c])


@compiled
def _differ(rows: Array, others: Array) -> BoolArray:
    """Which rows (k,) of two fields (k, m) are not the same."""
    found = np.zeros(len(rows), dtype=np.bool_)
    for k in range(len(rows)):
        for c in range(rows.shape[1]):
            if rows[k, c] != others[k, c]:
                found[k] = True
                break
    return found


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
    """The next of a series of guesses (k, 6), by the last ones and what was found from them.

    base: (k, 6) what the first points to differ from it count from.
    """

    base: Array
    points: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))  #: Where either was not the base.
    last: Array | None = None  #: At them, what was found from the last guess, less the base, and what that missed.
    changes: Array = field(default_factory=lambda: np.zeros((0, 2, 0, 6)))  #: Of both, from guess to guess.

    def next(self, guess: Array, found: Array) -> Array:
        """The guess that, were all linear, would be found from itself; `found` is changed to it."""
        self._widen(np.flatnonzero(_differ(guess, self.base) | _differ(found, self.base)))
        at = found[self.points]
        own = np.stack([at - self.base[self.points], at - guess[self.points]])
        if self.last is not None:
            self.changes = np.concatenate([self.changes, (own - self.last)[None]])[-_REMEMBERED:]
        self.last = own
        missed = self.changes[:, 1].reshape(len(self.changes), own[1].size)
        weights, *_ = np.linalg.lstsq(missed @ missed.T, missed @ own[1].ravel(), rcond=1e-12)
        found[self.points] = at - np.tensordot(weights, self.changes[:, 0], axes=1)
        return found

    def _widen(self, points: IntArray) -> None:
        """Take in points at which both have been the base so far."""
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
