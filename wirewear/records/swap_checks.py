"""Checks for copied data in a record, and for data filed under another cycle or repeat.

Two readings of a noisy sensor are never equal sample by sample; exchanged data show by their figures.
"""

from collections.abc import Iterable, Iterator
from hashlib import sha256
from typing import Literal

import numpy as np

from geometry.arrays import Array, IntArray
from wirewear.records.evolution_checks import figure_at
from wirewear.records.remarks import CheckedRecord, Remark, plural
from wirewear.records.scars import MeasuredScar
from wirewear.records.values import MeasuredEvolution
from wirewear.results.scar import called

Numbers = IntArray

#: Loops out of order: their energies differ from those they should follow by this, and by a third of it in another
#: order. Loops in order follow their evolution within 0.01 in the records of the frozen blind batches.
OUT_OF_ORDER, IN_ORDER = 0.02, 1.0 / 3.0

#: Numbers that stand for other cycles: counted in tens, hundreds or thousands, or by a log that was thinned.
RENUMBERED = (0.01, 0.1, 10.0, 100.0)

_ENERGY, _AS_NUMBERED = "dissipated_energy_mJ", "at 1 times the cycle"

#: A loop is another one's where its figures are off by so many deviations of all loops', and fit there within so many,
#: or are off by a third of that only.
OFF, FITS = 6.0, 3.0

#: Loops of which fewer show no deviation, and the least that figures of noisy loops have: that of energies in records
#: of tests of 256 samples a cycle.
FEWEST, FINEST = 6, 1e-3

ROUNDS = 4  #: Rounds in which medians of repeats and of cycles settle.


def renumbered(checked: CheckedRecord) -> Iterator[Remark]:
    """Remarks on repeats whose loops have the energies of other cycles, by their evolution or the other repeats."""
    s = checked.statistics
    evolutions = {part.repeat: part for part in checked.record.evolution}
    for repeat in checked.record.repeats:
        own = np.flatnonzero((s.repeat == repeat) & (s.energy_mJ > 0.0) & (s.cycle > 0))
        cycles, energies = s.cycle[own], s.energy_mJ[own]
        if part := evolutions.get(repeat):
            rows = {name: own if name == "cycle" else own[::-1] for name, own in part.columns.items()}
            turned = MeasuredEvolution(repeat, rows)
            expected = {
                f"at {factor:g} times the cycle": np.array(
                    [figure_at(part, _ENERGY, cycle * factor) for cycle in cycles]
                )
                for factor in (1.0, *RENUMBERED)
            }
            expected["with its rows in reverse order"] = np.array([figure_at(turned, _ENERGY, one) for one in cycles])
            whom = "the evolution"
        else:
            others = [s.energy_mJ[(s.cycle == cycle) & (s.repeat != repeat)] for cycle in cycles]
            expected = {_AS_NUMBERED: np.array([np.median(same) if same.size > 1 else np.nan for same in others])}
            whom = "the other repeats"
        if found := _other_order(energies, expected):
            text = (
                f"The loops of repeat {repeat} have the energies of {whom} {found}: check the numbers of their cycles."
            )
            yield Remark("problem", "cycle lists", text)


def exchanged_evolutions(checked: CheckedRecord) -> Iterator[Remark]:
    """Remarks on repeats that have the evolution of each other, by the energies of their loops."""
    s, owners = checked.statistics, {}
    for repeat in checked.record.repeats:
        own = np.flatnonzero((s.repeat == repeat) & (s.energy_mJ > 0.0))
        off = {}
        for part in checked.record.evolution:
            stated = np.array([figure_at(part, "dissipated_energy_mJ", int(cycle)) for cycle in s.cycle[own]])
            if stated.size >= 2 and (stated > 0.0).all():
                off[part.repeat] = float(np.sqrt(np.mean(np.log(s.energy_mJ[own] / stated) ** 2)))
        best = min(off, key=lambda other: off[other], default=repeat)
        if off.get(repeat, 0.0) > OUT_OF_ORDER and off[best] < IN_ORDER * off[repeat]:
            owners[repeat] = best
    if owners and owners.keys() == set(owners.values()):
        pairs = ", ".join(f"{repeat} that of {other}" for repeat, other in owners.items())
        text = f"Repeats have the evolution of each other, as the energies of their loops show: {pairs}."
        yield Remark("problem", "evolution", text)


def exchanged_loops(checked: CheckedRecord) -> Iterator[Remark]:
    """One remark at most, on pairs of loops each of which has the energy and largest force expected of the other by the
    repeat's evolution or else by the other loops: it names the first pair and counts the rest.
    """
    s = checked.statistics
    own = np.flatnonzero((s.energy_mJ > 0.0) & (s.force_amplitude_N > 0.0) & (s.cycle > 0))
    figures = {"dissipated_energy_mJ": s.energy_mJ, "max_tangential_force_N": s.force_amplitude_N}
    measured = {name: np.log(values[own]) for name, values in figures.items()}
    repeat, cycle = s.repeat[own], s.cycle[own]
    misfits = []
    for name, values in measured.items():
        expected = _expected(checked, name, values, repeat, cycle)
        off = values - expected
        known = np.isfinite(off)
        if np.count_nonzero(known) >= FEWEST:
            # By the median, so that misplaced loops do not count.
            spread = np.median(np.abs(off[known] - np.median(off[known])))
            deviation = max(1.4826 * float(spread), FINEST)
            misfits.append((values / deviation, expected / deviation))
    if not misfits:
        return
    off = np.max([np.abs(values - expected) for values, expected in misfits], axis=0)
    suspects = np.flatnonzero(off > OFF)
    # So many loops out of place are no exchange of two; pairs are as many as their square.
    if suspects.size > 200:
        return
    one, other = (suspects[place] for place in np.triu_indices(suspects.size, 1))
    crosswise = np.max([np.abs([v[one] - e[other], v[other] - e[one]]).max(axis=0) for v, e in misfits], axis=0)
    found = crosswise < np.maximum(FITS, IN_ORDER * np.minimum(off[one], off[other]))
    pairs = [
        [f"cycle {cycle[place]} of repeat {repeat[place]}" for place in pair]
        for pair in zip(one[found], other[found], strict=True)
    ]
    if pairs:
        more = f" So have {plural(len(pairs) - 1, 'further pair')}." if len(pairs) > 1 else ""
        text = f"The loops of {' and '.join(pairs[0])} have each other's energy and force: are they exchanged?{more}"
        yield Remark("problem", "cycle lists", text)


