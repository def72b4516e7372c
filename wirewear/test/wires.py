"""The keys of both wires of a study or a record, with types, defaults and meanings.

The moving wire is driven and lies below; the fixed one, above it, is held. Angles are about the normal that points
upwards.
"""

import warnings
from collections.abc import Mapping
from dataclasses import fields
from typing import Annotated, Any

from pydantic import AliasChoices, BeforeValidator, Field

from wirewear.base.errors import AssumedWarning
from wirewear.base.words import shown
from wirewear.test import keys
from wirewear.test.bodies import OPEN, BodiesByOptions, GripKeys, MaterialKeys, StatedBodies, SurfaceKeys, Wire
from wirewear.test.gaps import touch_along_line

#: Keys that each wire needs; the fixed wire has the moving one's values if it does not state its own.
_NEEDED = ("diameter_mm", "youngs_modulus_MPa", "poissons_ratio")
_YIELDS = ("yield_stress_MPa", "hardening_modulus_MPa")
_MATERIAL = ("material", *_YIELDS)  #: Keys that belong to a material's constants.
_MOTION = "motion_angle_deg"
_ANGLES = ("crossing_angle_deg", _MOTION)
_BOTH = AliasChoices("wires", "bodies")


def _wires_of_bodies(table: Any) -> Any:
    """A table of both wires from [wires] whose wires state keys it lacks, or from [bodies.moving] and [bodies.fixed].

    Raises ValueError if one is not a wire, or an angle is stated twice.
    """
    stated = [table.get(name) for name in ("moving", "fixed")] if isinstance(table, Mapping) else []
    if not stated or not all(isinstance(own, Mapping) and own for own in stated):
        return table
    both, moving, fixed = (dict(keys.with_constants_of_material(own)) for own in (table, *stated))
    for shape in (own.pop("shape", "wire") for own in (moving, fixed)):
        if shape != "wire":
            raise ValueError(f'give a {shown(shape)}, but crossed wires are wires: kind = "point-contact" takes others')
    shared = [key for key in _NEEDED if key not in both and key in moving]
    if assumed := [key for key in shared if key not in fixed]:
        said = f"the fixed wire states no {', no '.join(assumed)}, and is taken to have what the moving wire states"
        warnings.warn(AssumedWarning(f"{said}."), stacklevel=2)
    for key in shared:
        both |= {own: moving.pop(own) for own in (key, *_MATERIAL) if own in moving and own not in both}
    return {**both, **_angles(both, moving, fixed), "moving": moving, "fixed": fixed}


def _angles(both: Mapping[str, Any], moving: dict[str, Any], fixed: dict[str, Any]) -> dict[str, float]:
    """Crossing and motion angle in degrees from the wires' own axis angles, which are removed from their tables; or
    empty. Raises ValueError if one is not an angle, or the crossing or motion angle is stated as well.
    """
    given = [own.pop("axis_angle_deg", None) for own in (moving, fixed)]
    if given == [None, None]:
        return {}
    if twice := [key for key in _ANGLES if key in both]:
        raise ValueError(f"give {twice[0]} beside an axis_angle_deg, which states it as well: give one of the two")
    try:
        first, second = (
            float(keys.AXIS(default if own is None else own)) for own, default in zip(given, (0.0, 90.0), strict=True)
        )
    except ValueError as problem:
        raise ValueError(f"give an axis_angle_deg that {problem}") from None
    return {"crossing_angle_deg": (second - first) % 180.0, "motion_angle_deg": (90.0 - first) % 180.0 - 90.0}


def with_motion_of_wires(tables: object) -> object:
    """A study's unchecked nested tables with the direction of motion moved from the wires into [conditions].
    Unchanged if both state it, or the wires cannot be read.
    """
    if not isinstance(tables, Mapping):
        return tables
    key = next((own for own in _BOTH.choices if own in tables), "")
    wires, conditions = (tables[key], tables.get("conditions")) if key else (None, None)
    if not isinstance(wires, Mapping) or not isinstance(conditions, Mapping):
        return tables
    turned = any("axis_angle_deg" in own for own in wires.values() if isinstance(own, Mapping))
    try:
        both = _wires_of_bodies(wires) if turned else wires
    except ValueError:
        # To be refused at its key.
        return tables
    # Results of earlier versions hold a default of 0 beside what the wires state.
    twice = conditions.get(_MOTION) is not None if turned else bool(conditions.get(_MOTION))
    if both.get(_MOTION) is None or twice:
        return tables
    rest = {own: value for own, value in both.items() if own != _MOTION}
    return {**tables, key: rest, "conditions": {**conditions, _MOTION: both[_MOTION]}}


