"""Studies of all kinds as immutable values: their tables, variants, blocks of cycles, and copies with changed values.

A key is named with the tables above it, as "conditions.normal_load_N". A variant replaces some of a study's values; a
block is a number of cycles under conditions of its own. A resolved study states every value, defaults included.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, Generic, Self, cast

from typing_extensions import TypeVar

from solvers import Drive, FrictionLaw, WearLaw
from wirewear.base.errors import StudyError
from wirewear.base.frame import notebook_table
from wirewear.base.words import as_sentence, counted, shown
from wirewear.effects import AnyEffect, effects_of_tables
from wirewear.test.conditions import Log
from wirewear.test.consistency import checked_tables, default_loop_cycles, inconsistency
from wirewear.test.keys import Table, merged, values_in_no_variant
from wirewear.test.life import LifeTable, material_of_body
from wirewear.test.messages import validated
from wirewear.test.programme import Schedule, as_driven, placed, worked_cycles
from wirewear.test.surfaces import LayerTable
from wirewear.test.tables import CommonTables

LOGGED = "log.loop_cycles"  #: The key that is adapted to the length of the test unless a study states it.

AnyTable = TypeVar("AnyTable", bound=Table)
Same = TypeVar("Same", bound=CommonTables)


def with_values(tables: Same, values: Mapping[str, object], where: str) -> Same:
    """A checked copy of the tables with these values by their keys with dots; None sets a key to its default.
    If the length of the test changes, recorded cycles beyond its end are dropped and its last is added. where: name of
    the tables for messages. Raises StudyError, in one sentence, if a key does not exist or its value is not allowed.
    """
    data = tables.model_dump(mode="json", exclude_none=True)
    values = dict(tables.known_as(key, value) for key, value in values.items())
    for key, value in values.items():
        _put(data, key, value, where)
    if "conditions.cycles" in values and LOGGED not in values:
        data["log"]["loop_cycles"] = _as_far(tables, values["conditions.cycles"])
    return cast("Same", checked_tables(data, where))


def value_at(tables: CommonTables, key: str) -> Any:
    """The value of a key with dots, as JSON holds it; None if the tables have no such key."""
    here: Any = tables.model_dump(mode="json")
    for part in tables.known_as(key, None)[0].split("."):
        here = here.get(part) if isinstance(here, Mapping) else None
    return here


def _as_far(tables: CommonTables, end: object) -> list[int]:
    """The cycles to record in a test that ends at another cycle; an empty list lets the program choose."""
    logged = tables.log.loop_cycles
    if not isinstance(end, int) or logged == default_loop_cycles(tables.conditions.cycles):
        return []
    return [*logged, end]


def _put(data: dict[str, Any], key: str, value: Any, where: str) -> None:
    *path, last = key.split(".")
    here = data
    for part in path:
        inner = here.setdefault(part, {})
        if not isinstance(inner, dict):
            raise StudyError(f"{shown(part)} in the key {shown(key)} for {where} is no table but a value.")
        here = inner
    if value is None:
        here.pop(last, None)
    else:
        here[last] = value


Tables_co = TypeVar("Tables_co", bound=CommonTables, default=CommonTables, covariant=True)


T_co = TypeVar("T_co", covariant=True)


class _OfTables(Generic[T_co]):
    """An attribute of a study that its tables hold under the same name."""

    def __set_name__(self, _study: type, name: str) -> None:
        self.name = name

    def __get__(self, study: AnyStudy, _type: type) -> T_co:
        value: T_co = getattr(study.tables, self.name)
        return value


@dataclass(frozen=True, repr=False)
class AnyStudy(Generic[Tables_co]):
    """A checked study of a test. tables: its own values; variants: pairs (name, complete tables) in the file's order.
    variant_name: name of the variant that this study was taken from; empty for the study of a whole file.
    """

    tables: Tables_co
    variants: tuple[tuple[str, Tables_co], ...] = ()
    variant_name: str = ""

    name = _OfTables[str]()
    kind = _OfTables[str]()  #: Kind of contact, as the file states it.
    contact_kind = _OfTables[str]()  #: Kind of contact, as results and records name it.
    conditions = _OfTables[Any]()  #: Load, stroke, frequency and length of the test.
    contact = _OfTables[Any]()  #: Friction.
    wear = _OfTables[Any]()  #: Wear law, or None when nothing wears.
    holder = _OfTables[Any]()  #: Stiffness of the rig and of the loading train.
    mesh = _OfTables[Any]()  #: Extent of the fine mesh.
    laws = _OfTables[tuple[FrictionLaw | WearLaw, ...]]()  #: The friction law and, if the test wears, the wear law.
    layers = _OfTables[dict[str, tuple[LayerTable, ...]]]()  #: Coatings and hard skins on both bodies, by their names.
    drive = _OfTables[Drive]()  #: Displacement, load and bulk stresses in the course of a cycle.
    effects = _OfTables[tuple[AnyEffect, ...]]()  #: Effects that the nominal model lacks.
    log = _OfTables[Log]()  #: Which cycles are recorded.
    worn_per_cycle = _OfTables[float]()

    @property
    def body_names(self) -> tuple[str, ...]:
        """(driven, held): names of the bodies; empty for a joint."""
        return tuple(self.layers)

    @property
    def driven(self) -> Self:
        """A copy with conditions and blocks as effects on the drive change them; the study itself if none does."""
        conditions, blocks = as_driven(self.conditions, self.tables.programme, self.effects)
        if conditions is self.conditions:
            return self
        return replace(self, tables=self.tables.model_copy(update={"conditions": conditions, "programme": blocks}))

    @cached_property
    def schedule(self) -> Schedule[Self]:
        """The test as stretches of cycles, each with the study of the conditions in it."""
        alone = replace(self, tables=self.tables.model_copy(update={"programme": ()}))
        return Schedule(self.tables.programme, self.conditions.cycles, alone, partial(_under, alone))

    @cached_property
    def envelope(self) -> Self:
        """A study without programme for sizing meshes: the largest load, stroke and friction of all blocks, and as many
        cycles as wear the total volume of all. The study itself if it has no programme.
        """
        if not self.tables.programme:
            return self
        stretches = self.schedule.stretches
        worst = max((own.study for own in stretches), key=lambda study: study.worn_per_cycle)
        conditions = {
            key: max(getattr(own.study.conditions, key) for own in stretches)
            for key in ("normal_load_N", "displacement_amplitude_um")
        }
        friction = max(own.study.contact.friction for own in stretches)
        largest = worst.changed({"conditions": conditions, "contact": {"friction": friction}})
        cycles = worked_cycles(stretches, largest.worn_per_cycle)
        return largest.changed({"conditions": {"cycles": cycles}})

    @property
    def runs(self) -> tuple[Tables_co, ...]:
        """The tables of every block of every variant (of the study itself, if it has none), each once."""
        own = [self.variant(name) for name in self.variant_names] or [self]
        every = (stretch.study for each in own for stretch in each.schedule.stretches)
        return tuple({id(study): study.tables for study in every}.values())

    def given(self) -> dict[str, Any]:
        """The nested tables as the file states them, without defaults and variants, ready for JSON."""
        return self.tables.model_dump(mode="json", exclude_none=True, exclude_unset=True)

    def logging(self, cycles: tuple[int, ...]) -> Self:
        """A copy that records the loops of these cycles, in its variants as well."""
        variants = tuple(
            (name, tables.model_copy(update={"log": tables.log.of_cycles(cycles)})) for name, tables in self.variants
        )
        own = self.tables.model_copy(update={"log": self.tables.log.of_cycles(cycles)})
        return replace(self, tables=own, variants=variants)

    def unused_values(self) -> Iterator[tuple[str, str, object]]:
        """Yields (table, key, value) of what the file states for the whole study but every variant overrides."""
        return values_in_no_variant(self.tables, [tables for _, tables in self.variants])

    def changed(self, changes: Mapping[str, object]) -> Self:
        """A copy without variants, with the values of `changes`, nested by table; they are not checked."""
        return type(self)(_changed(self.tables, changes), variant_name=self.variant_name)

    def with_values(self, values: Mapping[str, object]) -> Self:
        """A checked copy with values by their keys with dots, as {"conditions.normal_load_N": 4}, in its variants as
        well; None sets a key to its default. Raises StudyError if a key does not exist, its value is not allowed, or
        variants state the key differently.
        """
        name = self.name if not self.variant_name else f"{self.name}, variant {self.variant_name}"
        where = f"the study {name!r}"
        for key in values:
            own = [one for one, tables in self.variants if value_at(tables, key) != value_at(self.tables, key)]
            if own:
                raise StudyError(
                    f"{key} of {where} is stated by its variants {', '.join(own)}: take one of them first, as in "
                    f'study.variant("{own[0]}").'
                )
        variants = tuple((one, with_values(tables, values, f"{where}, variant {one}")) for one, tables in self.variants)
        return type(self)(with_values(self.tables, values, where), variants, self.variant_name)

    def with_effects(self, *effects: AnyEffect) -> Self:
        """A copy without variants, with these effects in place of its own. Raises StudyError if an effect is given
        twice, or contradicts another key of the study.
        """
        try:
            study = self.changed({"effects": effects_of_tables(effects)})
        except ValueError as problem:
            raise StudyError(as_sentence(f"effects of the study {self.name!r} {problem}")) from None
        contradiction = inconsistency(study.tables)
        if contradiction is not None:
            raise StudyError(f"{contradiction.keys[-1]} of the study {self.name!r} {contradiction.problem}.")
        return study

    @property
    def stated(self) -> dict[str, float]:
        """Every number in the study's tables by its key with dots, in the unit of the key, defaults included."""
        return dict(_numbers(_plain(self.tables), ()))

    @property
    def variant_names(self) -> tuple[str, ...]:
        """Names of the variants in the file's order; empty for a study without variants."""
        return tuple(name for name, _ in self.variants)

    def variant(self, name: str) -> Self:
        """A variant as a study of its own, by its name. Raises StudyError if there is no such variant."""
        for own, tables in self.variants:
            if own == name:
                return type(self)(tables, variant_name=name)
        known = f"its variants are {', '.join(self.variant_names)}" if self.variants else "it has no variants"
        raise StudyError(f"the study {self.name!r} has no variant {name!r}: {known}.")

    def __repr__(self) -> str:
        own = f", variant {self.variant_name!r}" if self.variant_name else ""
        variants = f", variants {', '.join(self.variant_names)}" if self.variants else ""
        c = self.conditions
        return (
            f"<{type(self).__name__} {self.name!r}{own}: {c.normal_load_N:g} N, ±{c.displacement_amplitude_um:g} µm, "
            f"{counted(c.cycles)} cycles{variants}>"
        )

    def _repr_html_(self) -> str:
        rows = dict(_written(_plain(self.tables), ()))
        if self.variants:
            rows["variants"] = ", ".join(self.variant_names)
        return notebook_table(self.name, rows)

    def resolved(self) -> dict[str, Any]:
        """Nested tables of all keys, defaults and variants included, ready for JSON and for `study_from_tables`."""
        data = _plain(self.tables)
        if self.variants:
            data["variants"] = {
                name: {
                    key: table for key, table in _plain(tables).items() if isinstance(table, dict) or key == "effects"
                }
                for name, tables in self.variants
            }
        return data


