"""Loops of any CSV file: columns chosen by name and unit, or recognised by their usual names."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Array, BoolArray
from wirewear.base.delimited import CSV
from wirewear.base.errors import RecordError
from wirewear.base.guessing import GuessedLayout, NoTableError, guessed_layout
from wirewear.base.quantity import FIELD_UNITS, nearest, shown
from wirewear.base.reading import DELIMITERS
from wirewear.loops.cleaning import FEWEST_SAMPLES
from wirewear.loops.cycles import split_cycles
from wirewear.loops.digitised import outline
from wirewear.records.columns import Column, column_names, read_columns
from wirewear.records.importing.usual_names import UNIT_OF, recognised, stem_and_unit
from wirewear.records.values import MeasuredLoop

_OPTIONS = {"displacement": "--displacement", "force": "--force", "normal load": "--normal-load"}
_LARGEST = 1e15

SPLIT = (
    "no column counts the cycles: the samples were split at the reversals of the displacement into {}, and {} samples "
    "were left over"
)


@dataclass(frozen=True, eq=False)
class SampledLoop:
    """Samples of one cycle, arrays (n,); `normal_load_N` may be one number or unknown, `time_s` unknown.

    `notes` say how the cycle was told.
    """

    repeat: int
    cycle: int
    displacement_um: Array
    tangential_force_N: Array
    normal_load_N: Array | float | None
    time_s: Array | None
    notes: tuple[str, ...] = ()

    @classmethod
    def of(cls, loop: MeasuredLoop, load_N: float | None) -> SampledLoop:
        """A record's loop, under that load where none was measured."""
        normal = load_N if loop.normal_force_N is None else loop.normal_force_N
        return cls(loop.repeat, loop.cycle, loop.displacement_um, loop.tangential_force_N, normal, loop.time_s)


@dataclass(frozen=True)
class Spelling:
    """How a text is laid out, as far as it is told; the rest is guessed from its first lines.

    `delimiter` is a name of DELIMITERS.
    """

    encoding: str | None = None
    delimiter: str | None = None
    decimal: str | None = None
    header_lines: int | None = None
    lines_after_names: int | None = None

    def layout(self, path: Path) -> GuessedLayout:
        """The layout of a file.

        Raises:
            RecordError: the file cannot be read.
        """
        try:
            guessed = guessed_layout(path)
        except NoTableError:
            guessed = GuessedLayout(CSV, (), ())
        layout = guessed.layout if guessed.names else replace(guessed.layout, names_line=True)
        told = {key: value for key, value in vars(self).items() if value is not None}
        if self.delimiter is not None:
            told["delimiter"] = DELIMITERS[self.delimiter]
        return replace(guessed, layout=replace(layout, **told))


def csv_loops(
    path: Path,
    displacement: str | None = None,
    force: str | None = None,
    normal_load: str | None = None,
    spelling: Spelling | None = None,
) -> tuple[SampledLoop, ...]:
    """Loops of a CSV file, split by its columns of repeat and cycle, or else where the drive turns round.

    Args:
        path: file with a line that names the columns, and perhaps one of units below it.
        displacement: "COLUMN" or "COLUMN:UNIT", the column by its name or number; None to recognise it.
        force: the same.
        normal_load: the same, or a number in N; None to recognise it, and to do without where none is.
        spelling: what is known of its encoding, delimiter, decimal sign and header; None to guess all of it.

    Raises:
        RecordError: the file cannot be read, or a column or its unit cannot be told.
    """
    guessed = (spelling or Spelling()).layout(path)
    names, where = column_names(path, guessed.layout), f"{path}, line {guessed.layout.line_of_names}"
    units = dict(zip(guessed.names, guessed.units, strict=True)) if guessed.names == names else {}
    constant = _number(normal_load)
    chosen = {
        "displacement": _channel(where, names, units, "displacement", displacement),
        "force": _channel(where, names, units, "force", force),
    }
    optional = [("time", None)] + ([("normal load", normal_load)] if constant is None else [])
    for channel, asked in optional:
        if asked is not None or recognised(names, channel):
            chosen[channel] = _channel(where, names, units, channel, asked)
    free = [name for name in names if name not in {own for own, _ in chosen.values()}]
    keys = {key: found[0] for key in ("repeat", "cycle") if (found := recognised(free, key))}
    columns = dict.fromkeys(name for name, _ in chosen.values())
    wanted = [Column(name, -_LARGEST, _LARGEST) for name in columns]
    counted = [Column(name, 0, 1e12, whole=True, complete=True) for name in keys.values()]
    table = read_columns(path, [*wanted, *counted], guessed.layout)
    channels = {channel: table.columns[name] * factor for channel, (name, factor) in chosen.items()}
    return tuple(_loops(channels, {key: table.columns[name] for key, name in keys.items()}, constant))


