"""A mapping guessed from a laboratory's files: which are loops and scars, how they are spelled, what they hold."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wirewear.errors import RecordError
from wirewear.files.guessing import GuessedLayout, guessed_layout
from wirewear.quantity import FIELD_UNITS, shown
from wirewear.records.importing.guessed_conditions import (
    FEWEST,
    GuessedFile,
    conditions_of,
    spelling_of,
)
from wirewear.records.importing.mapping import PROFILOMETER, ColumnMapping, Source
from wirewear.records.importing.sources import read_source
from wirewear.records.importing.usual_names import recognised, stem_and_unit, units_of

Array = NDArray[np.float64]

#: Ends of names of profilometers' files, which SurfaceTopography reads.
MAPS = frozenset(
    (".al3d", ".datx", ".di", ".ezd", ".gwy", ".ibw", ".mnt", ".nid", ".nms", ".npy", ".oir", ".opd", ".opdx", ".os3d")
    + (".plu", ".plux", ".poir", ".sdf", ".spm", ".stp", ".sur", ".vk4", ".vk6", ".vk7", ".wsf", ".x3p", ".zag", ".zmg")
)

#: Words in a file's name that tell whose scar it holds, and which number is a cycle's or a repeat's.
WIRE_WORDS = {
    "moving": ("moving", "upper", "oben", "oberer", "beweg", "mobile"),
    "fixed": ("fixed", "lower", "unten", "unterer", "fest", "ruhend", "static"),
}
NUMBER_WORDS = {
    "cycle": ("cycle", "cyc", "zyklus", "zykl", "lastspiel", "n", "c"),
    "repeat": ("repeat", "rep", "test", "run", "versuch", "wiederholung", "probe", "specimen", "r", "t"),
}

#: Tables of a mapping that hold one of surfaces for each body.
SURFACES = ("scars", "profiles")

#: The keys of a record's loops, and the channel that each is.
LOOP_KEYS = {
    "displacement_um": "displacement",
    "tangential_force_N": "force",
    "normal_force_N": "normal load",
    "time_s": "time",
    "cycle": "cycle",
    "repeat": "repeat",
}


@dataclass(frozen=True)
class Guess:
    """What was guessed: the tables of a mapping, and sentences on what should be looked at."""

    tables: dict[str, Any]
    remarks: tuple[str, ...]


def guessed_mapping(files: Sequence[Path], known: dict[str, Any]) -> Guess:
    """The mapping that files of one folder seem to ask for.

    Args:
        files: loops, and perhaps scars.
        known: what the user says: keys of `[wires]` and `[conditions]`, and `name`.

    Raises:
        RecordError: no file holds loops, or something is not known that no file tells; one sentence.
    """
    kinds = recognised_files(files)
    if not kinds.loops:
        raise no_loops(kinds)
    source, conditions, remarks = loop_source(kinds.loops, known)
    tables: dict[str, Any] = {
        "format": 1,
        "name": known.get("name", name_of_folder(files)),
        "wires": _wires(known),
        "conditions": conditions,
        "loops": source,
    }
    scars, told = _scars(kinds.others, kinds.maps)
    if scars:
        tables["scars"] = scars
    return Guess(tables, (*remarks, *told))


@dataclass(frozen=True)
class RecognisedFiles:
    """A laboratory's files by what they seem to hold: loops, heights and depths in texts, a profilometer's maps."""

    loops: tuple[GuessedFile, ...]
    others: tuple[GuessedFile, ...]
    maps: tuple[Path, ...]


def recognised_files(files: Sequence[Path]) -> RecognisedFiles:
    """Files of one folder, looked into.

    Raises:
        RecordError: they lie in several folders, or one cannot be read.
    """
    if any(path.parent != files[0].parent for path in files):
        raise RecordError("the files of a mapping must lie in one folder; copy them into one.")
    texts = [_recognised(path) for path in files if path.suffix.lower() not in MAPS]
    return RecognisedFiles(
        loops=tuple(text for text in texts if "tangential_force_N" in text.columns),
        others=tuple(text for text in texts if "tangential_force_N" not in text.columns),
        maps=tuple(path for path in files if path.suffix.lower() in MAPS),
    )


def no_loops(kinds: RecognisedFiles) -> RecordError:
    """What is said of files of which none holds loops."""
    names = shown(", ".join(kinds.others[0].guessed.names)) if kinds.others else "none"
    return RecordError(
        f"no file holds loops: a displacement and a force must be among the columns, which are {names}; name them in a "
        "mapping of your own (docs/records.md)."
    )


def name_of_folder(files: Sequence[Path]) -> str:
    """A title for the test that files are of: their folder's name."""
    return files[0].parent.resolve().name or "test"


