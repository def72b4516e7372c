"""The open-set gate: is what an explanation leaves over no more than chance, before its name is printed?"""

from __future__ import annotations

from dataclasses import dataclass
from math import e, expm1, log, log1p

import numpy as np
from scipy.stats import chi2

from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.infer.inference import Fit, Problem

_KNOWN = constants("infer.gate")

#: Mean square of whitened residuals that gap-free solver differences reach at most; above, something is left over.
MOST_MISFIT = _KNOWN.number("most_misfit")

#: Standard deviation of the logarithm by which the variance of one observable's solver differences lies above or below
#: the learned one, from test to test.
SCALE = _KNOWN.number("scale")

#: Places and weights of a normal deviate, for means over it.
_PLACES, _WEIGHTS = np.polynomial.hermite_e.hermegauss(_KNOWN.count("places"))

#: The least p-value that is told from others: below it chi² has no digits left.
_LEAST_P = 1e-300


@dataclass(frozen=True)
class Remainder:
    """What an explanation leaves over: chi² per observable, and the least likely of all `blocks` of observables."""

    misfit: float
    worst_block: str
    block_p_value: float
    block_misfit: float
    blocks: int

    @property
    def passes(self) -> bool:
        """Whether as a whole nothing but noise, scatter and solver error need be left."""
        return self.misfit <= MOST_MISFIT

    @property
    def log_surprise(self) -> float:
        """Log of the largest Bayes factor that the worst block lends to something else being at work, 0 if none.

        −e p ln p, the least that a p-value leaves of a hypothesis (Sellke, Bayarri and Berger, Am. Stat. 55 (2001) 62,
        eq. 2), with p that of the least of several.
        """
        p_value = max(-expm1(self.blocks * log1p(-min(self.block_p_value, 0.5))), _LEAST_P)
        return -log(-e * p_value * log(p_value)) if p_value < 1.0 / e else 0.0


def remainder_of(problem: Problem, one: Fit) -> Remainder:
    """Judge the whitened residuals of a fit, as a whole and by observable."""
    whitened = problem.whitened(one.setup)
    misfit = float(whitened @ whitened) / max(whitened.size - one.coordinates.size, 1)
    residual = problem.mean - problem.predicted(one.setup)
    worst = ("none", 1.0, 0.0)
    covariance = np.linalg.inv(problem.whitening.T @ problem.whitening)
    for part in problem.layout:
        block, rest = covariance[part.rows, part.rows], residual[part.rows]
        squares = float(rest @ np.linalg.solve(block, rest))
        p_value = chance(squares, rest.size)
        if p_value < worst[1]:
            worst = part.observable.name, p_value, squares / rest.size
    return Remainder(misfit, *worst, len(problem.layout.parts))


def chance(squares: float, count: int, scale: float = SCALE) -> float:
    """Of a chi square of so many numbers or a larger one, the logarithm of their variance being known within `scale`.

    It is the mean over that of what it were with the variance known: a posterior predictive p-value.
    """
    scaled = squares * np.exp(-scale * _PLACES)
    return float(_WEIGHTS @ chi2.sf(scaled, count) / _WEIGHTS.sum())
