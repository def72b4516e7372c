"""Criteria of sliding that need no loop's shape: the energy ratio, and the same without what the rig gives way.

Source: Fouvry, Kapsa & Vincent, Wear 185 (1995) 35. For a sphere on a flat, or crossed wires, the transition from
partial to gross slip lies at A = 0.2 and B = 0.77.
"""

import numpy as np

from wirewear.loops.cleaning import CleanLoop
from wirewear.loops.figures import Measured

#: Values at the transition from partial slip to gross slip.
ENERGY_TRANSITION, SYSTEM_FREE_TRANSITION = 0.2, 0.77

#: No contact in partial slip has a larger energy ratio: that of evenly spread limits at the transition (Iwan 1966).
MOST_IN_PARTIAL_SLIP = 1.0 / 3.0


def force_amplitude(loop: CleanLoop, tops: tuple[Measured, Measured]) -> Measured:
    """Q* in N: mean of the largest forces of both directions, which an offset does not shift.

    `tops` are the largest |Q|/P of each, or |Q| without a normal force.
    """
    load = 1.0 if loop.normal_force_N is None else float(np.median(loop.normal_force_N))
    deviation = 0.5 * load * float(np.hypot(tops[0].deviation, tops[1].deviation))
    return Measured.from_deviation(0.5 * load * (tops[0].value + tops[1].value), deviation)


def energy_ratio(energy_mJ: Measured, amplitude_um: Measured, force_N: Measured) -> Measured | None:
    """E_d/(4 δ Q*): A with the displacement amplitude for δ, B with the slip amplitude; None where the box is empty."""
    box = 4e-3 * amplitude_um.value * force_N.value
    if box <= 0.0:
        return None
    ratio = energy_mJ.value / box
    parts = (
        energy_mJ.deviation / box,
        ratio * amplitude_um.deviation / amplitude_um.value,
        ratio * force_N.deviation / force_N.value,
    )
    return Measured.from_deviation(ratio, float(np.linalg.norm(parts)))
