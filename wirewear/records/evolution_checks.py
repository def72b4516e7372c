"""Checks of a record as a whole: its cycles, its repeats, and the drift of its figures over the test.

Each check yields remarks on what it finds, none if all is well.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from geometry.arrays import Array
from wirewear.base.course import enclosed_energy
from wirewear.loops import LoopError, LoopFigures
from wirewear.records.remarks import CheckedRecord, Remark, listed, plural
from wirewear.records.values import AnyRecord, MeasuredEvolution, MeasuredLoop
from wirewear.results.scar import called

DRIFT, OFFSET_DRIFT = 0.05, 0.05  #: What counts as notable: drifts over the test, of amplitudes or load and of means.

#: The same of a loop's area beside the other repeats', and of a stated energy beside its loop's area. Of this factor
#: fresh specimens do not differ, and no definition of the energy does.
ODD_REPEAT, ODD_ENERGY, OTHER_ENERGY = 0.25, 0.1, 2.0


_EVOLVING = {
    "displacement_amplitude_um": "displacement amplitude",
    "slip_amplitude_um": "slip amplitude",
    "max_tangential_force_N": "largest tangential force",
    "dissipated_energy_mJ": "dissipated energy",
}


@dataclass(frozen=True)
class OtherDefinition:
    """Column of the evolution that is defined otherwise than the figures of the record's loops.

    share: median of the column's difference from these figures, relative to them.
    """

    column: str
    share: float

    @property
    def text(self) -> str:
        return (
            f"the evolution's {self.column} differs by {100.0 * self.share:+.0f} % from that of the record's own "
            "loops: it is defined otherwise"
        )


def other_definitions(
    loops: Mapping[tuple[int, int], tuple[MeasuredLoop, LoopFigures]], evolution: Sequence[MeasuredEvolution]
) -> tuple[OtherDefinition, ...]:
    """Columns of the evolution that contradict the loops; empty if none does.

    loops: loops and their figures by (repeat, cycle). The largest force may be defined as max |Q| or as half the range
    of Q, which an offset of the force distinguishes.
    """
    shares: dict[str, list[float]] = {}
    for part in evolution:
        for (repeat, cycle), (loop, figures) in loops.items():
            if repeat == part.repeat and cycle > 0:
                for column, own in _figures(loop, figures).items():
                    stated = figure_at(part, column, cycle)
                    if np.isfinite(stated) and stated > 0.0 and min(own) > 0.0:
                        away = np.log(stated / np.array(own))
                        shares.setdefault(column, []).append(float(away[np.abs(away).argmin()]))
    # Loops that must have their figure in the evolution to say so.
    medians = {column: float(np.median(away)) for column, away in shares.items() if len(away) >= 3}
    # Relative difference from the loops, as a median, from which on a figure is another one. In forty records of other
    # solvers, with noise, hum, drift and steps of sensors, figures of the same definition differ by at most 0.025
    # (0.002 but for the largest force), a plateau's force and a rectangle's slip by 0.09.
    found = {column: float(np.expm1(away)) for column, away in medians.items() if abs(away) > 0.04}
    return tuple(OtherDefinition(column, share) for column, share in found.items())


def _figures(loop: MeasuredLoop, figures: LoopFigures) -> dict[str, tuple[float, ...]]:
    """Values of a loop's figures by column, for each definition that a column may have."""
    force = loop.tangential_force_N[np.isfinite(loop.tangential_force_N)]
    # A few samples may be spikes.
    low, high = np.quantile(force, [0.01, 0.99])
    return {
        "dissipated_energy_mJ": (figures.dissipated_energy_mJ.value,),
        "slip_amplitude_um": (figures.slip_amplitude_um.value,),
        "max_tangential_force_N": (float(max(-low, high)), 0.5 * float(high - low)),
    }


