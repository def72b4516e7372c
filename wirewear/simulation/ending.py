"""When a test stops before its last cycle: which figures of the worn contact end it, when, and how they are met."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import log

from solvers import ContactState
from wirewear.base.errors import counted
from wirewear.study.tables import Stop

#: A stop is met within this share, or within a cycle.
_MET = 1e-3
#: The course of a figure is taken from where the test had done its cycles over this, and that before from there.
_BACK = 2.0
_CHANGES = 2.0  # Of the change of the power so far: what it may change by on the way.
_LEAST_SLOPE = 0.02  # Of logarithms: a figure that grows more slowly has no end to foresee.

FIGURES: Mapping[str, Callable[[ContactState], float]] = {
    "depth_um": lambda state: 1e3 * max(float(depth.max()) for depth in state.wear.depths),
    "worn_volume_mm3": lambda state: state.wear.primary_volume_mm3 + state.wear.secondary_volume_mm3,
    "accumulated_energy_J": lambda state: 1e-3 * state.wear.energy_mJ,
    "tangential_force_N": lambda state: abs(float(state.primary_force[:, 0].sum())),
    "clearance_um": lambda state: 1e3 * (state.pressed_z - state.holder_z),
}


@dataclass
class Ending:
    """The stops of a test, and the course of their figures so far as (cycles, figure)."""

    stops: Mapping[str, float]
    course: dict[str, list[tuple[float, float]]] = field(default_factory=dict)

    @classmethod
    def of(cls, stated: Stop | None) -> "Ending":
        """Those that a study states."""
        given = {} if stated is None else {key: getattr(stated, key) for key in FIGURES}
        return cls({key: float(target) for key, target in given.items() if target is not None})

    def reached(self, state: ContactState) -> str | None:
        """The stop that a state is at or beyond, that beyond which it is farthest; None where there is none."""
        shares = {key: FIGURES[key](state) / target for key, target in self.stops.items()}
        passed = {key: share for key, share in shares.items() if share >= 1.0}
        return max(passed, key=lambda key: passed[key], default=None)

    def shorter(self, before: ContactState, after: ContactState, jump: float) -> float | None:
        """The whole cycles after which a jump meets its stop, None where it meets it or passes none."""
        key = self.reached(after)
        if key is None:
            return None
        start, end, target = FIGURES[key](before), FIGURES[key](after), self.stops[key]
        size = float(max(round(jump * (target - start) / (end - start)), 1)) if end > start else jump
        return size if end > (1.0 + _MET) * target and size < jump else None

    def follow(self, state: ContactState, done: float) -> None:
        """Take in the state after so many cycles."""
        for key in self.stops:
            self.course.setdefault(key, []).append((done, FIGURES[key](state)))

    def foreseen(self) -> str:
        """When the first stop will be met, with an interval, as the rest of a sentence; empty if it cannot be said."""
        found = {key: ends for key in self.stops if (ends := self._ends(key)) is not None}
        if not found:
            return ""
        key = min(found, key=lambda one: found[one][0])
        best, low, high = (counted(round(end)) for end in found[key])
        return f"; {key} = {self.stops[key]:g} is expected after {best} cycles ({low} to {high})"

    def _ends(self, key: str) -> tuple[float, float, float] | None:
        """Cycles at which a figure meets its stop if it goes on by its latest power of the cycles, and the ends of an
        interval: by the power before that one, and by one that has changed on the way as those did and more.
        """
        course = [(done, figure) for done, figure in self.course.get(key, ()) if done >= 1.0 and figure > 0.0]
        if not course:
            return None
        done, figure = course[-1]
        earlier = [next((at for at in reversed(course) if at[0] <= done / _BACK**k), None) for k in (1, 2)]
        if earlier[0] is None or earlier[1] is None:
            return None
        late, early = _slope(earlier[0], course[-1]), _slope(earlier[1], earlier[0])
        slopes = [late, early, late + _CHANGES * (late - early)]
        if min(slopes) < _LEAST_SLOPE:
            return None
        best, *others = (done * (self.stops[key] / figure) ** (1.0 / slope) for slope in slopes)
        return best, min(best, *others), max(best, *others)


def _slope(before: tuple[float, float], after: tuple[float, float]) -> float:
    return log(after[1] / before[1]) / log(after[0] / before[0])
