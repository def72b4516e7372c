"""Loops from any source: a record, a result, or a logger's file with stated or recognised columns."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Array
from wirewear.base.delimited import CSV
from wirewear.base.errors import RecordError
from wirewear.base.files import DELIMITERS, TABLE_FILE_NAME
from wirewear.base.guessing import GuessedLayout, NoTableError, guessed_layout
from wirewear.base.naming import states_factor
from wirewear.base.recognising import Held, require_no_other
from wirewear.base.units import FIELD_UNITS
from wirewear.base.words import nearest, shown
from wirewear.loops.cleaning import FEWEST_SAMPLES
from wirewear.loops.clock import read_clock
from wirewear.loops.cycles import split_cycles
from wirewear.loops.outline import outline
from wirewear.records import read_record
from wirewear.records.columns import column_names
from wirewear.records.exporting import chosen_run
from wirewear.records.importing.guessed_columns import GuessedFile, loop_columns, rivals, unread
from wirewear.records.importing.guessed_files import table_of
from wirewear.records.importing.importing import in_rows
from wirewear.records.importing.loggers import kind_of
from wirewear.records.importing.sources import require_recorded
from wirewear.records.importing.text_reader import TextReader
from wirewear.records.normal_force import require_pressing
from wirewear.records.remarks import plural
from wirewear.records.values import MeasuredLoop
from wirewear.results import read_results

#: Channels by their keys: in words, and the option that names its column.
_CHANNELS = {
    "displacement_um": ("displacement", "--displacement"),
    "tangential_force_N": ("force", "--force"),
    "normal_force_N": ("normal load", "--normal-load"),
}

SPLIT = (
    "no column counts the cycles: the samples were split at the reversals of the displacement into {}, and {} samples "
    "were left over"
)


@dataclass(frozen=True, eq=False)
class SampledLoop:
    """Samples (n,) of one cycle of a repeat.

    normal_load_N: (n,), one number or None if unknown. time_s: (n,), or None if unknown. notes: sentences on how the
    cycle was found. numbered: True if the source says which cycle of the test it is.
    """

    repeat: int
    cycle: int
    displacement_um: Array
    tangential_force_N: Array
    normal_load_N: Array | float | None
    time_s: Array | None
    notes: tuple[str, ...] = ()
    numbered: bool = True

    @classmethod
    def of(cls, loop: MeasuredLoop, load_N: float | None) -> "SampledLoop":
        """A loop of a record; load_N: stands in for a normal force that was not measured."""
        normal = load_N if loop.normal_force_N is None else loop.normal_force_N
        return cls(loop.repeat, loop.cycle, loop.displacement_um, loop.tangential_force_N, normal, loop.time_s)


@dataclass(frozen=True)
class Spelling:
    """Stated parts of a text's layout; None is guessed from its first lines. delimiter: a name in DELIMITERS."""

    encoding: str | None = None
    delimiter: str | None = None
    decimal: str | None = None
    header_lines: int | None = None
    lines_after_names: int | None = None

    def layout(self, path: Path) -> GuessedLayout | None:
        """Layout of a file, guessed except for the stated parts; None if nothing is stated. Raises RecordError if the
        file cannot be read, or no line names its columns.
        """
        given = {key: value for key, value in vars(self).items() if value is not None}
        if not given:
            return None
        try:
            guessed = guessed_layout(path)
        except NoTableError:
            guessed = GuessedLayout(CSV, (), ())
        layout = guessed.layout if guessed.names else replace(guessed.layout, names_line=True)
        if self.delimiter is not None:
            given["delimiter"] = DELIMITERS[self.delimiter]
        layout = replace(layout, **given)
        names = column_names(path, layout)
        units = guessed.units if guessed.names == names else ("",) * len(names)
        return replace(guessed, layout=layout, names=names, units=units, width=len(names), tables=())


