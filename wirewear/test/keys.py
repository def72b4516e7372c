"""The keys of a study's TOML file: the type of each value, with its unit and range, and tables of keys.

A key's name ends in the unit of its value, and values are kept in that unit. A `Quantity` checks a number's range.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict
from itertools import pairwise
from math import inf
from typing import Annotated, Any, ClassVar, Literal, NamedTuple, TypeVar, cast, get_args

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, PlainSerializer, PlainValidator, model_validator
from pydantic.fields import FieldInfo

from solvers import FrictionLaw, SolverError, WearLaw
from solvers.laws.friction_law import friction_law
from solvers.laws.wear_law import wear_law
from wirewear.base.units import Quantity, finite_number
from wirewear.base.words import shown
from wirewear.effects import AnyEffect, effects_of_tables, tables_of_effects
from wirewear.test.materials import material_named

FORMAT = 1

_CYCLES = Quantity("cycles", 1, 1e9, whole=True)
AXIS = Quantity("deg", -180.0, 180.0)  #: Unit and range of the angle of a body's axis to the motion.

_FRICTION = '"coulomb" or a table such as { name = "shear-limited", shear_strength_MPa = 800.0 }'
_WEAR = '"energy" or a table such as { name = "energy-threshold", threshold_mJ_per_mm2 = 500.0 }'

#: The rest of a sentence that begins with a rotational stiffness.
NO_PIVOT = "says that the holder rotates, but pivot_height_mm, the height of its pivot above the contact, is missing"


def checked_format(value: object) -> int:
    """`value` if it is FORMAT, the only version of the file format; ValueError for any other value."""
    if value != FORMAT or isinstance(value, bool):
        raise ValueError(f"is {shown(value)}, but this version of wirewear reads format {FORMAT}")
    return FORMAT


def checked_text(value: object) -> str:
    """`value` if it is a text that is not blank; ValueError otherwise."""
    if not isinstance(value, str) or not value.strip():
        raise ValueError(f'is {shown(value)}, but must be a text such as "steel wires"')
    return value


def one_of(*words: str) -> Callable[[object], str]:
    """A function that returns its argument if it is one of `words`, and raises ValueError otherwise."""
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


def _checked_material(value: object) -> str:
    return material_named(value).name


Stated = TypeVar("Stated")


def with_constants_of_material(table: Stated) -> Stated | dict[str, object]:
    """The table with the elastic constants of the material that it names and, unless it states another yield stress,
    that and the hardening; unchanged if it is no mapping, or names no material or an unknown one. Raises ValueError if
    it states elastic constants other than the material's.
    """
    if not isinstance(table, Mapping) or table.get("material") is None:
        return table
    try:
        named = material_named(table["material"])
    except ValueError:
        return table  # to be refused at its key
    elastic = named.elastic
    constants = {"youngs_modulus_MPa": elastic.youngs_modulus_MPa, "poissons_ratio": elastic.poissons_ratio}
    for key, own in constants.items():
        if table.get(key, own) != own:
            raise ValueError(
                f"gives {key} = {shown(table[key])} beside the material {table['material']!r}, which has {own:g}: give "
                "the constants or the material, not both"
            )
    yields = dict(named.yields)
    stress = yields.get("yield_stress_MPa")
    return {**(yields if table.get("yield_stress_MPa", stress) == stress else {}), **table, **constants}


MaterialName = Annotated[str, PlainValidator(_checked_material)]
Effects = Annotated[tuple[AnyEffect, ...], PlainValidator(effects_of_tables), PlainSerializer(tables_of_effects)]
Diameter = Annotated[float, PlainValidator(Quantity("mm", 0.02, 20.0))]
Length = Annotated[float, PlainValidator(Quantity("mm", 0.05, 200.0))]
YoungsModulus = Annotated[float, PlainValidator(Quantity("MPa", 1e3, 1.5e6))]
YieldStress = Annotated[float, PlainValidator(Quantity("MPa", 5.0, 1e4))]
Hardening = Annotated[float, PlainValidator(Quantity("MPa", 0.0, 1e5))]
PoissonsRatio = Annotated[float, PlainValidator(Quantity("1", 0.0, 0.49))]
CrossingAngle = Annotated[float, PlainValidator(Quantity("deg", 5.0, 175.0))]
NormalLoad = Annotated[float, PlainValidator(Quantity("N", 1e-3, 1e4))]
AMPLITUDE_um = Quantity("um", 0.1, 5e3)
Amplitude = Annotated[float, PlainValidator(AMPLITUDE_um)]
AxisAngle = Annotated[float, PlainValidator(AXIS)]
MotionAngle = Annotated[float, PlainValidator(Quantity("deg", -90.0, 90.0))]
GripAngle = Annotated[float, PlainValidator(Quantity("deg", 12.0, 220.0))]
GripStiffness = Annotated[float | Literal["rigid"], PlainValidator(Quantity("N_per_mm3", 1.0, 1e9, words=("rigid",)))]
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
WornDepth = Annotated[float, PlainValidator(Quantity("um", 1e-3, 1e4))]
WornVolume = Annotated[float, PlainValidator(Quantity("mm3", 1e-9, 1e3))]
AccumulatedEnergy = Annotated[float, PlainValidator(Quantity("J", 1e-6, 1e9))]
HeldEnergy = Annotated[float, PlainValidator(Quantity("mJ", 1e-6, 1e6))]
Approach = Annotated[float, PlainValidator(Quantity("um", 1e-3, 1e3))]
SpringStiffness = Annotated[float, PlainValidator(Quantity("N_per_mm", 0.0, 1e5))]
ElementSize = Annotated[float, PlainValidator(Quantity("um", 0.1, 5e3))]
PressureLength = Annotated[float, PlainValidator(Quantity("um", 0.1, 5e3))]
IncrementsPerCycle = Annotated[int, PlainValidator(Quantity("1", 16, 4000, whole=True, multiple_of=4))]
ContactStates = Annotated[int, PlainValidator(Quantity("1", 0, 4000, whole=True))]
Tolerance = Annotated[float, PlainValidator(Quantity("1", 1e-6, 0.5))]
Refinement = Annotated[float, PlainValidator(Quantity("1", 0.25, 4.0))]
RelativeScatter = Annotated[float, PlainValidator(Quantity("1", 0.0, 0.3))]
AngleScatter = Annotated[float, PlainValidator(Quantity("deg", 0.0, 10.0))]
NodeMotion = Annotated[float, PlainValidator(Quantity("um", 0.0, 1e3))]
CycleList = Annotated[tuple[int, ...], BeforeValidator(_checked_cycle_list)]
CheckedFlag = Annotated[bool, PlainValidator(_checked_flag)]


Law = TypeVar("Law", FrictionLaw, WearLaw)


def _law_of(value: object, kind: type[Any], made: Callable[[str, Mapping[str, float]], Law], example: str) -> Law:
    """The law that a key's value describes; ValueError if it describes none.

    kind: base class of the laws.  made: makes one from name and parameters.  example: for messages.
    """
    if isinstance(value, kind):
        return cast("Law", value)
    table = {"name": value} if isinstance(value, str) else value
    if not isinstance(table, dict) or not isinstance(table.get("name"), str):
        raise ValueError(f"is {shown(value)}, but must be {example}")
    parameters = {key: number for key, number in table.items() if key != "name"}
    for key, number in parameters.items():
        try:
            parameters[key] = finite_number(number)
        except ValueError as problem:
            raise ValueError(f"gives {key}, which {problem}") from None
    try:
        return made(table["name"], parameters)
    except SolverError as problem:
        raise ValueError(f"is {shown(value)}: {problem}") from None


def _described(law: FrictionLaw | WearLaw) -> str | dict[str, Any]:
    parameters = asdict(law)
    return {"name": law.name, **parameters} if parameters else law.name


#: A key that takes a friction law.
FrictionLawKey = Annotated[
    FrictionLaw,
    PlainValidator(lambda value: _law_of(value, FrictionLaw, friction_law, _FRICTION)),
    PlainSerializer(_described),
]

#: A key that takes a wear law.
WearLawKey = Annotated[
    WearLaw, PlainValidator(lambda value: _law_of(value, WearLaw, wear_law, _WEAR)), PlainSerializer(_described)
]


def pairs_of(
    value: object, example: str, least: float = -inf, *, given: str = "is", must: str = "be a list of"
) -> tuple[tuple[float, float], ...]:
    """The pairs of a list as floats, all finite and at least `least`; ValueError otherwise.
    The message follows a key's name: `given` is its verb, `must` comes before "pairs such as" and `example`.
    """
    points = []
    for item in value if isinstance(value, list | tuple) else [None]:
        pair = item if isinstance(item, list | tuple) else []
        if len(pair) != 2 or any(isinstance(x, bool) or not isinstance(x, int | float) or x < least for x in pair):
            raise ValueError(f"{given} {shown(value)}, but must {must} pairs such as {example}")
        try:
            points.append((finite_number(pair[0]), finite_number(pair[1])))
        except ValueError as problem:
            raise ValueError(f"{given} {shown(value)}, one of whose numbers {problem}") from None
    return tuple(points)


def _checked_points(value: object) -> tuple[tuple[float, float], ...]:
    points = pairs_of(value, "[[0, 1.0], [10000, 0.5]]", 0.0)
    if any(not later[0] > earlier[0] for earlier, later in pairwise(points)):
        raise ValueError(f"is {shown(value)}, but the first numbers of its pairs must increase")
    return points


Points = Annotated[tuple[tuple[float, float], ...], BeforeValidator(_checked_points)]


class Table(BaseModel):
    """A table of keys of a TOML file as an immutable value; an unknown key raises pydantic's ValidationError."""

    # Checks are built when a table is first read: those of most kinds of contact are never.
    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    #: What to do in place of an unknown key that belongs to tables of another kind, by the key.
    elsewhere: ClassVar[Mapping[str, str]] = {}


