"""Analysis of fretting loops, simulated and measured alike, and what a rig's instruments make of the true signals."""

from typing import TYPE_CHECKING

from geometry.late import loaded_late

if TYPE_CHECKING:
    from wirewear.loops.analysis import analyse_loop
    from wirewear.loops.figures import LoopError, LoopFigures, Measured, MicroSlipBranch, StickSlip
    from wirewear.loops.friction import PositionResolvedFriction, position_resolved_friction
    from wirewear.loops.sensor import LoopSignals, Sensor, SensorNoise

__all__ = [
    "LoopError", "LoopFigures", "LoopSignals", "Measured", "MicroSlipBranch", "PositionResolvedFriction", "Sensor",
    "SensorNoise", "StickSlip", "analyse_loop", "position_resolved_friction",
]  # fmt: skip

__getattr__ = loaded_late(__name__)
