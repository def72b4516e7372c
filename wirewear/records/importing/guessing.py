"""A mapping guessed from a laboratory's files: which are loops and scars, how they are spelled, what they hold."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from wirewear.errors import RecordError
from wirewear.files.guessing import GuessedLayout, guessed_layout
from wirewear.quantity import shown
from wirewear.records.importing.guessed_conditions import (
    GuessedFile,
    conditions_of,
    mapped_columns,
    spelling_of,
)
from wirewear.records.importing.guessed_scars import listed, points_without_names, scars_of
from wirewear.records.importing.usual_names import recognised, stem_and_unit, units_of

#: Ends of names of profilometers' files, which SurfaceTopography reads.
MAPS = frozenset(
    (".al3d", ".datx", ".di", ".ezd", ".gwy", ".ibw", ".mnt", ".nid", ".nms", ".npy", ".oir", ".opd", ".opdx", ".os3d")
    + (".plu", ".plux", ".poir", ".sdf", ".spm", ".stp", ".sur", ".vk4", ".vk6", ".vk7", ".wsf", ".x3p", ".zag", ".zmg")
)

#: Words in a file's name that tell which number is a cycle's or a repeat's.
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
    scars, told = scars_of(kinds.others, kinds.maps)
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
    if not guessed.names and path.suffix.lower() == ".xyz":
        return points_without_names(path, guessed)
    columns: dict[str, tuple[str | int, str]] = {}
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
        names = [(relative / name).as_posix() for name in listed(files)]
        return names if isinstance(files, list) else names[0]

    tables = dict(guess.tables)
    if "loops" in tables:
        tables["loops"] = tables["loops"] | {"files": moved(tables["loops"]["files"])}
    for kind in SURFACES:
        if kind in tables:
            tables[kind] = {body: own | {"files": moved(own["files"])} for body, own in tables[kind].items()}
    return replace(guess, tables=tables)
