"""Tables of a study of any contact for all but its bodies: every key with its type, default and meaning.

A drive holds its displacement amplitude, unless the study states another quantity that it holds (a key held_...).
"""

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, PlainValidator

from solvers import Archard, Coulomb, Drive, EnergyLaw, Waveform, WearLaw
from wirewear.test import keys
from wirewear.test.drive import LOAD_CYCLE, MOTION, LoadCycleKey, MotionKey, drive_of

Formulation = Literal["augmented-lagrangian", "penalty"]
Variation = Literal["none", "cycles", "energy_J"]
WearUpdate = Literal["implicit", "explicit"]


class Asked(keys.Table):
    """Keys of load, stroke and length of any test. Where a key held_... is stated, displacement_amplitude_um is the
    largest amplitude that the drive may take.
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


def held_keys(conditions: object) -> list[str]:
    """The keys held_... of these conditions that are stated, in their order; more than one is a contradiction."""
    known = type(conditions).model_fields if isinstance(conditions, keys.Table) else {}
    return [key for key in known if key.startswith("held_") and getattr(conditions, key) is not None]


@dataclass(frozen=True)
class HeldTarget:
    """The quantity that a drive holds in place of its amplitude. key: the key held_... that states it; value in the
    key's unit (µm, N or mJ).
    """

    key: str
    value: float  #: The value to hold; for a line contact that of one millimetre if the study is.

    @property
    def figure(self) -> str:
        """The second word of `key`, which names what is held: "slip", "motion", "reading", "tangential" or "energy"."""
        return self.key.split("_")[1]

    def first_um(self, friction_N: float, carried_um: float, largest_um: float) -> float:
        """First guess in µm of the drive's amplitude at which a contact in gross slip holds the value; at most
        largest_um.

        friction_N: friction force. carried_um: travel of the rig under it. largest_um: the drive's largest amplitude.
        """
        match self.figure:
            case "slip" | "motion":
                first = self.value + carried_um
            case "reading":
                first = self.value
            case "energy":
                first = 1e3 * self.value / (4.0 * friction_N) + carried_um if friction_N else largest_um
            case _:
                first = 0.3 * largest_um + self.value * (carried_um / friction_N if friction_N else 0.0)
        return min(first, largest_um)


def held_by(conditions: object) -> HeldTarget | None:
    """The quantity that the drive holds in place of its displacement amplitude; None if it holds that."""
    key = next(iter(held_keys(conditions)), None)
    return None if key is None else HeldTarget(key, float(getattr(conditions, key)))


class DrivenConditions(Asked):
    """Keys of load, stroke and length of a test that is simulated."""

    @property
    def drive(self) -> Drive:
        """Displacement and normal load over a cycle, as the solvers take them; without bulk stresses."""
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
    """Keys of friction, and of what bodies do that state a yield stress."""

    friction: keys.Friction = Field(description="coefficient of friction", examples=[0.62])
    friction_law: keys.FrictionLawKey = Field(
        Coulomb(), description='"coulomb", or a table of another law\'s name and parameters; friction is its start'
    )
    # Metal that flows in the near zone is followed under contacts at a point alone, see `Contact`.
    plasticity: Annotated[
        Literal["limited pressure", "near zone", "none"], PlainValidator(keys.one_of("limited pressure", "none"))
    ] = Field(
        "limited pressure",
        description='what a body that states its yield_stress_MPa does: "limited pressure", or "none" to stay elastic',
    )


class Contact(FrictionTable):
    """Keys of friction of a contact at a point, of yielding, and of how the contact conditions are imposed."""

    plasticity: Annotated[
        Literal["limited pressure", "near zone", "none"],
        PlainValidator(keys.one_of("limited pressure", "near zone", "none")),
    ] = Field(
        "limited pressure",
        description='what a body that states its yield_stress_MPa does: "limited pressure"; "near zone", which '
        'flows beneath the surface as it is pressed and first slides; or "none" to stay elastic',
    )
    formulation: Annotated[Formulation, PlainValidator(keys.one_of("augmented-lagrangian", "penalty"))] = Field(
        "augmented-lagrangian", description='"augmented-lagrangian" (exact) or "penalty" (a thin elastic layer)'
    )
    primary_wire: Annotated[
        Literal["auto", "fixed", "moving"], PlainValidator(keys.one_of("auto", "fixed", "moving"))
    ] = Field(
        "auto",
        description='whose surface carries the contact tractions: "fixed", "moving", or "auto", by the physics; '
        "where a body yields alone, or first, it does",
    )


class Wear(keys.Table):
    """Keys of the wear law of a contact at a point: worn volume of both bodies = coefficient × friction energy or, by
    Archard's law, coefficient × load × sliding distance.
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
        """The wear coefficients that are stated, by their keys and in their units; empty if none is."""
        stated = {
            "energy_wear_coefficient_mm3_per_J": self.energy_wear_coefficient_mm3_per_J,
            "archard_wear_coefficient_mm3_per_N_m": self.archard_wear_coefficient_mm3_per_N_m,
        }
        return {key: value for key, value in stated.items() if value is not None}

    @property
    def of_law(self) -> WearLaw:
        """The stated law; if none is, Archard's law if its coefficient is stated, else the energy law."""
        return self.law or (EnergyLaw() if self.archard_wear_coefficient_mm3_per_N_m is None else Archard())

    def volume_per_sliding_mm3_per_N_m(self, friction: float) -> float:
        """Worn volume of both bodies per load and sliding distance in gross slip, without variation; 0 without a
        coefficient. friction: coefficient of friction, by which the energy law dissipates.
        """
        if self.archard_wear_coefficient_mm3_per_N_m is not None:
            return self.archard_wear_coefficient_mm3_per_N_m
        return (self.energy_wear_coefficient_mm3_per_J or 0.0) * friction

    @property
    def largest_factor(self) -> float:
        """Largest factor on the wear coefficient among `variation_points`; 1 if there are none."""
        return max((factor for _, factor in self.variation_points), default=1.0)

    def factor(self, cycles: float, energy_J: float) -> float:
        """Factor on the wear coefficient after `cycles` cycles and energy_J of friction energy, interpolated in
        `variation_points` and constant beyond them; 1 without variation.
        """
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
    """Keys of what is recorded: cycles whose loops and scars are kept, contact forces, and lengths of means."""

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
        """A copy that records the loops of these cycles."""
        return self.model_copy(update={"loop_cycles": cycles})


