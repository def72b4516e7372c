"""The tables of a study's TOML file: every key with its unit, sensible range, default and meaning.

The keys carry their units; values are kept as given. A key's checks stand in its `Quantity`.
"""

from collections.abc import Callable
from itertools import pairwise
from typing import Annotated, Any, Literal, get_args

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, PlainSerializer, PlainValidator
from pydantic.fields import FieldInfo

from solvers import Coulomb
from wirewear.effects import Effect, effects_of_tables, tables_of_effects
from wirewear.quantity import Quantity, shown
from wirewear.study.laws import FrictionLawKey

FORMAT = 1
Formulation = Literal["augmented-lagrangian", "penalty"]
Variation = Literal["none", "cycles", "energy_J"]
WearUpdate = Literal["implicit", "explicit"]

_CYCLES = Quantity("cycles", 1, 1e9, whole=True)


def checked_format(value: object) -> int:
    """FORMAT, the only version there is; anything else raises ValueError."""
    if value != FORMAT or isinstance(value, bool):
        raise ValueError(f"is {shown(value)}, but this version of wirewear reads format {FORMAT}")
    return FORMAT


def checked_text(value: object) -> str:
    """A text that is not blank; anything else raises ValueError."""
    if not isinstance(value, str) or not value.strip():
        raise ValueError(f'is {shown(value)}, but must be a text such as "steel wires"')
    return value


#: Kinds of study with tables of their own, which `wirewear run` takes beside crossed wires.
PLANAR_KINDS = ("cylinder-on-flat", "rig-stiffness")


def _checked_kind(value: object) -> str:
    if value != "crossed-wires":
        others = " or ".join(f'"{kind}"' for kind in PLANAR_KINDS)
        raise ValueError(f'is {shown(value)}, but must be "crossed-wires"; `wirewear run` also takes {others}')
    return "crossed-wires"


def _checked_points(value: object) -> tuple[tuple[float, float], ...]:
    points = []
    for item in value if isinstance(value, list | tuple) else [None]:
        pair = item if isinstance(item, list | tuple) else []
        if len(pair) != 2 or any(isinstance(x, bool) or not isinstance(x, int | float) or not x >= 0 for x in pair):
            raise ValueError(f"is {shown(value)}, but must be a list of pairs such as [[0, 1.0], [10000, 0.5]]")
        points.append((float(pair[0]), float(pair[1])))
    if any(later[0] <= earlier[0] for earlier, later in pairwise(points)):
        raise ValueError(f"is {shown(value)}, but the first numbers of its pairs must increase")
    return tuple(points)


def _one_of(*words: str) -> Callable[[object], str]:
    """A check for a key that takes one of a few words."""
    choice = " or ".join(f'"{word}"' for word in words)

    def check(value: object) -> str:
        if value not in words:
            raise ValueError(f"is {shown(value)}, but must be {choice}")
        return str(value)

    return check


def _checked_flag(value: object) -> bool:
    if not isinstance(value, bool):
        raise ValueError(f"is {shown(value)}, but must be true or false")
    return value


def _checked_cycle_list(value: object) -> tuple[int, ...]:
    if not isinstance(value, list | tuple):
        raise ValueError(f"is {shown(value)}, but must be a list of cycle numbers such as [1, 100, 1000]")
    cycles = []
    for item in value:
        try:
            cycles.append(int(_CYCLES(item)))
        except ValueError as problem:
            raise ValueError(f"holds an item that {problem}") from None
    return tuple(sorted(set(cycles)))


