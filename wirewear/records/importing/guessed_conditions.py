"""Conditions of a test that its files show: load, amplitude, frequency, cycles, signs of forces, scars.

A value of a mapping is open if the files do not show it, so that the user must fill it in.
"""

import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from geometry.arrays import Array
from wirewear.base.errors import RecordError
from wirewear.loops import LoopError
from wirewear.loops.clock import Clock, read_clock
from wirewear.loops.cycles import split_cycles
from wirewear.loops.drive import even_period, period_by_phase, period_of, series
from wirewear.loops.reading import read_loop
from wirewear.records.common_tables import FRICTION_FORCE
from wirewear.records.importing.guessed_columns import GuessedFile, shut
from wirewear.records.importing.guessed_files import FEWEST
from wirewear.records.importing.importing import drives_motion, loops_of
from wirewear.records.importing.mapping import LoopSource
from wirewear.records.values import MeasuredLoop
from wirewear.test.bodies import OPEN
from wirewear.test.keys import AMPLITUDE_um

#: Frequencies of fretting rigs, from creeping drives to piezos; numbers without a unit beyond are no seconds.
_RIGS_Hz = 0.1, 1000.0
_FEWEST = 4  #: Samples of a cycle that show its period.
_SINE = 0.05  #: Of a cycle's displacement: what is left of one that is a sine.


def conditions_of(
    text: GuessedFile,
    source: dict[str, Any],
    known: Mapping[str, object],
    length_mm: float | None = None,
    *,
    of_joint: bool = False,
) -> tuple[dict[str, object], dict[str, float], list[str]]:
    """Conditions by key that the first file shows (others are open), signs of forces by key, and sentences on
    assumptions.

    source: table `[loops]` of the mapping, whose columns may be changed in place. known: conditions that the user
    states. length_mm: of a line contact. of_joint: True if an unknown load is replaced by the friction force of the
    loops. Raises RecordError if the file holds too few samples, or its loops cannot be distinguished.
    """
    closed = {key: own for key, own in source["columns"].items() if own["column"] != OPEN}
    columns = text.read(closed, length_mm) if closed else {}
    timing = {"frequency_Hz": known.get("frequency_Hz", OPEN), "cycles": known.get("cycles", OPEN)}
    loops: list[MeasuredLoop] = []
    remarks, signs = [], dict[str, float]()
    if {"displacement_um", "tangential_force_N"} <= closed.keys():
        x = columns["displacement_um"]
        x = x[np.isfinite(x)]
        if x.size < FEWEST or np.ptp(x) <= 0.0:
            raise RecordError(f"{text.path}: {x.size} complete samples of a displacement show no loop.")
        columns, clock = _clocked(columns)
        remarks += [f"{text.path.name}: {clock.note}"] if clock.note else []
        if "time_s" not in columns and ("cycle" in columns or not clock.gaps):
            closed.pop("time_s", None)
            source["columns"].pop("time_s", None)
        found, doubt = frequency_of(columns, source, clock.doubt_s)
        if (
            "frequency_Hz" not in known
            and "time_s" in text.columns
            and not text.columns["time_s"][1]
            and found
            and not _RIGS_Hz[0] <= found <= _RIGS_Hz[1]
        ):
            source["columns"]["time_s"]["unit"] = OPEN
            remarks.append(f"{found:g} cycles in a unit of the column of time are none a second: which unit is it?")
        asked = _open(source, "time_s")
        doubtful = bool(doubt) and "frequency_Hz" not in known
        timing["frequency_Hz"] = known.get("frequency_Hz") or (OPEN if asked or doubtful else found) or OPEN
        cut_by = found if asked or doubtful else timing["frequency_Hz"]
        loops = _loops(text, source | {"columns": closed}, cut_by or OPEN, length_mm)
        timing["cycles"] = known.get("cycles") or (OPEN if doubtful else _last_cycle(source, loops))
        if doubtful:
            remarks.append(doubt)
        if "time_s" not in columns and "sample_rate_Hz" in source:
            remarks.append(f"the header's {source['sample_rate_Hz']:g} samples per second stand for a column of time")
        if 2 * sum(drives_motion(loop) for loop in loops) > len(loops):
            signs["tangential_force_N"] = -1.0
            remarks.append("the force drives the motion as it is logged, so that factor = -1 turns it")
    normal = columns.get("normal_force_N", np.array([]))
    if np.isfinite(normal).any() and np.nanmedian(normal) < 0.0:
        signs["normal_force_N"] = -1.0
        remarks.append("the normal force is negative when pressing as it is logged, so that factor = -1 turns it")
    load, remark = _load(source, normal, known)
    amplitude, other = _amplitude(source, loops, known)
    key = "normal_load_N"
    if of_joint and load == OPEN and loops:
        ranges = [np.ptp(np.percentile(loop.tangential_force_N, [2.0, 98.0])) for loop in loops]
        key, load = FRICTION_FORCE, float(f"{0.5 * np.median(ranges):.3g}")
        remark = f"the friction force, {load:g} N, is that of the loops: state what you expected to have it judged"
    conditions = {key: load, "displacement_amplitude_um": amplitude} | timing
    return conditions, signs, [*(one for one in (remark, other) if one), *remarks]


