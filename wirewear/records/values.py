"""Experiment record as a value: loops of each repeat and cycle, evolution, worn surfaces.

A programme is a sequence of blocks of cycles, each under its own conditions.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Generic, TypeAlias

import numpy as np
from typing_extensions import TypeVar

from geometry.arrays import Array, BoolArray
from wirewear.base.errors import RecordError
from wirewear.base.files import table_of
from wirewear.loops import LoopFigures, LoopSignals, analyse_loop
from wirewear.records.contact_tables import AnyTables, LineRecordTables
from wirewear.records.profiles import MeasuredProfile
from wirewear.records.scars import MeasuredScar
from wirewear.records.tables import RecordTables, StatedRig
from wirewear.test import study_from_tables
from wirewear.test.conditions import held_by
from wirewear.test.messages import validated
from wirewear.test.programme import Schedule, worked_course

#: What changes over the cycles, as keys of `[stated]` and as effects of a study.
_EVOLUTIONS = ("friction_evolution", "wear_rate_evolution")

_OF_THE_CONTACT = ("friction", *_EVOLUTIONS)


# Shares of a loop's force and stroke: within the first a test stands at rest, and beyond the last, which is what even
# little slip leaves of the friction force, a cycle that began so does not close.
_AT_REST, _ENDS_APART, _FEWEST_SAMPLES = 0.15, 0.3, 16

#: Where a record has what a block of a programme states in its tables, but for bulk stresses, which no loop shows.
_IN_TABLE = {"conditions": "conditions", "contact": "stated", "wear": "stated"}


def stated_study(tables: AnyTables, more: Mapping[str, object] | None = None) -> Any:
    """Study of the record's test as its owner states it.

    more: further tables of the study, such as log and mesh. Raises RecordError if friction or wear is not stated, or
    friction is stated twice and differently; StudyError if the statements do not fit together.
    """
    friction = stated_friction(tables)
    for lacking in tables.missing:
        raise RecordError(
            f"[stated] of the record {tables.name!r} does not give {lacking}, without which there is no model to "
            "diagnose: add it, or fit the record (`wirewear fit`) and give the fitted study by --model."
        )
    data = stated_tables(tables, friction or 0.0) | dict(more or {})
    return study_from_tables(data, f"the nominal model of the record {tables.name!r}")


def stated_friction(tables: AnyTables) -> float | None:
    """Coefficient of friction after running-in; None if unstated.

    Raises RecordError if it is stated twice and differently.
    """
    stated: StatedRig = tables.stated
    evolution = stated.friction_evolution
    if evolution is not None and stated.friction not in (None, evolution.final):
        raise RecordError(
            f"[stated] of the record {tables.name!r} gives friction = {stated.friction:g}, but final = "
            f"{evolution.final:g} in friction_evolution: leave friction out, or make them equal."
        )
    return stated.final_friction


def stated_tables(tables: AnyTables, friction: float) -> dict[str, object]:
    """Tables of a study of the record's test with this coefficient of friction; bodies with unstated wear do not
    wear.
    """
    stated = tables.stated.model_dump(mode="json", exclude_unset=True, exclude_none=True)
    rig = {key: stated[key] for key in StatedRig.model_fields if key in stated and key not in _OF_THE_CONTACT}
    wear = {key: stated[key] for key in (*type(tables.stated).WEAR, "law") if key in stated}
    wears = any("_wear_coefficient_" in key for key in wear)
    effects = [{"name": key, **stated[key]} for key in _EVOLUTIONS if key in stated]
    programme = [
        {"cycles": block.cycles, **block.values, **({"name": block.name} if block.name else {})}
        for block in tables.programme
    ]
    data: dict[str, Any] = {
        "format": 1,
        "name": tables.name,
        "kind": tables.contact_kind,
        "conditions": tables.conditions.model_dump(mode="json", exclude={"drive"}, exclude_none=True),
        "contact": {"friction": friction},
        "holder": rig or {"tangential_stiffness_N_per_mm": "rigid"},
        **({"wear": wear} if wears else {}),
        **({"effects": effects} if effects else {}),
        **({"programme": programme} if programme else {}),
    }
    whole: dict[str, Any] = tables.with_bodies(data)
    return whole


@dataclass(frozen=True, eq=False)
class MeasuredLoop:
    """Loop of one cycle of one repeat as the sensors read it, in the order of its n samples; NaN is a missing sample.

    time_s: from the start of the cycle. tangential_force_N: positive when it resists motion in +x. normal_force_N: None
    if not measured.
    """

    repeat: int
    cycle: int
    time_s: Array
    displacement_um: Array
    tangential_force_N: Array
    normal_force_N: Array | None
    _analysed: dict[float | None, LoopFigures] = field(default_factory=dict, init=False, repr=False)

    @property
    def name(self) -> str:
        return f"repeat {self.repeat}, cycle {self.cycle}"

    @property
    def complete(self) -> "MeasuredLoop":
        """Copy of the loop without the samples that lack a channel."""
        channels = [self.time_s, self.displacement_um, self.tangential_force_N]
        if self.normal_force_N is not None:
            channels.append(self.normal_force_N)
        keep: BoolArray = np.logical_and.reduce([np.isfinite(channel) for channel in channels])
        return self if keep.all() else self.taken(keep)

    @property
    def begins_at_rest(self) -> bool:
        """True if the loop goes from rest to one end first and so does not close, as a test's first cycle may."""
        whole = self.complete
        x, q = whole.displacement_um, whole.tangential_force_N
        if x.size < _FEWEST_SAMPLES:
            return False
        (x_low, x_high), (q_low, q_high) = (np.percentile(one, (1.0, 99.0)) for one in (x, q))
        reach, force = 0.5 * (x_high - x_low), 0.5 * (q_high - q_low)
        rests = abs(q[0]) < _AT_REST * force and abs(x[0] - 0.5 * (x_low + x_high)) < _AT_REST * reach
        return bool(rests and abs(q[-1] - q[0]) > _ENDS_APART * force)

    def taken(self, keep: BoolArray) -> "MeasuredLoop":
        """Copy of the loop with the samples marked in `keep` (n,)."""
        normal = None if self.normal_force_N is None else self.normal_force_N[keep]
        channels = (self.time_s[keep], self.displacement_um[keep], self.tangential_force_N[keep], normal)
        return MeasuredLoop(self.repeat, self.cycle, *channels)

    def signals(self, period_s: float | None = None) -> LoopSignals:
        """Channels of the loop as input for a sensor model; period_s: duration of the cycle, None if unknown."""
        return LoopSignals(self.time_s, self.displacement_um, self.tangential_force_N, self.normal_force_N, period_s)

    def read_as(self, signals: LoopSignals) -> "MeasuredLoop":
        """Copy of the loop with the displacements, tangential and normal forces of `signals`, at the same times."""
        return replace(
            self,
            displacement_um=signals.displacement_um,
            tangential_force_N=signals.tangential_force_N,
            normal_force_N=signals.normal_force_N,
        )

    def figures(self, normal_load_N: float | None = None) -> LoopFigures:
        """Figures of the loop, computed once; normal_load_N: stands in for a normal force that was not measured. Raises
        LoopError if the samples cannot be analysed.
        """
        if normal_load_N not in self._analysed:
            loop = self.complete
            normal = normal_load_N if loop.normal_force_N is None else loop.normal_force_N
            signals = loop.displacement_um, loop.tangential_force_N, normal
            figures = analyse_loop(*signals, time_s=loop.time_s, cycle=loop.cycle)
            self._analysed[normal_load_N] = figures
        return self._analysed[normal_load_N]