Effects = Annotated[tuple[Effect[Any], ...], PlainValidator(effects_of_tables), PlainSerializer(tables_of_effects)]
Diameter = Annotated[float, PlainValidator(Quantity("mm", 0.02, 20.0))]
Length = Annotated[float, PlainValidator(Quantity("mm", 0.05, 200.0))]
YoungsModulus = Annotated[float, PlainValidator(Quantity("MPa", 1e3, 1.5e6))]
PoissonsRatio = Annotated[float, PlainValidator(Quantity("1", 0.0, 0.49))]
CrossingAngle = Annotated[float, PlainValidator(Quantity("deg", 30.0, 90.0))]
NormalLoad = Annotated[float, PlainValidator(Quantity("N", 1e-3, 1e4))]
Amplitude = Annotated[float, PlainValidator(Quantity("um", 0.1, 5e3))]
MotionAngle = Annotated[float, PlainValidator(Quantity("deg", -90.0, 90.0))]
Frequency = Annotated[float, PlainValidator(Quantity("Hz", 1e-4, 1e3))]
Cycles = Annotated[int, PlainValidator(_CYCLES)]
Friction = Annotated[float, PlainValidator(Quantity("1", 0.0, 2.0))]
WearCoefficient = Annotated[float, PlainValidator(Quantity("mm3_per_J", 0.0, 1e-2))]
ArchardCoefficient = Annotated[float, PlainValidator(Quantity("mm3_per_N_m", 0.0, 1e-2))]
ExplicitJump = Annotated[float, PlainValidator(Quantity("cycles", 0.01, 1e6))]
Share = Annotated[float, PlainValidator(Quantity("1", 0.0, 1.0))]
HolderStiffness = Annotated[float | Literal["rigid"], PlainValidator(Quantity("N_per_mm", 1.0, 1e7, words=("rigid",)))]
RotationalStiffness = Annotated[
    float | Literal["rigid"], PlainValidator(Quantity("N_mm_per_rad", 1.0, 1e10, words=("rigid",)))
]
PivotHeight = Annotated[float, PlainValidator(Quantity("mm", 0.1, 1e3))]
Approach = Annotated[float, PlainValidator(Quantity("um", 1e-3, 1e3))]
SpringStiffness = Annotated[float, PlainValidator(Quantity("N_per_mm", 0.0, 1e5))]
ElementSize = Annotated[float, PlainValidator(Quantity("um", 0.1, 5e3))]
IncrementsPerCycle = Annotated[int, PlainValidator(Quantity("1", 16, 4000, whole=True, multiple_of=4))]
Tolerance = Annotated[float, PlainValidator(Quantity("1", 1e-6, 0.5))]
Refinement = Annotated[float, PlainValidator(Quantity("1", 0.25, 4.0))]
NodeMotion = Annotated[float, PlainValidator(Quantity("um", 0.0, 1e3))]
CheckedFlag = Annotated[bool, PlainValidator(_checked_flag)]


