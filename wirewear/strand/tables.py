"""Tables of a rope's file: construction, load, bending and friction, every key with its range and meaning."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, PlainValidator

from geometry import Elastic
from wirewear.base.errors import StudyError
from wirewear.base.files import read_toml
from wirewear.base.recognising import Held, require_no_other
from wirewear.base.units import Quantity
from wirewear.strand.construction import AskedLayer, Fibre, Layer, RopeWire, Strand
from wirewear.strand.helix import Hand
from wirewear.test import keys
from wirewear.test.bodies import YIELDS, ElasticKeys, YieldingKeys
from wirewear.test.life import LifeTable
from wirewear.test.messages import validated

_RADIUS = "radius of its centre line; without it where it comes to rest on what is below, or on its neighbours"


class _LayQuantity(Quantity):
    """A length whose message on a negative value explains that its sign is not the direction of lay."""

    def __call__(self, value: object) -> float | int | str:
        if isinstance(value, int | float) and not isinstance(value, bool) and value < 0.0:
            raise ValueError(f'is {value:g}, but a lay length is positive: its direction is lay = "left" or "right"')
        return super().__call__(value)


LayLength = Annotated[float, PlainValidator(_LayQuantity("mm", 1.0, 1e4))]
Lay = Annotated[Literal["right", "left"], PlainValidator(keys.one_of("right", "left"))]
Count = Annotated[int, PlainValidator(Quantity("1", 3, 200, whole=True))]
Radius = Annotated[float, PlainValidator(Quantity("mm", 0.02, 500.0))]
Fibres = Annotated[float, PlainValidator(Quantity("mm", 0.1, 200.0))]
Tension = Annotated[float, PlainValidator(Quantity("N", 1e-2, 1e8))]
TensionAmplitude = Annotated[float, PlainValidator(Quantity("N", 0.0, 1e8))]
BendingRadius = Annotated[float, PlainValidator(Quantity("mm", 1.0, 1e7))]
Bending = Annotated[Literal["reversed", "pulsating"], PlainValidator(keys.one_of("reversed", "pulsating"))]


class _OwnMaterial(keys.OfMaterial):
    """Material of wires that differs from [wires]."""

    material: keys.MaterialName | None = Field(None, description="name of their material, in place of its constants")
    youngs_modulus_MPa: keys.YoungsModulus | None = Field(None, description="Young's modulus")
    poissons_ratio: keys.PoissonsRatio | None = Field(None, description="Poisson's ratio")
    yield_stress_MPa: keys.YieldStress | None = Field(None, description=YIELDS)


class AllWires(YieldingKeys):
    """Keys of the material of all wires that state none of their own."""

    def wire(self, diameter_mm: float, own: _OwnMaterial) -> RopeWire:
        """A wire of this diameter, with its own constants where `own` states any."""
        modulus, ratio = own.youngs_modulus_MPa, own.poissons_ratio
        material = self.material if modulus is None and ratio is None else own.material
        elastic = Elastic(modulus or self.youngs_modulus_MPa, self.poissons_ratio if ratio is None else ratio)
        stated = own.yield_stress_MPa or (self.yield_stress_MPa if own.material is None else None)
        return RopeWire(diameter_mm, elastic, material, stated)


class CoreTable(_OwnMaterial):
    """Keys of the middle of a strand: a wire, or fibres in a rope."""

    wire_diameter_mm: keys.Diameter | None = Field(None, description="diameter of the core's wire", examples=[3.0])
    fibre_diameter_mm: Fibres | None = Field(None, description="diameter of a core of fibres, which bears no tension")


class LayerOfWires(_OwnMaterial):
    """Keys of one layer of wires."""

    wires: Count = Field(description="number of wires", examples=[6])
    wire_diameter_mm: keys.Diameter = Field(description="diameter of its wires", examples=[2.9])
    lay_length_mm: LayLength = Field(description="length along the strand in which a wire goes around once")
    lay: Lay = Field("right", description='"right" or "left"')
    radius_mm: Radius | None = Field(None, description=_RADIUS)


class OuterStrands(keys.Table):
    """Keys of equal strands around the core strand, or the fibre core, of a rope."""

    strands: Count = Field(description="number of strands", examples=[6])
    lay_length_mm: LayLength = Field(description="length along the rope in which a strand goes around once")
    lay: Lay = Field("right", description='"right" or "left"')
    radius_mm: Radius | None = Field(None, description=_RADIUS)
    core: CoreTable = Field(description="core of each strand")
    layers: tuple[LayerOfWires, ...] = Field(description="layers of each strand, from the innermost on")


class RopeConditions(keys.Table):
    """Keys of the rope's tension and bending."""

    tension_N: Tension = Field(description="tension of the rope", examples=[20000.0])
    tension_amplitude_N: TensionAmplitude = Field(0.0, description="amplitude of the tension, in step with the bending")
    bending_radius_mm: BendingRadius = Field(description="radius to which the rope's axis is bent", examples=[500.0])
    bending: Bending = Field(
        "reversed",
        description='"reversed", to that radius on either side, or "pulsating", from straight as on a sheave',
    )
    cycles: keys.Cycles = Field(description="cycles of bending", examples=[100000])
    frequency_Hz: keys.Frequency = Field(1.0, description="cycles per second")

    @property
    def curvature_amplitude_per_mm(self) -> float:
        """Amplitude of the curvature of the rope's axis: 1/radius for reversed bending, half of it for pulsating."""
        return (1.0 if self.bending == "reversed" else 0.5) / self.bending_radius_mm


