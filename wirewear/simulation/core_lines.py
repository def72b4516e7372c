"""Mesh lines on which as much wears around a core that sticks, and a fresh loop dissipates as much, as they should.

The core is the ellipse that sticks in the middle of a contact. Whole nodes stick or slip: those within the core's
outline stick. Where wear takes all pressure from the others, they carry everything, and what wears is the gap that is
left at a few rings of nodes. It depends steeply on the lines: a hundredth of the core's radius is a tenth of the volume
(docs/partial_slip.md).

So does a loop's energy, of all nodes in the annulus: they slip as they would come into contact under a growing load,
since tangential tractions are µ times what the pressures under the load lack of those under its part whose friction is
not used (Jäger, Arch. Appl. Mech. 65 (1995) 478).
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property, lru_cache
from math import ceil, pi, sqrt
from typing import NamedTuple

import numpy as np
import scipy

from geometry import EdgeGradedAxis, GradedAxis, RimGradedAxis
from geometry.arrays import Array, BoolArray, IntArray
from solvers.stress.pressing import depth_by_rectangle
from wirewear.reference import LineContact, worn_under_load
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
#: Of how many lines of nearly one area what wears is found, of the core's area and then of the one that its stiffness
#: needs; and loops of how many of these.
_FITS, _LOOPS = (1, 96), 32
#: Of an element: by how much a punch of finite elements is larger than one of as many cells of even pressure that are
#: held at their middles. Runs of balls on 8 and 12 elements a radius wear as cells with 0.05 to 0.07.
_LARGER = 0.06
_AROUND, _OUTWARDS = 32, 300  #: Places at which what wears is integrated: over a quarter turn, and along a radius.
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
    sticks: BoolArray  #: Which of all nodes (n_a, n_t) they are.

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
    """(axial, transverse): copies of `lines`, both stretched alike by up to 7 % within the patch, on which as much
    wears in the end, and is dissipated while the contact is fresh, as should be. contact: its angle is from the driven
    body's axis; share: of its axes that sticks; axial_rad: angle of the axial lines from there.
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
    found: set[int] = set()
    area = pi * core.major_mm * core.minor_mm
    for count in _FITS:
        nearest = np.argsort([abs(one.area / area - 1.0) + one.unclear for one in cells])[:count].tolist()
        found |= set(nearest)
        area *= (right / cells[nearest[-1]].stiffness) ** 2
    worn = _WornGap(contact, share)
    wear = {
        one: abs(_wear_error(worn, tried[one], cells[one].sticks, axial_rad)) + cells[one].unclear
        for one in sorted(found)
    }

    def off(place: int) -> float:
        """Sum of the errors of what wears and of the loop's energy, which count alike."""
        loop = loop_error(tried[place], contact, share, axial_rad)
        return wear[place] + float(np.sqrt(np.mean(loop**2)))

    return tried[min(sorted(wear, key=wear.__getitem__)[:_LOOPS], key=off)]


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
    cells = _Part.of(lines, contact, axial_rad)
    cells = cells.chosen(np.hypot(cells.along, cells.across) < _TOUCHING)
    gap, load = _gap(contact, cells.along, cells.across), _load(contact) / len(cells.sides)
    q = np.minimum(_ABOUT * (1.0 - share**3), _NEARLY_ALL)
    loads, approach = _unloaded(cells.compliance(cells), gap, cells.area, load, (1.0 - float(q[-1])) * load)
    force = np.unique([*(loads[0] - loads), *(q * load)])
    moved = np.interp(force, loads[0] - loads, approach[0] - approach)
    work = scipy.integrate.cumulative_trapezoid(force, moved, initial=0.0)
    enclosed = (2.0 * work - force * moved)[np.searchsorted(force, q * load)]
    # µ = 1. A loop loses four times what its first branch encloses, and µP displaces a contact by 1.5 µP/K.
    right = cyclic_loss(q) / 6.0
    return np.asarray(enclosed / (right * load * _depth(contact)) - 1.0)


