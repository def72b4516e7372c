"""Where a contact ends between nodes, and the area within.

Next to the edge a power of the pressure falls as the square of the distance from the middle: its square on every line
through Hertz's ellipse, itself on springs, and on thin soft layers one in between, as three nodes show. It is
followed from the outermost pressed nodes of a line to where it vanishes, but at most to the next node; where it does
not fall, the contact ends midway. Holes are as wide as their nodes.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geometry import ContactPatch
from geometry.arrays import Array, BoolArray, IntArray

_NODES = 3  #: Outermost nodes through which the power of the pressure is laid.


@dataclass(frozen=True)
class Footprint:
    """Where a patch touches, sought when it is asked for: few increments' extents are."""

    patch: ContactPatch
    pressure: Array  #: (n,) at the patch's nodes, MPa, 0 where it does not touch.
    world_to_patch: Array  #: (2, 2) turn of the plane.

    @cached_property
    def area(self) -> float:
        """Area of contact in the plane, mm²."""
        return float(areas([self])[0])

    @cached_property
    def half_widths(self) -> Array:
        """(2,) halves of its extent along x and y of the world, mm."""
        return np.asarray(half_widths([self])[0])


def half_widths(footprints: Sequence[Footprint]) -> Array:
    """(s, 2) halves of the extents of s contacts of one patch along x and y of the world, mm."""
    if not footprints:
        return np.zeros((0, 2))
    first = footprints[0]
    edge, there, _ = _edges(first.patch, np.stack([own.pressure for own in footprints]))
    places, there = edge @ first.world_to_patch, there[..., None]
    low, high = np.where(there, places, np.inf).min(axis=1), np.where(there, places, -np.inf).max(axis=1)
    return np.asarray(0.5 * np.maximum(high - low, 0.0))


def areas(footprints: Sequence[Footprint]) -> Array:
    """(s,) areas in mm² of s contacts of one patch in the plane; of a line contact, of one millimetre of it."""
    return extent(footprints[0].patch, np.stack([own.pressure for own in footprints]))[0] if footprints else np.zeros(0)


def extent(patch: ContactPatch, pressures: Array) -> tuple[Array, list[Array]]:
    """Areas (s,) of contact in mm², and of each places (k, 2) of its edge along the patch's lines, from pressures
    (s, n) at the nodes of the patch that are 0 where it does not touch; of a line contact areas are those of one
    millimetre.
    """
    edges, there, chords = _edges(patch, pressures)
    places = [edge[at] for edge, at in zip(edges, there, strict=True)]
    if len(chords) == 1:
        return np.asarray(chords[0][:, 0]), places
    both = zip((patch.transverse_mm, patch.axial_mm), chords, strict=True)
    across, along = (np.array([_area(lines, own) for own in chord]) for lines, chord in both)
    return 0.5 * (across + along), places


def _edges(patch: ContactPatch, pressures: Array) -> tuple[Array, BoolArray, list[Array]]:
    """Both ends (s, k, 2) of all lines of the patch under each of the pressures (s, n), whether a line is pressed
    (s, k), and the pressed lengths of its lines along it and, but for a line contact, across it.
    """
    tables, lines = pressures.reshape(-1, *patch.shape), (patch.axial_mm, patch.transverse_mm)
    ends, chords = [], []
    for k in range(2 if patch.shape[1] > 1 else 1):
        low, high, chord = _chords(lines[k], np.moveaxis(tables, 1 + k, 0))
        for own in (low, high):
            place = np.broadcast_to(lines[1 - k], own.shape)
            ends.append(np.stack([own, place] if k == 0 else [place, own], axis=-1))
        chords.append(chord)
    there = np.concatenate([chord > 0.0 for chord in chords for _ in range(2)], axis=1)
    return np.concatenate(ends, axis=1), there, chords


