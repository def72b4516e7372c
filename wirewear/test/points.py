"""Studies of contacts at a point of any two bodies, and of a ball on a flat, which is their short form."""

from dataclasses import replace
from typing import Annotated, Any, Literal

from pydantic import Field, PlainValidator

from geometry import TabledProfile
from wirewear.base import kinds
from wirewear.base.errors import Quantity
from wirewear.effects import Age, Seam, Specimens, applied
from wirewear.test import keys
from wirewear.test.bodies import BlockBody, Body, Wire, touch_along_line
from wirewear.test.drive import BULK, BulkTable
from wirewear.test.faces import FACE_KEYS, Extent, PadFaceOrFile, size_of
from wirewear.test.keys import Inconsistency
from wirewear.test.surfaces import LAYERS, LayerTable, StatedSurface
from wirewear.test.tables import ContactTables, StatesItsKind
from wirewear.test.template import COMMON, EXAMPLE, Template

#: Shapes that are blocks: whether they are curved along and across.
_CURVED = {"ball": (True, True), "flat": (False, False), "cylinder": (False, True), "barrel": (True, True)}
_ROUND = ("wire", "tube")  #: Those that are round bars.
#: One that is turned about the normal, with a face as a line contact's pad has one along the motion.
PAD = "pad"
SHAPES = (*_CURVED, *_ROUND, PAD)
_THINNEST_WALL = 0.02  #: Thinnest wall of a tube, as a share of its diameter.

Diameter = Annotated[float, PlainValidator(Quantity("mm", 0.1, 200.0))]

_STEEL = {"youngs_modulus_MPa": 210000.0, "poissons_ratio": 0.3}
_TEST: dict[str, Any] = {
    **EXAMPLE,
    "conditions": {"normal_load_N": 100.0, "displacement_amplitude_um": 50.0, "frequency_Hz": 10.0, "cycles": 10000},
    "wear": {"energy_wear_coefficient_mm3_per_J": 2.0e-5, "moving_share": 0.5},
}
_SHOWN = ("bodies", *COMMON)
_OF_WIRES = ("conditions.motion_angle_deg",)


class GrippedBody(keys.OfMaterial):
    """A body of one material, held by its holder."""

    material: keys.MaterialName | None = Field(
        None, description="name of a material of the table, in place of its constants", examples=["Ti-6Al-4V"]
    )
    youngs_modulus_MPa: keys.YoungsModulus = Field(description="Young's modulus", examples=[210000.0])
    poissons_ratio: keys.PoissonsRatio = Field(description="Poisson's ratio", examples=[0.3])
    half_width_mm: Extent | None = Field(
        None, description="of the block that is meshed, to each side; without it the program chooses"
    )
    height_mm: Extent | None = Field(None, description="of the block, from its contact to its held back")
    grip_stiffness_N_per_mm3: keys.GripStiffness = Field(
        "rigid", description='stiffness per area of what holds back and sides, a number or "rigid"'
    )
    surface: StatedSurface | None = Field(None, description="its surface as measured before the test")
    layers: tuple[LayerTable, ...] = Field((), description=LAYERS)
    bulk: BulkTable | None = Field(None, description=BULK)

    def block(
        self, name: str, curvatures: tuple[float, float], size_mm: float, axis_angle_deg: float = 0.0
    ) -> BlockBody:
        """The body of a name, of these curvatures."""
        held = (self.youngs_modulus_MPa, self.poissons_ratio, self.grip_stiffness_N_per_mm3)
        extents = (self.half_width_mm, self.height_mm, size_mm)
        stated = BlockBody(name, *held, axis_angle_deg, curvatures, *extents, surface=self.surface)
        return replace(stated, layers=self.layers, bulk=self.bulk)


class _Diameter(keys.Table):
    """What is stated first of a ball."""

    diameter_mm: Diameter = Field(description="diameter of the ball", examples=[12.7])


class BallTable(GrippedBody, _Diameter):
    """The ball, held above the flat."""


