"""Holders of the reserved set that give way otherwise than springs do, the same for all forward models.

They are read of loops without them, to first order: the wires wear as if their stroke were whole.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import hypot

import numpy as np

from studies.blind.generators.instruments import Array, Instrument, Signals, place_in_stroke
from studies.blind.generators.strokes import through_holder

LEAST_ELASTIC = 1e-3  #: The contact gives way by this share of the stroke at least.


@dataclass(frozen=True)
class SnappingLeaf:
    """A leaf of the holder was clamped under compression and buckled: it snaps over at some force either way.

    It stands at −g/2 until the force exceeds +F, at +g/2 until it falls below −F, as buckled beams do (Timoshenko &
    Gere, Theory of Elastic Stability, 2nd ed., section 7.10).
    """

    jump_um: float
    force_N: float

    def read(self, signals: Signals, _cycle: float) -> Signals:
        """The forces with shelves where the leaf snaps."""

        def give(_place: Array, force: Array, direction: int) -> Array:
            return np.asarray(0.5 * self.jump_um * np.sign(force - direction * self.force_N))

        return through_holder(signals, give)


@dataclass(frozen=True)
class TelescopingSlide:
    """The holder's slide sticks further out of its guide the further the stroke has come, and gives way more there.

    c Q (1 ± δ/A)/2: nothing at one end of the stroke, c Q at the other; a negative compliance puts it at the low end.
    """

    um_per_N: float

    def read(self, signals: Signals, _cycle: float) -> Signals:
        """The forces, which turn more slowly at one end than at the other."""
        _, half = place_in_stroke(signals)
        middle = float(signals.displacement_um.max()) - half

        def give(displacement: Array, force: Array, _direction: int) -> Array:
            out = 0.5 * (1.0 + np.sign(self.um_per_N) * (displacement - middle) / half)
            return np.asarray(abs(self.um_per_N) * out * force)

        return through_holder(signals, give)


@dataclass(frozen=True)
class OrbitingHolder:
    """The holder is soft across the motion and swings that way, a quarter of a cycle late: the wire goes round.

    Friction points against the slip, µP v/|v|, and turns with it in place of stopping at a reversal. What that changes
    is computed with Coulomb friction behind a spring in the plane (Mróz & Stupkiewicz, Int. J. Solids Struct. 31
    (1994) 2757). The spring is as soft as the loop is: of area 4 F (A − F/K).
    """

    across: float

    def read(self, signals: Signals, _cycle: float) -> Signals:
        """The tangential force along the motion while it turns."""
        place, _ = place_in_stroke(signals)
        force = signals.tangential_force_N
        largest = max(0.5 * float(np.ptp(force)), 1e-12)
        elastic = max(1.0 - _area(place, force) / (4.0 * largest), LEAST_ELASTIC)
        late = np.interp(signals.time_s - 0.25 * signals.period_s, signals.time_s, place, period=signals.period_s)
        turned = _friction_along(place / elastic, self.across * late / elastic)
        straight = _friction_along(place / elastic, np.zeros_like(place))
        return replace(signals, tangential_force_N=np.asarray(force + largest * (turned - straight)))


def _area(place: Array, force: Array) -> float:
    return abs(float(np.sum(0.5 * (force + np.roll(force, -1)) * (np.roll(place, -1) - place))))


def _friction_along(along: Array, across: Array) -> Array:
    """Friction along the motion over the largest (n,), of a periodic path in units of the spring's give."""
    steps = np.stack([np.diff(path, prepend=path[-1]) for path in (along, across)], axis=1).tolist()
    found = np.empty_like(along)
    first = second = 0.0
    for _ in range(2):  # The second cycle repeats itself.
        for i, (forward, aside) in enumerate(steps):
            first, second = first + forward, second + aside
            beyond = max(hypot(first, second), 1.0)
            first, second = first / beyond, second / beyond
            found[i] = first
    return found


#: Those of the reserved set, by name, from their parameters.
HOLDERS: Mapping[str, Callable[[Mapping[str, float]], Instrument]] = {
    "snapping_leaf": lambda p: SnappingLeaf(p["jump_um"], p["force_N"]),
    "telescoping_slide": lambda p: TelescopingSlide(p["um_per_N"]),
    "orbiting_holder": lambda p: OrbitingHolder(p["across"]),
}
