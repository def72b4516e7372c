"""The tables of a planar study's TOML file: a cylinder on a flat in plane strain, everything per mm of thickness."""

from typing import Annotated, Literal

from pydantic import Field, PlainValidator

from geometry import Elastic
from solvers import Coulomb
from wirewear.quantity import Quantity
from wirewear.study.keys import (
    Amplitude,
    ArchardCoefficient,
    Cycles,
    Effects,
    ElementSize,
    Frequency,
    Friction,
    IncrementsPerCycle,
    NamedTable,
    PoissonsRatio,
    Table,
    Tolerance,
    WearCoefficient,
    YoungsModulus,
    one_of,
)
from wirewear.study.laws import FrictionLawKey
from wirewear.study.tables import Log

KIND = "cylinder-on-flat"

Radius = Annotated[float, PlainValidator(Quantity("mm", 0.05, 1000.0))]
Extent = Annotated[float, PlainValidator(Quantity("mm", 0.05, 500.0))]
LineLoad = Annotated[float, PlainValidator(Quantity("N_per_mm", 1e-3, 1e5))]
LineStiffness = Annotated[float | Literal["rigid"], PlainValidator(Quantity("N_per_mm2", 1.0, 1e8, words=("rigid",)))]


class Material(Table):
    """An elastic material."""

    youngs_modulus_MPa: YoungsModulus = Field(description="Young's modulus", examples=[116000.0])
    poissons_ratio: PoissonsRatio = Field(description="Poisson's ratio", examples=[0.3])

    @property
    def elastic(self) -> Elastic:
        """As the solvers take it."""
        return Elastic(self.youngs_modulus_MPa, self.poissons_ratio)


class Resolution(Table):
    """Resolution in space and time; what is left out follows from --fidelity."""

    contact_mesh_um: ElementSize | None = Field(None, description="element size under the contact")
    far_mesh_mm: Extent = Field(1.0, description="largest element far from the contact")
    increments_per_cycle: IncrementsPerCycle | None = Field(None, description="time steps of one cycle")


class Pad(Material):
    """The cylinder, held by the rig, above the specimen."""

    radius_mm: Radius = Field(description="radius of the cylinder", examples=[40.0])
    height_mm: Extent = Field(10.0, description="height of the pad between its contact and its holder")
    half_width_mm: Extent | None = Field(None, description="half of the pad's width; without it 10 or 0.8 radii")


class Specimen(Material):
    """The flat, moved by the drive, below the pad."""

    height_mm: Extent = Field(10.0, description="height of the specimen between its contact and its moved back")
    half_width_mm: Extent | None = Field(
        None, description="half of the specimen's width; without it 10 or what it needs"
    )


class PlanarConditions(Table):
    """What is asked of the rig."""

    normal_load_N_per_mm: LineLoad = Field(description="normal load per length of the cylinder", examples=[390.0])
    displacement_amplitude_um: Amplitude = Field(
        description="imposed displacement amplitude, half the stroke", examples=[35.0]
    )
    cycles: Cycles = Field(description="length of the test", examples=[10000])
    motion: Annotated[Literal["triangular", "sinusoidal"], PlainValidator(one_of("triangular", "sinusoidal"))] = Field(
        "sinusoidal", description="displacement over time"
    )
    frequency_Hz: Frequency = Field(1.0, description="cycles per second")


class PlanarContact(Table):
    """The friction law."""

    friction: Friction = Field(description="coefficient of friction", examples=[0.9])
    friction_law: FrictionLawKey = Field(
        Coulomb(), description='"coulomb", or a table of another law\'s name and parameters; friction is its start'
    )


class PlanarWear(Table):
    """Wear of each body: by dissipated energy, or by Archard's law in load times sliding distance."""

    pad_energy_mm3_per_J: WearCoefficient = Field(0.0, description="energy wear coefficient of the pad")
    specimen_energy_mm3_per_J: WearCoefficient = Field(0.0, description="energy wear coefficient of the specimen")
    pad_archard_mm3_per_N_m: ArchardCoefficient = Field(0.0, description="Archard wear coefficient of the pad")
    specimen_archard_mm3_per_N_m: ArchardCoefficient = Field(
        0.0, description="Archard wear coefficient of the specimen"
    )


class PlanarHolder(Table):
    """The rig: a spring between the pad's holder and ground along the motion."""

    tangential_stiffness_N_per_mm2: LineStiffness = Field(
        "rigid", description='stiffness of the rig per length of the cylinder, a number or "rigid"'
    )


class PlanarMeshing(Resolution):
    """Resolution in space and time, and the extent of the fine mesh."""

    scar_half_width_um: ElementSize | None = Field(
        None, description="half-width of the finely meshed patch beyond the stroke; without it, predicted"
    )
    jump_tolerance: Tolerance | None = Field(None, description="relative error allowed to one cycle jump")


class PlanarStudy(NamedTable):
    """A planar study as a value."""

    kind: Annotated[Literal["cylinder-on-flat"], PlainValidator(one_of(KIND))] = Field(
        description="kind of contact", examples=[KIND]
    )
    pad: Pad = Field(description="the cylinder")
    specimen: Specimen = Field(description="the flat")
    conditions: PlanarConditions = Field(description="load, stroke, motion and length of the test")
    contact: PlanarContact = Field(description="friction")
    wear: PlanarWear = Field(PlanarWear(), description="wear of both bodies; without this table nothing wears")
    holder: PlanarHolder = Field(PlanarHolder(), description="stiffness of the rig")
    effects: Effects = Field((), description="effects that the nominal model lacks, per mm of thickness")
    log: Log = Field(Log(), description="which cycles are recorded")
    mesh: PlanarMeshing = Field(PlanarMeshing(), description="resolution")

    def energy_coefficients(self) -> tuple[float, float]:
        """Wear of pad and specimen per dissipated energy, in mm³/J.

        Archard's law h = k p s is the energy law h = α µ p s with α = k/µ wherever Coulomb friction slides.
        """
        wear, friction = self.wear, self.contact.friction

        def combined(energy: float, archard: float) -> float:
            return energy + (archard / friction if archard > 0.0 else 0.0)

        return (
            combined(wear.pad_energy_mm3_per_J, wear.pad_archard_mm3_per_N_m),
            combined(wear.specimen_energy_mm3_per_J, wear.specimen_archard_mm3_per_N_m),
        )