class BallAndFlat(keys.Table):
    """A ball held above a flat that is driven."""

    ball: BallTable = Field(description="the ball, whose holder carries the rig's compliance")
    flat: GrippedBody = Field(description="the flat, which is driven")

    def of_test(self) -> tuple[BlockBody, BlockBody]:
        radius = 0.5 * self.ball.diameter_mm
        flat = self.flat.block("flat", (0.0, 0.0), radius)
        return flat, self.ball.block("ball", (1.0 / radius, 1.0 / radius), radius)

    def contradiction(self) -> Inconsistency | None:
        """Nothing: any ball touches a flat at a point."""
        return None


class _Shape(keys.Table):
    """What is stated first of a body of any shape."""

    shape: Annotated[str, PlainValidator(keys.one_of(*SHAPES))] = Field(
        description="ball, flat, cylinder (a block with a cylindrical face), barrel, wire (a round bar), tube or pad "
        "(with a face that is turned about the normal)"
    )
    diameter_mm: Diameter | None = Field(
        None, description="diameter, of a barrel across its axis; a flat and a pad have none"
    )
    diameter_along_mm: Diameter | None = Field(None, description="diameter of a barrel's profile along its axis")
    bore_mm: Diameter | None = Field(None, description="inner diameter of a tube")
    axis_angle_deg: keys.AxisAngle = Field(
        0.0, description="angle of its axis to the motion, about the normal that points upwards"
    )


class ShapedBody(GrippedBody, PadFaceOrFile, _Shape):
    """A body of any shape."""

    grip_angle_deg: keys.GripAngle = Field(
        90.0, description="part of a wire's or tube's circumference, about its back, that is held"
    )
    held_at: Annotated[Literal["back", "ends"], PlainValidator(keys.one_of("back", "ends"))] = Field(
        "back", description="where a wire or tube is held"
    )

    @property
    def curvatures_per_mm(self) -> tuple[float, float]:
        """Curvatures along its axis and across, 1/mm."""
        along, across = _CURVED.get(self.shape, (False, True))
        own = self.diameter_along_mm or self.diameter_mm
        return 2.0 / own if along and own else 0.0, 2.0 / self.diameter_mm if across and self.diameter_mm else 0.0

    def missing(self) -> Inconsistency | None:
        """The key that its shape lacks or does not have; None where all fit."""
        flat = self.shape in ("flat", PAD)
        if (self.diameter_mm is None) != flat:
            return Inconsistency(
                ("diameter_mm",),
                f"is {'missing' if self.diameter_mm is None else 'given'}, but a {self.shape} has "
                + ("no diameter" if flat else "one"),
            )
        if (wanted := self._unfit_face()) is not None:
            return wanted
        for key, shape in (("diameter_along_mm", "barrel"), ("bore_mm", "tube")):
            if (getattr(self, key) is None) == (self.shape == shape):
                return Inconsistency((key,), f"belongs to a {shape} and to no other shape")
        if self.held_at == "ends" and self.shape not in _ROUND:
            return Inconsistency(("held_at",), f'is "ends", but a {self.shape} is held at its back and sides')
        widest = (1.0 - 2.0 * _THINNEST_WALL) * (self.diameter_mm or 0.0)
        if self.bore_mm and self.bore_mm > widest:
            return Inconsistency(
                ("bore_mm",),
                f"is {self.bore_mm:g}, but a tube of {self.diameter_mm:g} mm is meshed with a bore of at most "
                f"{widest:.4g} mm",
            )
        return None

    def _unfit_face(self) -> Inconsistency | None:
        """The key that gives a pad no face, or another shape one; None where all fit."""
        if self.shape != PAD:
            foreign = [key for key in FACE_KEYS if getattr(self, key) is not None]
            return Inconsistency((foreign[0],), f"is of a pad, but a {self.shape} has diameters") if foreign else None
        if (wanted := self.missing_face()) is not None:
            return Inconsistency(("shape",), f'is "pad", whose face is not stated: {wanted}')
        if isinstance(self.profile, TabledProfile) and not self.profile.is_even:
            return Inconsistency(("profile_points_mm",), "begins below 0, but a turned face has points from x = 0 on")
        return None

    def body(self, name: str, size_mm: float) -> Body:
        """The body of a name; size_mm sets the extents that its table leaves to the program."""
        if self.shape not in _ROUND:
            block = self.block(name, self.curvatures_per_mm, size_mm, self.axis_angle_deg)
            return replace(block, of_pad=self.profile) if self.shape == PAD else block
        held = (self.youngs_modulus_MPa, self.poissons_ratio, self.grip_stiffness_N_per_mm3)
        return Wire(
            name,
            *held,
            self.axis_angle_deg,
            diameter_mm=self.diameter_mm or 0.0,
            length_mm=None if self.half_width_mm is None else 2.0 * self.half_width_mm,
            grip_angle_deg=self.grip_angle_deg,
            grip_length_mm=None,
            held_at=self.held_at,
            bore_mm=self.bore_mm or 0.0,
            surface=self.surface,
            layers=self.layers,
            bulk=self.bulk,
        )


