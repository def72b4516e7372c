"""Tables of a line contact's study: a pad held on a flat specimen that is driven, in plane strain, of a stated length
across the motion. Numbers are those of the whole length.
"""

from collections.abc import Mapping
from dataclasses import replace
from math import pi
from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, PlainValidator

from geometry import Elastic, RoundedFlat
from solvers import Coulomb, Drive, EnergyLaw, Holder, WearLaw, WearRates
from wirewear.base import kinds
from wirewear.base.errors import RecordError, StudyError
from wirewear.base.units import Quantity
from wirewear.effects import Seam
from wirewear.test import keys
from wirewear.test.bodies import BodiesByOptions, StatedBodies, yield_of
from wirewear.test.conditions import DrivenConditions, FrictionTable
from wirewear.test.drive import bulk_of
from wirewear.test.faces import FACE_KEYS, PadFace
from wirewear.test.keys import Inconsistency
from wirewear.test.lengths import given_length_mm, key_of_whole, study_of_length, whole_test
from wirewear.test.line_bodies import Extent, Pad, Specimen
from wirewear.test.surfaces import LayerTable, layers_of
from wirewear.test.tables import CommonTables, StatesItsKind
from wirewear.test.template import Template

LineLoad = Annotated[float, PlainValidator(Quantity("N", 1e-3, 1e6))]

TITANIUM = {"youngs_modulus_MPa": 116000.0, "poissons_ratio": 0.3}  #: An alloy like Ti-6Al-4V.


class ResolutionTable(keys.Table):
    """Keys of the resolution of a line contact in space and time; None follows from the level of fidelity."""

    contact_mesh_um: keys.ElementSize | None = Field(None, description="element size under the contact")
    far_mesh_mm: Extent = Field(1.0, description="largest element far from the contact")
    increments_per_cycle: keys.IncrementsPerCycle | None = Field(None, description="time steps of one cycle")


class LineConditions(DrivenConditions):
    """Keys of load, stroke, frequency and length of a line contact's test."""

    normal_load_N: LineLoad = Field(description="normal load between the bodies", examples=[2.0])
    frequency_Hz: keys.Frequency = Field(1.0, description="cycles per second")


class LineContactTable(FrictionTable):
    """Keys of a line contact's friction and length."""

    length_mm: Extent = Field(1.0, description="length of the contact across the motion", examples=[10.0])


class WearOfBodies(keys.Table):
    """Keys of the wear coefficients of pad and specimen: worn volume per dissipated energy or, by Archard's law, per
    load and sliding distance.
    """

    WEAR: ClassVar[tuple[str, ...]] = tuple(
        f"{body}_{law}"
        for law in ("energy_wear_coefficient_mm3_per_J", "archard_wear_coefficient_mm3_per_N_m")
        for body in ("pad", "specimen")
    )

    pad_energy_wear_coefficient_mm3_per_J: keys.WearCoefficient | None = Field(
        None, description="worn volume of the pad per dissipated energy"
    )
    specimen_energy_wear_coefficient_mm3_per_J: keys.WearCoefficient | None = Field(
        None, description="worn volume of the specimen per dissipated energy"
    )
    pad_archard_wear_coefficient_mm3_per_N_m: keys.ArchardCoefficient | None = Field(
        None, description="worn volume of the pad per load and sliding distance"
    )
    specimen_archard_wear_coefficient_mm3_per_N_m: keys.ArchardCoefficient | None = Field(
        None, description="worn volume of the specimen per load and sliding distance"
    )

    @property
    def coefficients(self) -> dict[str, float]:
        """The four coefficients by their keys, in the order of WEAR and in the keys' units; 0 where not stated."""
        return {key: getattr(self, key) or 0.0 for key in self.WEAR}


class LineWear(WearOfBodies):
    """Keys of the wear coefficients of pad and specimen, and of the wear law."""

    law: keys.WearLawKey | None = Field(
        None, description='"energy", or a table of another law\'s name and parameters, for energy coefficients'
    )

    @property
    def of_law(self) -> WearLaw:
        return self.law or EnergyLaw()


class LineMeshing(ResolutionTable):
    """Keys of a line contact's resolution in space and time, and of the extent of its fine mesh."""

    scar_half_width_um: keys.ElementSize | None = Field(
        None, description="half-width of the finely meshed patch beyond the stroke; without it, predicted"
    )
    jump_tolerance: keys.Tolerance | None = Field(None, description="relative error allowed to one cycle jump")
    mesh_refinement: keys.Refinement = Field(1.0, description="elements are smaller than asked for by this factor")
    increments_refinement: keys.Refinement = Field(
        1.0, description="time steps are shorter than asked for by this factor"
    )


