"""The tables of a study of a contact at a point, and those common to all kinds: every key with range, default and
meaning.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import replace
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, PlainValidator, model_validator

from geometry import Elastic
from solvers import Archard, Coulomb, Drive, EnergyLaw, FrictionLaw, Holder, Waveform, WearLaw, WearRates
from wirewear.base import kinds
from wirewear.base.errors import shown
from wirewear.test import keys
from wirewear.test.bodies import Body, Wire, yield_of
from wirewear.test.drive import LOAD_CYCLE, MOTION, LoadCycleKey, MotionKey, bulk_of, drive_of
from wirewear.test.life import LifeTable
from wirewear.test.programme import CycleBlock
from wirewear.test.surfaces import LayerTable, layers_of
from wirewear.test.wires import BothWires, with_motion_of_wires

Formulation = Literal["augmented-lagrangian", "penalty"]
Variation = Literal["none", "cycles", "energy_J"]
WearUpdate = Literal["implicit", "explicit"]


def _checked_kind(value: object) -> str:
    if value == "rig-stiffness":
        raise ValueError('is "rig-stiffness", which is a line contact whose variants have the rigs: "line-contact"')
    if value != kinds.CROSSED_WIRES:
        others = " or ".join(f'"{kind}"' for kind in (*kinds.AT_A_POINT[1:], *kinds.NAMES[kinds.LINE_CONTACT]))
        raise ValueError(f'is {shown(value)}, but must be "crossed-wires"; `wirewear run` also takes {others}')
    return kinds.CROSSED_WIRES


class Asked(keys.Table):
    """Keys of load, stroke and length of any test. If another figure is held, displacement_amplitude_um is the largest
    amplitude.
    """

    normal_load_N: keys.NormalLoad = Field(description="normal load between the bodies", examples=[2.0])
    displacement_amplitude_um: keys.Amplitude = Field(
        description="imposed displacement amplitude, half the stroke", examples=[60.0]
    )
    frequency_Hz: keys.Frequency = Field(description="cycles per second", examples=[3.0])
    cycles: keys.Cycles = Field(description="length of the test", examples=[100000])
    motion: MotionKey = Field(Waveform(), description=MOTION, examples=["sinusoidal"])
    load_cycle: LoadCycleKey | None = Field(None, description=LOAD_CYCLE)
    held_slip_amplitude_um: keys.Amplitude | None = Field(
        None, description="the drive holds this slip amplitude, by a stroke of displacement_amplitude_um at most"
    )
    held_motion_um: keys.Amplitude | None = Field(
        None, description="the drive holds this amplitude of the bodies' motion against each other where they are held"
    )
    held_reading_um: keys.Amplitude | None = Field(
        None, description="the drive holds this amplitude of its sensor's reading, which the effects of a sensor change"
    )
    held_tangential_force_N: keys.NormalLoad | None = Field(
        None, description="the drive holds this largest tangential force of a cycle"
    )
    held_energy_mJ: keys.HeldEnergy | None = Field(None, description="the drive holds this energy of a cycle")


class DrivenConditions(Asked):
    """Keys of load, stroke and length of a simulated test, whose drive is known."""

    @property
    def drive(self) -> Drive:
        """Displacement and load over a cycle."""
        return drive_of(self.displacement_amplitude_um, self.motion, self.load_cycle)


class Conditions(DrivenConditions):
    """Keys of load, stroke and length of a test of a contact at a point."""

    approach_um: keys.Approach | None = Field(
        None, description="press the bodies together by this much and hold them; normal_load_N is then only expected"
    )
    motion_angle_deg: keys.MotionAngle = Field(
        0.0, description="direction of the motion against the moving wire's axis, about the normal that points upwards"
    )


class FrictionTable(keys.Table):
    """Keys of the friction law."""

    friction: keys.Friction = Field(description="coefficient of friction", examples=[0.62])
    friction_law: keys.FrictionLawKey = Field(
        Coulomb(), description='"coulomb", or a table of another law\'s name and parameters; friction is its start'
    )
    plasticity: Annotated[
        Literal["limited pressure", "none"], PlainValidator(keys.one_of("limited pressure", "none"))
    ] = Field(
        "limited pressure",
        description='what a body that states its yield_stress_MPa does: "limited pressure", or "none" to stay elastic',
    )


class Contact(FrictionTable):
    """Keys of the friction law, and of how the contact conditions are imposed."""

    formulation: Annotated[Formulation, PlainValidator(keys.one_of("augmented-lagrangian", "penalty"))] = Field(
        "augmented-lagrangian", description='"augmented-lagrangian" (exact) or "penalty" (a thin elastic layer)'
    )
    primary_wire: Annotated[Literal["fixed", "moving"], PlainValidator(keys.one_of("fixed", "moving"))] = Field(
        "fixed",
        description="the wire whose surface carries the contact tractions; where one yields alone, or first, it does",
    )


class Wear(keys.Table):
    """Keys of the wear law: worn volume = coefficient × friction energy, or, by Archard's law, coefficient × load ×
    sliding.
    """

    law: keys.WearLawKey | None = Field(
        None, description='"energy", "archard", or a table of another law\'s name and parameters; by the coefficient'
    )

    energy_wear_coefficient_mm3_per_J: keys.WearCoefficient | None = Field(
        None, description="energy law: worn volume of both bodies together per dissipated energy"
    )
    archard_wear_coefficient_mm3_per_N_m: keys.ArchardCoefficient | None = Field(
        None, description="Archard's law: worn volume of both bodies together per load and sliding distance"
    )
    moving_share: keys.Share = Field(0.5, description="part of the worn volume that the driven body loses")
    variation: Annotated[Variation, PlainValidator(keys.one_of("none", "cycles", "energy_J"))] = Field(
        "none", description='what the coefficient varies with: "none", "cycles" or "energy_J", the accumulated energy'
    )
    variation_points: keys.Points = Field(
        (), description="pairs [cycles or energy_J, factor on the coefficient], joined by straight lines"
    )
    update: Annotated[WearUpdate, PlainValidator(keys.one_of("implicit", "explicit"))] = Field(
        "implicit", description='"implicit", or "explicit" for comparison: surfaces recede after each increment'
    )
    explicit_jump_cycles: keys.ExplicitJump | None = Field(
        None, description="cycles that one simulated cycle stands for with the explicit update"
    )

    @property
    def coefficients(self) -> dict[str, float]:
        """The stated coefficients by their keys."""
        stated = {
            "energy_wear_coefficient_mm3_per_J": self.energy_wear_coefficient_mm3_per_J,
            "archard_wear_coefficient_mm3_per_N_m": self.archard_wear_coefficient_mm3_per_N_m,
        }
        return {key: value for key, value in stated.items() if value is not None}

    @property
    def of_law(self) -> WearLaw:
        """The law that is stated, or the one to which the stated coefficient belongs."""
        return self.law or (EnergyLaw() if self.archard_wear_coefficient_mm3_per_N_m is None else Archard())

    def volume_per_sliding_mm3_per_N_m(self, friction: float) -> float:
        """Worn volume of both bodies per load and sliding distance in gross slip, without variation."""
        if self.archard_wear_coefficient_mm3_per_N_m is not None:
            return self.archard_wear_coefficient_mm3_per_N_m
        return (self.energy_wear_coefficient_mm3_per_J or 0.0) * friction

    @property
    def largest_factor(self) -> float:
        """Largest factor on the coefficient in its variation."""
        return max((factor for _, factor in self.variation_points), default=1.0)

    def factor(self, cycles: float, energy_J: float) -> float:
        """Factor on the coefficient after this number of cycles and this friction energy."""
        if self.variation == "none":
            return 1.0
        at, factors = zip(*self.variation_points, strict=True)
        return float(np.interp(cycles if self.variation == "cycles" else energy_J, at, factors))


class HolderTable(keys.Table):
    """Keys of the rig: springs between the held body's holder and ground, and the spring of the loading train."""

    tangential_stiffness_N_per_mm: keys.HolderStiffness = Field(
        "rigid", description='stiffness of the rig along the motion, a number or "rigid"', examples=[167.0]
    )
    rotational_stiffness_N_mm_per_rad: keys.RotationalStiffness = Field(
        "rigid", description='stiffness against rotation about a pivot above the contact, a number or "rigid"'
    )
    pivot_height_mm: keys.PivotHeight | None = Field(None, description="height of that pivot above the contact")
    normal_spring_stiffness_N_per_mm: keys.SpringStiffness = Field(
        0.0, description="stiffness of the loading spring; 0 is a dead weight"
    )


