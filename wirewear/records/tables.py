"""The tables of experiment.toml: every key with its unit, sensible range, default and meaning."""

from typing import Annotated, Literal

from pydantic import Field, PlainValidator

from wirewear.quantity import Quantity, shown
from wirewear.study.keys import (
    FORMAT,
    Amplitude,
    CrossingAngle,
    Cycles,
    Diameter,
    Frequency,
    Friction,
    HolderStiffness,
    NormalLoad,
    PivotHeight,
    PoissonsRatio,
    RotationalStiffness,
    Share,
    SpringStiffness,
    Table,
    WearCoefficient,
    YoungsModulus,
    checked_format,
    checked_text,
)

DRIVES = ("sensor", "stroke")


def _checked_drive(value: object) -> str:
    if value not in DRIVES:
        raise ValueError(f'is {shown(value)}, but must be "sensor" or "stroke"')
    return str(value)


def _checked_file_name(value: object) -> str:
    name = checked_text(value)
    if not name.isprintable() or name.startswith(("/", "\\")) or ".." in name.replace("\\", "/").split("/"):
        raise ValueError(f"is {shown(value)}, but must name a file in the record's own folder")
    return name


FileName = Annotated[str, PlainValidator(_checked_file_name)]
DisplacementNoise = Annotated[float, PlainValidator(Quantity("um", 0.0, 1e3))]
ForceNoise = Annotated[float, PlainValidator(Quantity("N", 0.0, 1e3))]


class RecordWires(Table):
    """What the specimens are: two alike."""

    diameter_mm: Diameter = Field(description="diameter of the wires", examples=[0.45])
    crossing_angle_deg: CrossingAngle = Field(90.0, description="angle between the wires' axes")
    youngs_modulus_MPa: YoungsModulus = Field(description="Young's modulus", examples=[210000.0])
    poissons_ratio: PoissonsRatio = Field(description="Poisson's ratio", examples=[0.3])


class RecordConditions(Table):
    """What was asked of the rig."""

    normal_load_N: NormalLoad = Field(description="normal load between the wires", examples=[2.0])
    displacement_amplitude_um: Amplitude = Field(
        description="displacement amplitude asked for, half the stroke", examples=[60.0]
    )
    frequency_Hz: Frequency = Field(description="cycles per second", examples=[3.0])
    cycles: Cycles = Field(description="length of the test", examples=[100000])
    drive: Annotated[Literal["sensor", "stroke"], PlainValidator(_checked_drive)] = Field(
        "sensor", description="where the amplitude is held: on the sensor's reading, or on the true motion"
    )


class Stated(Table):
    """What the rig's owner believes; what is not stated is believed ideal."""

    friction: Friction | None = Field(None, description="coefficient of friction", examples=[0.62])
    energy_wear_coefficient_mm3_per_J: WearCoefficient | None = Field(
        None, description="worn volume of both wires together per dissipated energy", examples=[3.0e-5]
    )
    moving_share: Share = Field(0.5, description="part of the worn volume that the moving wire loses")
    tangential_stiffness_N_per_mm: HolderStiffness = Field(
        "rigid", description='stiffness of the rig along the motion, a number or "rigid"', examples=[167.0]
    )
    rotational_stiffness_N_mm_per_rad: RotationalStiffness = Field(
        "rigid", description='stiffness against rotation about a pivot above the contact, a number or "rigid"'
    )
    pivot_height_mm: PivotHeight | None = Field(None, description="height of that pivot above the contact")
    normal_spring_stiffness_N_per_mm: SpringStiffness = Field(
        0.0, description="stiffness of the loading spring; 0 is a dead weight"
    )


class Noise(Table):
    """Standard deviations of one sample; None where the owner does not know."""

    displacement_um: DisplacementNoise | None = Field(None, description="noise of the displacement sensor")
    tangential_force_N: ForceNoise | None = Field(None, description="noise of the tangential force")
    normal_force_N: ForceNoise | None = Field(None, description="noise of the normal force")


class Files(Table):
    """Where the data stand, beside experiment.toml."""

    loops: FileName = Field(description="file of the loops", examples=["loops.csv"])
    evolution: FileName | None = Field(None, description="file of the evolution over the cycles")
    scar_moving: FileName | None = Field(None, description="file of the moving wire's scars")
    scar_fixed: FileName | None = Field(None, description="file of the fixed wire's scars")


class RecordTables(Table):
    """The whole of experiment.toml."""

    format: Annotated[int, PlainValidator(checked_format)] = Field(
        description="version of the record's format", examples=[FORMAT]
    )
    name: Annotated[str, PlainValidator(checked_text)] = Field(
        description="title of the experiment", examples=["steel wires, test 3"]
    )
    wires: RecordWires = Field(description="the two wires")
    conditions: RecordConditions = Field(description="load, stroke, frequency and length of the test")
    stated: Stated = Field(Stated(), description="what the rig's owner believes")
    noise: Noise = Field(Noise(), description="noise of one sample")
    files: Files = Field(description="names of the data files")
