"""Tables of a line contact's TOML file, read and checked: a pad on a flat in plane strain, all per mm of thickness."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, PlainValidator, PrivateAttr

from geometry import Elastic, PlanarGeometry
from solvers import Coulomb, Drive, EnergyLaw, FrictionLaw, Waveform, WearLaw
from wirewear.base.errors import Quantity, StudyError
from wirewear.effects import Effect, Seam
from wirewear.study import keys
from wirewear.study.bulk import BULK, BulkTable, bulk_of
from wirewear.study.consistency import log_within, merged
from wirewear.study.drive import LOAD_CYCLE, MOTION, LoadCycleKey, MotionKey, drive_of
from wirewear.study.faces import PadFaceOrFile
from wirewear.study.layers import LAYERS, LayerTable, unfit_layers
from wirewear.study.life import LifeTable
from wirewear.study.messages import validated
from wirewear.study.programme import CycleBlock, Schedule, as_driven, held_keys, placed, too_many, worked_cycles
from wirewear.study.reading import variants_in
from wirewear.study.surfaces import StatedSurface
from wirewear.study.tables import FrictionLawKey, HeldByDrive, Log, Stop, WearLawKey
from wirewear.study.template import Template

#: What the kind may be called: any line contact, or that of a cylinder.
CYLINDER_ON_FLAT = "cylinder-on-flat"
KINDS = ("line-contact", CYLINDER_ON_FLAT)

Extent = Annotated[float, PlainValidator(Quantity("mm", 0.05, 500.0))]
LineLoad = Annotated[float, PlainValidator(Quantity("N_per_mm", 1e-3, 1e5))]
LineStiffness = Annotated[float | Literal["rigid"], PlainValidator(Quantity("N_per_mm2", 1.0, 1e8, words=("rigid",)))]


RotationalLineStiffness = Annotated[
    float | Literal["rigid"], PlainValidator(Quantity("N_per_rad", 1.0, 1e12, words=("rigid",)))
]
LineSpringStiffness = Annotated[float, PlainValidator(Quantity("N_per_mm2", 0.0, 1e5))]

#: By which power of the contact's length a whole contact's number is larger than that of one millimetre, by its unit;
#: of all other units the numbers are the same.
_POWERS = {"N": 1, "N_per_mm": 1, "N_mm_per_rad": 1, "um_per_N": -1, "um_per_N2": -2}

TITANIUM = {"youngs_modulus_MPa": 116000.0, "poissons_ratio": 0.3}  #: An alloy like Ti-6Al-4V.


class MaterialTable(keys.OfMaterial):
    """An elastic material."""

    material: keys.MaterialName | None = Field(
        None, description="name of a material of the table, in place of its constants", examples=["Ti-6Al-4V"]
    )
    youngs_modulus_MPa: keys.YoungsModulus = Field(description="Young's modulus", examples=[116000.0])
    poissons_ratio: keys.PoissonsRatio = Field(description="Poisson's ratio", examples=[0.3])

    @property
    def elastic(self) -> Elastic:
        """As the solvers take it."""
        return Elastic(self.youngs_modulus_MPa, self.poissons_ratio)


class ResolutionTable(keys.Table):
    """Resolution in space and time; what is left out follows from --fidelity."""

    contact_mesh_um: keys.ElementSize | None = Field(None, description="element size under the contact")
    far_mesh_mm: Extent = Field(1.0, description="largest element far from the contact")
    increments_per_cycle: keys.IncrementsPerCycle | None = Field(None, description="time steps of one cycle")


class HeldTable(MaterialTable):
    """A body whose back is held."""

    grip_width_mm: Extent | None = Field(
        None, description="width of the back that is held, about its middle; all by default"
    )
    grip_stiffness_N_per_mm3: keys.GripStiffness = Field(
        "rigid", description='stiffness of the grip per area, a number or "rigid"'
    )
    surface: StatedSurface | None = Field(None, description="its surface as measured before the test")
    layers: tuple[LayerTable, ...] = Field((), description=LAYERS)
    bulk: BulkTable | None = Field(None, description=BULK)

    def held(self, geometry: PlanarGeometry) -> PlanarGeometry:
        """That body, held so."""
        stiffness, width = self.grip_stiffness_N_per_mm3, self.grip_width_mm
        return replace(
            geometry,
            grip_half_width_mm=None if width is None else 0.5 * width,
            grip_stiffness_N_per_mm3=None if isinstance(stiffness, str) else stiffness,
        )


class Pad(PadFaceOrFile, HeldTable):
    """The pad, held by the rig, above the specimen."""

    height_mm: Extent = Field(10.0, description="height of the pad between its contact and its holder")
    half_width_mm: Extent | None = Field(
        None, description="half of the pad's width; without it 10 or 0.8 radii, or as far as its profile goes"
    )


class Specimen(HeldTable):
    """The flat, moved by the drive, below the pad."""

    height_mm: Extent = Field(10.0, description="height of the specimen between its contact and its moved back")
    half_width_mm: Extent | None = Field(
        None, description="half of the specimen's width; without it 10 or what it needs"
    )


class PlanarConditions(HeldByDrive):
    """What is asked of the rig."""

    normal_load_N_per_mm: LineLoad = Field(description="normal load per length of the contact", examples=[390.0])
    displacement_amplitude_um: keys.Amplitude = Field(
        description="imposed displacement amplitude, half the stroke", examples=[35.0]
    )
    held_tangential_force_N_per_mm: LineLoad | None = Field(
        None, description="the drive holds this largest tangential force of a cycle, per length of the contact"
    )
    held_energy_mJ_per_mm: keys.HeldEnergy | None = Field(
        None, description="the drive holds this energy of a cycle, per length of the contact"
    )
    cycles: keys.Cycles = Field(description="length of the test", examples=[10000])
    motion: MotionKey = Field(Waveform(), description=MOTION, examples=["sinusoidal"])
    load_cycle: LoadCycleKey | None = Field(None, description=LOAD_CYCLE)
    frequency_Hz: keys.Frequency = Field(1.0, description="cycles per second")

    @property
    def drive(self) -> Drive:
        return drive_of(self.displacement_amplitude_um, self.motion, self.load_cycle)


class PlanarContact(keys.Table):
    """The friction law."""

    friction: keys.Friction = Field(description="coefficient of friction", examples=[0.9])
    friction_law: FrictionLawKey = Field(
        Coulomb(), description='"coulomb", or a table of another law\'s name and parameters; friction is its start'
    )


class PlanarWear(keys.Table):
    """Wear of each body: by dissipated energy, or by Archard's law in load times sliding distance."""

    law: WearLawKey | None = Field(
        None, description='"energy", or a table of another law\'s name and parameters, for energy coefficients'
    )

    pad_energy_mm3_per_J: keys.WearCoefficient = Field(0.0, description="energy wear coefficient of the pad")
    specimen_energy_mm3_per_J: keys.WearCoefficient = Field(0.0, description="energy wear coefficient of the specimen")
    pad_archard_mm3_per_N_m: keys.ArchardCoefficient = Field(0.0, description="Archard wear coefficient of the pad")
    specimen_archard_mm3_per_N_m: keys.ArchardCoefficient = Field(
        0.0, description="Archard wear coefficient of the specimen"
    )

    @property
    def coefficients(self) -> dict[str, float]:
        """All four by their keys."""
        return {name: value for name, value in self if isinstance(value, float)}

    @property
    def of_law(self) -> WearLaw:
        """The law of the energy coefficients."""
        return self.law or EnergyLaw()


