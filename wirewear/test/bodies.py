"""Bodies: the keys that files state of any body, and bodies of contacts at a point as they are meshed.

The driven body lies below, the held one above. A block or a bar has an axis, which lies in the plane of contact; along
and across are relative to it. The size of a body is the length from which extents that are not stated are chosen.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from math import cos, inf, radians, sin, sqrt
from typing import Any, Literal, TypedDict, cast

import numpy as np
from pydantic import Field

from geometry import BlockGeometry, BodyGeometry, Elastic, GradedAxis, Layering, RimGradedAxis, Turned, WireGeometry
from geometry.arrays import Array
from wirewear.base.errors import RecordError, StudyError
from wirewear.test import keys
from wirewear.test.drive import BULK, BulkTable
from wirewear.test.faces import Face
from wirewear.test.surfaces import LAYERS, LayerTable, StatedSurface

#: How far a block's face falls to its sides over its sharper radius: a ball's corner, at 0.85 radii, is still meshed
#: soundly.
_FALL = 0.2


YIELDS = "stress at which its material yields in tension; without it the body stays elastic"
HARDENS = "rise of that stress per plastic strain; without it the stress stays"


OPEN = "?"  #: Placeholder in a guessed file for values that only the user knows.


class StatedBody(keys.Table):
    """The keys of any body, in studies, records and mappings of all kinds."""

    bulk: BulkTable | None = Field(None, description=BULK)


class ElasticKeys(keys.OfMaterial):
    """Keys of an elastic material."""

    material: keys.MaterialName | None = Field(
        None, description="name of a material of the table, in place of its constants", examples=["Ti-6Al-4V"]
    )
    youngs_modulus_MPa: keys.YoungsModulus = Field(description="Young's modulus", examples=[210000.0])
    poissons_ratio: keys.PoissonsRatio = Field(description="Poisson's ratio", examples=[0.3])

    @property
    def elastic(self) -> Elastic:
        return Elastic(self.youngs_modulus_MPa, self.poissons_ratio)


class YieldingKeys(ElasticKeys):
    """Keys of a material that is elastic or, with a yield stress, ideally plastic."""

    yield_stress_MPa: keys.YieldStress | None = Field(None, description=YIELDS)


class MaterialKeys(YieldingKeys):
    """Keys of the material of a simulated body: elastic or, with a yield stress, plastic with linear hardening."""

    hardening_modulus_MPa: keys.Hardening | None = Field(None, description=HARDENS)


class CoatedBody(StatedBody):
    """Keys of any body that may have layers, such as coatings, in studies and records."""

    layers: tuple[LayerTable, ...] = Field((), description=LAYERS)


class SurfaceKeys(CoatedBody):
    """Keys of any body in a study: its surface as measured before the test, its layers and its bulk stress."""

    surface: StatedSurface | None = Field(None, description="its surface as measured before the test")


class GripKeys(keys.Table):
    """The key for how stiffly the holder grips a body, per area."""

    grip_stiffness_N_per_mm3: keys.GripStiffness = Field(
        "rigid", description='stiffness per area of what holds the body, a number or "rigid"'
    )


class KeysOfBody(TypedDict):
    """Arguments of `Body` that have keys of the same names."""

    youngs_modulus_MPa: float
    poissons_ratio: float
    grip_stiffness_N_per_mm3: float | Literal["rigid"]
    axis_angle_deg: float
    surface: StatedSurface | None
    layers: tuple[LayerTable, ...]
    bulk: BulkTable | None
    yield_stress_MPa: float | None
    hardening_modulus_MPa: float | None


class MountedBody(SurfaceKeys, GripKeys, MaterialKeys):
    """Keys of a body of one material, held by its holder, in a study of any kind."""

    @property
    def as_stated(self) -> KeysOfBody:
        """Arguments of `Body` as these keys state them; bodies without an axis are at 0°."""
        own = {key: getattr(self, key) for key in KeysOfBody.__annotations__ if key in type(self).model_fields}
        return cast("KeysOfBody", {"axis_angle_deg": 0.0, **own})


@dataclass(frozen=True)
class Body(ABC):
    """A body of a contact at a point, as it is meshed. axis_angle_deg: angle of its axis to the motion, about the
    normal that points upwards. grip_stiffness_N_per_mm3: stiffness of its holder per gripped area. surface: as measured
    before the test, None for the unworn shape. layers: coatings, the outermost first. yield_stress_MPa: None for a body
    that stays elastic.
    """

    name: str
    youngs_modulus_MPa: float
    poissons_ratio: float
    grip_stiffness_N_per_mm3: float | Literal["rigid"]
    axis_angle_deg: float
    surface: StatedSurface | None = field(default=None, kw_only=True)
    layers: tuple[LayerTable, ...] = field(default=(), kw_only=True)
    bulk: BulkTable | None = field(default=None, kw_only=True)
    yield_stress_MPa: float | None = field(default=None, kw_only=True)
    hardening_modulus_MPa: float | None = field(default=None, kw_only=True)

    @property
    def material(self) -> Elastic:
        return Elastic(self.youngs_modulus_MPa, self.poissons_ratio)

    @property
    @abstractmethod
    def curvatures_per_mm(self) -> tuple[float, float]:
        """(along, across): curvatures in 1/mm of its face, one over the radii; 0 where straight."""

    @property
    def face(self) -> Face | None:
        """The profile of a pad's face; None for any other body, whose face follows from its curvatures."""
        return None

    @property
    def has_axis(self) -> bool:
        """True if its curvatures along and across its axis differ, so that its direction matters."""
        along, across = self.curvatures_per_mm
        return along != across

    @property
    def diameters_mm(self) -> tuple[float, float]:
        """(along, across): diameters of its face, infinite where straight."""
        along, across = (2.0 / k if k else float("inf") for k in self.curvatures_per_mm)
        return along, across

    def curvature_per_mm(self, turned_deg: float = 0.0) -> Array:
        """Curvature matrix K (2, 2) in 1/mm of its face z = ½ rᵀKr, with r along and across the motion. turned_deg:
        angle by which its axis is turned beyond axis_angle_deg.
        """
        angle = radians(self.axis_angle_deg + turned_deg)
        turn = np.array([[cos(angle), -sin(angle)], [sin(angle), cos(angle)]])
        return np.asarray(turn @ np.diag(self.curvatures_per_mm) @ turn.T)

    @property
    def bedding_N_per_mm3(self) -> float | None:
        """Stiffness of its grip per area; None for a rigid one."""
        return None if isinstance(self.grip_stiffness_N_per_mm3, str) else self.grip_stiffness_N_per_mm3

    @abstractmethod
    def geometry(
        self, axial: GradedAxis | RimGradedAxis, transverse: GradedAxis | RimGradedAxis, layering: Layering
    ) -> BodyGeometry:
        """The geometry to mesh: a patch whose nodes lie on these axes (along and across the body's axis), with element
        layers below it by `layering`. Raises StudyError if the patch does not fit on the body.
        """