@dataclass(frozen=True, eq=False)
class MeasuredEvolution:
    """Figures of one repeat over the cycles, as columns (n,) by name; `columns["cycle"]` increases, NaN is a missing
    value.
    """

    repeat: int
    columns: Mapping[str, Array]


#: Tables of a record and its worn surfaces; where nothing is said, those of crossed wires.
Tables = TypeVar("Tables", bound="AnyTables", default=RecordTables)
Surface = TypeVar("Surface", bound="MeasuredScar | MeasuredProfile", default=MeasuredScar)


def _schedule(tables: Any) -> Schedule[Any]:
    """Blocks of a record's programme in turn, each with the tables of a test under that block's conditions only."""

    def under(values: Mapping[str, object]) -> Any:
        own: dict[str, Any] = {}
        for name in [one for one in _IN_TABLE if one in values]:
            more, table = table_of(values, name), _IN_TABLE[name]
            before = own.get(table, getattr(tables, table))
            data = {**before.model_dump(exclude_unset=True), **more}
            own[table] = validated(type(before), data, f"a block of the programme of {tables.name!r}", RecordError)
        return tables.model_copy(update=own)

    blocks = tables.programme
    changed = {name: {key for block in blocks for key in getattr(block, name)} for name in _IN_TABLE}
    whole = []
    for block in blocks:
        given = under(block.values)
        states = {
            name: {key: getattr(getattr(given, _IN_TABLE[name]), key) for key in keys} for name, keys in changed.items()
        }
        whole.append(block.model_copy(update=states))
    tables = tables.model_copy(update={"programme": tuple(whole)})
    return Schedule(tables.programme, tables.conditions.cycles, tables, under)


