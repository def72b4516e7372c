"""Experiment records: data that laboratories measured, read, checked, written, imported and exported.

A record holds loops of repeated tests at several cycles, their evolution over the cycles, and worn surfaces at the end.
A repeat is one test on fresh specimens. A remark is a problem or a note that a check finds.
"""

from wirewear.records.checking import check_record
from wirewear.records.exporting import record_of_result
from wirewear.records.profiles import MeasuredProfile
from wirewear.records.reading import read_record
from wirewear.records.remarks import RecordReport, Remark
from wirewear.records.scars import MeasuredScar
from wirewear.records.tables import RecordTables
from wirewear.records.values import AnyRecord, ExperimentRecord, LineRecord, MeasuredEvolution, MeasuredLoop
from wirewear.records.writing import require_place, write_record

__all__ = [
    "AnyRecord", "ExperimentRecord", "LineRecord", "MeasuredEvolution", "MeasuredLoop", "MeasuredProfile",
    "MeasuredScar", "RecordReport", "RecordTables", "Remark", "check_record", "read_record", "record_of_result",
    "require_place", "write_record",
]  # fmt: skip