class Log(keys.Table):
    """Keys of the cycles whose loops and scars are recorded, and of the length over which pressures are averaged."""

    loop_cycles: keys.CycleList = Field(
        (),
        description="cycles whose loop is recorded, the last for later ones; without it 1, 2, 5, 10, ... and the last",
    )
    contact_states: keys.ContactStates = Field(
        24,
        description="positions of each recorded cycle whose contact forces are kept, from which the stresses inside "
        "follow; 0 for none",
    )
    pressure_length_um: keys.PressureLength | None = Field(
        None,
        description="mean pressures are those over discs of this diameter, of a line contact over segments of this "
        "length; without it the diameter of the fresh contact, of a line contact half its width",
    )

    def of_cycles(self, cycles: tuple[int, ...]) -> "Log":
        """The table with the loops of these cycles recorded."""
        return self.model_copy(update={"loop_cycles": cycles})


class Stop(keys.Table):
    """Keys of what ends a test before its last cycle, whichever comes first."""

    depth_um: keys.WornDepth | None = Field(None, description="depth of the deepest scar")
    worn_volume_mm3: keys.WornVolume | None = Field(None, description="worn volume of both bodies")
    accumulated_energy_J: keys.AccumulatedEnergy | None = Field(None, description="friction energy of all cycles")
    tangential_force_N: keys.NormalLoad | None = Field(None, description="tangential force at the ends of the stroke")
    clearance_um: keys.WornDepth | None = Field(
        None, description="clearance that wear opens: how far the held body has sunk since the bodies were pressed"
    )


