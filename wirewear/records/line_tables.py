"""The tables of a line contact's experiment.toml (format 1, second edition)."""

from typing import Annotated, Literal

from pydantic import Field, PlainValidator

from wirewear.base.errors import RecordError
from wirewear.planar.tables import KINDS, Extent, PadFace
from wirewear.records.metadata import Metadata
from wirewear.records.tables import (
    DisplacementNoise,
    FileName,
    Noise,
    RecordConditions,
    StatedFrictionEvolution,
    StatedScatter,
    StatedWearRateEvolution,
)
from wirewear.study.keys import (
    FORMAT,
    ArchardCoefficient,
    Friction,
    HolderStiffness,
    MaterialName,
    OfMaterial,
    PivotHeight,
    PoissonsRatio,
    RotationalStiffness,
    SpringStiffness,
    Table,
    WearCoefficient,
    YoungsModulus,
    checked_format,
    checked_text,
    one_of,
)


class RecordContact(Table):
    """What touches: loads and forces of the record are those of the whole contact."""

    kind: Annotated[Literal["line-contact", "cylinder-on-flat"], PlainValidator(one_of(*KINDS))] = Field(
        description="kind of contact", examples=[KINDS[0]]
    )
    length_mm: Extent = Field(description="length of the line contact", examples=[10.0])


class RecordBody(OfMaterial):
    """A body: its elastic constants, and how far from the contact it is held; None where the owner does not say."""

    height_mm: Extent | None = Field(None, description="height between the contact and where the body is held")
    half_width_mm: Extent | None = Field(None, description="half of the body's width along the motion")

    material: MaterialName | None = Field(
        None, description="name of a material of the table, in place of its constants"
    )
    youngs_modulus_MPa: YoungsModulus = Field(description="Young's modulus", examples=[200000.0])
    poissons_ratio: PoissonsRatio = Field(description="Poisson's ratio", examples=[0.3])


class RecordPad(PadFace, RecordBody):
    """The pad: its face and its elastic constants."""


class LineConditions(RecordConditions):
    """What was asked of the rig."""

    motion: Annotated[Literal["triangular", "sinusoidal"], PlainValidator(one_of("triangular", "sinusoidal"))] = Field(
        "sinusoidal", description='displacement over time: "sinusoidal" or "triangular"'
    )


class LineStated(Table):
    """What the rig's owner believes; what is not stated is believed ideal."""

    friction: Friction | None = Field(None, description="coefficient of friction", examples=[0.9])
    pad_energy_wear_coefficient_mm3_per_J: WearCoefficient | None = Field(
        None, description="worn volume of the pad per dissipated energy"
    )
    specimen_energy_wear_coefficient_mm3_per_J: WearCoefficient | None = Field(
        None, description="worn volume of the specimen per dissipated energy"
    )
    pad_archard_wear_coefficient_mm3_per_N_m: ArchardCoefficient | None = Field(
        None, description="worn volume of the pad per load and sliding distance"
    )
    specimen_archard_wear_coefficient_mm3_per_N_m: ArchardCoefficient | None = Field(
        None, description="worn volume of the specimen per load and sliding distance"
    )
    tangential_stiffness_N_per_mm: HolderStiffness = Field(
        "rigid", description='stiffness of the rig along the motion, a number or "rigid"', examples=[5000.0]
    )
    stiffness_includes: Annotated[Literal["rig only", "bodies"], PlainValidator(one_of("rig only", "bodies"))] = Field(
        "rig only", description='what that stiffness is of: "rig only", or "bodies" where pad and specimen add to it'
    )
    rotational_stiffness_N_mm_per_rad: RotationalStiffness = Field(
        "rigid", description='stiffness against rotation about a pivot above the contact, a number or "rigid"'
    )
    pivot_height_mm: PivotHeight | None = Field(None, description="height of that pivot above the contact")
    normal_spring_stiffness_N_per_mm: SpringStiffness = Field(
        0.0, description="stiffness of the loading spring; 0 is a dead weight"
    )
    friction_evolution: StatedFrictionEvolution | None = Field(None, description="running-in of the friction")
    wear_rate_evolution: StatedWearRateEvolution | None = Field(None, description="running-in of the wear")

    @property
    def final_friction(self) -> float | None:
        """Coefficient of friction once it has run in; None where it is not stated."""
        return self.friction if self.friction_evolution is None else self.friction_evolution.final


class LineNoise(Noise):
    """Standard deviations of one sample; None where the owner does not know."""

    depth_um: DisplacementNoise | None = Field(
        None, description="error of one depth of a profile, such as that of reading it from a figure", examples=[0.05]
    )


class LineFiles(Table):
    """Where the data stand, beside experiment.toml; any may be missing, but not all."""

    loops: FileName | None = Field(None, description="file of the loops", examples=["loops.csv"])
    evolution: FileName | None = Field(None, description="file of the evolution over the cycles")
    profile_pad: FileName | None = Field(None, description="file of the pad's worn profile at the end")
    profile_specimen: FileName | None = Field(None, description="file of the specimen's worn profile at the end")


class LineTest(Table):
    """What is said of a line contact's test beside its data."""

    format: Annotated[int, PlainValidator(checked_format)] = Field(
        description="version of the record's format", examples=[FORMAT]
    )
    name: Annotated[str, PlainValidator(checked_text)] = Field(
        description="title of the experiment", examples=["test 3"]
    )
    contact: RecordContact = Field(description="what touches")
    pad: RecordPad = Field(description="the pad")
    specimen: RecordBody = Field(description="the flat")
    conditions: LineConditions = Field(description="load, stroke, frequency and length of the test")
    stated: LineStated = Field(LineStated(), description="what the rig's owner believes")
    noise: LineNoise = Field(LineNoise(), description="noise of one sample")
    scatter: StatedScatter = Field(StatedScatter(), description="scatter between tests on fresh specimens")
    metadata: Metadata = Field(Metadata(), description="surroundings, surfaces and origin of the test")

    def require_face(self, where: str) -> None:
        """See that the pad has one face.

        Raises:
            RecordError: it has none, or several.
        """
        if (wanted := self.pad.missing_face(self.contact.kind)) is not None:
            raise RecordError(f"[pad] of {where} does not say which face the pad has: {wanted}.")


class LineRecordTables(LineTest):
    """The whole of a line contact's experiment.toml."""

    files: LineFiles = Field(description="names of the data files")
