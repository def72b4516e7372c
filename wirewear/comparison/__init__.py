"""Simulation and experiment side by side: matched loops, evolution, registered scars, and a table of differences."""

from wirewear.comparison.comparison import RecordComparison, compare
from wirewear.comparison.differences import Difference
from wirewear.comparison.registration import Registration
from wirewear.comparison.writing import write_comparison

__all__ = ["Difference", "RecordComparison", "Registration", "compare", "write_comparison"]
