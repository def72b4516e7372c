"""Checks of single loops of a record.

Each check yields remarks on what it finds in the record's loops, none if all is well. A channel is one recorded signal.
"""

from collections.abc import Iterator
from typing import Literal

import numpy as np

from geometry.arrays import Array, BoolArray
from wirewear.loops.analysis import ELLIPSE, HIDDEN, MAY_DRIFT, RUNS_ON
from wirewear.loops.cleaning import BACKWARDS, DRIFTS
from wirewear.loops.reading import EARLY, LATE
from wirewear.records.normal_force import impossible_loads
from wirewear.records.remarks import COURSE, FEWEST_SAMPLES, CheckedRecord, Remark, coarse_step_of, plural, where
from wirewear.test.conditions import held_keys

#: What of the analysis' notes nothing here has words of its own for.
NOTED = (LATE, EARLY, RUNS_ON, BACKWARDS, DRIFTS, MAY_DRIFT, ELLIPSE, HIDDEN)

#: What counts as notable: relative deviations of amplitude, load and period, a gap in a loop, a share of outliers.
ODD_AMPLITUDE, ODD_LOAD, ODD_PERIOD = 0.1, 0.1, 0.05
OPEN, OUTLIER_SHARE = 0.02, 0.01

COARSE = 0.02  #: Steps of a reading that can be seen, over its amplitude.

#: Samples in no order scatter about their neighbours by half of the amplitude and more; the noise of no sensor that is
#: of use comes near to it.
NO_ORDER = 0.3


#: An amplitude off by this factor is in another unit; a loop's area against the motion, of the rectangle around it, is
#: one of a wrong sign and not of noise.
OTHER_UNIT, AGAINST_MOTION = 5.0, 0.05

#: Tangential force over normal load of dry bodies that rub, and what is said of others.
DRY, NO_FRICTION = (0.005, 3.0), "The tangential force is {:.3g} times the normal load, which no dry friction gives"


def too_short(checked: CheckedRecord) -> Iterator[Remark]:
    """Remarks on loops with too few samples, and on samples that lack a channel."""
    short = checked.statistics.samples < FEWEST_SAMPLES
    if short.any():
        yield Remark("problem", "samples", f"Fewer than {FEWEST_SAMPLES} complete samples in {where(checked, short)}.")
    missing = checked.statistics.missing
    if missing.any():
        text = f"{plural(int(missing.sum()), 'sample')} missing a channel left out, in {where(checked, missing > 0)}."
        yield Remark("note", "missing samples", text)


def times(checked: CheckedRecord) -> Iterator[Remark]:
    """Remarks on times that do not increase, and on cycles that do not last one period of the stated frequency."""
    s = checked.statistics
    disordered = s.time_errors > 0.0
    if disordered.any():
        text = f"Time does not increase throughout {where(checked, disordered)}: rows may be doubled or re-ordered."
        # Of the samples of most loops, from which share on times that do not increase say that rows are in another
        # order.
        yield Remark("problem", "time", text, refuses=_most(s.time_errors > 0.05 * s.samples))
    period = 1.0 / checked.record.tables.conditions.frequency_Hz
    odd = np.abs(s.period_s / period - 1.0) > ODD_PERIOD
    if odd.any():
        ratio = float(np.nanmedian(s.period_s[odd])) / period
        unit = "; it looks like milliseconds" if 500.0 < ratio < 2000.0 else ""
        text = f"A cycle should last {period:.4g} s, but lasts {ratio:.3g} times that in {where(checked, odd)}{unit}."
        yield Remark("problem", "time", text)


def order(checked: CheckedRecord) -> Iterator[Remark]:
    """Remarks on channels that scatter or jump between samples, as with rows in a wrong order."""
    s = checked.statistics
    scattered = (s.displacement_noise_um > NO_ORDER * s.displacement_amplitude_um) | (
        s.force_noise_N > NO_ORDER * s.force_amplitude_N
    )
    # A drive that takes this share of its stroke in one step, of many, has samples missing or exchanged.
    jumps = s.displacement_jump > np.maximum(0.3, 4.0 * np.pi / np.maximum(s.samples, 1))
    for wrong, what in (
        (scattered, "Neighbouring samples differ as much as any two"),
        (
            jumps & ~scattered,
            f"The displacement jumps by up to {100.0 * _largest(s.displacement_jump):.0f} % of its range",
        ),
    ):
        if wrong.any():
            text = f"{what}, in {where(checked, wrong)}: rows may be missing or re-ordered."
            yield Remark("problem", "order of samples", text, refuses=_most(wrong))


def _largest(values: Array) -> float:
    return float(np.nanmax(values)) if np.isfinite(values).any() else 0.0


