"""Tables of experiment.toml for contacts at a point: every key with its unit, range, default and meaning."""

from abc import abstractmethod
from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, PlainValidator

from wirewear.base import kinds
from wirewear.base.errors import RecordError
from wirewear.base.files import table_of
from wirewear.base.units import Quantity
from wirewear.base.words import shown
from wirewear.records.common_tables import Metadata, OfRecord, OfTest
from wirewear.records.scars import MeasuredScar
from wirewear.records.surfaces import SCARS
from wirewear.results.scar import WIRES, called
from wirewear.test import keys
from wirewear.test.bodies import Body
from wirewear.test.conditions import Asked, HolderTable
from wirewear.test.gaps import unworn_stiffness_N_per_um
from wirewear.test.keys import Inconsistency
from wirewear.test.wires import BothWires, Wires

DRIVES = ("sensor", "stroke")

#: Keys of wires that a record states where they are not what is taken without a word.
GRIPS = ("length_mm", "grip_angle_deg", "grip_length_mm", "grip_stiffness_N_per_mm3")

FRAMES = ("test", "wire")  #: What x of a scar's map runs along: the motion of the test, or the axis of that wire.


def _checked_frame(value: object) -> str:
    if value not in FRAMES:
        raise ValueError(f'is {shown(value)}, but must be "test" (x along the motion) or "wire" (x along its axis)')
    return str(value)


def _checked_file_name(value: object) -> str:
    name = keys.checked_text(value)
    if not name.isprintable() or name.startswith(("/", "\\")) or ".." in name.replace("\\", "/").split("/"):
        raise ValueError(f"is {shown(value)}, but must name a file in the record's own folder")
    return name


Frame = Annotated[Literal["test", "wire"], PlainValidator(_checked_frame)]
FileName = Annotated[str, PlainValidator(_checked_file_name)]
DisplacementNoise = Annotated[float, PlainValidator(Quantity("um", 0.0, 1e3))]
ForceNoise = Annotated[float, PlainValidator(Quantity("N", 0.0, 1e3))]
Spread = Annotated[float, PlainValidator(Quantity("1", 0.0, 1.0))]
WearFactor = Annotated[float, PlainValidator(Quantity("1", 0.0, 100.0))]
RunningIn = Annotated[float, PlainValidator(Quantity("cycles", 1.0, 1e9))]


class RecordConditions(Asked):
    """Conditions asked of the rig."""

    drive: Annotated[Literal["sensor", "stroke"], PlainValidator(keys.one_of(*DRIVES))] = Field(
        "sensor", description="where the amplitude is held: on the sensor's reading, or on the true motion"
    )


class StatedFrictionEvolution(keys.Table):
    """Known running-in of the friction: exponential from the initial to the final coefficient."""

    initial: keys.Friction = Field(description="coefficient of friction at the start", examples=[0.44])
    final: keys.Friction = Field(description="coefficient of friction in the end", examples=[0.66])
    cycles: RunningIn = Field(description="cycles after which 63 % of the change has happened", examples=[3000])


class StatedWearRateEvolution(keys.Table):
    """Known running-in of the wear: factors on the wear coefficient, exponential from the initial to the final one."""

    initial_factor: WearFactor = Field(description="factor on the wear coefficient at the start", examples=[3.0])
    final_factor: WearFactor = Field(description="factor on the wear coefficient in the end", examples=[1.0])
    cycles: RunningIn = Field(description="cycles after which 63 % of the change has happened", examples=[10000])


class StatedFriction(keys.Table):
    """Friction as the rig's owner states it."""

    friction: keys.Friction | None = Field(None, description="coefficient of friction", examples=[0.62])


class StatedRig(HolderTable, StatedFriction):
    """Rig, friction and evolution over the cycles as the rig's owner states them."""

    friction_evolution: StatedFrictionEvolution | None = Field(None, description="running-in of the friction")
    wear_rate_evolution: StatedWearRateEvolution | None = Field(None, description="running-in of the wear")

    @property
    def final_friction(self) -> float | None:
        """Coefficient of friction after running-in; None if unstated."""
        return self.friction if self.friction_evolution is None else self.friction_evolution.final

    def with_fitted(self, fitted: Mapping[str, object]) -> Self:
        """Copy with fitted values in place of stated ones; friction runs in only if that was fitted."""
        return self.model_copy(update={"friction_evolution": None, **fitted})


class StatedLaw(keys.Table):
    """Form of the wear law as the rig's owner states it."""

    law: keys.WearLawKey | None = Field(None, description="form of the wear law, as in [wear] of a study")


class StatedWear(StatedLaw):
    """Wear as the rig's owner states it."""

    WEAR: ClassVar[tuple[str, ...]] = ("energy_wear_coefficient_mm3_per_J", "moving_share")

    energy_wear_coefficient_mm3_per_J: keys.WearCoefficient | None = Field(
        None, description="worn volume of both wires together per dissipated energy", examples=[3.0e-5]
    )
    moving_share: keys.Share = Field(0.5, description="part of the worn volume that the moving wire loses")


