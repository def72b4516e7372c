"""Shapes of bodies of a contact at a point, such as a ball or a tube: keys that state them, and the bodies that they
make.

A body's axis lies in the plane of contact; along and across are relative to it. A new shape is a class here, listed in
`SHAPES`; a face that two curvatures do not give stands in `geometry/profiles.py`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

from pydantic import Field, PlainValidator

from geometry import TabledProfile
from geometry.own_surface import own_surface
from wirewear.base.units import Quantity
from wirewear.test import keys
from wirewear.test.bodies import BlockBody, Body, MountedBody, Wire
from wirewear.test.faces import FACE_KEYS, Extent, Face, PadFaceOrFile, size_of
from wirewear.test.keys import Inconsistency
from wirewear.test.own_bodies import (
    MESH_KEYS,
    STIFFNESS_KEYS,
    MeshKeys,
    OwnBody,
    StiffBody,
    source_of,
    unfit_mesh,
    unfit_stiffness,
)

Diameter = Annotated[float, PlainValidator(Quantity("mm", 0.1, 200.0))]


#: Keys that some shapes have, with the reason why others do not.
_OF_SOME = {
    "diameter_mm": "but a {} has no diameter",
    **dict.fromkeys(FACE_KEYS, "is of a pad, but a {} has diameters"),
    **dict.fromkeys(MESH_KEYS, "is of a body of a file, but a {} is meshed by the program"),
    "diameter_along_mm": "belongs to a barrel and to no other shape",
    "bore_mm": "belongs to a tube and to no other shape",
    "held_at": 'is "ends", but a {} is held at its back and sides',
}


@dataclass(frozen=True)
class Shape:
    """A shape of a body, meshed as a block unless a subclass says otherwise. straight: True where it is, (along,
    across). needs: keys that it must have; takes: further ones of the keys that not all shapes have; idle: keys without
    effect on it, each with the reason. note: added to its name in messages.
    """

    name: str
    needs: tuple[str, ...] = ("diameter_mm",)
    straight: tuple[bool, bool] = (False, False)
    note: str = ""
    takes: ClassVar[tuple[str, ...]] = ()
    idle: ClassVar[dict[str, str]] = {"grip_angle_deg": "is of wires and tubes, but a {} is held at its back and sides"}

    def curvatures_per_mm(self, stated: ShapedBody) -> tuple[float, float]:
        """(along, across): curvatures in 1/mm of the stated body's face, 0 where straight."""
        across, along = stated.diameter_mm, stated.diameter_along_mm or stated.diameter_mm
        return (
            0.0 if self.straight[0] or not along else 2.0 / along,
            0.0 if self.straight[1] or not across else 2.0 / across,
        )

    def face(self, _stated: ShapedBody) -> Face | None:
        """The profile of a pad's face; None for any other shape, whose face follows from its curvatures."""
        return None

    def unfit(self, _stated: ShapedBody) -> Inconsistency | None:
        """The contradiction of a value that the shape cannot have; None if there is none."""
        return None

    def body(self, stated: ShapedBody, name: str, size_mm: float) -> Body:
        """The stated body, called `name`. size_mm: length, usually the sharpest radius, from which extents that are not
        stated are chosen.
        """
        return stated.block(name, self.curvatures_per_mm(stated), size_mm, self.face(stated))


@dataclass(frozen=True)
class _RoundBar(Shape):
    """A wire or, with a bore, a tube."""

    straight: tuple[bool, bool] = (True, False)

    takes: ClassVar[tuple[str, ...]] = ("held_at",)
    idle: ClassVar[dict[str, str]] = {"height_mm": "is of blocks, but a {} is as high as it is thick"}

    def unfit(self, stated: ShapedBody) -> Inconsistency | None:
        # Thinnest wall of a tube, as a share of its diameter.
        widest = (1.0 - 2.0 * 0.02) * (stated.diameter_mm or 0.0)
        if (stated.bore_mm or 0.0) <= widest:
            return None
        return Inconsistency(
            ("bore_mm",),
            f"is {stated.bore_mm:g}, but a tube of {stated.diameter_mm:g} mm is meshed with a bore of at most "
            f"{widest:.4g} mm",
        )

    def body(self, stated: ShapedBody, name: str, size_mm: float) -> Wire:
        del size_mm
        return Wire(
            name,
            **stated.as_stated,
            diameter_mm=stated.diameter_mm or 0.0,
            length_mm=None if stated.half_width_mm is None else 2.0 * stated.half_width_mm,
            grip_angle_deg=stated.grip_angle_deg,
            grip_length_mm=None,
            held_at=stated.held_at,
            bore_mm=stated.bore_mm or 0.0,
        )