def yield_of(body: Body | MaterialKeys) -> tuple[float, float] | None:
    """(yield stress, hardening modulus) in MPa, 0 for no stated hardening; None for an elastic body."""
    return None if body.yield_stress_MPa is None else (body.yield_stress_MPa, body.hardening_modulus_MPa or 0.0)


@dataclass(frozen=True)
class BodiesByOptions:
    """Bodies stated by options of a command. tables: those of a mapping file; remarks: sentences on what was assumed;
    bodies: (driven, held), empty if their size is not stated. length_mm: of a line contact, None at a point. with_axis:
    names of the bodies that always have an axis. needs_loops: False if a record of them may lack loops.
    """

    tables: Mapping[str, Any]
    remarks: tuple[str, ...] = ()
    bodies: tuple[Body, ...] = ()
    length_mm: float | None = None
    with_axis: tuple[str, ...] = ()
    needs_loops: bool = True


class StatedBodies(keys.Table):
    """The keys by which the files of a kind of test state its bodies; each kind of test has a subclass."""

    @classmethod
    def by_options(
        cls, known: Mapping[str, object], elastic: Mapping[str, object], of_other: Mapping[str, object]
    ) -> BodiesByOptions:
        """Bodies from options of a command. known: options by key, such as diameter_mm; elastic, of_other: elastic
        constants of the driven and of the held body. Raises RecordError, in one sentence, if a needed value is missing.
        """
        del known, elastic, of_other
        raise RecordError(
            "no options state shapes of bodies: write [contact] and [bodies] of a mapping yourself (docs/records.md), "
            "or take --kind ball-on-flat or crossed-wires."
        )


