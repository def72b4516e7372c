"""Tables of a mapping file, which says in which files, columns and units a laboratory's data are."""

import re
from pathlib import Path
from typing import Annotated, Any, Generic

from pydantic import BeforeValidator, Field, PlainValidator

from wirewear.base.files import DELIMITERS, is_encoding_of_text
from wirewear.base.units import FIELD_UNITS, UNITS_PER_LENGTH, Quantity
from wirewear.base.words import shown
from wirewear.records.common_tables import Metadata, of_kinds
from wirewear.records.contact_tables import Bodies, BodiesTest, JointTest, LineTest
from wirewear.records.importing.height_maps import MapScale
from wirewear.records.importing.loggers import readers
from wirewear.records.tables import Frame, Noise, PointTest, RecordConditions, Stated, WiresTest
from wirewear.test.keys import CheckedFlag, Table, checked_text, one_of
from wirewear.test.lengths import extent_of

PROFILOMETER = "profilometer"  #: Kind of the files that hold a height map, which SurfaceTopography reads.

StepOfPoints = Annotated[float, PlainValidator(Quantity("um", 1e-3, 1e3))]
Lines = Annotated[int, PlainValidator(Quantity("1", 0, 100_000, whole=True))]


def _checked_delimiter(value: object) -> str:
    names = {sign: name for name, sign in DELIMITERS.items()}
    name = names.get(value, value) if isinstance(value, str) else value
    if name not in DELIMITERS:
        known = ", ".join(f'"{name}"' for name in DELIMITERS)
        raise ValueError(f'is {shown(value)}, but must be one of {known}, or the sign itself such as ";"')
    return str(name)


def _checked_kind(value: object) -> str:
    return one_of(*readers(), PROFILOMETER)(value)


def _checked_encoding(value: object) -> str:
    name = checked_text(value)
    if not is_encoding_of_text(name):
        raise ValueError(f'is {shown(value)}, but must be an encoding of text such as "utf-8" or "latin-1"')
    return name


def _checked_pattern(value: object) -> str:
    text = checked_text(value)
    try:
        groups = set(re.compile(text).groupindex)
    except re.error as problem:
        raise ValueError(f"is {shown(value)}, but is no regular expression ({problem})") from None
    if not groups or groups - {"repeat", "cycle"}:
        raise ValueError(f"is {shown(value)}, but must have groups named cycle or repeat such as '_(?P<cycle>\\d+)'")
    return text


def _checked_files(value: object) -> tuple[str, ...]:
    names = [value] if isinstance(value, str) else value
    if not isinstance(names, list | tuple) or not names or not all(isinstance(n, str) and n.strip() for n in names):
        raise ValueError(f'is {shown(value)}, but must be a file, a pattern such as "cycle_*.csv", or a list of them')
    for name in names:
        if Path(name).is_absolute() or ".." in Path(name).parts:
            raise ValueError(f"is {shown(value)}, but must name files beside the mapping or in folders there")
    return tuple(names)


def _as_table(value: object) -> object:
    """Table of a column that is given by its name or number alone."""
    return {"column": value} if isinstance(value, str | int) and not isinstance(value, bool) else value


def _checked_column(value: object) -> str | int:
    whole = isinstance(value, int) and not isinstance(value, bool) and value >= 1
    if whole or (isinstance(value, str) and value.strip()):
        return value  # type: ignore[return-value]
    raise ValueError(f"is {shown(value)}, but must be the column's name, or its number from 1 on")


class ColumnMapping(Table):
    """Where a record's column comes from: value = raw · unit · factor + offset."""

    column: Annotated[str | int, PlainValidator(_checked_column)] = Field(
        description="name or number of the column in the file, or path of the MATLAB variable", examples=["Force"]
    )
    file: Annotated[str | None, PlainValidator(lambda value: _checked_files(value)[0])] = Field(
        None, description="file beside the other one where this channel has its own"
    )
    unit: Annotated[str | None, PlainValidator(checked_text)] = Field(None, description="unit in the file")
    factor: Annotated[float, PlainValidator(Quantity("1", -1e12, 1e12))] = Field(1.0, description="calibration factor")
    offset: Annotated[float, PlainValidator(Quantity("1", -1e12, 1e12))] = Field(
        0.0, description="what is added, in the record's unit"
    )


Column = Annotated[ColumnMapping, BeforeValidator(_as_table)]
OptionalColumn = Annotated[ColumnMapping | None, BeforeValidator(_as_table)]


class LoopColumns(Table):
    """Columns of the loops; missing ones follow from file names, the sample rate or the frequency."""

    displacement_um: Column = Field(description="displacement")
    tangential_force_N: Column = Field(description="tangential force")
    normal_force_N: OptionalColumn = Field(None, description="normal force")
    time_s: OptionalColumn = Field(None, description="time")
    cycle: OptionalColumn = Field(None, description="number of the cycle")
    repeat: OptionalColumn = Field(None, description="number of the repeat")