def _energies_mJ(evolution: Sequence[MeasuredEvolution], schedule: Schedule[Any]) -> dict[int, float]:
    """Friction energy per cycle in mJ of each block, as the median of measured values.

    If a block has none, all get the friction work of gross slip on a rigid rig, of which only ratios are meaningful.
    """
    found: dict[int, float] = {}
    for block in sorted({one.block for one in schedule.stretches}):
        rows = [_rows(one, schedule, block).columns.get("dissipated_energy_mJ", np.zeros(0)) for one in evolution]
        measured = np.concatenate([np.zeros(0), *rows])
        if not (measured > 0.0).any():
            break
        found[block] = float(np.nanmedian(measured))
    else:
        return found
    for one in schedule.stretches:
        friction_N = one.study.conditions.normal_load_N * (one.study.stated.friction or 1.0)
        found[one.block] = float(friction_N * _stroke_um(one.study))
    return found


def _stroke_um(tables: Any) -> float:
    """Displacement amplitude in µm: as asked for, or as the held quantity gives on a rigid rig."""
    asked, friction = tables.conditions, tables.stated.friction or 1.0
    held, largest = held_by(asked), asked.displacement_amplitude_um
    return float(largest if held is None else held.first_um(friction * asked.normal_load_N, 0.0, largest))


def _rows(evolution: MeasuredEvolution, schedule: Schedule[Any], block: int) -> MeasuredEvolution:
    own = np.array([schedule.at(cycle).block == block for cycle in evolution.columns["cycle"]], dtype=bool)
    return replace(evolution, columns={name: column[own] for name, column in evolution.columns.items()})