class Table(BaseModel):
    """A table of the study: immutable, and without keys that it does not know."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class WireOverride(Table):
    """What one wire has different from `[wires]`."""

    diameter_mm: Diameter | None = Field(None, description="diameter of this wire")
    length_mm: Length | None = Field(None, description="modelled length of this wire")
    youngs_modulus_MPa: YoungsModulus | None = Field(None, description="Young's modulus of this wire")
    poissons_ratio: PoissonsRatio | None = Field(None, description="Poisson's ratio of this wire")


class Wires(Table):
    """Both wires: the moving one slides along its own axis, the fixed one's holder carries the rig's compliance."""

    diameter_mm: Diameter = Field(description="diameter of the wires", examples=[0.45])
    youngs_modulus_MPa: YoungsModulus = Field(description="Young's modulus", examples=[210000.0])
    poissons_ratio: PoissonsRatio = Field(description="Poisson's ratio", examples=[0.3])
    crossing_angle_deg: CrossingAngle = Field(90.0, description="angle between the wires' axes")
    length_mm: Length | None = Field(None, description="modelled length; without it the program chooses")
    moving: WireOverride = Field(WireOverride(), description="what the moving wire has different")
    fixed: WireOverride = Field(WireOverride(), description="what the fixed wire has different")


class Conditions(Table):
    """What is asked of the rig."""

    normal_load_N: NormalLoad = Field(description="normal load between the wires", examples=[2.0])
    approach_um: Approach | None = Field(
        None, description="press the wires together by this much and hold them; normal_load_N is then only expected"
    )
    displacement_amplitude_um: Amplitude = Field(
        description="imposed displacement amplitude, half the stroke", examples=[60.0]
    )
    motion_angle_deg: MotionAngle = Field(
        0.0, description="direction of the motion against the moving wire's axis, about the normal that points upwards"
    )
    frequency_Hz: Frequency = Field(description="cycles per second", examples=[3.0])
    cycles: Cycles = Field(description="length of the test", examples=[100000])


class Contact(Table):
    """The friction law, and how the contact conditions are imposed."""

    friction: Friction = Field(description="coefficient of friction", examples=[0.62])
    friction_law: FrictionLawKey = Field(
        Coulomb(), description='"coulomb", or a table of another law\'s name and parameters; friction is its start'
    )
    formulation: Annotated[Formulation, PlainValidator(_one_of("augmented-lagrangian", "penalty"))] = Field(
        "augmented-lagrangian", description='"augmented-lagrangian" (exact) or "penalty" (a thin elastic layer)'
    )
    primary_wire: Annotated[Literal["fixed", "moving"], PlainValidator(_one_of("fixed", "moving"))] = Field(
        "fixed", description="the wire whose surface carries the contact tractions"
    )


class Wear(Table):
    """The wear law: worn volume = coefficient × friction energy, or, by Archard's law, coefficient × load × sliding."""

    energy_wear_coefficient_mm3_per_J: WearCoefficient | None = Field(
        None, description="energy law: worn volume of both wires together per dissipated energy"
    )
    archard_wear_coefficient_mm3_per_N_m: ArchardCoefficient | None = Field(
        None, description="Archard's law: worn volume of both wires together per load and sliding distance"
    )
    moving_share: Share = Field(0.5, description="part of the worn volume that the moving wire loses")
    variation: Annotated[Variation, PlainValidator(_one_of("none", "cycles", "energy_J"))] = Field(
        "none", description='what the coefficient varies with: "none", "cycles" or "energy_J", the accumulated energy'
    )
    variation_points: Annotated[tuple[tuple[float, float], ...], BeforeValidator(_checked_points)] = Field(
        (), description="pairs [cycles or energy_J, factor on the coefficient], joined by straight lines"
    )
    update: Annotated[WearUpdate, PlainValidator(_one_of("implicit", "explicit"))] = Field(
        "implicit", description='"implicit", or "explicit" for comparison: surfaces recede after each increment'
    )
    explicit_jump_cycles: ExplicitJump | None = Field(
        None, description="cycles that one simulated cycle stands for with the explicit update"
    )

    def volume_per_sliding_mm3_per_N_m(self, friction: float) -> float:
        """Worn volume of both wires per load and sliding distance in gross slip, without any variation."""
        if self.archard_wear_coefficient_mm3_per_N_m is not None:
            return self.archard_wear_coefficient_mm3_per_N_m
        return (self.energy_wear_coefficient_mm3_per_J or 0.0) * friction

    def factor(self, cycles: float, energy_J: float) -> float:
        """The factor on the coefficient after so many cycles and so much energy."""
        if self.variation == "none":
            return 1.0
        at, factors = zip(*self.variation_points, strict=True)
        return float(np.interp(cycles if self.variation == "cycles" else energy_J, at, factors))


class Holder(Table):
    """The rig: springs between the fixed wire's holder and ground, and the spring of the loading train."""

    tangential_stiffness_N_per_mm: HolderStiffness = Field(
        "rigid", description='stiffness of the rig along the motion, a number or "rigid"', examples=[167.0]
    )
    rotational_stiffness_N_mm_per_rad: RotationalStiffness = Field(
        "rigid", description='stiffness against rotation about a pivot above the contact, a number or "rigid"'
    )
    pivot_height_mm: PivotHeight | None = Field(None, description="height of that pivot above the contact")
    normal_spring_stiffness_N_per_mm: SpringStiffness = Field(
        0.0, description="stiffness of the loading spring; 0 is a dead weight"
    )


