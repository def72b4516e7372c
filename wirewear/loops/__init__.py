"""Analysis of fretting loops, simulated and measured alike."""

from wirewear.loops.analysis import analyse_loop
from wirewear.loops.figures import LoopError, LoopFigures, Measured, MicroSlipBranch, StickSlip
from wirewear.loops.friction import PositionResolvedFriction, position_resolved_friction

__all__ = [
    "LoopError",
    "LoopFigures",
    "Measured",
    "MicroSlipBranch",
    "PositionResolvedFriction",
    "StickSlip",
    "analyse_loop",
    "position_resolved_friction",
]
