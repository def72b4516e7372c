"""Friction laws of the independent model: how friction is mobilised after a reversal. None is Coulomb's.

A law gives the share of the full swing from −µ to +µ that has been mobilised after a displacement d since the reversal.
All start with the contact's stiffness K: the share rises from 0 with K/(2 µ P).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Joint(Protocol):
    """Anything in series with the contact that moves with the tangential force."""

    def moved_mm(self, force_N: Array, held_from_N: float, direction: int) -> Array:
        """Displacement along a branch (n,), whose force went from `held_from_N` in a direction since the reversal."""
        ...


@dataclass(frozen=True)
class FrictionLaw:
    """`share` of d K/(2 µ P) is the mobilised part; static friction exceeds kinetic by `excess`, lost over a length."""

    name: str
    share: Callable[[Array], Array]
    excess: float = 0.0
    weakening_mm: float = 1e-3

    def limit(self, friction: float, slid_mm: Array) -> Array:
        """Largest coefficient after a slip since the reversal (n,)."""
        return np.asarray(friction * (1.0 + self.excess * np.exp(-slid_mm / self.weakening_mm)))


def _dahl(reduced: Array) -> Array:
    return np.asarray(-np.expm1(-reduced))


def _iwan(reduced: Array) -> Array:
    order = 2.5
    return np.asarray(1.0 - np.maximum(1.0 - reduced / order, 0.0) ** order)


def _bouc(reduced: Array) -> Array:
    beyond = np.maximum(reduced - 0.5, 0.0)
    return np.asarray(np.where(reduced < 0.5, reduced, 0.5 + 0.5 * np.tanh(2.0 * beyond)))


#: Dahl (1968): mobilised exponentially. Iwan (1966): spread thresholds. Weakening: Dahl, static friction 3 % higher.
#: Bouc (1967) and Wen (1976), of exponent 2 and equal parameters: a line down to no force, then a hyperbolic tangent.
LAWS: Mapping[str, FrictionLaw] = {
    law.name: law
    for law in (
        FrictionLaw("dahl", _dahl),
        FrictionLaw("iwan", _iwan),
        FrictionLaw("weakening", _dahl, excess=0.03, weakening_mm=2e-3),
        FrictionLaw("bouc", _bouc),
    )
}