class WireOverride(SurfaceKeys, keys.OfMaterial):
    """Keys of one wire; those that it does not state are as in `[wires]`."""

    diameter_mm: keys.Diameter | None = Field(None, description="diameter of this wire")
    length_mm: keys.Length | None = Field(None, description="modelled length of this wire")
    material: keys.MaterialName | None = Field(
        None, description="name of this wire's material, in place of its constants"
    )
    youngs_modulus_MPa: keys.YoungsModulus | None = Field(None, description="Young's modulus of this wire")
    poissons_ratio: keys.PoissonsRatio | None = Field(None, description="Poisson's ratio of this wire")
    yield_stress_MPa: keys.YieldStress | None = Field(None, description="yield stress of this wire")
    hardening_modulus_MPa: keys.Hardening | None = Field(None, description="hardening modulus of this wire")
    grip_angle_deg: keys.GripAngle | None = Field(None, description="part of this wire's circumference that is held")
    grip_length_mm: keys.Length | None = Field(None, description="length over which this wire is held")
    grip_stiffness_N_per_mm3: keys.GripStiffness | None = Field(
        None, description="stiffness of this wire's grip per area"
    )


class _DiameterOfWires(keys.Table):
    """The key with which the table of the wires begins."""

    diameter_mm: keys.Diameter = Field(description="diameter of the wires", examples=[0.45])


class Wires(GripKeys, MaterialKeys, _DiameterOfWires, StatedBodies):
    """Keys of both wires, with what the moving or the fixed one has different."""

    crossing_angle_deg: keys.CrossingAngle = Field(
        90.0, description="angle of the fixed wire's axis to the moving one's, about the normal that points upwards"
    )
    motion_angle_deg: keys.MotionAngle | None = Field(
        None, description="that of the motion to the moving wire's axis, of a study in its conditions"
    )
    length_mm: keys.Length | None = Field(None, description="modelled length; without it the program chooses")
    grip_angle_deg: keys.GripAngle = Field(90.0, description="part of the circumference, about the back, that is held")
    grip_length_mm: keys.Length | None = Field(
        None, description="length over which a wire is held, about its middle; without it all of the modelled length"
    )
    moving: WireOverride = Field(WireOverride(), description="what the moving wire has different")
    fixed: WireOverride = Field(WireOverride(), description="what the fixed wire has different")

    @classmethod
    def by_options(
        cls, known: Mapping[str, object], elastic: Mapping[str, object], of_other: Mapping[str, object]
    ) -> BodiesByOptions:
        del of_other
        remarks = []
        if "diameter_mm" not in known:
            remarks.append("no file states the wires' diameter, in millimetres: --diameter does it, too")
        if "crossing_angle_deg" not in known:
            remarks.append(
                "the bodies are taken for wires that cross at 90°; --kind and --crossing-angle say otherwise"
            )
        angle = known.get("crossing_angle_deg", 90.0)
        wires = {"diameter_mm": known.get("diameter_mm", OPEN), "crossing_angle_deg": angle, **elastic}
        bodies = cls.model_validate(wires).of_test() if "diameter_mm" in known else ()
        return BodiesByOptions({"wires": wires}, tuple(remarks), bodies, with_axis=("moving", "fixed"))

    def of_test(self, motion_angle_deg: float = 0.0) -> tuple[Wire, Wire]:
        """(moving, fixed). motion_angle_deg: angle of the motion to the moving wire's axis, if they state none."""
        motion = self.motion_angle_deg or motion_angle_deg
        return self._wire("moving", -motion), self._wire("fixed", self.crossing_angle_deg - motion)

    def _wire(self, name: str, axis_angle_deg: float) -> Wire:
        different = {key: value for key, value in getattr(self, name) if value is not None}
        # A wire of another material yields where that does.
        shared = {key: value for key, value in self if key not in _YIELDS or "youngs_modulus_MPa" not in different}
        stated = shared | different
        names = {field.name for field in fields(Wire)} & WireOverride.model_fields.keys()
        own: dict[str, Any] = {key: stated.get(key) for key in names}
        return Wire(name=name, axis_angle_deg=axis_angle_deg, **own)

    def contradiction(self) -> keys.Inconsistency | None:
        """The contradiction of a wire shorter than thick, or of wires that touch along a line; None if all fit."""
        moving, fixed = self.of_test()
        for wire in (moving, fixed):
            if (wire.length_mm or wire.diameter_mm) < wire.diameter_mm:
                own = (wire.name,) if getattr(self, wire.name).length_mm else ()
                return keys.Inconsistency(
                    ("wires", *own, "length_mm"),
                    f"is {wire.length_mm:g} mm, but must be at least the wire's diameter, {wire.diameter_mm:g} mm",
                )
        if touch_along_line(moving, fixed):
            return keys.Inconsistency(
                ("wires", "crossing_angle_deg"),
                f"is {self.crossing_angle_deg:g}°, at which wires so unlike touch along a line or nearly so",
            )
        return None


#: A key that takes both wires, or two bodies by their names.
BothWires = Annotated[
    Wires, BeforeValidator(_wires_of_bodies), Field(description="the two wires", validation_alias=_BOTH)
]