class PlanarHolder(keys.Table):
    """The rig: springs between the pad's holder and ground, and that of the loading train."""

    tangential_stiffness_N_per_mm2: LineStiffness = Field(
        "rigid", description='stiffness of the rig along the motion per length of the contact, a number or "rigid"'
    )
    rotational_stiffness_N_per_rad: RotationalLineStiffness = Field(
        "rigid", description='stiffness against rotation about a pivot above the contact, a number or "rigid"'
    )
    pivot_height_mm: keys.PivotHeight | None = Field(None, description="height of that pivot above the contact")
    normal_spring_stiffness_N_per_mm2: LineSpringStiffness = Field(
        0.0, description="stiffness of the loading spring per length of the contact; 0 is a dead weight"
    )


class PlanarMeshing(ResolutionTable):
    """Resolution in space and time, and the extent of the fine mesh."""

    scar_half_width_um: keys.ElementSize | None = Field(
        None, description="half-width of the finely meshed patch beyond the stroke; without it, predicted"
    )
    jump_tolerance: keys.Tolerance | None = Field(None, description="relative error allowed to one cycle jump")
    mesh_refinement: keys.Refinement = Field(1.0, description="elements are smaller than asked for by this factor")
    increments_refinement: keys.Refinement = Field(
        1.0, description="time steps are shorter than asked for by this factor"
    )


