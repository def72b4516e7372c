"""Where along a cycle the surfaces meet when they wear: places spread evenly over the slip.

Between two places nothing wears, so they must lie closer together than the surfaces' elements. Both strokes share the
surface: where the places of one are moved a quarter of their distance, those of the other, its mirror image, lie half
way between them, and together they are twice as dense.

The bodies slide by what the drive moves and the holder does not. Where the holder stands along a stroke is known from
one before; else it is taken to spring back as far to the other side as it was carried along, and to stand still.
"""

from dataclasses import dataclass

import numpy as np

from geometry.arrays import Array

# Share of the stroke over which the bodies must move against each other for places to be spread over that.
_LEAST_SLIDING_SHARE = 0.25
# Increments from a reversal to the first place, over which the holder springs back and the contact mostly sticks.
_STICK_INCREMENTS = 2
_SHIFT = 0.25
_FOLLOWS = 0.9  # A holder that moves by less than this share of what the drive moves has begun to slide.
# The increment that sticks ends where the bodies have moved against each other by this share of the places' distance,
# for they yield elastically while they stick, and no nearer than that share of its way to either side.
_STUCK_SHARE = 0.04


@dataclass(frozen=True)
class Stroke:
    """Where the holder stood along a stroke from about +amplitude to -amplitude, (m,) each, mm."""

    drive: Array
    holder_x: Array

    @property
    def mirrored(self) -> "Stroke":
        """The stroke back of a symmetric cycle, turned round to run from +amplitude to -amplitude as well."""
        return Stroke(-self.drive, -self.holder_x)


def wear_path(amplitude_mm: float, holder_x_mm: float, increments: int, before: Stroke | None = None) -> Array:
    """Drive at the ends of the increments of half a cycle from +amplitude to -amplitude, shape (increments,).

    holder_x_mm: by how much the contact has carried the holder along at +amplitude.  before: a similar stroke.
    """
    carried = min(max(holder_x_mm, 0.0), amplitude_mm)
    slides = amplitude_mm - carried
    if slides < _LEAST_SLIDING_SHARE * amplitude_mm or increments < 2 * _STICK_INCREMENTS:
        steps = np.cos(np.pi * np.arange(1, increments + 1) / increments)
        steps[-1] = -1.0
        return amplitude_mm * np.asarray(steps)
    count = increments - _STICK_INCREMENTS
    places, stuck = _places(amplitude_mm, carried, count, before)
    between = amplitude_mm - places[0]
    stuck = min(max(stuck, places[0] + _STUCK_SHARE * between), amplitude_mm - _STUCK_SHARE * between)
    return np.concatenate([[stuck], places, [-amplitude_mm]])


def _places(amplitude: float, carried: float, count: int, before: Stroke | None) -> tuple[Array, float]:
    """Places (count,) along the slip, and where the contact still sticks."""
    shares = (np.arange(count) + _SHIFT) / count
    if before is None:
        places = amplitude - 2.0 * carried - 2.0 * (amplitude - carried) * shares
        return places, 0.5 * (amplitude + float(places[0]))
    drive, holder = _with_knee(np.append(amplitude, before.drive), np.append(carried, before.holder_x))
    # Round-off and creep must not let the bodies seem to slide back.
    apart = np.minimum.accumulate(drive - holder)
    start, end = float(apart[0]), float(apart[-1])
    wanted = start - (start - end) * np.append(_STUCK_SHARE / count, shares)
    found = -np.interp(-wanted, -apart, -drive)
    return found[1:], float(found[0])


def _with_knee(drive: Array, holder: Array) -> tuple[Array, Array]:
    """The stroke with the place at which sliding begins, where the holder that follows the drive meets the line on
    which it stands while the bodies slide; increments of the stroke may be long.
    """
    ahead = np.append(True, np.diff(drive) < 0.0)
    drive, holder = drive[ahead], holder[ahead]
    rates = np.diff(holder) / np.diff(drive)
    knee = int(np.argmax(rates < _FOLLOWS))
    if rates[knee] >= _FOLLOWS or knee + 1 == len(rates):
        return drive, holder
    slope = float(np.clip(rates[knee + 1], -0.5, 0.5))
    along = holder[knee + 1] - slope * drive[knee + 1] - holder[knee] + drive[knee]
    place = float(np.clip(along / (1.0 - slope), drive[knee + 1], drive[knee]))
    stands = holder[knee] + place - drive[knee]
    return np.insert(drive, knee + 1, place), np.insert(holder, knee + 1, stands)
