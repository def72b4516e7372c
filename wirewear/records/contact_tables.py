"""Tables of experiment.toml for line contacts, for contacts at a point of bodies of any shape, and for joints."""

from collections.abc import Mapping
from dataclasses import replace
from math import inf
from typing import Annotated, Any, ClassVar, Generic, Literal, Self, TypeGuard, TypeVar

from pydantic import Field, PlainValidator

from wirewear.base import kinds
from wirewear.base.errors import RecordError
from wirewear.base.files import table_of
from wirewear.records import tables
from wirewear.records.common_tables import FRICTION_FORCE, Metadata, OfRecord, of_kinds
from wirewear.records.surfaces import NO_SURFACES, PROFILES, SCARS
from wirewear.records.tables import PointRecordTables, PointTest, RecordTables, curved
from wirewear.results.scar import BODIES
from wirewear.test import keys, study_from_tables
from wirewear.test.bodies import Body, CoatedBody, MaterialKeys
from wirewear.test.faces import FACE_KEYS, PadFace, half_width_of
from wirewear.test.joints import AskedOfJoint, Force, JointStiffness
from wirewear.test.keys import Inconsistency, Table, one_of
from wirewear.test.lengths import stated_length_mm, whole_test
from wirewear.test.line_bodies import Extent, Pad, Specimen
from wirewear.test.lines import PadAndSpecimen, WearOfBodies
from wirewear.test.points import TwoBodies


class RecordContact(keys.Table):
    """The kind and length of a line contact."""

    kind: Annotated[
        Literal["line-contact", "cylinder-on-flat"], PlainValidator(keys.one_of(*kinds.NAMES[kinds.LINE_CONTACT]))
    ] = Field(description="kind of contact", examples=[kinds.LINE_CONTACT])
    length_mm: Extent = Field(description="length of the line contact", examples=[10.0])


class RecordBody(MaterialKeys, CoatedBody):
    """Body of a line contact with its elastic constants, and its size between contact and grip; None if unknown."""

    height_mm: Extent | None = Field(None, description="height between the contact and where the body is held")
    half_width_mm: Extent | None = Field(None, description="half of the body's width along the motion")


class RecordPad(PadFace, RecordBody):
    """Pad with its face and elastic constants."""


class LineStated(tables.StatedRig, WearOfBodies, tables.StatedLaw, tables.StatedFriction):
    """Statements of the rig's owner about a line contact's rig, friction and wear; unstated properties are taken as
    ideal.
    """

    stiffness_includes: Annotated[Literal["rig only", "bodies"], PlainValidator(keys.one_of("rig only", "bodies"))] = (
        Field(
            "rig only",
            description='what that stiffness is of: "rig only", or "bodies" where pad and specimen add to it',
        )
    )

    def with_fitted(self, fitted: Mapping[str, object]) -> Self:
        """Copy with fitted values by key: a fitted energy coefficient replaces Archard's, a fitted stiffness is the
        rig's alone.
        """
        energy, archard = "energy_wear_coefficient_mm3_per_J", "archard_wear_coefficient_mm3_per_N_m"
        rig = {"stiffness_includes": "rig only"} if "tangential_stiffness_N_per_mm" in fitted else {}
        other = {key.replace(energy, archard): None for key in fitted if key.endswith(energy)}
        return super().with_fitted({**fitted, **rig, **other})


class LineNoise(tables.Noise):
    """Standard deviation of one sample of each channel; None if unknown."""

    depth_um: tables.DisplacementNoise | None = Field(
        None, description="error of one depth of a profile, such as that of reading it from a figure", examples=[0.05]
    )


class LineFiles(keys.Table):
    """Names of the data files beside experiment.toml, of which at least one is given."""

    loops: tables.FileName | None = Field(None, description="file of the loops", examples=["loops.csv"])
    evolution: tables.FileName | None = Field(None, description="file of the evolution over the cycles")
    profile_pad: tables.FileName | None = Field(None, description="file of the pad's worn profile at the end")
    profile_specimen: tables.FileName | None = Field(None, description="file of the specimen's worn profile at the end")


