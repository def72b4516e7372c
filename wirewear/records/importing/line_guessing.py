"""What is guessed of a line contact from a laboratory's files: its worn profiles, and of which body each is."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from wirewear.base.errors import RecordError
from wirewear.planar.tables import CYLINDER_ON_FLAT, KINDS
from wirewear.records.importing.guessed_files import GuessedFile, mapped_columns
from wirewear.records.importing.guessed_scars import Touching, body_of, map_source
from wirewear.records.importing.reader import OPEN
from wirewear.records.importing.sources import name_pattern
from wirewear.records.line_tables import LineTest, RecordContact
from wirewear.study.faces import FACE_KEYS, PadFace
from wirewear.study.messages import validated

#: What only options tell where no file holds loops.
_OPTIONS = {
    "normal_load_N": "--normal-load",
    "displacement_amplitude_um": "--amplitude",
    "frequency_Hz": "--frequency",
    "cycles": "--cycles",
}


def line_contact(known: Mapping[str, Any], specimen: Mapping[str, Any], pad: Mapping[str, Any]) -> Touching:
    """A line contact of such constants, of a length and a face as the user says.
    Raises RecordError, in one sentence, if the length or the face is not known, which no file tells.
    """
    length = known.get("length_mm")
    if length is None:
        raise RecordError("no file tells the length of the line contact: give it by --length, in millimetres.")
    validated(RecordContact, {"kind": KINDS[0], "length_mm": length}, "the options", RecordError)
    face = {key: known[key] for key in FACE_KEYS if known.get(key) is not None}
    if validated(PadFace, face, "the options", RecordError).missing_face() is not None:
        raise RecordError(
            "no file tells the pad's face: give --radius, or --face-half-width and --edge-radius, in millimetres."
        )
    kind = CYLINDER_ON_FLAT if face.keys() == {"radius_mm"} else KINDS[0]
    tables = {"contact": {"kind": kind, "length_mm": length}, "pad": face | dict(pad), "specimen": dict(specimen)}
    return Touching(tables, LineTest.body_names, length_mm=length)


def asked_of(known: Mapping[str, Any]) -> dict[str, Any]:
    """The conditions of a test of which no file holds loops. Raises RecordError if the options do not tell them all."""
    missing = [option for key, option in _OPTIONS.items() if known.get(key) is None]
    if missing:
        raise RecordError(f"no file holds loops, so that only options can tell the test: give {', '.join(missing)}.")
    return {key: known[key] for key in _OPTIONS}


def profiles_of(texts: Sequence[GuessedFile], maps: Sequence[Path]) -> tuple[dict[str, Any], list[str]]:
    """The tables `[profiles.*]` of texts of profiles and of maps, and what was assumed."""
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
        body = body_of(text.path, LineTest.body_names, "specimen", remarks)
        if body not in found:
            columns, told = mapped_columns(text)
            remarks += told
            found[body] = text.spelling | {"columns": columns}
            if alone:
                found[body]["step_um"] = text.step_um or OPEN
        files.setdefault(body, []).append(text.path.name)
    for path in maps:
        body = body_of(path, LineTest.body_names, "specimen", remarks)
        if body not in found:
            if (source := map_source(path, remarks)) is None:
                continue
            found[body] = source[1] | {"axis": "x"}
            remarks.append(f'{path.name}: axis = "x" says that the motion runs along the map\'s x; see the dry run')
        files.setdefault(body, []).append(path.name)
    sources = {}
    for body in (one for one in LineTest.body_names if one in found):
        names = sorted(files[body])
        pattern = name_pattern(names, has_cycle=True)
        of_files = {"files": names if len(names) > 1 else names[0]} | ({"name_pattern": pattern} if pattern else {})
        sources[body] = of_files | found[body]
    return sources, remarks