def loop_source(
    loops: Sequence[GuessedFile], known: dict[str, Any], length_mm: float | None = None
) -> tuple[dict[str, Any], dict[str, Any], list[str]]:
    """The table `[loops]`, the conditions that the loops tell, and what was assumed.

    length_mm: of a line contact, whose forces may be given per millimetre.

    Raises:
        RecordError: something is not known that no file tells; one sentence.
    """
    source, remarks = _loop_source(loops)
    conditions, factor, more = conditions_of(loops[0], source, known, length_mm)
    source["columns"]["tangential_force_N"] |= factor
    return source, conditions, [*remarks, *more]


def _recognised(path: Path) -> GuessedFile:
    guessed = guessed_layout(path)
    columns: dict[str, tuple[str, str]] = {}
    taken: set[str] = set()

    def take(key: str, channel: str) -> None:
        names = [name for name in guessed.names if name not in taken]
        if found := recognised(names, channel):
            taken.add(found[0])
            columns[key] = (found[0], _unit(guessed, found[0], channel))

    names = guessed.names
    surface = recognised(names, "height") or recognised(names, "depth")
    if recognised(names, "x") and (recognised(names, "y") or surface) and not recognised(names, "force"):
        for key, channel in (("x_um", "x"), ("y_um", "y"), ("depth_um", "depth"), ("height_um", "height")):
            if key != "height_um" or "depth_um" not in columns:
                take(key, channel)
        return GuessedFile(path, guessed, columns)
    for key, channel in LOOP_KEYS.items():
        take(key, channel)
    if not {"displacement_um", "tangential_force_N"} <= columns.keys():
        columns = {}
    return GuessedFile(path, guessed, columns)


def _unit(guessed: GuessedLayout, name: str, channel: str) -> str:
    told = dict(zip(guessed.names, guessed.units, strict=True))
    return stem_and_unit(name, units_of(channel))[1] or told.get(name, "")


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


def _loop_source(loops: Sequence[GuessedFile]) -> tuple[dict[str, Any], list[str]]:
    columns, remarks = mapped_columns(loops[0])
    names = sorted({text.path.name for text in loops})
    source: dict[str, Any] = {"files": names if len(names) > 1 else names[0]}
    pattern = name_pattern(names, has_cycle="cycle" in columns)
    if pattern is not None:
        source["name_pattern"] = pattern
    source |= spelling_of(loops[0].guessed) | {"columns": columns}
    return source, remarks


def name_pattern(names: Sequence[str], *, has_cycle: bool) -> str | None:
    """A pattern for the numbers that differ between files' names: a cycle's, a repeat's."""
    if len(names) < 2:
        return None
    parts = [re.split(r"(\d+)", name) for name in names]
    if len({len(part) for part in parts}) != 1 or len({tuple(part[::2]) for part in parts}) != 1:
        raise RecordError(
            f"the files' names, such as {names[0]!r} and {names[1]!r}, differ by more than numbers: give those of one "
            "kind, or write a name_pattern."
        )
    pattern, left = "", ["repeat"] if has_cycle else ["cycle", "repeat"]
    for place, part in enumerate(parts[0]):
        differs = len({own[place] for own in parts}) > 1
        if place % 2 == 0 or not differs or not left:
            pattern += re.escape(part)
            continue
        before = re.sub(r"[^a-zäöü]", " ", parts[0][place - 1].lower()).split()
        word = before[-1] if before else ""
        key = next((key for key in left if word in NUMBER_WORDS[key]), left[0])
        left.remove(key)
        pattern += rf"(?P<{key}>\d+)"
    return pattern


