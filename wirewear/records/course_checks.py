"""What is odd about a record as a whole: its cycles, its repeats, their course over the test."""

from collections.abc import Iterator

import numpy as np

from wirewear.records.definitions import other_definitions
from wirewear.records.remarks import CheckedRecord, Remark
from wirewear.records.wording import listed, plural

#: What counts as notable: drifts over the test, of amplitudes or load and of means.
DRIFT, OFFSET_DRIFT = 0.05, 0.05

#: The same of a loop's area beside the other repeats', and of a stated energy beside its loop's area.
ODD_REPEAT, ODD_ENERGY = 0.25, 0.1


def cycle_lists(checked: CheckedRecord) -> Iterator[Remark]:
    """Cycles that not all repeats have, and those beyond the test's end."""
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


def drift(checked: CheckedRecord) -> Iterator[Remark]:
    """Means and amplitudes that change over the test."""
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


def repeats(checked: CheckedRecord) -> Iterator[Remark]:
    """A single repeat, and loops unlike those of the other repeats."""
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


def evolution(checked: CheckedRecord) -> Iterator[Remark]:
    """Repeats without an evolution, figures of another definition, and energies that are not their loop's area."""
    record = checked.record
    without = sorted(set(record.repeats) - {part.repeat for part in record.evolution})
    if record.evolution and without:
        yield Remark("note", "evolution", f"There is no evolution of the repeats {listed(without)}.")
    loops = {(loop.repeat, loop.cycle): loop for loop in record.loops}
    analysed = {name: (loops[name], figures) for name, figures in checked.figures.items()}
    for other in other_definitions(analysed, record.evolution):
        text = f"{other.text[:1].upper()}{other.text[1:]}. A diagnosis leaves it out."
        yield Remark("note", "evolution", text)
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