def logged_loops(
    path: Path,
    displacement: str | None = None,
    force: str | None = None,
    normal_load: str | None = None,
    spelling: Spelling | None = None,
) -> tuple[SampledLoop, ...]:
    """Loops of a logger's file, split by its columns of repeat and cycle, or else at the drive's reversals.

    path: a text, or a file of MATLAB or LabVIEW. displacement, force: "COLUMN" or "COLUMN:UNIT", the column by its name
    or number; None to recognise it. normal_load: a column in this form, or a number in N; None to recognise a column,
    if there is one. spelling: known parts of a text's layout; None to guess it. Raises RecordError if the file cannot
    be read, or a column or its unit cannot be identified.
    """
    file = table_of(path, spelling.layout(path) if spelling else None)
    constant = _number(normal_load)
    asked = {"displacement_um": displacement, "tangential_force_N": force}
    asked |= {"normal_force_N": normal_load} if constant is None else {}
    known = loop_columns(file)
    chosen = {key: _column(file, known, key, own) for key, own in asked.items() if own is not None or key in known}
    for key in ("displacement_um", "tangential_force_N"):
        chosen[key] = chosen.get(key) or _column(file, known, key, None)
    free = {key: own for key, own in known.items() if own[0] not in {name for name, _ in chosen.values()}}
    chosen |= {"time_s": (free["time_s"][0], free["time_s"][1] or "s")} if "time_s" in free else {}
    columns: dict[str, Any] = {key: {"column": name, "unit": unit} for key, (name, unit) in chosen.items()}
    columns |= {key: {"column": free[key][0]} for key in ("repeat", "cycle") if key in free}
    passed_over = (note for key, note in rivals(file, known).items() if key in chosen and asked.get(key) is None)
    remarks = (*file.remarks, *passed_over, *unread(file, known))
    return tuple(_loops(path, in_rows(path, file.read(columns)), constant, remarks))


def _number(text: str | None) -> float | None:
    try:
        value = float(text) if text is not None else None
    except ValueError:
        return None
    if value is not None and not 0.0 < value < np.inf:
        raise RecordError(f"--normal-load must be a positive number of newtons or a column, not {text}.")
    return value


def _column(
    file: GuessedFile, recognised: Mapping[str, tuple[str | int, str]], key: str, asked: str | None
) -> tuple[str | int, str]:
    (channel, option), known = _CHANNELS[key], FIELD_UNITS[key.rpartition("_")[2]]
    names = [str(name) for name in file.references]
    among = shown(", ".join(names))
    if asked is None:
        if key not in recognised:
            encoding = file.spelling.get("encoding", "utf-8")
            doubt = "" if encoding.startswith("utf") else f", or another --encoding than {encoding}, which is a guess"
            if factored := next((title for title in file.titles if states_factor(title)), ""):
                doubt += f"; {factored!r} states a factor, which only a mapping takes (`wirewear new --mapping`)"
            raise RecordError(
                f"{file.path}: none of the columns {among} is known as the {channel}; name it by {option} COLUMN:UNIT"
                f"{doubt}."
            )
        name, unit = recognised[key]
    else:
        own, _, unit = asked.rpartition(":") if asked not in names and ":" in asked else (asked, "", "")
        if own.isdecimal() and own not in names and 0 < int(own) <= len(names):
            own = names[int(own) - 1]
        if own not in names:
            hint = f"; did you mean {like!r}?" if (like := nearest(own or asked, names)) else "."
            raise RecordError(f"{file.path}: there is no column {own or asked!r} among {among}{hint}")
        place = names.index(own)
        name, unit = file.references[place], unit or ("" if states_factor(own) else file.unit(place, channel))
    if unit not in known:
        said = f"cannot be in {unit!r}" if unit else "has no unit in its name"
        raise RecordError(
            f"{file.path}: the column {name!r} {said}; write {option} {name}:UNIT with one of {', '.join(known)}."
        )
    return name, unit


def _loops(
    path: Path, channels: dict[str, Array], constant: float | None, remarks: tuple[str, ...]
) -> Iterator[SampledLoop]:
    if "cycles" in channels and "cycle" not in channels:
        channels["cycle"] = channels["cycles"] + 1.0
    if "time_s" in channels:
        numbers = [channels[key] for key in ("repeat", "cycle") if key in channels]
        clock = read_clock(channels["time_s"], channels["displacement_um"], channels["tangential_force_N"], numbers)
        remarks = (*remarks, clock.note) if clock.note else remarks
        channels = {key: own for key, own in channels.items() if key != "time_s"}
        channels |= {} if clock.time_s is None else {"time_s": clock.time_s}
    count = len(channels["displacement_um"])
    keys = {key: channels.get(key, np.ones(count)) for key in ("repeat", "cycle")}
    require_recorded(path, **keys)
    finite = np.isfinite([own for key, own in channels.items() if own.dtype == np.float64])
    complete, measured = finite.all(axis=0), finite[[key in _CHANNELS for key in channels]].any(axis=0)
    if lacking := np.count_nonzero(measured & ~complete):
        remarks = (*remarks, f"{plural(int(lacking), 'sample')} without a number were left out")
    repeats, cycles = (own.astype(np.int64) for own in keys.values())
    for repeat, cycle in np.unique(np.stack([repeats, cycles]), axis=1).T:
        rows = np.flatnonzero(complete & (repeats == repeat) & (cycles == cycle))
        parts = [rows] if "cycle" in channels else _cycles(rows, channels)
        left = rows.size - sum(part.size for part in parts)
        whole = f"{len(parts)} whole cycle{'s' if len(parts) > 1 else ''}"
        note = (SPLIT.format(whole, left),) if left or len(parts) > 1 else ()
        for number, part in enumerate(parts):
            normal = channels["normal_force_N"][part] if "normal_force_N" in channels else constant
            time = channels["time_s"][part] if "time_s" in channels else None
            own = channels["displacement_um"][part], channels["tangential_force_N"][part]
            notes = (*remarks, *note)
            yield SampledLoop(int(repeat), int(cycle) + number, *own, normal, time, notes, "cycle" in channels)