class PlanarStudy(keys.NamedTable):
    """A study of a line contact as a value."""

    contact_kind: ClassVar[str] = "line-contact"

    kind: Annotated[Literal["line-contact", "cylinder-on-flat"], PlainValidator(keys.one_of(*KINDS))] = Field(
        description="kind of contact", examples=[KINDS[0]]
    )
    pad: Pad = Field(description="the pad")
    specimen: Specimen = Field(description="the flat")
    conditions: PlanarConditions = Field(description="load, stroke, motion and length of the test")
    programme: tuple[CycleBlock, ...] = Field((), description="blocks of cycles, repeated in turn up to the test's end")
    contact: PlanarContact = Field(description="friction")
    wear: PlanarWear = Field(PlanarWear(), description="wear of both bodies; without this table nothing wears")
    holder: PlanarHolder = Field(PlanarHolder(), description="stiffness of the rig")
    stop: Stop | None = Field(None, description="what ends the test before its last cycle")
    effects: keys.Effects = Field((), description="effects that the nominal model lacks, per mm of thickness")
    log: Log = Field(Log(), description="which cycles are recorded")
    life: LifeTable | None = Field(
        None, description="criterion and data by which cycles are counted until a crack begins"
    )
    mesh: PlanarMeshing = Field(PlanarMeshing(), description="resolution")

    _variants: tuple[tuple[str, "PlanarStudy"], ...] = PrivateAttr(())
    _variant_name: str = PrivateAttr("")

    @property
    def variant_name(self) -> str:
        return self._variant_name

    @property
    def variant_names(self) -> tuple[str, ...]:
        return tuple(name for name, _ in self._variants)

    def variant(self, name: str) -> "PlanarStudy":
        """The study that a variant is: complete, and without variants of its own.
        Raises StudyError if there is no such variant.
        """
        for own, study in self._variants:
            if own == name:
                return study
        known = f"its variants are {', '.join(self.variant_names)}" if self._variants else "it has no variants"
        raise StudyError(f"the study {self.name!r} has no variant {name!r}: {known}.")

    def with_variants(self, variants: tuple[tuple[str, "PlanarStudy"], ...]) -> "PlanarStudy":
        """The study with these variants."""
        return self._with("", variants)

    def named(self, variant: str) -> "PlanarStudy":
        """The study as the variant of that name."""
        return self._with(variant, ())

    @property
    def driven(self) -> "PlanarStudy":
        """The study as its drive moves the bodies, which effects may change."""
        conditions, blocks = as_driven(self.conditions, self.programme, self.effects)
        return self.model_copy(update={"conditions": conditions, "programme": blocks})

    @property
    def schedule(self) -> Schedule["PlanarStudy"]:
        alone = self.model_copy(update={"programme": ()})
        return Schedule(self.programme, self.conditions.cycles, alone, partial(_under, alone))

    @property
    def worn_per_cycle(self) -> float:
        """What a cycle wears in gross slip on a rigid rig, 10⁻⁶ mm² for either stroke of one amplitude."""
        load, stroke = self.conditions.normal_load_N_per_mm, self.conditions.displacement_amplitude_um
        return sum(self.energy_coefficients()) * self.contact.friction * load * stroke

    @property
    def envelope(self) -> "PlanarStudy":
        """A study of one block, as large in load, stroke, friction and wear as all blocks together: for meshes."""
        if not self.programme:
            return self
        stretches = self.schedule.stretches
        worst = max((own.study for own in stretches), key=lambda study: study.worn_per_cycle)
        largest = {
            "normal_load_N_per_mm": max(own.study.conditions.normal_load_N_per_mm for own in stretches),
            "displacement_amplitude_um": max(own.study.conditions.displacement_amplitude_um for own in stretches),
        }
        friction = max(own.study.contact.friction for own in stretches)
        contact = worst.contact.model_copy(update={"friction": friction})
        whole = worst.model_copy(update={"contact": contact, "conditions": worst.conditions.model_copy(update=largest)})
        cycles = worked_cycles(stretches, whole.worn_per_cycle)
        return whole.model_copy(update={"conditions": whole.conditions.model_copy(update={"cycles": cycles})})

    @property
    def laws(self) -> tuple[FrictionLaw, WearLaw]:
        """Those of friction and of wear."""
        return self.contact.friction_law, self.wear.of_law

    @property
    def layers(self) -> dict[str, tuple[LayerTable, ...]]:
        """Coatings and hard skins on both bodies, by their names."""
        return {"specimen": self.specimen.layers, "pad": self.pad.layers}

    @property
    def drive(self) -> Drive:
        """Displacement, load and bulk stresses in the course of a cycle."""
        bodies = [(body.bulk, body.elastic) for body in (self.specimen, self.pad)]
        return replace(self.conditions.drive, bulk=bulk_of(bodies, plane_strain=True))

    def given(self) -> dict[str, Any]:
        """What its file gives, as nested tables."""
        return self.model_dump(mode="json", exclude_none=True, exclude_unset=True)

    def logging(self, cycles: tuple[int, ...]) -> "PlanarStudy":
        """The study, and each of its variants, with the loops of these cycles logged."""
        own = self.model_copy(update={"log": self.log.of_cycles(cycles)})
        return own._with(  # noqa: SLF001 - its own copy
            self._variant_name, tuple((name, study.logging(cycles)) for name, study in self._variants)
        )

    def unused_values(self) -> Iterator[tuple[str, str, object]]:
        """Table, key and value of what the file gives for all variants while each of them has another value."""
        return keys.values_in_no_variant(self, [study for _, study in self._variants])

    def _with(self, name: str, variants: tuple[tuple[str, "PlanarStudy"], ...]) -> "PlanarStudy":
        copy = self.model_copy()
        copy._variant_name, copy._variants = name, variants  # noqa: SLF001 - its own copy
        return copy

    def energy_coefficients(self) -> tuple[float, float]:
        """Wear of pad and specimen per dissipated energy, in mm³/J.

        Archard's law h = k p s is the energy law h = α µ p s with α = k/µ wherever Coulomb friction slides.
        """
        wear, friction = self.wear, self.contact.friction

        def combined(energy: float, archard: float) -> float:
            return energy + (archard / friction if archard > 0.0 else 0.0)

        return (
            combined(wear.pad_energy_mm3_per_J, wear.pad_archard_mm3_per_N_m),
            combined(wear.specimen_energy_mm3_per_J, wear.specimen_archard_mm3_per_N_m),
        )


