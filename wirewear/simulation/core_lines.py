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
from math import ceil, pi
from typing import NamedTuple

import numpy as np
import scipy

from geometry import EdgeGradedAxis, GradedAxis, RimGradedAxis
from geometry.arrays import Array, BoolArray, IntArray
from wirewear.reference import LineContact, worn_under_load
from wirewear.reference.cattaneo_mindlin import cyclic_loss
from wirewear.simulation.cells import depth_of_cells, punch_stiffness
from wirewear.simulation.control import unused_friction
from wirewear.simulation.expected_contact import Ellipse
from wirewear.test import LineStudy

#: By how much lines are stretched at most, and how many stretches are tried.
_STRETCH, _TRIED = 0.09, 91
_SHARES = tuple(0.05 * step for step in range(9, 17))  #: How their sizes fall towards the rim: 0.45 to 0.8.
_BEYOND = 0.02  #: Of an element: by how much nodes may lie beyond the outline and stick, of Hertz's contacts.
_COARSER = 5.0  #: Elements in the middle of a flat contact, where nothing changes quickly, over those at its edges.
_MIDDLE = 1e-9  #: Of the outline: nodes as near to its middle lie there.
#: Of an element: nodes nearer to the outline within and beyond it might slip or stick.
_CLEAR = -0.12, 0.1
#: Of how many lines of nearly one area errors are found: of the core's area, then of the one that its stiffness needs.
_FITS = 1, 224
#: Of the elements to the rim the least share, and how many of them the annulus that slips must have at least.
_FEWEST, _ACROSS = 0.75, 2.0
_WELL_ENOUGH = 0.16  #: Error over one by the elements to the rim up to which fewer of them serve.
_DEEPEST, _DOUBT = 0.1, 0.5  #: Weights of the largest depth, which few nodes have, and of nodes near the outline.
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
        """`punch_stiffness` of these cells."""
        return punch_stiffness(*self[:4])


@lru_cache(maxsize=16)
def fitted_to_core(lines: _Lines, contact: Ellipse, share: float, axial_rad: float) -> _Lines:
    """(axial, transverse): copies of `lines`, both stretched alike by up to 9 % within the patch, on which as much
    wears in the end, and is dissipated while the contact is fresh, as should be. Of these the fewest, down to three
    quarters of the elements to the rim, that do so well enough. contact: its angle is from the driven body's axis;
    share: of its axes that sticks; axial_rad: angle of the axial lines from there.
    """
    worn, most = _WornGap(contact, share), lines[0].elements
    for elements in range(ceil(max(_FEWEST * most, _ACROSS / (1.0 - share))), most):
        axial, transverse = (replace(one, elements=round(one.elements * elements / most)) for one in lines)
        fitted, error = _fitted((axial, transverse), worn, axial_rad, clear=True)
        if error <= _WELL_ENOUGH / most:
            return fitted
    return _fitted(lines, worn, axial_rad)[0]


def _fitted(lines: _Lines, worn: "_WornGap", axial_rad: float, *, clear: bool = False) -> tuple[_Lines, float]:
    """(lines, weighted sum of their errors): the best copies of `lines`; the error is infinite if there are none whose
    nodes are `clear`, which slip or stick beyond doubt.
    """
    core, stretches = worn.core, 1.0 + _STRETCH * np.linspace(-1.0, 1.0, _TRIED)
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
    worn_off = {}
    for place in (one for one in found if not (clear and cells[one].unclear)):
        part, depths = _pressed(tried[place], worn, axial_rad)
        volume, deepest = map(abs, _wear_errors(worn, part, depths, cells[place].sticks))
        worn_off[place] = _DOUBT * cells[place].unclear + volume + _DEEPEST * deepest
    best, least = lines, np.inf
    # Loops take the longest: of those that wear best, until the others are worse by that alone.
    for place in sorted(worn_off, key=lambda one: (worn_off[one], one)):
        if worn_off[place] >= least:
            break
        loops = _loop_error(worn, *_pressed(tried[place], worn, axial_rad))
        error = worn_off[place] + float(np.sqrt(np.mean(loops**2)))
        if error < least:
            best, least = tried[place], error
    return best, least


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
    worn = _WornGap(contact, share)
    return _loop_error(worn, *_pressed(lines, worn, axial_rad))


def wear_error(lines: _Lines, contact: Ellipse, share: float, axial_rad: float) -> float:
    """Relative error of the volume that wears on these lines, under a load that stays, until nothing is pressed but the
    `share` of a contact's axes that sticks; nodes are cells of even pressure.
    """
    worn = _WornGap(contact, share)
    return _wear_errors(worn, *_pressed(lines, worn, axial_rad), _within(lines, worn.core, axial_rad).sticks)[0]


