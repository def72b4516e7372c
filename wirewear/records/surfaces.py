"""Kinds of worn surfaces in records: maps of scars, and profiles across line contacts."""

from dataclasses import dataclass

from wirewear.records.columns import Column
from wirewear.records.profiles import MeasuredProfile
from wirewear.records.scars import MeasuredScar

_REPEAT = Column("repeat", 0, 1e6, whole=True, complete=True)


@dataclass(frozen=True)
class WornSurfaces:
    """One kind of worn surface in records: its names and columns, and words for sentences."""

    name: str  #: Begins the names of files, such as scar_moving; the body follows.
    noun: str  #: Noun for one surface in the summary of an import.
    columns: tuple[Column, ...]  #: Columns of such a file.
    surface: type[MeasuredScar] | type[MeasuredProfile]  #: Class of one surface.
    support: str  #: Sentence on the conclusions that surfaces support.
    fewest: int  #: Number of bodies whose surfaces are needed for that.
    lacking: str  #: Sentence on what is unknown without them, and how to measure them.


SCARS = WornSurfaces(
    "scar",
    "scar map",
    (
        _REPEAT,
        Column("x_um", -1e5, 1e5, complete=True),
        Column("y_um", -1e5, 1e5, complete=True),
        Column("depth_um", -1e4, 1e4),
    ),
    MeasuredScar,
    "Worn volume, depth and shape of both scars at the end; the crossing angle by their skew.",
    2,
    "Worn volume and shape, and the crossing angle: there is no scar of the {}. A profilometer's map of it, or "
    "its points x, y, height, can be imported ([scars.*] of a mapping).",
)
#: Of a test without bodies.
NO_SURFACES = WornSurfaces("surface", "surface", (), MeasuredScar, "", 1, "")
PROFILES = WornSurfaces(
    "profile",
    "profile",
    (_REPEAT, Column("x_um", -1e6, 1e6, complete=True), Column("depth_um", -1e4, 1e4, complete=True)),
    MeasuredProfile,
    "Depth, width and worn area of the {} at the end.",
    1,
    "Depth, width and worn area of the {}: there is no profile of it. A stylus's line or a profilometer's map across "
    "the scar can be imported ([profiles.*] of a mapping).",
)
