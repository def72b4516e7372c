"""What a kind of contact answers to commands; surfaces that a study names as heights, levelled for its bodies."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from functools import reduce
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

import numpy as np

from geometry import Flat
from geometry.arrays import Array
from wirewear.base.errors import StudyError, WirewearError
from wirewear.base.guessing import known_columns
from wirewear.planar import PlanarStudy
from wirewear.records.importing.height_maps import MapScale, height_map, is_map
from wirewear.records.importing.mapping import ScarSource
from wirewear.records.importing.profilometry import MapOfBody, levelled, scar_of_heights, scar_of_map
from wirewear.study import Study
from wirewear.study.messages import validated
from wirewear.study.surfaces import COLUMNS, StatedSurface, kept, surfaces_in

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from wirewear.diagnosis.model.nominal import ObserverOf
    from wirewear.diagnosis.model.setup import Setup
    from wirewear.diagnosis.model.wear_states import WearStates
    from wirewear.interior.strength import Strength, StrengthAsked
    from wirewear.records.exporting import Surface
    from wirewear.records.importing.guessing import GuessedMapping
    from wirewear.study.template import Template


class Kind(Protocol):
    """A kind of contact. Its studies, records and results are its own; whoever has one asks its kind.

    Attributes:
        name: as `kind` in a study and `contact_kind` of studies, records and results say it.
        names: all that `kind` in a study may be, older names too.
        inside_options: options of `wirewear fields` and `strength` that not all kinds know.
        scatters: whether studies state the scatter of their inputs.
        options: keys of its records alone that `wirewear new --mapping` takes as options.
        foresees_scars: whether the fast model's worn bodies are as those of a run, so that both are compared.
        rigid_N_per_mm: a rig as stiff as this takes nothing of any stroke.
    """

    name: ClassVar[str]
    names: ClassVar[tuple[str, ...]]
    inside_options: ClassVar[frozenset[str]]
    scatters: ClassVar[bool]
    options: ClassVar[frozenset[str]]
    foresees_scars: ClassVar[bool]
    rigid_N_per_mm: ClassVar[float]

    @property
    def template(self) -> Template:
        """What a new study begins with."""

    def study_from_tables(self, tables: Mapping[str, Any], where: str) -> Any:
        """A study from nested tables; StudyError in one sentence that names `where`."""

    def run(self, study: Any, **asked: Any) -> list[Any]:
        """Results of a study's variants, each with what belongs into its folder; arguments as of `run_study`."""

    def write_meshes(self, study: Any, fidelity: str, folder: Path) -> list[Path]:
        """Write and draw the meshes of both bodies."""

    @property
    def refined(self) -> Any:
        """What a study of convergence refines and watches."""

    def write_beside(self, results: Sequence[Any], folder: Path) -> None:
        """Write what the folder of a study's runs holds beside their results, for people and other programs."""

    def checked_model(self, record: Any, study: Any) -> Any:
        """A study that is to be diagnosed against a record; RecordError where it is of another test."""

    def states(self, study: Any, tables: Any, observer_of: ObserverOf | None) -> tuple[WearStates, tuple[str, ...]]:
        """Wear states of a finite element run of a record's test, and what that run says against them.
        Raises StudyError or SolverError if the study cannot be run, and RunError if no loop of the run slides as a
        whole.
        """

    def setup(self, study: Any, tables: Any) -> Setup:
        """The circumstances that a study states of a record's test, for the fast model."""

    def with_effects(
        self, study: Any, effects: Sequence[Any], length_mm: float, amplitude_um: float, increments: int
    ) -> Any:
        """A study with further effects of the whole contact and another amplitude, of loops of so many increments."""

    def guessed_mapping(
        self, files: Sequence[Path], known: Mapping[str, Any], own: Mapping[str, float], pad: Mapping[str, float]
    ) -> GuessedMapping:
        """A mapping guessed from files, what is known of the test, and the elastic constants of the bodies."""

    def surfaces(self, result: Any, noise_um: float, seed: int) -> Mapping[str, Surface]:
        """Worn bodies as a profilometer sees them, by names of files."""

    def write_fields(self, result: Any, folder: Path, shown: Mapping[str, Any], **asked: Any) -> list[Path]:
        """Stresses inside both bodies; `shown` is what `inside_options` say, the rest as of `write_fields`."""

    def assessable(self, result: Any, body: str, cycle: float, asked: StrengthAsked) -> int:
        """The recorded cycle nearest to one; ResultError where it does not allow what is asked of a body."""

    def strength(self, result: Any, body: str, cycle: int, asked: StrengthAsked) -> Strength:
        """The strength of a body at a recorded cycle."""

    def drawings(self, results: Sequence[Any]) -> Mapping[str, Callable[[], Figure]]:
        """What can be drawn of results, by file name."""


