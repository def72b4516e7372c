"""Sweeps: many runs of a study with varied keys and effects, their table of figures, and each key's influence."""

from wirewear.sweeps.running import SweepResult, run_sweep
from wirewear.sweeps.sweep import Sweep, load_sweep

__all__ = ["Sweep", "SweepResult", "load_sweep", "run_sweep"]
