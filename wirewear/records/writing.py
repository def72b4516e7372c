"""Writing of an experiment record: prepared in a folder beside its place, and moved there in one step.

An existing record is replaced only if it was made of the same source and is unchanged, or if the user asks for it.
"""

import hashlib
import os
from collections.abc import Iterable, Mapping, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from wirewear.base.errors import RecordError
from wirewear.base.files import TABLE_FILE_NAME, link_followed, read_bytes, spelled, toml_text
from wirewear.base.locks import occupied
from wirewear.base.writing import folder_in_one_step, put_back, usable_folder, write_csv, write_text, writing
from wirewear.records.contact_tables import RECORDS
from wirewear.records.reading import EVOLUTION_COLUMNS, require_unchanged
from wirewear.records.values import AnyRecord, MeasuredLoop

if TYPE_CHECKING:
    import polars as pl

#: All that wirewear writes of a record, of whatever kind of contact.
_FILES = (
    TABLE_FILE_NAME,
    *dict.fromkeys(
        f"{key}.csv"
        for tables in RECORDS.values()
        for key in ("loops", "evolution", *(f"{tables.worn.name}_{body}" for body in tables.body_names))
    ),
)
_MADE_OF = "# made of "  #: Before the path, from the record's folder, of the file that a record was made of.


def require_place(folder: Path, *, made_of: Sequence[Path] = (), overwrite: bool = False) -> None:
    """Check that a record can be written to a folder; nothing is changed.

    made_of: files that the record is made of, the mapping, run or record first. overwrite: any record there may be
    replaced. Raises RecordError if the folder is or holds one of these files, or holds another record or a file that
    would be lost; RunError if it cannot be written.
    """
    with writing(RecordError, f"cannot write the record to {folder}"):
        place = link_followed(folder).resolve()
    # The folder itself is tried by whoever is given it.
    usable_folder(place.parent)
    with writing(RecordError, f"cannot write the record to {folder}"):
        put_back(place)
    if place.is_mount():
        raise RecordError(f"a disk is mounted at {folder}, which no record can replace: choose a folder in it.")
    for path in made_of:
        if path.resolve().is_relative_to(place):
            raise RecordError(f"{folder} holds {path}, which the record is made of: choose another folder.")
    if place.is_dir() and Path.cwd().is_relative_to(place):
        raise RecordError(
            f"{folder} is the folder that the command was started in, or holds it: choose another folder."
        )
    if not overwrite and (lost := _lost(place, made_of)):
        raise RecordError(
            f"{folder} holds {lost}, and is not overwritten unasked: choose another folder, or overwrite it "
            "(--overwrite)."
        )


def _lost(folder: Path, made_of: Sequence[Path]) -> str | None:
    """Words on what would be lost in a folder; None if it is free, or holds a record made in the same way."""
    path = folder / TABLE_FILE_NAME
    if not path.is_file():
        return next((name for name in _FILES if os.path.lexists(folder / name)), None)
    text = read_bytes(path, RecordError, "TOML file").decode("utf-8", "replace")
    try:
        unchanged = "# sha256 " in text and not require_unchanged(path)
    except RecordError:
        unchanged = False
    if not unchanged:
        return "a record that was written or changed by hand"
    if _origin(folder, made_of) not in text.splitlines() and (made_of or f"\n{_MADE_OF}" in text):
        return "a record that was not made of the same file"
    return None


def _origin(folder: Path, made_of: Sequence[Path]) -> str:
    """Line of experiment.toml that names the first source of a record; "" if there is none."""
    if not made_of:
        return ""
    place = os.fsencode(os.path.relpath(made_of[0].resolve(), folder.resolve()))
    return _MADE_OF + spelled(place.decode("utf-8", "backslashreplace"))