def figure_at(part: MeasuredEvolution, column: str, cycle: float) -> float:
    """Value of a column at a cycle, linear in log cycle; NaN outside the known cycles, or without the column."""
    if column not in part.columns:
        return np.nan
    known = np.isfinite(part.columns[column]) & (part.columns["cycle"] > 0)
    times, values = np.log(part.columns["cycle"][known]), part.columns[column][known]
    if times.size == 0:
        return np.nan
    return float(np.interp(np.log(cycle), times, values, left=np.nan, right=np.nan))


def cycle_lists(checked: CheckedRecord) -> Iterator[Remark]:
    """Remarks on logged cycles that some repeats lack, and on cycles beyond the test's end."""
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
    """Remarks on means and amplitudes that change by more than 5 % over a repeat."""
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
    """Remarks on a single repeat, on worn surfaces without loops, and on loops whose area differs much from those of
    the other repeats.
    """
    record = checked.record
    for number in sorted({one.repeat for one in record.scars} - {loop.repeat for loop in record.loops}):
        of_bodies = " and of the ".join(called(one.body) for one in record.scars if one.repeat == number)
        text = (
            f"Repeat {number} has a {record.tables.worn.name} of the {of_bodies} and no loops, so that the test that "
            "wore it is not known: is it a copy, or was it measured before the test?"
        )
        yield Remark("problem", "repeats", text)
    if len(record.repeats) == 1:
        yield Remark("note", "repeats", "There is one repeat only.")
    s = checked.statistics
    if len(record.repeats) < 3:
        return
    odd: list[tuple[int, int]] = []
    # A wrong sign is another fault.
    sizes, far = np.abs(s.energy_mJ), 0
    for cycle in record.cycles:
        here = np.flatnonzero((s.cycle == cycle) & np.isfinite(sizes))
        for place in here if here.size >= 3 else ():
            others = float(np.median(sizes[here[here != place]]))
            if abs(sizes[place] - others) > ODD_REPEAT * others:
                odd.append((int(s.repeat[place]), cycle))
                far += not others / OTHER_ENERGY < sizes[place] < others * OTHER_ENERGY
    if odd:
        text = (
            f"The loop area differs by more than {100.0 * ODD_REPEAT:g} % from the other repeats' in "
            f"{plural(len(odd), 'loop')} (first: repeat {odd[0][0]}, cycle {odd[0][1]})."
        )
        if far:
            text += f" In {far} of them it is {OTHER_ENERGY:g} times as large or as small: a gain may differ."
        yield Remark("problem" if far else "note", "repeats", text)


def evolution(checked: CheckedRecord) -> Iterator[Remark]:
    """Remarks on missing evolutions, on columns with another definition, and on energies unlike the loop's area."""
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
                far = not 1.0 / OTHER_ENERGY < stated / area < OTHER_ENERGY
                yield Remark("problem" if far else "note", "evolution", text)
                break


def impossible_evolution(checked: CheckedRecord) -> Iterator[Remark]:
    """Remarks on impossible values of the evolution: negative ones, energies beyond stroke times force, another stroke,
    cycles beyond the test's end.
    """
    last = checked.record.tables.conditions.cycles
    for part in checked.record.evolution:
        who = f"the evolution of repeat {part.repeat}"
        columns = {name: part.columns[name] for name in _EVOLVING if name in part.columns}
        for name, values in columns.items():
            # Under a load that varies, springs of a contact that sticks give back what the load put in.
            if name == "dissipated_energy_mJ" and checked.record.tables.conditions.load_cycle is not None:
                continue
            negative = values < -ODD_ENERGY * np.nanmax(np.abs(values), initial=0.0, where=np.isfinite(values))
            if negative.any():
                text = f"The {_EVOLVING[name]} is negative in {who}: turn it round, by factor = -1 in a mapping."
                yield Remark("problem", "evolution", text, refuses=2 * int(negative.sum()) > negative.size)
        if columns.keys() >= {"dissipated_energy_mJ", "max_tangential_force_N", "displacement_amplitude_um"}:
            most = 4e-3 * np.abs(columns["displacement_amplitude_um"] * columns["max_tangential_force_N"])
            energy = columns["dissipated_energy_mJ"]
            # A loop's energy exceeds that of the rectangle around it by no more than what figures scatter, or hooks
            # rise.
            beyond = energy > 1.2 * most
            if beyond.any():
                place = int(np.argmax(beyond))
                text = (
                    f"The energy of cycle {part.columns['cycle'][place]:.0f} in {who} is {energy[place]:.3g} mJ, where "
                    f"its stroke and largest force allow {most[place]:.3g} mJ: check their units and definitions."
                )
                yield Remark("problem", "evolution", text)
        if (beyond_end := part.columns["cycle"] > last).any():
            text = f"In {who}, {int(beyond_end.sum())} of {beyond_end.size} cycles lie beyond the test's end, {last}."
            yield Remark("problem", "evolution", text)
    yield from _other_stroke(checked)