@dataclass(frozen=True)
class Wire(Body):
    """A round bar, gripped about its back or at its ends: a wire or, with bore_mm above 0, a tube. grip_angle_deg: part
    of the circumference that is gripped. length_mm: None is chosen by the program; grip_length_mm: None is all of it.
    """

    diameter_mm: float
    length_mm: float | None
    grip_angle_deg: float
    grip_length_mm: float | None
    held_at: Literal["back", "ends"] = "back"
    bore_mm: float = 0.0

    @property
    def curvatures_per_mm(self) -> tuple[float, float]:
        return 0.0, 2.0 / self.diameter_mm

    def geometry(
        self, axial: GradedAxis | RimGradedAxis, transverse: GradedAxis | RimGradedAxis, layering: Layering
    ) -> WireGeometry:
        reach, limit = transverse.half_extent_mm, 0.42 * self.diameter_mm
        if reach > limit:
            raise StudyError(
                f"the {self.name} wire is too thin for this test: the contact is expected to need {1e3 * reach:.0f} um "
                f"to each side of its crown, but at most {1e3 * limit:.0f} um of a wire of {self.diameter_mm:g} mm can "
                "be meshed; lower the cycles, load, stroke or wear coefficient, or give a smaller scar_half_width_um "
                "in [mesh]"
            )
        shortest = 2.0 * axial.half_extent_mm / 0.9
        length = self.length_mm or max(2.2 * self.diameter_mm, shortest + self.diameter_mm)
        if length < shortest:
            raise StudyError(
                f"length_mm = {length:g} of the {self.name} wire is too short: stroke and scar need at least "
                f"{shortest:.3g} mm"
            )
        return WireGeometry(
            self.diameter_mm,
            length,
            axial,
            transverse,
            0.155 * self.diameter_mm,
            grip_half_angle_rad=0.5 * radians(self.grip_angle_deg),
            grip_half_length_mm=None if self.grip_length_mm is None else 0.5 * self.grip_length_mm,
            grip_stiffness_N_per_mm3=self.bedding_N_per_mm3,
            layering=layering,
            gripped_at_ends=self.held_at == "ends",
            bore_mm=self.bore_mm,
        )


@dataclass(frozen=True)
class BlockBody(Body):
    """A block with the face of a ball, a barrel, a cylinder, a flat or a pad, held at its back and sides. half_width_mm
    (to each side) and height_mm: None is chosen from size_mm and the curvatures (along, across). of_pad: a pad's face,
    whose curvatures are 0.
    """

    curvatures: tuple[float, float]
    half_width_mm: float | None
    height_mm: float | None
    #: Length by which its extents are chosen if they are not stated: a radius, its own or the other body's.
    size_mm: float
    of_pad: Face | None = None

    @property
    def curvatures_per_mm(self) -> tuple[float, float]:
        return self.curvatures

    @property
    def face(self) -> Face | None:
        return self.of_pad

    def geometry(
        self, axial: GradedAxis | RimGradedAxis, transverse: GradedAxis | RimGradedAxis, layering: Layering
    ) -> BlockGeometry:
        """A block as wide as its radii allow or, where straight, wide enough to keep its sides far from the contact.

        Held at back and sides, its approach is less than a half-space's by about 0.5 a² / size for a ball's contact of
        radius a.
        """
        along, across = (
            self._half_width(curvature, axis.half_extent_mm)
            for curvature, axis in zip(self.curvatures, (axial, transverse), strict=True)
        )
        sharpest = max(self.curvatures)
        height = self.height_mm or (1.0 / sharpest if sharpest else min(along, across))
        # Largest element of a block far from the contact, as a share of its smaller extent.
        coarse = 0.2 * min(along, across, height)
        face = None if self.of_pad is None else Turned(self.of_pad)
        size, held = (along, across, height), self.bedding_N_per_mm3
        return BlockGeometry(*self.curvatures, *size, axial, transverse, coarse, held, layering, face)

    @property
    def _called(self) -> str:
        return f"{self.name} body" if self.name in ("lower", "upper") else self.name

    def _half_width(self, curvature: float, reach_mm: float) -> float:
        """Half of the block's extent in mm in the direction of a curvature, for a patch that reaches `reach_mm` to each
        side. Raises StudyError if it would be too narrow for the patch, or too wide for its radius.
        """
        # Half-width of a straight block over the other body's radius, or its patch.
        straight = 4.0 * max(self.size_mm, reach_mm)
        fall = _FALL / max(self.curvatures) if curvature else 0.0
        widest = sqrt(fall * (2.0 / curvature - fall)) if curvature else inf
        width = self.half_width_mm or min(straight, widest)
        if width > widest:
            raise StudyError(
                f"half_width_mm = {width:g} of the {self._called} is too wide: a block on it reaches at most "
                f"{widest:.4g} mm to each side, where it falls by {_FALL:g} of its radius"
            )
        if reach_mm > 0.9 * width:
            raise StudyError(
                f"the {self._called} is too small for this test: the contact is expected to need "
                f"{1e3 * reach_mm:.0f} um to each side of its middle, but at most {900.0 * width:.0f} um can be "
                "meshed; lower the cycles, load, stroke or wear coefficient, or give a smaller scar_half_width_um in "
                "[mesh]"
            )
        return width
