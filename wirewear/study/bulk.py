"""Bulk stresses of bodies as a study states them: tension, bending and torsion beside the contact."""

from collections.abc import Sequence
from math import radians
from typing import Annotated

from pydantic import Field, PlainValidator

from geometry import Elastic
from solvers import BulkStress
from wirewear.base.errors import Quantity
from wirewear.study import keys

BULK = (
    "stress that it carries beside the contact, by tension, bending and torsion in each cycle"  #: What the key holds.
)

Stress = Annotated[float, PlainValidator(Quantity("MPa", -1e4, 1e4))]
StressAmplitude = Annotated[float, PlainValidator(Quantity("MPa", 0.0, 1e4))]
Phase = Annotated[float, PlainValidator(Quantity("deg", -360.0, 360.0))]


class BulkTable(keys.Table):
    """Bulk stress of one body along its own axis, named by what it is at the contact: mean + amplitude cos(cycle −
    phase), from the drive's rest at +amplitude on.
    """

    axial_stress_MPa: Stress = Field(0.0, description="mean axial stress, tension positive", examples=[300.0])
    axial_stress_amplitude_MPa: StressAmplitude = Field(0.0, description="amplitude of the axial stress")
    bending_stress_MPa: Stress = Field(0.0, description="mean bending stress at the contact, tension there positive")
    bending_stress_amplitude_MPa: StressAmplitude = Field(0.0, description="amplitude of the bending stress")
    torsion_stress_MPa: Stress = Field(0.0, description="mean shear stress by torsion at the surface of a round bar")
    torsion_stress_amplitude_MPa: StressAmplitude = Field(0.0, description="amplitude of the shear stress by torsion")
    phase_deg: Phase = Field(0.0, description="by how much the stress comes after the drive")

    def of(self, material: Elastic, *, plane_strain: bool = False) -> BulkStress:
        """As the solvers take it."""
        return BulkStress(
            material,
            (self.axial_stress_MPa, self.bending_stress_MPa, self.torsion_stress_MPa),
            (self.axial_stress_amplitude_MPa, self.bending_stress_amplitude_MPa, self.torsion_stress_amplitude_MPa),
            radians(self.phase_deg),
            plane_strain,
        )

    def unfit(self, *, is_round: bool) -> str | None:
        """What is wrong with it in a body that is a round bar or not, as the rest of a sentence, if anything."""
        if (self.torsion_stress_MPa or self.torsion_stress_amplitude_MPa) and not is_round:
            return "gives a torsion stress, which is of round bars, wires and tubes alone"
        return None


def bulk_of(
    bodies: Sequence[tuple[BulkTable | None, Elastic]], *, plane_strain: bool = False
) -> tuple[BulkStress, ...]:
    """Of the driven and the held body; nothing where none is stated."""
    if all(table is None for table, _ in bodies):
        return ()
    return tuple((table or BulkTable()).of(material, plane_strain=plane_strain) for table, material in bodies)