#: A titanium cylinder on a titanium flat.
LINE_CONTACT = Template(
    KINDS[0],
    PlanarStudy,
    ("pad", "specimen", "conditions", "contact", "wear", "holder", "log"),
    {
        "pad": {"radius_mm": 40.0, **TITANIUM},
        "specimen": TITANIUM,
        "conditions": {
            "normal_load_N_per_mm": 390.0,
            "displacement_amplitude_um": 35.0,
            "cycles": 10000,
            "frequency_Hz": 5.0,
        },
        "contact": {"friction": 0.9},
        "wear": {"pad_energy_mm3_per_J": 2.0e-5, "specimen_energy_mm3_per_J": 4.0e-5},
        "holder": {"tangential_stiffness_N_per_mm2": "rigid"},
    },
    "A cylinder on a flat, to be changed into your line contact; everything is per mm of its length.",
)


def per_mm(effects: Iterable[Effect[Any]], length_mm: float) -> tuple[Effect[Any], ...]:
    """Effects of a whole contact as a study of one millimetre of it takes them."""
    return tuple(_scaled(effect, length_mm, -1) for effect in effects)


def of_whole_contact(effects: Iterable[Effect[Any]], length_mm: float) -> tuple[Effect[Any], ...]:
    """Effects of a study per mm as those of the whole contact."""
    return tuple(_scaled(effect, length_mm, 1) for effect in effects)


def _scaled(effect: Effect[Any], length_mm: float, sign: int) -> Effect[Any]:
    known = effect.parameters().items()
    powers = {name: sign * _POWERS.get(described.quantity.unit, 0) for name, described in known}
    return replace(
        effect, **{name: getattr(effect, name) * length_mm**power for name, power in powers.items() if power}
    )


def planar_study_from_tables(data: Mapping[str, Any], where: str) -> PlanarStudy:
    """Build a planar study from nested tables; `where` names their origin in messages.
    Raises StudyError, in one sentence, if the tables are no valid study.
    """
    base = {key: value for key, value in data.items() if key != "variants"}
    study = _checked(base, where)
    return study.with_variants(
        tuple(
            (name, _checked(merged(base, overrides), f"the variant {name!r} of {where}").named(name))
            for name, overrides in variants_in(data, where)
        )
    )


