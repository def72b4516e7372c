"""Studies as tables of keys, each an attribute: the tables of any study, and those that contacts at a point and crossed
wires add.

The driven body lies below, the held one above. A variant is a set of values that replaces some of a study's own.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import replace
from math import inf
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, PlainValidator, model_validator

from geometry import Elastic
from solvers import Coating, Drive, FrictionLaw, Holder, WearLaw, WearRates
from wirewear.base import kinds
from wirewear.base.words import shown
from wirewear.effects import Age, Seam, Specimens, applied
from wirewear.test import keys
from wirewear.test.bodies import Body, Wire, yield_of
from wirewear.test.conditions import (
    Conditions,
    Contact,
    DrivenConditions,
    Fidelities,
    FrictionTable,
    HolderTable,
    Log,
    Mesh,
    Scatter,
    Stop,
    Wear,
)
from wirewear.test.drive import bulk_of
from wirewear.test.life import LifeTable
from wirewear.test.programme import RiggedBlock
from wirewear.test.surfaces import LayerTable, coating_of, layers_of
from wirewear.test.wires import BothWires, with_motion_of_wires


def _checked_kind(value: object) -> str:
    if value == "rig-stiffness":
        raise ValueError('is "rig-stiffness", which is a line contact whose variants have the rigs: "line-contact"')
    if value != kinds.CROSSED_WIRES:
        others = " or ".join(f'"{kind}"' for kind in (*kinds.AT_A_POINT[1:], *kinds.NAMES[kinds.LINE_CONTACT]))
        raise ValueError(f'is {shown(value)}, but must be "crossed-wires"; `wirewear run` also takes {others}')
    return kinds.CROSSED_WIRES


class StatesItsKind(keys.NamedTable):
    """The keys with which a study file begins: version of the format, title, and kind of test."""

    kind: str = Field(description="kind of contact")


class CommonTables(StatesItsKind, ABC):
    """The tables of a study of any kind, without its variants. Subclasses give the types of `wear` and `mesh`."""

    conditions: DrivenConditions = Field(description="load, stroke, frequency and length of the test")
    programme: tuple[RiggedBlock, ...] = Field(
        (), description="blocks of cycles, repeated in turn up to the test's end"
    )
    contact: FrictionTable = Field(description="friction")
    wear: Any = Field(None, description="wear law; without this table nothing wears")
    holder: HolderTable = Field(HolderTable(), description="stiffness of the rig and of the loading train")
    stop: Stop | None = Field(None, description="what ends the test before its last cycle")
    effects: keys.Effects = Field((), description="effects that the nominal model lacks")
    log: Log = Field(Log(), description="which cycles are recorded")
    life: LifeTable | None = Field(
        None, description="criterion and data by which cycles are counted until a crack begins"
    )
    mesh: Any = Field(None, description="extent of the fine mesh")

    @property
    def contact_kind(self) -> str:
        """Name of the kind of test in results and records."""
        return self.kind

    @classmethod
    def known(
        cls, data: Mapping[str, object], where: str, variant: Mapping[str, object] | None = None
    ) -> dict[str, object]:
        """The nested tables of a file, a variant's values merged into them, with keys that the class knows: line
        contacts convert those per millimetre. where: name of the file for messages. Raises StudyError if a value is
        stated in two ways.
        """
        del where
        return keys.merged(data, variant or {})

    def known_as(self, key: str, value: object) -> tuple[str, object]:
        """The key and value that these tables hold for a key with dots: line contacts convert those per millimetre."""
        return key, value

    @property
    @abstractmethod
    def layers(self) -> dict[str, tuple[LayerTable, ...]]:
        """Coatings by the name of the body, the driven one first; an empty tuple for a body without any."""

    @property
    @abstractmethod
    def materials(self) -> dict[str, Elastic]:
        """Elastic constants by the name of the body, the driven one first."""

    @property
    def coatings(self) -> tuple[Coating | None, ...]:
        """Layers with elastic constants of their own on the driven and on the held body; None for none."""
        return tuple(coating_of(layers, self.materials[name]) for name, layers in self.layers.items())

    @property
    def yields(self) -> dict[str, tuple[float, float] | None]:
        """(yield stress, hardening modulus) in MPa by body, the driven one first; None for an elastic body."""
        return {}

    @property
    @abstractmethod
    def drive(self) -> Drive:
        """Displacement, load and bulk stresses over a cycle, as the solvers take them."""

    @property
    def laws(self) -> tuple[FrictionLaw | WearLaw, ...]:
        """The friction law and, if the test wears, the wear law."""
        friction: FrictionLaw = self.contact.friction_law
        return (friction,) if self.wear is None else (friction, self.wear.of_law)

    @property
    @abstractmethod
    def worn_by_sliding(self) -> float:
        """Worn volume of both bodies per load and sliding distance in gross slip, in mm³/(N m)."""

    @property
    def worn_per_cycle(self) -> float:
        """A measure of wear per cycle to compare conditions by, in 10⁻⁶ mm³: the worn volume of both bodies when one
        amplitude, a quarter of a cycle's path, slides as a whole.
        """
        return self.worn_by_sliding * self.conditions.normal_load_N * float(self.conditions.displacement_amplitude_um)

    @property
    def rig(self) -> Holder:
        """The held body's holder under the stated normal load, without effects; its springs along the motion and
        against rotation as compliances, 0 where rigid.
        """
        holder = self.holder
        return Holder(
            normal_load_N=self.conditions.normal_load_N,
            tangential_compliance_mm_per_N=compliance(holder.tangential_stiffness_N_per_mm),
            normal_stiffness_N_per_mm=holder.normal_spring_stiffness_N_per_mm,
            rotational_compliance_rad_per_N_mm=compliance(holder.rotational_stiffness_N_mm_per_rad),
            pivot_height_mm=holder.pivot_height_mm or 0.0,
        )

    @property
    @abstractmethod
    def wear_rates(self) -> WearRates:
        """Wear law, nominal coefficients in mm³/mJ and layers of the upper (held) and the lower (driven) body."""

    @abstractmethod
    def contradiction(self) -> keys.Inconsistency | None:
        """The first contradiction among the keys of the bodies, or in what this kind of test alone takes; None if all
        fit. What holds for any contact is checked in `consistency`.
        """


def compliance(stiffness: float | Literal["rigid"]) -> float:
    """1/stiffness of a spring; 0 for "rigid"."""
    return 0.0 if stiffness == "rigid" else 1.0 / stiffness


class ContactTables(CommonTables):
    """The tables of a study of any contact at a point, without those of its bodies."""

    conditions: Conditions = Field(description="load, stroke, frequency and length of the test")
    contact: Contact = Field(description="friction")
    wear: Wear | None = Field(None, description="wear law; without this table nothing wears")
    scatter: Scatter | None = Field(None, description="scatter of the study's values from test to test")
    mesh: Mesh = Field(Mesh(), description="extent of the fine mesh")
    fidelity: Fidelities = Field(Fidelities(), description="resolution of quick, standard and fine runs")

    @abstractmethod
    def bodies_of_test(self) -> tuple[Body, Body]:
        """(driven body, held body); the driven one lies below."""

    @property
    def layers(self) -> dict[str, tuple[LayerTable, ...]]:
        return {body.name: body.layers for body in self.bodies_of_test()}

    @property
    def materials(self) -> dict[str, Elastic]:
        return {body.name: body.material for body in self.bodies_of_test()}

    @property
    def yields(self) -> dict[str, tuple[float, float] | None]:
        stated = {body.name: yield_of(body) or (inf, 0.0) for body in self.bodies_of_test()}
        first = min(stress for stress, _ in stated.values())
        mounted = applied(self.effects, Seam.SPECIMENS, Specimens(90.0, yield_stress_MPa=first), Age.new())
        # An effect of another yield stress is that of the bodies which are stated to yield first.
        own = {name: (mounted.yield_stress_MPa if at <= first else at, rise) for name, (at, rise) in stated.items()}
        return {name: None if at == inf else (at, rise) for name, (at, rise) in own.items()}

    @property
    def drive(self) -> Drive:
        return replace(
            self.conditions.drive, bulk=bulk_of([(body.bulk, body.material) for body in self.bodies_of_test()])
        )

    @property
    def worn_by_sliding(self) -> float:
        wear = self.wear
        return 0.0 if wear is None else wear.largest_factor * wear.volume_per_sliding_mm3_per_N_m(self.contact.friction)

    @property
    def rig(self) -> Holder:
        approach_um = self.conditions.approach_um
        return replace(super().rig, approach_mm=None if approach_um is None else 1e-3 * approach_um)

    @property
    def wear_rates(self) -> WearRates:
        if self.wear is None:
            return WearRates()
        wear, (driven, held) = self.wear, self.bodies_of_test()
        energy, archard = wear.energy_wear_coefficient_mm3_per_J, wear.archard_wear_coefficient_mm3_per_N_m
        # Per joule and per newton metre alike: 1 J = 1000 mJ = 1000 N mm.
        both = 1e-3 * (archard or energy or 0.0)
        return WearRates(
            upper_mm3_per_mJ=(1.0 - wear.moving_share) * both,
            lower_mm3_per_mJ=wear.moving_share * both,
            law=wear.of_law,
            upper_layers=layers_of(held.layers, self.contact.friction),
            lower_layers=layers_of(driven.layers, self.contact.friction),
        )


class _OfWires(StatesItsKind):
    """The keys with which a study of crossed wires begins."""

    wires: BothWires


class StudyTables(ContactTables, _OfWires):
    """The tables of a study of crossed wires, without its variants."""

    elsewhere: ClassVar = {"bodies": "one wire alone is [wires.moving] or [wires.fixed]"}

    kind: Annotated[Literal["crossed-wires"], PlainValidator(_checked_kind)] = Field(
        description="kind of contact", examples=["crossed-wires"]
    )

    @model_validator(mode="before")
    @classmethod
    def _with_motion(cls, tables: Any) -> Any:
        return with_motion_of_wires(tables)

    def bodies_of_test(self) -> tuple[Wire, Wire]:
        return self.wires.of_test(self.conditions.motion_angle_deg)

    def contradiction(self) -> keys.Inconsistency | None:
        twice = self.wires.motion_angle_deg is not None
        second = keys.Inconsistency(("conditions", "motion_angle_deg"), "is given, and the wires give it as well")
        return self.wires.contradiction() or (second if twice else None)