def _wires(known: dict[str, Any]) -> dict[str, Any]:
    keys = ("diameter_mm", "crossing_angle_deg", "youngs_modulus_MPa", "poissons_ratio")
    wires = {key: known[key] for key in keys if known.get(key) is not None}
    if "diameter_mm" not in wires:
        raise RecordError("no file tells the wires' diameter: give it by --diameter, in millimetres.")
    return wires


def _scars(points: Sequence[GuessedFile], maps: Sequence[Path]) -> tuple[dict[str, Any], list[str]]:
    scars: dict[str, Any] = {}
    remarks = []
    for text in points:
        if not {"x_um", "y_um"} <= text.columns.keys() or not {"depth_um", "height_um"} & text.columns.keys():
            remarks.append(f"{text.path.name} was left out: neither loops nor a scar were recognised in it")
            continue
        wire = _wire(text.path, scars, remarks)
        columns, told = mapped_columns(text)
        remarks += told
        if wire in scars:
            scars[wire]["files"] = [*_listed(scars[wire]["files"]), text.path.name]
            continue
        scars[wire] = {"files": text.path.name, **spelling_of(text.guessed), "columns": columns}
        if "height_um" in columns:
            scars[wire]["axis"] = _axis(text, columns)
    for path in maps:
        wire = _wire(path, scars, remarks)
        if wire in scars:
            scars[wire]["files"] = [*_listed(scars[wire]["files"]), path.name]
        else:
            scars[wire] = {"files": path.name, "kind": PROFILOMETER, "axis": "x"}
            remarks.append(f'{path.name}: axis = "x" says that the wire runs along the map\'s x; see the dry run')
    return scars, remarks


def _listed(files: str | list[str]) -> list[str]:
    return [files] if isinstance(files, str) else files


def _wire(path: Path, scars: dict[str, Any], remarks: list[str]) -> str:
    name = path.stem.lower()
    for wire, words in WIRE_WORDS.items():
        if any(word in name for word in words):
            return wire
    wire = "moving" if "moving" not in scars else "fixed"
    remarks.append(f"{path.name}: nothing in its name tells whose scar it is; it is taken for the {wire} wire's")
    return wire


def _axis(text: GuessedFile, columns: dict[str, Any]) -> str:
    """Along which axis of the map the wire runs: that in which its surface is the straighter."""
    wanted = {key: ColumnMapping(**column) for key, column in columns.items()}
    found = read_source(text.path, Source(files=(text.path.name,), **spelling_of(text.guessed)), wanted)
    x, y, z = (found[key] for key in ("x_um", "y_um", "height_um"))
    known = np.isfinite(x + y + z)
    if np.count_nonzero(known) < FEWEST or min(np.ptp(values[known]) for values in (x, y, z)) <= 0.0:
        return "x"
    x, y, z = ((values[known] - values[known].mean()) / np.ptp(values[known]) for values in (x, y, z))
    bends = np.linalg.lstsq(np.column_stack([x**0, x, y, x * x, x * y, y * y]), z, rcond=None)[0]
    width = {"x": float(np.ptp(found["x_um"][known])), "y": float(np.ptp(found["y_um"][known]))}
    return "x" if abs(bends[3]) / width["x"] ** 2 < abs(bends[5]) / width["y"] ** 2 else "y"


def with_files_from(guess: Guess, home: Path, folder: Path) -> Guess:
    """The guess for a mapping that stands in `folder`, in or above which the files' own folder lies.

    Raises:
        RecordError: the files do not lie there.
    """
    try:
        relative = home.resolve().relative_to(folder.resolve())
    except ValueError:
        raise RecordError(f"the mapping must stand beside the files or above them, not in {folder}.") from None

    def moved(files: str | list[str]) -> str | list[str]:
        names = [(relative / name).as_posix() for name in _listed(files)]
        return names if isinstance(files, list) else names[0]

    tables = dict(guess.tables)
    if "loops" in tables:
        tables["loops"] = tables["loops"] | {"files": moved(tables["loops"]["files"])}
    for kind in SURFACES:
        if kind in tables:
            tables[kind] = {body: own | {"files": moved(own["files"])} for body, own in tables[kind].items()}
    return replace(guess, tables=tables)