def merged(base: Mapping[str, object], overrides: Mapping[str, object]) -> dict[str, object]:
    """A new nested table: `base`, with the values of `overrides` in place of its own at every level."""
    whole = dict(base)
    for key, value in overrides.items():
        below = whole.get(key)
        whole[key] = merged(below, value) if isinstance(value, Mapping) and isinstance(below, Mapping) else value
    return whole


def values_in_no_variant(tables: Table, variants: Sequence[Table]) -> Iterator[tuple[str, str, object]]:
    """Yields (table, key, value) of what `tables` state but every variant states otherwise; nothing without any."""
    for name in sorted(tables.model_fields_set):
        own = getattr(tables, name)
        for key in sorted(own.model_fields_set) if isinstance(own, Table) and variants else ():
            value = getattr(own, key)
            if all(getattr(getattr(other, name), key, None) != value for other in variants):
                yield name, key, value


class OfMaterial(Table):
    """A table of elastic constants, which may name a material of materials.toml instead of stating them."""

    @model_validator(mode="before")
    @classmethod
    def _with_constants(cls, table: object) -> object:
        found = with_constants_of_material(table)
        if found is table or not isinstance(found, Mapping):
            return table
        known = set(cls.model_fields) | set(table if isinstance(table, Mapping) else ())
        return {key: own for key, own in found.items() if key in known}