Of = TypeVar("Of", bound=AnyStudy)


def alone(study: Of, how: str = "choose one with --variant") -> Of:
    """The study itself; StudyError if it has variants. how: advice at the end of that message on how to choose a
    variant; {first} in it becomes the name of the first one.
    """
    if study.variant_names:
        how = how.replace("{first}", study.variant_names[0])
        raise StudyError(f"the study {study.name!r} has the variants {', '.join(study.variant_names)}: {how}.")
    return study


def life_data(
    study: AnyStudy, bodies: Iterable[str], values: Mapping[str, object] | None = None
) -> dict[str, LifeTable]:
    """The table [life] for each of these bodies, by name: as the study states it, with `values` of its keys in place,
    and completed by the fatigue data of the body's material.
    Raises StudyError if a value is not allowed, or data that the criterion needs are missing.
    """
    tables = study.tables.model_dump(mode="json", exclude_none=True, exclude_unset=True)
    where = f"[life] of {(study.variant_name or study.name)!r}"
    asked = validated(LifeTable, tables.get("life", {}) | dict(values or {}), where, StudyError)
    found = {body: asked.of_material(material_of_body(tables, body)) for body in bodies}
    for table in found.values():
        table.required(*table.needed)
    return found


def _under(alone: Any, values: Mapping[str, Any]) -> Any:
    """The study without a programme, under the conditions of a block."""
    tables = alone.tables.model_dump(mode="json", exclude_none=True)
    tables = merged(tables, placed(values, tables))
    return replace(alone, tables=checked_tables(tables, f"the study {alone.name!r}"))


def _changed(table: AnyTable, changes: Mapping[str, Any]) -> AnyTable:
    values = {
        key: _changed(getattr(table, key), value) if isinstance(value, Mapping) else value
        for key, value in changes.items()
    }
    return table.model_copy(update=values)


def _plain(tables: CommonTables) -> dict[str, Any]:
    return tables.model_dump(mode="json", exclude_none=True)


def _written(table: Mapping[str, Any], place: tuple[str, ...]) -> Iterator[tuple[str, str]]:
    """Every key with dots and its value as text; empty tables and lists are left out."""
    for key, value in table.items():
        if isinstance(value, Mapping):
            yield from _written(value, (*place, key))
        elif value not in ([], ()):
            yield ".".join((*place, key)), str(value)


def _numbers(table: Mapping[str, Any], place: tuple[str, ...]) -> Iterator[tuple[str, float]]:
    for key, value in table.items():
        if isinstance(value, Mapping):
            yield from _numbers(value, (*place, key))
        elif isinstance(value, int | float) and not isinstance(value, bool):
            yield ".".join((*place, key)), float(value)