class LineTest(OfRecord):
    """Test of a line contact as stated in a file, without the names of data files."""

    of, worn, needs_loops = PadAndSpecimen, PROFILES, False

    contact: RecordContact = Field(description="what touches")
    pad: RecordPad = Field(description="the pad")
    specimen: RecordBody = Field(description="the flat")
    conditions: tables.RecordConditions = Field(description="load, stroke, frequency and length of the test")
    stated: LineStated = Field(LineStated(), description="what the rig's owner states")
    noise: LineNoise = Field(LineNoise(), description="noise of one sample")
    scatter: tables.StatedScatter = Field(
        tables.StatedScatter(), description="scatter between tests on fresh specimens"
    )
    tolerance: tables.Tolerance = Field(tables.Tolerance(), description="differences that count as none")
    metadata: Metadata = Field(Metadata(), description="surroundings, surfaces and origin of the test")

    @property
    def wear(self) -> dict[str, tuple[str, ...]]:
        return {f"{body}_energy_wear_coefficient_mm3_per_J": (body,) for body in BODIES}

    @property
    def shares(self) -> dict[str, float]:
        """Share of the worn volume that each body loses, by the stated wear coefficients; 0.5 if none is stated."""
        stated = {body: getattr(self.stated, f"{body}_energy_wear_coefficient_mm3_per_J") or 0.0 for body in BODIES}
        total = sum(stated.values())
        return {body: own / total if total > 0.0 else 0.5 for body, own in stated.items()}

    @property
    def length_mm(self) -> float:
        return self.contact.length_mm

    @property
    def depth_noise_um(self) -> float:
        return self.noise.depth_um or 0.0

    @classmethod
    def length_of(cls, study: Mapping[str, object], asked_mm: float | None, label: str) -> float:
        """Length in mm that the user asks for, or else the study's. asked_mm: None or 0 for none asked. Raises
        RecordError if the study's is 1 mm, as forces are then per millimetre, and none is asked for.
        """
        if not asked_mm and (own := stated_length_mm(study)) == 1.0:
            raise RecordError(f"the forces of {label} are per millimetre: give its --length for a record.")
        return asked_mm or own

    @classmethod
    def known(cls, data: dict[str, object], where: str) -> dict[str, object]:
        return whole_test(data, where, RecordError)

    @classmethod
    def bodies_of(cls, study: Mapping[str, object], label: str) -> dict[str, object]:
        del label
        pad, specimen = ({key: own for key, own in table_of(study, body).items() if own != []} for body in BODIES)
        round_pad, length_mm = pad.get("radius_mm") is not None, table_of(study, "contact")["length_mm"]
        return {
            "contact": {"kind": kinds.CYLINDER_ON_FLAT if round_pad else kinds.LINE_CONTACT, "length_mm": length_mm},
            "pad": tables.known_of(RecordPad, {**pad, "material": None}),
            "specimen": tables.known_of(RecordBody, {**specimen, "material": None}),
        }

    @classmethod
    def stated_by(cls, study: Mapping[str, object]) -> dict[str, object]:
        return {key: value for key, value in super().stated_by(study).items() if value or key not in LineStated.WEAR}

    @property
    def of_study(self) -> dict[str, float | None]:
        return {
            "normal_load_N": self.conditions.normal_load_N,
            "displacement_amplitude_um": self.conditions.displacement_amplitude_um,
            **{key: getattr(self.pad, key) for key in FACE_KEYS},
        }

    def with_bodies(self, data: dict[str, object]) -> dict[str, object]:
        """Tables of a study with pad and specimen added; heights that are not stated are assumed. Raises RecordError if
        the bodies alone are no stiffer than the stated stiffness that includes them.
        """
        data["contact"] = {**table_of(data, "contact"), "length_mm": self.length_mm}
        heights = self.assumed_heights_mm
        for body in BODIES:
            own = getattr(self, body).model_dump(mode="json", exclude_none=True, exclude={"material"})
            data[body] = own | ({"height_mm": heights[body]} if body in heights else {})
        holder = table_of(data, "holder")
        key = "tangential_stiffness_N_per_mm"
        if self.stated.stiffness_includes == "bodies" and holder.get(key, "rigid") != "rigid":
            without_rig = {name: table for name, table in data.items() if name not in ("holder", "wear", "effects")}
            data["holder"] = {**holder, key: self._without_bodies(without_rig)}
        return data

    @property
    def assumed_heights_mm(self) -> dict[str, float]:
        """Assumed heights in mm of the bodies that state none, by body: the default of studies, for a pad at most its
        width. A block is sheared by friction; a column would bend, with a compliance that goes with the cube of an
        unknown height.
        """
        width = 2.0 * (self.pad.half_width_mm or half_width_of(self.pad.profile))
        usual = {"pad": min(Pad.model_fields["height_mm"].default, width)}
        usual["specimen"] = Specimen.model_fields["height_mm"].default
        return {body: height for body, height in usual.items() if getattr(self, body).height_mm is None}

    @property
    def doubts_bodies(self) -> bool:
        """True if the compliance between rig and contact is uncertain: a height is assumed, and no stated stiffness
        includes the bodies.
        """
        stated = self.stated
        whole = stated.stiffness_includes == "bodies" and stated.tangential_stiffness_N_per_mm != "rigid"
        return bool(self.assumed_heights_mm) and not whole

    def _without_bodies(self, data: Mapping[str, Any]) -> float:
        """Stiffness of the rig alone in N/mm: the stated one less pad and specimen, which are in series with
        the rig.
        """
        from wirewear.simulation import bodies_stiffness_N_per_mm2

        whole = float(self.stated.tangential_stiffness_N_per_mm)
        study = study_from_tables(data, f"the bodies of the record {self.name!r}")
        of_bodies = self.length_mm * bodies_stiffness_N_per_mm2(study)
        if whole >= of_bodies:
            raise RecordError(
                f"[stated] of the record {self.name!r} gives a stiffness of {whole:.4g} N/mm that includes the bodies, "
                f"but these alone have {of_bodies:.4g} N/mm: correct it, height_mm or half_width_mm of [pad] and "
                '[specimen], or say stiffness_includes = "rig only".'
            )
        return 1.0 / (1.0 / whole - 1.0 / of_bodies)

    def require_whole(self, where: str) -> None:
        if (wanted := self.pad.missing_face(self.contact.kind)) is not None:
            raise RecordError(f"[pad] of {where} does not say which face the pad has: {wanted}.")

    @property
    def missing(self) -> tuple[str, ...]:
        worn = any(getattr(self.stated, key) is not None for key in WearOfBodies.model_fields)
        needs = {"friction": self.stated.final_friction is not None, "a wear coefficient of pad or specimen": worn}
        return tuple(key for key, given in needs.items() if not given)