class Log(Table):
    """At which cycles loops and scars are recorded."""

    loop_cycles: Annotated[tuple[int, ...], BeforeValidator(_checked_cycle_list)] = Field(
        (), description="cycles whose loop is recorded; without it 1, 2, 5, 10, ... and the last cycle"
    )


class Mesh(Table):
    """Where the mesh is fine."""

    scar_half_width_um: ElementSize | None = Field(
        None, description="half-width of the finely meshed patch beyond the stroke; without it, predicted"
    )
    follow_scar: CheckedFlag = Field(
        True, description="new meshes as the scar grows, where their sizes are left to the program; else one for all"
    )
    move_nodes_every_um: NodeMotion | None = Field(
        None,
        description="nodes are moved into the worn surface and the wires condensed again whenever the surface is this "
        "much deeper than the nodes, 0 at every cycle jump; without it worn depth stays an offset from the fresh nodes",
    )


class FidelitySettings(Table):
    """How finely a run resolves space and time; None leaves the choice to the program."""

    contact_mesh_um: ElementSize | None = Field(None, description="element size where the fresh contact sits")
    outer_mesh_um: ElementSize | None = Field(None, description="largest element of the fine patch")
    increments_per_cycle: IncrementsPerCycle | None = Field(None, description="time steps of one cycle")
    increments_per_wear_cycle: IncrementsPerCycle | None = Field(
        None, description="time steps of a cycle that only wears, where no loop is recorded; without it, fewer"
    )
    mesh_refinement: Refinement = Field(1.0, description="elements are smaller than the level's by this factor")
    jump_tolerance: Tolerance | None = Field(None, description="relative error allowed to one cycle jump")


class Fidelities(Table):
    """Settings of the three levels of fidelity."""

    quick: FidelitySettings = Field(FidelitySettings(), description="seconds")
    standard: FidelitySettings = Field(FidelitySettings(), description="minutes")
    fine: FidelitySettings = Field(FidelitySettings(), description="for convergence checks")


class StudyTables(Table):
    """A whole study without its variants."""

    format: Annotated[int, PlainValidator(checked_format)] = Field(
        description="version of this file's format", examples=[FORMAT]
    )
    name: Annotated[str, PlainValidator(checked_text)] = Field(
        description="title of the study", examples=["steel wires"]
    )
    kind: Annotated[Literal["crossed-wires"], PlainValidator(_checked_kind)] = Field(
        description="kind of contact", examples=["crossed-wires"]
    )
    wires: Wires = Field(description="the two wires")
    conditions: Conditions = Field(description="load, stroke, frequency and length of the test")
    contact: Contact = Field(description="friction")
    wear: Wear | None = Field(None, description="wear law; without this table nothing wears")
    holder: Holder = Field(Holder(), description="stiffness of the rig and of the loading train")
    effects: Effects = Field((), description="effects that the nominal model lacks")
    log: Log = Field(Log(), description="which cycles are recorded")
    mesh: Mesh = Field(Mesh(), description="extent of the fine mesh")
    fidelity: Fidelities = Field(Fidelities(), description="resolution of quick, standard and fine runs")


def quantity_of(field: FieldInfo) -> Quantity | None:
    """The `Quantity` that checks a key, if it holds a number."""
    inside_optional = [item for part in get_args(field.annotation) for item in getattr(part, "__metadata__", ())]
    for item in [*field.metadata, *inside_optional]:
        if isinstance(item, PlainValidator) and isinstance(item.func, Quantity):
            return item.func
    return None


def table_of(field: FieldInfo) -> type[Table] | None:
    """The table that a key holds, if it holds one."""
    candidates: tuple[Any, ...] = (field.annotation, *get_args(field.annotation))
    return next((c for c in candidates if isinstance(c, type) and issubclass(c, Table)), None)
