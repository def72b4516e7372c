"""What a check says of a record, and what the single checks look at."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from wirewear.loops import LoopFigures
from wirewear.records.loop_statistics import LoopStatistics
from wirewear.records.metadata import Metadata
from wirewear.records.tables import Noise, RecordConditions
from wirewear.records.values import MeasuredEvolution, MeasuredLoop
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


class LoggedTables(Protocol):
    """What the record of any contact states of its loops."""

    @property
    def conditions(self) -> RecordConditions:
        """What was asked of the rig."""

    @property
    def noise(self) -> Noise:
        """Noise of one sample."""

    @property
    def metadata(self) -> Metadata:
        """Where the test comes from."""


class LoggedTest(Protocol):
    """The record of any contact as far as its loops and their course over the cycles go."""

    @property
    def tables(self) -> LoggedTables:
        """What is stated."""

    @property
    def loops(self) -> Sequence[MeasuredLoop]:
        """Its loops, ordered by repeat and cycle."""

    @property
    def evolution(self) -> Sequence[MeasuredEvolution]:
        """Figures over the cycles."""

    @property
    def repeats(self) -> tuple[int, ...]:
        """Numbers of its repeats."""

    @property
    def cycles(self) -> tuple[int, ...]:
        """Cycles of which there are loops."""


@dataclass(frozen=True, eq=False)
class CheckedRecord:
    """A record, statistics of all its loops, and of those that are analysed in full the figures or why not.

    Loops of figures and refusals are named (repeat, cycle). `length_mm` is that of a line contact.
    """

    record: LoggedTest
    statistics: LoopStatistics
    figures: dict[tuple[int, int], LoopFigures]
    refused: dict[tuple[int, int], str]
    length_mm: float | None = None


def where(checked: CheckedRecord, wrong: NDArray[np.bool_]) -> str:
    """Which loops: "3 of 21 loops (first: repeat 1, cycle 100)"."""
    first = int(np.argmax(wrong))
    s = checked.statistics
    return (
        f"{int(np.count_nonzero(wrong))} of {plural(wrong.size, 'loop')} "
        f"(first: repeat {s.repeat[first]}, cycle {s.cycle[first]})"
    )