def _pressed(lines: _Lines, worn: "_WornGap", axial_rad: float) -> tuple["_Part", Array]:
    """The n cells within which a contact wears, those of the m that may touch first, and their displacements (n, m) by
    unit pressure on these.
    """
    cells = _Part.of(lines, worn.contact, axial_rad)
    reach = np.hypot(cells.along, cells.across)
    touch, count = reach < _TOUCHING, int((reach < _TOUCHING).sum())
    part = cells.chosen(np.append(np.flatnonzero(touch), np.flatnonzero(~touch & (reach < worn.edge))))
    return part, part.compliance(part.chosen(slice(count)))


def _loop_error(worn: "_WornGap", part: "_Part", compliance: Array) -> Array:
    contact, cells = worn.contact, part.chosen(slice(compliance.shape[1]))
    gap, load = _gap(contact, cells.along, cells.across), worn.load / len(cells.sides)
    q = np.minimum(_ABOUT * (1.0 - worn.share**3), _NEARLY_ALL)
    loads, approach = _unloaded(compliance[: len(gap)], gap, cells.area, load, (1.0 - float(q[-1])) * load)
    force = np.unique([*(loads[0] - loads), *(q * load)])
    moved = np.interp(force, loads[0] - loads, approach[0] - approach)
    work = scipy.integrate.cumulative_trapezoid(force, moved, initial=0.0)
    enclosed = (2.0 * work - force * moved)[np.searchsorted(force, q * load)]
    # µ = 1. A loop loses four times what its first branch encloses, and µP displaces a contact by 1.5 µP/K.
    right = cyclic_loss(q) / 6.0
    return np.asarray(enclosed / (right * load * _depth(contact)) - 1.0)


def _wear_errors(worn: "_WornGap", part: "_Part", compliance: Array, sticks: BoolArray) -> tuple[float, float]:
    within, load = sticks.ravel()[part.number], worn.load / len(part.sides)
    gap, core = _gap(worn.contact, part.along, part.across), within[: compliance.shape[1]]
    rows = np.block([[compliance[within][:, core], -np.ones((core.sum(), 1))], [part.area[within], np.zeros(1)]])
    found = np.linalg.solve(rows, np.append(-gap[within], load))
    left = found[-1] - gap[~within] - compliance[~within][:, core] @ found[:-1]
    volume = float(len(part.sides) * (np.maximum(left, 0.0) @ part.area[~within]))
    return volume / worn.volume - 1.0, float(left.max()) / worn.deepest - 1.0


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
    def deepest(self) -> float:
        """The largest gap on the contact's axes."""
        radius = np.linspace(self.share, self.edge, _OUTWARDS)
        return float(max(self.left(radius, 0.0 * radius).max(), self.left(0.0 * radius, radius).max()))

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
    images by the signs `sides`, and bear alike. Middles and sizes of cells are in mm, places of nodes along and across
    in shares of its axes.
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

    def chosen(self, which: BoolArray | IntArray | slice) -> "_Part":
        """A part of those cells that `which` marks (n,), or whose indices it holds."""
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
        """(n, m) displacement of these cells by unit pressure on m others and on their images."""
        found = sum(
            depth_of_cells(self.x[:, None] - side * by.x, self.y[:, None] - end * by.y, self.sizes, by.sizes)
            for side, end in by.sides
        )
        return np.asarray(by.weight * found)

    @property
    def sizes(self) -> tuple[Array, Array]:
        return self.wide, self.high


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
    """Middles x, y and sizes along both axes, in mm, of the cells of all nodes, and places of the nodes along and
    across an outline in shares of its axes, (n, m) each.
    """
    x, y = lines[0].lines()[:, None], lines[1].lines()
    turn = outline.angle_rad - axial_rad
    along, across = x * np.cos(turn) + y * np.sin(turn), y * np.cos(turn) - x * np.sin(turn)
    wide, high = np.gradient(x[:, 0])[:, None], np.gradient(y)
    # One body's nodes bear at their places, the other's what their hat functions gather around their middles.
    middle, centre = x + _ahead(x[:, 0])[:, None], y + _ahead(y)
    every = middle, centre, wide, high, along / outline.major_mm, across / outline.minor_mm
    return tuple(np.broadcast_arrays(*every))


def _ahead(lines: Array) -> Array:
    """Half the distance (n,) from each of n lines to the middle of its hat function."""
    return np.pad(np.diff(lines, 2) / 6.0, 1)


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