class LowerAndUpper(keys.Table):
    """Two bodies of any shapes."""

    lower: ShapedBody = Field(description="the lower body, which is driven")
    upper: ShapedBody = Field(description="the upper body, whose holder carries the rig's compliance")

    def of_test(self) -> tuple[Body, Body]:
        bodies = (self.lower, self.upper)
        sharpest = max(max(body.curvatures_per_mm) for body in bodies)
        size = 1.0 / sharpest if sharpest else max(size_of(body.profile) for body in bodies if body.shape == PAD)
        return self.lower.body("lower", size), self.upper.body("upper", size)

    def contradiction(self) -> Inconsistency | None:
        """Shapes without their diameters, or bodies that touch along a line."""
        for name, body in (("lower", self.lower), ("upper", self.upper)):
            if (unfit := body.missing()) is not None:
                return Inconsistency(("bodies", name, *unfit.keys), unfit.problem)
        shapes = (self.lower.shape, self.upper.shape)
        if PAD in shapes:
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


class _OfBallAndFlat(StatesItsKind):
    """What a study of a ball on a flat states first."""

    bodies: BallAndFlat = Field(description="both bodies")


class _OfBodies(StatesItsKind):
    """What a study of any contact at a point states first."""

    bodies: LowerAndUpper = Field(description="both bodies")


class BallOnFlatTables(ContactTables, _OfBallAndFlat):
    """A whole study of a ball on a flat without its variants."""

    kind: Literal["ball-on-flat"] = Field(description="kind of contact", examples=[kinds.BALL_ON_FLAT])

    def bodies_of_test(self) -> tuple[BlockBody, BlockBody]:
        return self.bodies.of_test()

    def contradiction(self) -> Inconsistency | None:
        """A key of crossed wires, or a stroke longer than the ball is thick."""
        return _of_wires(self) or self.too_far()


class PointTables(ContactTables, _OfBodies):
    """A whole study of a contact at a point without its variants."""

    kind: Literal["point-contact"] = Field(description="kind of contact", examples=[kinds.POINT_CONTACT])

    def bodies_of_test(self) -> tuple[Body, Body]:
        return self.bodies.of_test()

    def contradiction(self) -> Inconsistency | None:
        return self.bodies.contradiction() or _of_wires(self) or self.too_far()


def _of_wires(tables: ContactTables) -> Inconsistency | None:
    """A key that only crossed wires take."""
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
    if mounted.flattening_mm and any(body.face is not None for body in tables.bodies_of_test()):
        return Inconsistency(("effects",), "hold plasticity, which flattens round bodies and no pads")
    return None


#: A steel ball of half an inch on a steel flat.
BALL = Template(
    kinds.BALL_ON_FLAT,
    BallOnFlatTables,
    _SHOWN,
    _TEST | {"bodies": {"ball": {"diameter_mm": 12.7, **_STEEL}, "flat": _STEEL}},
    "A steel ball on a steel flat, to be changed into your test; the flat is driven, the ball held above it.",
    _OF_WIRES,
)

#: Two cylinders of half an inch, crossed at right angles.
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