def _clocked(columns: dict[str, Array]) -> tuple[dict[str, Array], Clock]:
    """Columns with repaired times, or without times if the clock does not show them, and the clock."""
    time, x = columns.get("time_s"), columns["displacement_um"]
    if time is None or time.shape != x.shape:
        return columns, Clock(time)
    parts = [columns[key].ravel() for key in ("repeat", "cycle") if key in columns and columns[key].shape == x.shape]
    clock = read_clock(time.ravel(), x.ravel(), columns["tangential_force_N"].ravel(), parts)
    rest = {key: own for key, own in columns.items() if key != "time_s"}
    return rest | ({} if clock.time_s is None else {"time_s": clock.time_s.reshape(x.shape)}), clock


def _open(source: dict[str, Any], key: str) -> bool:
    """True if the unit or factor of a column is open."""
    return OPEN in source["columns"].get(key, {}).values()


def _loops(text: GuessedFile, source: dict[str, Any], frequency: object, length_mm: float | None) -> list[MeasuredLoop]:
    """Loops as the import will read them; columns with an open unit keep the file's numbers."""
    whole = LoopSource(**source | {"columns": {key: shut(own) for key, own in source["columns"].items()}})
    # Without times, loops are split where the drive turns, whatever a cycle lasts.
    unknown = np.nan if "time_s" in source["columns"] or "sample_rate_Hz" in source else 1.0
    number = frequency if isinstance(frequency, int | float) else unknown
    loops = [loop.complete for loop in loops_of(text.path, whole, number, length_mm)[0]]
    return [loop for loop in loops if loop.time_s.size]


def frequency_of(columns: dict[str, Array], source: dict[str, Any], doubt_s: float = 0.0) -> tuple[float | None, str]:
    """Frequency of the drive in Hz, None if no times are stated, and a reason against numbering cycles by it ("" if
    there is none). columns: those read, in the record's units. source: table `[loops]` of the mapping. doubt_s:
    uncertainty of times across gaps in the log.
    """
    x = columns["displacement_um"]
    time = columns.get("time_s")
    if time is None and "sample_rate_Hz" in source:
        time = np.arange(x.shape[0]) / float(source["sample_rate_Hz"])
    if time is None:
        return None, ""
    if x.ndim == 2:
        whole = time[: max(x.shape)]
        return _rounded(even_period(whole[np.isfinite(whole)]), 6), ""
    cycle, known = columns.get("cycle"), np.isfinite(x) & np.isfinite(time)
    if cycle is not None:
        alone = [known & (cycle == number) for number in np.unique(cycle)[:20]]
        return _usual([(time[own], x[own]) for own in alone]), ""
    x, time = x[known], time[known]
    parts = split_cycles(x)
    steps = np.diff(time)
    usual = float(np.median(steps) * np.median([part.stop - part.start for part in parts]))
    gaps = np.flatnonzero(steps > 0.5 * usual) + 1
    if gaps.size:
        return _across_gaps(np.split(x, gaps), np.split(time, gaps), doubt_s)
    if len(parts) > 2:
        starts = time[[part.start for part in parts]]
        period = float(np.polyfit(np.arange(starts.size), starts, 1)[0])
        steady = np.all(steps >= 0.0) and np.ptp(time) > 2.5 * period > 0.0
        return _rounded(period_by_phase(time, x, period) if steady else period, 6), ""
    return _usual([(time[part], x[part]) for part in parts]), ""


def _usual(cycles: Sequence[tuple[Array, Array]]) -> float | None:
    """Frequency in Hz of cycles, (times, displacements) of each."""
    periods = [_period(time, x) for time, x in cycles if time.size >= _FEWEST]
    return _rounded(float(np.median(periods)), 6) if periods else None


def _period(time: Array, x: Array) -> float:
    """Period in s of one cycle: that of its sine or, where it is none, of samples evenly spread over it."""
    period = period_of(time, x)
    sine = series(time, period, 1)
    left = x - sine @ np.linalg.lstsq(sine, x, rcond=None)[0]
    return period if np.std(left) < _SINE * np.std(x) else even_period(time)


