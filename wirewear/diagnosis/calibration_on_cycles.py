"""One named effect calibrated on some cycles of a record only, to predict the others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from wirewear.base.errors import RecordError
from wirewear.base.quantity import counted
from wirewear.diagnosis.infer.inference import fit
from wirewear.diagnosis.model.setup import Setup
from wirewear.views.diagnosis_values import Estimate, estimates

if TYPE_CHECKING:
    from wirewear.views.diagnosis_wording import Diagnosed


def calibrated(diagnosed: Diagnosed, effect: str, cycles: Sequence[int]) -> tuple[Mapping[str, Estimate], Setup]:
    """Parameters of an effect as the loops of these cycles alone give them, and the nominal model with it.

    Raises:
        RecordError: the effect was not considered, or the record has no loops of these cycles.
    """
    found = diagnosed.search
    alone = next((one for one in found.singles if one.names == (effect,)), None)
    keep = np.isin(found.problem.layout.cycle, list(cycles))
    if alone is None or not keep.any():
        raise RecordError(
            f"{effect} cannot be calibrated on the cycles {', '.join(map(counted, cycles))} of the record "
            f"{diagnosed.record.name!r}: name an effect of the library and cycles that have loops."
        )
    known = fit(found.problem.part(keep, found.covariance), alone.candidates)
    ((candidate, coordinates, deviations),) = known.parts()
    return estimates(candidate, coordinates, deviations, max(found.remainder.misfit, 1.0)), known.setup
