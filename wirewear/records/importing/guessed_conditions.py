"""What a laboratory's first file tells of the test: load, amplitude, frequency, cycles, and the force's sign."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wirewear.errors import RecordError
from wirewear.files.guessing import GuessedLayout
from wirewear.files.spellings import DELIMITERS
from wirewear.loops.area import enclosed_area
from wirewear.quantity import FIELD_UNITS
from wirewear.records.importing.mapping import ColumnMapping, Source
from wirewear.records.importing.sources import read_source

Array = NDArray[np.float64]

#: Fewer samples tell nothing.
FEWEST = 16


@dataclass(frozen=True)
class GuessedFile:
    """A text with its layout and the columns that were recognised, names or numbers and units, by key of the record."""

    path: Path
    guessed: GuessedLayout
    columns: dict[str, tuple[str | int, str]] = field(default_factory=dict)


def spelling_of(guessed: GuessedLayout) -> dict[str, Any]:
    """The keys of a mapping that say how the text is spelled."""
    layout = guessed.layout
    delimiter = next(name for name, sign in DELIMITERS.items() if sign == layout.delimiter)
    spelled: dict[str, Any] = {"encoding": layout.encoding, "delimiter": delimiter, "decimal": layout.decimal}
    if layout.header_lines:
        spelled["header_lines"] = layout.header_lines
    if not layout.names_line:
        spelled["names_line"] = False
    if layout.lines_after_names:
        spelled["lines_after_names"] = layout.lines_after_names
    return spelled


def mapped_columns(text: GuessedFile) -> tuple[dict[str, Any], list[str]]:
    """A mapping's columns of a file, and what was assumed of their units."""
    columns: dict[str, Any] = {}
    remarks = []
    for key, (name, unit) in text.columns.items():
        columns[key] = {"column": name}
        suffix = key.rpartition("_")[2]
        if suffix in FIELD_UNITS:
            columns[key]["unit"] = unit or suffix
        if suffix in FIELD_UNITS and not unit:
            remarks.append(f"{text.path.name}: the column {name!r} has no unit; {suffix} is taken for it")
    return columns, remarks


def conditions_of(
    text: GuessedFile, source: dict[str, Any], known: dict[str, Any], length_mm: float | None = None
) -> tuple[dict[str, Any], dict[str, float], list[str]]:
    """Load, amplitude, frequency and cycles of the first file, the force's sign, and what was assumed."""
    columns = complete_columns(text, source, length_mm)
    x, remarks = columns["displacement_um"], []
    low, high = np.percentile(x, [0.2, 99.8])
    time, frequency = columns.get("time_s"), known.get("frequency_Hz")
    starts = _starts(x)
    if frequency is None:
        if time is None:
            raise RecordError("no column of time tells the frequency: give it by --frequency, in hertz.")
        frequency = _frequency(time, starts, columns.get("cycle"))
        if not (np.isfinite(frequency) and frequency > 0.0):
            raise RecordError(f"{text.path}: the times tell no frequency; give it by --frequency, in hertz.")
    load = known.get("normal_load_N")
    if load is None:
        if "normal_force_N" not in columns:
            raise RecordError("no column tells the normal load: give it by --normal-load, in newtons.")
        load = float(f"{np.median(columns['normal_force_N']):.3g}")
        remarks.append(f"the normal load, {load:g} N, is the median of the measured one")
    amplitude = known.get("displacement_amplitude_um")
    if amplitude is None:
        amplitude = float(f"{0.5 * (high - low):.3g}")
        remarks.append(f"the displacement amplitude, {amplitude:g} µm, is that of the loops")
    cycles = known.get("cycles") or int(columns["cycle"].max() if "cycle" in columns else _last_cycle(source, starts))
    conditions = {
        "normal_load_N": load,
        "displacement_amplitude_um": amplitude,
        "frequency_Hz": frequency,
        "cycles": max(cycles, 1),
    }
    one = slice(0, None)
    if "cycle" in columns:
        one = slice(0, int(np.argmax(columns["cycle"] != columns["cycle"][0])) or None)
    elif starts.size > 2:
        one = slice(int(starts[0]), int(starts[1]))
    drives = enclosed_area(x[one], columns["tangential_force_N"][one]) < 0.0
    if drives:
        remarks.append("the force drives the motion as it is logged, so that factor = -1 turns it")
    return conditions, {"factor": -1.0} if drives else {}, remarks


def complete_columns(text: GuessedFile, source: dict[str, Any], length_mm: float | None = None) -> dict[str, Array]:
    """Columns of a file's complete samples, in the record's units; `length_mm` of a line contact.

    Raises:
        RecordError: there are too few of them, or the displacement never changes.
    """
    wanted = {key: ColumnMapping(**column) for key, column in source["columns"].items()}
    columns = read_source(text.path, Source(files=(text.path.name,), **spelling_of(text.guessed)), wanted, length_mm)
    keep: NDArray[np.bool_] = np.logical_and.reduce([np.isfinite(values) for values in columns.values()])
    columns = {key: values[keep] for key, values in columns.items()}
    x = columns["displacement_um"]
    if x.size < FEWEST or np.ptp(x) <= 0.0:
        raise RecordError(f"{text.path}: {x.size} complete samples of a displacement tell no loop.")
    return columns


def _starts(x: Array) -> NDArray[np.intp]:
    """Samples at which a displacement passes its middle upwards, after having been below it by a quarter."""
    low, high = np.percentile(x, [0.2, 99.8])
    level = (x - 0.5 * (low + high)) / max(0.5 * (high - low), 1e-300)
    state = np.where(level > 0.3, 1, np.where(level < -0.3, -1, 0))
    places = np.flatnonzero(state)
    rises = places[1:][(state[places][1:] > 0) & (state[places][:-1] < 0)]
    return np.asarray(rises)


def _frequency(time: Array, starts: NDArray[np.intp], cycle: Array | None) -> float:
    """Cycles a second: of a log of many cycles by their starts, of one by its length."""
    if cycle is not None:
        lengths = []
        for number in np.unique(cycle)[:20]:
            own = time[cycle == number]
            lengths.append(float(np.ptp(own)) * own.size / max(own.size - 1, 1))
        return float(f"{_reciprocal(float(np.median(lengths))):.6g}")
    if starts.size >= 3:
        return float(f"{_reciprocal(float(np.polyfit(np.arange(starts.size), time[starts], 1)[0])):.6g}")
    return float(f"{(time.size - 1) / time.size * _reciprocal(float(np.ptp(time))):.4g}")


def _reciprocal(value: float) -> float:
    return 1.0 / value if value > 0.0 else np.nan


def _last_cycle(source: dict[str, Any], starts: NDArray[np.intp]) -> int:
    pattern, files = source.get("name_pattern"), source["files"]
    if pattern is None or "(?P<cycle>" not in pattern or isinstance(files, str):
        return int(starts.size) or 1
    found = [re.search(pattern, name) for name in files]
    return max(int(match["cycle"]) for match in found if match)
