"""Why simulation and rig disagree: where the gap lies, which effect causes it, how far it shrinks with that effect."""

from typing import TYPE_CHECKING

from geometry.lazy import loaded_late

if TYPE_CHECKING:
    from wirewear.diagnosis.answer import Cause, Diagnosis, Estimate
    from wirewear.diagnosis.confirmation import calibrated, confirmed
    from wirewear.diagnosis.preparation import PreparedRecord, prepared
    from wirewear.diagnosis.record_diagnosis import Diagnosed, diagnose, diagnose_prepared

__all__ = [
    "Cause", "Diagnosed", "Diagnosis", "Estimate", "PreparedRecord", "calibrated", "confirmed", "diagnose",
    "diagnose_prepared", "prepared",
]  # fmt: skip

__getattr__ = loaded_late(__name__)