class LineRecordTables(LineTest):
    """All tables of a line contact's experiment.toml."""

    files: LineFiles = Field(description="names of the data files")


Bodies = TypeVar("Bodies", bound=TwoBodies)


class ContactAtAPoint(Table):
    """What touches at a point: the name of the kind, such as "ball-on-flat"."""

    kind: Annotated[str, PlainValidator(one_of(*kinds.AT_A_POINT[1:]))] = Field(
        description="kind of contact", examples=[kinds.BALL_ON_FLAT]
    )


class BodiesTest(PointTest, Generic[Bodies]):
    """Test of two bodies that touch at a point, as stated in a file."""

    of = TwoBodies
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
        return self.bodies.of_test()

    def contradiction(self) -> Inconsistency | None:
        return self.bodies.contradiction()


class BodiesRecord(PointRecordTables, BodiesTest[Bodies], Generic[Bodies]):
    """All tables of the experiment.toml of two bodies that touch at a point."""

    @classmethod
    def bodies_of(cls, study: Mapping[str, object], label: str) -> dict[str, object]:
        del label
        bodies = table_of(study, "bodies")
        stated = {name: {key: own for key, own in table_of(bodies, name).items() if own != []} for name in bodies}
        return {"contact": {"kind": cls.contact_kind}, "bodies": stated}

    @property
    def of_study(self) -> dict[str, float | None]:
        return {**super().of_study, **curved(self.model_dump(exclude_none=True)["bodies"])}

    def with_bodies(self, data: dict[str, object]) -> dict[str, object]:
        return data | {"bodies": self.model_dump(mode="json", exclude_none=True)["bodies"]}


class ContactOfJoint(JointStiffness):
    """What touches, a joint, and its own stiffness, rigid if unstated."""

    kind: Annotated[Literal["joint"], PlainValidator(keys.one_of(kinds.JOINT))] = Field(
        description="kind of contact", examples=[kinds.JOINT]
    )