class NamedTable(Table):
    """The keys with which every study file begins: version of the format, and title."""

    format: Annotated[int, PlainValidator(checked_format)] = Field(
        description="version of this file's format", examples=[FORMAT]
    )
    name: Annotated[str, PlainValidator(checked_text)] = Field(
        description="title of the study", examples=["steel wires"]
    )


def quantity_of(field: FieldInfo) -> Quantity | None:
    """The `Quantity` (unit and range) that checks a key's number; None if the key does not hold a number."""
    inside_optional = [item for part in get_args(field.annotation) for item in getattr(part, "__metadata__", ())]
    for item in [*field.metadata, *inside_optional]:
        if isinstance(item, PlainValidator) and isinstance(item.func, Quantity):
            return item.func
    return None


def table_of(field: FieldInfo) -> type[Table] | None:
    """The class of the table that a key holds, or of the tables in a list that it holds; None if it holds neither."""
    held = get_args(field.annotation)
    candidates: tuple[Any, ...] = (field.annotation, *held, *(item for one in held for item in get_args(one)))
    return next((c for c in candidates if isinstance(c, type) and issubclass(c, Table)), None)


class Inconsistency(NamedTuple):
    """A contradiction between the keys of a study. keys: the path from the top of the file to one of them; problem: the
    rest of a sentence that begins with that key.
    """

    keys: tuple[str, ...]
    problem: str