class EvolutionColumns(Table):
    """Where the columns of the evolution come from; None for those that the files lack."""

    cycle: Column = Field(description="number of the cycle")
    displacement_amplitude_um: OptionalColumn = Field(None, description="displacement amplitude")
    slip_amplitude_um: OptionalColumn = Field(None, description="slip amplitude")
    max_tangential_force_N: OptionalColumn = Field(None, description="largest tangential force")
    dissipated_energy_mJ: OptionalColumn = Field(None, description="dissipated energy")
    repeat: OptionalColumn = Field(None, description="number of the repeat")


class PointColumns(Table):
    """Columns of a scar's map given as points."""

    x_um: Column = Field(description="position along the motion")
    y_um: Column = Field(description="position across the motion")
    depth_um: OptionalColumn = Field(None, description="worn depth")
    height_um: OptionalColumn = Field(None, description="height of the surface, in place of the worn depth")
    repeat: OptionalColumn = Field(None, description="number of the repeat")


class Source(Table):
    """Files of one kind of data, and how they are spelled (encoding, delimiter, header)."""

    files: Annotated[tuple[str, ...], PlainValidator(_checked_files)] = Field(
        description="file, pattern or list of them, beside the mapping", examples=["cycle_*.csv"]
    )
    kind: Annotated[str, PlainValidator(_checked_kind)] = Field("text", description="kind of the files")
    encoding: Annotated[str, PlainValidator(_checked_encoding)] = Field("utf-8-sig", description="encoding of the text")
    delimiter: Annotated[str, PlainValidator(_checked_delimiter)] = Field("comma", description="what separates columns")
    decimal: Annotated[str, PlainValidator(one_of(".", ","))] = Field(".", description="decimal sign")
    header_lines: Lines = Field(0, description="lines before the column names")
    names_line: CheckedFlag = Field(True, description="whether a line names the columns")
    lines_after_names: Lines = Field(0, description="lines between the column names and the numbers, such as units")
    rows: Annotated[int | None, PlainValidator(Quantity("1", 1, 1e9, whole=True))] = Field(
        None, description="lines of numbers that are read, where others stand below them"
    )
    blocks: CheckedFlag = Field(
        False, description="whether several tables, or sheets, below the same names are read, numbered by words"
    )
    name_pattern: Annotated[str | None, PlainValidator(_checked_pattern)] = Field(
        None, description="regular expression that finds cycle and repeat in a file's name"
    )
    repeat: Annotated[int, PlainValidator(Quantity("1", 0, 1e6, whole=True))] = Field(
        1, description="number of the repeat where nothing else states it"
    )


class LoopSource(Source):
    """Files of loops: one for each cycle, or one for all."""

    columns: LoopColumns = Field(description="columns of the loops")
    sample_rate_Hz: Annotated[float | None, PlainValidator(Quantity("Hz", 1e-3, 1e9))] = Field(
        None, description="samples per second, where there is no column of time"
    )
    first_cycle: Annotated[int, PlainValidator(Quantity("cycles", 0, 1e9, whole=True))] = Field(
        1, description="number of the first cycle of a file that is cut into cycles by the frequency"
    )


class EvolutionSource(Source):
    """Files of the evolution over the cycles, each with one row for a cycle."""

    columns: EvolutionColumns = Field(description="columns of the evolution")


class MapSource(Source):
    """Files that may be a profilometer's maps, with the scale of those that do not state it."""

    step_um: StepOfPoints | None = Field(
        None, description="distance from point to point of heights without positions, of a map along x and y"
    )
    step_y_um: StepOfPoints | None = Field(None, description="distance along y of a map's points, where it is another")
    height_unit: Annotated[str | None, PlainValidator(one_of(*FIELD_UNITS["um"]))] = Field(
        None, description="unit of a map's heights, where it does not state it"
    )

    @property
    def scale(self) -> MapScale:
        """The step and the unit of heights that the mapping states, for maps that do not; None for unstated ones."""
        return MapScale(self.step_um, self.step_y_um, self.height_unit)


class ScarSource(MapSource):
    """Files of a body's scars: points in columns, or a profilometer's maps, one file for each repeat."""

    columns: PointColumns | None = Field(None, description="columns of the points")
    frame: Frame | None = Field(
        None,
        description='what x runs along: "test", the motion (of depths without a word), or "wire", the body\'s axis',
    )
    axis: Annotated[str, PlainValidator(one_of("x", "y"))] = Field(
        "x", description='direction of a map along which the body\'s axis runs, where its frame is "wire"'
    )
    subtract_wire: CheckedFlag = Field(
        True, description="whether the unworn surface (a cylinder, a ball, a flat) is fitted and subtracted"
    )


