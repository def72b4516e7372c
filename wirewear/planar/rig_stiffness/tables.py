"""The tables of a rig stiffness study's TOML file: plane strain, everything per mm of thickness."""

from functools import partial
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, PlainValidator

from wirewear.planar.tables import Extent, LineLoad, Material, Radius, Resolution
from wirewear.quantity import Quantity, shown
from wirewear.study.keys import Amplitude, Friction, NamedTable, PivotHeight, Table, one_of

KIND = "rig-stiffness"

_TANGENTIAL = Quantity("N_per_mm2", 1.0, 1e8)
_ROTATIONAL = Quantity("N_per_rad", 1.0, 1e12)


def _numbers(quantity: Quantity, example: str, value: object) -> tuple[float, ...]:
    if not isinstance(value, list | tuple) or not value:
        raise ValueError(f"is {shown(value)}, but must be a list with a number for each case, such as {example}")
    numbers = []
    for item in value:
        try:
            numbers.append(float(quantity(item)))
        except ValueError as problem:
            raise ValueError(f"holds an item that {problem}") from None
    return tuple(numbers)


SettlingCycles = Annotated[int, PlainValidator(Quantity("cycles", 2, 50, whole=True))]
TangentialStiffnesses = Annotated[tuple[float, ...], BeforeValidator(partial(_numbers, _TANGENTIAL, "[5.0e3, 1.0e4]"))]
#: The word for springs that are to be found.
FOUND = "equal"


def _checked_rotational(value: object) -> tuple[float, ...] | str:
    if value == FOUND:
        return FOUND
    if isinstance(value, str):
        raise ValueError(f'is {shown(value)}, but must be a list with a number for each case, or "{FOUND}"')
    return _numbers(_ROTATIONAL, "[5.0e5, 1.0e6]", value)


RotationalStiffnesses = Annotated[tuple[float, ...] | Literal["equal"], BeforeValidator(_checked_rotational)]


class Conditions(Table):
    """What is asked of the rig."""

    displacement_amplitude_um: Amplitude = Field(
        description="displacement amplitude of the specimen's rigid lower face, half the stroke", examples=[35.0]
    )
    friction: Friction = Field(description="coefficient of friction", examples=[0.9])
    most_cycles: SettlingCycles = Field(
        12, description="cycles after which the last is looked at if friction has not shaken down before"
    )


class ContactTable(Table):
    """A pad on a specimen, each with a rigid back, and the springs that hold the pad in each case.

    Scenario 1: the pad does not rotate and a tangential spring to ground holds it.  Scenario 2: the pad does not
    translate and rotates about a pivot, held by a rotational spring.
    """

    normal_load_N_per_mm: LineLoad = Field(description="normal load per thickness", examples=[390.0])
    pad_height_mm: Extent = Field(description="height of the pad between its contact and its rigid back")
    pad_half_width_mm: Extent = Field(description="half of the pad's width")
    specimen_height_mm: Extent = Field(description="height of the specimen between its contact and its rigid face")
    specimen_half_width_mm: Extent = Field(description="half of the specimen's width")
    pivot_height_mm: PivotHeight = Field(description="height of the pivot above the contact", examples=[10.3])
    tangential_stiffness_N_per_mm2: TangentialStiffnesses = Field(
        description="scenario 1: stiffness of the tangential spring per thickness, case by case"
    )
    rotational_stiffness_N_per_rad: RotationalStiffnesses = Field(
        description='scenario 2: stiffness of the rotational spring per thickness, case by case, or "equal": found so '
        "that the loop's stiffness K_t,m is that of scenario 1"
    )


class CylinderContact(ContactTable):
    """A cylindrical pad."""

    radius_mm: Radius = Field(description="radius of the pad", examples=[40.0])


class FlatContact(ContactTable):
    """A flat pad with rounded edges."""

    face_half_width_mm: Extent = Field(description="half-width of the flat part of the pad's face", examples=[1.9])
    edge_radius_mm: Radius = Field(description="radius of the face's rounded edges", examples=[3.0])


class RigStiffnessStudy(NamedTable):
    """A rig stiffness study as a value."""

    kind: Annotated[Literal["rig-stiffness"], PlainValidator(one_of(KIND))] = Field(
        description="kind of study", examples=[KIND]
    )
    material: Material = Field(description="elasticity of pads and specimen")
    conditions: Conditions = Field(description="stroke, friction and number of cycles")
    cylinder: CylinderContact | None = Field(None, description="a cylindrical pad on the specimen")
    flat: FlatContact | None = Field(None, description="a flat pad with rounded edges on the specimen")
    mesh: Resolution = Field(Resolution(), description="resolution")

    @property
    def contacts(self) -> dict[str, ContactTable]:
        """The contacts that the study has, by name."""
        both = {"cylinder": self.cylinder, "flat": self.flat}
        return {name: contact for name, contact in both.items() if contact is not None}
