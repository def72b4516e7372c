"""Guess of a mapping from a laboratory's files: which hold loops and worn surfaces, and how they are to be read.

A value of a mapping is open if the files do not show it, so that the user must fill it in.
"""

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from wirewear.base.errors import RecordError
from wirewear.base.files import toml_text
from wirewear.base.naming import plain
from wirewear.base.words import as_sentence
from wirewear.records.common_tables import FRICTION_FORCE
from wirewear.records.importing.guessed_columns import GuessedFile
from wirewear.records.importing.guessed_conditions import conditions_of
from wirewear.records.importing.guessed_files import joined, looked_into, mapped_columns
from wirewear.records.importing.guessed_scars import Touching, body_of, listed, map_source, scars_of
from wirewear.records.importing.height_maps import is_map, matrix_of
from wirewear.records.importing.sources import name_pattern
from wirewear.records.importing.text_reader import open_lines
from wirewear.records.remarks import plural
from wirewear.results.scar import called
from wirewear.test.bodies import OPEN
from wirewear.test.lengths import extent_of

#: What only options state where no file holds loops.
_OPTIONS = {
    "normal_load_N": "--normal-load",
    "displacement_amplitude_um": "--amplitude",
    "frequency_Hz": "--frequency",
    "cycles": "--cycles",
}

SURFACES = ("scars", "profiles")  #: Tables of a mapping that hold one of surfaces for each body.
#: Words of a file's name by which its surface is not worn yet, or is what wear has left; those in `_NEW` may also say
#: that the file was written again, and count only where other surfaces are there.
_BEFORE = frozenset(("before", "unworn", "vorher", "vor", "unverschlissen", "avant", "antes", "prima"))
_NEW = frozenset(
    ("new", "fresh", "pristine", "virgin", "initial", "pre", "neu", "neuf", "neuve", "nuevo", "nuova", "nuovo")
)
_AFTER = frozenset(
    ("after", "worn", "post", "nachher", "nach", "verschlissen", "apres", "despues", "dopo", "minus", "diff")
)

_HELD = {"loops": "loops", "evolution": "evolution", "surfaces": "surface", "unknown": "unknown"}


def asked_of(known: Mapping[str, object]) -> dict[str, object]:
    """Conditions by key of a test without loops, from the user's options `known`. Raises RecordError if one is
    missing.
    """
    missing = [option for key, option in _OPTIONS.items() if known.get(key) is None]
    if missing:
        raise RecordError(f"no file holds loops, so that only options can state the test: give {', '.join(missing)}.")
    return {key: known[key] for key in _OPTIONS}


def profiles_of(
    texts: Sequence[GuessedFile], maps: Sequence[Path], touching: Touching
) -> tuple[dict[str, object], list[str]]:
    """Tables `[profiles.*]` of a mapping, by body, for these texts and maps of profiles, and sentences on assumptions
    and on files left out.
    """
    found: dict[str, Any] = {}
    files: dict[str, list[str]] = {}
    remarks: list[str] = []
    for text in texts:
        alone = len(text.references) == 1
        if (
            not (alone or "x_um" in text.columns)
            or not {"depth_um", "height_um"} & text.columns.keys()
            or "y_um" in text.columns
        ):
            remarks.append(f"{text.path.name} was left out: neither loops nor a profile were recognised in it")
            continue
        body = body_of(text.path, touching.names, "specimen", remarks)
        if body not in found:
            columns, more = mapped_columns(text)
            remarks += more
            found[body] = text.spelling | {"columns": columns}
            if alone:
                found[body]["step_um"] = text.step_um or OPEN
        files.setdefault(body, []).append(text.path.name)
    for path in maps:
        body = body_of(path, touching.names, "specimen", remarks)
        if body not in found:
            if (source := map_source(path, remarks)) is None:
                continue
            found[body] = source[1] | {"axis": "x"}
            remarks.append(f'{path.name}: axis = "x" says that the motion runs along the map\'s x; see the dry run')
        files.setdefault(body, []).append(path.name)
    sources = {}
    for body in (one for one in touching.names if one in found):
        sources[body] = _named_files(sorted(files[body])) | found[body]
    return sources, remarks


