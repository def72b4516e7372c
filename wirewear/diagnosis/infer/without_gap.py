"""Where a record lies among records without a gap, by what each leaves beside its nominal model.

The covariance is never quite right: solvers differ more on one test than on another, repeats scatter less than is
expected before looking. So no chi square is asked for a chance, but records that are known to have no gap: of those
that are like a new one, each share leaves more than it (conformal p-values: Vovk, Gammerman and Shafer, Algorithmic
Learning in a Random World, 2005, ch. 2).
"""

from __future__ import annotations

import numpy as np

from wirewear.diagnosis.calibration import constants
from wirewear.diagnosis.infer.inference import Fit, Problem

#: Chi squares per number of records without a gap, sorted.
LEFT = np.sort(constants("infer.without_gap").numbers("left"))


def left_by(problem: Problem, fit: Fit) -> float:
    """Chi square per number that an explanation leaves, none among them."""
    whitened = problem.whitened(fit.setup)
    return float(whitened @ whitened) / max(whitened.size, 1)


def share_beyond(left: float) -> float:
    """Of records without a gap those that leave more than so much per number; linear between them, never 0 or 1."""
    level = np.arange(1, LEFT.size + 1) / (LEFT.size + 1.0)
    return float(1.0 - np.interp(left, LEFT, level))