class Stop(keys.Table):
    """Keys of limits that end a test before its last cycle; the first that is reached ends it."""

    depth_um: keys.WornDepth | None = Field(None, description="depth of the deepest scar")
    worn_volume_mm3: keys.WornVolume | None = Field(None, description="worn volume of both bodies")
    accumulated_energy_J: keys.AccumulatedEnergy | None = Field(None, description="friction energy of all cycles")
    tangential_force_N: keys.NormalLoad | None = Field(None, description="tangential force at the ends of the stroke")
    clearance_um: keys.WornDepth | None = Field(
        None, description="clearance that wear opens: how far the held body has sunk since the bodies were pressed"
    )


class Scatter(keys.Table):
    """Keys of the scatter of a study's values from test to test, as standard deviations; relative ones are shares of
    the value.
    """

    friction: keys.RelativeScatter | None = Field(None, description="of the coefficient of friction, relative")
    normal_load: keys.RelativeScatter | None = Field(None, description="of the normal load, relative")
    wear: keys.RelativeScatter | None = Field(None, description="of the wear coefficient, relative")
    tangential_stiffness: keys.RelativeScatter | None = Field(None, description="of the rig's stiffness, relative")
    crossing_angle_deg: keys.AngleScatter | None = Field(None, description="of the crossing angle")


class Mesh(keys.Table):
    """Keys of a contact at a point for the extent of the fine mesh, and for how it follows wear."""

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
