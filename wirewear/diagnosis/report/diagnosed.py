"""A diagnosis with all that a report of it needs."""

from __future__ import annotations

from dataclasses import dataclass

from wirewear.diagnosis.infer.search import Search
from wirewear.diagnosis.infer.weighing import Weighed
from wirewear.diagnosis.model.setup import Setup
from wirewear.diagnosis.model.wear_states import WearStates
from wirewear.diagnosis.observe.reduction import Observations
from wirewear.diagnosis.report.values import Diagnosis
from wirewear.records import ExperimentRecord
from wirewear.study import Study


@dataclass(frozen=True, eq=False)
class Diagnosed:
    """A diagnosis with all that pictures of it need."""

    diagnosis: Diagnosis
    record: ExperimentRecord
    study: Study
    states: WearStates
    setup: Setup
    observed: Observations
    search: Search
    weighed: Weighed
