"""What distortions are shares of: powers of a reading over its scale, and places along the stroke.

A share of branches (n, 2, m) is in the direction of travel; x/A is the place fixed to the rig, over the amplitude.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from wirewear.diagnosis.infer.shapes import Branches, Shape, loaded, resisting
from wirewear.diagnosis.model.setup import Array

Share = Callable[[Branches], Array]


def odd(u: Array) -> Array:
    """A cubic that is 0 at 1."""
    return np.asarray(u**3 - u)


def odd_fifth(u: Array) -> Array:
    """The next odd one."""
    return np.asarray(u**5 - u**3)


def cubic(u: Array) -> Array:
    """A cubic that bends the ends alone."""
    return np.asarray(u**3)


def even(u: Array) -> Array:
    """A parabola that is 0 at both ends."""
    return np.asarray(u**2 - 1.0)


def even_fourth(u: Array) -> Array:
    """The next even one."""
    return np.asarray(u**4 - u**2)


def direction(b: Branches) -> Array:
    """+1 on the branch towards +x, −1 on the other."""
    return np.broadcast_to(np.array([1.0, -1.0])[None, :, None], b.place.shape)


def bowl(b: Branches) -> Array:
    """More towards both ends of the stroke, none of it in the mean."""
    return np.asarray(b.place**2 - 1.0 / 3.0)


def bowl_fourth(b: Branches) -> Array:
    """The same, nearer to the ends."""
    return np.asarray(b.place**4 - 0.2)


def tilt(b: Branches) -> Array:
    """More towards one end of the rig: x/A."""
    return np.asarray(direction(b) * b.place)


def tilt_third(b: Branches) -> Array:
    """The same, nearer to the ends."""
    return np.asarray(direction(b) * b.place**3)


def uphill(power: int) -> Share:
    """A force that follows the place, against the motion towards either end: an odd power of x/A."""
    return lambda b: np.asarray(b.place**power)


def sided(b: Branches) -> Array:
    """A force that follows the square of the place, so that it is against the motion one way only."""
    return np.asarray(direction(b) * b.place**2)


def later(b: Branches) -> Array:
    """The sine of twice the phase of a harmonic drive: more in the second half of either stroke."""
    return np.asarray(b.place * np.sqrt(np.maximum(1.0 - b.place**2, 0.0)))


def fast(b: Branches) -> Array:
    """The speed of a harmonic drive over its largest, with its sign."""
    return np.asarray(direction(b) * np.sqrt(np.maximum(1.0 - b.place**2, 0.0)))


def behind(b: Branches) -> Array:
    """Behind the motion, most in mid-stroke."""
    return np.asarray(-np.maximum(1.0 - b.place**2, 0.0))


def bump(at: float, width: float) -> Share:
    """At one place of the rig, so wide, whichever way it is passed."""
    return lambda b: np.asarray(np.exp(-(((tilt(b) - at) / width) ** 2)))


def since(length: float) -> Shape:
    """Friction that passes over some way after each reversal."""
    return resisting(lambda b: np.asarray(np.exp(-b.slid / length)))


def turning(length: float) -> Shape:
    """A load that is more one way, and turns over some way after each reversal."""
    return loaded(lambda b: np.asarray(direction(b) * (1.0 - 2.0 * np.exp(-b.slid / length))))
