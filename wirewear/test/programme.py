"""A test's programme: blocks of cycles under conditions of their own, repeated in turn for as long as the test lasts.

A stretch or a stage is a range of cycles under one block's conditions: after `start`, up to and with `end`. A turn is
one pass through all blocks. A block's number is from 1 in a programme, its index from 0.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import cycle
from math import ceil
from typing import Annotated, Any, Generic, Self, TypeVar

from pydantic import Field, PlainValidator

from wirewear.base.words import counted, shown
from wirewear.effects import Age, Control, Seam, applied
from wirewear.effects.seams import ChangesASeam
from wirewear.test import keys
from wirewear.test.conditions import held_keys

AnyStudy = TypeVar("AnyStudy")

#: Keys that a block may not change: the length of the whole test, its bodies, and how it is computed.
_OF_THE_TEST = {
    "conditions": ("cycles", "motion_angle_deg", "approach_um"),
    "contact": ("formulation", "primary_wire", "length_mm"),
    "wear": ("update", "explicit_jump_cycles"),
    "bulk": (),
    "holder": (),
}
_AMPLITUDE = "displacement_amplitude_um"
MOST_BLOCKS = 10_000  #: Most blocks of a test, repeated ones counted; each takes a cycle jump at least.


def _values_of(table: str) -> PlainValidator:
    def check(value: object) -> dict[str, object]:
        if not isinstance(value, Mapping):
            raise ValueError(f"is {shown(value)}, but must be a table such as {{ normal_load_N = 2.0 }}")
        fixed = next((key for key in _OF_THE_TEST[table] if key in value), None)
        if fixed is not None:
            raise ValueError(f"holds {fixed}, which is the same for the whole test: state it in [{table}]")
        return dict(value)

    return PlainValidator(check)


Values = dict[str, Any]


class CycleBlock(keys.Table):
    """Keys of a block of cycles; values that it does not state are those of the study."""

    name: Annotated[str, PlainValidator(keys.checked_text)] | None = Field(None, description="what the block is called")
    cycles: keys.Cycles = Field(description="length of the block", examples=[1000])
    conditions: Annotated[Values, _values_of("conditions")] = Field({}, description="load, stroke and frequency in it")
    contact: Annotated[Values, _values_of("contact")] = Field({}, description="friction in it, as where it is greased")
    wear: Annotated[Values, _values_of("wear")] = Field({}, description="wear in it")
    bulk: Annotated[Values, _values_of("bulk")] = Field({}, description="bulk stress in it, by the bodies' names")

    @property
    def values(self) -> dict[str, Values]:
        """The tables that the block states, by name; those that are empty are left out."""
        return {name: own for name in _OF_THE_TEST if (own := getattr(self, name, None))}


class RiggedBlock(CycleBlock):
    """Keys of a block of a study's programme, in which the rig may be another one, too."""

    holder: Annotated[Values, _values_of("holder")] = Field({}, description="stiffness of the rig in it")


def placed(values: Mapping[str, Values], tables: Mapping[str, object]) -> dict[str, object]:
    """A block's values nested as in a study's `tables`: its bulk stresses, by body, move into each body's table."""
    found: dict[str, Any] = {name: own for name, own in values.items() if name != "bulk"}
    if "bulk" in values:
        bodies = {name: {"bulk": own} for name, own in values["bulk"].items()}
        home = next((name for name in ("bodies", "wires") if name in tables), None)
        found |= bodies if home is None else {home: bodies}
    return found


@dataclass(frozen=True)
class Stretch(Generic[AnyStudy]):
    """The cycles after `start`, up to and with `end`, the number of their block, and the study under which they run."""

    start: int
    end: int
    block: int
    study: AnyStudy


@dataclass(frozen=True)
class Schedule(Generic[AnyStudy]):
    """A test as a sequence of stretches. blocks: of its programme, empty without one; cycles: length of the test;
    alone: the study without its programme; under: gives that study with the values of a block.
    """

    blocks: tuple[CycleBlock, ...]
    cycles: int
    alone: AnyStudy
    under: Callable[[Mapping[str, Values]], AnyStudy]

    @cached_property
    def stretches(self) -> tuple[Stretch[AnyStudy], ...]:
        """All stretches in the order of the test; successive blocks with equal conditions form one."""
        if not self.blocks:
            return (Stretch(0, self.cycles, 1, self.alone),)
        studies = [self.under(block.values) for block in self.blocks]
        found: list[Stretch[AnyStudy]] = []
        for number, end in _ends(self.blocks, self.cycles):
            start, own = (found[-1].end if found else 0), studies[number]
            if found and found[-1].study == own:
                found[-1] = Stretch(found[-1].start, end, found[-1].block, own)
            else:
                found.append(Stretch(start, end, number + 1, own))
        return tuple(found)

    @property
    def studies(self) -> Sequence[AnyStudy]:
        """The study of each block that is run, in the order in which they come first, however often they come."""
        return [*{own.block: own.study for own in self.stretches}.values()]

    @cached_property
    def pulled(self) -> bool:
        every: Sequence[Any] = self.studies
        return any(own.drive.bulk for own in every)

    def at(self, done: float) -> Stretch[AnyStudy]:
        """The stretch to which cycle `done` belongs; the last one for a cycle beyond the test's end."""
        return next((own for own in self.stretches if done <= own.end), self.stretches[-1])