class Stated(StatedRig, StatedWear, StatedFriction):
    """Statements of the rig's owner; unstated properties are taken as ideal."""


class Noise(keys.Table):
    """Standard deviation of one sample of each channel; None if unknown."""

    displacement_um: DisplacementNoise | None = Field(None, description="noise of the displacement sensor")
    tangential_force_N: ForceNoise | None = Field(None, description="noise of the tangential force")
    normal_force_N: ForceNoise | None = Field(None, description="noise of the normal force")


class StatedScatter(keys.Table):
    """Standard deviations between tests on fresh specimens; None if unknown."""

    friction: Spread | None = Field(None, description="relative scatter of the friction", examples=[0.05])
    normal_load: Spread | None = Field(None, description="relative scatter of the normal load")
    wear: Spread | None = Field(None, description="relative scatter of the worn volume per energy")
    force_zero_N: ForceNoise | None = Field(None, description="scatter of the tangential force's zero")
    displacement_zero_um: DisplacementNoise | None = Field(None, description="scatter of the displacement's zero")


class Tolerance(keys.Table):
    """Relative differences that count as equal in practice.

    The defaults are calibration classes of laboratories: force transducers and extensometers of class 1 are within 1 %
    (ISO 7500-1, ISO 9513), an energy is a product of both, and a worn volume is known within some 5 %.
    """

    force: Spread = Field(0.01, description="relative difference of forces that is none in practice")
    displacement: Spread = Field(0.01, description="the same of displacements, of the displacement amplitude")
    energy: Spread = Field(0.02, description="the same of dissipated energies")
    volume: Spread = Field(0.05, description="the same of worn volumes, depths and sizes of scars")


class Frames(keys.Table):
    """Direction of x in each scar's map, whose origin is the point of first contact."""

    scar_moving: Frame = Field("test", description='"test", x along the motion, or "wire", x along the body\'s axis')
    scar_fixed: Frame = Field("test", description="the same of the fixed wire")
    scar_flat: Frame = Field("test", description="of the flat")
    scar_ball: Frame = Field("test", description="of the ball")
    scar_lower: Frame = Field("test", description="of the lower body")
    scar_upper: Frame = Field("test", description="of the upper body")


class Files(keys.Table):
    """Names of the data files beside experiment.toml."""

    loops: FileName = Field(description="file of the loops", examples=["loops.csv"])
    evolution: FileName | None = Field(None, description="file of the evolution over the cycles")
    scar_moving: FileName | None = Field(None, description="file of the moving wire's scars")
    scar_fixed: FileName | None = Field(None, description="file of the fixed wire's scars")
    scar_flat: FileName | None = Field(None, description="file of the flat's scars")
    scar_ball: FileName | None = Field(None, description="file of the ball's scars")
    scar_lower: FileName | None = Field(None, description="file of the lower body's scars")
    scar_upper: FileName | None = Field(None, description="file of the upper body's scars")
    frames: Frames = Field(Frames(), description="what x of the scars runs along")


def known_of(table: type[keys.Table], values: Mapping[str, object]) -> dict[str, object]:
    """The entries of `values` whose keys the table has and whose values are not None."""
    return {key: values[key] for key in table.model_fields if values.get(key) is not None}


#: Names of the bodies of all kinds of contact at a point.
ALL_BODIES = frozenset(key.removeprefix(f"{SCARS.name}_") for key in Frames.model_fields)


def curved(bodies: Mapping[str, Mapping[str, object]]) -> dict[str, float]:
    """Diameters and angles of bodies by key and body, such as "diameter_mm of the ball"; unstated ones are left out."""
    keys = ("diameter_mm", "diameter_along_mm", "axis_angle_deg")
    return {
        f"{key} of the {called(name)}": value
        for name, own in bodies.items()
        for key in keys
        if isinstance(value := own.get(key), int | float)
    }


def each_wire(wires: Mapping[str, object]) -> dict[str, dict[str, object]]:
    """Complete table of each wire by its name; keys that it lacks come from the table of both."""
    return {name: {**wires, **table_of(wires, name)} for name in WIRES}


class PointTest(OfTest):
    """Test of a contact at a point as stated in a file."""

    worn, needs_loops = SCARS, True

    @property
    @abstractmethod
    def bodies_of_test(self) -> tuple[Body, Body]:
        """The driven body, which lies below, and the held one."""

    def body(self, name: str) -> Body:
        return self.bodies_of_test[self.body_names.index(name)]

    @abstractmethod
    def contradiction(self) -> Inconsistency | None:
        """Key of the bodies that does not fit the others, with the reason; None if all fit."""

    def require_whole(self, where: str) -> None:
        if (wrong := self.contradiction()) is not None:
            raise RecordError(f"{wrong.keys[-1]} in [{'.'.join(wrong.keys[:-1])}] of {where} {wrong.problem}.")
        if any(body.surface is not None for body in self.bodies_of_test):
            raise RecordError(f"{where} is of a measured surface, of whose tests no records are read yet.")

    def require_bodies(self, where: str, *given: keys.Table) -> None:
        """Raise RecordError if one of the tables `given`, which have a key for each possible body, states a body that
        this kind of contact does not have.
        """
        for key in (key for table in given for key in table.model_fields_set):
            name = key.removeprefix(f"{SCARS.name}_")
            if name in ALL_BODIES and name not in self.body_names:
                raise RecordError(
                    f"{where}: {key} is given, but a {self.contact_kind} has a {' and a '.join(self.body_names)}."
                )