class PadAndSpecimen(StatedBodies):
    """Keys of a pad and, below it, a flat that is driven."""

    pad: Pad = Field(description="the pad")
    specimen: Specimen = Field(description="the flat")

    @classmethod
    def by_options(
        cls, known: Mapping[str, object], elastic: Mapping[str, object], of_other: Mapping[str, object]
    ) -> BodiesByOptions:
        length = known.get("length_mm")
        if not isinstance(length, int | float):
            raise RecordError("no file states the length of the line contact: give it by --length, in millimetres.")
        face = {key: known[key] for key in FACE_KEYS if known.get(key) is not None}
        if PadFace.model_validate(face).missing_face() is not None:
            raise RecordError(
                "no file states the pad's face: give --radius, or --face-half-width and --edge-radius, in millimetres."
            )
        kind = kinds.CYLINDER_ON_FLAT if face.keys() == {"radius_mm"} else kinds.LINE_CONTACT
        tables = {
            "contact": {"kind": kind, "length_mm": length},
            "pad": face | dict(of_other),
            "specimen": dict(elastic),
        }
        return BodiesByOptions(tables, length_mm=length, needs_loops=False)


class LineTables(CommonTables, PadAndSpecimen, StatesItsKind):
    """The tables of a study of a line contact, without its variants."""

    kind: Annotated[
        Literal["line-contact", "cylinder-on-flat"], PlainValidator(keys.one_of(*kinds.NAMES[kinds.LINE_CONTACT]))
    ] = Field(description="kind of contact", examples=[kinds.LINE_CONTACT])
    conditions: LineConditions = Field(description="load, stroke, motion and length of the test")
    contact: LineContactTable = Field(description="friction and length")
    wear: LineWear = Field(LineWear(), description="wear of both bodies; without this table nothing wears")
    mesh: LineMeshing = Field(LineMeshing(), description="resolution")

    @property
    def contact_kind(self) -> str:
        return kinds.LINE_CONTACT

    @classmethod
    def known(
        cls, data: Mapping[str, object], where: str, variant: Mapping[str, object] | None = None
    ) -> dict[str, object]:
        length_mm = given_length_mm(variant or {}) or given_length_mm(data)
        base, own = (whole_test(tables, where, StudyError, length_mm) for tables in (data, variant or {}))
        return keys.merged(base, own)

    def known_as(self, key: str, value: object) -> tuple[str, object]:
        return key_of_whole(key, value, self.contact.length_mm)

    @property
    def layers(self) -> dict[str, tuple[LayerTable, ...]]:
        return {"specimen": self.specimen.layers, "pad": self.pad.layers}

    @property
    def materials(self) -> dict[str, Elastic]:
        return {"specimen": self.specimen.elastic, "pad": self.pad.elastic}

    @property
    def yields(self) -> dict[str, tuple[float, float] | None]:
        return {"specimen": yield_of(self.specimen), "pad": yield_of(self.pad)}

    @property
    def drive(self) -> Drive:
        bodies = [(body.bulk, body.elastic) for body in (self.specimen, self.pad)]
        return replace(self.conditions.drive, bulk=bulk_of(bodies, plane_strain=True))

    @property
    def rig(self) -> Holder:
        overlap_um = self.specimen.interference_um
        return replace(super().rig, approach_mm=None if overlap_um is None else 1e-3 * overlap_um)

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
        return sum(self.energy_coefficients()) * self.contact.friction

    def energy_coefficients(self) -> tuple[float, float]:
        """(pad, specimen): worn volume per dissipated energy in mm³/J, 0 where nothing wears.

        Archard's law h = k p s is the energy law h = α µ p s with α = k/µ wherever Coulomb friction slides.
        """
        wear, friction = self.wear, self.contact.friction

        def combined(energy: float, archard: float) -> float:
            return energy + (archard / friction if archard > 0.0 else 0.0)

        pad_energy, specimen_energy, pad_archard, specimen_archard = wear.coefficients.values()
        return combined(pad_energy, pad_archard), combined(specimen_energy, specimen_archard)

    def of_length(self, length_mm: float) -> Self:
        """A copy for a contact of length_mm, with equal load, force and energy per millimetre."""
        return study_of_length(self, length_mm)

    def contradiction(self) -> Inconsistency | None:
        return self._of_bodies() or self._of_holder() or self._of_wear()

    def _of_bodies(self) -> Inconsistency | None:
        if (wanted := self.pad.missing_face(self.kind)) is not None:
            return Inconsistency(("pad",), f"does not say which face it has: {wanted}")
        if (unfit := self.specimen.unfit_bore(self.pad, self.kind)) is not None:
            return unfit
        if (unfit := self._of_shaft()) is not None:
            return unfit
        for name in ("pad", "specimen"):
            if (bulk := getattr(self, name).bulk) is not None and (problem := bulk.unfit(is_round=False)):
                return Inconsistency((name, "bulk"), problem)
        if any(effect.seam is Seam.SPECIMENS for effect in self.effects):
            return Inconsistency(
                ("effects",), "hold one that changes how crossed wires are mounted, which a pad is not"
            )
        return None

    def _of_shaft(self) -> Inconsistency | None:
        """The contradiction of a shaft with the rest of the study; None if they fit, or there is no shaft."""
        own, pad = self.specimen, self.pad
        radius = own.shaft_radius_mm
        if radius is None:
            beside = next((key for key in ("interference_um", "assembly_force_N", "taper") if getattr(own, key)), None)
            return (
                Inconsistency(("specimen", beside), "is of a shaft: give its shaft_radius_mm, too") if beside else None
            )
        around, length = 2.0 * pi * radius, self.contact.length_mm
        problems = {
            ("pad",): "is the hub of a shaft: give its bore's face_half_width_mm and the edge_radius_mm of its ends"
            if not isinstance(pad.profile, RoundedFlat)
            else None,
            ("specimen", "interference_um"): "is missing: nothing else presses a hub on its shaft but assembly_force_N"
            if own.interference_um is None and own.assembly_force_N is None
            else None,
            ("specimen", "assembly_force_N"): "and interference_um are both given, but either follows from the other: "
            "give one"
            if own.interference_um is not None and own.assembly_force_N is not None
            else None,
            ("contact", "length_mm"): f"must be {around:.6g}, the shaft's circumference, to a thousandth"
            if abs(length / around - 1.0) > 1e-3
            else None,
            ("holder", "rotational_stiffness_N_mm_per_rad"): "is given, but a hub does not turn over: remove it"
            if self.holder.rotational_stiffness_N_mm_per_rad != "rigid"
            else None,
        }
        foreign = [("specimen", "bore_radius_mm"), ("holder", "normal_spring_stiffness_N_per_mm")]
        foreign += [("conditions", "load_cycle")]
        foreign += [(body, key) for body in ("pad", "specimen") for key in ("surface", "bulk", "grip_width_mm")]
        for table, key in foreign:
            given = getattr(getattr(self, table), key)
            problems[table, key] = "is given, but a shaft in a hub has none: remove it" if given else None
        return next((Inconsistency(key, said) for key, said in problems.items() if said), None)

    def _of_holder(self) -> Inconsistency | None:
        holder, key = self.holder, ("holder", "rotational_stiffness_N_mm_per_rad")
        stiffness = holder.rotational_stiffness_N_mm_per_rad
        if stiffness == "rigid":
            return None
        if holder.pivot_height_mm is None:
            return Inconsistency(key, keys.NO_PIVOT)
        leaning = self.conditions.normal_load_N * holder.pivot_height_mm
        if stiffness > leaning:
            return None
        return Inconsistency(
            key,
            f"is {stiffness:g}, but below {leaning:g}, load times pivot height, the pad tips over: give a stiffer "
            "spring or a lower pivot",
        )

    def _of_wear(self) -> Inconsistency | None:
        wear, law, friction = self.wear, self.wear.of_law, self.contact
        for body in ("pad", "specimen"):
            energy, archard = (key for key in wear.WEAR if key.startswith(body))
            if wear.coefficients[energy] > 0.0 and wear.coefficients[archard] > 0.0:
                return Inconsistency(
                    ("wear", energy), f"and {archard} are both given, but a body wears by one law: give one of the two"
                )
        by_archard = any(value > 0.0 for key, value in wear.coefficients.items() if "archard" in key)
        if by_archard and not isinstance(friction.friction_law, Coulomb):
            return Inconsistency(
                ("contact", "friction_law"),
                f"is {friction.friction_law.name!r}, but line contacts compute Archard wear from Coulomb's friction "
                "energy: give energy wear coefficients instead",
            )
        if law.coefficient == "archard" or (by_archard and not isinstance(law, EnergyLaw)):
            return Inconsistency(
                ("wear", "law"),
                f"is {law.name!r}, but line contacts take Archard's law by {' and '.join(wear.WEAR[2:])}, and all "
                "others by energy wear coefficients",
            )
        if by_archard and friction.friction == 0.0:
            return Inconsistency(
                ("contact", "friction"),
                "is 0, but Archard wear is computed from friction energy: give a small coefficient such as 0.01",
            )
        return None


#: The template of a line contact's study: a titanium cylinder on a titanium flat.
LINE_CONTACT = Template(
    kinds.LINE_CONTACT,
    LineTables,
    ("pad", "specimen", "conditions", "contact", "wear", "holder", "log"),
    {
        "pad": {"radius_mm": 40.0, **TITANIUM},
        "specimen": TITANIUM,
        "conditions": {
            "normal_load_N": 3900.0,
            "displacement_amplitude_um": 35.0,
            "cycles": 10000,
            "frequency_Hz": 5.0,
        },
        "contact": {"friction": 0.9, "length_mm": 10.0},
        "wear": {"pad_energy_wear_coefficient_mm3_per_J": 2.0e-5, "specimen_energy_wear_coefficient_mm3_per_J": 4.0e-5},
        "holder": {"tangential_stiffness_N_per_mm": "rigid"},
    },
    "A cylinder on a flat, to be changed into your line contact; loads and stiffnesses are of its whole length.",
)
