"""Figures of all loops of a CSV file, a record or a result: read, analysed, tabulated, drawn."""

from wirewear.loops.loop_report.csv_file import Spelling
from wirewear.loops.loop_report.picture import draw_loops
from wirewear.loops.loop_report.report import (
    AnalysedLoop,
    analyse_loops,
    loops_json,
    loops_table,
    real_loops_table,
    remarks,
)
from wirewear.loops.loop_report.sources import read_loops
from wirewear.loops.loop_report.values import SampledLoop

__all__ = [
    "AnalysedLoop",
    "SampledLoop",
    "Spelling",
    "analyse_loops",
    "draw_loops",
    "loops_json",
    "loops_table",
    "read_loops",
    "real_loops_table",
    "remarks",
]
