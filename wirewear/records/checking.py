"""Check of a record: its problems, and which conclusions it supports, as a report for a terminal."""

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np
from rich.console import Group
from rich.padding import Padding
from rich.text import Text

from wirewear.base.errors import RecordError
from wirewear.base.files import TABLE_FILE_NAME
from wirewear.base.words import counted
from wirewear.loops import LoopError, LoopFigures
from wirewear.loops.figures import regime_of
from wirewear.records import evolution_checks, loop_checks, swap_checks
from wirewear.records.remarks import CheckedRecord, RecordReport, Remark, listed, loop_statistics, plural
from wirewear.records.surface_checks import profile_remarks, scar_remarks
from wirewear.records.surfaces import NO_SURFACES, PROFILES, SCARS
from wirewear.records.values import AnyRecord, MeasuredLoop
from wirewear.results.scar import called

RESOLVED = 4  #: Samples on half of a micro-slip branch from which on its stiffness is well resolved.


#: Whether something can be concluded from a record, and a sentence about what.
Verdict = tuple[bool, str]


#: Loops that are analysed in full; in a larger record the others are checked by their statistics alone.
MOST_ANALYSED = 30

#: What is checked of maps of scars, and of profiles.
_OF_SURFACES: Mapping[str, Callable[[CheckedRecord], Iterator[Remark]]] = {
    SCARS.name: scar_remarks,
    PROFILES.name: profile_remarks,
    NO_SURFACES.name: lambda _: iter(()),
}
_CHECKS: Sequence[Callable[[CheckedRecord], Iterator[Remark]]] = (
    loop_checks.too_short,
    loop_checks.times,
    loop_checks.order,
    loop_checks.units,
    loop_checks.folded,
    loop_checks.normal_force,
    evolution_checks.cycle_lists,
    evolution_checks.repeats,
    loop_checks.outlying_samples,
    loop_checks.sensors,
    loop_checks.resolution,
    loop_checks.play_and_stick_slip,
    loop_checks.notes_of_analysis,
    loop_checks.closure,
    evolution_checks.drift,
    evolution_checks.evolution,
    evolution_checks.impossible_evolution,
    swap_checks.renumbered,
    swap_checks.exchanged_evolutions,
    swap_checks.exchanged_loops,
    swap_checks.copied_loops,
    swap_checks.copied_evolution,
)


def support(checked: CheckedRecord, spoilt: bool) -> Iterator[Verdict]:
    """Verdicts on possible conclusions from a record: whether it supports each, and a sentence. spoilt: True if the
    record has problems, which adds a restriction.
    """
    record = checked.record
    yield from _loops(checked)
    yield from _repeats(record)
    if any(loop.normal_force_N is not None for loop in record.loops):
        yield True, "Telling a wrong or drifting normal load from a change of friction."
    else:
        yield (
            False,
            (
                "Telling a wrong or drifting normal load from a change of friction: the normal force was not "
                "measured. A load cell under the body at rest measures it."
            ),
        )
    yield from _wear(record)
    yield _model(record)
    if spoilt:
        yield False, "Conclusions that rest on what the problems above concern, until these are cleared up."


def _loops(checked: CheckedRecord) -> Iterator[Verdict]:
    figures = tuple(checked.figures.values())
    if not figures:
        yield False, "Anything about loops: none of those looked at can be analysed."
        return
    which = "the logged cycles"
    cycles = sorted({loop.cycle for loop in checked.record.loops})
    if checked.refused:
        # Where some are refused, what was not looked at supports nothing.
        looked = len(figures) + len(checked.refused)
        among = "" if looked == len(checked.record.loops) else " looked at"
        which = f"{len(figures)} of {plural(looked, 'logged loop')}{among}"
        cycles = sorted({cycle for _, cycle in checked.figures})
    yield True, f"Slip amplitude, dissipated energy and friction of {which}."
    if len(cycles) > 1:
        span = f"{plural(len(cycles), 'cycle')} from {counted(cycles[0])} to {counted(cycles[-1])}"
        yield True, f"How loops change with the cycles ({span})."
    else:
        yield (
            False,
            (
                "How anything changes with the cycles: there are loops of one only; roughness, wear and drift look "
                "alike. Log loops at 1, 10, 100, ... and the last cycle."
            ),
        )
    branches = [branch for item in figures for branch in item.branches]
    few = sum(len(branch.samples) < RESOLVED for branch in branches)
    yield from _partial_slip(figures)
    if few > len(branches) // 2:
        yield (
            False,
            (
                "The stiffness just after a reversal: most branches have fewer than four samples there, so that free"
                " play and compliance may look alike. Sample faster, or press on the holder with a dial gauge at it."
            ),
        )
    elif 2 * sum(item.measured_stiffness_N_per_um is None for item in figures) > len(figures):
        yield False, "The tangential stiffness: behind reversals, most loops show no line."
    else:
        yield True, "The measured tangential stiffness, rig and contact together."


