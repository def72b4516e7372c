"""The mapping file of a line contact's import: geometry and conditions, and where loops and profiles are."""

from typing import Annotated, Literal

from pydantic import Field, PlainValidator

from wirewear.planar.tables import LineLoad
from wirewear.records.importing.mapping import (
    EvolutionSource,
    LoopSource,
    MapSource,
    OptionalColumn,
    checked_yes_or_no,
    one_of_words,
)
from wirewear.records.line_tables import LineConditions, LineNoise, LineTest
from wirewear.records.tables import StatedScatter
from wirewear.study.keys import NormalLoad, Table, checked_format


class MappedConditions(LineConditions):
    """What was asked of the rig; the load of the whole contact, or per millimetre of it."""

    normal_load_N: NormalLoad | None = Field(None, description="normal load of the whole contact")  # type: ignore[assignment]
    normal_load_N_per_mm: LineLoad | None = Field(
        None, description="normal load per length of the contact, in its place", examples=[18.5]
    )


class ProfileColumns(Table):
    """Columns of a worn profile along the sliding direction."""

    x_um: OptionalColumn = Field(None, description="position along the motion; without it, `step_um` of the source")
    depth_um: OptionalColumn = Field(None, description="worn depth")
    height_um: OptionalColumn = Field(None, description="height of the surface, in place of the worn depth")
    repeat: OptionalColumn = Field(None, description="number of the repeat")


class ProfileSource(MapSource):
    """A body's profiles: a stylus's lines with columns, or a profilometer's maps, one file a repeat."""

    columns: ProfileColumns | None = Field(None, description="columns of the profile")
    axis: Annotated[str, one_of_words("x", "y")] = Field("x", description="direction of a map along the motion")
    subtract_face: Annotated[bool, PlainValidator(checked_yes_or_no)] = Field(
        True, description="whether the unworn face, with level and tilt free, is fitted to heights and subtracted"
    )


class Profiles(Table):
    """Worn profiles at the end of the test."""

    pad: ProfileSource | None = Field(None, description="profiles of the pad")
    specimen: ProfileSource | None = Field(None, description="profiles of the specimen")


class LineMapping(LineTest):
    """A whole mapping file of a line contact."""

    format: Annotated[Literal[1], PlainValidator(checked_format)] = Field(
        description="version of this file's format", examples=[1]
    )
    conditions: MappedConditions = Field(description="load, stroke, frequency and length of the test")
    noise: LineNoise = Field(LineNoise(), description="noise of one sample")
    scatter: StatedScatter = Field(StatedScatter(), description="scatter between tests on fresh specimens")
    loops: LoopSource | None = Field(None, description="where the loops are; forces may be in N/mm")
    evolution: EvolutionSource | None = Field(None, description="where the evolution is")
    profiles: Profiles = Field(Profiles(), description="where the profiles are")