def wear_error(lines: _Lines, contact: Ellipse, share: float, axial_rad: float) -> float:
    """Relative error of the volume that wears on these lines, under a load that stays, until nothing is pressed but the
    `share` of a contact's axes that sticks; nodes are cells of even pressure.
    """
    worn = _WornGap(contact, share)
    return _wear_error(worn, lines, _within(lines, worn.core, axial_rad).sticks, axial_rad)


def _wear_error(worn: "_WornGap", lines: _Lines, sticks: BoolArray, axial_rad: float) -> float:
    cells = _Part.of(lines, worn.contact, axial_rad)
    within = sticks.ravel()[cells.number]
    core = cells.chosen(within)
    around = cells.chosen(~within & (np.hypot(cells.along, cells.across) < worn.edge))
    rows = np.block([[core.compliance(core), -np.ones((len(core.x), 1))], [core.area, np.zeros(1)]])
    load = worn.load / len(cells.sides)
    found = np.linalg.solve(rows, np.append(-_gap(worn.contact, core.along, core.across), load))
    left = found[-1] - _gap(worn.contact, around.along, around.across) - around.compliance(core) @ found[:-1]
    return float(len(cells.sides) * (np.maximum(left, 0.0) @ around.area) / worn.volume - 1.0)


class _WornGap:
    """The gap that wear leaves around the core, `share` of a contact's axes, under a load that stays (Ciavarella and
    Hills, Eur. J. Mech. A 18 (1999) 491): pressure is 1 in the fresh contact's middle, and π times the contact modulus.
    """

    def __init__(self, contact: Ellipse, share: float) -> None:
        self.contact, self.core, self.share = contact, contact.enlarged(share), share
        self.load = _load(contact)

    @cached_property
    def edge(self) -> float:
        """Share of the contact's axes beyond which nothing wears: across a slender one larger than of a circle."""
        return 1.3 * worn_under_load(1.0, 1.0, 4.0 / 3.0, 1.0 - self.share**3).edge_radius_mm

    @cached_property
    def volume(self) -> float:
        """Volume in mm³ that wears in the end: of the gap around the core, where it is open."""
        turn = 0.5 * pi * (np.arange(_AROUND) + 0.5) / _AROUND
        steps = (np.arange(_OUTWARDS) + 0.5) / _OUTWARDS
        wide = self.edge - self.share
        radius, width = self.share + wide * steps**2, 2.0 * wide * steps / _OUTWARDS
        left = np.maximum(self.left(*np.multiply.outer([np.cos(turn), np.sin(turn)], radius)), 0.0)
        area = 4.0 * self.contact.major_mm * self.contact.minor_mm * 0.5 * pi / _AROUND
        return float(area * (left @ (radius * width)).sum())

    def left(self, along: Array, across: Array) -> Array:
        """At places outside the core in shares of the contact's axes, of their shape. The core is pressed as Hertz has
        it under its share of the load, and by the rest as a flat punch.
        """
        core, used = self.core, (1.0 - self.share**3) * self.load
        a, b = core.major_mm**2, core.minor_mm**2
        x, y = (along * self.contact.major_mm) ** 2, (across * self.contact.minor_mm) ** 2
        half = 0.5 * (x + y - a - b)
        out = np.maximum(half + np.sqrt(np.maximum(half**2 + x * b + y * a - a * b, 0.0)), 0.0)
        flat = scipy.special.elliprf(a + out, b + out, out)
        long, short = a + out, b + out
        bent = x * scipy.special.elliprd(short, out, long) + y * scipy.special.elliprd(long, out, short)
        moved = pi * self.share * core.major_mm * core.minor_mm * (flat - bent / 3.0) + used * flat
        approach = self.share * _depth(core) + used * _depth(core) / (pi * core.major_mm * core.minor_mm)
        return np.asarray(approach - _gap(self.contact, along, across) - moved)


