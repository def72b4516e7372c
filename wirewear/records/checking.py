"""What is wrong with a record, and what it can and cannot support, in plain words."""

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from wirewear.base.errors import RecordError
from wirewear.base.recognised import TABLE_FILE_NAME
from wirewear.loops import LoopError, LoopFigures
from wirewear.records import course_checks, exchanges, loop_checks
from wirewear.records.loop_statistics import loop_statistics
from wirewear.records.profile_checks import profile_remarks
from wirewear.records.remarks import CheckedRecord, RecordReport, Remark
from wirewear.records.scar_checks import scar_remarks
from wirewear.records.support import Support, support
from wirewear.records.surfaces import PROFILES, SCARS
from wirewear.records.values import AnyRecord, MeasuredLoop

#: Loops that are analysed in full; in a larger record the others are checked by their statistics alone.
MOST_ANALYSED = 30


def check_record(record: AnyRecord) -> RecordReport:
    """Check units, times, channels, cycle lists, outliers, repeats, drift, saturation and closure of a record."""
    checked = looked_at(record)
    remarks = [Remark("note", TABLE_FILE_NAME, f"{note}.") for note in record.notes]
    remarks += loop_remarks(checked)
    remarks += _OF_SURFACES[record.tables.worn.name](checked)
    can: Support = support(checked, any(remark.level == "problem" for remark in remarks))
    return RecordReport(
        name=record.name,
        repeats=record.repeats,
        cycles=record.cycles,
        loops=len(record.loops),
        samples=int(checked.statistics.samples.sum()),
        remarks=tuple(remarks),
        supports=can.supports,
        cannot=can.cannot,
        metadata=record.tables.metadata.lines,
    )


def looked_at(record: AnyRecord) -> CheckedRecord:
    """The loops of a record, all by their statistics and some analysed in full."""
    figures: dict[tuple[int, int], LoopFigures] = {}
    refused: dict[tuple[int, int], str] = {}
    for loop in analysed(record.loops):
        try:
            figures[loop.repeat, loop.cycle] = loop.figures(record.tables.conditions.normal_load_N)
        except LoopError as error:
            refused[loop.repeat, loop.cycle] = str(error)
    return CheckedRecord(record, loop_statistics(record.loops), figures, refused)


def loop_remarks(checked: CheckedRecord) -> list[Remark]:
    """What is odd about the loops of a record and their course over the cycles."""
    return [remark for check in _CHECKS for remark in check(checked)] if checked.record.loops else []


def problems_told(record: AnyRecord) -> tuple[str, ...]:
    """The problems of a record from which something is to be concluded all the same, as sentences.

    Raises:
        RecordError: one of them forbids any conclusion.
    """
    return tuple(remark.text for remark in remarks_told(record) if remark.level == "problem")


def remarks_told(record: AnyRecord) -> tuple[Remark, ...]:
    """All that is odd in a record from which something is to be concluded all the same.

    Raises:
        RecordError: something forbids any conclusion.
    """
    report = check_record(record)
    for problem in report.problems:
        if problem.refuses:
            text = problem.text[:1].lower() + problem.text[1:].rstrip(".")
            raise RecordError(
                f"nothing can be concluded from the record {report.name!r}: {text}; `wirewear check` tells all that is "
                "odd in it."
            )
    return report.remarks


def analysed(loops: Sequence[MeasuredLoop]) -> list[MeasuredLoop]:
    """The loops that are analysed in full, evenly chosen."""
    count = len(loops)
    places = sorted(set(np.linspace(0, count - 1, min(count, MOST_ANALYSED)).round().astype(int).tolist()))
    return [loops[place] for place in places]


#: What is checked of maps of scars, and of profiles.
_OF_SURFACES: Mapping[str, Callable[[CheckedRecord], Iterator[Remark]]] = {
    SCARS.name: scar_remarks,
    PROFILES.name: profile_remarks,
}

_CHECKS: Sequence[Callable[[CheckedRecord], Iterator[Remark]]] = (
    loop_checks.too_short,
    loop_checks.times,
    loop_checks.order,
    loop_checks.units,
    loop_checks.folded,
    loop_checks.normal_force,
    course_checks.cycle_lists,
    course_checks.repeats,
    loop_checks.outlying_samples,
    loop_checks.sensors,
    loop_checks.resolution,
    loop_checks.play_and_stick_slip,
    loop_checks.told_by_analysis,
    loop_checks.closure,
    course_checks.drift,
    course_checks.evolution,
    course_checks.impossible_evolution,
    exchanges.renumbered,
    exchanges.exchanged_evolutions,
    exchanges.exchanged_loops,
    exchanges.copied_loops,
    exchanges.copied_evolution,
)