def _expected(checked: CheckedRecord, name: str, values: Array, repeat: Numbers, cycle: Numbers) -> Array:
    """Logarithms (n,) of a figure expected of loops, from their repeat's evolution or else the other repeats; NaN if
    unknown.

    Common factors of a repeat or a cycle are removed as medians: other definitions and specimens are not looked for.
    """
    expected = np.full(values.size, np.nan)
    for part in checked.record.evolution:
        for place in np.flatnonzero(repeat == part.repeat):
            stated = figure_at(part, name, int(cycle[place]))
            expected[place] = np.log(stated) if stated > 0.0 else np.nan
    if not np.isfinite(expected).any():
        # Both in turn, as medians of what the other leaves.
        of_cycle = of_repeat = np.zeros(values.size)
        for _ in range(ROUNDS):
            of_cycle = _medians(values - of_repeat, cycle)
            of_repeat = _medians(values - of_cycle, repeat)
        several = np.array([np.count_nonzero(cycle == own) > 2 for own in cycle])
        return np.where(several, of_cycle + of_repeat, np.nan)
    shift = float(np.nanmedian(values - expected))
    return expected + shift


def _medians(values: Array, group: Numbers) -> Array:
    return np.array([np.median(values[group == own]) for own in group])


def _other_order(energies: Array, expected: dict[str, Array]) -> str | None:
    """Words on how energies (n,) would fit the expected ones, such as "in reverse order"; None if they fit, or never
    do.

    expected: energies (n,) by the words for each way of renumbering.
    """
    known = expected[_AS_NUMBERED] > 0.0
    if np.count_nonzero(known) < 3:
        return None

    def misfit(ours: Array, theirs: Array) -> float:
        return float(np.std(np.log(ours / theirs))) if (theirs > 0.0).all() else np.inf

    ours, theirs = energies[known], expected[_AS_NUMBERED][known]
    given = misfit(ours, theirs)
    if given < OUT_OF_ORDER:
        return None
    if misfit(ours[::-1], theirs) < IN_ORDER * given:
        return "in reverse order"
    if misfit(np.sort(ours), np.sort(theirs)) < IN_ORDER * given:
        return "in another order"
    for done, values in expected.items():
        if misfit(energies, values) < IN_ORDER * given:
            return done
    return None


def copied_loops(checked: CheckedRecord) -> Iterator[Remark]:
    """Remark on the first loop with a channel equal, sample by sample, to that of another loop."""
    record, noise = checked.record, checked.record.tables.noise
    for name, stated in (
        ("displacement_um", noise.displacement_um),
        ("tangential_force_N", noise.tangential_force_N),
        ("normal_force_N", noise.normal_force_N),
    ):
        channels = ((loop.name, getattr(loop, name)) for loop in record.loops)
        if pair := _first_copy((called, (channel,)) for called, channel in channels if channel is not None):
            level: Literal["problem", "note"] = "problem" if stated else "note"
            text = f"{pair[1]} has the same {name}, sample by sample, as {pair[0]}: one is a copy"
            yield Remark(level, "copies", f"{text[:1].upper()}{text[1:]}, or the channel has no noise.")
            return


def copied_evolution(checked: CheckedRecord) -> Iterator[Remark]:
    """Remark on the first repeat whose evolution equals that of another, figure by figure."""
    parts = ((f"repeat {part.repeat}", tuple(part.columns.values())) for part in checked.record.evolution)
    if pair := _first_copy(parts):
        tables = checked.record.tables
        noisy = tables.noise.tangential_force_N and tables.metadata.source != "simulated"
        level: Literal["problem", "note"] = "problem" if noisy else "note"
        text = f"The evolution of {pair[1]} is that of {pair[0]}, figure by figure: one is a copy, or without noise."
        yield Remark(level, "copies", text)


def copied_scars(scars: Iterable[MeasuredScar]) -> Iterator[str]:
    """A sentence on two maps with equal depths, of other repeats or bodies; none if there are none."""
    if pair := _first_copy((f"the {called(scar.body)}'s of repeat {scar.repeat}", (scar.depth_um,)) for scar in scars):
        yield f"A scar stands twice: {pair[1]} is {pair[0]}, point by point, so that one is a copy, or without noise."


def _first_copy(named: Iterable[tuple[str, tuple[Array, ...]]]) -> tuple[str, str] | None:
    """Names of the first two entries with equal numbers, constants excepted; None if there are none."""
    seen: dict[bytes, str] = {}
    for name, arrays in named:
        if not any(array.size and np.nanmax(array) > np.nanmin(array) for array in arrays if np.isfinite(array).any()):
            continue
        digest = sha256(b"".join(np.ascontiguousarray(array).tobytes() for array in arrays)).digest()
        if digest in seen:
            return seen[digest], name
        seen[digest] = name
    return None
