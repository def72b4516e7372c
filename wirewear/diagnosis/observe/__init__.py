"""What is observed of a record: loops read, and the list of observables, measured and computed.

A package that adds an observable needs the names of this door alone.
"""

from wirewear.diagnosis.model.forward import LoopCourse
from wirewear.diagnosis.model.setup import Setup
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
from wirewear.diagnosis.observe.reading import Reading

#: As packages know it that were written when numbers of one zone had a class of their own.
OfWholeLoops = Observable

__all__ = [
    "AlongBranch", "LoopCourse", "ModelLoops", "Observable", "ObservedBranch", "OfLoops", "OfWholeLoops", "Reading",
    "ReducedLoop", "Scale", "Setup", "Site", "Sites", "Smoothness", "SolverSize", "Zone", "rows_of",
]  # fmt: skip