class Scars(Table):
    """Where the scar maps of each body are; None for bodies without scars."""

    moving: ScarSource | None = Field(None, description="scars of the moving wire")
    fixed: ScarSource | None = Field(None, description="scars of the fixed wire")
    flat: ScarSource | None = Field(None, description="scars of the flat")
    ball: ScarSource | None = Field(None, description="scars of the ball")
    lower: ScarSource | None = Field(None, description="scars of the lower body")
    upper: ScarSource | None = Field(None, description="scars of the upper body")


class PointMapping(PointTest):
    """Tables of any point contact's mapping file, besides those of its bodies."""

    conditions: RecordConditions = Field(description="load, stroke, frequency and length of the test")
    stated: Stated = Field(Stated(), description="what the rig's owner states")
    noise: Noise = Field(Noise(), description="noise of one sample")
    metadata: Metadata = Field(Metadata(), description="surroundings, surfaces and origin of the test")
    loops: LoopSource = Field(description="where the loops are")
    evolution: EvolutionSource | None = Field(None, description="where the evolution is")
    scars: Scars = Field(Scars(), description="where the scar maps are")

    @property
    def surfaces(self) -> Scars:
        return self.scars

    def require_whole(self, where: str) -> None:
        super().require_whole(where)
        self.require_bodies(f"[scars] of {where}", self.scars)


class Mapping(PointMapping, WiresTest):
    """All tables of a mapping file for crossed wires."""


class BodiesMapping(PointMapping, BodiesTest[Bodies], Generic[Bodies]):
    """All tables of a mapping file for two bodies that touch at a point."""


def unit_factor(name: str, mapping: ColumnMapping, length_mm: float | None = None) -> float:
    """Factor from the file's unit and calibration to the unit of the record's column `name`.

    length_mm: of a line contact, for whose whole length units per length then stand; None for contacts at a point.
    Raises ValueError, naming the known units, if the unit is unknown for this column.
    """
    suffix = name.rpartition("_")[2]
    if mapping.unit is None:
        return mapping.factor
    if mapping.unit == "V":
        if mapping.factor == 1.0:
            raise ValueError(f"{name} is in volts, so it needs a factor in {suffix} per volt")
        return mapping.factor
    known: dict[str, Any] = FIELD_UNITS.get(suffix, {})
    known = known | extent_of(length_mm).units(UNITS_PER_LENGTH.get(suffix, {}))
    if mapping.unit not in known:
        raise ValueError(f"{name} cannot be in {mapping.unit!r}: the units known there are {', '.join([*known, 'V'])}")
    return float(known[mapping.unit]) * mapping.factor


class ProfileColumns(Table):
    """Columns of a worn profile along the sliding direction."""

    x_um: OptionalColumn = Field(None, description="position along the motion; without it, `step_um` of the source")
    depth_um: OptionalColumn = Field(None, description="worn depth")
    height_um: OptionalColumn = Field(None, description="height of the surface, in place of the worn depth")
    repeat: OptionalColumn = Field(None, description="number of the repeat")


class ProfileSource(MapSource):
    """Files of a body's profiles: a stylus's lines in columns, or a profilometer's maps, one file for each repeat."""

    columns: ProfileColumns | None = Field(None, description="columns of the profile")
    axis: Annotated[str, PlainValidator(one_of("x", "y"))] = Field(
        "x", description="direction of a map along the motion"
    )
    subtract_face: CheckedFlag = Field(
        True, description="whether the unworn face, with level and tilt free, is fitted to heights and subtracted"
    )


class Profiles(Table):
    """Where the worn profiles at the end of the test are; None for a body without one."""

    pad: ProfileSource | None = Field(None, description="profiles of the pad")
    specimen: ProfileSource | None = Field(None, description="profiles of the specimen")


class LineMapping(LineTest):
    """All tables of a mapping file for a line contact."""

    loops: LoopSource | None = Field(None, description="where the loops are; forces may be in N/mm")
    evolution: EvolutionSource | None = Field(None, description="where the evolution is")
    profiles: Profiles = Field(Profiles(), description="where the profiles are")

    @property
    def surfaces(self) -> Profiles:
        return self.profiles


class JointMapping(JointTest):
    """All tables of a mapping file for a joint."""

    loops: LoopSource = Field(description="where the loops are")
    evolution: EvolutionSource | None = Field(None, description="where the evolution is")

    @property
    def surfaces(self) -> Table:
        """Empty table, as joints have no worn surfaces."""
        return Table()


#: Mappings by the names of kinds of contact.
MAPPINGS: dict[str, type[PointMapping | LineMapping | JointMapping]] = of_kinds(
    Mapping, LineMapping, JointMapping, BodiesMapping
)
