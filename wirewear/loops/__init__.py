"""Analysis of fretting loops, simulated and measured alike, and models of a rig's sensors.

A loop is tangential force Q over displacement δ for one cycle. Its figures are quantities read from it, such as slip
amplitude, dissipated energy and friction. A branch is the half between two reversals of the drive; its micro-slip is
the part up to the onset of gross slip, its plateau the part on which the contact slides.
"""

from typing import TYPE_CHECKING

from geometry.lazy import loaded_late

if TYPE_CHECKING:
    from wirewear.loops.analysis import analyse_loop
    from wirewear.loops.figures import LoopError, LoopFigures, Measured, MicroSlipBranch, StickSlip
    from wirewear.loops.sensor import LoopSignals, Sensor, SensorNoise

__all__ = [
    "LoopError", "LoopFigures", "LoopSignals", "Measured", "MicroSlipBranch", "Sensor", "SensorNoise", "StickSlip",
    "analyse_loop",
]  # fmt: skip

__getattr__ = loaded_late(__name__)
