"""The open-set gate: is what an explanation leaves over no more than chance, before its name is printed?"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from wirewear.diagnosis.inference import Fit, Problem

#: Mean square of whitened residuals that gap-free solver differences reach at most; above, something is left over.
MOST_MISFIT = 1.6

#: The worst block (stick branches, plateaus, ...) may be this improbable, as one of all blocks.
LEAST_BLOCK = 1e-4


@dataclass(frozen=True)
class Remainder:
    """What an explanation leaves over: chi² per observable, and the least likely block of observables."""

    misfit: float
    worst_block: str
    block_p_value: float
    block_misfit: float

    @property
    def passes(self) -> bool:
        """Whether nothing but noise, scatter and solver error need be left."""
        return self.misfit <= MOST_MISFIT and self.block_p_value >= LEAST_BLOCK


def remainder_of(problem: Problem, one: Fit) -> Remainder:
    """Judge the whitened residuals of a fit, as a whole and by kind and branch parity."""
    whitened = problem.whitened(one.setup)
    misfit = float(whitened @ whitened) / max(whitened.size - one.coordinates.size, 1)
    residual = problem.mean - problem.predicted(one.setup)
    worst = ("none", 1.0, 0.0)
    covariance = np.linalg.inv(problem.whitening.T @ problem.whitening)
    for kind in sorted(set(problem.layout.kind.tolist())):
        keep = problem.layout.kind == kind
        block = covariance[np.ix_(keep, keep)]
        rest = residual[keep]
        squares = float(rest @ np.linalg.solve(block, rest))
        p_value = float(chi2.sf(squares, int(keep.sum())))
        if p_value < worst[1]:
            worst = kind, p_value, squares / int(keep.sum())
    return Remainder(misfit, *worst)
