"""Simulation and experiment side by side: matched loops, evolution, registered scars, and a table of differences."""

from wirewear.comparison.comparison import Comparison, compare, write_comparison
from wirewear.comparison.differences import Difference
from wirewear.comparison.registration import Registration

__all__ = ["Comparison", "Difference", "Registration", "compare", "write_comparison"]