def _number(text: str | None) -> float | None:
    if text is None:
        return None
    try:
        value = float(text)
    except ValueError:
        return None
    if not 0.0 < value < _LARGEST:
        raise RecordError(f"--normal-load must be a positive number of newtons or a column, not {text}.")
    return value


def _channel(
    where: str, names: Sequence[str], units: Mapping[str, str], channel: str, asked: str | None
) -> tuple[str, float]:
    """Column of a channel, and the factor to the unit used inside."""
    unit: str | None = None
    if asked is None:
        found = recognised(names, channel)
        if not found:
            raise RecordError(
                f"{where}: none of the columns {shown(', '.join(names))} is known as the {channel}; "
                f"name it by {_OPTIONS[channel]} COLUMN:UNIT."
            )
        name = found[0]
    elif asked in names:
        name = asked
    else:
        name, _, unit = asked.rpartition(":") if ":" in asked else (asked, "", None)
        if name.isdecimal() and name not in names and 0 < int(name) <= len(names):
            name = names[int(name) - 1]
        if name not in names:
            hint = f"; did you mean {like!r}?" if (like := nearest(name or asked, names)) else "."
            raise RecordError(f"{where}: there is no column {name or asked!r} among {shown(', '.join(names))}{hint}")
    known = FIELD_UNITS[UNIT_OF[channel]]
    unit = unit or stem_and_unit(name, known)[1] or units.get(name) or None
    if unit is None and channel == "time":
        unit = "s"
    if unit is None or unit not in known:
        said = "has no unit in its name" if unit is None else f"cannot be in {unit!r}"
        raise RecordError(
            f"{where}: the column {name!r} {said}; write {_OPTIONS[channel]} {name}:UNIT with one of "
            f"{', '.join(known)}."
        )
    return name, known[unit]


def _loops(channels: dict[str, Array], keys: dict[str, Array], constant: float | None) -> Iterator[SampledLoop]:
    count = len(channels["displacement"])
    numbers = [keys.get(key, np.ones(count)).astype(np.int64) for key in ("repeat", "cycle")]
    complete: BoolArray = np.logical_and.reduce([np.isfinite(values) for values in channels.values()])
    for repeat, cycle in np.unique(np.stack(numbers), axis=1).T:
        rows = np.flatnonzero(complete & (numbers[0] == repeat) & (numbers[1] == cycle))
        parts = [rows] if "cycle" in keys else _cycles(rows, channels)
        left = rows.size - sum(part.size for part in parts)
        whole = f"{len(parts)} whole cycle{'s' if len(parts) > 1 else ''}"
        note = (SPLIT.format(whole, left),) if left or len(parts) > 1 else ()
        for number, part in enumerate(parts):
            normal = channels["normal load"][part] if "normal load" in channels else constant
            time = channels["time"][part] if "time" in channels else None
            own = channels["displacement"][part], channels["force"][part]
            yield SampledLoop(int(repeat), int(cycle) + number, *own, normal, time, note)


def _cycles(rows: NDArray[np.intp], channels: dict[str, Array]) -> list[NDArray[np.intp]]:
    """The rows of each whole cycle; all of them where they are one, or points without an order of time."""
    if rows.size < 2 * FEWEST_SAMPLES:
        return [rows]
    if "time" in channels:
        rows = rows[np.argsort(channels["time"][rows], kind="stable")]
    elif outline(channels["displacement"][rows], channels["force"][rows]) is not None:
        return [rows]
    parts = [rows[part] for part in split_cycles(channels["displacement"][rows])]
    return parts if min(part.size for part in parts) >= FEWEST_SAMPLES else [rows]
