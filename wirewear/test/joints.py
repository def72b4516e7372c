"""Joints: tests of which loops alone are known, as of a bolted joint or a damper, without bodies and wear."""

from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import Field, PlainValidator

from geometry import Elastic
from solvers import Drive, WearRates
from wirewear.base import kinds
from wirewear.base.units import Quantity
from wirewear.effects import Seam
from wirewear.test import keys
from wirewear.test.bodies import BodiesByOptions, StatedBodies
from wirewear.test.conditions import Asked, DrivenConditions, FrictionTable
from wirewear.test.keys import Inconsistency
from wirewear.test.surfaces import LayerTable
from wirewear.test.tables import CommonTables, StatesItsKind
from wirewear.test.template import Template

Stroke = Annotated[float, PlainValidator(Quantity("um", 0.1, 1e5))]
Force = Annotated[float, PlainValidator(Quantity("N", 1e-3, 1e7))]


class AskedOfJoint(Asked):
    """Keys of load, stroke and length of a joint's test; loads may be meganewtons, strokes centimetres."""

    normal_load_N: Force = Field(description="normal load in the joint", examples=[130.0])
    displacement_amplitude_um: Stroke = Field(
        description="imposed displacement amplitude, half the stroke", examples=[60.0]
    )


class JointConditions(AskedOfJoint, DrivenConditions):
    """Keys of the conditions of a joint's test in a study."""


class JointStiffness(StatedBodies):
    """The key of a joint's own stiffness, which is stated in place of bodies."""

    contact_stiffness_N_per_mm: keys.HolderStiffness = Field(
        "rigid", description='stiffness of the joint itself, without the rig, a number or "rigid"'
    )

    @classmethod
    def by_options(
        cls, known: Mapping[str, object], elastic: Mapping[str, object], of_other: Mapping[str, object]
    ) -> BodiesByOptions:
        del known, elastic, of_other
        return BodiesByOptions({"contact": {"kind": kinds.JOINT}})


class JointContact(FrictionTable, JointStiffness):
    """Keys of a joint's friction and stiffness."""


class JointTables(CommonTables, StatesItsKind):
    """The tables of a joint's study, without variants; it can be fitted and diagnosed, but not simulated."""

    kind: Literal["joint"] = Field(description="kind of contact", examples=[kinds.JOINT])
    conditions: JointConditions = Field(description="load, stroke, frequency and length of the test")
    contact: JointContact = Field(description="friction and stiffness")
    wear: None = Field(None, description="nothing: a joint's wear is not known")
    mesh: None = Field(None, description="nothing: there is no mesh")
    life: None = Field(None, description="nothing: there are no bodies")

    @property
    def layers(self) -> dict[str, tuple[LayerTable, ...]]:
        return {}

    @property
    def materials(self) -> dict[str, Elastic]:
        return {}

    @property
    def drive(self) -> Drive:
        return self.conditions.drive

    @property
    def worn_by_sliding(self) -> float:
        return 0.0

    @property
    def wear_rates(self) -> WearRates:
        return WearRates()

    def contradiction(self) -> Inconsistency | None:
        if any(effect.seam is Seam.SPECIMENS for effect in self.effects):
            return Inconsistency(("effects",), "hold one of bodies, which a joint does not state")
        return None


#: The template of a joint's study: a friction damper.
JOINT = Template(
    kinds.JOINT,
    JointTables,
    ("conditions", "contact", "holder", "log"),
    {
        "conditions": {"normal_load_N": 130.0, "displacement_amplitude_um": 500.0, "frequency_Hz": 1.0, "cycles": 100},
        "contact": {"friction": 0.3, "contact_stiffness_N_per_mm": "rigid"},
        "holder": {"tangential_stiffness_N_per_mm": 900.0},
    },
    "A joint of which loops are known, to be changed into yours; it is fitted and diagnosed, and not simulated.",
)