def folded(checked: CheckedRecord) -> Iterator[Remark]:
    """Remark on forces recorded as absolute values, which fall to zero and rise again twice a cycle."""
    wrong = checked.statistics.force_folded > 0.0
    if wrong.any():
        text = (
            "The tangential force falls to nothing and rises again twice a cycle, but never changes its sign, as one "
            f"that was rectified, in {where(checked, wrong)}: log it with its sign."
        )
        yield Remark("problem", "tangential force", text, refuses=_most(wrong))


def units(checked: CheckedRecord) -> Iterator[Remark]:
    """Remarks on displacement amplitudes and forces far from those asked for, and on forces that drive the motion."""
    s, conditions = checked.statistics, checked.record.tables.conditions
    ratio = s.displacement_amplitude_um / conditions.displacement_amplitude_um
    odd = np.abs(ratio - 1.0) > ODD_AMPLITUDE
    if held_keys(conditions):
        # A drive that holds something else has that at most, and often far less; other units are a thousand off.
        odd &= (ratio > 1.0) | (ratio < 1e-2)
    if odd.any():
        middle = float(np.nanmedian(ratio[odd]))
        decade = round(float(np.log10(middle))) if middle > 0.0 else 0
        unit = {-3: ": it looks like millimetres", 3: ": it looks like nanometres"}.get(decade, "")
        asked = f"the {conditions.displacement_amplitude_um:g} µm asked for"
        text = f"The displacement amplitude is {middle:.3g} times {asked} in {where(checked, odd)}{unit}."
        strange = bool(np.nanmedian(np.abs(np.log(np.maximum(ratio, 1e-12)))) > np.log(OTHER_UNIT))
        yield Remark("problem", "displacement", text, refuses=strange)
    friction = s.force_amplitude_N / conditions.normal_load_N
    odd = (friction < DRY[0]) | (friction > DRY[1])
    if odd.any():
        text = f"{NO_FRICTION.format(float(np.nanmedian(friction[odd])))}, in {where(checked, odd)}: check its unit."
        yield Remark("problem", "tangential force", text, refuses=_most(odd))
    turned = s.energy_mJ < 0.0
    if turned.any():
        text = f"The tangential force drives the motion, as if its sign were wrong, in {where(checked, turned)}."
        # Around a loop without slip, noise makes small areas of either sign.
        opened = s.energy_mJ / (4e-3 * s.displacement_amplitude_um * s.force_amplitude_N)
        yield Remark("problem", "tangential force", text, refuses=_most(opened < -AGAINST_MOTION))


def _most(loops: BoolArray) -> bool:
    return 2 * int(np.count_nonzero(loops)) > loops.size


def normal_force(checked: CheckedRecord) -> Iterator[Remark]:
    """Remarks on missing normal forces, and on those far from the load asked for."""
    s, load = checked.statistics, checked.record.tables.conditions.normal_load_N
    absent = np.isnan(s.normal_force_N) & (s.samples >= FEWEST_SAMPLES)
    if absent.all():
        yield Remark("note", "normal force", "No normal force was measured; the load asked for stands in for it.")
        return
    if absent.any():
        yield Remark("note", "normal force", f"No normal force was measured in {where(checked, absent)}.")
    impossible = tuple(impossible_loads(checked.record.loops, load, checked.record.tables.length_mm))
    for words, wrong in impossible:
        yield Remark("problem", "normal force", f"{words}, in {where(checked, wrong)}.", refuses=True)
    odd = np.abs(s.normal_force_N / load - 1.0) > ODD_LOAD
    if odd.any() and not impossible:
        ratio = float(np.nanmedian(s.normal_force_N[odd])) / load
        text = f"The normal force is {ratio:.3g} times the {load:g} N asked for in {where(checked, odd)}."
        yield Remark("note", "normal force", text)


def outlying_samples(checked: CheckedRecord) -> Iterator[Remark]:
    """Remark on the number of outlying samples: a problem if they are more than the share `OUTLIER_SHARE` of all, else
    a note.
    """
    s = checked.statistics
    count, all_samples = float(np.nansum(s.outliers)), max(int(s.samples.sum()), 1)
    if count:
        share = count / all_samples
        level: Literal["problem", "note"] = "problem" if share > OUTLIER_SHARE else "note"
        text = f"{plural(int(count), 'outlying sample')} ({100.0 * share:.2g} %) in {where(checked, s.outliers > 0)}."
        yield Remark(level, "outliers", text)


