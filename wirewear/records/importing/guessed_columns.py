"""Recognition of the columns of a laboratory's file by names, units and words, and remarks on columns not used.

A channel is a measured quantity such as "force"; a key is the name of a record's column. A value of a mapping is open
if the user must fill it in.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from geometry.arrays import Array
from wirewear.base.delimited import read_delimited
from wirewear.base.errors import RecordError
from wirewear.base.naming import KNOWN_UNITS, RAW_UNITS, UNIT_OF, recognised, states_factor, stem_and_unit, units_of
from wirewear.records.importing.mapping import ColumnMapping, Source
from wirewear.records.importing.sources import layout_of, read_source
from wirewear.test.bodies import OPEN

#: What parts samples has so few different values, over their number; columns that are looked at for that.
LABELLED, MOST_LABELS = 0.06, 40

ALIKE = 2e-3  #: Values of two columns that differ by less than this share of the largest one are the same.

#: The keys of a record's tables, and the channel that each is.
LOOP_KEYS = {
    "displacement_um": "displacement",
    "tangential_force_N": "force",
    "normal_force_N": "normal load",
    "time_s": "time",
    "cycle": "cycle",
    "repeat": "repeat",
}
EVOLUTION_KEYS = {
    "cycle": "cycle",
    "displacement_amplitude_um": "displacement amplitude",
    "slip_amplitude_um": "slip amplitude",
    "max_tangential_force_N": "largest force",
    "dissipated_energy_mJ": "energy",
    "repeat": "repeat",
}
SURFACE_KEYS = {"x_um": "x", "y_um": "y", "depth_um": "depth", "height_um": "height", "repeat": "repeat"}


@dataclass(frozen=True)
class GuessedFile:
    """A laboratory's file with the layout of its text and the columns recognised in it.

    holds: "loops", "evolution", "surface", "channel" (displacement or force alone) or "unknown". units: of the columns,
    "" if unstated. remarks: sentences for the user.
    """

    path: Path
    holds: str
    spelling: dict[str, Any]  #: Keys of a mapping on the text's layout.
    references: tuple[str | int, ...]  #: Names or numbers by which a mapping names its columns.
    titles: tuple[str, ...]  #: Titles of the columns in the file.
    units: tuple[str, ...]
    #: Reference and unit ("" where none is stated) by key of the record.
    columns: dict[str, tuple[str | int, str]] = field(default_factory=dict)
    sample_rate_Hz: float | None = None
    remarks: tuple[str, ...] = ()
    elsewhere: dict[str, str] = field(default_factory=dict)  #: Other file that holds a column, by key.
    step_um: float | None = None  #: Spacing of points, as the header states it.
    words: frozenset[int] = frozenset()  #: Indices of the columns of words.

    @property
    def named(self) -> bool:
        return any(self.titles)

    def unit(self, place: int, channel: str) -> str:
        """Unit of the column with the index `place` as this channel, from its title or as the file states it; "" if
        unstated.
        """
        return stem_and_unit(self.titles[place], units_of(channel))[1] or self.units[place]

    def read(self, columns: dict[str, dict[str, object]], length_mm: float | None = None) -> dict[str, Array]:
        """Columns (n,) by key, read as a mapping with the tables `columns` would; open values are ignored. length_mm:
        of a line contact; None for contacts at a point.
        """
        wanted = {key: ColumnMapping(**shut(own)) for key, own in columns.items()}
        return read_source(self.path, Source(files=(self.path.name,), **self.spelling), wanted, length_mm)

    @property
    def listing(self) -> str:
        """Text that lists the file's columns with the ranges of their numbers.

        Raises RecordError if none of them can be read.
        """
        ranges, unread = [], []
        for reference, title, unit in zip(self.references, self.titles, self.units, strict=True):
            try:
                values = self.read({"any": {"column": reference}})["any"]
            except RecordError as problem:
                unread.append(problem)
                continue
            if np.isfinite(values).any():
                name = " ".join(part for part in (str(reference), repr(title) if title else "", unit) if part)
                name = repr(reference) if isinstance(reference, str) else name
                ranges.append(f"{name} from {np.nanmin(values):.4g} to {np.nanmax(values):.4g}")
        if unread and not ranges:
            raise unread[0]
        return ", ".join(ranges)


def shut(column: dict[str, object]) -> dict[str, object]:
    """A mapping's column without open entries, and without the unit of volts that lack a factor."""
    unscaled = column.get("factor") == OPEN
    return {word: one for word, one in column.items() if one != OPEN and not (unscaled and word == "unit")}


def loop_columns(file: GuessedFile) -> dict[str, tuple[str | int, str]]:
    """Reference and unit of the column of each channel of a loop that is recognised, by key."""
    loops = taken_columns(file, LOOP_KEYS)
    if "tangential_force_N" not in loops and "normal_force_N" in loops:
        values = file.read({"any": {"column": loops["normal_force_N"][0]}})["any"]
        values = values[np.isfinite(values)]
        # What presses never goes to either side of zero.
        if values.size and np.percentile(values, 90) * np.percentile(values, 10) < 0.0:
            loops["tangential_force_N"] = loops.pop("normal_force_N")
    return loops


