"""Observables of a record: its loops prepared for reading, and all numbers that are compared between record and model.

A package that adds an observable needs only the names exported here.
"""

from wirewear.diagnosis.observe.local_lines import ObservedBranch
from wirewear.diagnosis.observe.measured_loops import ReducedLoop
from wirewear.diagnosis.observe.observable import (
    AlongBranch,
    ModelLoops,
    Observable,
    OfLoops,
    Scale,
    Site,
    Sites,
    Smoothness,
    SolverSize,
    Zone,
    rows_of,
)
from wirewear.diagnosis.observe.observed_record import Reading
from wirewear.diagnosis.surrogate.forward import PredictedLoops
from wirewear.diagnosis.surrogate.inputs import SurrogateInputs

#: As packages know them that were written before these names.
OfWholeLoops = Observable
LoopCourse = PredictedLoops
Setup = SurrogateInputs

__all__ = [
    "AlongBranch", "LoopCourse", "ModelLoops", "Observable", "ObservedBranch", "OfLoops", "OfWholeLoops",
    "PredictedLoops", "Reading", "ReducedLoop", "Scale", "Setup", "Site", "Sites", "Smoothness", "SolverSize",
    "SurrogateInputs", "Zone", "rows_of",
]  # fmt: skip
