"""Loops of a logger's file that is no plain CSV: columns by name or number, or recognised by their usual names."""

from dataclasses import replace
from pathlib import Path
from typing import Any

from wirewear.base.errors import RecordError
from wirewear.base.quantity import FIELD_UNITS, nearest, shown
from wirewear.records.importing.guessed_conditions import frequency_of
from wirewear.records.importing.guessed_files import GuessedFile, looked_into
from wirewear.records.importing.importing import loops_of
from wirewear.records.importing.mapping import LoopSource
from wirewear.views.loops_values import SampledLoop

_OPTIONS = {
    "displacement_um": "--displacement",
    "tangential_force_N": "--force",
    "normal_force_N": "--normal-load",
}


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