@dataclass(frozen=True)
class _Pad(Shape):
    """A pad of revolution about the normal; its face is, along any radius, what a line contact's pad has along the
    motion.
    """

    needs: tuple[str, ...] = ()
    straight: tuple[bool, bool] = (True, True)

    takes: ClassVar[tuple[str, ...]] = FACE_KEYS

    def face(self, stated: ShapedBody) -> Face:
        return stated.profile

    def unfit(self, stated: ShapedBody) -> Inconsistency | None:
        if (wanted := stated.missing_face()) is not None:
            return Inconsistency(("shape",), f'is "{self.name}", whose face is not stated: {wanted}')
        if isinstance(stated.profile, TabledProfile) and not stated.profile.is_even:
            return Inconsistency(("profile_points_mm",), "begins below 0, but a turned face has points from x = 0 on")
        return None


@dataclass(frozen=True)
class _FromFile(Shape):
    """A shape that a mesh file defines."""

    needs: tuple[str, ...] = ()

    takes: ClassVar[tuple[str, ...]] = MESH_KEYS
    idle: ClassVar[dict[str, str]] = {
        **dict.fromkeys(("half_width_mm", "height_mm"), "is of blocks, but a {}'s file says how large it is"),
        "grip_angle_deg": "is of wires and tubes, but a {}'s file says where it is held",
    }

    def curvatures_per_mm(self, stated: ShapedBody) -> tuple[float, float]:
        return own_surface(source_of(stated)).curvatures_per_mm

    def unfit(self, stated: ShapedBody) -> Inconsistency | None:
        problem = unfit_mesh(stated, stated.poissons_ratio)
        return None if problem is None else Inconsistency((problem[0],), problem[1])

    def body(self, stated: ShapedBody, name: str, size_mm: float) -> Body:
        del size_mm
        return OwnBody(name, **stated.as_stated, source=source_of(stated))


@dataclass(frozen=True)
class _OfStiffness(_FromFile):
    """A shape that a file with a condensed stiffness defines."""

    takes: ClassVar[tuple[str, ...]] = STIFFNESS_KEYS

    def curvatures_per_mm(self, stated: ShapedBody) -> tuple[float, float]:
        return self.body(stated, "", 0.0).curvatures_per_mm

    def unfit(self, stated: ShapedBody) -> Inconsistency | None:
        if stated.grip_stiffness_N_per_mm3 != "rigid":
            return Inconsistency(
                ("grip_stiffness_N_per_mm3",), "is given, but a known stiffness holds its nodes rigidly"
            )
        problem = unfit_stiffness(stated)
        return None if problem is None else Inconsistency((problem[0],), problem[1])

    def body(self, stated: ShapedBody, name: str, size_mm: float) -> Body:
        del size_mm
        return StiffBody(name, **stated.as_stated, source=source_of(stated))


PAD = _Pad("pad", note="with a face that is turned about the normal")
SHAPES: dict[str, Shape] = {
    shape.name: shape
    for shape in (
        Shape("ball"),
        Shape("flat", (), (True, True)),
        Shape("cylinder", straight=(True, False), note="a block with a cylindrical face"),
        Shape("barrel", ("diameter_mm", "diameter_along_mm")),
        _RoundBar("wire", note="a round bar"),
        _RoundBar("tube", ("diameter_mm", "bore_mm")),
        PAD,
        _FromFile("mesh", note="of a file"),
        _OfStiffness("stiffness", note="condensed, of a file"),
    )
}


def _described() -> str:
    named = [f"{shape.name} ({shape.note})" if shape.note else shape.name for shape in SHAPES.values()]
    return f"{', '.join(named[:-1])} or {named[-1]}"


