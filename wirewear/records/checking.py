"""What is wrong with a record, and what it can and cannot support, in plain words."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from wirewear.errors import RecordError
from wirewear.loops import LoopError, LoopFigures
from wirewear.records.loop_statistics import FEWEST_SAMPLES, LoopStatistics, loop_statistics
from wirewear.records.scar_checks import scar_findings
from wirewear.records.support import Support, support
from wirewear.records.values import ExperimentRecord
from wirewear.records.wording import listed, plural

#: Loops that are analysed in full; in a larger record the others are checked by their statistics alone.
MOST_ANALYSED = 30

#: What counts as notable: relative deviations of amplitude, load and period, drifts over the test, a gap in a loop.
ODD_AMPLITUDE, ODD_LOAD, ODD_PERIOD = 0.1, 0.1, 0.05
DRIFT, OFFSET_DRIFT = 0.05, 0.05
#: Noise, as a share of the amplitude, that curvature between samples resembles.
ROUND_OFF = 1e-4

OPEN, OUTLIER_SHARE = 0.02, 0.01
ODD_REPEAT, ODD_ENERGY = 0.25, 0.1

#: An amplitude off by this factor is in another unit; a loop's area against the motion, of the rectangle around it, is
#: one of a wrong sign and not of noise.
OTHER_UNIT, AGAINST_MOTION = 5.0, 0.05


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

    @property
    def problems(self) -> tuple[Remark, ...]:
        """The remarks that spoil something."""
        return tuple(remark for remark in self.remarks if remark.level == "problem")

    def to_json(self) -> dict[str, Any]:
        """The report as plain values."""
        return asdict(self)


@dataclass(frozen=True, eq=False)
class _Checked:
    record: ExperimentRecord
    statistics: LoopStatistics
    figures: dict[tuple[int, int], LoopFigures]
    refused: dict[tuple[int, int], str]


def check_record(record: ExperimentRecord) -> RecordReport:
    """Check units, times, channels, cycle lists, outliers, repeats, drift, saturation and closure of a record."""
    figures: dict[tuple[int, int], LoopFigures] = {}
    refused: dict[tuple[int, int], str] = {}
    for place in _chosen(len(record.loops)):
        loop = record.loops[place]
        try:
            figures[loop.repeat, loop.cycle] = loop.figures(record.tables.conditions.normal_load_N)
        except LoopError as error:
            refused[loop.repeat, loop.cycle] = str(error)
    checked = _Checked(record, loop_statistics(record), figures, refused)
    remarks = [Remark("note", "unknown keys", f"{note}.") for note in record.notes]
    for check in _CHECKS:
        remarks += check(checked)
    remarks += [Remark(found.level, "scars", found.text, found.refuses) for found in scar_findings(record)]
    can: Support = support(record, tuple(figures.values()), any(remark.level == "problem" for remark in remarks))
    return RecordReport(
        name=record.name,
        repeats=record.repeats,
        cycles=record.cycles,
        loops=len(record.loops),
        samples=int(checked.statistics.samples.sum()),
        remarks=tuple(remarks),
        supports=can.supports,
        cannot=can.cannot,
    )


def problems_told(record: ExperimentRecord) -> tuple[str, ...]:
    """The problems of a record from which something is to be concluded all the same, as sentences.

    Raises:
        RecordError: one of them forbids any conclusion.
    """
    problems = check_record(record).problems
    for problem in problems:
        if problem.refuses:
            text = problem.text[:1].lower() + problem.text[1:].rstrip(".")
            raise RecordError(
                f"nothing can be concluded from the record {record.name!r}: {text}; `wirewear check` tells all that is "
                "odd in it."
            )
    return tuple(problem.text for problem in problems)


def _chosen(count: int) -> list[int]:
    return sorted(set(np.linspace(0, count - 1, min(count, MOST_ANALYSED)).round().astype(int).tolist()))


def _where(checked: _Checked, wrong: NDArray[np.bool_]) -> str:
    """Which loops: "3 of 21 loops (first: repeat 1, cycle 100)"."""
    first = int(np.argmax(wrong))
    s = checked.statistics
    return (
        f"{int(np.count_nonzero(wrong))} of {plural(wrong.size, 'loop')} "
        f"(first: repeat {s.repeat[first]}, cycle {s.cycle[first]})"
    )


def _too_short(checked: _Checked) -> Iterator[Remark]:
    short = checked.statistics.samples < FEWEST_SAMPLES
    if short.any():
        yield Remark("problem", "samples", f"Fewer than {FEWEST_SAMPLES} complete samples in {_where(checked, short)}.")
    missing = checked.statistics.missing
    if missing.any():
        text = f"{plural(int(missing.sum()), 'sample')} missing a channel left out, in {_where(checked, missing > 0)}."
        yield Remark("note", "missing samples", text)


def _times(checked: _Checked) -> Iterator[Remark]:
    s = checked.statistics
    disordered = s.time_errors > 0.0
    if disordered.any():
        yield Remark("problem", "time", f"Time does not increase throughout {_where(checked, disordered)}.")
    period = 1.0 / checked.record.tables.conditions.frequency_Hz
    odd = np.abs(s.period_s / period - 1.0) > ODD_PERIOD
    if odd.any():
        ratio = float(np.nanmedian(s.period_s[odd])) / period
        unit = "; it looks like milliseconds" if 500.0 < ratio < 2000.0 else ""
        text = f"A cycle should last {period:.4g} s, but lasts {ratio:.3g} times that in {_where(checked, odd)}{unit}."
        yield Remark("problem", "time", text)


def _units(checked: _Checked) -> Iterator[Remark]:
    s, conditions = checked.statistics, checked.record.tables.conditions
    ratio = s.displacement_amplitude_um / conditions.displacement_amplitude_um
    odd = np.abs(ratio - 1.0) > ODD_AMPLITUDE
    if odd.any():
        middle = float(np.nanmedian(ratio[odd]))
        unit = {-3: ": it looks like millimetres", 3: ": it looks like nanometres"}.get(_decade(middle), "")
        asked = f"the {conditions.displacement_amplitude_um:g} µm asked for"
        text = f"The displacement amplitude is {middle:.3g} times {asked} in {_where(checked, odd)}{unit}."
        strange = float(np.nanmedian(np.abs(np.log(np.maximum(ratio, 1e-12))))) > np.log(OTHER_UNIT)
        yield Remark("problem", "displacement", text, refuses=strange)
    friction = s.force_amplitude_N / conditions.normal_load_N
    odd = (friction > 3.0) | (friction < 0.005)
    if odd.any():
        text = (
            f"The tangential force is {float(np.nanmedian(friction[odd])):.3g} times the normal load in "
            f"{_where(checked, odd)}, which no dry friction gives: check its unit."
        )
        yield Remark("problem", "tangential force", text, refuses=_most(odd))
    turned = s.energy_mJ < 0.0
    if turned.any():
        text = f"The tangential force drives the motion, as if its sign were wrong, in {_where(checked, turned)}."
        # Around a loop without slip, noise makes small areas of either sign.
        opened = s.energy_mJ / (4e-3 * s.displacement_amplitude_um * s.force_amplitude_N)
        yield Remark("problem", "tangential force", text, refuses=_most(opened < -AGAINST_MOTION))


def _most(loops: NDArray[np.bool_]) -> bool:
    return 2 * int(np.count_nonzero(loops)) > loops.size


def _decade(ratio: float) -> int:
    return round(float(np.log10(ratio))) if ratio > 0.0 else 0


def _normal_force(checked: _Checked) -> Iterator[Remark]:
    s, load = checked.statistics, checked.record.tables.conditions.normal_load_N
    absent = np.isnan(s.normal_force_N) & (s.samples >= FEWEST_SAMPLES)
    if absent.all():
        yield Remark("note", "normal force", "No normal force was measured; the load asked for stands in for it.")
        return
    if absent.any():
        yield Remark("note", "normal force", f"No normal force was measured in {_where(checked, absent)}.")
    odd = np.abs(s.normal_force_N / load - 1.0) > ODD_LOAD
    if odd.any():
        ratio = float(np.nanmedian(s.normal_force_N[odd])) / load
        yield Remark(
            "note",
            "normal force",
            f"The normal force is {ratio:.3g} times the {load:g} N asked for in {_where(checked, odd)}.",
        )


def _cycle_lists(checked: _Checked) -> Iterator[Remark]:
    record = checked.record
    lists = {repeat: {loop.cycle for loop in record.loops if loop.repeat == repeat} for repeat in record.repeats}
    everywhere = set.intersection(*lists.values())
    if partial := sorted(set(record.cycles) - everywhere):
        text = (
            f"Not all repeats have loops of the cycles {listed(partial)}; {len(everywhere)} cycles are common to all."
        )
        yield Remark("note", "cycle lists", text)
    beyond = [cycle for cycle in record.cycles if cycle > record.tables.conditions.cycles]
    if beyond:
        last = record.tables.conditions.cycles
        yield Remark(
            "problem", "cycle lists", f"Loops of the cycles {listed(beyond)} lie beyond the test's end, {last}."
        )


def _outlying_samples(checked: _Checked) -> Iterator[Remark]:
    s = checked.statistics
    count, all_samples = float(np.nansum(s.outliers)), max(int(s.samples.sum()), 1)
    if count:
        share = count / all_samples
        level: Literal["problem", "note"] = "problem" if share > OUTLIER_SHARE else "note"
        text = f"{plural(int(count), 'outlying sample')} ({100.0 * share:.2g} %) in {_where(checked, s.outliers > 0)}."
        yield Remark(level, "outliers", text)


def _sensors(checked: _Checked) -> Iterator[Remark]:
    s, noise = checked.statistics, checked.record.tables.noise
    for name, saturated in (("displacement", s.displacement_saturated), ("tangential force", s.force_saturated)):
        if (saturated > 0.0).any():
            text = (
                f"The {name} stays at its extreme, as a sensor at its stop does, in {_where(checked, saturated > 0.0)}."
            )
            yield Remark("problem", "saturation", text)
    for name, unit, stated, seen, amplitude in (
        ("displacement", "µm", noise.displacement_um, s.displacement_noise_um, s.displacement_amplitude_um),
        ("tangential force", "N", noise.tangential_force_N, s.force_noise_N, s.force_amplitude_N),
    ):
        if not np.isfinite(seen).any():
            continue
        middle = float(np.nanmedian(seen))
        if stated is None:
            text = f"The noise of the {name} is not stated; between neighbouring samples it is {middle:.3g} {unit}."
            yield Remark("note", "noise", text)
        elif not 0.5 * stated <= middle <= 2.0 * stated + ROUND_OFF * float(np.nanmedian(amplitude)):
            text = f"The noise of the {name} is {middle:.3g} {unit} between samples, but stated as {stated:g}."
            yield Remark("note", "noise", text)


def _closure(checked: _Checked) -> Iterator[Remark]:
    s = checked.statistics
    for name, gap in (("displacement", s.displacement_gap), ("tangential force", s.force_gap)):
        wide = gap > OPEN
        if wide.any():
            worst = f"by up to {100.0 * float(np.nanmax(gap)):.2g} % of its range"
            yield Remark(
                "problem",
                "open loops",
                f"The {name} does not return to its start, {worst}, in {_where(checked, wide)}.",
            )
    if checked.refused:
        (repeat, cycle), reason = next(iter(checked.refused.items()))
        first = f"first: repeat {repeat}, cycle {cycle}"
        text = f"{plural(len(checked.refused), 'loop')} cannot be analysed ({first}): {reason}."
        yield Remark("problem", "loops", text)


def _drift(checked: _Checked) -> Iterator[Remark]:
    s, conditions = checked.statistics, checked.record.tables.conditions
    for name, values, scale, limit in (
        ("displacement amplitude", s.displacement_amplitude_um, conditions.displacement_amplitude_um, DRIFT),
        ("middle of the stroke", s.displacement_offset_um, conditions.displacement_amplitude_um, OFFSET_DRIFT),
        ("normal force", s.normal_force_N, conditions.normal_load_N, DRIFT),
        ("mean tangential force", s.force_offset_N, conditions.normal_load_N, OFFSET_DRIFT),
    ):
        for repeat in checked.record.repeats:
            own = values[(s.repeat == repeat) & np.isfinite(values)]
            if own.size < 2:
                continue
            # Loops are ordered by cycle: the last tenth against the first, at least one loop each.
            part = max(own.size // 10, 1)
            change = float(np.median(own[-part:]) - np.median(own[:part])) / scale
            if abs(change) > limit:
                text = f"The {name} changes by {100.0 * change:+.2g} % over repeat {repeat}."
                yield Remark("note", "drift", text)


def _repeats(checked: _Checked) -> Iterator[Remark]:
    record = checked.record
    if len(record.repeats) == 1:
        yield Remark("note", "repeats", "There is one repeat only.")
    s = checked.statistics
    if len(record.repeats) < 3:
        return
    odd: list[tuple[int, int]] = []
    for cycle in record.cycles:
        here = np.flatnonzero((s.cycle == cycle) & np.isfinite(s.energy_mJ))
        for place in here if here.size >= 3 else ():
            others = float(np.median(s.energy_mJ[here[here != place]]))
            if abs(s.energy_mJ[place] - others) > ODD_REPEAT * abs(others):
                odd.append((int(s.repeat[place]), cycle))
    if odd:
        text = (
            f"The loop area differs by more than {100.0 * ODD_REPEAT:g} % from the other repeats' in "
            f"{plural(len(odd), 'loop')} (first: repeat {odd[0][0]}, cycle {odd[0][1]})."
        )
        yield Remark("note", "repeats", text)


def _evolution(checked: _Checked) -> Iterator[Remark]:
    record = checked.record
    without = sorted(set(record.repeats) - {part.repeat for part in record.evolution})
    if record.evolution and without:
        yield Remark("note", "evolution", f"There is no evolution of the repeats {listed(without)}.")
    for part in record.evolution:
        for cycle, stated in zip(part.columns["cycle"], part.columns["dissipated_energy_mJ"], strict=True):
            figures = checked.figures.get((part.repeat, int(cycle)))
            if figures is None or not np.isfinite(stated):
                continue
            area = figures.dissipated_energy_mJ.value
            if abs(stated - area) > ODD_ENERGY * abs(area):
                where = f"repeat {part.repeat}, cycle {int(cycle)}"
                text = f"The energy of {where} is {stated:.4g} mJ, but its loop's area {area:.4g} mJ."
                yield Remark("note", "evolution", text)
                break


_CHECKS: Sequence[Callable[[_Checked], Iterator[Remark]]] = (
    _too_short,
    _times,
    _units,
    _normal_force,
    _cycle_lists,
    _repeats,
    _outlying_samples,
    _sensors,
    _closure,
    _drift,
    _evolution,
)
