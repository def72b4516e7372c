"""Recognition of what a laboratory's file holds: loops, an evolution or a worn surface, by the names of its columns."""

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import groupby, permutations
from pathlib import Path
from typing import Any

import numpy as np

from geometry.arrays import Array
from wirewear.base.delimited import CSV, DelimitedLayout
from wirewear.base.errors import RecordError
from wirewear.base.files import DELIMITERS
from wirewear.base.guessing import GuessedLayout, guessed_layout
from wirewear.base.naming import UNIT_OF, recognised, units_of
from wirewear.base.units import FIELD_UNITS
from wirewear.records.importing.guessed_columns import (
    EVOLUTION_KEYS,
    LOOP_KEYS,
    SURFACE_KEYS,
    GuessedFile,
    loop_columns,
    rivals,
    taken_columns,
    unread,
    values_of,
)
from wirewear.records.importing.loggers import kind_of, readers
from wirewear.records.importing.text_reader import TextReader
from wirewear.test.bodies import OPEN

FEWEST = 16  #: Fewer samples show nothing.

#: Scars are smaller than this in millimetres and larger in micrometres; they are larger in millimetres than in metres.
SCAR_mm = 20.0


#: Units of which one is asked for, where none is stated.
_SUCH = {"um": "um, mm or inch", "N": "N, mN or gf", "mJ": "mJ, J or uJ", "s": "s, ms, or s with factor = 86400"}

_NEEDED = frozenset(("displacement_um", "tangential_force_N"))


def looked_into(path: Path) -> GuessedFile:
    """A file with its recognised contents. Raises RecordError if it cannot be read, holds no table of numbers, or has
    no columns for a displacement and a force.
    """
    file = table_of(path)
    if not file.named:
        return _line_of_heights(file) or _points_without_names(file)
    cycles = taken_columns(file, EVOLUTION_KEYS)
    if "cycle" in cycles and len(cycles.keys() - {"repeat"}) > 1 and _counts_each_once(file, cycles):
        return replace(file, holds="evolution", columns=cycles)
    surface, loops = taken_columns(file, SURFACE_KEYS), loop_columns(file)
    levels = surface.keys() & {"depth_um", "height_um"}
    if "x_um" in surface and (levels or "y_um" in surface) and "tangential_force_N" not in loops:
        if "depth_um" in levels:
            surface.pop("height_um", None)
        line = None if levels else _line_of_heights(file)
        return line or replace(file, holds="surface", columns=surface)
    if not loops and (line := _line_of_heights(file)):
        return line
    whole = loops.keys() >= _NEEDED and not ("cycle" in loops and _counts_each_once(file, loops))
    if not whole and len(loops.keys() & _NEEDED) == 1 and len(file.references) - len(loops.keys() - _NEEDED) < 2:
        return replace(file, holds="channel", columns=loops)
    grouped = any(":" in str(own) for own in file.references) and not loops
    if not whole and len(file.references) - len(loops.keys() - _NEEDED) < len(_NEEDED) and not grouped:
        raise RecordError(f"{path} has no columns for a displacement and a force")
    remarks = (*file.remarks, *rivals(file, loops).values(), *unread(file, loops))
    return replace(file, holds="loops" if whole else "unknown", columns=loops, remarks=remarks)


def table_of(path: Path, layout: GuessedLayout | None = None) -> GuessedFile:
    """A file with its columns before their contents are recognised; layout: of a text, None to guess it. Raises
    RecordError if it cannot be read, or holds no table of numbers.
    """
    kind = kind_of(path)
    if kind == TextReader.kind:
        guessed = layout or guessed_layout(path)
        numbers = tuple(range(1, guessed.width + 1))
        names, units = (own[: guessed.width] for own in (guessed.names, guessed.units))
        blank = ("",) * guessed.width
        references: tuple[str | int, ...] = numbers
        if guessed.layout.names_line:
            # Two columns of one name are distinguished by their numbers.
            references = tuple(n if names.count(name) > 1 else name for n, name in zip(numbers, names, strict=True))
        if guessed.width > FEWEST:
            references, names, units = _in_groups(path, references, names or blank, units or blank)
            blank = ("",) * len(references)
        files = [
            GuessedFile(
                path, "unknown", spelling_of(layout), references, names or blank, units or blank,
                sample_rate_Hz=guessed.sample_rate_Hz, step_um=guessed.step_um, words=guessed.words,
                remarks=guessed.remarks,
            )
            for layout in guessed.tables or (guessed.layout,)
        ]  # fmt: skip
        return _that_moves(files, guessed.tables)
    channels = readers()[kind].channels(path)
    if not channels:
        raise RecordError(f"{path} holds no variable of numbers.")
    names = tuple(channel.name for channel in channels)
    titles = tuple(name.replace("/", ".").rpartition(".")[2] for name in names)
    rate = next((channel.sample_rate_Hz for channel in channels if channel.sample_rate_Hz), None)
    return GuessedFile(
        path, "unknown", {"kind": kind}, names, titles, tuple(own.unit for own in channels), sample_rate_Hz=rate
    )


