"""Tables of the two bodies of a line contact: the pad that the rig holds, and the specimen that is driven."""

from dataclasses import replace
from typing import Annotated, TypeVar

from pydantic import Field, PlainValidator

from geometry import Cylinder, PlanarGeometry, RingGeometry
from wirewear.base import kinds
from wirewear.base.units import Quantity
from wirewear.test import keys
from wirewear.test.bodies import MountedBody
from wirewear.test.faces import PadFaceOrFile
from wirewear.test.keys import Inconsistency

Taper = Annotated[float, PlainValidator(Quantity("1", -0.2, 0.2))]
AxialForce = Annotated[float, PlainValidator(Quantity("N", 1e-3, 1e7))]
Extent = Annotated[float, PlainValidator(Quantity("mm", 0.05, 500.0))]

Planar = TypeVar("Planar", PlanarGeometry, RingGeometry)


class HeldTable(MountedBody):
    """Keys of the pad or the specimen, each held at its back."""

    grip_width_mm: Extent | None = Field(
        None, description="width of the back that is held, about its middle; all by default"
    )

    def held(self, geometry: Planar) -> Planar:
        """A copy of `geometry` with the width and stiffness of this body's grip."""
        stiffness, width = self.grip_stiffness_N_per_mm3, self.grip_width_mm
        return replace(
            geometry,
            grip_half_width_mm=None if width is None else 0.5 * width,
            grip_stiffness_N_per_mm3=None if isinstance(stiffness, str) else stiffness,
        )


class Pad(PadFaceOrFile, HeldTable):
    """Keys of the pad, which the rig holds above the specimen."""

    height_mm: Extent = Field(10.0, description="height of the pad between its contact and its holder")
    half_width_mm: Extent | None = Field(
        None, description="half of the pad's width; without it 10 or 0.8 radii, or as far as its profile goes"
    )


class Specimen(HeldTable):
    """Keys of the flat, which the drive moves below the pad."""

    height_mm: Extent = Field(10.0, description="height of the specimen between its contact and its moved back")
    half_width_mm: Extent | None = Field(
        None, description="half of the specimen's width; without it 10 or what it needs"
    )
    bore_radius_mm: Extent | None = Field(
        None,
        description="radius of a bore in place of a flat: a round pad is then a pin in it. The pin is held around its "
        "core, at most 0.9 radii below its surface, and the specimen around the rim that lies its height outside the "
        "bore",
        examples=[6.02],
    )
    shaft_radius_mm: Extent | None = Field(
        None,
        description="radius of a shaft in place of a flat, with its axis along the motion: the pad is then a hub around"
        " it, as thick as its height_mm. A height_mm below the radius is the wall of a hollow shaft",
        examples=[10.0],
    )
    interference_um: keys.Approach | None = Field(
        None, description="how much larger than its hub's the shaft's radius is; normal_load_N is then only expected"
    )
    assembly_force_N: AxialForce | None = Field(
        None, description="force that has pushed the shaft into its hub, in place of interference_um"
    )
    taper: Taper = Field(0.0, description="rise of the shaft's radius, and of its hub's, along the motion")

    def unfit_bore(self, pad: Pad, kind: str) -> Inconsistency | None:
        """The contradiction of the bore with this pad in a test of this kind; None if they fit, or there is no bore."""
        key = ("specimen", "bore_radius_mm")
        if self.bore_radius_mm is None:
            return None
        if kind != kinds.LINE_CONTACT:
            return Inconsistency(key, f'is given, but a bore is no flat: give kind = "{kinds.LINE_CONTACT}"')
        if not isinstance(face := pad.profile, Cylinder):
            return Inconsistency(key, "needs a round pad: give it radius_mm alone")
        if not self.bore_radius_mm > face.radius_mm:
            return Inconsistency(
                key, f"is {self.bore_radius_mm:g}, but must be larger than the pin's radius_mm, {face.radius_mm:g}"
            )
        for name, body in (("pad", pad), ("specimen", self)):
            for foreign in ("half_width_mm", "grip_width_mm", "surface", "bulk"):
                if getattr(body, foreign) is not None:
                    text = "is given, but a pin and a plate with a bore have none: remove it"
                    return Inconsistency((name, foreign), text)
        return None
