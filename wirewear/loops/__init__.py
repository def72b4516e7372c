"""Analysis of fretting loops, simulated and measured alike, and what a rig's instruments make of the true signals."""

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