@dataclass(frozen=True)
class Stage:
    """The cycles after `start`, up to and with `end`, and the index of their block, the same for equal conditions."""

    start: float
    end: float
    block: int

    def __contains__(self, cycle: float) -> bool:
        """True if the cycle is one of the stage's."""
        return self.start < cycle <= self.end


@dataclass(frozen=True)
class BlockCourse:
    """Course of a test. done: its stages; ahead: those of one turn after its end, of blocks that it has reached; names:
    of the blocks, by index.
    """

    done: tuple[Stage, ...]
    ahead: tuple[Stage, ...]
    names: tuple[str, ...]

    @classmethod
    def of(cls, schedule: Schedule[Any], end: float) -> Self:
        """The stages of a test that ended at cycle `end`, and those of the turn that would follow."""
        turn = sum(block.cycles for block in schedule.blocks) or 1
        alike: list[Any] = []
        names, every = [], []
        for own in replace(schedule, cycles=ceil(end) + turn).stretches:
            if own.study not in alike:
                alike.append(own.study)
                names.append((schedule.blocks and schedule.blocks[own.block - 1].name) or f"block {own.block}")
            every.append(Stage(own.start, own.end, alike.index(own.study)))
        done = tuple(replace(one, end=min(one.end, end)) for one in every if one.start < end)
        ahead = [replace(one, start=max(one.start, end)) for one in every if one.end > end]
        return cls(done, tuple(one for one in ahead if one.block in {each.block for each in done}), tuple(names))

    @property
    def end(self) -> float:
        return self.done[-1].end

    @property
    def not_reached(self) -> tuple[str, ...]:
        """Names of the blocks of which the test ran no cycle."""
        return tuple(name for block, name in enumerate(self.names) if all(one.block != block for one in self.done))

    def among(self, cycles: Iterable[int], block: int) -> list[int]:
        """Cycles among `cycles` that the test ran under the conditions of the block with this index."""
        return [cycle for cycle in cycles if any(cycle in one for one in self.done if one.block == block)]

    def latest(self, block: int) -> Stage:
        """The last stage of the block with this index that is at least half as long as its longest one."""
        own = [one for one in self.done if one.block == block]
        longest = max(one.end - one.start for one in own)
        return next(one for one in reversed(own) if one.end - one.start >= 0.5 * longest)


def _ends(blocks: Sequence[CycleBlock], cycles: int) -> Iterator[tuple[int, int]]:
    """Index of each block in turn and the cycle at which it ends, up to the test's end."""
    done = 0
    for number in cycle(range(len(blocks))):
        done = min(done + blocks[number].cycles, cycles)
        yield number, done
        if done == cycles:
            return


Asked = TypeVar("Asked", bound=keys.Table)


def as_driven(
    conditions: Asked, blocks: tuple[CycleBlock, ...], effects: Sequence[ChangesASeam]
) -> tuple[Asked, tuple[CycleBlock, ...]]:
    """(conditions, blocks) after effects on the drive; returned as given unless an effect makes the drive hold its
    displacement amplitude, which then replaces all keys held_... in both.
    """
    own = [*(key for key in type(conditions).model_fields if key.startswith("held_")), _AMPLITUDE]
    holds = held_keys(conditions) or [key for block in blocks for key in block.conditions if key in own[:-1]]
    stated = Control(None if holds else getattr(conditions, _AMPLITUDE))
    control = applied(effects, Seam.DRIVE, stated, Age.new())
    if control == stated:
        return conditions, blocks
    changed = conditions.model_copy(update=dict.fromkeys(own[:-1]) | {_AMPLITUDE: control.displacement_amplitude_um})
    rest = [{key: value for key, value in block.conditions.items() if key not in own} for block in blocks]
    return changed, tuple(
        block.model_copy(update={"conditions": left}) for block, left in zip(blocks, rest, strict=True)
    )


def too_many(blocks: Sequence[CycleBlock], cycles: int) -> str | None:
    """The rest of a message "programme ..." if more than MOST_BLOCKS blocks come in `cycles` cycles; None otherwise."""
    count = cycles / sum(block.cycles for block in blocks) * len(blocks) if blocks else 1.0
    if count <= MOST_BLOCKS:
        return None
    return (
        f"comes to {counted(count)} blocks in {counted(cycles)} cycles, but a run goes through {counted(MOST_BLOCKS)}"
    )


def worked_cycles(stretches: Sequence[Stretch[Any]], most: float) -> int:
    """Number of cycles, at least 1, that wear as much as all stretches do if each wears by `most`, a wear per cycle in
    the unit of `worn_per_cycle`.
    """
    return max(ceil(worked_course(stretches, lambda own: own.study.worn_per_cycle / most if most else 0.0)[-1][1]), 1)


def worked_course(
    stretches: Sequence[Stretch[AnyStudy]], share: Callable[[Stretch[AnyStudy]], float]
) -> tuple[tuple[float, float], ...]:
    """Pairs (cycle of the test, equivalent cycles up to there), from (0, 0) on to the end of each stretch. share:
    equivalent cycles per cycle of a stretch.
    """
    course = [(0.0, 0.0)]
    for own in stretches:
        course.append((float(own.end), course[-1][1] + (own.end - own.start) * share(own)))
    return tuple(course)


def logged_ends(blocks: Sequence[CycleBlock], cycles: int) -> set[int]:
    """The cycles, up to `cycles`, at which the blocks of the first and of the last turn end; empty without blocks."""
    if not blocks:
        return set()
    ends = [end for _, end in _ends(blocks, cycles)]
    return {*ends[: len(blocks)], *ends[-len(blocks) :]}