#: What a mapping says of worn surfaces, by what they are.
_WORN = {"scars": scars_of, "profiles": profiles_of}


@dataclass(frozen=True)
class GuessedMapping:
    """Guessed tables of a mapping by name, such as "loops", and sentences on what the user should check."""

    tables: dict[str, Any]
    remarks: tuple[str, ...]


def guessed_mapping(files: Sequence[Path], known: Mapping[str, object], touching: Touching) -> GuessedMapping:
    """Guess a mapping from files of one folder: of loops, and possibly of an evolution and worn surfaces.

    known: keys of `[conditions]` and `name` as the user states them. touching: bodies as the user states them. Raises
    RecordError, in one sentence, if no file holds loops, or one of them cannot be read.
    """
    found, stated = recognised_files(files), touching.stated
    extent = extent_of(stated.length_mm)
    name, (worn, of_worn) = extent.worn, _WORN[extent.worn](found.surfaces, found.maps, touching)
    evolution, of_evolution = evolution_source(found.evolution, per_length=bool(extent.units({"N": 1.0})))
    loops = found.loops or (() if worn and not stated.needs_loops else found.unknown)
    tables: dict[str, Any] = {"format": 1, "name": known.get("name", name_of_folder(files)), **stated.tables}
    remarks: list[str] = []
    if loops:
        source, asked, remarks = loop_source(loops, known, stated.length_mm, of_joint=not touching.names)
        tables["conditions"] = {key: own for key, own in asked.items() if key != FRICTION_FORCE}
        tables["stated"] = {key: own for key, own in asked.items() if key == FRICTION_FORCE}
        tables["loops"] = source
        remarks += _without_loops(worn, source, extent.worn.removesuffix("s"))
    elif not stated.needs_loops and (worn or evolution):
        tables["conditions"] = asked_of(known)
    else:
        why = "; ".join(found.unread) or "a displacement and a force must be among the columns"
        raise RecordError(f"no file holds loops: {why}; name them in a mapping of your own (docs/records.md).")
    tables |= {key: own for key, own in ((name, worn), ("evolution", evolution)) if own}
    left = [] if loops is found.unknown else left_out(found.unknown)
    return GuessedMapping(tables, (*stated.remarks, *remarks, *of_evolution, *of_worn, *left, *found.unread))


@dataclass(frozen=True)
class RecognisedFiles:
    """A laboratory's files by what they hold; surfaces are worn surfaces as columns of a text, maps those of a
    profilometer.
    """

    loops: tuple[GuessedFile, ...]
    evolution: tuple[GuessedFile, ...]
    surfaces: tuple[GuessedFile, ...]
    unknown: tuple[GuessedFile, ...]  #: Tables of numbers with unknown column names.
    maps: tuple[Path, ...]
    unread: tuple[str, ...]  #: A sentence on each file that is left out.


def recognised_files(files: Sequence[Path]) -> RecognisedFiles:
    """Files of one folder by what they hold; for those that cannot be read there is a sentence. Raises RecordError if
    they lie in several folders, or do not exist.
    """
    if any(path.parent != files[0].parent for path in files):
        raise RecordError("the files of a mapping must lie in one folder; copy them into one.")
    maps, tables, unread = [], [], dict[Path, str]()
    for path in files:
        if not path.is_file():
            raise RecordError(f"there is no file {path}.")
        if is_map(path):
            maps.append(path)
            continue
        try:
            tables.append(looked_into(path))
        except RecordError as problem:
            unread[path] = f"{path.name} was left out: {str(problem).removesuffix('.')}"
    held = {name: tuple(own for own in tables if own.holds == kind) for name, kind in _HELD.items()}
    channels = [own for own in tables if own.holds == "channel"]
    whole = joined(channels)
    if not whole:
        reason = "was left out: it has no columns for a displacement and a force"
        unread |= {own.path: f"{own.path.name} {reason}" for own in channels}
    # Beside loops, a matrix without names is a map of heights, though it does not say so.
    matrices = [path for path in (*unread, *(own.path for own in held["unknown"])) if matrix_of(path)]
    others = tuple(own for own in held["unknown"] if own.path not in matrices)
    if held["loops"] + whole or others:
        held["unknown"], maps = others, [*maps, *matrices]
        unread = {path: reason for path, reason in unread.items() if path not in matrices}
    early = _unworn([*(own.path for own in held["surfaces"]), *maps])
    held["surfaces"] = tuple(own for own in held["surfaces"] if own.path not in early)
    maps = [path for path in maps if path not in early]
    why = "by its name it shows what was not worn yet; the unworn surface is fitted to the worn map itself"
    unread |= {path: f"{path.name} was left out: {why}" for path in early}
    return RecognisedFiles(**held | {"loops": held["loops"] + whole}, maps=tuple(maps), unread=tuple(unread.values()))