class RopeFriction(keys.Table):
    """The key for the coefficient of friction of all contacts."""

    friction: keys.Friction = Field(description="coefficient of friction", examples=[0.15])


class RopeWear(keys.Table):
    """The key of the energy law of wear: worn volume = coefficient × friction energy."""

    energy_wear_coefficient_mm3_per_J: keys.WearCoefficient = Field(
        description="worn volume of both wires together per dissipated energy", examples=[3e-5]
    )


class Sheave(ElasticKeys):
    """Keys of a sheave that the rope is bent over."""

    groove_radius_mm: Radius = Field(description="radius of the groove across the rope")


class RopeTables(keys.NamedTable):
    """All tables of a rope's file."""

    wires: AllWires = Field(description="material of wires that state none")
    core: CoreTable = Field(description="core of the strand, or of a rope's core strand")
    layers: tuple[LayerOfWires, ...] = Field((), description="layers of wires around it, from the innermost on")
    outer_strands: OuterStrands | None = Field(None, description="strands around the core strand, of a rope")
    conditions: RopeConditions = Field(description="tension and bending")
    contact: RopeFriction = Field(description="friction")
    wear: RopeWear | None = Field(None, description="wear law; without this table nothing wears")
    sheave: Sheave | None = Field(None, description="groove that the rope is bent over")
    life: LifeTable | None = Field(None, description="criterion and data by which lives are estimated")

    def construction(self, where: str) -> Strand:
        """The strand or rope that the tables describe; where: name of the file for messages. Raises StudyError, in one
        sentence, if it is impossible.
        """
        fibres, outer = self.core.fibre_diameter_mm, self.outer_strands
        core = self._core(self.core, f"[core] of {where}", may_be_fibre=outer is not None and not self.layers)
        if outer is None and not self.layers:
            raise StudyError(f"{where} has neither [[layers]] nor [outer_strands]: a wire alone touches nothing.")
        middle = core if fibres and not self.layers else Strand(core, self._layers(core, self.layers, where))
        if outer is None:
            return middle if isinstance(middle, Strand) else Strand(middle, ())
        if isinstance(middle, Strand) and not middle.layers:
            middle = middle.core
        inner = self._core(outer.core, f"[outer_strands.core] of {where}", may_be_fibre=False)
        strand = Strand(inner, self._layers(inner, outer.layers, where, "outer_strands."))
        if not strand.layers:
            raise StudyError(f"[[outer_strands.layers]] is empty in {where}: give the wires of its strands.")
        place = f"[outer_strands] of {where}"
        hand = _hand(outer.lay)
        ring = AskedLayer((middle, ()), outer.strands, strand, outer.lay_length_mm, hand, outer.radius_mm, place)
        return Strand(middle, (ring.laid(),))

    def _core(self, table: CoreTable, where: str, *, may_be_fibre: bool) -> RopeWire | Fibre:
        if (table.wire_diameter_mm is None) == (table.fibre_diameter_mm is None):
            raise StudyError(f"{where} must give wire_diameter_mm, or fibre_diameter_mm of a rope's fibre core.")
        if table.wire_diameter_mm is not None:
            return self.wires.wire(table.wire_diameter_mm, table)
        if not may_be_fibre or table.fibre_diameter_mm is None:
            raise StudyError(f"{where} gives fibre_diameter_mm, but only [outer_strands] alone lie on fibres.")
        return Fibre(table.fibre_diameter_mm)

    def _layers(
        self, core: RopeWire | Fibre, tables: Sequence[LayerOfWires], where: str, above: str = ""
    ) -> tuple[Layer, ...]:
        made: list[Layer] = []
        for number, own in enumerate(tables, 1):
            wire = self.wires.wire(own.wire_diameter_mm, own)
            place = f"[[{above}layers]] number {number} of {where}"
            below, hand = (core, tuple(made)), _hand(own.lay)
            made.append(AskedLayer(below, own.wires, wire, own.lay_length_mm, hand, own.radius_mm, place).laid())
        return tuple(made)


def _hand(lay: str) -> Hand:
    return 1 if lay == "right" else -1


def load_rope(path: str | Path) -> RopeTables:
    """Checked tables of a rope's file. Raises StudyError, in one sentence, if it cannot be read or is not a rope's."""
    path = Path(path)
    require_no_other(path, StudyError, Held.ROPE)
    return rope_of(read_toml(path, StudyError, "TOML file"), str(path))


def rope_of(tables: dict[str, object], where: str) -> RopeTables:
    """A rope's nested tables, checked; `where` names their origin. Raises StudyError, in one sentence, if not valid."""
    return validated(RopeTables, tables, where, StudyError)