def _partial_slip(figures: Sequence[LoopFigures]) -> Iterator[Verdict]:
    """Verdict on the friction of loops in partial slip: known within an interval, or bounded from below only."""
    sticking = [item for item in figures if item.regime == "partial slip"]
    if not sticking:
        return
    if regime_of(figures) == "mixed":
        yield True, f"That the test is mixed: {len(sticking)} of {plural(len(figures), 'loop')} in partial slip."
    intervals = [one.interval95 for item in sticking if (one := item.friction_partial_slip) is not None]
    bounded = [one for one in intervals if np.isfinite(one[1])]
    if bounded:
        low, high = min(bounded, key=lambda one: one[1] / max(one[0], 1e-300))
        between = f"energy, stiffness and shape of one loop leave {low:.2g} to {high:.2g}, those of the others more"
        yield True, f"The coefficient of friction in partial slip, within bounds: {between}."
    else:
        yield (
            False,
            (
                "The coefficient of friction in partial slip: the largest force over load is a lower bound, and nothing"
                " bounds it above. A longer stroke, or a displacement sensor nearer to the contact, would."
            ),
        )


def _repeats(record: AnyRecord) -> Iterator[Verdict]:
    count = len(record.repeats)
    if count == 1:
        yield (
            False,
            (
                "Whether a difference means anything: with one repeat, the scatter between tests is unknown, and the"
                " sensors' noise is only a lower bound. Repeat the test with fresh specimens, or state what is known"
                " in [scatter]."
            ),
        )
        return
    # 95 % interval of a standard deviation from n samples: s·sqrt((n-1)/χ²).
    factors = {2: "0.45 to 32", 3: "0.52 to 6.3", 4: "0.57 to 3.7", 5: "0.60 to 2.9"}
    known = f"; its standard deviation is known within factors of {factors[count]} only" if count in factors else ""
    yield True, f"Scatter between tests, from {plural(count, 'repeat')}{known}."


def _wear(record: AnyRecord) -> Iterator[Verdict]:
    worn = record.tables.worn
    present = [body for body in record.tables.body_names if record.scars_of(body)]
    absent = [body for body in record.tables.body_names if body not in present]
    if len(present) >= worn.fewest:
        yield True, worn.support.format(" and ".join(present))
    if absent:
        yield False, worn.lacking.format(" and the ".join(map(called, absent)))
    if record.evolution:
        yield True, "The course of amplitudes, force and energy between the logged loops."
    else:
        yield (
            False,
            (
                "The course of amplitudes, force and energy between the logged loops: there is no evolution. Many "
                "loggers write such figures for every cycle ([evolution] of a mapping)."
            ),
        )


def _model(record: AnyRecord) -> Verdict:
    if absent := record.tables.missing:
        return False, (
            f"{record.tables.predicted} from the record alone: [stated] does not give {' and '.join(absent)}. "
            "`wirewear fit RECORD` finds friction and rig stiffness from the loops, and the wear coefficient from "
            "scars and energy."
        )
    taken = f"with all that is not stated taken as ideal{record.tables.assumed}"
    return True, f"{record.tables.predicted} from the record alone, {taken}."


