"""Studies of contacts at a point between any two bodies, and of a ball on a flat, their short form.

The driven body lies below, the held one above.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from math import inf
from typing import Any, Literal

from pydantic import Field

from wirewear.base import kinds
from wirewear.effects import Age, Seam, Specimens, applied
from wirewear.test import keys
from wirewear.test.bodies import OPEN, BlockBody, BodiesByOptions, Body, StatedBodies
from wirewear.test.gaps import touch_along_line
from wirewear.test.keys import Inconsistency
from wirewear.test.shapes import PAD, Diameter, GrippedBody, ShapedBody
from wirewear.test.tables import ContactTables, StatesItsKind
from wirewear.test.template import COMMON, EXAMPLE, Template

_STEEL = {"youngs_modulus_MPa": 210000.0, "poissons_ratio": 0.3}
_TEST: dict[str, Any] = {
    **EXAMPLE,
    "conditions": {"normal_load_N": 100.0, "displacement_amplitude_um": 50.0, "frequency_Hz": 10.0, "cycles": 10000},
    "wear": {"energy_wear_coefficient_mm3_per_J": 2.0e-5, "moving_share": 0.5},
}
_SHOWN = ("bodies", *COMMON)
_OF_WIRES = ("conditions.motion_angle_deg",)


class _Diameter(keys.Table):
    """The key with which a ball's table begins."""

    diameter_mm: Diameter = Field(description="diameter of the ball", examples=[12.7])


class BallTable(GrippedBody, _Diameter):
    """Keys of the ball, which is held above the flat."""


class TwoBodies(StatedBodies, ABC):
    """Keys of the table [bodies] of a study, which holds the tables of two bodies by their names."""

    @abstractmethod
    def of_test(self) -> tuple[Body, Body]:
        """(driven body, held body), as they are meshed."""

    def contradiction(self) -> Inconsistency | None:
        """The first contradiction among the keys of the bodies; None if all fit."""
        return None


class BallAndFlat(TwoBodies):
    """Keys of a ball and, below it, a flat that is driven."""

    ball: BallTable = Field(description="the ball, whose holder carries the rig's compliance")
    flat: GrippedBody = Field(description="the flat, which is driven")

    def of_test(self) -> tuple[BlockBody, BlockBody]:
        radius = 0.5 * self.ball.diameter_mm
        flat = self.flat.block("flat", (0.0, 0.0), radius)
        return flat, self.ball.block("ball", (1.0 / radius, 1.0 / radius), radius)

    @classmethod
    def by_options(
        cls, known: Mapping[str, object], elastic: Mapping[str, object], of_other: Mapping[str, object]
    ) -> BodiesByOptions:
        tables = {"ball": {"diameter_mm": known.get("diameter_mm", OPEN), **of_other}, "flat": dict(elastic)}
        touching = {"contact": {"kind": kinds.BALL_ON_FLAT}, "bodies": tables}
        if "diameter_mm" in known:
            return BodiesByOptions(touching, bodies=cls.model_validate(tables).of_test())
        return BodiesByOptions(
            touching, ("no file states the ball's diameter, in millimetres: --diameter does it, too",)
        )


class LowerAndUpper(TwoBodies):
    """Keys of two bodies of any shapes; the lower one is driven."""

    lower: ShapedBody = Field(description="the lower body, which is driven")
    upper: ShapedBody = Field(description="the upper body, whose holder carries the rig's compliance")

    def of_test(self) -> tuple[Body, Body]:
        bodies = (self.lower, self.upper)
        sharpest = max(max(body.curvatures_per_mm) for body in bodies)
        size = 1.0 / sharpest if sharpest else max(body.size_mm for body in bodies)
        return self.lower.body("lower", size), self.upper.body("upper", size)

    def contradiction(self) -> Inconsistency | None:
        for name, body in (("lower", self.lower), ("upper", self.upper)):
            if (unfit := body.missing()) is not None:
                return Inconsistency(("bodies", name, *unfit.keys), unfit.problem)
        shapes = (self.lower.shape, self.upper.shape)
        if PAD.name in shapes:
            if "flat" in shapes:
                return None
            return Inconsistency(("bodies", "upper", "shape"), "is not a flat's, but a pad is pressed on a flat")
        if not touch_along_line(self.lower.body("lower", 1.0), self.upper.body("upper", 1.0)):
            return None
        return Inconsistency(
            ("bodies", "upper", "shape"),
            "and its angle make the bodies touch along a line or nearly so: a contact at a point has a ball or a "
            "barrel, or two cylinders or wires whose axes are some 5° apart or more",
        )