class OfWires(keys.Table):
    """Kind of contact, where it is stated."""

    kind: Annotated[str, PlainValidator(keys.one_of(kinds.CROSSED_WIRES))] = Field(description="kind of contact")


class WiresTest(PointTest):
    """Test of crossed wires as stated in a file."""

    of = Wires

    contact: OfWires | None = Field(None, description="what touches, where that is said")
    wires: BothWires

    @property
    def bodies_of_test(self) -> tuple[Body, Body]:
        """The moving and the fixed wire."""
        return self.wires.of_test()

    def contradiction(self) -> Inconsistency | None:
        return self.wires.contradiction()


class PointRecordTables(OfRecord, PointTest):
    """Tables of the experiment.toml of any contact at a point, besides those of its bodies."""

    conditions: RecordConditions = Field(description="load, stroke, frequency and length of the test")
    stated: Stated = Field(Stated(), description="what the rig's owner states")
    noise: Noise = Field(Noise(), description="noise of one sample")
    scatter: StatedScatter = Field(StatedScatter(), description="scatter between tests on fresh specimens")
    tolerance: Tolerance = Field(Tolerance(), description="differences that count as none")
    metadata: Metadata = Field(Metadata(), description="surroundings, surfaces and origin of the test")
    files: Files = Field(description="names of the data files")

    def require_whole(self, where: str) -> None:
        super().require_whole(where)
        self.require_bodies(f"[files] of {where}", self.files, self.files.frames)

    @property
    def wear(self) -> dict[str, tuple[str, ...]]:
        return {"energy_wear_coefficient_mm3_per_J": self.body_names}

    @property
    def shares(self) -> dict[str, float]:
        return dict(zip(self.body_names, (self.stated.moving_share, 1.0 - self.stated.moving_share), strict=True))

    @property
    def of_study(self) -> dict[str, float | None]:
        asked = self.conditions
        return {"normal_load_N": asked.normal_load_N, "displacement_amplitude_um": asked.displacement_amplitude_um}

    @property
    def contact_stiffness_N_per_um(self) -> float:
        """Tangential stiffness in N/µm of the unworn contact under the asked load, as `unworn_stiffness_N_per_um`."""
        return unworn_stiffness_N_per_um(self.conditions.normal_load_N, *self.bodies_of_test)

    def placed(self, surface: MeasuredScar) -> MeasuredScar:
        of_body = getattr(self.files.frames, f"{SCARS.name}_{surface.body}") == "wire"
        return surface.turned(self.body(surface.body).axis_angle_deg if of_body else 0.0)

    @property
    def missing(self) -> tuple[str, ...]:
        needs = {
            "friction": self.stated.final_friction,
            "energy_wear_coefficient_mm3_per_J": self.stated.energy_wear_coefficient_mm3_per_J,
        }
        return tuple(key for key, value in needs.items() if value is None)


class RecordTables(PointRecordTables, WiresTest):
    """All tables of the experiment.toml of crossed wires."""

    @classmethod
    def bodies_of(cls, study: Mapping[str, object], label: str) -> dict[str, object]:
        del label
        angle = table_of(study, "conditions").get("motion_angle_deg") or 0.0
        own = {"motion_angle_deg": angle, **table_of(study, "wires")}
        left = {key: Wires.model_fields[key].default for key in GRIPS} | {wire: {} for wire in WIRES}
        return {"wires": {key: value for key, value in own.items() if key not in left or value != left[key]}}

    @property
    def of_study(self) -> dict[str, float | None]:
        own, wires = self.wires, self.wires.model_dump(exclude_none=True)
        angles = {"crossing_angle_deg": own.crossing_angle_deg, "motion_angle_deg": own.motion_angle_deg or 0.0}
        return {**super().of_study, **curved(each_wire(wires)), **angles}

    def with_bodies(self, data: dict[str, object]) -> dict[str, object]:
        wires = self.wires.model_dump(mode="json", exclude_none=True)
        angle = {"motion_angle_deg": wires.pop("motion_angle_deg", 0.0)}
        return data | {
            "wires": wires,
            "conditions": {**table_of(data, "conditions"), **(angle if any(angle.values()) else {})},
        }

    @property
    def assumed(self) -> str:
        """Assumption on how the wires are held, as the end of a sentence; "" if that is stated."""
        given = {*self.wires.model_fields_set, *self.wires.moving.model_fields_set, *self.wires.fixed.model_fields_set}
        return "" if "grip_angle_deg" in given else "; wires are held rigidly over 90° of their backs, all along"