def write_record(
    folder: str | Path, record: AnyRecord, *, made_of: Sequence[Path] = (), overwrite: bool = False
) -> Path:
    """Write a record to `folder`, which is created if missing, and return it; numbers keep all their digits.

    made_of, overwrite: see `require_place`. Files of an earlier record there are replaced, other files stay; at any
    moment others see the old or the new record. Raises RecordError if the record lacks the loops that it must have,
    holds nothing or has no place there, or a file cannot be written; RunError if the folder cannot be created, or
    another command is writing to it.
    """
    folder, tables = Path(folder), record.tables
    frames = {"loops": loops_frame(record.loops)} if record.loops else {}
    if record.evolution:
        sizes = [part.columns["cycle"].size for part in record.evolution]
        columns: dict[str, Any] = {"repeat": np.repeat([part.repeat for part in record.evolution], sizes)}
        for column in EVOLUTION_COLUMNS[1:]:
            columns[column.name] = np.concatenate([part.columns[column.name] for part in record.evolution])
        columns["cycle"] = columns["cycle"].astype(np.int64)
        frames["evolution"] = frame_of(columns)
    for body in tables.body_names:
        if own := record.scars_of(body):
            parts = [{"repeat": np.full(one.points["x_um"].size, one.repeat), **one.points} for one in own]
            frames[f"{tables.worn.name}_{body}"] = frame_of(
                {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
            )
    if not frames or (tables.needs_loops and not record.loops):
        what = "has no loops" if tables.needs_loops else "holds nothing"
        raise RecordError(f"the record {record.name!r} {what}, so it cannot be written.")
    files = {key: f"{key}.csv" for key in frames}
    tables = tables.model_copy(update={"files": type(tables.files)(**files)})
    require_place(folder, made_of=made_of, overwrite=overwrite)
    # One that is not there is nobody's.
    held = occupied(folder, f"the record {record.name}") if folder.is_dir() else nullcontext()
    with (
        held,
        writing(RecordError, f"cannot write the record to {folder}"),
        folder_in_one_step(folder, in_place_of=_FILES) as partial,
    ):
        for key, frame in frames.items():
            write_csv(partial / files[key], frame)
        text = toml_text(tables.model_dump(mode="json", exclude_none=True, exclude_unset=True))
        origin = f"\n{_origin(folder, made_of)}\n" if made_of else ""
        write_text(partial / TABLE_FILE_NAME, with_checksums(text + origin, partial, files.values()))
    return folder


def loops_frame(loops: Sequence[MeasuredLoop]) -> "pl.DataFrame":
    """Table of loops with the columns of a record's loops.csv; normal_force_N only if a loop has one."""
    sizes = [loop.time_s.size for loop in loops]
    columns: dict[str, Any] = {
        "repeat": np.repeat([loop.repeat for loop in loops], sizes),
        "cycle": np.repeat([loop.cycle for loop in loops], sizes),
        "sample": np.concatenate([np.arange(size) for size in sizes]),
    }
    for name in ("time_s", "displacement_um", "tangential_force_N"):
        columns[name] = np.concatenate([getattr(loop, name) for loop in loops])
    normal = [
        np.full(loop.time_s.size, np.nan) if loop.normal_force_N is None else loop.normal_force_N for loop in loops
    ]
    if any(loop.normal_force_N is not None for loop in loops):
        columns["normal_force_N"] = np.concatenate(normal)
    return frame_of(columns)


def frame_of(columns: Mapping[str, ArrayLike]) -> "pl.DataFrame":
    """Data frame of these columns (n,), with NaN as empty fields."""
    import polars as pl

    return pl.DataFrame(dict(columns)).with_columns(pl.selectors.float().fill_nan(None))


def with_checksums(text: str, folder: Path, names: Iterable[object]) -> str:
    """`text` of experiment.toml followed by the SHA-256 of the files `names` in its folder, and of the text itself."""
    lines = [f"# sha256 {hashlib.sha256((folder / str(name)).read_bytes()).hexdigest()} {name}\n" for name in names]
    text += "\n# The files as wirewear wrote them. Whoever changes one on purpose deletes its line.\n" + "".join(lines)
    return text + f"# sha256 {hashlib.sha256(text.encode()).hexdigest()} of the text above\n"