@dataclass(frozen=True, eq=False)
class ExperimentRecord(Generic[Tables, Surface]):
    """Experiment record of format 1.

    loops: sorted by repeat and cycle. scars: worn surfaces at the end, maps or profiles of a line contact, whose forces
    and energies are of the whole contact. notes: sentences on what was ignored in reading. path: its folder, None if it
    was not read. block: number of the chosen block of its programme, None for the whole test. worked: pairs of a cycle
    of the test and of the number of that block's cycles that dissipate as much energy. within_longer_strokes: True if
    other blocks have longer strokes.
    """

    tables: Tables
    loops: tuple[MeasuredLoop, ...] = ()
    evolution: tuple[MeasuredEvolution, ...] = ()
    scars: tuple[Surface, ...] = ()
    notes: tuple[str, ...] = ()
    path: Path | None = None
    block: int | None = None
    worked: tuple[tuple[float, float], ...] = ()
    within_longer_strokes: bool = False

    def of_block(self, number: int | None = None) -> "ExperimentRecord[Tables, Surface]":
        """Part of the record measured under one block of its programme: loops, evolution, and the scars if no other
        block has a longer stroke.

        number: from 1; None for the block with the longest stroke and most loops. A record without a programme, or of
        one block already, is returned unchanged. Raises RecordError if there is no loop of that block.
        """
        tables: Any = self.tables
        if not tables.programme or self.block is not None:
            return self
        schedule = _schedule(tables)
        belongs = [schedule.at(loop.cycle).block for loop in self.loops]
        strokes = {one.block: _stroke_um(one.study) for one in schedule.stretches}
        chosen = number or max(sorted(set(belongs)), key=lambda one: (strokes[one], belongs.count(one)), default=1)
        if chosen not in belongs:
            known = ", ".join(map(str, sorted(set(belongs)))) or "none"
            raise RecordError(
                f"the record {self.name!r} has no loop of block {chosen} of its programme: it has loops of {known}."
            )
        own: Any = next(one.study for one in schedule.stretches if one.block == chosen)
        spent = _energies_mJ(self.evolution, schedule)
        worked = worked_course(schedule.stretches, lambda one: spent[one.block] / spent[chosen])
        note = f"of block {chosen} of the programme: the others enter by what they wear"
        shapes = strokes[chosen] == max(strokes.values())
        note += "" if shapes else ", and scars of their longer strokes are left out"
        return replace(
            self,
            tables=own,
            loops=tuple(loop for loop, block in zip(self.loops, belongs, strict=True) if block == chosen),
            evolution=tuple(_rows(one, schedule, chosen) for one in self.evolution),
            scars=self.scars if shapes else (),
            notes=(*self.notes, note),
            block=chosen,
            worked=worked,
            within_longer_strokes=not shapes,
        )

    def blocks(self) -> "tuple[ExperimentRecord[Tables, Surface], ...]":
        """What was measured under each block of the record's programme: first as `of_block` gives it, then the other
        blocks that have loops, without scars. Alone for a record without a programme, or of one block already.
        """
        first = self.of_block()
        if first is self:
            return (self,)
        schedule = _schedule(self.tables)
        others = {schedule.at(loop.cycle).block for loop in self.loops} - {first.block}
        return first, *(replace(self.of_block(number), scars=()) for number in sorted(others))

    def working_cycles(self, cycles: Array) -> Array:
        """Numbers (n,) of the chosen block's cycles that dissipate as much energy as the test's first `cycles` (n,)."""
        return np.interp(cycles, *np.array(self.worked).T) if self.worked else cycles

    @property
    def contact_kind(self) -> str:
        return self.tables.contact_kind

    @property
    def name(self) -> str:
        return self.tables.name

    @property
    def repeats(self) -> tuple[int, ...]:
        """Numbers of the repeats that have loops, or any data if the kind of record may lack loops."""
        parts: tuple[Any, ...] = (*self.loops, *(() if self.tables.needs_loops else (*self.evolution, *self.scars)))
        return tuple(sorted({one.repeat for one in parts}))

    @property
    def cycles(self) -> tuple[int, ...]:
        return tuple(sorted({loop.cycle for loop in self.loops}))

    def loops_at(self, cycle: int) -> tuple[MeasuredLoop, ...]:
        """Loops of a cycle, one for each repeat that has it; empty if none has."""
        return tuple(loop for loop in self.loops if loop.cycle == cycle)

    def loop(self, repeat: int, cycle: int) -> MeasuredLoop:
        """Loop of this repeat and cycle. Raises RecordError if there is none."""
        for loop in self.loops:
            if (loop.repeat, loop.cycle) == (repeat, cycle):
                return loop
        raise RecordError(f"the record {self.name!r} has no loop of repeat {repeat} at cycle {cycle}.")

    def scars_of(self, body: str) -> tuple[Surface, ...]:
        """Worn surfaces of a body, one for each repeat that has it."""
        return tuple(scar for scar in self.scars if scar.body == body)

    @property
    def worn_volumes_mm3(self) -> dict[str, dict[int, float]]:
        """Worn volumes in mm³ of the whole contact, by body and then by repeat."""
        length = self.tables.length_mm
        return {
            body: {one.repeat: one.volume_of(length) for one in self.scars_of(body)} for body in self.tables.body_names
        }


LineRecord: TypeAlias = ExperimentRecord[LineRecordTables, MeasuredProfile]
AnyRecord: TypeAlias = ExperimentRecord[Any, Any]