def taken_columns(file: GuessedFile, keys: dict[str, str]) -> dict[str, tuple[str | int, str]]:
    """Reference and unit of the column of each channel that is recognised, by key; no column is used twice, and of
    several candidates one that varies is taken. keys: channel by key of the record.
    """
    columns: dict[str, tuple[str | int, str]] = {}
    free = list(range(len(file.titles)))
    for key, channel in keys.items():
        counted = key in ("cycle", "repeat")
        fit = [place for place in free if not _of_another_kind(file.unit(place, channel), channel)]
        fit = [place for place in fit if counted or place not in file.words]
        titles, units = [file.titles[place] for place in fit], [file.unit(place, channel) for place in fit]
        found = [fit[place] for place in recognised(titles, channel, units)]
        if counted and not found:
            # What a column of words numbers, the words say.
            found = [place for place in sorted(file.words) if _changes(file, place, key)][:1]
        if not found:
            continue
        place = next((own for own in found if _changes(file, own)), found[0]) if len(found) > 1 else found[0]
        if (counted or key in ("time_s", "normal_force_N")) and not np.isfinite(values_of(file, place, key)).any():
            continue
        free = [own for own in free if own != place]
        columns[key] = (file.references[place], file.unit(place, channel))
    return columns


def rivals(file: GuessedFile, columns: Mapping[str, tuple[str | int, str]]) -> dict[str, str]:
    """Sentences, by key, on columns that fit a channel as well as the one in `columns` by name, but hold other
    values.
    """
    sentences = {}
    taken = {file.references.index(reference) for reference, _ in columns.values() if reference in file.references}
    for key, channel in LOOP_KEYS.items():
        if key not in columns or channel not in UNIT_OF or channel == "time" or columns[key][0] not in file.references:
            continue
        place = file.references.index(columns[key][0])
        units = [file.unit(own, channel) for own in range(len(file.titles))]
        # What has no unit of the channel is a raw twin.
        scaled = units[place] in units_of(channel)
        left = [n for n, unit in enumerate(units) if n not in taken and (not scaled or unit in units_of(channel))]
        found = recognised([file.titles[n] for n in left], channel, [units[n] for n in left])
        others = [left[n] for n in found if _changes(file, left[n]) and _differ(file, channel, place, left[n])]
        if others:
            names = " and ".join(repr(file.titles[n]) for n in others)
            sentences[key] = f"{file.path.name}: {file.titles[place]!r} is taken for the {channel}, and not {names}"
    return sentences


def unread(file: GuessedFile, columns: Mapping[str, tuple[str | int, str]]) -> list[str]:
    """Sentences on columns, not among `columns`, that state a factor, or seem to number the samples by words or
    counts.
    """
    taken, sentences = {reference for reference, _ in columns.values()}, []
    for place, (reference, title) in enumerate(zip(file.references, file.titles, strict=True)):
        if reference in taken or not title or place >= MOST_LABELS:
            continue
        if states_factor(title):
            sentences.append(
                f"{file.path.name}: the name of the column {title!r} states a factor: give it in a mapping"
            )
        if file.unit(place, ""):
            continue
        if place in file.words:
            text = read_delimited(file.path, layout_of(Source(files=(file.path.name,), **file.spelling)))
            words = [fields[place] for _, fields in text.rows() if place < len(fields) and fields[place]]
            different = list(dict.fromkeys(words))
            if 1 < len(different) <= LABELLED * len(words):
                such = ", ".join(map(repr, different[:3]))
                sentences.append(f"{file.path.name}: the column {title!r} holds words, such as {such}, and is not read")
            continue
        values = values_of(file, place)
        values = values[np.isfinite(values)] if values.ndim == 1 else np.empty(0)
        steps = np.diff(values)
        counts = values.size and np.array_equal(values, np.floor(values)) and np.all(steps >= 0.0)
        if counts and 0 < np.count_nonzero(steps) <= LABELLED * values.size:
            about = f"counts from {values[0]:g} to {values[-1]:g}"
            sentences.append(f"{file.path.name}: the column {title!r} {about}, and is not read")
    return sentences


def _differ(file: GuessedFile, channel: str, *places: int) -> bool:
    """True if the columns of a file with these indices hold different values of a channel."""
    units = [units_of(channel).get(file.unit(place, channel), 1.0) for place in places]
    one, other = (unit * values_of(file, place) for unit, place in zip(units, places, strict=True))
    return one.shape != other.shape or float(np.nanmax(np.abs(one - other))) > ALIKE * float(np.nanmax(np.abs(one)))


def _of_another_kind(unit: str, channel: str) -> bool:
    """True if a unit belongs to another quantity than the channel, such as °C for a column T that might be time."""
    counted = not units_of(channel) and unit in ("cycles", "Zyklen", "ciclos")
    return unit in KNOWN_UNITS and unit not in RAW_UNITS and unit not in units_of(channel) and not counted


def values_of(file: GuessedFile, place: int, key: str = "time_s") -> Array:
    """Numbers (n,) of the column with the index `place`, read as the given key; empty if it cannot be read."""
    try:
        return file.read({key: {"column": file.references[place]}})[key]
    except RecordError:
        return np.array([])


def _changes(file: GuessedFile, place: int, key: str = "time_s") -> bool:
    values = values_of(file, place, key)
    return bool(np.isfinite(values).any() and np.nanmax(values) > np.nanmin(values))