def _cycles(rows: NDArray[np.intp], channels: dict[str, Array]) -> list[NDArray[np.intp]]:
    """Indices of the rows of each whole cycle; of all rows if they are one cycle, or points in no order of time."""
    if rows.size < 2 * FEWEST_SAMPLES:
        return [rows]
    displacement = channels["displacement_um"]
    if "time_s" in channels:
        rows = rows[np.argsort(channels["time_s"][rows], kind="stable")]
    elif outline(displacement[rows], channels["tangential_force_N"][rows]) is not None:
        return [rows]
    parts = [rows[part] for part in split_cycles(displacement[rows])]
    return parts if min(part.size for part in parts) >= FEWEST_SAMPLES else [rows]


def read_loops(
    path: Path,
    *,
    cycle: int | None = None,
    variant: str | None = None,
    displacement: str | None = None,
    force: str | None = None,
    normal_load: str | None = None,
    spelling: Spelling | None = None,
) -> tuple[SampledLoop, ...]:
    """Loops of a logger's file, a record's folder, a result file or a run's folder.

    cycle: the only cycle wanted; None for all. variant: which run, if a folder holds several. displacement, force,
    normal_load, spelling: for a logger's file, see `logged_loops`. Raises RecordError if the source cannot be read, has
    no loop of that cycle, or an option does not apply to it; ResultError if the result cannot be read.
    """
    if not path.exists():
        raise RecordError(f"there is no file or folder {path}.")
    require_no_other(path, RecordError, Held.NUMBERS, Held.RECORD, Held.RUN)
    spelled = spelling is not None and any(value is not None for value in vars(spelling).values())
    is_record = path.name == TABLE_FILE_NAME or (path / TABLE_FILE_NAME).is_file()
    is_binary = path.is_file() and kind_of(path) != TextReader.kind
    is_result = not is_record and not is_binary and (path.is_dir() or h5py.is_hdf5(path))
    if spelled and (is_record or is_binary or is_result):
        raise RecordError(
            f"--encoding, --delimiter, --decimal and the header's lines describe a text, which {path} is not."
        )
    if (is_record or is_result) and any(option is not None for option in (displacement, force, normal_load)):
        raise RecordError(
            f"--displacement, --force and --normal-load choose columns of a CSV file, which {path} is not."
        )
    if variant is not None and not is_result:
        raise RecordError(f"--variant chooses among the runs of a result, which {path} is not.")
    if is_record:
        record = read_record(path)
        stated, logged = record.tables.conditions.normal_load_N, [loop.complete for loop in record.loops]
        if not logged:
            raise RecordError(f"the record {record.name!r} holds no loops.")
        require_pressing(logged, stated, record.tables.length_mm)
        loops = tuple(SampledLoop.of(loop, stated) for loop in logged)
    elif is_result:
        result = chosen_run(read_results(path), variant, path)
        of = tuple(f"the forces are those of {said}" for said in (result.extent.said,) if said)
        loops = tuple(
            SampledLoop(
                1, loop.cycle, loop.displacement_um, loop.tangential_force_N, loop.normal_force_N, loop.time_s, of
            )
            for loop in result.loops
        )
    else:
        loops = logged_loops(path, displacement, force, normal_load, spelling)
    if cycle is None:
        return loops
    chosen = tuple(loop for loop in loops if loop.cycle == cycle)
    if not chosen:
        known = ", ".join(str(number) for number in sorted({loop.cycle for loop in loops})) or "none"
        raise RecordError(f"{path} has no loop of cycle {cycle}; there are: {known}.")
    return chosen
