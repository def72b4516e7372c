"""What is observed of a record: a fixed list of numbers that loops, evolution and scars give, measured or computed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from wirewear.diagnosis.model.forward import SLIDING
from wirewear.diagnosis.model.scar_figures import SCAR_FIGURES
from wirewear.diagnosis.model.wear_states import WIRES
from wirewear.diagnosis.observe.knee import computed_peaks_N

if TYPE_CHECKING:
    from wirewear.diagnosis.model.forward import Course

Array = NDArray[np.float64]

#: Kinds of observables, with the words that reports use and their unit.
KINDS = {
    "stick": ("displacement at equal force", "um"),
    "plateau": ("force at equal displacement", "N"),
    "knee": ("force just past the knee over that beyond", "N"),
    "amplitude": ("displacement amplitude", "um"),
    "normal": ("normal force", "N"),
    "normal_direction": ("normal force, forward less backward", "N"),
    "energy": ("dissipated energy", "mJ"),
    "slip": ("slip amplitude", "um"),
    "force": ("largest tangential force", "N"),
    "scar": ("scar", "relative"),
    "skew": ("skew of the scar", "rad"),
}


@dataclass(frozen=True, eq=False)
class Layout:
    """Observables, one entry each (n,): what they are, of which cycle, on which branch and at which level.

    `branch` is +1, −1, or 0 for the whole loop; `level` is a displacement for "plateau", a force in the branch's
    direction for "stick", none for "knee", the place in `SCAR_FIGURES`, plus 10 for the fixed wire, for "scar", and
    0 or 10 for "skew".
    """

    kind: NDArray[np.str_]
    cycle: NDArray[np.int64]
    branch: NDArray[np.int64]
    level: Array

    @classmethod
    def of_rows(cls, rows: list[tuple[str, int, int, float]]) -> Layout:
        """From one row an observable: kind, cycle, branch, level."""
        kind, cycle, branch, level = zip(*rows, strict=True) if rows else ((), (), (), ())
        return cls(np.array(kind, dtype="U20"), np.array(cycle, dtype=np.int64), np.array(branch, dtype=np.int64),
                   np.array(level, dtype=float))  # fmt: skip

    def __len__(self) -> int:
        return self.kind.size

    @property
    def cycles(self) -> Array:
        """Cycles at which loops are needed, increasing."""
        return np.unique(self.cycle).astype(float)

    @cached_property
    def _along_branches(self) -> list[tuple[str, int, NDArray[np.intp]]]:
        """Kind, sign and places of the observables that lie on one branch of one cycle together."""
        groups = []
        for kind in ("plateau", "stick"):
            for sign in (1, -1):
                here = (self.kind == kind) & (self.branch == sign)
                groups += [
                    (kind, sign, np.flatnonzero(here & (self.cycle == cycle))) for cycle in np.unique(self.cycle[here])
                ]
        return groups

    def taken(self, keep: NDArray[np.bool_]) -> Layout:
        """Part of the observables."""
        return Layout(self.kind[keep], self.cycle[keep], self.branch[keep], self.level[keep])

    def zone(self, reach_um: float) -> NDArray[np.str_]:
        """Zone of each observable: stick, knee, plateau, tip of the loop, or the channel where it has none."""
        zone = self.kind.copy()
        along = self.level * self.branch
        plateau = self.kind == "plateau"
        zone[plateau & (along > 0.8 * reach_um)] = "tip"
        return zone

    def observed(self, course: Course) -> Array:
        """The observables (n,) of a computed course, which must hold all of `cycles`."""
        values = np.full(len(self), np.nan)
        place = np.searchsorted(course.cycles, self.cycle)
        for kind, sign, at in self._along_branches:
            x, q = (
                channel[place[at[0]], (1 - sign) // 2]
                for channel in (course.displacement_um, course.tangential_force_N)
            )
            if kind == "plateau":
                values[at] = np.interp(sign * self.level[at], sign * x, q)
            else:
                # Past a loop's tips, a force crosses no stick branch: the branch ends there.
                values[at] = np.interp(self.level[at], np.maximum.accumulate(sign * q), x)
        at = self.kind == "knee"
        if at.any():
            peaks = computed_peaks_N(course.displacement_um, course.tangential_force_N)
            side = (self.branch[at] < 0).astype(int)
            values[at] = self.branch[at] * peaks[place[at], side]
        self._whole_loops(course, place, values)
        return values

    def _whole_loops(self, course: Course, place: NDArray[np.intp], values: Array) -> None:
        x, q, p = course.displacement_um, course.tangential_force_N, course.normal_force_N
        wanted = set(self.kind.tolist())
        figures: dict[str, Callable[[], Array]] = {
            "amplitude": lambda: 0.5 * (x.max(axis=(1, 2)) - x.min(axis=(1, 2))),
            "normal": lambda: p[:, :, SLIDING:].mean(axis=(1, 2)),
            "normal_direction": lambda: p[:, 0, SLIDING:].mean(axis=1) - p[:, 1, SLIDING:].mean(axis=1),
            "energy": lambda: loop_area(x, q),
            "slip": lambda: half_width(x, q),
            "force": lambda: np.abs(q).max(axis=(1, 2)),
        }
        for kind, compute in figures.items():
            if kind in wanted:
                at = self.kind == kind
                values[at] = compute()[place[at]]
        at = self.kind == "scar"
        code = self.level[at].astype(int)
        values[at] = np.log(np.maximum(course.scars[code // 10, code % 10], 1e-6))
        values[self.kind == "skew"] = course.skew

    def words(self, place: int) -> str:
        """What one observable is, for people."""
        words = KINDS[str(self.kind[place])][0]
        if self.kind[place] == "skew":
            return f"{words} ({WIRES[int(self.level[place]) // 10]} wire)"
        if self.kind[place] == "scar":
            code = int(self.level[place])
            return f"{SCAR_FIGURES[code % 10]} of the {WIRES[code // 10]} wire's scar"
        return words


def loop_area(x: Array, q: Array) -> Array:
    """Area of loops (n, 2, m) in mJ, (n,)."""
    branches = [np.asarray(np.trapezoid(q[:, side], x[:, side], axis=1)) for side in (0, 1)]
    area: Array = 1e-3 * (branches[0] + branches[1])
    return area


def half_width(x: Array, q: Array) -> Array:
    """Half of a loop's width at its mid force, (n,)."""
    middle = 0.5 * (q.max(axis=(1, 2)) + q.min(axis=(1, 2)))
    width = [
        np.interp(-m, np.maximum.accumulate(-qs[1]), xs[1]) - np.interp(m, np.maximum.accumulate(qs[0]), xs[0])
        for xs, qs, m in zip(x, q, middle, strict=True)
    ]
    return 0.5 * np.array(width)
