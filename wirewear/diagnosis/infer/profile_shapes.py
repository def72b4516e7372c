"""Shapes of distortions of worn profiles: depths that differ by a share of the largest."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from wirewear.diagnosis.infer.shapes import Branches, Shape
from wirewear.diagnosis.model.forward import LoopCourse
from wirewear.diagnosis.model.line_wear import EDGE
from wirewear.diagnosis.model.setup import Array

MIDDLE_AND_FLANKS = "wear that differs between the middle of the scar and its flanks"


def worn(share: Callable[[Array], Array]) -> Shape:
    """Bodies that wear by a share f(x/w) of the largest depth more, w the scar's half-width."""

    def shape(b: Branches, size: float) -> LoopCourse:
        changed = {
            body: (x, depth + size * float(depth.max()) * share(x / half_width(x, depth)))
            for body, (x, depth) in b.course.profiles.items()
        }
        return replace(b.course, profiles=changed)

    return shape


def middle(width: float) -> Callable[[Array], Array]:
    """A bump in the middle, so wide."""
    return lambda u: np.asarray(np.exp(-((u / width) ** 2)))


def aside(u: Array) -> Array:
    """More on one side than on the other, nothing beyond the scar."""
    return np.asarray(u * np.maximum(1.0 - u**2, 0.0))


def aside_third(u: Array) -> Array:
    """The same, towards the edges."""
    return np.asarray(u**3 * np.maximum(1.0 - u**2, 0.0))


def widened(b: Branches, size: float) -> LoopCourse:
    """Scars that are wider by a share, of the same area."""
    changed = {
        body: (x, np.interp(x / (1.0 + size), x, depth) / (1.0 + size))
        for body, (x, depth) in b.course.profiles.items()
    }
    return replace(b.course, profiles=changed)


def half_width(x_um: Array, depth_um: Array) -> float:
    """Of a profile about zero."""
    over = np.flatnonzero(depth_um > EDGE * depth_um.max(initial=0.0))
    return max(float(np.abs(x_um[over]).max(initial=0.0)), 1e-6)