#: Lines x (n_x,) and y (n_y,) along and across the motion, and depths (n_x, n_y), all in µm.
Map = tuple[Array, Array, Array]

#: Depths of a surface whose own are still to be found.
_LEVEL = kept(np.zeros(2), np.zeros(2), np.zeros((2, 2)))


def with_levelled(
    tables: Mapping[str, Any], where: str, read: Callable[[Mapping[str, Any], str], Study | PlanarStudy]
) -> Mapping[str, Any]:
    """A study's tables with depths in place of files of heights; `read` makes a study of tables.
    Raises StudyError if a file cannot be read, or its surface is not that of the body.
    """
    unworn, whole = deepcopy(dict(tables)), deepcopy(dict(tables))
    files = {place: Path(table["file"]) for place, table in surfaces_in(tables) if isinstance(table.get("file"), str)}
    heights = {place: file for place, file in files.items() if _has_heights(file)}
    for *place, key in heights:
        reduce(dict.__getitem__, place, unworn).pop(key)
    study = read(unworn, where)
    for (*place, key), file in heights.items():
        holder = reduce(dict.__getitem__, place, whole)
        told = {name: value for name, value in holder[key].items() if name != "file"}
        stated = validated(StatedSurface, told | _LEVEL, where, StudyError)
        try:
            of = _of_line if isinstance(study, PlanarStudy) else _of_body
            x, y, depth = of(study, place[-1], file, stated)
        except WirewearError as problem:
            raise StudyError(f"the surface of {place[-1]} in {where} cannot be taken: {problem}") from None
        if stated.centred_on == "map":
            x, y = x - 0.5 * (x[0] + x[-1]), y - 0.5 * (y[0] + y[-1])
        holder[key] = {"frame": "test", **kept(x, y, depth)}
    return whole


def _has_heights(file: Path) -> bool:
    """Whether a file is a map or a table of heights; of one that cannot be read its reader tells."""
    try:
        return file.is_file() and (is_map(file) or "depth_um" not in known_columns(file, COLUMNS))
    except WirewearError:
        return False


def _of_body(study: Any, name: str, file: Path, stated: StatedSurface) -> Map:
    """Of a body of a contact at a point."""
    told = stated.model_dump(include={"step_um", "height_unit"}, exclude_none=True)
    told |= {"files": file.name, "frame": "wire" if stated.frame == "body" else "test"}
    source = ScarSource.model_validate(told)
    of = MapOfBody(file, source, next(body for body in study.bodies if body.name == name), 1)
    columns = {} if is_map(file) else known_columns(file, COLUMNS)
    points = [columns[key] for key in ("x_um", "y_um", "height_um") if key in columns]
    scar = scar_of_heights(of, (points[0], points[1], points[2])) if len(points) == 3 else scar_of_map(of)
    return scar.x_um, scar.y_um, scar.depth_um


def _of_line(study: Any, name: str, file: Path, stated: StatedSurface) -> Map:
    """Of the pad or the specimen of a line contact: the mean over the lines of a map."""
    columns = {} if is_map(file) else known_columns(file, COLUMNS)
    if "x_um" in columns and "height_um" in columns:
        x, height = columns["x_um"], columns["height_um"]
    else:
        x, _, heights = height_map(file, MapScale(stated.step_um, None, stated.height_unit))
        height = np.nanmean(heights, axis=1)
    face = study.pad.profile if name == "pad" else Flat()
    found = levelled(file, 1, name, face, (x, height), subtract=True)
    return found.x_um, np.zeros(1), found.depth_um[:, None]
