"""Why simulation and rig disagree: where the gap lies, which effect causes it, how far it shrinks with that effect."""

from typing import TYPE_CHECKING

from geometry.late import loaded_late

if TYPE_CHECKING:
    from wirewear.diagnosis.answer import Cause, Diagnosis, Estimate
    from wirewear.diagnosis.confirmation import calibrated, confirmed
    from wirewear.diagnosis.record_diagnosis import diagnose
    from wirewear.diagnosis.wording import Diagnosed
    from wirewear.views.diagnosis_page import ten_lines, write_diagnosis

__all__ = [
    "Cause", "Diagnosed", "Diagnosis", "Estimate", "calibrated", "confirmed", "diagnose", "ten_lines",
    "write_diagnosis",
]  # fmt: skip

__getattr__ = loaded_late(__name__)