class _OfTwoBodies(StatesItsKind):
    """The keys with which a study of two bodies begins."""

    bodies: Any = Field(description="both bodies")


class TwoBodiesTables(ContactTables, _OfTwoBodies):
    """The tables of a study whose [bodies] state two bodies by their names, without its variants."""

    def bodies_of_test(self) -> tuple[Body, Body]:
        found: tuple[Body, Body] = self.bodies.of_test()
        return found

    def contradiction(self) -> Inconsistency | None:
        return self.bodies.contradiction() or _of_wires(self)


class BallOnFlatTables(TwoBodiesTables):
    """The tables of a study of a ball on a flat, without its variants."""

    kind: Literal["ball-on-flat"] = Field(description="kind of contact", examples=[kinds.BALL_ON_FLAT])
    bodies: BallAndFlat = Field(description="both bodies")


class PointTables(TwoBodiesTables):
    """The tables of a study of any two bodies that touch at a point, without its variants."""

    kind: Literal["point-contact"] = Field(description="kind of contact", examples=[kinds.POINT_CONTACT])
    bodies: LowerAndUpper = Field(description="both bodies")


def _of_wires(tables: ContactTables) -> Inconsistency | None:
    """A key that only crossed wires take, if it is stated."""
    if tables.conditions.motion_angle_deg:
        return Inconsistency(
            ("conditions", "motion_angle_deg"),
            "is of crossed wires: a point contact states the angle of each body's axis to the motion",
        )
    if tables.scatter is not None and tables.scatter.crossing_angle_deg is not None:
        return Inconsistency(("scatter", "crossing_angle_deg"), "is of crossed wires")
    mounted = applied(tables.effects, Seam.SPECIMENS, Specimens(90.0), Age.new())
    if mounted.crossing_angle_deg != 90.0:
        return Inconsistency(("effects",), "hold crossing_angle_error, which is of crossed wires")
    flat = mounted.flattening_mm > 0.0 or mounted.yield_stress_MPa < inf
    if flat and any(body.face is not None for body in tables.bodies_of_test()):
        return Inconsistency(("effects",), "hold plasticity, which flattens round bodies and no pads")
    return None


#: The template of a study of a ball on a flat: a steel ball of half an inch on a steel flat.
BALL = Template(
    kinds.BALL_ON_FLAT,
    BallOnFlatTables,
    _SHOWN,
    _TEST | {"bodies": {"ball": {"diameter_mm": 12.7, **_STEEL}, "flat": _STEEL}},
    "A steel ball on a steel flat, to be changed into your test; the flat is driven, the ball held above it.",
    _OF_WIRES,
)

#: The template of a study of two bodies: cylinders of half an inch, crossed at right angles.
ANY_BODIES = Template(
    kinds.POINT_CONTACT,
    PointTables,
    _SHOWN,
    _TEST
    | {
        "bodies": {
            "lower": {"shape": "cylinder", "diameter_mm": 12.7, "axis_angle_deg": 0.0, **_STEEL},
            "upper": {"shape": "cylinder", "diameter_mm": 12.7, "axis_angle_deg": 90.0, **_STEEL},
        }
    },
    "Two cylinders crossed at right angles, to be changed into your bodies; the lower one is driven.",
    _OF_WIRES,
)
