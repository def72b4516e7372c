"""Mesh lines on which the nodes within a core that sticks have its area.

Whole nodes stick or slip: those within the core's outline stick. Where wear takes all pressure from the others, they
carry everything, as a punch does whose area is the sum of theirs. What wears depends steeply on that: a hundredth of
the radius is a tenth of the volume (docs/partial_slip.md).
"""

from dataclasses import replace
from math import pi

import numpy as np

from geometry import RimGradedAxis
from geometry.arrays import Array
from wirewear.simulation.expected_contact import Ellipse

#: By how much lines are stretched at most, and how many stretches are tried.
_STRETCH, _TRIED = 0.07, 141
_SHARES = (0.5, 0.55, 0.6, 0.65, 0.7, 0.75)  #: How their sizes fall towards the rim.
_BEYOND = 0.02  #: Of an element: by how much nodes may lie beyond the outline and stick, of Hertz's contacts.
_MIDDLE = 1e-9  #: Of the outline: nodes as near to its middle lie there.
#: Of an element: nodes nearer to the outline within and beyond it might slip or stick.
_CLEAR = -0.12, 0.1


def fitted_to_core(
    lines: tuple[RimGradedAxis, RimGradedAxis], core: Ellipse, axial_rad: float
) -> tuple[RimGradedAxis, RimGradedAxis]:
    """Axial and transverse lines, both stretched alike within the patch, that fit a core best.

    core: its angle as that of the axial lines is from the driven body's axis.
    """
    stretches = 1.0 + _STRETCH * np.linspace(-1.0, 1.0, _TRIED)
    tried = [
        (
            replace(lines[0], rim_mm=stretch * lines[0].rim_mm, share=share),
            replace(lines[1], rim_mm=stretch * lines[1].rim_mm, share=share),
        )
        for stretch in stretches
        for share in _SHARES
    ]
    misfits = [_misfit(axial, transverse, core, axial_rad) for axial, transverse in tried]
    return tried[int(np.argmin(misfits))]


def _misfit(axial: RimGradedAxis, transverse: RimGradedAxis, core: Ellipse, axial_rad: float) -> float:
    """By how much the area of the nodes within an outline is off, and more where nodes lie next to it."""
    x, y = axial.lines()[:, None], transverse.lines()
    sizes = np.gradient(axial.lines())[:, None], np.gradient(transverse.lines())
    turn = core.angle_rad - axial_rad
    along, across = x * np.cos(turn) + y * np.sin(turn), y * np.cos(turn) - x * np.sin(turn)
    reach = np.hypot(along / core.major_mm, across / core.minor_mm)
    slopes = _slopes(along, across, core, reach, turn)
    element = np.hypot(slopes[0] * sizes[0], slopes[1] * sizes[1])
    beyond = (reach - 1.0) / np.maximum(element, _MIDDLE) - _BEYOND
    area = float((sizes[0] * sizes[1])[beyond < 0.0].sum())
    off = abs(area / (pi * core.major_mm * core.minor_mm) - 1.0)
    within, outside = float(beyond[beyond < 0.0].max(initial=-1.0)), float(beyond[beyond > 0.0].min(initial=1.0))
    return off + max(within - _CLEAR[0], 0.0) + max(_CLEAR[1] - outside, 0.0)


def _slopes(along: Array, across: Array, core: Ellipse, reach: Array, turn: float) -> tuple[Array, Array]:
    """Derivatives of the reach, in shares of the outline's, by the axial and the transverse place."""
    least = np.maximum(reach, _MIDDLE)
    own, other = along / core.major_mm**2 / least, across / core.minor_mm**2 / least
    return own * np.cos(turn) - other * np.sin(turn), own * np.sin(turn) + other * np.cos(turn)
