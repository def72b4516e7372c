"""What a check says of a record, and what the single checks look at."""

from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from wirewear.loops import LoopFigures
from wirewear.records.loop_statistics import LoopStatistics
from wirewear.records.values import ExperimentRecord
from wirewear.records.wording import plural


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

    record: ExperimentRecord
    statistics: LoopStatistics
    figures: dict[tuple[int, int], LoopFigures]
    refused: dict[tuple[int, int], str]


def where(checked: CheckedRecord, wrong: NDArray[np.bool_]) -> str:
    """Which loops: "3 of 21 loops (first: repeat 1, cycle 100)"."""
    first = int(np.argmax(wrong))
    s = checked.statistics
    return (
        f"{int(np.count_nonzero(wrong))} of {plural(wrong.size, 'loop')} "
        f"(first: repeat {s.repeat[first]}, cycle {s.cycle[first]})"
    )