class ConditionsOfJoint(AskedOfJoint, tables.RecordConditions):
    """Conditions asked of a joint's rig; the normal load may be left out if the friction force is stated."""


class StatedOfJoint(tables.StatedRig):
    """Statements of the owner of a joint's rig; unstated properties are taken as ideal."""

    WEAR: ClassVar[tuple[str, ...]] = ()

    friction_force_N: Force | None = Field(
        None, description="friction force, in place of friction; without a normal load it stands for that, too"
    )


class FilesOfJoint(keys.Table):
    """Names of the data files beside experiment.toml."""

    loops: tables.FileName = Field(description="file of the loops", examples=["loops.csv"])
    evolution: tables.FileName | None = Field(None, description="file of the evolution over the cycles")


class JointTest(OfRecord):
    """Test of a joint as stated in a file, without the names of data files."""

    of, worn, needs_loops, fitted_by_loops, contact_slips = JointStiffness, NO_SURFACES, True, True, False

    contact: ContactOfJoint = Field(description="what touches")
    conditions: ConditionsOfJoint = Field(description="load, stroke, frequency and length of the test")
    stated: StatedOfJoint = Field(StatedOfJoint(), description="what the rig's owner states")
    noise: tables.Noise = Field(tables.Noise(), description="noise of one sample")
    scatter: tables.StatedScatter = Field(tables.StatedScatter(), description="scatter between tests")
    tolerance: tables.Tolerance = Field(tables.Tolerance(), description="differences that count as none")
    metadata: Metadata = Field(Metadata(), description="surroundings, surfaces and origin of the test")

    @classmethod
    def known(cls, data: dict[str, object], where: str) -> dict[str, object]:
        """A file's tables with a stated friction force converted to a coefficient, force over load; an unknown load is
        set to that force. Raises RecordError if both friction and friction force are stated.
        """
        stated, conditions = data.get("stated"), data.get("conditions")
        force = stated.get(FRICTION_FORCE) if isinstance(stated, Mapping) else None
        if not isinstance(stated, Mapping) or not isinstance(conditions, Mapping) or not _is_positive(force):
            return data
        if "friction" in stated:
            raise RecordError(f"{where} gives both friction and {FRICTION_FORCE} in [stated]: give one of the two.")
        load = conditions.get("normal_load_N", force)
        if not _is_positive(load):
            return data
        rest = {key: value for key, value in stated.items() if key != FRICTION_FORCE}
        return {
            **data,
            "conditions": {**conditions, "normal_load_N": load},
            "stated": {**rest, "friction": force / load},
        }

    @property
    def wear(self) -> dict[str, tuple[str, ...]]:
        return {}

    @property
    def shares(self) -> dict[str, float]:
        return {}

    @classmethod
    def bodies_of(cls, study: Mapping[str, object], label: str) -> dict[str, object]:
        del label
        return {"contact": {"kind": kinds.JOINT, **tables.known_of(JointStiffness, table_of(study, "contact"))}}

    @property
    def of_study(self) -> dict[str, float | None]:
        asked = self.conditions
        return {"normal_load_N": asked.normal_load_N, "displacement_amplitude_um": asked.displacement_amplitude_um}

    def with_bodies(self, data: dict[str, object]) -> dict[str, object]:
        own = self.contact.model_dump(include={*JointStiffness.model_fields})
        return data | {"contact": {**table_of(data, "contact"), **own}}

    @property
    def contact_stiffness_N_per_um(self) -> float:
        stated = self.contact.contact_stiffness_N_per_mm
        return inf if stated == "rigid" else 1e-3 * float(stated)

    @property
    def predicted(self) -> str:
        return "A prediction of its loops"

    @property
    def missing(self) -> tuple[str, ...]:
        return ("friction",) if self.stated.final_friction is None else ()


class JointRecordTables(JointTest):
    """All tables of a joint's experiment.toml."""

    files: FilesOfJoint = Field(description="names of the data files")


def _is_positive(value: object) -> TypeGuard[float]:
    return isinstance(value, int | float) and not isinstance(value, bool) and value > 0.0


AnyTables = PointRecordTables | LineRecordTables | JointRecordTables

#: Tables of records by the names of kinds of test.
RECORDS: dict[str, type[AnyTables]] = of_kinds(RecordTables, LineRecordTables, JointRecordTables, BodiesRecord)
