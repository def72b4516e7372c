"""Where loops come from: a logger's file, an experiment record, or a result."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py

from wirewear.base.errors import RecordError
from wirewear.base.guessing import guessed_layout
from wirewear.base.quantity import FIELD_UNITS, nearest, shown
from wirewear.base.reading import TABLE_FILE_NAME, Held, require_no_other
from wirewear.records import read_record
from wirewear.records.exporting import chosen_run
from wirewear.records.importing.guessed_conditions import frequency_of
from wirewear.records.importing.guessed_files import GuessedFile, looked_into
from wirewear.records.importing.importing import loops_of
from wirewear.records.importing.mapping import LoopSource
from wirewear.records.importing.reader import TextReader
from wirewear.records.importing.registry import kind_of
from wirewear.records.normal_force import require_pressing
from wirewear.results import read_results
from wirewear.views.loops_csv import SampledLoop, Spelling, csv_loops

_OPTIONS = {"displacement_um": "--displacement", "tangential_force_N": "--force", "normal_force_N": "--normal-load"}


def logged_loops(
    path: Path, displacement: str | None = None, force: str | None = None, normal_load: str | None = None
) -> tuple[SampledLoop, ...]:
    """Loops of MATLAB's or LabVIEW's file, or of a text without names, split into cycles as an import does.

    Args:
        path: the file.
        displacement: "COLUMN:UNIT", or "COLUMN" of a file that tells units; None to recognise it.
        force: the same.
        normal_load: the same, or a number in N; None to recognise it, and to do without where none is.

    Raises:
        RecordError: the file cannot be read, or a column or its unit cannot be told.
    """
    file = looked_into(path)
    constant = _number(normal_load)
    asked = {
        "displacement_um": displacement,
        "tangential_force_N": force,
        "normal_force_N": normal_load if constant is None else None,
    }
    columns: dict[str, Any] = {key: {"column": own[0]} for key, own in file.columns.items() if key not in _OPTIONS}
    for key, own in asked.items():
        if key == "normal_force_N" and (constant is not None or (own is None and key not in file.columns)):
            continue
        name, unit = _column(file, key, own)
        columns[key] = {"column": name, "unit": unit}
    read = file.read({key: columns[key] for key in columns.keys() & {"displacement_um", "time_s", "cycle"}})
    source = LoopSource(files=(path.name,), **file.spelling, columns=columns)
    # Without a time, cycles are told by the reversals alone.
    found = loops_of(path, source, frequency_of(read, {}) or 1.0)
    loops = [replace(SampledLoop.of(one.complete, constant), notes=file.remarks) for one in found]
    return tuple(loops if "time_s" in columns else (replace(loop, time_s=None) for loop in loops))


def _number(text: str | None) -> float | None:
    try:
        return float(text) if text is not None else None
    except ValueError:
        return None


def _column(file: GuessedFile, key: str, asked: str | None) -> tuple[str | int, str]:
    """Name and unit of a channel."""
    option, known = _OPTIONS[key], FIELD_UNITS[key.rpartition("_")[2]]
    names = [str(name) for name in file.references]
    if asked is None:
        if key not in file.columns:
            raise RecordError(
                f"{file.path}: which of {shown(', '.join(names))} is it? Write {option} COLUMN:UNIT with one of them."
            )
        name, unit = file.columns[key]
    else:
        name, _, unit = (asked, "", "") if asked in names else asked.rpartition(":")
        if name not in names:
            hint = f"; did you mean {like!r}?" if (like := nearest(str(name) or asked, names)) else "."
            raise RecordError(
                f"{file.path}: there is no column {name or asked!r} among {shown(', '.join(names))}{hint}"
            )
        place = names.index(str(name))
        name, unit = file.references[place], unit or file.units[place]
    if unit not in known:
        said = f"cannot be in {unit!r}" if unit else "has no unit"
        raise RecordError(
            f"{file.path}: the column {name!r} {said}; write {option} {name}:UNIT with one of {', '.join(known)}."
        )
    return name, unit


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
    """Loops of a CSV file (see `csv_loops`), a record's folder, a result file or a run's folder.

    Args:
        path: file or folder.
        cycle: the only cycle wanted; None for all.
        variant: which run, where a folder holds several.
        displacement: column of a CSV file.
        force: the same.
        normal_load: the same, or a number in N.
        spelling: what is known of a CSV file's layout.

    Raises:
        RecordError: the source cannot be read, has no loop of that cycle, or an option does not belong to it.
        ResultError: the result cannot be read.
    """
    if not path.exists():
        raise RecordError(f"there is no file or folder {path}.")
    require_no_other(path, RecordError, Held.NUMBERS, Held.RECORD, Held.RUN)
    if path.name == TABLE_FILE_NAME or (path / TABLE_FILE_NAME).is_file():
        _no_columns(path, spelling, displacement, force, normal_load)
        _no_variant(path, variant)
        loops = _record_loops(path)
    elif path.is_file() and kind_of(path) != TextReader.kind:
        _no_variant(path, variant)
        _no_spelling(path, spelling)
        loops = logged_loops(path, displacement, force, normal_load)
    elif path.is_dir() or h5py.is_hdf5(path):
        _no_columns(path, spelling, displacement, force, normal_load)
        loops = _result_loops(path, variant)
    elif not _told(spelling) and _is_unusual(path):
        _no_variant(path, variant)
        loops = logged_loops(path, displacement, force, normal_load)
    else:
        _no_variant(path, variant)
        loops = csv_loops(path, displacement, force, normal_load, spelling)
    if cycle is None:
        return loops
    chosen = tuple(loop for loop in loops if loop.cycle == cycle)
    if not chosen:
        known = ", ".join(str(number) for number in sorted({loop.cycle for loop in loops})) or "none"
        raise RecordError(f"{path} has no loop of cycle {cycle}; there are: {known}.")
    return chosen


def _is_unusual(path: Path) -> bool:
    """Whether a text names no columns, or holds times of day."""
    try:
        return not guessed_layout(path).plain
    except RecordError:
        return False


def _told(spelling: Spelling | None) -> bool:
    return spelling is not None and any(value is not None for value in vars(spelling).values())


def _no_spelling(path: Path, spelling: Spelling | None) -> None:
    if _told(spelling):
        raise RecordError(
            f"--encoding, --delimiter, --decimal and the header's lines tell of a text, which {path} is not."
        )


def _no_columns(path: Path, spelling: Spelling | None, *options: str | None) -> None:
    _no_spelling(path, spelling)
    if any(option is not None for option in options):
        raise RecordError(
            f"--displacement, --force and --normal-load choose columns of a CSV file, which {path} is not."
        )


def _no_variant(path: Path, variant: str | None) -> None:
    if variant is not None:
        raise RecordError(f"--variant chooses among the runs of a result, which {path} is not.")


def _record_loops(path: Path) -> tuple[SampledLoop, ...]:
    record = read_record(path)
    stated, loops = record.tables.conditions.normal_load_N, [loop.complete for loop in record.loops]
    if not loops:
        raise RecordError(f"the record {record.name!r} holds no loops.")
    require_pressing(loops, stated, record.tables.length_mm)
    return tuple(SampledLoop.of(loop, stated) for loop in loops)


def _result_loops(path: Path, variant: str | None) -> tuple[SampledLoop, ...]:
    result = chosen_run(read_results(path), variant, path)
    of = (f"the forces are those of {result.length_mm:g} mm of the contact",) if result.length_mm else ()
    return tuple(
        SampledLoop(1, loop.cycle, loop.displacement_um, loop.tangential_force_N, loop.normal_force_N, loop.time_s, of)
        for loop in result.loops
    )
