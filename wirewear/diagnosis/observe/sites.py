"""Where numbers are read: the cycle, the branch and the level, or the wire, of each."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from wirewear.diagnosis.model.forward import LoopCourse
from wirewear.diagnosis.model.setup import Array


@dataclass(frozen=True)
class Site:
    """Where one number is read: after which cycle, on which branch and at which level of it, of which wire's scar.

    `branch` is +1, −1, or 0 for the whole loop; `level` is what the observable says (a displacement, a force), 0 where
    it has none; `wire` and `figure` are empty but for scars.
    """

    cycle: int
    branch: int = 0
    level: float = 0.0
    wire: str = ""
    figure: str = ""


@dataclass(frozen=True, eq=False)
class Sites:
    """The same of several numbers, (n,) each."""

    cycle: NDArray[np.int64]
    branch: NDArray[np.int64]
    level: Array
    wire: NDArray[np.str_]
    figure: NDArray[np.str_]

    @classmethod
    def of(cls, sites: Sequence[Site]) -> Sites:
        """From one object a number."""
        return cls(
            np.array([site.cycle for site in sites], dtype=np.int64),
            np.array([site.branch for site in sites], dtype=np.int64),
            np.array([site.level for site in sites], dtype=float),
            np.array([site.wire for site in sites], dtype=np.str_),
            np.array([site.figure for site in sites], dtype=np.str_),
        )

    def __len__(self) -> int:
        return self.cycle.size

    def __iter__(self) -> Iterator[Site]:
        columns = (self.cycle, self.branch, self.level, self.wire, self.figure)
        for cycle, branch, level, wire, figure in zip(*(column.tolist() for column in columns), strict=True):
            yield Site(cycle, branch, level, wire, figure)

    def taken(self, keep: NDArray[np.bool_]) -> Sites:
        """Part of them."""
        return Sites(self.cycle[keep], self.branch[keep], self.level[keep], self.wire[keep], self.figure[keep])

    @cached_property
    def branches(self) -> list[tuple[int, int, NDArray[np.intp]]]:
        """Cycle, sign and places of the numbers that lie on one branch of one cycle together."""
        pairs = sorted({(int(cycle), int(sign)) for cycle, sign in zip(self.cycle, self.branch, strict=True)})
        return [(*pair, np.flatnonzero((self.cycle == pair[0]) & (self.branch == pair[1]))) for pair in pairs]


def rows_of(course: LoopCourse, sites: Sites) -> NDArray[np.intp]:
    """Row (n,) of a course in which each site's cycle stands."""
    return np.searchsorted(course.cycles, sites.cycle)