def _under(alone: PlanarStudy, values: Mapping[str, Any]) -> PlanarStudy:
    """A study without a programme under the conditions of a block."""
    tables = alone.model_dump(mode="json", exclude_none=True)
    tables = merged(tables, placed(values, tables))
    return _checked(tables, f"the study {alone.name!r}").named(alone.variant_name)


def _checked(tables: Mapping[str, Any], where: str) -> PlanarStudy:
    study = validated(PlanarStudy, tables, where, StudyError)
    _require_consistent(study, where)
    if (told := too_many(study.programme, study.conditions.cycles)) is not None:
        raise StudyError(f"programme in {where} {told}.")
    for number, block in enumerate(study.programme, 1):
        alone = {key: value for key, value in tables.items() if key != "programme"}
        _checked(merged(alone, placed(block.values, alone)), f"block {number} of the programme in {where}")
    return study.model_copy(update={"log": log_within(study.log, study.conditions.cycles, study.programme)})


def _require_bodies(study: PlanarStudy, where: str) -> None:
    if (wanted := study.pad.missing_face(round_alone=study.kind == CYLINDER_ON_FLAT)) is not None:
        raise StudyError(f"[pad] in {where} does not say which face the pad has: {wanted}.")
    for name in ("pad", "specimen"):
        if (bulk := getattr(study, name).bulk) is not None and (told := bulk.unfit(is_round=False)):
            raise StudyError(f"bulk in [{name}] of {where} {told}.")


def _require_holder(study: PlanarStudy, where: str) -> None:
    holder = study.holder
    if holder.rotational_stiffness_N_per_rad == "rigid":
        return
    if holder.pivot_height_mm is None:
        raise StudyError(
            f"rotational_stiffness_N_per_rad in [holder] of {where} says that the holder rotates, but pivot_height_mm, "
            "the height of its pivot above the contact, is missing."
        )
    leaning = study.conditions.normal_load_N_per_mm * holder.pivot_height_mm
    if holder.rotational_stiffness_N_per_rad <= leaning:
        raise StudyError(
            f"rotational_stiffness_N_per_rad in [holder] of {where} is {holder.rotational_stiffness_N_per_rad:g}, but "
            f"below {leaning:g}, load times pivot height, the pad tips over: give a stiffer spring or a lower pivot."
        )


def _require_consistent(study: PlanarStudy, where: str) -> None:
    if len(held := held_keys(study.conditions)) > 1:
        raise StudyError(f"{' and '.join(held)} in [conditions] of {where} are given, but a drive holds one of them.")
    _require_bodies(study, where)
    _require_holder(study, where)
    wear = study.wear
    for body in ("pad", "specimen"):
        energy, archard = getattr(wear, f"{body}_energy_mm3_per_J"), getattr(wear, f"{body}_archard_mm3_per_N_m")
        if energy > 0.0 and archard > 0.0:
            raise StudyError(
                f"{body}_energy_mm3_per_J and {body}_archard_mm3_per_N_m in [wear] of {where} are both given, but a "
                "body wears by one law: give one of the two."
            )
    archard = max(wear.pad_archard_mm3_per_N_m, wear.specimen_archard_mm3_per_N_m)
    if archard > 0.0 and not isinstance(study.contact.friction_law, Coulomb):
        raise StudyError(
            f"friction_law in [contact] of {where} is {study.contact.friction_law.name!r}, but line contacts compute "
            "Archard wear from Coulomb's friction energy: give energy wear coefficients instead."
        )
    if told := unfit_layers((*study.pad.layers, *study.specimen.layers), study.contact.friction):
        raise StudyError(f"layers in {where} {told}.")
    law = wear.of_law
    if law.coefficient == "archard" or (archard > 0.0 and not isinstance(law, EnergyLaw)):
        raise StudyError(
            f"law in [wear] of {where} is {law.name!r}, but line contacts take Archard's law by "
            "pad_archard_mm3_per_N_m and specimen_archard_mm3_per_N_m, and all others by energy wear coefficients."
        )
    if study.contact.friction == 0.0 and archard > 0.0:
        raise StudyError(
            f"friction in [contact] of {where} is 0, but Archard wear is computed from friction energy: give a small "
            "coefficient such as 0.01."
        )
    for effect in study.effects:
        if effect.seam is Seam.SPECIMENS:
            raise StudyError(
                f"effects in {where} hold {effect.name}, which changes the {effect.seam} of crossed wires: line "
                "contacts take effects of holder, contact, wear, loading and sensor."
            )
