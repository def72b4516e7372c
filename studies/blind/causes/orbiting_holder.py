from dataclasses import dataclass, replace
from math import hypot

import numpy as np

from studies.blind.causes.cause import Reading, Sizes
from studies.blind.generators.draw import Draw
from studies.blind.generators.signals import Array, Signals, place_in_stroke


@dataclass(frozen=True)
class OrbitingHolder(Reading):
    """The holder is soft across the motion and swings that way, a quarter of a cycle late: the wire goes round.

    Friction points against the slip, µP v/|v|, and turns with it in place of stopping at a reversal. What that changes
    is computed with Coulomb friction behind a spring in the plane (Mróz & Stupkiewicz, Int. J. Solids Struct. 31
    (1994) 2757). The spring is as soft as the loop is: of area 4 F (A − F/K).
    """

    seam = "holder"
    sets = (("reserved", 11),)

    across: float

    @staticmethod
    def size(d: Draw) -> Sizes:
        return {"across": d.between(0.05, 0.3)}

    def read(self, signals: Signals, _cycle: float) -> Signals:
        place, _ = place_in_stroke(signals)
        force = signals.tangential_force_N
        largest = max(0.5 * float(np.ptp(force)), 1e-12)
        # The contact gives way by a thousandth of the stroke at least.
        elastic = max(1.0 - _area(place, force) / (4.0 * largest), 1e-3)
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
            far = max(hypot(first, second), 1.0)
            first, second = first / far, second / far
            found[i] = first
    return found