def _unworn(surfaces: Sequence[Path]) -> list[Path]:
    """Which of these files hold a surface that is not worn yet, by words in their names."""
    words = {
        path: frozenset(re.findall(r"[^\W\d_]+", plain(re.sub(r"(?<=[a-z])(?=[A-Z])", "_", path.stem))))
        for path in surfaces
    }
    found = [path for path, own in words.items() if own & (_BEFORE | _NEW) and not own & _AFTER]
    return [path for path in found if words[path] & _BEFORE or len(found) < len(surfaces)]


def _without_loops(worn: Mapping[str, Any], loops: Mapping[str, Any], name: str) -> list[str]:
    """A sentence on each body with more files of worn surfaces than the loops have repeats; none if columns number
    these. worn: a mapping's tables by body. loops: its table. name: of a worn surface.
    """
    pattern, repeats = loops.get("name_pattern", ""), {"1"}
    if "(?P<repeat>" in pattern:
        repeats = {found["repeat"] for file in listed(loops["files"]) if (found := re.search(pattern, file))}
    if "repeat" in loops["columns"]:
        return []
    return [
        f"the {called(body)} has {len(files)} {name}s ({', '.join(files)}), which count as one repeat each, and the "
        f"loops {plural(len(repeats), 'repeat')}: keep those {name}s alone whose loops are there"
        for body, source in worn.items()
        if len(files := listed(source["files"])) > len(repeats) and "repeat" not in source.get("columns", {})
    ]


def left_out(unknown: Sequence[GuessedFile]) -> list[str]:
    """A sentence for each table whose contents were not recognised."""
    return [f"{one.path.name} was left out: what its columns hold is not recognised" for one in unknown]


def name_of_folder(files: Sequence[Path]) -> str:
    """Name of the folder of the first file, as a title for the test; "test" if it has none."""
    return files[0].parent.resolve().name or "test"


def loop_source(
    loops: Sequence[GuessedFile], known: Mapping[str, object], length_mm: float | None = None, *, of_joint: bool = False
) -> tuple[dict[str, object], dict[str, object], list[str]]:
    """Table `[loops]` of a mapping, the conditions by key that the loops show, and sentences on assumptions.

    known: conditions that the user states. length_mm: of a line contact, whose forces may be given per millimetre.
    of_joint: see `conditions_of`. Raises RecordError, in one sentence, if something is missing that no file states.
    """
    first = loops[0]
    columns, remarks = mapped_columns(first, per_length=bool(extent_of(length_mm).units({"N": 1.0})))
    missing = [key for key in ("displacement_um", "tangential_force_N") if key not in columns]
    columns = {**{key: {"column": OPEN, "unit": OPEN} for key in missing}, **columns}
    if missing or remarks != [*first.remarks]:
        remarks.append(f"{first.path.name} has the columns {first.listing}")
        encoding = first.spelling.get("encoding", "utf-8")
        if missing and first.named and not encoding.startswith("utf"):
            remarks.append(f"the encoding {encoding} is a guess: where the names are garbled, put another one")
    if missing and any(":" in str(own) for own in first.references):
        remarks.append('with one cycle a row, a channel is a group of columns such as "1:128"')
    source = _named_files([text.path.name for text in loops], has_cycle="cycle" in columns) | first.spelling
    if len({one.spelling.get("rows") for one in loops}) > 1:
        del source["rows"]
    if "time_s" not in columns and first.sample_rate_Hz is not None:
        source["sample_rate_Hz"] = first.sample_rate_Hz
    source["columns"] = columns
    conditions, signs, more = conditions_of(first, source, known, length_mm, of_joint=of_joint)
    for key, sign in signs.items():
        columns[key].setdefault("factor", sign)
    return source, conditions, [*remarks, *more]


