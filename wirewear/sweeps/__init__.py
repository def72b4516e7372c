"""Sweeps: many runs of one study with varied keys and effects, their table of figures, and the influence of
each key.
"""

from wirewear.sweeps.running import SweepResult, run_sweep
from wirewear.sweeps.sweep import Sweep, load_sweep

__all__ = ["Sweep", "SweepResult", "load_sweep", "run_sweep"]