def sensors(checked: CheckedRecord) -> Iterator[Remark]:
    """Remarks on sensors at the end of their range, and on noise that is not stated or differs from the stated one."""
    s, noise = checked.statistics, checked.record.tables.noise
    for name, saturated in (
        ("displacement", s.displacement_saturated),
        ("tangential force", s.force_saturated),
        ("normal force", s.normal_saturated),
    ):
        stuck = saturated > 0.0
        if stuck.any():
            text = (
                f"The {name} stays at its extreme, as a sensor at its stop does, in {where(checked, stuck)}: it is "
                "clipped there."
            )
            yield Remark("problem", "saturation", text, refuses=_most(stuck))
    for name, unit, stated, seen, amplitude in (
        ("displacement", "µm", noise.displacement_um, s.displacement_noise_um, s.displacement_amplitude_um),
        ("tangential force", "N", noise.tangential_force_N, s.force_noise_N, s.force_amplitude_N),
    ):
        if not np.isfinite(seen).any():
            continue
        middle = float(np.nanmedian(seen))
        course = next(share for samples, share in COURSE if np.median(s.samples) >= samples)
        if stated is None:
            text = f"The noise of the {name} is not stated; between neighbouring samples it is {middle:.3g} {unit}."
            yield Remark("note", "noise", text)
        elif not 0.5 * stated <= middle <= 2.0 * stated + course * float(np.nanmedian(amplitude)):
            text = f"The noise of the {name} is {middle:.3g} {unit} between samples, but stated as {stated:g}."
            yield Remark("note", "noise", text)


def resolution(checked: CheckedRecord) -> Iterator[Remark]:
    """Remarks on channels read in steps of more than the share `COARSE` of their amplitude."""
    s, loops = checked.statistics, checked.record.loops
    for name, unit, amplitude, channels in (
        ("displacement", "µm", s.displacement_amplitude_um, [loop.displacement_um for loop in loops]),
        ("tangential force", "N", s.force_amplitude_N, [loop.tangential_force_N for loop in loops]),
    ):
        steps = np.array([coarse_step_of(channel) for channel in channels])
        coarse = steps > COARSE * amplitude
        if coarse.any():
            share = 100.0 * float(np.median((steps / amplitude)[coarse]))
            text = (
                f"The {name} is read in steps of {float(np.median(steps[coarse])):.3g} {unit}, {share:.2g} % of its "
                f"amplitude, in {where(checked, coarse)}: what is smaller is lost."
            )
            yield Remark("note", "resolution", text)


def closure(checked: CheckedRecord) -> Iterator[Remark]:
    """Remarks on loops that do not close, or cannot be analysed."""
    s = checked.statistics
    for name, gap in (("displacement", s.displacement_gap), ("tangential force", s.force_gap)):
        wide = gap > OPEN
        if wide.any():
            worst = f"by up to {100.0 * float(np.nanmax(gap)):.2g} % of its range"
            yield Remark(
                "problem", "open loops", f"The {name} does not return to its start, {worst}, in {where(checked, wide)}."
            )
    if checked.refused:
        (repeat, cycle), reason = next(iter(checked.refused.items()))
        first = f"first: repeat {repeat}, cycle {cycle}"
        text = f"{plural(len(checked.refused), 'loop')} cannot be analysed ({first}): {reason}."
        yield Remark("problem", "loops", text)


def notes_of_analysis(checked: CheckedRecord) -> Iterator[Remark]:
    """Remarks on the notes `NOTED` that the analysis of loops made, each with the first loop that it concerns."""
    for noted in NOTED:
        begin = noted.partition("{")[0]
        found = {
            name: note for name, figures in checked.figures.items() for note in figures.notes if note.startswith(begin)
        }
        if found:
            (repeat, cycle), note = next(iter(found.items()))
            of_all = f"In {len(found)} of {plural(len(checked.figures), 'analysed loop')}"
            yield Remark("note", "loops", f"{of_all} {note} (first: repeat {repeat}, cycle {cycle}).")


def play_and_stick_slip(checked: CheckedRecord) -> Iterator[Remark]:
    """Remarks on free play and stick-slip, if most sliding loops show them."""
    sliding = [figures for figures in checked.figures.values() if figures.regime == "gross slip"]
    plays = [figures.free_play_um.value for figures in sliding if figures.free_play_um is not None]
    if 2 * len(plays) > len(sliding):
        text = (
            f"A shelf about zero force in {len(plays)} of {plural(len(sliding), 'sliding loop')}, as free play of "
            f"{float(np.median(plays)):.3g} µm gives."
        )
        yield Remark("note", "free play", text)
    chattering = [figures.stick_slip for figures in sliding if figures.stick_slip is not None]
    if 2 * len(chattering) > len(sliding):
        often = float(np.median([chatter.slips_per_cycle for chatter in chattering]))
        where = f"{len(chattering)} of {plural(len(sliding), 'sliding loop')}"
        yield Remark("note", "stick-slip", f"Stick-slip in {where}, about {often:.0f} times a cycle.")