def _load(contact: Ellipse) -> float:
    """Load on Hertz's contact of these axes whose pressure is 1 in the middle."""
    return 2.0 / 3.0 * pi * contact.major_mm * contact.minor_mm


def _depth(contact: Ellipse) -> float:
    """Hertz's approach of pressures that are 1 in the middle, times π and the contact modulus."""
    return pi * contact.minor_mm * float(scipy.special.ellipk(1.0 - (contact.minor_mm / contact.major_mm) ** 2))


def _gap(contact: Ellipse, along: Array, across: Array) -> Array:
    """Gap between the unworn bodies at places in shares of the contact's axes, in the unit of `_depth`."""
    k = (contact.minor_mm / contact.major_mm) ** 2
    whole = float(scipy.special.ellipk(1.0 - k))
    part = pi / 4.0 if k == 1.0 else (whole - float(scipy.special.ellipe(1.0 - k))) / (1.0 - k)
    return np.asarray(pi * contact.minor_mm * (part * along**2 + (whole - part) * across**2))


class _Part(NamedTuple):
    """Cells (n,) of a quarter of all nodes, or of half of them if the contact lies across the lines: others are their
    images by the signs `sides`, and bear alike. Places and sizes are in mm, along and across in shares of its axes.
    """

    number: IntArray  #: Of the node.
    x: Array
    y: Array
    wide: Array
    high: Array
    along: Array
    across: Array
    sides: Sequence[tuple[float, float]]

    @classmethod
    def of(cls, lines: _Lines, contact: Ellipse, axial_rad: float) -> "_Part":
        x, y, *sizes, along, across = (one.ravel() for one in _placed(lines, contact, axial_rad))
        askew = abs(np.sin(2.0 * (contact.angle_rad - axial_rad))) > _MIDDLE and contact.major_mm > contact.minor_mm
        chosen = (x > 0.0) | ((x == 0.0) & (y >= 0.0)) if askew else (x >= 0.0) & (y >= 0.0)
        sides = [(1.0, 1.0), (-1.0, -1.0), *([] if askew else [(1.0, -1.0), (-1.0, 1.0)])]
        return cls(np.arange(len(x)), x, y, sizes[0], sizes[1], along, across, sides).chosen(chosen)

    def chosen(self, which: BoolArray) -> "_Part":
        """Some of these cells, marked (n,)."""
        x, y, wide, high, along, across = (one[which] for one in self[1:-1])
        return _Part(self.number[which], x, y, wide, high, along, across, self.sides)

    @property
    def weight(self) -> Array:
        """The share of a cell's images that are not another one of them."""
        if len(self.sides) == 2:
            return np.where((self.x == 0.0) & (self.y == 0.0), 0.5, 1.0)
        return np.where(self.x == 0.0, 0.5, 1.0) * np.where(self.y == 0.0, 0.5, 1.0)

    @property
    def area(self) -> Array:
        """In mm²; of a cell that is its own image, that much less."""
        return self.weight * self.wide * self.high

    def compliance(self, by: "_Part") -> Array:
        """(n, m) displacement at these cells by unit pressure on m others and on their images."""
        found = by.weight * sum(
            depth_by_rectangle(self.x[:, None] - side * by.x, self.y[:, None] - end * by.y, by.wide, by.high)
            for side, end in by.sides
        )
        if by is self:
            found -= np.diag(_LARGER * 0.5 * pi**2 * np.sqrt(by.wide * by.high))
        return np.asarray(found)


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
    return _Cells(x[sticks], y[sticks], wide[sticks], high[sticks], unclear, sticks)


def punch_stiffness(x: Array, y: Array, wide: Array, high: Array) -> float:
    """Load over depth of a flat punch on a half-space, over π times the contact modulus, in mm.
    The punch is made of rectangles with middles (x, y) and sizes (wide, high), each (n,) in mm, under an even pressure
    each.
    """
    depth = depth_by_rectangle(x[:, None] - x, y[:, None] - y, wide, high)
    return float((wide * high) @ np.linalg.solve(depth, np.ones(len(x))))
