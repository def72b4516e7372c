"""Quantities of a test that change freely over its cycles, as fast models take them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from wirewear.diagnosis.model.setup import Array
from wirewear.effects import Age, Ageing, Chain, Seam


@dataclass(frozen=True, eq=False)
class FreeInTime:
    """One column of a chain that is changed over the cycles; it stands in a setup beside its effects.

    Attributes:
        column: of the chain.
        knots: logarithms (k,) of cycles.
        values: (k,) changes at these, linear between them.
        scale: what a change of one adds; 0 multiplies instead.
    """

    column: str
    knots: Array
    values: Array
    scale: float
    name: str = "free in time"
    ages: Ageing = Ageing.BY_CYCLES

    @property
    def seam(self) -> Seam | None:
        """None: it changes the chain itself."""
        return None

    def changed(self, described: object, _age: Age) -> object:
        """Nothing of a seam's description."""
        return described

    def foreseen(self, chain: Chain) -> Chain:
        """The chain with the column changed."""
        share = np.interp(np.log(np.maximum(chain.cycles, 1.0)), self.knots, self.values)
        was = getattr(chain, self.column)
        return replace(chain, **{self.column: was * (1.0 + share) if self.scale == 0.0 else was + self.scale * share})