def _chords(lines: Array, pressure: Array) -> tuple[Array, Array, Array]:
    """Both ends and pressed length (s, m) of each column of pressures (n, s, m) at places `lines` (n,), 0 of none."""
    pressed = pressure > 0.0
    some = pressed.any(axis=0)
    first, last = pressed.argmax(axis=0), len(lines) - 1 - pressed[::-1].argmax(axis=0)
    middle = 0.5 * (lines[first] + lines[last])
    low, high = _ends(lines, pressure, middle, np.stack([first, last]))
    rows = np.arange(len(lines))[:, None, None]
    holes = ~pressed & (rows > first) & (rows < last)
    bare = np.tensordot(np.gradient(lines), holes, 1) if holes.any() else 0.0
    return low * some, high * some, np.where(some, high - low - bare, 0.0)


def _ends(lines: Array, pressure: Array, middle: Array, node: IntArray) -> Array:
    """Where columns of pressures (n, s, m) end below and above (2, s, m), beyond their outermost pressed `node`."""
    step, most = np.array([-1, 1])[:, None, None], len(lines) - 1
    inside: IntArray = np.clip(node - step * np.arange(_NODES)[:, None, None, None], 0, most)
    offsets, pressures = lines[inside] - middle, np.take_along_axis(pressure[:, None], inside, axis=0)
    # A line's nodes count as far as all before them do.
    counted: BoolArray = np.logical_and.accumulate((pressures > 0.0) & (offsets * step >= 0.0))
    x, w = offsets**2, counted.astype(np.float64)
    y = _straightened(x, pressures, np.asarray(counted.all(axis=0)))
    total = np.maximum(w.sum(axis=0), 1.0)
    x0, y0 = (w * x).sum(axis=0) / total, (w * y).sum(axis=0) / total
    away = w * (x - x0)
    spread, fall = (away * (x - x0)).sum(axis=0), -(away * (y - y0)).sum(axis=0)
    after, falls = lines[np.clip(node + step, 0, most)] - middle, fall > 0.0
    vanishes = x0 + y0 * spread / np.where(falls, fall, 1.0)
    reach = np.where(falls, np.sqrt(np.maximum(vanishes, 0.0)), 0.5 * np.abs(offsets[0] + after))
    return np.asarray(middle + step * np.clip(reach, np.abs(offsets[0]), np.abs(after)))


def _straightened(x: Array, pressures: Array, known: BoolArray) -> Array:
    """Pressures (3, 2, s, m) over their largest, to the power of 1 to 2 that is most nearly linear in x; where it is
    not known, to the mean of the others of the s-th contact, or 2.
    """
    share = pressures / np.maximum(pressures.max(axis=0), 1e-300)
    # By how much it is steeper between the inner two nodes, to either power.
    single, square = (np.subtract(*np.diff(share**power, axis=0) * np.diff(x, axis=0)[::-1]) for power in (1, 2))
    between = (single < 0.0) & (square > 0.0)
    power = 1.0 + np.where(between, single / np.where(between, single - square, 1.0), single < 0.0)
    count = known.sum(axis=(0, 2))
    mean = np.where(count, (power * known).sum(axis=(0, 2)) / np.maximum(count, 1), 2.0)
    return np.asarray(share ** np.where(known, power, mean[:, None]))


def _area(lines: Array, chord: Array) -> float:
    """Area under chords (m,) at places `lines` (m,), whose squares are linear between them and fall on beyond the last
    ones, at most to the next line.
    """
    sections = 2.0 / 3.0 * (chord[1:] ** 2 + chord[1:] * chord[:-1] + chord[:-1] ** 2)
    sections /= np.maximum(chord[1:] + chord[:-1], 1e-300)
    between = (chord[1:] > 0.0) & (chord[:-1] > 0.0)
    total = float((np.diff(lines) * sections)[between].sum())
    for end in np.flatnonzero(chord):
        for step in (-1, 1):
            out, back = end + step, end - step
            if 0 <= out < len(lines) and not chord[out]:
                far = abs(lines[out] - lines[end])
                inner = chord[back] if 0 <= back < len(lines) else 0.0
                near = 0.5 * far
                if inner > chord[end]:
                    near = min(chord[end] ** 2 * abs(lines[back] - lines[end]) / (inner**2 - chord[end] ** 2), far)
                total += 2.0 / 3.0 * chord[end] * near
    return total
