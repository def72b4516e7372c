"""How a bed of debris and a lack of oxygen change the worn profile of a line contact, by two half-planes with a bed
between.

The gap between pad and flat, less the debris in it, closes by the pad's approach; pressures on the half-planes
(Johnson, Contact Mechanics, 1985, section 2.4) and on the bed follow from it. Wear goes with the local pressure at a
step's end, so that contacts conform. The stroke's own width is neglected, and only the difference from the same contact
without bed and with oxygen everywhere is used. The worn area is the worn cross-section of both bodies together. Lengths
are in mm, pressures in MPa.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from geometry.arrays import Array
from solvers import OxygenSupply
from wirewear.results.scar import crossings
from wirewear.test.faces import Face

#: Places from the middle to the edge; steps over which the worn area grows; its first share of the last.
_PLACES, _STEPS, _FIRST_SHARE = 81, 26, 0.01

#: Newton's steps for the approach, and by which share of the load they may miss.
_NEWTON_STEPS, _NEWTON_TOLERANCE = 25, 1e-6

#: A scar ends where it is so deep against its deepest place.
EDGE = 0.03


@dataclass(frozen=True)
class WornLineContact:
    """A line contact per mm of length, with the debris and oxygen that affect its wear. Load, Hertz's half-width and
    modulus are those before any wear.
    """

    face: Face  #: Of the pad.
    load_N_per_mm: float
    hertz_half_width_mm: float
    contact_modulus_MPa: float
    reach_mm: float  #: Half-width of the region in which profiles are computed.
    most_area_mm2: float  #: Worn area up to which wear is followed.
    retained_fraction: float = 0.0  #: Share of the worn material that stays in the contact as debris, 0 to 1.
    modulus_MPa: float = 0.0  #: Modulus of the debris; zero for a rigid bed.
    #: Supply of oxygen over 4 times friction, slip amplitude and frequency; zero for oxygen everywhere.
    supply_mm3_MPa: float = 0.0
    starved_factor: float = 1.0  #: Factor on the wear coefficients where there is no oxygen.

    @property
    def plain(self) -> WornLineContact:
        """This contact without a bed of debris and with oxygen everywhere."""
        return replace(self, retained_fraction=0.0, modulus_MPa=0.0, supply_mm3_MPa=0.0, starved_factor=1.0)


@dataclass(frozen=True, eq=False)
class WornLine:
    """Profiles of a line contact at k worn areas."""

    x_mm: Array  #: (m,) distance from the contact's middle; profiles are symmetric.
    area_mm2: Array  #: (k,) worn area, increasing from 0.
    depth_mm: Array  #: (k, m) worn depth of both bodies together.
    factor: Array  #: (k,) mean factor on the wear coefficients by lack of oxygen.
    half_width_mm: Array  #: (k,) of the scar.

    def depth_at(self, area_mm2: float) -> Array:
        """Depths (m,) in mm worn off both bodies together at this worn area."""
        return between(self.area_mm2, self.depth_mm, area_mm2, 1.5)

    def half_width_at(self, area_mm2: float) -> float:
        """Half-width of the scar in mm at a worn area, linear between those computed and constant beyond them."""
        return float(np.interp(area_mm2, self.area_mm2, self.half_width_mm))

    def factor_at(self, area_mm2: Array) -> Array:
        """Mean factors (n,) on the wear coefficients at worn areas (n,) in mm²."""
        return np.interp(area_mm2, self.area_mm2, self.factor)


@lru_cache(maxsize=512)
def worn_line(contact: WornLineContact) -> WornLine:
    """Profiles of a line contact as it wears, from none to its largest worn area; computed once for each contact."""
    x = np.linspace(0.0, contact.reach_mm, _PLACES)
    weight = np.full(x.size, 2.0 * x[1])
    weight[[0, -1]] = x[1]
    elastic = _half_planes(x, contact.contact_modulus_MPa)
    fall = -contact.face.height(np.column_stack([x, np.zeros_like(x)]))
    areas = contact.most_area_mm2 * np.concatenate([[0.0], np.geomspace(_FIRST_SHARE, 1.0, _STEPS)])
    depth, share = np.zeros(x.size), np.ones(x.size)
    guess = np.where(x < max(contact.hertz_half_width_mm, x[1]), contact.load_N_per_mm, 0.0)
    pressure = _pressures(contact, elastic, fall, _Worn(depth, share, 0.0), weight, guess / float(weight @ guess))
    kept, factors, reached = [depth], [1.0], [0.0]
    for wanted in areas[1:]:
        share = _breathing(contact, pressure, x)
        gain = (wanted - reached[-1]) / float(weight @ (share * pressure))
        pressure = _pressures(contact, elastic, fall, _Worn(depth, share, gain), weight, pressure)
        depth = depth + gain * share * pressure
        kept.append(depth)
        reached.append(float(weight @ depth))
        factors.append(float(weight @ (share * pressure)) / contact.load_N_per_mm)
    factors[0] = factors[1]
    widths = [_half_width(x, one) for one in kept[1:]]
    return WornLine(x, np.array(reached), np.array(kept), np.array(factors), np.array([widths[0], *widths]))


def _half_planes(x: Array, modulus_MPa: float) -> Array:
    """Closure (m, m) of two half-planes under even pressures on elements about places (Johnson, eq. 2.25).

    Closures are those but for one constant, which goes into the approach.
    """
    step = x[1]

    def integral(place: Array) -> Array:
        far = np.maximum(np.abs(place), 1e-300)
        return np.asarray(place * np.log(far) - place)

    def element(centre: Array) -> Array:
        apart = x[:, None] - centre
        return integral(apart + 0.5 * step) - integral(apart - 0.5 * step)

    both = element(x) + element(-x)
    both[:, 0] *= 0.5
    return np.asarray(-2.0 / (np.pi * modulus_MPa) * both)


@dataclass(frozen=True, eq=False)
class _Worn:
    """A wear step: depths (m,) before it, factors (m,) on the wear, and depth that a pressure wears in it."""

    depth: Array
    share: Array
    gain: float


def _pressures(
    contact: WornLineContact, elastic: Array, fall: Array, step: _Worn, weight: Array, guess: Array
) -> Array:
    """Pressures (m,) that carry the load at a step's end, by Newton's method on the places that touch."""
    soft = contact.retained_fraction / contact.modulus_MPa if contact.modulus_MPa > 0.0 else 0.0
    opens = 1.0 - contact.retained_fraction
    wears, gap = step.gain * step.share, fall + opens * step.depth
    pressure = guess * (contact.load_N_per_mm / float(weight @ guess))
    touching, approach = pressure > 0.0, 0.0
    for _ in range(_NEWTON_STEPS):
        closed = elastic @ pressure + soft * (step.depth + wears * pressure) * pressure + opens * wears * pressure + gap
        slope = soft * (step.depth + 2.0 * wears * pressure) + opens * wears
        own = np.flatnonzero(touching)
        matrix = np.zeros((own.size + 1, own.size + 1))
        matrix[:-1, :-1] = elastic[np.ix_(own, own)]
        matrix[np.arange(own.size), np.arange(own.size)] += slope[own]
        matrix[:-1, -1], matrix[-1, :-1] = -1.0, weight[own]
        rest = np.append(approach - closed[own], contact.load_N_per_mm - float(weight[own] @ pressure[own]))
        moved = np.linalg.solve(matrix, rest)
        after = np.zeros_like(pressure)
        after[own] = pressure[own] + moved[:-1]
        approach += float(moved[-1])
        changed = float(np.abs(after - pressure).max())
        left = touching & (after < 0.0)
        pressure = np.maximum(after, 0.0)
        found = ~touching & (elastic @ pressure + gap < approach)
        touching = (touching & ~left) | found
        if not left.any() and not found.any() and changed < _NEWTON_TOLERANCE * float(pressure.max()):
            break
    return pressure


def _breathing(contact: WornLineContact, pressure: Array, x: Array) -> Array:
    """Factors (m,) on the wear coefficients under these pressures: by the law of the full simulation."""
    if contact.supply_mm3_MPa <= 0.0 or contact.starved_factor == 1.0:
        return np.ones(x.size)
    half = _half_width(x, pressure)
    # Supply and power density both over 4 times friction, slip and frequency.
    supply = OxygenSupply(contact.supply_mm3_MPa, contact.starved_factor)
    return supply.factors(np.maximum(half - x, 0.0), contact.load_N_per_mm / (2.0 * half))


def _half_width(x: Array, values: Array) -> float:
    """Where values that fall outwards come down to a small share of the largest."""
    return max(crossings(x, values, EDGE * float(values.max()))[1], float(x[1]))


def between(known: Array, rows: Array, at: float, most: float) -> Array:
    """Row (m,) at `at`, linear between rows (k, m) at increasing coordinates `known` (k,). Beyond the last row it goes
    on from the last but one by at most `most` times the difference of both.
    """
    after = int(np.clip(np.searchsorted(known, at), 1, known.size - 1))
    share = (at - known[after - 1]) / (known[after] - known[after - 1])
    return np.asarray(rows[after - 1] + np.clip(share, 0.0, most) * (rows[after] - rows[after - 1]))


def transformed(x_um: Array, depth_um: Array, before: WornLine, after: WornLine, area_mm2: float) -> Array:
    """A body's profile (n,) in µm, changed as bed and lack of oxygen change the profile `before` to `after` at this
    worn area. x_um, depth_um: (n,) positions and depths. before: the contact without both. Positions scale with the
    scar's half-width, depths with the local ratio of both profiles; the cross-section stays the same.
    """
    narrow = before.half_width_at(area_mm2) / max(after.half_width_at(area_mm2), 1e-9)
    wide, changed = before.depth_at(area_mm2), after.depth_at(area_mm2)
    place = 1e-3 * np.abs(x_um)
    edge = 0.92 * before.half_width_at(area_mm2)
    inside = np.minimum(place * narrow, edge)
    ratio = np.interp(inside / narrow, after.x_mm, changed) / np.interp(inside, before.x_mm, wide)
    found = ratio * np.interp(narrow * x_um, x_um, depth_um, left=0.0, right=0.0)
    total = float(np.trapezoid(found, x_um))
    return np.asarray(found * (float(np.trapezoid(depth_um, x_um)) / total) if total > 0.0 else found)
