"""Wirewear from Python, as people write it: load, change, run, look, compare, diagnose; nothing needs a folder."""

from wirewear.interactive.loading import load
from wirewear.interactive.looking import Run, read_result, read_results
from wirewear.interactive.measured import Record, read_record
from wirewear.interactive.measured_lines import RecordOfLines, read_line_record
from wirewear.interactive.running import run, run_variants

__all__ = [
    "Record",
    "RecordOfLines",
    "Run",
    "load",
    "read_line_record",
    "read_record",
    "read_result",
    "read_results",
    "run",
    "run_variants",
]
