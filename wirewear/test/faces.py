"""Faces of pads as a study states them: of a line contact's pad, and of a pad of revolution about the normal.

A face is the profile of a pad along the motion (or along any radius): round, flat with rounded edges, or tabled.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, Field, PlainValidator, model_validator

from geometry import Cylinder, GeometryError, RoundedFlat, TabledProfile
from wirewear.base import kinds
from wirewear.base.errors import RecordError
from wirewear.base.units import Quantity
from wirewear.base.words import shown
from wirewear.test.keys import Table, pairs_of

Face = Cylinder | RoundedFlat | TabledProfile

Radius = Annotated[float, PlainValidator(Quantity("mm", 0.05, 1000.0))]
Extent = Annotated[float, PlainValidator(Quantity("mm", 0.02, 500.0))]

COLUMNS = ("x_um", "height_um")  #: Columns of a file of a profile.
MOST_POINTS = 1_000  #: Points of a file beyond this number are averaged in groups of neighbours.

#: Half-width of a body that does not state it: at most, and as a share of a round face's radius.
WIDEST_mm, _ACROSS_RADIUS = 10.0, 0.8


#: Sets of keys that make one face.
_FACES = (
    {"radius_mm"},
    {"face_half_width_mm", "edge_radius_mm"},
    {"face_half_width_mm", "radius_mm"},
    {"profile_points_mm"},
)


_ANY_FACE = (
    "give radius_mm, or face_half_width_mm with edge_radius_mm or with radius_mm, or profile_points_mm or profile_file"
)
#: For some kinds of contact: the sets of keys allowed, and advice for messages.
_OF_KINDS = {kinds.CYLINDER_ON_FLAT: (_FACES[:1], "give radius_mm, the radius of the cylinder, and no other face")}


def half_width_of(face: Face) -> float:
    """Half-width in mm that a pad gets if its study does not state it."""
    match face:
        case Cylinder(radius_mm=radius):
            return min(WIDEST_mm, _ACROSS_RADIUS * radius)
        case RoundedFlat(half_width_mm=flat, edge_radius_mm=radius):
            return min(flat + WIDEST_mm, _ACROSS_RADIUS * radius + (0.0 if face.cut else flat))
        case TabledProfile():
            return min(WIDEST_mm, face.reach_mm)


def _checked_profile(value: object) -> tuple[tuple[float, float], ...]:
    points = pairs_of(value, "[[0, 0], [0.5, 0.001], [1, 0.02]]")
    try:
        TabledProfile(points)
    except GeometryError as problem:
        raise ValueError(f"does not describe a face: {problem}") from None
    return points


def _points_of_file(name: object) -> list[tuple[float, float]]:
    """Pairs of x and fall below the highest point in mm, from a table of heights in µm."""
    from wirewear.base.guessing import known_columns

    if not isinstance(name, str):
        raise ValueError(f'gives profile_file = {shown(name)}, but must give a name such as "pad.csv"')
    try:
        columns = known_columns(Path(name), COLUMNS)
        if missing := [column for column in COLUMNS if column not in columns]:
            raise RecordError(f"{name} has no column {' and no '.join(missing)}.")
    except RecordError as problem:
        raise ValueError(f"gives a profile_file that cannot be taken: {str(problem).rstrip('.')}") from None
    x, height = (columns[column] for column in COLUMNS)
    groups = [np.array_split(1e-3 * values, min(x.size, MOST_POINTS)) for values in (x, np.max(height) - height)]
    places, fall = (np.array([group.mean() for group in own]) for own in groups)
    return list(zip(places.tolist(), (fall - fall.min()).tolist(), strict=True))


def size_of(face: Face) -> float:
    """Length in mm from which a turned pad's extents are chosen: radius, half-width of the flat, or reach."""
    match face:
        case Cylinder(radius_mm=radius):
            return radius
        case RoundedFlat(half_width_mm=flat):
            return flat
        case TabledProfile():
            return face.reach_mm


class PadFace(Table):
    """Keys of a pad's face: round, flat with rounded edges, a flat cut off a round one, or any other profile."""

    radius_mm: Radius | None = Field(
        None, description="radius of a round pad; with face_half_width_mm a flat is cut off it", examples=[40.0]
    )
    face_half_width_mm: Extent | None = Field(
        None, description="half-width of the flat part of a flat pad's face", examples=[1.9]
    )
    edge_radius_mm: Radius | None = Field(None, description="radius of a flat pad's rounded edges", examples=[3.0])
    profile_points_mm: Annotated[tuple[tuple[float, float], ...], BeforeValidator(_checked_profile)] | None = Field(
        None,
        description="any other pad: pairs [x, fall below its highest point] in mm; from x = 0 on they stand for both "
        "sides, else they go from one to the other",
    )

    @property
    def profile(self) -> Face:
        """The face that these keys state, if they state exactly one (`missing_face` returns None)."""
        if self.profile_points_mm is not None:
            return TabledProfile(self.profile_points_mm)
        if self.face_half_width_mm is not None:
            return RoundedFlat(
                self.face_half_width_mm, self.edge_radius_mm or self.radius_mm or 0.0, cut=self.edge_radius_mm is None
            )
        return Cylinder(self.radius_mm or 0.0, curved_along=True)

    def missing_face(self, kind: str = kinds.LINE_CONTACT) -> str | None:
        """The rest of an error message if the keys state no face, several or an impossible one; None if they state one.
        kind: name of the kind of contact in the file.
        """
        faces, wanted = _OF_KINDS.get(kind, (_FACES, _ANY_FACE))
        if {key for key in FACE_KEYS if getattr(self, key) is not None} not in faces:
            return wanted
        try:
            _ = self.profile
        except GeometryError as problem:
            return str(problem)
        return None


FACE_KEYS = tuple(PadFace.model_fields)  #: The keys of a face.


class PadFaceOrFile(PadFace):
    """Keys of a pad's face, or of a file that holds its profile."""

    profile_file: str | None = Field(
        None, description="table of x_um and height_um, taken over as profile_points_mm", examples=["pad.csv"]
    )

    @model_validator(mode="before")
    @classmethod
    def _with_points(cls, table: Any) -> Any:
        if not isinstance(table, Mapping) or table.get("profile_file") is None:
            return table
        if table.get("profile_points_mm") is not None:
            raise ValueError("gives profile_points_mm beside profile_file: give one of the two")
        given = {key: value for key, value in table.items() if key != "profile_file"}
        return given | {"profile_points_mm": _points_of_file(table["profile_file"])}
