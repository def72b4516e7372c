"""Mesh lines on which the nodes within a core that sticks are as stiff as it.

The core is the ellipse that sticks in the middle of a contact. Whole nodes stick or slip: those within the core's
outline stick. Where wear takes all pressure from the others, they carry everything, as a punch does whose outline is
that of their cells. What wears depends steeply on that: a hundredth of the radius is a tenth of the volume
(docs/partial_slip.md).

So does a loop's energy, of all nodes in the annulus: they slip as they would come into contact under a growing load,
since tangential tractions are µ times what the pressures under the load lack of those under its part whose friction is
not used (Jäger, Arch. Appl. Mech. 65 (1995) 478).
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
from wirewear.reference.cattaneo_mindlin import cyclic_loss
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
_FITS = 1, 48  #: Of how many lines of nearly one area stiffness is found: of the core's area, then of the one it needs.
_STEEP = 2.5  #: What wears in the end goes with this power of the share of the axes that slips (Popov; 2.7 at 0.5 µP).
#: Of a mean element of the core: by how much a punch of finite elements is larger than one of as many cells of even
#: pressure that are held at their middles.
_LARGER = 0.08
_ABOUT, _NEARLY_ALL = np.array([0.95, 1.0, 1.05]), 0.995  #: Forces over that of the core; over µP at most.
_TOUCHING = 1.15  #: Of the contact's axes: nodes beyond do not touch.
_ROUND_OFF = 1e-9  #: Of the load: cells that part together.

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
        return punch_stiffness(*self[:4]) * (1.0 + _LARGER * sqrt(pi / len(self.x)))


@lru_cache(maxsize=16)
def fitted_to_core(lines: _Lines, contact: Ellipse, share: float, axial_rad: float) -> _Lines:
    """(axial, transverse): copies of `lines`, both stretched alike by up to 7 % within the patch, whose nodes within
    the core are as stiff as it, and that dissipate as they should while the contact is fresh. contact: its angle is
    from the driven body's axis; share: of its axes that sticks; axial_rad: angle of the axial lines from there.
    """
    core = contact.enlarged(share)
    stretches = 1.0 + _STRETCH * np.linspace(-1.0, 1.0, _TRIED)
    tried = [
        (
            replace(lines[0], rim_mm=stretch * lines[0].rim_mm, share=share),
            replace(lines[1], rim_mm=stretch * lines[1].rim_mm, share=share),
        )
        for stretch in stretches
        for share in _SHARES
    ]
    cells = [_within(one, core, axial_rad) for one in tried]
    right = core.major_mm / float(scipy.special.ellipk(1.0 - (core.minor_mm / core.major_mm) ** 2))
    fits: dict[int, float] = {}
    area = pi * core.major_mm * core.minor_mm
    for count in _FITS:
        misfits = [abs(one.area / area - 1.0) + one.unclear for one in cells]
        for place in np.argsort(misfits)[:count]:
            stiffer = cells[place].stiffness / right
            fits[int(place)] = abs(stiffer - 1.0) + cells[place].unclear
        area /= stiffer**2
    off = {place: float(np.sqrt(np.mean(loop_error(tried[place], contact, share, axial_rad) ** 2))) for place in fits}
    # Relative errors of what wears, by that of the stiffness, and of the energy count alike.
    return tried[min(fits, key=lambda one: _STEEP / (1.0 - share) * fits[one] + off[one])]


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


def loop_error(lines: _Lines, contact: Ellipse, share: float, axial_rad: float) -> Array:
    """Relative errors (k,) of the energies of a fresh contact's loops on these lines, of forces about that at which
    `share` of its axes sticks; nodes are cells of even pressure.
    """
    x, y, wide, high, along, across = (one.ravel() for one in _placed(lines, contact, axial_rad))
    # Of two nodes that lie opposite each other, and so bear alike, one.
    half = ((x > 0.0) | ((x == 0.0) & (y >= 0.0))) & (np.hypot(along, across) < _TOUCHING)
    x, y, wide, high, along, across = (one[half] for one in (x, y, wide, high, along, across))
    pairs = np.where((x == 0.0) & (y == 0.0), 0.5, 1.0)
    compliance = pairs * sum(
        depth_by_rectangle(x[:, None] - side * x, y[:, None] - side * y, wide, high) for side in (1.0, -1.0)
    )
    compliance -= np.diag(_LARGER * 0.5 * pi**2 * np.sqrt(wide * high))
    k = (contact.minor_mm / contact.major_mm) ** 2
    whole = float(scipy.special.ellipk(1.0 - k))
    part = pi / 4.0 if k == 1.0 else (whole - float(scipy.special.ellipe(1.0 - k))) / (1.0 - k)
    gap = pi * contact.minor_mm * (part * along**2 + (whole - part) * across**2)
    load, q = pi / 3.0 * contact.major_mm * contact.minor_mm, np.minimum(_ABOUT * (1.0 - share**3), _NEARLY_ALL)
    loads, approach = _unloaded(compliance, gap, pairs * wide * high, load, (1.0 - float(q[-1])) * load)
    force = np.unique([*(loads[0] - loads), *(q * load)])
    moved = np.interp(force, loads[0] - loads, approach[0] - approach)
    work = scipy.integrate.cumulative_trapezoid(force, moved, initial=0.0)
    enclosed = (2.0 * work - force * moved)[np.searchsorted(force, q * load)]
    # µ = 1. A loop loses four times what its first branch encloses, and µP displaces a contact by 1.5 µP/K.
    right = cyclic_loss(q) / 6.0
    return np.asarray(enclosed / (right * load * pi * contact.minor_mm * whole) - 1.0)


def _unloaded(compliance: Array, gap: Array, area: Array, load: float, least: float) -> tuple[Array, Array]:
    """(loads, approaches), (k,) each, of an elastic surface that touches in some of its n cells: at `load`, `least` and
    whenever one parts on the way. compliance: (n, n) displacement at cells by unit pressure on others. gap, area: (n,).
    """
    on, now = np.arange(len(gap)), load
    found: list[tuple[float, float]] = []
    while True:
        lines = np.block([[compliance[np.ix_(on, on)], -np.ones((len(on), 1))], [area[on], np.zeros(1)]])
        start, slope = np.linalg.solve(lines, np.column_stack([np.append(-gap[on], now), np.eye(len(lines))[-1]])).T
        if not found and (start[:-1] < 0.0).any():
            on = on[start[:-1] >= 0.0]
            continue
        found.append((now, start[-1]))
        if now <= least:
            return np.array([one for one, _ in found]), np.array([one for _, one in found])
        parts = np.where(slope[:-1] > 0.0, now - start[:-1] / slope[:-1], -np.inf)
        now = max(float(parts.max(initial=least)), least)
        on = on[parts < now - _ROUND_OFF * load]


def _placed(lines: _Lines, outline: Ellipse, axial_rad: float) -> tuple[Array, ...]:
    """Places x, y and sizes along both axes, in mm, of the cells of all nodes, and places along and across an outline
    in shares of its axes, (n, m) each.
    """
    x, y = lines[0].lines()[:, None], lines[1].lines()
    turn = outline.angle_rad - axial_rad
    along, across = x * np.cos(turn) + y * np.sin(turn), y * np.cos(turn) - x * np.sin(turn)
    every = x, y, np.gradient(x[:, 0])[:, None], np.gradient(y), along / outline.major_mm, across / outline.minor_mm
    return tuple(np.broadcast_arrays(*every))


def _within(lines: _Lines, core: Ellipse, axial_rad: float) -> _Cells:
    x, y, wide, high, along, across = _placed(lines, core, axial_rad)
    turn, reach = core.angle_rad - axial_rad, np.hypot(along, across)
    # Derivatives of the reach, in shares of the outline's, by the axial and the transverse place.
    least = np.maximum(reach, _MIDDLE)
    own, other = along / core.major_mm / least, across / core.minor_mm / least
    slopes = own * np.cos(turn) - other * np.sin(turn), own * np.sin(turn) + other * np.cos(turn)
    element = np.hypot(slopes[0] * wide, slopes[1] * high)
    beyond = (reach - 1.0) / np.maximum(element, _MIDDLE) - _BEYOND
    sticks = beyond < 0.0
    within, outside = float(beyond[sticks].max(initial=-1.0)), float(beyond[~sticks].min(initial=1.0))
    unclear = max(within - _CLEAR[0], 0.0) + max(_CLEAR[1] - outside, 0.0)
    return _Cells(x[sticks], y[sticks], wide[sticks], high[sticks], unclear)


def punch_stiffness(x: Array, y: Array, wide: Array, high: Array) -> float:
    """Load over depth of a flat punch on a half-space, over π times the contact modulus, in mm.
    The punch is made of rectangles with middles (x, y) and sizes (wide, high), each (n,) in mm, under an even pressure
    each.
    """
    depth = depth_by_rectangle(x[:, None] - x, y[:, None] - y, wide, high)
    return float((wide * high) @ np.linalg.solve(depth, np.ones(len(x))))
