"""Where a contact ends between nodes, and the area within.

Next to the edge a power of the pressure falls as the square of the distance from the middle: its square on every line
through Hertz's ellipse, itself on springs, and on thin soft layers one in between, as three nodes show. It is
followed from the outermost pressed nodes of a line to where it vanishes, but at most to the next node; where it does
not fall, the contact ends midway. Holes are as wide as their nodes.
"""

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
    def _extent(self) -> tuple[float, Array]:
        return extent(self.patch, self.pressure)

    @property
    def area(self) -> float:
        """Area of contact in the plane, mm²."""
        return self._extent[0]

    @property
    def half_widths(self) -> Array:
        """(2,) halves of its extent along x and y of the world, mm."""
        edge = self._extent[1]
        return np.asarray(0.5 * np.ptp(edge @ self.world_to_patch, axis=0)) if len(edge) else np.zeros(2)


def extent(patch: ContactPatch, pressure: Array) -> tuple[float, Array]:
    """Area of contact in mm², and places (k, 2) of its edge along the patch's lines, from pressures (n,) at the nodes
    of the patch that are 0 where it does not touch; of a line contact the area is that of one millimetre.
    """
    table = pressure.reshape(patch.shape)
    if not table.any():
        return 0.0, np.zeros((0, 2))
    along, across = patch.axial_mm, patch.transverse_mm
    low, high, chord = _chords(along, table)
    at = np.flatnonzero(chord)
    edges = [np.column_stack([own, across[at]]) for own in (low[at], high[at])]
    if len(across) == 1:
        return float(chord[0]), np.concatenate(edges)
    low, high, own = _chords(across, table.T)
    other = np.flatnonzero(own)
    edges += [np.column_stack([along[other], ends]) for ends in (low[other], high[other])]
    return 0.5 * (_area(across, chord) + _area(along, own)), np.concatenate(edges)


def _chords(lines: Array, pressure: Array) -> tuple[Array, Array, Array]:
    """Both ends and the pressed length (m,) of each column of pressures (n, m) at places `lines` (n,); 0 for none."""
    pressed = pressure > 0.0
    some = pressed.any(axis=0)
    first, last = pressed.argmax(axis=0), len(lines) - 1 - pressed[::-1].argmax(axis=0)
    middle = 0.5 * (lines[first] + lines[last])
    low, high = _ends(lines, pressure, middle, np.stack([first, last]))
    rows = np.arange(len(lines))[:, None]
    holes = ~pressed & (rows > first) & (rows < last)
    bare = np.gradient(lines) @ holes if holes.any() else 0.0
    return low * some, high * some, np.where(some, high - low - bare, 0.0)


def _ends(lines: Array, pressure: Array, middle: Array, node: IntArray) -> Array:
    """Where columns of pressures (n, m) end below and above (2, m), beyond their outermost pressed `node` (2, m)."""
    step, most = np.array([[-1], [1]]), len(lines) - 1
    inside = np.clip(node - step * np.arange(_NODES)[:, None, None], 0, most)
    offsets, pressures = lines[inside] - middle, pressure[inside, np.arange(pressure.shape[1])]
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
    """Pressures (3, 2, m) over their largest, to the power of 1 to 2 that is most nearly linear in x; where it is not
    known, to the mean of the others, or 2.
    """
    share = pressures / np.maximum(pressures.max(axis=0), 1e-300)
    # By how much it is steeper between the inner two nodes, to either power.
    single, square = (np.subtract(*np.diff(share**power, axis=0) * np.diff(x, axis=0)[::-1]) for power in (1, 2))
    between = (single < 0.0) & (square > 0.0)
    power = 1.0 + np.where(between, single / np.where(between, single - square, 1.0), single < 0.0)
    return np.asarray(share ** np.where(known, power, power[known].mean() if known.any() else 2.0))


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
