"""Many runs of one study: keys and effects varied by a design, one table, what the figures depend on."""

from wirewear.sweeps.running import SweepResult, run_sweep
from wirewear.sweeps.sweep import Sweep, load_sweep

__all__ = ["Sweep", "SweepResult", "load_sweep", "run_sweep"]
