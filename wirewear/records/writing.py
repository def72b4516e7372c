"""Writing an experiment record, file by file and each in one step; experiment.toml comes last."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from wirewear.base.errors import RecordError
from wirewear.base.locks import occupied
from wirewear.base.reading import toml_text
from wirewear.base.recognised import TABLE_FILE_NAME
from wirewear.base.writing import write_csv, write_text, writing
from wirewear.records.reading import EVOLUTION_COLUMNS, LOOP_COLUMNS
from wirewear.records.surfaces import MeasuredProfile, MeasuredScar
from wirewear.records.toml_file import with_checksums
from wirewear.records.values import AnyRecord, MeasuredEvolution, MeasuredLoop

if TYPE_CHECKING:
    import polars as pl


def write_record(folder: str | Path, record: AnyRecord) -> Path:
    """Write a record to `folder`, which is made if need be, and return it; numbers keep all their digits.

    The files take the names of format 1; what a record before had there goes. A killed writer leaves no file half
    written.

    Raises:
        RecordError: the record has no loops and must have some, or nothing at all, or a file cannot be written.
        RunError: the folder cannot be made, or another command is writing to it.
    """
    folder, tables = Path(folder), record.tables
    frames = {"loops": loops_frame(record.loops)} if record.loops else {}
    if record.evolution:
        frames["evolution"] = evolution_frame(record.evolution)
    for body in tables.bodies:
        if own := record.scars_of(body):
            frames[f"{tables.worn.name}_{body}"] = _surfaces(own)
    if not frames or (tables.needs_loops and not record.loops):
        what = "has no loops" if tables.needs_loops else "holds nothing"
        raise RecordError(f"the record {record.name!r} {what}, so it cannot be written.")
    files = {key: f"{key}.csv" for key in frames}
    tables = tables.model_copy(update={"files": type(tables.files)(**files)})
    with occupied(folder, f"the record {record.name}"), writing(RecordError, f"cannot write the record to {folder}"):
        for key, frame in frames.items():
            write_csv(folder / files[key], frame)
        text = toml_text(tables.model_dump(mode="json", exclude_none=True, exclude_unset=True))
        write_text(folder / TABLE_FILE_NAME, with_checksums(text, folder, files))
        for key in type(tables.files).model_fields:
            if key not in files and key != "frames":
                (folder / f"{key}.csv").unlink(missing_ok=True)
    return folder


def loops_frame(loops: Sequence[MeasuredLoop]) -> "pl.DataFrame":
    """Loops as the table of a record."""
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
    return frame_of({column.name: columns[column.name] for column in LOOP_COLUMNS if column.name in columns})


def evolution_frame(evolution: Sequence[MeasuredEvolution]) -> "pl.DataFrame":
    """Evolutions as the table of a record."""
    sizes = [part.columns["cycle"].size for part in evolution]
    columns: dict[str, Any] = {"repeat": np.repeat([part.repeat for part in evolution], sizes)}
    for column in EVOLUTION_COLUMNS[1:]:
        columns[column.name] = np.concatenate([part.columns[column.name] for part in evolution])
    columns["cycle"] = columns["cycle"].astype(np.int64)
    return frame_of(columns)


def _surfaces(surfaces: Sequence[MeasuredScar | MeasuredProfile]) -> "pl.DataFrame":
    parts = [{"repeat": np.full(one.points["x_um"].size, one.repeat), **one.points} for one in surfaces]
    return frame_of({name: np.concatenate([part[name] for part in parts]) for name in parts[0]})


def frame_of(columns: Mapping[str, Any]) -> "pl.DataFrame":
    """Columns as a table in which an empty field is a value that is missing."""
    import polars as pl

    return pl.DataFrame(dict(columns)).with_columns(pl.selectors.float().fill_nan(None))
