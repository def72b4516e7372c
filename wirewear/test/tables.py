"""Studies as tables: what all state, and what those of contacts at a point and of crossed wires add."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import replace
from typing import Annotated, Any, Literal

from pydantic import Field, PlainValidator, model_validator

from geometry import Elastic
from solvers import Drive, FrictionLaw, Holder, WearLaw, WearRates
from wirewear.base import kinds
from wirewear.base.words import shown
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
from wirewear.test.programme import CycleBlock
from wirewear.test.surfaces import LayerTable, layers_of
from wirewear.test.wires import BothWires, with_motion_of_wires


def _checked_kind(value: object) -> str:
    if value == "rig-stiffness":
        raise ValueError('is "rig-stiffness", which is a line contact whose variants have the rigs: "line-contact"')
    if value != kinds.CROSSED_WIRES:
        others = " or ".join(f'"{kind}"' for kind in (*kinds.AT_A_POINT[1:], *kinds.NAMES[kinds.LINE_CONTACT]))
        raise ValueError(f'is {shown(value)}, but must be "crossed-wires"; `wirewear run` also takes {others}')
    return kinds.CROSSED_WIRES


class StatesItsKind(keys.NamedTable):
    """The keys with which a file begins that states its kind of contact."""

    kind: str = Field(description="kind of contact")


class CommonTables(StatesItsKind, ABC):
    """Tables that studies of all kinds have, without variants; the type of those marked `Any` depends on the kind."""

    conditions: DrivenConditions = Field(description="load, stroke, frequency and length of the test")
    programme: tuple[CycleBlock, ...] = Field((), description="blocks of cycles, repeated in turn up to the test's end")
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
        """Kind of contact, as results and records name it."""
        return self.kind

    @classmethod
    def known(cls, data: Mapping[str, Any], where: str, variant: Mapping[str, Any] | None = None) -> dict[str, Any]:
        """A file's tables, with a variant's values in place of its own, converted to the keys that these tables have.

        Raises StudyError, in one sentence, if a value is stated twice; `where` names the file.
        """
        del where
        return keys.merged(data, variant or {})

    def known_as(self, key: str, value: Any) -> tuple[str, Any]:
        """The tables' own key and value for a key with dots that may be per length of a line contact, and its value."""
        return key, value

    @property
    @abstractmethod
    def layers(self) -> dict[str, tuple[LayerTable, ...]]:
        """Coatings of both bodies, by their names."""

    @property
    @abstractmethod
    def materials(self) -> dict[str, Elastic]:
        """Elastic constants of the driven body and of the held one, by their names."""

    @property
    def yields(self) -> dict[str, tuple[float, float] | None]:
        """Yield stress and hardening modulus in MPa of the driven and the held body, by name; None for an
        elastic body.
        """
        return {}

    @property
    @abstractmethod
    def drive(self) -> Drive:
        """Displacement, load and bulk stresses over a cycle."""

    @property
    def laws(self) -> tuple[FrictionLaw | WearLaw, ...]:
        """The friction law and, if the test wears, the wear law."""
        friction: FrictionLaw = self.contact.friction_law
        return (friction,) if self.wear is None else (friction, self.wear.of_law)

    @property
    @abstractmethod
    def worn_by_sliding(self) -> float:
        """Worn volume of both bodies in gross slip per load and sliding distance, 10⁻⁹ mm³/(N mm)."""

    @property
    def worn_per_cycle(self) -> float:
        """Worn volume in gross slip over a distance of one amplitude, a quarter of a cycle's, in 10⁻⁶ mm³."""
        return self.worn_by_sliding * self.conditions.normal_load_N * float(self.conditions.displacement_amplitude_um)

    @property
    def rig(self) -> Holder:
        """The held body's holder with its springs, as the solvers take it."""
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
        """Wear law and coefficients of the held (upper) and the driven (lower) body, without variation."""

    @abstractmethod
    def contradiction(self) -> keys.Inconsistency | None:
        """The key in the tables of the bodies that does not fit the others; None if all fit."""


def compliance(stiffness: float | Literal["rigid"]) -> float:
    """1/stiffness of a spring, 0 for a rigid one."""
    return 0.0 if stiffness == "rigid" else 1.0 / stiffness


class ContactTables(CommonTables):
    """Tables that studies of all contacts at a point have, besides their bodies."""

    conditions: Conditions = Field(description="load, stroke, frequency and length of the test")
    contact: Contact = Field(description="friction")
    wear: Wear | None = Field(None, description="wear law; without this table nothing wears")
    scatter: Scatter | None = Field(None, description="scatter of the study's values from test to test")
    mesh: Mesh = Field(Mesh(), description="extent of the fine mesh")
    fidelity: Fidelities = Field(Fidelities(), description="resolution of quick, standard and fine runs")

    @abstractmethod
    def bodies_of_test(self) -> tuple[Body, Body]:
        """The driven body, which lies below, and the held one above it."""

    @property
    def layers(self) -> dict[str, tuple[LayerTable, ...]]:
        """Coatings of the driven body and of the held one."""
        return {body.name: body.layers for body in self.bodies_of_test()}

    @property
    def materials(self) -> dict[str, Elastic]:
        """Elastic constants of the driven body and of the held one."""
        return {body.name: body.material for body in self.bodies_of_test()}

    @property
    def yields(self) -> dict[str, tuple[float, float] | None]:
        return {body.name: yield_of(body) for body in self.bodies_of_test()}

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

    def too_far(self) -> keys.Inconsistency | None:
        """The key of a stroke longer than a body is thick; None otherwise."""
        amplitude_um = self.conditions.displacement_amplitude_um
        thinnest_mm = min(min(body.diameters_mm) for body in self.bodies_of_test())
        if amplitude_um > 1e3 * thinnest_mm:
            return keys.Inconsistency(
                ("conditions", "displacement_amplitude_um"),
                f"is {amplitude_um:g} µm, but must not exceed the smallest diameter, {1e3 * thinnest_mm:g} µm",
            )
        return None


class _OfWires(StatesItsKind):
    """The keys with which a study of crossed wires begins."""

    wires: BothWires


class StudyTables(ContactTables, _OfWires):
    """A whole study of crossed wires without its variants."""

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
        """The key of wires that do not fit, of two directions of motion, or of a stroke longer than a wire is thick;
        None if all fit.
        """
        twice = self.wires.motion_angle_deg is not None
        second = keys.Inconsistency(("conditions", "motion_angle_deg"), "is given, and the wires give it as well")
        return self.wires.contradiction() or (second if twice else None) or self.too_far()
