"""Why simulation and rig disagree: where the gap lies, which effect causes it, how far it shrinks with that effect."""

from wirewear.diagnosis.diagnose import Diagnosed, diagnose
from wirewear.diagnosis.values import Cause, Diagnosis, Estimate

__all__ = ["Cause", "Diagnosed", "Diagnosis", "Estimate", "diagnose"]