def evolution_source(tables: Sequence[GuessedFile], *, per_length: bool = False) -> tuple[dict[str, object], list[str]]:
    """Table `[evolution]` of a mapping and sentences on assumptions; both empty without tables. per_length: forces and
    energies may be per millimetre of a line contact.
    """
    if not tables:
        return {}, []
    columns, remarks = mapped_columns(tables[0], per_length=per_length)
    return _named_files([text.path.name for text in tables]) | tables[0].spelling | {"columns": columns}, remarks


def _named_files(names: Sequence[str], *, has_cycle: bool = True) -> dict[str, Any]:
    """Keys of a mapping for files of these names. has_cycle: True if columns number the cycles."""
    files = sorted(set(names))
    pattern = name_pattern(files, has_cycle=has_cycle)
    named = {} if pattern is None else {"name_pattern": pattern}
    return {"files": files if len(files) > 1 else files[0], **named}


def with_files_from(guess: GuessedMapping, home: Path, folder: Path) -> GuessedMapping:
    """Copy of a guessed mapping for a file in `folder`, with the data files' names relative to it; home: these files'
    folder. Raises RecordError if `home` is not inside `folder`.
    """
    try:
        relative = home.resolve().relative_to(folder.resolve())
    except ValueError:
        raise RecordError(f"the mapping must stand beside the files or above them, not in {folder}.") from None

    def moved(files: str | list[str]) -> str | list[str]:
        names = [(relative / name).as_posix() for name in listed(files)]
        return names if isinstance(files, list) else names[0]

    tables = dict(guess.tables)
    for name in ("loops", "evolution"):
        if name in tables:
            tables[name] = tables[name] | {"files": moved(tables[name]["files"])}
    for kind in SURFACES:
        if kind in tables:
            tables[kind] = {body: own | {"files": moved(own["files"])} for body, own in tables[kind].items()}
    return replace(guess, tables=tables)


def mapping_text(guess: GuessedMapping) -> str:
    """Text of the mapping file, to be read by `wirewear import`."""
    tables = dict(guess.tables)
    lines = ["# Guessed by `wirewear new --mapping`; `wirewear import --dry-run` draws what it gives."]
    lines += [f"# – {as_sentence(remark)}" for remark in guess.remarks]
    sources = ("stated", "loops", "evolution", *SURFACES)
    lines += ["", toml_text({key: own for key, own in tables.items() if key not in sources}).strip()]
    lines += ["", "[stated]  # what you believe of the rig; `wirewear fit` finds friction, stiffness and wear"]
    lines += [f"{key} = {value:g}" for key, value in tables.get("stated", {}).items()]
    for name in ("loops", "evolution"):
        if name in tables:
            lines += _source(name, tables[name])
    for kind in SURFACES:
        for body, source in tables.get(kind, {}).items():
            lines += _source(f"{kind}.{body}", source)
    text = "\n".join(lines) + "\n"
    left = {number for number, _ in open_lines(text)}
    marked = (f"{line}  # fill in" if number in left else line for number, line in enumerate(text.splitlines(), 1))
    return "\n".join(marked) + "\n"


def _source(name: str, source: Mapping[str, Any]) -> list[str]:
    own = {key: value for key, value in source.items() if key != "columns"}
    lines = ["", f"[{name}]", *(f"{key} = {_spelled(value)}" for key, value in own.items())]
    if "columns" in source:
        lines.append(f"[{name}.columns]")
        for key, column in source["columns"].items():
            inside = ", ".join(f"{word} = {_spelled(value)}" for word, value in column.items())
            lines.append(f"{key} = {{ {inside} }}")
    return lines


def _spelled(value: object) -> str:
    # A pattern's backslashes stay as they are.
    if isinstance(value, str) and "\\" in value and "'" not in value:
        return f"'{value}'"
    return json.dumps(value, ensure_ascii=False)
