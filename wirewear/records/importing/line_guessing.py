"""A mapping of a line contact guessed from a laboratory's files: which are loops, which profiles, of which body."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from wirewear.base.errors import RecordError
from wirewear.planar.tables import CYLINDER_ON_FLAT, KINDS
from wirewear.records.importing import guessing
from wirewear.records.importing.guessed_files import GuessedFile, mapped_columns
from wirewear.records.importing.guessed_scars import map_source
from wirewear.records.importing.reader import OPEN
from wirewear.records.line_tables import LineTest, RecordContact
from wirewear.study.faces import FACE_KEYS, PadFace
from wirewear.study.messages import validated

#: Words in a file's name that tell whose profile it holds.
BODY_WORDS = {
    "pad": ("pad", "cylinder", "zylinder", "punch", "stempel", "upper", "oben", "oberer"),
    "specimen": ("specimen", "flat", "plane", "probe", "ebene", "platte", "lower", "unten", "unterer"),
}

#: What only options tell where no file holds loops.
_OPTIONS = {
    "normal_load_N": "--normal-load",
    "displacement_amplitude_um": "--amplitude",
    "frequency_Hz": "--frequency",
    "cycles": "--cycles",
}


def guessed_line_mapping(files: Sequence[Path], known: Mapping[str, Any]) -> guessing.GuessedMapping:
    """The mapping that files of one folder seem to ask for.

    Args:
        files: loops, or profiles, or both.
        known: what the user says: `length_mm`, keys of a face and of `[conditions]`, elastic constants as `pad` and
            `specimen`, and `name`.

    Raises:
        RecordError: no file holds loops or a profile, or something is not known that no file tells; one sentence.
    """
    kinds, length = guessing.recognised_files(files), known.get("length_mm")
    if length is None:
        raise RecordError("no file tells the length of the line contact: give it by --length, in millimetres.")
    validated(RecordContact, {"kind": KINDS[0], "length_mm": length}, "the options", RecordError)
    face = {key: known[key] for key in FACE_KEYS if known.get(key) is not None}
    if validated(PadFace, face, "the options", RecordError).missing_face() is not None:
        raise RecordError(
            "no file tells the pad's face: give --radius, or --face-half-width and --edge-radius, in millimetres."
        )
    profiles, remarks = _profiles(kinds.surfaces, kinds.maps)
    evolution, told = guessing.evolution_source(kinds.evolution, per_length=True)
    remarks += told
    tables: dict[str, Any] = {
        "format": 1,
        "name": known.get("name", guessing.name_of_folder(files)),
        "contact": {"kind": CYLINDER_ON_FLAT if face.keys() == {"radius_mm"} else KINDS[0], "length_mm": length},
        "pad": face | dict(known["pad"]),
        "specimen": dict(known["specimen"]),
    }
    loops = kinds.loops or (() if profiles else kinds.unknown)
    if loops:
        tables["loops"], conditions, told = guessing.loop_source(loops, dict(known), length)
        remarks = [*told, *remarks]
    elif profiles or evolution:
        conditions = _asked(known)
    else:
        raise guessing.no_loops(kinds)
    tables["conditions"] = conditions
    if evolution:
        tables["evolution"] = evolution
    if profiles:
        tables["profiles"] = profiles
    left = [] if loops is kinds.unknown else guessing.left_out(kinds.unknown)
    return guessing.GuessedMapping(tables, (*remarks, *left, *kinds.unread))


def _asked(known: Mapping[str, Any]) -> dict[str, Any]:
    missing = [option for key, option in _OPTIONS.items() if known.get(key) is None]
    if missing:
        raise RecordError(f"no file holds loops, so that only options can tell the test: give {', '.join(missing)}.")
    return {key: known[key] for key in _OPTIONS}


def _profiles(texts: Sequence[GuessedFile], maps: Sequence[Path]) -> tuple[dict[str, Any], list[str]]:
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
        body = _body(text.path, remarks)
        if body not in found:
            columns, told = mapped_columns(text)
            remarks += told
            found[body] = text.spelling | {"columns": columns}
            if alone:
                found[body]["step_um"] = text.step_um or OPEN
        files.setdefault(body, []).append(text.path.name)
    for path in maps:
        body = _body(path, remarks)
        if body not in found:
            if (source := map_source(path, remarks)) is None:
                continue
            found[body] = source[1] | {"axis": "x"}
            remarks.append(f'{path.name}: axis = "x" says that the motion runs along the map\'s x; see the dry run')
        files.setdefault(body, []).append(path.name)
    sources = {}
    for body in (one for one in LineTest.body_names if one in found):
        names = sorted(files[body])
        pattern = guessing.name_pattern(names, has_cycle=True)
        of_files = {"files": names if len(names) > 1 else names[0]} | ({"name_pattern": pattern} if pattern else {})
        sources[body] = of_files | found[body]
    return sources, remarks


def _body(path: Path, remarks: list[str]) -> str:
    name = path.stem.lower()
    for body, words in BODY_WORDS.items():
        if any(word in name for word in words):
            return body
    remarks.append(f"{path.name}: nothing in its name tells whose profile it is; it is taken for the specimen's")
    return "specimen"
