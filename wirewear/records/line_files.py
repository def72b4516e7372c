"""Line contacts' records on disk: experiment.toml with [contact], CSV files beside it."""

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from wirewear.base.errors import RecordError
from wirewear.base.locks import occupied
from wirewear.base.reading import read_toml, toml_text
from wirewear.base.recognised import TABLE_FILE_NAME
from wirewear.base.writing import write_csv, write_text, writing
from wirewear.records.columns import Column, ColumnTable, read_columns
from wirewear.records.line_tables import LineFiles, LineRecordTables
from wirewear.records.line_values import BODIES, LineRecord, MeasuredProfile
from wirewear.records.normal_force import pressing
from wirewear.records.reading import (
    EVOLUTION_COLUMNS,
    LOOP_COLUMNS,
    data_file,
    evolution_in,
    loops_in,
    sorted_rows,
)
from wirewear.records.toml_file import read_tables, require_unchanged, with_checksums
from wirewear.records.writing import evolution_frame, frame_of, loops_frame

_REPEAT = Column("repeat", 0, 1e6, whole=True, complete=True)
PROFILE_COLUMNS = (_REPEAT, Column("x_um", -1e6, 1e6, complete=True), Column("depth_um", -1e4, 1e4, complete=True))


def is_line_record(path: str | Path) -> bool:
    """Whether a record's folder, its experiment.toml or a mapping is of a line contact: it has a table [contact]."""
    path = Path(path)
    table = path / TABLE_FILE_NAME if path.is_dir() else path
    try:
        tables = read_toml(table, RecordError) if table.is_file() else {}
    except RecordError:
        return False  # to be told by whoever reads it
    # A study has one, too, and says of which kind it is.
    return "contact" in tables and "kind" not in tables


def read_line_record(folder: str | Path) -> LineRecord:
    """Read the record of a line contact; loops, evolution and profiles may be missing, but not all.

    Raises:
        RecordError: it cannot be read; one sentence with file, line and column.
    """
    folder = Path(folder)
    if folder.name == TABLE_FILE_NAME and not folder.is_dir():
        folder = folder.parent
    tables, notes = read_tables(folder / TABLE_FILE_NAME, LineRecordTables)
    tables.require_face(str(folder / TABLE_FILE_NAME))
    notes = (*notes, *require_unchanged(folder / TABLE_FILE_NAME))
    files = tables.files
    if not any(getattr(files, key) for key in LineFiles.model_fields):
        raise RecordError(f"{folder / TABLE_FILE_NAME}: [files] names no file, so there is nothing recorded.")
    loops, evolution = (), ()
    if files.loops is not None:
        loops, turned = pressing(tuple(loops_in(read_columns(data_file(folder, files, "loops"), LOOP_COLUMNS))))  # type: ignore[assignment]
        notes = (*notes, *turned)
    if files.evolution is not None:
        evolution = tuple(evolution_in(read_columns(data_file(folder, files, "evolution"), EVOLUTION_COLUMNS)))  # type: ignore[assignment]
    profiles: list[MeasuredProfile] = []
    for body in BODIES:
        if getattr(files, f"profile_{body}") is not None:
            table = read_columns(data_file(folder, files, f"profile_{body}"), PROFILE_COLUMNS)
            profiles += _profiles(table, body)
    return LineRecord(tables, loops, evolution, tuple(profiles), notes, folder)


def write_line_record(folder: str | Path, record: LineRecord) -> Path:
    """Write a record to `folder`, which is made if need be, and return it; experiment.toml comes last.

    Raises:
        RecordError: nothing is recorded, or a file cannot be written.
        RunError: the folder cannot be made, or another command is writing to it.
    """
    folder = Path(folder)
    frames: dict[str, Any] = {}
    if record.loops:
        frames["loops"] = loops_frame(record.loops)
    if record.evolution:
        frames["evolution"] = evolution_frame(record.evolution)
    for body in BODIES:
        if own := record.profiles_of(body):
            columns = {
                "repeat": np.concatenate([np.full(one.x_um.size, one.repeat) for one in own]),
                "x_um": np.concatenate([one.x_um for one in own]),
                "depth_um": np.concatenate([one.depth_um for one in own]),
            }
            frames[f"profile_{body}"] = frame_of(columns)
    if not frames:
        raise RecordError(f"the record {record.name!r} holds nothing, so it cannot be written.")
    files = {key: f"{key}.csv" for key in frames}
    tables = record.tables.model_copy(update={"files": LineFiles(**files)})
    with occupied(folder, f"the record {record.name}"), writing(RecordError, f"cannot write the record to {folder}"):
        for key, frame in frames.items():
            write_csv(folder / files[key], frame)
        text = toml_text(tables.model_dump(mode="json", exclude_none=True))
        write_text(folder / TABLE_FILE_NAME, with_checksums(text, folder, files))
        for key in LineFiles.model_fields:
            if key not in files:
                (folder / f"{key}.csv").unlink(missing_ok=True)
    return folder


def _profiles(table: ColumnTable, body: str) -> Iterator[MeasuredProfile]:
    columns = sorted_rows(table, ("repeat", "x_um")).columns
    repeat = columns["repeat"]
    bounds = [0, *(np.flatnonzero(np.diff(repeat)) + 1).tolist(), repeat.size]
    for start, stop in pairwise(bounds):
        if stop - start < 3:
            raise RecordError(f"{table.path}: the profile of repeat {repeat[start]:g} has fewer than three points.")
        part = slice(start, stop)
        yield MeasuredProfile(int(repeat[start]), body, columns["x_um"][part], columns["depth_um"][part])