class GrippedBody(MountedBody):
    """Keys of a body of one material that is meshed as a block, held at its back and sides."""

    elsewhere: ClassVar = dict.fromkeys(
        ("shape", *MESH_KEYS), 'bodies of any shape, also from files, are those of kind = "point-contact"'
    )

    half_width_mm: Extent | None = Field(
        None, description="half-width of the block that is meshed, to each side; without it the program chooses"
    )
    height_mm: Extent | None = Field(None, description="height of the block, from its contact to its held back")

    def block(
        self, name: str, curvatures: tuple[float, float], size_mm: float, of_pad: Face | None = None
    ) -> BlockBody:
        """The block called `name` with curvatures (along, across) in 1/mm. size_mm: as in `Shape.body`; of_pad: the
        face of a pad, None for other shapes.
        """
        return BlockBody(
            name,
            **self.as_stated,
            curvatures=curvatures,
            half_width_mm=self.half_width_mm,
            height_mm=self.height_mm,
            size_mm=size_mm,
            of_pad=of_pad,
        )


class _ShapeFirst(keys.Table):
    """The keys with which the table of a body of any shape begins."""

    shape: Annotated[str, PlainValidator(keys.one_of(*SHAPES))] = Field(description=_described())
    diameter_mm: Diameter | None = Field(
        None, description="diameter, of a barrel across its axis; a flat and a pad have none"
    )
    diameter_along_mm: Diameter | None = Field(None, description="diameter of a barrel's profile along its axis")
    bore_mm: Diameter | None = Field(None, description="inner diameter of a tube")
    axis_angle_deg: keys.AxisAngle = Field(
        0.0, description="angle of its axis to the motion, about the normal that points upwards"
    )


class ShapedBody(GrippedBody, MeshKeys, PadFaceOrFile, _ShapeFirst):
    """Keys of a body of any shape in SHAPES; `missing` and `idle` say which of them do not go with its shape."""

    grip_angle_deg: keys.GripAngle = Field(
        90.0, description="part of a wire's or tube's circumference, about its back, that is held"
    )
    held_at: Annotated[Literal["back", "ends"], PlainValidator(keys.one_of("back", "ends"))] = Field(
        "back", description="where a wire or tube is held"
    )

    @property
    def of_shape(self) -> Shape:
        return SHAPES[self.shape]

    @property
    def curvatures_per_mm(self) -> tuple[float, float]:
        """(along, across): curvatures in 1/mm of its face, 0 where straight."""
        return self.of_shape.curvatures_per_mm(self)

    def missing(self) -> Inconsistency | None:
        """The contradiction of a key that its shape needs but lacks, has but does not take, or whose value it cannot
        have; None if all fit.
        """
        shape = self.of_shape
        for key, foreign in _OF_SOME.items():
            given = getattr(self, key) != type(self).model_fields[key].default
            if key in shape.needs and not given:
                return Inconsistency((key,), self._lacking(key, foreign))
            if given and key not in (*shape.needs, *shape.takes):
                start = "is given, " if foreign.startswith("but") else ""
                return Inconsistency((key,), start + foreign.format(self.shape))
        return shape.unfit(self)

    def _lacking(self, key: str, foreign: str) -> str:
        return f"is missing, but a {self.shape} has one" if key == "diameter_mm" else foreign.format(self.shape)

    def idle(self) -> Iterator[Inconsistency]:
        """Yields a contradiction for each key that is stated but has no effect on a body of this shape."""
        for key, reason in self.of_shape.idle.items():
            if getattr(self, key) != type(self).model_fields[key].default:
                yield Inconsistency((key,), reason.format(self.shape))
        if self.held_at == "ends" and self.grip_angle_deg != type(self).model_fields["grip_angle_deg"].default:
            yield Inconsistency(("grip_angle_deg",), 'is of a back that is held, but held_at is "ends"')

    def body(self, name: str, size_mm: float) -> Body:
        """The body as it is meshed, called `name`. size_mm: as in `Shape.body`."""
        return self.of_shape.body(self, name, size_mm)

    @property
    def size_mm(self) -> float:
        """Length in mm from which extents of a pad that are not stated are chosen; 0 for any other shape."""
        face = self.of_shape.face(self)
        return 0.0 if face is None else size_of(face)
