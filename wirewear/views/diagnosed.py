"""A diagnosis with all that a report of it needs."""

from __future__ import annotations

from dataclasses import dataclass

from wirewear.base import notebook
from wirewear.diagnosis.infer.search import Search
from wirewear.diagnosis.infer.weighing import Weighed
from wirewear.diagnosis.model.setup import Setup
from wirewear.diagnosis.model.wear_states import WearStates
from wirewear.diagnosis.observe.reduction import Observations
from wirewear.planar.tables import PlanarStudy
from wirewear.records import ExperimentRecord
from wirewear.records.line_values import LineRecord
from wirewear.study import Study
from wirewear.views.diagnosis_values import Diagnosis
from wirewear.views.diagnosis_wording import plain, with_unit


@dataclass(frozen=True, eq=False, repr=False)
class Diagnosed:
    """A diagnosis with all that pictures of it need."""

    diagnosis: Diagnosis
    record: ExperimentRecord | LineRecord
    study: Study | PlanarStudy
    states: WearStates
    setup: Setup
    observed: Observations
    search: Search
    weighed: Weighed

    def __repr__(self) -> str:
        return f"<Diagnosis of {self.record.name!r}, {self.diagnosis.verdict}: {self.diagnosis.sentence}>"

    def _repr_html_(self) -> str:
        rows = {
            f"{plain(cause.effect)}, {cause.probability:.0%}": "; ".join(
                with_unit(name, estimate) for name, estimate in cause.parameters.items()
            )
            for cause in self.diagnosis.causes[:5]
        }
        note = " ".join(f"{remark[0].upper()}{remark[1:]}." for remark in self.diagnosis.notes)
        return notebook.table(f"{self.record.name}: {self.diagnosis.sentence}", rows, note=note)