def _across_gaps(pieces: Sequence[Array], times: Sequence[Array], doubt_s: float) -> tuple[float | None, str]:
    """Frequency in Hz from a log in pieces, and a reason against numbering cycles by it ("" if there is none).

    It uses the cycles in each piece, and gaps that are known well enough to be a whole number of cycles.
    """
    whole = [(x[part], t[part]) for x, t in zip(pieces, times, strict=True) if x.size > 2 for part in split_cycles(x)]
    periods = [period_of(t, x) for x, t in whole]
    period = float(np.median(periods))
    quarter, rest = np.percentile(periods, [25.0, 75.0])
    unsure = max(float(rest - quarter), 0.5 * float(np.median(np.diff(whole[0][1])))) / period
    off = doubt_s / period
    starts, numbers = list[float](), [0]
    for x, t in whole:
        sine, cosine = np.linalg.lstsq(series(t, period, 1), x, rcond=None)[0][-1:-3:-1]
        starts.append(float(t[0] - period * np.arctan2(cosine, sine) / (2.0 * np.pi)))
        if len(starts) == 1:
            continue
        ahead = (starts[-1] - starts[-2]) / period
        # Gaps in a log that may be off a whole number of cycles by this share of one are not counted.
        if max(unsure * ahead / max(numbers[-1], 1), abs(ahead - round(ahead)) + off) > 0.25:
            about = _rounded(float(np.median(periods)), 3)
            message = f"the cycles within the pieces of the log, some {about:g} a second, do not show how many lie"
            return about, f"{message} between them: --frequency does it, as exactly as it is known"
        numbers.append(numbers[-1] + round(ahead))
        period = float(np.polyfit(numbers, starts, 1)[0])
    return _rounded(period, 7), ""


def _rounded(period: float, digits: int) -> float | None:
    return float(f"{1.0 / period:.{digits}g}") if np.isfinite(period) and period > 0.0 else None


def _load(source: dict[str, Any], normal: Array, known: Mapping[str, Any]) -> tuple[float | str, str]:
    if "normal_load_N" in known:
        return known["normal_load_N"], ""
    if _open(source, "normal_force_N") or not np.isfinite(normal).any():
        return OPEN, "the normal load, in newtons, is not stated: --normal-load does it, too"
    load = abs(float(f"{np.nanmedian(normal):.3g}"))
    return load, f"the normal load, {load:g} N, is the median of the measured one"


def _amplitude(
    source: dict[str, Any], loops: Sequence[MeasuredLoop], known: Mapping[str, Any]
) -> tuple[float | str, str]:
    if "displacement_amplitude_um" in known:
        return known["displacement_amplitude_um"], ""
    if _open(source, "displacement_um") or not loops:
        return OPEN, "the displacement amplitude, half the stroke in µm, is not stated: --amplitude does it, too"
    # Loops that are analysed for it, from first to last: a second or two.
    amplitudes = [_amplitude_of(loop) for loop in loops[:: -(-len(loops) // 25)]]
    amplitude = float(f"{np.median(amplitudes):.3g}")
    # Amplitudes of a test's cycles that differ by more than this share of the largest are a programme of their own.
    if min(amplitudes) < (1.0 - 0.1) * max(amplitudes):
        message = f"amplitudes of the loops go from {min(amplitudes):.3g} to {max(amplitudes):.3g} µm"
        return amplitude, f"the {message}; their median stands in the mapping"
    try:
        AMPLITUDE_um(amplitude)
    except ValueError as problem:
        return OPEN, f"the displacement amplitude, that of the loops, {problem}: is the unit of its column wrong?"
    return amplitude, f"the displacement amplitude, {amplitude:g} µm, is that of the loops"


def _amplitude_of(loop: MeasuredLoop) -> float:
    """Displacement amplitude in µm, between the drive's reversals and not the outermost noisy samples."""
    whole = loop.complete
    signals = whole.displacement_um, whole.tangential_force_N, whole.normal_force_N
    try:
        return 0.5 * read_loop(*signals, time_s=whole.time_s).length_um
    except LoopError:
        return 0.5 * float(np.ptp(np.percentile(loop.displacement_um, [0.2, 99.8])))


def _last_cycle(source: dict[str, Any], loops: Sequence[MeasuredLoop]) -> int:
    pattern, files = source.get("name_pattern"), source["files"]
    if pattern is not None and "(?P<cycle>" in pattern and not isinstance(files, str):
        found = [re.search(pattern, name) for name in files]
        return max(1, *(int(match["cycle"]) for match in found if match))
    return max([1, *(loop.cycle for loop in loops)])
