"""Surfaces that a study gives as measured heights: levelled against the bodies' unworn shapes into depths."""

from collections.abc import Mapping, Sequence
from copy import deepcopy
from functools import reduce
from pathlib import Path
from typing import Any

import numpy as np

from geometry import Flat
from geometry.arrays import Array
from wirewear.base.errors import RecordError, StudyError, WirewearError
from wirewear.base.guessing import known_columns
from wirewear.records.importing.height_maps import MapScale, height_map, is_map
from wirewear.records.importing.mapping import ScarSource
from wirewear.records.importing.profilometry import MapOfBody, grid_of_points, levelled, scar_of
from wirewear.test import LineStudy, study_from_tables
from wirewear.test.messages import validated
from wirewear.test.surfaces import COLUMNS, StatedSurface, kept_map, surfaces_in

#: Lines x (n_x,) and y (n_y,) along and across the motion, and depths (n_x, n_y), all in µm.
Map = tuple[Array, Array, Array]

#: Depths of a surface whose own are still to be found.
_LEVEL = kept_map(np.arange(2.0), np.arange(2.0), np.zeros((2, 2)))


def with_levelled(tables: Mapping[str, object], where: str) -> Mapping[str, object]:
    """A copy of a study's nested tables with depths, levelled against the unworn bodies, in place of files of heights.

    where: name of the study for messages. Raises StudyError if a file cannot be read, or its surface does not fit the
    body.
    """
    unworn: dict[str, Any] = deepcopy(dict(tables))
    whole: dict[str, Any] = deepcopy(dict(tables))
    files = {place: Path(file) for place, table in surfaces_in(tables) if isinstance(file := table.get("file"), str)}
    heights = {place: file for place, file in files.items() if _has_heights(file)}
    for *place, key in heights:
        reduce(dict.__getitem__, place, unworn).pop(key)
    study = study_from_tables(unworn, where)
    for (*place, key), file in heights.items():
        holder = reduce(dict.__getitem__, place, whole)
        keys = {name: value for name, value in holder[key].items() if name != "file"}
        stated = validated(StatedSurface, keys | _LEVEL, where, StudyError)
        try:
            of = _of_line if isinstance(study, LineStudy) else _of_body
            x, y, depth = of(study, place[-1], file, stated)
        except WirewearError as problem:
            raise StudyError(f"the surface of {place[-1]} in {where} cannot be taken: {problem}") from None
        if stated.centred_on == "map":
            x, y = x - 0.5 * (x[0] + x[-1]), y - 0.5 * (y[0] + y[-1])
        holder[key] = {"frame": "test", **kept_map(x, y, depth)}
    return whole


def _has_heights(file: Path) -> bool:
    """True if a file is a map or a table of heights; False if it cannot be read."""
    try:
        return file.is_file() and (is_map(file) or "depth_um" not in known_columns(file, COLUMNS))
    except WirewearError:
        return False


def _of_body(study: Any, name: str, file: Path, stated: StatedSurface) -> Map:
    keys = stated.model_dump(include={"step_um", "height_unit"}, exclude_none=True)
    keys |= {"files": file.name, "frame": "wire" if stated.frame == "body" else "test"}
    source = ScarSource.model_validate(keys)
    of = MapOfBody(file, source, next(body for body in study.bodies if body.name == name), 1)
    columns = {} if is_map(file) else known_columns(file, COLUMNS)
    if {"x_um", "y_um", "height_um"} <= columns.keys():
        found = grid_of_points(file, (columns["x_um"], columns["y_um"], columns["height_um"]))
    else:
        found = height_map(file, source.scale)
    scar = scar_of(of, *found, form=False)
    _require_certain(scar.levelling_notes)
    return scar.x_um, scar.y_um, scar.depth_um


def _of_line(study: Any, name: str, file: Path, stated: StatedSurface) -> Map:
    """Depths of the pad or the specimen of a line contact, as a map with a single line; a measured map is averaged
    across.
    """
    columns = {} if is_map(file) else known_columns(file, COLUMNS)
    if "x_um" in columns and "height_um" in columns:
        x, height = columns["x_um"], columns["height_um"]
    else:
        x, _, heights = height_map(file, MapScale(stated.step_um, None, stated.height_unit))
        height = np.nanmean(heights, axis=1)
    face = study.pad.profile if name == "pad" else Flat()
    found = levelled(file, 1, name, face, (x, height), subtract=True, form=False)
    _require_certain(found.levelling_notes)
    return found.x_um, np.zeros(1), found.depth_um[:, None]


def _require_certain(sentences: Sequence[str]) -> None:
    """Raise RecordError with the first of `sentences`, doubts about how heights were levelled, if there is any."""
    if sentences:
        raise RecordError(f"{sentences[0]}.")
