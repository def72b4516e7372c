"""The tables of the experiment.toml of a contact at a point between bodies of any shapes (format 1, third edition).

Bodies are stated as in their studies.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Annotated, Any, Generic, TypeVar

from pydantic import Field, PlainValidator

from wirewear.records.line_tables import LineRecordTables
from wirewear.records.surfaces import SCARS
from wirewear.records.tables import PointRecordTables, PointTest, RecordTables, curved
from wirewear.study.bodies import Body
from wirewear.study.keys import Inconsistency, Table, one_of
from wirewear.study.points import BALL_ON_FLAT, POINT_CONTACT, BallAndFlat, LowerAndUpper

Bodies = TypeVar("Bodies", BallAndFlat, LowerAndUpper)


class ContactAtAPoint(Table):
    """What touches."""

    kind: Annotated[str, PlainValidator(one_of(BALL_ON_FLAT, POINT_CONTACT))] = Field(
        description="kind of contact", examples=[BALL_ON_FLAT]
    )


class BodiesTest(PointTest, Generic[Bodies]):
    """A test of two bodies as its file states them."""

    worn = replace(
        SCARS,
        support="Worn volume, depth and shape of both scars at the end.",
        lacking="Worn volume and shape: there is no scar of the {}. A profilometer's map of it, or its points x, y, "
        "height, can be imported ([scars.*] of a mapping).",
    )

    contact: ContactAtAPoint = Field(description="what touches")
    bodies: Bodies = Field(description="both bodies")

    @property
    def bodies_of_test(self) -> tuple[Body, Body]:
        """As their study has them."""
        return self.bodies.of_test()

    def contradiction(self) -> Inconsistency | None:
        """As of their study."""
        return self.bodies.contradiction()


class BallTest(BodiesTest[BallAndFlat]):
    """A test of a ball on a flat."""

    contact_kind, body_names = BALL_ON_FLAT, ("flat", "ball")


class ShapesTest(BodiesTest[LowerAndUpper]):
    """A test of bodies of any shapes."""

    contact_kind, body_names = POINT_CONTACT, ("lower", "upper")


class BodiesRecord(PointRecordTables):
    """How records and studies of two bodies say the same."""

    @classmethod
    def bodies_of(cls, study: Mapping[str, Any], label: str, length_mm: float | None) -> dict[str, Any]:
        """As they are."""
        del label, length_mm
        return {"contact": {"kind": cls.contact_kind}, "bodies": study["bodies"]}

    @property
    def of_study(self) -> dict[str, float | None]:
        """And how the bodies are curved and lie."""
        return {**super().of_study, **curved(self.model_dump(exclude_none=True)["bodies"])}

    def with_bodies(self, data: dict[str, Any]) -> dict[str, Any]:
        """As they are."""
        return data | {"bodies": self.model_dump(mode="json", exclude_none=True)["bodies"]}


class BallRecordTables(BodiesRecord, BallTest):
    """The whole of the experiment.toml of a ball on a flat."""


class ShapesRecordTables(BodiesRecord, ShapesTest):
    """The whole of the experiment.toml of bodies of any shapes."""


AnyTables = PointRecordTables | LineRecordTables

#: Tables of records by the names of kinds of contact.
TABLES: dict[str, type[AnyTables]] = {
    model.contact_kind: model for model in (RecordTables, LineRecordTables, BallRecordTables, ShapesRecordTables)
}