def _other_stroke(checked: CheckedRecord) -> Iterator[Remark]:
    """Remarks on evolutions whose displacement amplitude differs from that of the loops."""
    s = checked.statistics
    for part in checked.record.evolution:
        own = np.flatnonzero(s.repeat == part.repeat)
        stated = np.array([figure_at(part, "displacement_amplitude_um", int(cycle)) for cycle in s.cycle[own]])
        ratios = stated / s.displacement_amplitude_um[own]
        ratio = float(np.nanmedian(ratios)) if np.isfinite(ratios).any() else 1.0
        if abs(ratio - 1.0) > ODD_ENERGY:
            hint = "it may be the whole stroke" if abs(ratio - 2.0) < 2.0 * ODD_ENERGY else "it may be of another test"
            text = (
                f"The displacement amplitude in the evolution of repeat {part.repeat} is {ratio:.3g} times that of its "
                f"loops: {hint}."
            )
            yield Remark("problem", "evolution", text)


def accumulated_energy_J(record: AnyRecord, repeat: int) -> float | None:
    """Friction energy in J of a whole test of one repeat, from its evolution or else its loops; None if neither shows
    any. Between two logged cycles the energy per cycle is a power of the cycle number; it is constant before the first
    and after the last.
    """
    cycles, energies = energy_per_cycle(record, repeat)
    if not cycles.size:
        return None
    ends = np.append(cycles, max(record.tables.conditions.cycles, cycles[-1]))
    return float(energy_so_far_J(record, ends, np.append(energies, energies[-1]))[-1])


def energy_so_far_J(record: AnyRecord, cycles: Array, energies_mJ: Array) -> Array:
    """Friction energy (n,) in J from the first cycle to each of increasing cycles (n,), by the energy of each of these;
    between and before them as `accumulated_energy_J` says.
    """
    ends = [*zip(record.working_cycles(cycles), energies_mJ, strict=True)]
    steps = (enclosed_energy(*zip(*pair, strict=True)) for pair in pairwise(ends))
    first, energy = ends[0]
    return 1e-3 * np.cumsum([first * energy, *steps])


def energy_per_cycle(record: AnyRecord, repeat: int) -> tuple[Array, Array]:
    """Increasing cycles (n,) of a repeat and their friction energies (n,) in mJ, from its evolution or else its loops;
    empty if neither shows any.
    """
    for part in record.evolution:
        cycle, energy = part.columns["cycle"], part.columns["dissipated_energy_mJ"]
        known = np.isfinite(energy) & (energy > 0.0) & (cycle > 0)
        if part.repeat == repeat and known.any():
            return cycle[known], energy[known]
    rows = []
    for loop in record.loops:
        if loop.repeat == repeat and loop.cycle > 0:
            try:
                rows.append((float(loop.cycle), loop.figures(None).dissipated_energy_mJ.value))
            except LoopError:
                continue
    found = np.array(rows).reshape(-1, 2)
    return found[:, 0], found[:, 1]
