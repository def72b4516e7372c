"""Loops of any CSV file: columns chosen by name and unit, or recognised by their usual names."""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wirewear.errors import RecordError
from wirewear.loops.loop_report.values import SampledLoop
from wirewear.quantity import shown
from wirewear.records.columns import Column, column_names, read_columns
from wirewear.records.importing.mapping import UNITS

#: Usual names of a channel, without their unit, in order of preference.
USUAL_NAMES = {
    "displacement": ("displacement", "relative_displacement", "disp", "delta", "position", "x"),
    "force": ("tangential_force", "friction_force", "tangential", "force", "ft", "q"),
    "normal load": ("normal_force", "normal_load", "fn", "p"),
    "time": ("time", "t"),
}
_UNIT_OF = {"displacement": "um", "force": "N", "normal load": "N", "time": "s"}
_OPTIONS = {"displacement": "--displacement", "force": "--force", "normal load": "--normal-load"}
_LARGEST = 1e15


def csv_loops(
    path: Path, displacement: str | None = None, force: str | None = None, normal_load: str | None = None
) -> tuple[SampledLoop, ...]:
    """Loops of a CSV file, split by its columns `repeat` and `cycle` if it has them.

    Args:
        path: file whose first line names the columns.
        displacement: "COLUMN" or "COLUMN:UNIT"; None to recognise it.
        force: the same.
        normal_load: the same, or a number in N; None to recognise it, and to do without where none is.

    Raises:
        RecordError: the file cannot be read, or a column or its unit cannot be told.
    """
    names = column_names(path)
    constant = _number(normal_load)
    chosen = {
        "displacement": _channel(path, names, "displacement", displacement),
        "force": _channel(path, names, "force", force),
    }
    optional = [("time", None)] + ([("normal load", normal_load)] if constant is None else [])
    for channel, asked in optional:
        if asked is not None or _recognised(names, channel):
            chosen[channel] = _channel(path, names, channel, asked)
    keys = [name for name in ("repeat", "cycle") if name in names]
    columns = dict.fromkeys(name for name, _ in chosen.values())
    wanted = [Column(name, -_LARGEST, _LARGEST) for name in columns]
    table = read_columns(path, [*wanted, *(Column(key, 0, 1e12, whole=True, complete=True) for key in keys)])
    channels = {channel: table.columns[name] * factor for channel, (name, factor) in chosen.items()}
    return tuple(_loops(channels, {key: table.columns[key] for key in keys}, constant))


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


def _channel(path: Path, names: Sequence[str], channel: str, asked: str | None) -> tuple[str, float]:
    """Column of a channel, and the factor to the unit used inside."""
    unit: str | None = None
    if asked is None:
        found = _recognised(names, channel)
        if not found:
            raise RecordError(
                f"{path}, line 1: none of the columns {shown(', '.join(names))} is known as the {channel}; "
                f"name it by {_OPTIONS[channel]} COLUMN:UNIT."
            )
        name = found[0]
    elif asked in names:
        name = asked
    else:
        name, _, unit = asked.rpartition(":")
        if name not in names:
            raise RecordError(f"{path}, line 1: there is no column {name or asked!r} among {shown(', '.join(names))}.")
    known = UNITS[_UNIT_OF[channel]]
    unit = unit or _stem_and_unit(name, known)[1]
    if unit is None and channel == "time":
        unit = "s"
    if unit is None or unit not in known:
        said = "has no unit in its name" if unit is None else f"cannot be in {unit!r}"
        raise RecordError(
            f"{path}: the column {name!r} {said}; write {_OPTIONS[channel]} {name}:UNIT with one of {', '.join(known)}."
        )
    return name, known[unit]


def _recognised(names: Sequence[str], channel: str) -> list[str]:
    """Columns of a usual name, the most usual first."""
    known = UNITS[_UNIT_OF[channel]]
    stems = [_stem_and_unit(name, known)[0] for name in names]
    return [names[stems.index(usual)] for usual in USUAL_NAMES[channel] if usual in stems]


def _stem_and_unit(name: str, known: dict[str, float]) -> tuple[str, str | None]:
    """``"Tangential force [N]"`` and ``"tangential_force_N"`` as ``("tangential_force", "N")``."""
    match = re.fullmatch(r"(.+?)[\s_]*[_\[(\s]([^\s_\[\]()]+)[\])]?", name)
    stem, unit = (match[1], match[2]) if match and match[2] in known else (name, None)
    return re.sub(r"[\s_]+", "_", stem.strip().lower()), unit


def _loops(
    channels: dict[str, NDArray[np.float64]], keys: dict[str, NDArray[np.float64]], constant: float | None
) -> Iterator[SampledLoop]:
    count = len(channels["displacement"])
    numbers = [keys.get(key, np.ones(count)).astype(np.int64) for key in ("repeat", "cycle")]
    complete: NDArray[np.bool_] = np.logical_and.reduce([np.isfinite(values) for values in channels.values()])
    for repeat, cycle in np.unique(np.stack(numbers), axis=1).T:
        rows = complete & (numbers[0] == repeat) & (numbers[1] == cycle)
        normal = channels["normal load"][rows] if "normal load" in channels else constant
        time = channels["time"][rows] if "time" in channels else None
        yield SampledLoop(
            int(repeat), int(cycle), channels["displacement"][rows], channels["force"][rows], normal, time
        )
