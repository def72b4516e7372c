"""How much more or less than the nominal model effects let bodies wear: what meshes must hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from solvers import WearRates
from wirewear.effects import Age, ContactLaw, Effect, Loading, Seam, applied

# Effects may add this factor to the worn volume before the patch grows: 8 % of its half-width in 3D. Runs with and
# without effects that fit into the margin have the same meshes and differ by nothing else.
_MARGIN = 1.35
_AGES = 200


@dataclass(frozen=True)
class WearFactors:
    """Mean and largest factor of effects on the wear per cycle in gross slip, over the cycles of a test."""

    mean: float
    largest: float

    @property
    def beyond_margin(self) -> float:
        """Factor on the worn volume for which a mesh must have room, 1 where its margin will do."""
        return max(self.mean / _MARGIN, 1.0)


def wear_factors(effects: Sequence[Effect[Any]], friction: float, load_N: float, cycles: float) -> WearFactors:
    """The factors of effects on a nominal friction, load and wear law."""
    if not effects or friction * load_N == 0.0:
        return WearFactors(1.0, 1.0)
    nominal = ContactLaw(friction), Loading(load_N)
    factors = [_work(effects, *nominal, Age(n, 0.0)) for n in np.linspace(0.0, cycles, _AGES)]
    return WearFactors(float(np.mean(factors)) / (friction * load_N), max(factors) / (friction * load_N))


def _work(effects: Sequence[Effect[Any]], contact: ContactLaw, loading: Loading, age: Age) -> float:
    """Friction force times the factor on the wear coefficient, N; by Archard's law likewise."""
    friction = applied(effects, Seam.CONTACT, contact, age).friction
    load = applied(effects, Seam.LOADING, loading, age).normal_load_N
    return friction * load * applied(effects, Seam.WEAR, WearRates(1.0, 1.0), age).upper_mm3_per_mJ
