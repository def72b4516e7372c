"""Experiment records of line contacts: read, written, checked, made of a simulation, set beside one."""

from wirewear.line_records.checking import check_line_record
from wirewear.line_records.comparing import LineComparison, compare_line, write_line_comparison
from wirewear.line_records.exporting import line_record_of_result
from wirewear.line_records.files import is_line_record, read_line_record, write_line_record
from wirewear.line_records.tables import LineRecordTables
from wirewear.line_records.values import LineRecord, MeasuredProfile

__all__ = [
    "LineComparison",
    "LineRecord",
    "LineRecordTables",
    "MeasuredProfile",
    "check_line_record",
    "compare_line",
    "is_line_record",
    "line_record_of_result",
    "read_line_record",
    "write_line_comparison",
    "write_line_record",
]
