"""Recognition of what a path holds: record, result, study, measured numbers, or a bundled example."""

import re
import tomllib
from collections.abc import Mapping
from contextlib import suppress
from enum import StrEnum
from pathlib import Path

from wirewear.base.errors import WirewearError
from wirewear.base.files import RESULT_FILE_NAME, TABLE_FILE_NAME

#: Tables of a mapping that say where measured numbers are.
_SOURCES = ("loops", "evolution", "scars", "profiles")
_HDF5 = b"\x89HDF\r\n\x1a\n"

#: Beginnings of loggers' files that are no text: of xlsx and x3p, of MATLAB, of LabVIEW.
_PACKED = (b"PK\x03\x04", b"MATLAB 5.0", b"TDSm")
_NUMBER = r'"?[-+]?\d[\d.,]*(?:e[-+]?\d+)?"?'
_ROW = re.compile(rf"\s*{_NUMBER}(?:\s*[\s;,|]\s*{_NUMBER})+[\s;,|]*", re.IGNORECASE)

_RUNS_BELOW = f"*/{RESULT_FILE_NAME}"

STUDIES = ("steel_wires", "ball_on_flat", "cylinder_on_flat")
RECORDS = ("no_gap", "free_play_rig", "rigid_stated_compliant_rig")
_HERE = Path(__file__).resolve()

#: Where they are: `setup.py` puts them beside the installed modules; a checkout has them among its studies.
_FOLDERS = (_HERE.parents[1] / "examples", _HERE.parents[2] / "studies")


class Held(StrEnum):
    """Kinds of content that a path may hold."""

    RECORD = "record"
    RUN = "result of a run"
    STUDY = "study"
    SWEEP = "sweep"
    ROPE = "rope's construction"
    MAPPING = "mapping of measured files"
    NUMBERS = "file of measured numbers"
    FILES = "folder of measured files"


#: The commands that take it, PATH being its place.
_TAKEN = {
    Held.RECORD: "`wirewear check PATH` reads it",
    Held.RUN: "`wirewear report PATH` makes its page, `wirewear export PATH --as-record DIR` a record of it",
    Held.STUDY: "`wirewear run PATH` simulates it",
    Held.SWEEP: "`wirewear sweep PATH` runs it",
    Held.ROPE: "`wirewear strand PATH` finds its contacts",
    Held.MAPPING: "`wirewear import PATH --output DIR` makes a record by it",
    Held.NUMBERS: "`wirewear new --mapping PATH` begins a mapping that says how to read it, and `wirewear loops PATH` "
    "analyses friction loops",
    Held.FILES: "`wirewear new --mapping PATH/*` begins a mapping that says how to read them, without /* if each is of "
    "another test",
}


def require_no_other(path: Path, kind: type[WirewearError], *wanted: Held) -> None:
    """Check that a path holds nothing but content of the kinds `wanted`; content that is not recognised passes.

    Otherwise raises an error of class `kind` that names the content and a suitable command.
    """
    held = None
    with suppress(OSError, ValueError):
        held = recognised(path)
    if held == Held.FILES and Held.NUMBERS not in wanted and any(path.glob(_RUNS_BELOW)):
        held = Held.RUN if Held.RUN in wanted else held
    if held is not None and held not in wanted:
        place = path.parent if held == Held.RECORD and path.name == TABLE_FILE_NAME else path
        needed = " or ".join(wanted)
        lacks = (
            f"there is no file {TABLE_FILE_NAME} in it, and " if (held, *wanted) == (Held.FILES, Held.RECORD) else ""
        )
        raise kind(f"{path} is a {held}, and no {needed}: {lacks}{_TAKEN[held].replace('PATH', str(place))}.")


def recognised(path: Path) -> Held | None:
    """Kind of content at a path; None if it is not recognised."""
    if (path / TABLE_FILE_NAME).is_file() or (path.name == TABLE_FILE_NAME and path.is_file()):
        return Held.RECORD
    if path.is_dir():
        return _in_folder(path)
    if not path.is_file():
        return None
    with path.open("rb") as file:
        start = file.read(4096)
        file.seek(max(0, path.stat().st_size - 128))
        end = file.read()
    if start.startswith(_HDF5):
        # Other programs write HDF5 too.
        return Held.RUN if path.name == RESULT_FILE_NAME or b"\nwirewear sha256 " in end else None
    with suppress(ValueError, RecursionError):
        return _held_by(tomllib.loads(path.read_text(encoding="utf-8-sig")))
    rows = start.decode("latin-1").replace("\0", "").splitlines()
    is_numbers = start.startswith(_PACKED) or any(map(_ROW.fullmatch, rows))
    return Held.NUMBERS if is_numbers and path.suffix != ".toml" else None


def _in_folder(path: Path) -> Held | None:
    if (path / RESULT_FILE_NAME).exists():
        return Held.RUN
    # Tables that runs leave stand beside their pages.
    own = () if any(path.glob("*.html")) else (one for one in path.iterdir() if one.is_file())
    return Held.FILES if Held.NUMBERS in map(recognised, own) else Held.RUN if any(path.glob(_RUNS_BELOW)) else None


def _held_by(tables: Mapping[str, object]) -> Held | None:
    if "kind" not in tables and any(name in tables for name in _SOURCES):
        return Held.MAPPING
    if "files" in tables:
        return Held.RECORD
    if "vary" in tables:
        return Held.SWEEP
    if "core" in tables:
        return Held.ROPE
    contact = tables.get("contact")
    return Held.STUDY if "kind" in tables or (isinstance(contact, Mapping) and "friction" in contact) else None


def example(name: str) -> Path | None:
    """Path of the bundled study (file) or record (folder) of this name; None if there is none."""
    inner = {one: f"{one}/study.toml" for one in STUDIES}
    inner |= {one: f"steel_wires/example_records/{one}" for one in RECORDS}
    places = (folder / inner[name] for folder in _FOLDERS if name in inner)
    return next((place for place in places if place.exists()), None)