def check_record(record: AnyRecord) -> RecordReport:
    """Report on units, times, channels, cycle lists, outliers, repeats, drift, saturation and closure of a record, and
    on the conclusions that it supports; of a programme, for the block with the longest stroke.
    """
    record = record.of_block()
    checked = looked_at(record)
    remarks = [Remark("note", TABLE_FILE_NAME, f"{note}.") for note in record.notes]
    remarks += [remark for check in _CHECKS for remark in check(checked)] if checked.record.loops else []
    remarks += _OF_SURFACES[record.tables.worn.name](checked)
    verdicts = list(support(checked, any(remark.level == "problem" for remark in remarks)))
    return RecordReport(
        name=record.name,
        repeats=record.repeats,
        cycles=record.cycles,
        loops=len(record.loops),
        samples=int(checked.statistics.samples.sum()),
        remarks=tuple(remarks),
        supports=tuple(text for yes, text in verdicts if yes),
        cannot=tuple(text for yes, text in verdicts if not yes),
        metadata=record.tables.metadata.lines,
    )


def looked_at(record: AnyRecord) -> CheckedRecord:
    """The record with statistics of all its loops, and figures of at most MOST_ANALYSED of them, or why one has
    none.
    """
    figures: dict[tuple[int, int], LoopFigures] = {}
    refused: dict[tuple[int, int], str] = {}
    for loop in analysed(record.loops):
        try:
            figures[loop.repeat, loop.cycle] = loop.figures(record.tables.conditions.normal_load_N)
        except LoopError as error:
            refused[loop.repeat, loop.cycle] = str(error)
    return CheckedRecord(record, loop_statistics(record.loops), figures, refused)


def problems_of(record: AnyRecord) -> tuple[str, ...]:
    """Problems of a record, a sentence for each. Raises RecordError if one of them forbids any conclusion."""
    return tuple(remark.text for remark in remarks_of(record) if remark.level == "problem")


def remarks_of(record: AnyRecord) -> tuple[Remark, ...]:
    """Problems and notes of a record. Raises RecordError if a problem forbids any conclusion."""
    report = check_record(record)
    for problem in report.problems:
        if problem.refuses:
            text = problem.text[:1].lower() + problem.text[1:].rstrip(".")
            raise RecordError(
                f"nothing can be concluded from the record {report.name!r}: {text}; `wirewear check` shows all that is "
                "odd in it."
            )
    return report.remarks


def analysed(loops: Sequence[MeasuredLoop]) -> list[MeasuredLoop]:
    """At most MOST_ANALYSED of these loops, evenly chosen, first and last included."""
    count = len(loops)
    places = sorted(set(np.linspace(0, count - 1, min(count, MOST_ANALYSED)).round().astype(int).tolist()))
    return [loops[place] for place in places]


def report_text(report: RecordReport) -> Group:
    """Report of a check, to be printed with rich."""
    lines: list[Text | Padding] = [
        Text(report.name, style="bold"),
        Text(
            f"{plural(len(report.repeats), 'repeat')}, {plural(report.loops, 'loop')} of "
            f"{plural(report.samples, 'sample')} in all, cycles {listed(report.cycles)}"
        ),
    ]
    if report.metadata:
        lines += _list("Of the test", report.metadata, "default")
    for level, heading, colour in (("problem", "Problems", "red"), ("note", "To be known", "yellow")):
        own = [remark for remark in report.remarks if remark.level == level]
        if own:
            lines += _list(heading, [f"{remark.topic}: {remark.text}" for remark in own], colour)
    if not report.remarks:
        lines.append(Text("Nothing odd was found.", style="green"))
    lines += _list("The record supports", report.supports, "green")
    if report.cannot:
        lines += _list("It cannot support", report.cannot, "yellow")
    return Group(*lines)


def _list(heading: str, sentences: tuple[str, ...] | list[str], colour: str) -> list[Text | Padding]:
    items = [Padding(Text(f"– {sentence}"), (0, 0, 0, 2)) for sentence in sentences]
    return [Text(heading, style=colour), *items]
