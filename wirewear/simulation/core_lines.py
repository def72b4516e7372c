"""Mesh lines on which the nodes within a core that sticks are as stiff as it.

The core is the ellipse that sticks in the middle of a contact. Whole nodes stick or slip: those within the core's
outline stick. Where wear takes all pressure from the others, they carry everything, as a punch does whose outline is
that of their cells. What wears depends steeply on that: a hundredth of the radius is a tenth of the volume
(docs/partial_slip.md).
"""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from math import ceil, pi, sqrt
from typing import NamedTuple

import numpy as np
import scipy

from geometry import EdgeGradedAxis, GradedAxis, RimGradedAxis
from geometry.arrays import Array
from solvers.stress.pressing import depth_by_rectangle
from wirewear.reference import LineContact
from wirewear.simulation.control import unused_friction
from wirewear.simulation.expected_contact import Ellipse
from wirewear.test import LineStudy

#: By how much lines are stretched at most, and how many stretches are tried.
_STRETCH, _TRIED = 0.07, 141
_SHARES = (0.5, 0.55, 0.6, 0.65, 0.7, 0.75)  #: How their sizes fall towards the rim.
_BEYOND = 0.02  #: Of an element: by how much nodes may lie beyond the outline and stick, of Hertz's contacts.
_COARSER = 5.0  #: Elements in the middle of a flat contact, where nothing changes quickly, over those at its edges.
_MIDDLE = 1e-9  #: Of the outline: nodes as near to its middle lie there.
#: Of an element: nodes nearer to the outline within and beyond it might slip or stick.
_CLEAR = -0.12, 0.1
_FITS = 1, 16  #: Of how many lines of nearly one area stiffness is found: of the core's area, then of the one it needs.

_Lines = tuple[RimGradedAxis, RimGradedAxis]


class _Cells(NamedTuple):
    """Cells of the n nodes within an outline: their middles and sizes (n,) along both axes, in mm."""

    x: Array
    y: Array
    wide: Array
    high: Array
    unclear: float  #: By how much nodes lie too near to the outline.

    @property
    def area(self) -> float:
        """Area of the rectangles in mm²."""
        return float(self.wide @ self.high)

    @property
    def stiffness(self) -> float:
        """`punch_stiffness` of a punch of finite elements with these nodes."""
        # Of a mean element of the core: by how much a punch of finite elements is larger than one of as many cells of
        # even pressure that are held at their middles.
        return punch_stiffness(*self[:4]) * (1.0 + 0.08 * sqrt(pi / len(self.x)))


@lru_cache(maxsize=16)
def fitted_to_core(lines: _Lines, core: Ellipse, axial_rad: float) -> _Lines:
    """(axial, transverse): copies of `lines`, both stretched alike by up to 7 % within the patch, whose nodes within
    the core are as stiff as it. core: its angle is from the driven body's axis; axial_rad: angle of the axial lines
    from there.
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
    cells = [_within(axial, transverse, core, axial_rad) for axial, transverse in tried]
    right = core.major_mm / float(scipy.special.ellipk(1.0 - (core.minor_mm / core.major_mm) ** 2))
    fits: dict[int, float] = {}
    area = pi * core.major_mm * core.minor_mm
    for count in _FITS:
        misfits = [abs(one.area / area - 1.0) + one.unclear for one in cells]
        for place in np.argsort(misfits)[:count]:
            stiffer = cells[place].stiffness / right
            fits[int(place)] = abs(stiffer - 1.0) + cells[place].unclear
        area /= stiffer**2
    return tried[min(fits, key=lambda one: fits[one])]


def core_of_line(study: LineStudy, contact_under: Callable[[float], LineContact]) -> float | None:
    """Half-width in mm of a line contact's core under the tangential force that a study holds; None where that is to be
    seen. contact_under: the fresh contact under a load in N/mm.

    It is that of the contact under the load whose friction is not used (Ciavarella, J. Appl. Mech. 65 (1998) 998).
    """
    unused = unused_friction(study)
    return None if unused is None else contact_under(unused * study.conditions.normal_load_N).half_width_mm


def up_to_core(fine_mm: float, half_mm: float, core_mm: float) -> tuple[float, float]:
    """(element size, half-extent): even mesh lines from 0, at most `fine_mm` apart and at least as far as `half_mm`.

    Two lie as far within a line contact's core as beyond it: such nodes are as stiff as it, within 0.05 of an element.
    """
    size = core_mm / (max(ceil(core_mm / fine_mm - 0.5), 1) + 0.5)
    return size, size * ceil(half_mm / size)


def even_lines(fine_mm: float, half_mm: float, even_mm: float, core_mm: float | None) -> GradedAxis | EdgeGradedAxis:
    """Even mesh lines up to `half_mm`, coarser within a flat's middle `even_mm`, 0 for none; fitted to a core."""
    if core_mm is not None and core_mm > even_mm:
        fine_mm, half_mm = up_to_core(fine_mm, half_mm - even_mm, core_mm - even_mm)
        half_mm += even_mm
    if even_mm:
        return EdgeGradedAxis(fine_mm, _COARSER * fine_mm, even_mm, half_mm)
    return GradedAxis(fine_mm, half_mm, fine_mm, half_mm)


def _within(axial: RimGradedAxis, transverse: RimGradedAxis, core: Ellipse, axial_rad: float) -> _Cells:
    x, y = axial.lines()[:, None], transverse.lines()
    sizes = np.gradient(x[:, 0])[:, None], np.gradient(y)
    turn = core.angle_rad - axial_rad
    along, across = x * np.cos(turn) + y * np.sin(turn), y * np.cos(turn) - x * np.sin(turn)
    reach = np.hypot(along / core.major_mm, across / core.minor_mm)
    # Derivatives of the reach, in shares of the outline's, by the axial and the transverse place.
    least = np.maximum(reach, _MIDDLE)
    own, other = along / core.major_mm**2 / least, across / core.minor_mm**2 / least
    slopes = own * np.cos(turn) - other * np.sin(turn), own * np.sin(turn) + other * np.cos(turn)
    element = np.hypot(slopes[0] * sizes[0], slopes[1] * sizes[1])
    beyond = (reach - 1.0) / np.maximum(element, _MIDDLE) - _BEYOND
    sticks = beyond < 0.0
    within, outside = float(beyond[sticks].max(initial=-1.0)), float(beyond[~sticks].min(initial=1.0))
    unclear = max(within - _CLEAR[0], 0.0) + max(_CLEAR[1] - outside, 0.0)
    x, y, wide, high = (np.broadcast_to(one, reach.shape)[sticks] for one in (x, y, *sizes))
    return _Cells(x, y, wide, high, unclear)


def punch_stiffness(x: Array, y: Array, wide: Array, high: Array) -> float:
    """Load over depth of a flat punch on a half-space, over π times the contact modulus, in mm.
    The punch is made of rectangles with middles (x, y) and sizes (wide, high), each (n,) in mm, under an even pressure
    each.
    """
    depth = depth_by_rectangle(x[:, None] - x, y[:, None] - y, wide, high)
    return float((wide * high) @ np.linalg.solve(depth, np.ones(len(x))))
