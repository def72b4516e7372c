"""The tables of a line contact's experiment.toml (format 1, second edition)."""

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import Field, PlainValidator

from wirewear.base.errors import RecordError
from wirewear.planar.tables import CYLINDER_ON_FLAT, KINDS, Extent, PadFace
from wirewear.records.metadata import Metadata
from wirewear.records.surfaces import PROFILES
from wirewear.records.tables import (
    DisplacementNoise,
    FileName,
    Noise,
    OfTest,
    RecordConditions,
    RecordTables,
    StatedFriction,
    StatedRig,
    StatedScatter,
    Tolerance,
    known_of,
)
from wirewear.results.scar import BODIES
from wirewear.study.keys import (
    FORMAT,
    ArchardCoefficient,
    MaterialName,
    OfMaterial,
    PoissonsRatio,
    Table,
    WearCoefficient,
    YoungsModulus,
    checked_format,
    checked_text,
    one_of,
)

#: Keys of a study of one millimetre by those of a record, and whether the record's are of the whole length.
OF_WHOLE = {
    "normal_load_N_per_mm": ("normal_load_N", True),
    "tangential_stiffness_N_per_mm2": ("tangential_stiffness_N_per_mm", True),
    "rotational_stiffness_N_per_rad": ("rotational_stiffness_N_mm_per_rad", True),
    "normal_spring_stiffness_N_per_mm2": ("normal_spring_stiffness_N_per_mm", True),
    **{
        f"{body}_{law}_{unit}": (f"{body}_{law}_wear_coefficient_{unit}", False)
        for body in BODIES
        for law, unit in (("energy", "mm3_per_J"), ("archard", "mm3_per_N_m"))
    },
}


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


class LineStatedWear(Table):
    """The wear that the rig's owner states, of either body."""

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


class LineStated(StatedRig, LineStatedWear, StatedFriction):
    """What the rig's owner states; what is not stated is taken as ideal."""

    stiffness_includes: Annotated[Literal["rig only", "bodies"], PlainValidator(one_of("rig only", "bodies"))] = Field(
        "rig only", description='what that stiffness is of: "rig only", or "bodies" where pad and specimen add to it'
    )


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


class LineTest(OfTest):
    """What is said of a line contact's test beside its data."""

    contact_kind, described_by, bodies = KINDS[0], "contact", BODIES
    worn, needs_loops = PROFILES, False

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
    tolerance: Tolerance = Field(Tolerance(), description="differences that count as none")
    metadata: Metadata = Field(Metadata(), description="surroundings, surfaces and origin of the test")

    @property
    def length_mm(self) -> float:
        """Length of the contact."""
        return self.contact.length_mm

    @property
    def depth_noise_um(self) -> float:
        """Of reading a profile, as from a figure."""
        return self.noise.depth_um or 0.0

    @classmethod
    def require_length(cls, length_mm: float | None, label: str) -> None:
        """See that it is given; RecordError otherwise."""
        if not length_mm:
            raise RecordError(f"the forces of {label} are per millimetre: give its --length for a record.")

    @classmethod
    def bodies_of(cls, study: Mapping[str, Any], label: str, length_mm: float | None) -> dict[str, Any]:
        """What touches, the pad and the specimen."""
        del label
        round_pad = study["pad"].get("radius_mm") is not None
        return {
            "contact": {"kind": CYLINDER_ON_FLAT if round_pad else KINDS[0], "length_mm": length_mm},
            "pad": known_of(RecordPad, {**study["pad"], "material": None}),
            "specimen": known_of(RecordBody, {**study["specimen"], "material": None}),
        }

    @classmethod
    def stated_by(cls, study: Mapping[str, Any], length_mm: float | None) -> dict[str, Any]:
        """The same with what is per length times the length; a body without a coefficient does not wear."""
        found = super().stated_by(study, length_mm)
        for own, (key, per_length) in OF_WHOLE.items():
            value = found.pop(own, None)
            if value is not None and (value != 0.0 or per_length):
                found[key] = value * (length_mm or 1.0) if per_length and not isinstance(value, str) else value
        return found

    def require_whole(self, where: str) -> None:
        """See that the pad has one face.

        Raises:
            RecordError: it has none, or several.
        """
        if (wanted := self.pad.missing_face(self.contact.kind)) is not None:
            raise RecordError(f"[pad] of {where} does not say which face the pad has: {wanted}.")

    @property
    def missing(self) -> tuple[str, ...]:
        """What [stated] lacks for a simulation."""
        worn = any(getattr(self.stated, key) is not None for key in LineStatedWear.model_fields)
        needs = {"friction": self.stated.final_friction is not None, "a wear coefficient of pad or specimen": worn}
        return tuple(key for key, given in needs.items() if not given)

    @property
    def assumed(self) -> str:
        """What a simulation takes of the bodies is a remark of its own."""
        return ""


class LineRecordTables(LineTest):
    """The whole of a line contact's experiment.toml."""

    files: LineFiles = Field(description="names of the data files")


#: Tables of records by the names of kinds of contact.
TABLES: dict[str, type[RecordTables | LineRecordTables]] = {
    model.contact_kind: model for model in (RecordTables, LineRecordTables)
}