class Scatter(keys.Table):
    """Keys of the scatter of a study's values from test to test, as standard deviations."""

    friction: keys.RelativeScatter | None = Field(None, description="of the coefficient of friction, relative")
    normal_load: keys.RelativeScatter | None = Field(None, description="of the normal load, relative")
    wear: keys.RelativeScatter | None = Field(None, description="of the wear coefficient, relative")
    tangential_stiffness: keys.RelativeScatter | None = Field(None, description="of the rig's stiffness, relative")
    crossing_angle_deg: keys.AngleScatter | None = Field(None, description="of the crossing angle")


class Mesh(keys.Table):
    """Keys of the extent of the fine mesh, and of how it follows wear."""

    scar_half_width_um: keys.ElementSize | None = Field(
        None, description="half-width of the finely meshed patch beyond the stroke; without it, predicted"
    )
    follow_scar: keys.CheckedFlag = Field(
        True, description="new meshes as the scar grows, where their sizes are left to the program; else one for all"
    )
    move_nodes_at_stages: keys.CheckedFlag = Field(
        False,
        description="nodes are moved into the worn surface whenever a mesh for a larger scar begins; at fine fidelity "
        "they always are",
    )
    move_nodes_every_um: keys.NodeMotion | None = Field(
        None,
        description="nodes are moved into the worn surface and the bodies condensed again whenever the surface is this "
        "much deeper than the nodes, 0 at every cycle jump; without it worn depth stays an offset from the fresh nodes",
    )


class FidelitySettings(keys.Table):
    """Keys of the resolution in space and time at one level of fidelity; None leaves a value to the program."""

    contact_mesh_um: keys.ElementSize | None = Field(None, description="element size where the fresh contact sits")
    outer_mesh_um: keys.ElementSize | None = Field(None, description="largest element of the fine patch")
    increments_per_cycle: keys.IncrementsPerCycle | None = Field(None, description="time steps of one cycle")
    increments_per_wear_cycle: keys.IncrementsPerCycle | None = Field(
        None, description="time steps of a cycle that only wears, where no loop is recorded; without it, fewer"
    )
    mesh_refinement: keys.Refinement = Field(1.0, description="elements are smaller than asked for by this factor")
    jump_tolerance: keys.Tolerance | None = Field(None, description="relative error allowed to one cycle jump")


class Fidelities(keys.Table):
    """Settings of the three levels of fidelity."""

    quick: FidelitySettings = Field(FidelitySettings(), description="seconds")
    standard: FidelitySettings = Field(FidelitySettings(), description="minutes")
    fine: FidelitySettings = Field(FidelitySettings(), description="for convergence checks")


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
        """A key with dots and its value, converted to the key that these tables have."""
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
