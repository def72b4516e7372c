"""What a check says of a record, and what the single checks look at."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np

from geometry.arrays import BoolArray
from wirewear.base.errors import counted
from wirewear.loops import LoopFigures
from wirewear.records.loop_statistics import LoopStatistics
from wirewear.records.values import AnyRecord

MOST_LISTED = 8

ALIKE = 0.01  #: Conditions are rounded to this share of themselves, and alike within it.


def plural(count: int, noun: str) -> str:
    """``1 loop``, ``3 loops``."""
    return f"{counted(count)} {noun}{'' if count == 1 else 's'}"


def listed(values: Sequence[int]) -> str:
    """``1, 2, 3 and 12 more``."""
    shown = ", ".join(counted(value) for value in values[:MOST_LISTED])
    more = len(values) - MOST_LISTED
    return f"{shown} and {more} more" if more > 0 else shown


def unlike_conditions(
    pairs: Mapping[str, tuple[float | None, float | None]], cycles: tuple[float, float]
) -> str | None:
    """A sentence on the conditions in which a run and a record differ, by key; None where they are of one test.

    pairs: of the run and of the record, None where it says nothing.  cycles: a run may be the longer one.
    """
    differ = [
        f"{key} is {own:.4g} in the run and {other:.4g} in the record"
        for key, (own, other) in pairs.items()
        if own is not None and other is not None and abs(own - other) > ALIKE * max(abs(own), abs(other))
    ]
    if cycles[0] < cycles[1]:
        differ.append(f"the run ends after {cycles[0]:.9g} cycles and the record after {cycles[1]:.9g}")
    return f"The run and the record are not of the same test: {', '.join(differ)}." if differ else None


@dataclass(frozen=True)
class Remark:
    """Something found: a `problem` spoils what depends on it, a `note` should be known.

    refuses: nothing should be concluded from the record before this is cleared up.
    """

    level: Literal["problem", "note"]
    topic: str
    text: str
    refuses: bool = False


@dataclass(frozen=True)
class RecordReport:
    """The outcome of a check: remarks, what the record supports and what it does not."""

    name: str
    repeats: tuple[int, ...]
    cycles: tuple[int, ...]
    loops: int
    samples: int
    remarks: tuple[Remark, ...]
    supports: tuple[str, ...]
    cannot: tuple[str, ...]
    metadata: tuple[str, ...] = ()

    @property
    def problems(self) -> tuple[Remark, ...]:
        """The remarks that spoil something."""
        return tuple(remark for remark in self.remarks if remark.level == "problem")

    def to_json(self) -> dict[str, Any]:
        """The report as plain values."""
        return asdict(self)


@dataclass(frozen=True, eq=False)
class CheckedRecord:
    """A record, statistics of all its loops, and of those that are analysed in full the figures or why not.

    Loops of figures and refusals are named (repeat, cycle).
    """

    record: AnyRecord
    statistics: LoopStatistics
    figures: dict[tuple[int, int], LoopFigures]
    refused: dict[tuple[int, int], str]


def where(checked: CheckedRecord, wrong: BoolArray) -> str:
    """Which loops: "3 of 21 loops (first: repeat 1, cycle 100)"."""
    first = int(np.argmax(wrong))
    s = checked.statistics
    return (
        f"{int(np.count_nonzero(wrong))} of {plural(wrong.size, 'loop')} "
        f"(first: repeat {s.repeat[first]}, cycle {s.cycle[first]})"
    )