def _in_groups(
    path: Path, references: Sequence[str | int], names: Sequence[str], units: Sequence[str]
) -> tuple[tuple[str | int, ...], tuple[str, ...], tuple[str, ...]]:
    """References, titles and units of columns, with runs of columns that differ by their number combined to one
    channel.

    Such columns are samples of one cycle. Without names, the file's own name stands for the channel.
    """
    found: list[tuple[str | int, str, str]] = []
    place = 0
    for stem, group in groupby(re.sub(r"\d+", "", name) for name in names):
        count = len(list(group))
        title = re.sub(r"[\s_.]+(?=$|\s*[\[(])", "", stem) or path.stem
        if count >= FEWEST and (not stem or any(recognised([title], channel) for channel in LOOP_KEYS.values())):
            found.append((f"{place + 1}:{place + count}", title, units[place]))
        else:
            found += [(references[own], names[own], units[own]) for own in range(place, place + count)]
        place += count
    columns, titles, of_columns = zip(*found, strict=True)
    return columns, titles, of_columns


def joined(channels: Sequence[GuessedFile]) -> tuple[GuessedFile, ...]:
    """One file, in a tuple, that combines the two given files of a displacement and of its force; empty if there are
    others or they do not belong together.
    """
    pairs = [
        (first, second)
        for first, second in permutations(channels, 2)
        if "displacement_um" in first.columns and "tangential_force_N" in second.columns
    ]
    if len(pairs) != 1 or len(channels) != 2 or pairs[0][0].spelling != pairs[0][1].spelling:
        return ()
    first, second = pairs[0]
    shared = first.columns.keys() & second.columns.keys()
    for key in shared:
        one, other = (own.read({key: {"column": own.columns[key][0]}})[key] for own in pairs[0])
        if not np.array_equal(one, other, equal_nan=True):
            return ()
    columns = first.columns | {key: own for key, own in second.columns.items() if key not in shared}
    elsewhere = dict.fromkeys(columns.keys() - first.columns.keys(), second.path.name)
    remarks = (f"{second.path.name} holds the force to the displacement in {first.path.name}",)
    return (replace(first, holds="loops", columns=columns, elsewhere=elsewhere, remarks=remarks),)


def _that_moves(files: Sequence[GuessedFile], tables: Sequence[DelimitedLayout]) -> GuessedFile:
    """The table with the most motion among a file's tables, with a remark on those left out."""
    if not tables:
        return files[0]

    def motion(place: int) -> tuple[float, int]:
        found = recognised(files[place].titles, "displacement")
        x = values_of(files[place], found[0]) if found else np.zeros(1)
        return float(np.nansum(np.abs(np.diff(x)))), tables[place].most_rows or 0

    best = max(range(len(files)), key=motion)
    first, rows = (getattr(tables[best], key) for key in ("lines_before_rows", "most_rows"))
    message = f"{files[best].path.name}: lines {first + 1} to {first + rows} are read"
    if len(tables) > 1:
        others = ", ".join(str(own.line_of_names) for own in tables)
        message += f", the table with the most motion; {len(tables)} begin with the same names, in lines {others}"
    return replace(files[best], remarks=(*files[best].remarks, message))


def spelling_of(layout: DelimitedLayout) -> dict[str, object]:
    """Keys of a mapping that describe a text's layout; defaults are left out."""
    delimiter = next(name for name, sign in DELIMITERS.items() if sign == layout.delimiter)
    keys = {"header_lines": "header_lines", "names_line": "names_line", "lines_after_names": "lines_after_names"}
    keys |= {"rows": "most_rows", "blocks": "blocks"}
    stated = {key: getattr(layout, name) for key, name in keys.items() if getattr(layout, name) != getattr(CSV, name)}
    return {"encoding": layout.encoding, "delimiter": delimiter, "decimal": layout.decimal, **stated}


