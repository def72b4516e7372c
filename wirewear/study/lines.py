"""Tables of a line contact's study: a pad on a flat in plane strain, all per mm of thickness."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, PlainValidator

from geometry import Elastic, PlanarGeometry
from solvers import Coulomb, Drive, EnergyLaw, Holder, Waveform, WearLaw, WearRates
from wirewear.base.errors import Quantity
from wirewear.effects import Effect, Seam
from wirewear.study import keys
from wirewear.study.drive import BULK, LOAD_CYCLE, MOTION, BulkTable, LoadCycleKey, MotionKey, bulk_of, drive_of
from wirewear.study.faces import PadFaceOrFile
from wirewear.study.keys import Inconsistency
from wirewear.study.surfaces import LAYERS, LayerTable, StatedSurface, layers_of
from wirewear.study.tables import PLANAR_KINDS, CommonTables, HeldByDrive, StatesItsKind, compliance
from wirewear.study.template import Template

CYLINDER_ON_FLAT = PLANAR_KINDS[1]  #: A line contact whose pad is a cylinder.

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


class LineConditions(HeldByDrive):
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


class LineFriction(keys.Table):
    """The friction law."""

    friction: keys.Friction = Field(description="coefficient of friction", examples=[0.9])
    friction_law: keys.FrictionLawKey = Field(
        Coulomb(), description='"coulomb", or a table of another law\'s name and parameters; friction is its start'
    )


class LineWear(keys.Table):
    """Wear of each body: by dissipated energy, or by Archard's law in load times sliding distance."""

    law: keys.WearLawKey | None = Field(
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


class LineHolder(keys.Table):
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


class LineMeshing(ResolutionTable):
    """Resolution in space and time, and the extent of the fine mesh."""

    scar_half_width_um: keys.ElementSize | None = Field(
        None, description="half-width of the finely meshed patch beyond the stroke; without it, predicted"
    )
    jump_tolerance: keys.Tolerance | None = Field(None, description="relative error allowed to one cycle jump")
    mesh_refinement: keys.Refinement = Field(1.0, description="elements are smaller than asked for by this factor")
    increments_refinement: keys.Refinement = Field(
        1.0, description="time steps are shorter than asked for by this factor"
    )


class _OfPadAndSpecimen(StatesItsKind):
    """What a study of a line contact states first."""

    pad: Pad = Field(description="the pad")
    specimen: Specimen = Field(description="the flat")


class LineTables(CommonTables, _OfPadAndSpecimen):
    """A whole study of a line contact without its variants."""

    load_key: ClassVar[str] = "normal_load_N_per_mm"

    kind: Annotated[Literal["line-contact", "cylinder-on-flat"], PlainValidator(keys.one_of(*PLANAR_KINDS))] = Field(
        description="kind of contact", examples=[PLANAR_KINDS[0]]
    )
    conditions: LineConditions = Field(description="load, stroke, motion and length of the test")
    contact: LineFriction = Field(description="friction")
    wear: LineWear = Field(LineWear(), description="wear of both bodies; without this table nothing wears")
    holder: LineHolder = Field(LineHolder(), description="stiffness of the rig")
    effects: keys.Effects = Field((), description="effects that the nominal model lacks, per mm of thickness")
    mesh: LineMeshing = Field(LineMeshing(), description="resolution")

    @property
    def contact_kind(self) -> str:
        """A cylinder on a flat is one of them."""
        return PLANAR_KINDS[0]

    @property
    def layers(self) -> dict[str, tuple[LayerTable, ...]]:
        """Layers of the specimen and of the pad."""
        return {"specimen": self.specimen.layers, "pad": self.pad.layers}

    @property
    def materials(self) -> dict[str, Elastic]:
        """Elastic constants of the specimen and of the pad."""
        return {"specimen": self.specimen.elastic, "pad": self.pad.elastic}

    @property
    def drive(self) -> Drive:
        """With the stresses that both bodies carry."""
        bodies = [(body.bulk, body.elastic) for body in (self.specimen, self.pad)]
        return replace(self.conditions.drive, bulk=bulk_of(bodies, plane_strain=True))

    @property
    def rig(self) -> Holder:
        rig = self.holder
        return Holder(
            self.conditions.normal_load_N_per_mm,
            tangential_compliance_mm_per_N=compliance(rig.tangential_stiffness_N_per_mm2),
            normal_stiffness_N_per_mm=rig.normal_spring_stiffness_N_per_mm2,
            rotational_compliance_rad_per_N_mm=compliance(rig.rotational_stiffness_N_per_rad),
            pivot_height_mm=rig.pivot_height_mm or 0.0,
        )

    @property
    def wear_rates(self) -> WearRates:
        rates = self.energy_coefficients()
        return WearRates(
            upper_mm3_per_mJ=1e-3 * rates[0],
            lower_mm3_per_mJ=1e-3 * rates[1],
            law=self.wear.of_law,
            upper_layers=layers_of(self.pad.layers, self.contact.friction),
            lower_layers=layers_of(self.specimen.layers, self.contact.friction),
        )

    @property
    def worn_by_sliding(self) -> float:
        """Of both bodies together."""
        return sum(self.energy_coefficients()) * self.contact.friction

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

    def contradiction(self) -> Inconsistency | None:
        """A pad without a face, a holder that tips over, or two laws of wear."""
        return self._of_bodies() or self._of_holder() or self._of_wear()

    def _of_bodies(self) -> Inconsistency | None:
        if (wanted := self.pad.missing_face(round_alone=self.kind == CYLINDER_ON_FLAT)) is not None:
            return Inconsistency(("pad",), f"does not say which face it has: {wanted}")
        for name in ("pad", "specimen"):
            if (bulk := getattr(self, name).bulk) is not None and (told := bulk.unfit(is_round=False)):
                return Inconsistency((name, "bulk"), told)
        if any(effect.seam is Seam.SPECIMENS for effect in self.effects):
            return Inconsistency(
                ("effects",), "hold one that changes how crossed wires are mounted, which a pad is not"
            )
        return None

    def _of_holder(self) -> Inconsistency | None:
        holder, key = self.holder, ("holder", "rotational_stiffness_N_per_rad")
        if holder.rotational_stiffness_N_per_rad == "rigid":
            return None
        if holder.pivot_height_mm is None:
            return Inconsistency(key, keys.NO_PIVOT)
        leaning = self.conditions.normal_load_N_per_mm * holder.pivot_height_mm
        if holder.rotational_stiffness_N_per_rad > leaning:
            return None
        return Inconsistency(
            key,
            f"is {holder.rotational_stiffness_N_per_rad:g}, but below {leaning:g}, load times pivot height, the pad "
            "tips over: give a stiffer spring or a lower pivot",
        )

    def _of_wear(self) -> Inconsistency | None:
        wear, law, friction = self.wear, self.wear.of_law, self.contact
        for body in ("pad", "specimen"):
            energy, archard = (f"{body}_energy_mm3_per_J", f"{body}_archard_mm3_per_N_m")
            if getattr(wear, energy) > 0.0 and getattr(wear, archard) > 0.0:
                return Inconsistency(
                    ("wear", energy), f"and {archard} are both given, but a body wears by one law: give one of the two"
                )
        by_archard = max(wear.pad_archard_mm3_per_N_m, wear.specimen_archard_mm3_per_N_m) > 0.0
        if by_archard and not isinstance(friction.friction_law, Coulomb):
            return Inconsistency(
                ("contact", "friction_law"),
                f"is {friction.friction_law.name!r}, but line contacts compute Archard wear from Coulomb's friction "
                "energy: give energy wear coefficients instead",
            )
        if law.coefficient == "archard" or (by_archard and not isinstance(law, EnergyLaw)):
            return Inconsistency(
                ("wear", "law"),
                f"is {law.name!r}, but line contacts take Archard's law by pad_archard_mm3_per_N_m and "
                "specimen_archard_mm3_per_N_m, and all others by energy wear coefficients",
            )
        if by_archard and friction.friction == 0.0:
            return Inconsistency(
                ("contact", "friction"),
                "is 0, but Archard wear is computed from friction energy: give a small coefficient such as 0.01",
            )
        return None


#: A titanium cylinder on a titanium flat.
LINE_CONTACT = Template(
    PLANAR_KINDS[0],
    LineTables,
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