def _counts_each_once(file: GuessedFile, columns: dict[str, tuple[str | int, str]]) -> bool:
    """True if each cycle of each repeat has exactly one row."""
    keys = [key for key in ("repeat", "cycle") if key in columns]
    read = file.read({key: {"column": columns[key][0]} for key in keys})
    rows = np.stack([read[key].ravel() for key in keys]) if len({own.size for own in read.values()}) == 1 else None
    return rows is not None and rows.shape[1] > 0 and np.unique(rows, axis=1).shape[1] == rows.shape[1]


def _points_without_names(file: GuessedFile) -> GuessedFile:
    """File with three unnamed columns as x, y and height if they lie on a grid, with units guessed from the scar's
    size.
    """
    if len(file.references) != 3:
        return file
    points = file.read({key: {"column": place} for key, place in (("x", 1), ("y", 2), ("z", 3))})
    if not all(np.isfinite(values).any() for values in points.values()):
        return file
    if file.path.suffix.lower() != ".xyz" and not _on_grid(points["x"], points["y"]):
        return file
    x, y, z = (float(np.nanmax(values) - np.nanmin(values)) for values in points.values())
    across = "m" if max(x, y) < 1e-3 * SCAR_mm else "mm" if max(x, y) < SCAR_mm else "um"
    # No scar is higher than it is long.
    height = across if z < max(x, y) else "um"
    columns: dict[str, tuple[str | int, str]] = {"x_um": (1, across), "y_um": (2, across), "height_um": (3, height)}
    return replace(file, holds="surface", columns=columns)


def _line_of_heights(file: GuessedFile) -> GuessedFile | None:
    """File with one column as heights along a line, or two of which the first is monotonic; None for other files."""
    channels = ("height", "x")[: len(file.references)][::-1]
    if len(file.references) > 2 or any(":" in str(own) for own in file.references):
        return None
    if len(channels) == 2:
        steps = np.diff(values_of(file, 0))
        if not steps.size or not (np.all(steps > 0.0) or np.all(steps < 0.0)):
            return None
    columns = {f"{name}_um": (file.references[n], file.unit(n, name)) for n, name in enumerate(channels)}
    return replace(file, holds="surface", columns=columns)


def _on_grid(x: Array, y: Array) -> bool:
    """True if points form rows and columns."""
    columns, rows = (np.unique(values[np.isfinite(values)]).size for values in (x, y))
    return min(columns, rows) > 3 and 0.5 * columns * rows <= x.size <= columns * rows


def mapped_columns(text: GuessedFile, *, per_length: bool = False) -> tuple[dict[str, dict[str, object]], list[str]]:
    """Tables of a mapping for the columns of a guessed file, by key, and sentences on what the user must look at.

    A unit that the file does not state is left open, with a sentence, except that times are taken for seconds.
    per_length: units of forces and energies may be per millimetre of a line contact.
    """
    columns: dict[str, Any] = {}
    remarks = [*text.remarks]
    for key, (name, unit) in text.columns.items():
        columns[key] = {"column": name} | ({"file": text.elsewhere[key]} if key in text.elsewhere else {})
        suffix = key.rpartition("_")[2]
        if suffix not in FIELD_UNITS:
            continue
        channel = next(own for own, kept in UNIT_OF.items() if kept == suffix)
        known = units_of(channel) if per_length else FIELD_UNITS[suffix]
        if unit in known:
            columns[key]["unit"] = unit
        elif unit == "V":
            columns[key] |= {"unit": unit, "factor": OPEN}
            remarks.append(f"{text.path.name}: the column {name!r} is in volts; how many {suffix} is one volt?")
        elif suffix == "s" and not unit and not _since_an_epoch(text, name):
            columns[key]["unit"] = suffix
            remarks.append(f"{text.path.name}: the column {name!r} has no unit of time; seconds are taken for it")
        else:
            columns[key]["unit"] = OPEN
            wrong = f"is in {unit!r}, which is none of its units" if unit else "has no unit"
            remarks.append(f"{text.path.name}: the column {name!r} {wrong}; which is it, such as {_SUCH[suffix]}?")
    return columns, remarks


def _since_an_epoch(text: GuessedFile, name: str | int) -> bool:
    """True if times count from long before the test, such as days since 1900."""
    time = text.read({"time_s": {"column": name}})["time_s"]
    # A test that began after so many of its own lengths was not timed from its start.
    return bool(np.nanmin(time) > 1e3 * np.ptp(time[np.isfinite(time)]))
